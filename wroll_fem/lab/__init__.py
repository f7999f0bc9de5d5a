"""Bench experiments on prestressed layers (thesis, appendix E): the double shear test, rate-and-state friction."""

from .rate_and_state import RateAndState, VelocitySteps, shear_history
from .shear_test import ShearTest, modulus_of, run_shear_test, stiffness_of

__all__ = [
    "RateAndState", "ShearTest", "VelocitySteps", "modulus_of", "run_shear_test", "shear_history", "stiffness_of",
]  # fmt: skip
