"""Time step of a time history: number of steps per cycle, and error estimate after the run."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from wroll_fem.analyses.forecasts.closed_forms import beam_frequency
from wroll_fem.case.checks import FEWEST_STEPS_PER_CYCLE
from wroll_fem.case.integrator import DEFAULT_STEPS
from wroll_fem.case.structural import OnRoll
from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.dynamics.time_stepping.step_error import (
    Oscillator,
    curve_error,
    fitted_oscillator,
    history_error,
    steps_for,
    without_ripple,
)
from wroll_fem.numerics.time_grid import LEAST_STEPS, TimeGrid
from wroll_fem.signals.base_motion import sweep_rate_limit
from wroll_fem.signals.damping import HalfPower, likely_damping
from wroll_fem.signals.motions import base_motion, sweep_motion

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.case import DwellCase, HistoryCase, RandomCase, SweepCase
    from wroll_fem.case.damping import Damping
    from wroll_fem.dynamics.reduction.condensation import Condensation
    from wroll_fem.typing import FloatArray

WANTED = 0.05
"""Largest acceptable error of a time history due to its time step, relative to its largest displacement."""

WANTED_CURVE = 0.1
"""Largest acceptable error of |T| of a sweep due to its time step, relative to the peak. On a flank that friction makes
steep, a shift of the frequency by 0.2 % costs more than a tenth; peak and f_n change by much less."""

CHOICES = (DEFAULT_STEPS, 60, 80, 120, 160)
"""Numbers of steps per cycle from which `auto` chooses."""

ASSUMED_DAMPING = 0.01
"""Damping ratio of the resonance that `auto` assumes for friction, and for a case without section `damping`. The error
is estimated again after the run, with the damping of the computed response."""

MARGIN = 0.05
"""Relative error of the resonance frequencies estimated by `closed_forms.beam_frequency`."""

ORDERS, NEAR_MULTIPLE, LEAST_SHARE = (3, 5, 7), 0.06, 0.02
"""Criteria of `detuned_harmonic`: orders of the harmonics of the friction force; largest relative difference between
the natural frequency of a mode and the frequency of the harmonic; least tip participation of the mode, relative to the
main mode."""

PERIOD_ERROR = 0.01
"""Relative error of the period of a mode, due to the time step, above which `detuned_harmonic` warns."""

USEFUL_FIT = 0.3
"""Largest root-mean-square misfit of the oscillator fitted to a history, relative to the displacement. With a larger
misfit, no time step error is estimated."""


def steps_per_cycle(case: HistoryCase) -> int:
    """Number of steps per cycle of the highest excitation frequency, set by the case or chosen by `auto`.

    For the dwell of a roll, `auto` takes the smallest of `CHOICES` whose error is at most `WANTED` for all resonance
    frequencies between the frictionless and the bonded roll. For random motion of a roll it takes the smallest number
    from `FEWEST_STEPS_PER_CYCLE` on with which the resonance has `DEFAULT_STEPS`. Otherwise it takes `DEFAULT_STEPS`.
    """
    if case.integrator.steps_per_cycle != "auto" or not isinstance(case, OnRoll):
        return case.integrator.steps
    choose = _AUTO.get(case.excitation.kind)
    return case.integrator.steps if choose is None else choose(case)


def _resonances(case: OnRoll) -> tuple[float, float]:
    """Lowest and highest resonance frequency that the first bending mode of a roll can have, Hz."""
    stiff = case.coil.model in ("layers", "bonded", "solid")
    return (1.0 - MARGIN) * beam_frequency(case, bonded=False), (1.0 + MARGIN) * beam_frequency(case, bonded=stiff)


def _damping_before(case: Any, frequency: float) -> float:
    """Damping ratio of a resonance (Hz) before the run: of the material, and at least `ASSUMED_DAMPING` with slip."""
    known = 0.0 if case.damping is None else _material_damping(case.damping, frequency)
    slips = case.coil.has_interfaces or case.coil.slips
    return known if known > 0.0 and not slips else max(known, ASSUMED_DAMPING)


def _material_damping(damping: Damping, frequency: float) -> float:
    """Damping ratio of the lowest mode, at ``frequency`` (Hz); with loss factors, that of the less damped body."""
    if damping.rayleigh is not None:
        turn = 2.0 * np.pi * frequency
        return 0.5 * (damping.rayleigh.alpha / turn + damping.rayleigh.beta * turn)
    if damping.loss_factor is not None:
        return 0.5 * min(damping.loss_factor.mandrel, damping.loss_factor.coil)
    if damping.table:
        frequencies, ratios = zip(*damping.table, strict=True)
        return float(np.interp(frequency, frequencies, ratios))
    return damping.ratios[0]


def _of_random(case: Any) -> int:
    share = _resonances(case)[1] / case.excitation.highest_frequency_hz
    return int(np.clip(np.ceil(DEFAULT_STEPS * share), FEWEST_STEPS_PER_CYCLE, DEFAULT_STEPS))


def _of_dwell(case: Any) -> int:
    low, high = _resonances(case)
    frequency = case.excitation.frequency
    resonances = [*np.linspace(low, high, 5), float(np.clip(frequency, low, high))]
    motion, scheme = base_motion(case.excitation), Scheme.named(case.integrator.scheme, case.integrator.alpha)
    oscillators = [Oscillator(f, _damping_before(case, f)) for f in resonances]
    for steps in CHOICES[:-1]:
        dt = 1.0 / (frequency * steps)
        if all(history_error(scheme, dt, motion, oscillator) <= WANTED for oscillator in oscillators):
            return steps
    return CHOICES[-1]


_AUTO: dict[str, Callable[[Any], int]] = {"dwell": _of_dwell, "random": _of_random}
"""Kind of base motion -> number of steps per cycle that `auto` chooses for a roll."""


def time_step(case: HistoryCase) -> float:
    """Time step of a time history, s."""
    return 1.0 / (case.excitation.highest_frequency_hz * steps_per_cycle(case))


def time_grid(case: HistoryCase, main_mode: float | None) -> TimeGrid | None:
    """Steps of a sweep that follow its frequency (`integrator.follow_frequency`); None for equal steps.

    ``main_mode`` is the frequency of the main mode with stuck interfaces, Hz. If it is None, the estimate for a roll is
    used.
    """
    if not case.integrator.follow_frequency:
        return None
    motion, dt = sweep_motion(case.excitation), time_step(case)
    low, high = motion.band
    if main_mode is None:
        main_mode = beam_frequency(case, bonded=True) if isinstance(case, OnRoll) else high
    longest = min(high / low, 1.0 / (LEAST_STEPS * main_mode * dt))
    levels = np.arange(int(np.log2(max(longest, 1.0)) + 1e-9), -1, -1)
    changes = motion.time_of_frequency(high / 2.0 ** levels[:-1])
    if motion.downward:
        levels, changes = levels[::-1], changes[::-1]
    duration = base_motion(case.excitation).duration
    if duration > 1.5 * motion.duration:  # there and back
        levels = np.append(levels, levels[-2::-1])
        changes = np.append(changes, duration - changes[::-1])
    return TimeGrid.of_levels(duration, dt, [int(level) for level in levels], changes)


def step_at(history: xr.Dataset, frequency: float) -> float:
    """Time step of a sweep where it passes ``frequency`` (Hz), s."""
    place = int(np.abs(history["instantaneous_frequency"].values[:-1] - frequency).argmin())
    return float(np.diff(history["time"].values[place : place + 2])[0])


def dwell_step_error(case: DwellCase, history: xr.Dataset) -> tuple[float, str]:
    """Error of a dwell due to its time step, relative to the largest displacement, and a warning ("" if it is small).

    The error is nan, with a warning, if no oscillator describes the history.
    """
    scheme, dt = Scheme.named(case.integrator.scheme, case.integrator.alpha), time_step(case)
    motion, tip = base_motion(case.excitation), history["tip_displacement"].values
    if len(tip) < 20 or not np.abs(tip).max() > 0.0:
        return _unknown(case)
    oscillator, misfit = fitted_oscillator(scheme, dt, motion, tip)  # type: ignore[arg-type]
    if misfit > USEFUL_FIT:
        error, text = _unknown(case)
        return error, text or (
            "the error by the time step is unknown: the oscillator that fits the history best misses "
            f"{100 * misfit:.0f} % of it (rms); compare with integrator.steps_per_cycle: {2 * steps_per_cycle(case)}"
        )
    error = history_error(scheme, dt, motion, oscillator)
    return error, _warning("the history", error, WANTED, case, oscillator, dt)


def sweep_step_error(
    case: SweepCase, curve: tuple[FloatArray, FloatArray], read: HalfPower, participation: float | None = None,
    dt: float | None = None, stuck: float | None = None,
) -> tuple[float, str]:  # fmt: skip
    """Relative error of |T| of a sweep due to its time step (nan without a peak), and a warning ("" if it is small).

    ``curve`` is frequency (n,), Hz, and |T| (n,); ``participation`` that of the resonant mode, if it is known
    (`likely_damping`); ``dt`` the time step at the resonance, s, if it is not that of the case; ``stuck`` the resonance
    with stuck interfaces, Hz, whose softening by slip the trigonometric scheme does not follow exactly.
    """
    if not read.resonant:
        return _unknown(case)
    scheme, dt = Scheme.named(case.integrator.scheme, case.integrator.alpha), dt or time_step(case)
    oscillator = Oscillator(read.f_n, likely_damping(read, participation)[0])
    frequency, height = curve
    if sweep_motion(case.excitation).rate_at(read.f_n) <= sweep_rate_limit(read.f_n, oscillator.zeta):
        height = without_ripple(height)
    error = curve_error(scheme, dt, frequency, height, oscillator.zeta, stuck)
    return error, _warning("|T| on the flanks of the peak", error, WANTED_CURVE, case, oscillator, dt)


def random_step_error(
    case: RandomCase, curve: tuple[FloatArray, FloatArray], f_n: float, zeta: float
) -> tuple[float, str]:
    """Relative error of |H1| of a random motion due to its time step (nan without a damping ratio), and a warning.

    ``curve`` is frequency (n,), Hz, and |H1| (n,).
    """
    if not (np.isfinite(f_n) and np.isfinite(zeta) and zeta > 0.0):
        return _unknown(case)
    scheme = Scheme.named(case.integrator.scheme, case.integrator.alpha)
    dt = time_step(case)
    error = curve_error(scheme, dt, *curve, zeta)
    return error, _warning("|H1| on the flanks of the peak", error, WANTED_CURVE, case, Oscillator(f_n, zeta), dt)


def detuned_harmonic(case: HistoryCase, condensation: Condensation) -> str:
    """Warning if the time step of a dwell detunes a mode that harmonics of the friction force excite; empty otherwise.

    The friction force is odd in the motion, so its odd harmonics dominate. `dwell_step_error` does not include them.
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
                f"a mode at {natural[near][0]:.0f} Hz lies near {order} times the excitation frequency: "
                f"friction may drive it, but {steps} steps per cycle lengthen its period by {100 * longer:.2g} %, and "
                f"time_step_error does not include this; "
                f"set integrator.steps_per_cycle to {steps_for(longer, steps, PERIOD_ERROR)}"
            )
    return ""


