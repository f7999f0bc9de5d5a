"""Damping from a measured or computed transmissibility: one file per method, one result object (appendix D).

`choose` picks the method from the shape of the curve; each method can also be called by itself.
"""

from wroll_fem.signals.estimators.choice import CurveShape, choose, curve_shape
from wroll_fem.signals.estimators.estimate import DampingEstimate
from wroll_fem.signals.estimators.gaussian import gaussian_fit
from wroll_fem.signals.estimators.half_power import half_power_estimate
from wroll_fem.signals.estimators.rational_fraction import rational_fraction
from wroll_fem.signals.estimators.reading import ESTIMATORS, Reading, read_curve
from wroll_fem.signals.estimators.single_dof import (
    half_power_reading,
    leaning_transmissibility,
    lower_bound,
    peak_transmissibility,
    single_dof_transmissibility,
)

__all__ = [
    "ESTIMATORS",
    "CurveShape",
    "DampingEstimate",
    "Reading",
    "choose",
    "curve_shape",
    "gaussian_fit",
    "half_power_estimate",
    "half_power_reading",
    "leaning_transmissibility",
    "lower_bound",
    "peak_transmissibility",
    "rational_fraction",
    "read_curve",
    "single_dof_transmissibility",
]
