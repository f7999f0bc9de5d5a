"""Highest frequency with energy of a base motion, against the modes of mesh and reduced model, and the time step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.analyses.forecasts.closed_forms import bending_wave, root_element_height
from wroll_fem.analyses.shared.time_step import time_step
from wroll_fem.case.excitation import SHOCK_KINDS
from wroll_fem.case.structural import OnRoll
from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.signals.motions import base_motion

if TYPE_CHECKING:
    from wroll_fem.case import HistoryCase
    from wroll_fem.dynamics.time_stepping.stepper import Stepper

ELEMENTS_PER_WAVE = 2.0
"""Quadratic elements per wavelength with which a bending wave counts as resolved: the modes of the lab roll's mandrel
below are up to 4 % too high, those above up to 30 % (`tests/analyses/test_excited_band.py`)."""

LEAST_SHARE = 0.02
"""Tip participation of a mode, relative to that of the main mode, above which it has to be in the reduced basis."""

LARGEST_TURN = 2.0
"""Angle (rad) of a frequency in a time step, above which the steps do not follow it."""

WITHIN = 0.5
"""Part of a mode (of its modal mass) that a basis must contain."""


def excited_to(case: HistoryCase) -> float:
    """Highest frequency with energy of the base motion, Hz.

    Of a sine it is the highest one; 99.99 % of the mean square of a random motion and 99 % of the energy of a shock or
    a record lie below it.
    """
    if case.excitation.kind not in SHOCK_KINDS:
        return case.excitation.highest_frequency_hz
    return float(base_motion(case.excitation).highest_frequency_hz)  # type: ignore[attr-defined]


def period_error(case: HistoryCase, frequency: float) -> float:
    """Relative lengthening, by the time step, of a period of a frequency in Hz; infinite without oscillation."""
    turn = 2.0 * np.pi * frequency * time_step(case)
    if turn > LARGEST_TURN:
        return np.inf
    return numerical_damping(Scheme.named(case.integrator.scheme, case.integrator.alpha), turn)[1]


def mesh_band(case: OnRoll) -> float:
    """Highest frequency, Hz, of bending waves that the generated mesh of a roll resolves; infinite for a mesh file."""
    if case.mesh.file is not None:
        return np.inf
    tallest = root_element_height(case) * case.mesh.grading
    return bending_wave(case, ELEMENTS_PER_WAVE * tallest)


def band_remark(case: HistoryCase) -> str:
    """Warning if the base motion has energy above the modes that the mesh of a roll resolves; empty otherwise."""
    if not isinstance(case, OnRoll):
        return ""
    highest, limit = excited_to(case), mesh_band(case)
    if highest <= limit:
        return ""
    return (
        f"the base motion has energy up to {highest:.4g} Hz, but the mesh resolves bending waves up to {limit:.4g} Hz: "
        f"the response above is that of the mesh; {step_words(case, highest)}; raise mesh.axial to "
        f"{int(np.ceil(case.mesh.axial * highest / limit))}, or end the motion there"
    )


def basis_remark(case: HistoryCase, stepper: Stepper) -> str:
    """Warning if modes that the base motion excites lie outside the basis of a reduced model; empty otherwise."""
    if not isinstance(stepper, ReducedStepper) or stepper.complete:
        return ""
    modes, highest = stepper.condensation, excited_to(case)
    natural = np.sqrt(np.maximum(modes.eigenvalues, 0.0)) / (2.0 * np.pi)
    share = np.abs(modes.base * modes.tip)
    inside = np.sum(stepper.vectors**2, axis=1)
    missed = (natural <= highest) & (share > LEAST_SHARE * share.max(initial=0.0)) & (inside < WITHIN)
    if not missed.any():
        return ""
    return (
        f"the base motion has energy up to {highest:.4g} Hz and excites {int(missed.sum())} mode(s) outside the "
        f"reduced basis, the lowest at {natural[missed].min():.4g} Hz, which then respond without their inertia; "
        f"{step_words(case, float(natural[missed].min()))}; use solver.method: condensed, or lower "
        "solver.reduction_tolerance"
    )


def step_words(case: HistoryCase, frequency: float) -> str:
    """What the time step does to a frequency, Hz."""
    scheme = Scheme.named(case.integrator.scheme, case.integrator.alpha)
    turn = 2.0 * np.pi * frequency * time_step(case)
    if scheme.exact_modes:
        return "the time step is exact for linear modes there"
    if turn > LARGEST_TURN:
        return f"the time step does not follow {frequency:.4g} Hz"
    damping, longer = numerical_damping(scheme, turn)
    return (
        f"the time step lengthens periods there by {100 * longer:.2g} % and adds a damping ratio of "
        f"{100 * damping:.2g} %"
    )
