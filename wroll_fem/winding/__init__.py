"""Stress that winding leaves in a roll; knows nothing of the finite-element library."""

from wroll_fem.winding.core import tube_stiffness
from wroll_fem.winding.radial_modulus import RadialModulus
from wroll_fem.winding.stress import WoundRoll, WrapGrid, wound_roll

__all__ = ["RadialModulus", "WoundRoll", "WrapGrid", "tube_stiffness", "wound_roll"]
