"""Plan of a shock: time after it and highest frequency of its time steps, and modes that these steps do not resolve."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from wroll_fem.analyses.forecasts.closed_forms import beam_frequency
from wroll_fem.case.excitation import SHOCK_KINDS
from wroll_fem.case.structural import OnRoll
from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.signals.motions import base_motion

if TYPE_CHECKING:
    from wroll_fem.case import HistoryCase
    from wroll_fem.dynamics.reduction.condensation import Condensation

    C = TypeVar("C", bound=HistoryCase)

CYCLES = 60
"""Cycles of the estimated resonance that `decay: auto` follows; in multiples of the shock without an estimate:"""
SHOCKS = 20

ABOVE_RESONANCE = 3.0
"""Least highest frequency of the time steps, relative to the estimated resonance: the second bending mode, at about six
times the first, then has some 20 steps per cycle."""

STEPS_OF_PULSE = 40
"""Least number of time steps of a pulse: the area of a half-sine is then 0.05 % off."""

LEAST_SHARE = 0.02
"""Estimated tip acceleration of a mode, relative to that of the largest, above which it has to be resolved."""

FARTHEST = 40.0
"""Highest natural frequency that is looked at, relative to the band of the shock and to the main mode."""

PERIOD_ERROR = 0.02
"""Relative lengthening of the period of a mode by the time step above which it is not resolved."""


def planned(case: C) -> C:
    """Case whose `excitation.decay` and `excitation.highest_frequency` are numbers; other analyses unchanged.

    The time step divides the length of a pulse, so that its ends, and the jump of a sawtooth, fall on steps.
    """
    excitation: Any = case.excitation
    if excitation.kind not in SHOCK_KINDS:
        return case
    motion: Any = base_motion(excitation.model_copy(update={"decay": "auto"}))
    length = motion.end
    decay, highest = excitation.decay, excitation.highest_frequency
    if decay == "auto":
        decay = CYCLES / beam_frequency(case, bonded=False) if isinstance(case, OnRoll) else SHOCKS * length
    if highest == "auto":
        highest = excitation.highest_frequency_hz
        if isinstance(case, OnRoll):
            stiff = case.coil.model in ("layers", "bonded", "solid")
            highest = max(highest, ABOVE_RESONANCE * beam_frequency(case, bonded=stiff))
    if hasattr(excitation, "duration"):
        steps = case.integrator.steps
        highest = max(ceil(length * highest * steps - 1e-9), STEPS_OF_PULSE) / (length * steps)
    changed = excitation.model_copy(update={"decay": float(decay), "highest_frequency": float(highest)})
    return case.model_copy(update={"excitation": changed})


def unresolved_modes(case: HistoryCase, condensation: Condensation, dt: float) -> str:
    """Warning if a shock excites modes that the time steps do not resolve; empty otherwise.

    The tip acceleration of a mode is estimated by its participation and by the residual shock response spectrum of the
    base, which is what rings after the shock.
    """
    from wroll_fem.signals.shock.spectrum import GOOD_SAMPLES, shock_spectrum

    if case.excitation.kind not in SHOCK_KINDS:
        return ""
    share = np.abs(condensation.base * condensation.tip)
    natural = np.sqrt(np.maximum(condensation.eigenvalues, 0.0)) / (2.0 * np.pi)
    motion: Any = base_motion(case.excitation)
    highest = FARTHEST * max(motion.highest_frequency_hz, condensation.main_mode[0])
    counted = (share > 1e-3 * share.max(initial=0.0)) & (natural > 0.0) & (natural < highest)
    if not counted.any():
        return ""
    share, natural = share[counted], natural[counted]
    step = min(dt, 1.0 / (GOOD_SAMPLES * float(natural.max())))
    base = motion.acceleration(step * np.arange(int(np.ceil(motion.end / step)) + 2))
    ringing = share * shock_spectrum(base, step, natural, q=np.inf, interval="residual")
    scheme = Scheme.named(case.integrator.scheme, case.integrator.alpha)
    longer = np.array([_lengthening(scheme, 2.0 * np.pi * f * dt) for f in natural])
    missed = (ringing > LEAST_SHARE * ringing.max()) & (longer > PERIOD_ERROR)
    if not missed.any():
        return ""
    worst = int(np.argmax(np.where(missed, ringing, 0.0)))
    wanted = float(natural[missed].max()) * GOOD_SAMPLES / case.integrator.steps
    return (
        f"the shock excites {int(missed.sum())} mode(s) that the time step of {dt:.3g} s does not resolve, the largest "
        f"at {natural[worst]:.0f} Hz with an estimated {100 * ringing[worst] / ringing.max():.2g} % of the tip "
        f"acceleration of the main mode: it has {1.0 / (natural[worst] * dt):.3g} steps per cycle, which lengthen its "
        f"period by {100 * min(longer[worst], 9.99):.2g} %; set excitation.highest_frequency to {wanted:.0f} or more"
    )


def _lengthening(scheme: Scheme, angle: float) -> float:
    return np.inf if angle > 2.0 else numerical_damping(scheme, angle)[1]
