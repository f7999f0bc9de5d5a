"""Two masses coupled by friction on a moving base: the reduced-order model of a wound roll (thesis, chapter 5)."""

from wroll_fem.two_dof.fit import Fit, Measured, fit_curves
from wroll_fem.two_dof.maps import DesignSpace, Response, design_space, peak_half_power, response_map
from wroll_fem.two_dof.model import ARRANGEMENTS, PreloadedTwoMasses, TwoMasses, regularised_sign
from wroll_fem.two_dof.periodic import CycleEnergy, PeriodicMotion, PeriodicSolver, two_mass_system
from wroll_fem.two_dof.time import SteadyState, integrate_to_steady_state

# names until version 0.1
Pressed, SettledMotion, fit_family = PreloadedTwoMasses, SteadyState, fit_curves
peak_readings, settle, smoothed_sign = peak_half_power, integrate_to_steady_state, regularised_sign

__all__ = [
    "ARRANGEMENTS", "CycleEnergy", "DesignSpace", "Fit", "Measured", "PeriodicMotion", "PeriodicSolver",
    "PreloadedTwoMasses", "Response", "SteadyState", "TwoMasses", "design_space", "fit_curves",
    "integrate_to_steady_state", "peak_half_power", "regularised_sign", "response_map", "two_mass_system",
]  # fmt: skip
