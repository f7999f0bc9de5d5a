"""Stress in a wound roll due to the winding tension (thesis, section 2.2; docs/winding.md)."""

from wroll_fem.winding.core import tube_stiffness
from wroll_fem.winding.radial_modulus import RadialModulus
from wroll_fem.winding.stress import WoundRoll, WrapGrid, wound_roll

__all__ = ["RadialModulus", "WoundRoll", "WrapGrid", "tube_stiffness", "wound_roll"]
