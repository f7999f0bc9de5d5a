"""Bench experiments on preloaded layers (thesis, appendix E): double shear test and rate-and-state friction."""

from wroll_fem.tribology.rate_and_state import RateAndState, VelocitySteps, shear_history
from wroll_fem.tribology.shear_test import ShearTest, modulus_of, run_shear_test, stiffness_of

__all__ = [
    "RateAndState", "ShearTest", "VelocitySteps", "modulus_of", "run_shear_test", "shear_history", "stiffness_of",
]  # fmt: skip
