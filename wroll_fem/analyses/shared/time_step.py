"""Time step of a history: choice of the steps per cycle, and their error after the run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.analyses.shared.preflight import beam_frequency
from wroll_fem.case.integrator import DEFAULT_STEPS
from wroll_fem.case.structural import OnRoll
from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.dynamics.time_stepping.step_error import (
    Oscillator,
    curve_error,
    fitted_oscillator,
    history_error,
    steps_for,
)
from wroll_fem.signals.base_motion import base_motion
from wroll_fem.signals.damping import HalfPower, likely_damping

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.case import DwellCase, SweepCase
    from wroll_fem.dynamics.reduction.condensation import Condensation

WANTED = 0.05
"""Error of a history, over its largest displacement, up to which its steps are fine enough."""

CHOICES = (DEFAULT_STEPS, 60, 80, 120, 160)
"""Steps per cycle from which `auto` chooses."""

ASSUMED_DAMPING = 0.01
"""Damping ratio of the resonance that `auto` assumes, before the run; the run warns where it turns out sharper."""

MARGIN = 0.05
"""Relative error of the resonances by `preflight.beam_frequency`."""

ORDERS, NEAR_MULTIPLE, LEAST_SHARE = (3, 5, 7), 0.06, 0.02
"""Harmonics of the friction force; distance of a mode from that multiple of the excitation, relative; its participation
at the tip over that of the main mode."""

PERIOD_ERROR = 0.01
"""Period error of such a mode above which a dwell warns."""

USEFUL_FIT = 0.3
"""Misfit of the fitted oscillator above which its error tells nothing about the history."""


def steps_per_cycle(case: SweepCase | DwellCase) -> int:
    """Steps per cycle of the highest excitation frequency: those of the case, or the choice of `auto`.

    For the dwell of a roll it is the smallest of `CHOICES` whose error is at most `WANTED` wherever between the
    frictionless and the bonded roll the resonance may lie; for other histories `DEFAULT_STEPS`.
    """
    excitation = case.excitation
    if case.integrator.steps_per_cycle != "auto" or not isinstance(case, OnRoll) or excitation.kind != "dwell":
        return case.integrator.steps
    stiff = case.coil.model in ("layers", "bonded", "solid")
    low = (1.0 - MARGIN) * beam_frequency(case, bonded=False)
    high = (1.0 + MARGIN) * beam_frequency(case, bonded=stiff)
    resonances = [*np.linspace(low, high, 5), float(np.clip(excitation.frequency, low, high))]
    motion, scheme = base_motion(excitation), Scheme.named(case.integrator.scheme, case.integrator.alpha)
    for steps in CHOICES[:-1]:
        dt = 1.0 / (excitation.frequency * steps)
        if all(history_error(scheme, dt, motion, Oscillator(f, ASSUMED_DAMPING)) <= WANTED for f in resonances):
            return steps
    return CHOICES[-1]


def time_step(case: SweepCase | DwellCase) -> float:
    """Time step of a history, s."""
    return 1.0 / (case.excitation.highest_frequency_hz * steps_per_cycle(case))


def dwell_step_error(case: DwellCase, history: xr.Dataset) -> tuple[float, str]:
    """Error of a dwell's history due to its time step, relative to the largest displacement, and a warning or "".

    The error is nan where no oscillator describes the history.
    """
    scheme, dt = Scheme.named(case.integrator.scheme, case.integrator.alpha), time_step(case)
    motion, tip = base_motion(case.excitation), history["tip_displacement"].values
    if len(tip) < 20 or not np.abs(tip).max() > 0.0:
        return np.nan, ""
    oscillator, misfit = fitted_oscillator(scheme, dt, motion, tip)
    if misfit > USEFUL_FIT:
        return np.nan, ""
    error = history_error(scheme, dt, motion, oscillator)
    return error, _warning("the history", error, case, oscillator)


def sweep_step_error(case: SweepCase, read: HalfPower) -> tuple[float, str]:
    """Error of a sweep's |T| due to its time step, relative to the peak (nan without one), and a warning or ""."""
    if not read.resonant:
        return np.nan, ""
    scheme, dt = Scheme.named(case.integrator.scheme, case.integrator.alpha), time_step(case)
    oscillator = Oscillator(read.f_n, likely_damping(read)[0])
    error = curve_error(scheme, dt, oscillator)
    return error, _warning("|T| on the flanks of the peak", error, case, oscillator)


def detuned_harmonic(case: SweepCase | DwellCase, condensation: Condensation) -> str:
    """Warning if the step detunes a mode that a harmonic of the friction force can drive in a dwell; else empty.

    The friction force is odd in the motion, so its odd harmonics dominate. `dwell_step_error` does not see them.
    """
    excitation = case.excitation
    if excitation.kind != "dwell":
        return ""
    share = np.abs(condensation.base * condensation.tip)
    natural = np.sqrt(np.maximum(condensation.eigenvalues, 0.0)) / (2.0 * np.pi)
    scheme, steps = Scheme.named(case.integrator.scheme, case.integrator.alpha), steps_per_cycle(case)
    for order in ORDERS:
        near = np.abs(natural / (order * excitation.frequency) - 1.0) < NEAR_MULTIPLE
        near &= share > LEAST_SHARE * share.max(initial=0.0)
        if not near.any() or 2 * order >= steps:
            continue
        longer = numerical_damping(scheme, 2.0 * np.pi * order / steps)[1]
        if longer > PERIOD_ERROR:
            return (
                f"a mode at {natural[near][0]:.0f} Hz lies near {order} times the excitation: friction may drive it, "
                f"but {steps} steps per cycle lengthen its period by {100 * longer:.2g} %, which time_step_error misses"
                f"; set integrator.steps_per_cycle to {steps_for(longer, steps, PERIOD_ERROR)}"
            )
    return ""


def _warning(what: str, error: float, case: SweepCase | DwellCase, oscillator: Oscillator) -> str:
    if error <= WANTED:
        return ""
    scheme, steps = Scheme.named(case.integrator.scheme, case.integrator.alpha), steps_per_cycle(case)
    turn = 2.0 * np.pi * oscillator.frequency_hz * time_step(case)
    damping, longer = numerical_damping(scheme, turn)
    return (
        f"the time step changes {what} by about {100 * error:.2g} %: at {steps} steps per cycle the scheme lengthens "
        f"the period of the resonance at {oscillator.frequency_hz:.1f} Hz by {100 * longer:.2g} % and adds a damping "
        f"ratio of {100 * damping:.2g} %; set integrator.steps_per_cycle to {steps_for(error, steps, WANTED)}"
    )
