"""Stress that winding leaves in a roll; knows nothing of the finite-element library."""

from .core import tube_stiffness
from .radial_modulus import RadialModulus
from .stress import WoundRoll, WrapGrid, wound_roll

__all__ = ["RadialModulus", "WoundRoll", "WrapGrid", "tube_stiffness", "wound_roll"]
