"""Parameters from noisy records: least squares, correlated noise, confidence intervals."""

from wroll_fem.numerics.inference.estimate import Estimate, combined_freedom, mean_estimate
from wroll_fem.numerics.inference.fit import Fit, fit, linear_fit
from wroll_fem.numerics.inference.noise import NoiseModel, noise_model, stays_correlated

__all__ = [
    "Estimate",
    "Fit",
    "NoiseModel",
    "combined_freedom",
    "fit",
    "linear_fit",
    "mean_estimate",
    "noise_model",
    "stays_correlated",
]