def _unknown(case: HistoryCase) -> tuple[float, str]:
    """An error that cannot be estimated, with a warning where the steps are coarse (`solver.allow_coarse`)."""
    steps = steps_per_cycle(case)
    if steps >= FEWEST_STEPS_PER_CYCLE:
        return np.nan, ""
    return np.nan, (
        f"the error by the time step is unknown, and {steps} steps per cycle are too few to rely on: nothing fits the "
        f"response well enough to estimate it; set integrator.steps_per_cycle to {FEWEST_STEPS_PER_CYCLE} or more"
    )


def _warning(what: str, error: float, wanted: float, case: HistoryCase, oscillator: Oscillator, dt: float) -> str:
    if error <= wanted:
        return ""
    scheme, steps = Scheme.named(case.integrator.scheme, case.integrator.alpha), steps_per_cycle(case)
    turn = 2.0 * np.pi * oscillator.frequency_hz * dt
    if scheme.exact_modes:
        return (
            f"the time step changes {what} by about {100 * error:.2g} %: {steps} steps per cycle do not resolve the "
            f"slip; set integrator.steps_per_cycle to {steps_for(error, steps, wanted)}"
        )
    damping, longer = numerical_damping(scheme, turn)
    return (
        f"the time step changes {what} by about {100 * error:.2g} %: at {steps} steps per cycle the scheme lengthens "
        f"the period of the resonance at {oscillator.frequency_hz:.1f} Hz by {100 * longer:.2g} % and adds a damping "
        f"ratio of {100 * damping:.2g} %; set integrator.steps_per_cycle to {steps_for(error, steps, wanted)}"
    )
