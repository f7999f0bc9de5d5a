"""Damping estimators for measured or computed transmissibility curves (thesis, appendix D), one file per method.

All methods return a `DampingEstimate`. `choose` selects the method from the shape of the curve.
"""

from wroll_fem.signals.estimators.choice import CurveShape, choose, curve_shape
from wroll_fem.signals.estimators.curve_damping import (
    ESTIMATORS,
    CurveDamping,
    estimate_damping,
    without_half_power_points,
)
from wroll_fem.signals.estimators.estimate import DampingEstimate
from wroll_fem.signals.estimators.gaussian import gaussian_fit
from wroll_fem.signals.estimators.half_power import half_power_estimate
from wroll_fem.signals.estimators.rational_fraction import rational_fraction
from wroll_fem.signals.estimators.single_dof import (
    cubic_spring_transmissibility,
    lower_bound,
    peak_transmissibility,
    single_dof_half_power,
    single_dof_transmissibility,
)

# names until version 0.1
Reading, read_curve = CurveDamping, estimate_damping
half_power_reading, leaning_transmissibility = single_dof_half_power, cubic_spring_transmissibility

__all__ = [
    "ESTIMATORS",
    "CurveDamping",
    "CurveShape",
    "DampingEstimate",
    "choose",
    "cubic_spring_transmissibility",
    "curve_shape",
    "estimate_damping",
    "gaussian_fit",
    "half_power_estimate",
    "lower_bound",
    "peak_transmissibility",
    "rational_fraction",
    "single_dof_half_power",
    "single_dof_transmissibility",
    "without_half_power_points",
]
