"""Two masses that rub on each other on a shaken base: the reduced-order model of a wound roll (thesis, chapter 5)."""

from wroll_fem.two_dof.fit import Fit, Measured, fit_family
from wroll_fem.two_dof.maps import DesignSpace, Response, design_space, peak_readings, response_map
from wroll_fem.two_dof.model import ARRANGEMENTS, Pressed, TwoMasses, smoothed_sign
from wroll_fem.two_dof.periodic import CycleEnergy, PeriodicMotion, PeriodicSolver, two_mass_system
from wroll_fem.two_dof.time import SettledMotion, settle

__all__ = [
    "ARRANGEMENTS", "CycleEnergy", "DesignSpace", "Fit", "Measured", "PeriodicMotion", "PeriodicSolver", "Pressed",
    "Response", "SettledMotion", "TwoMasses", "design_space", "fit_family", "peak_readings", "response_map", "settle",
    "smoothed_sign", "two_mass_system",
]  # fmt: skip
