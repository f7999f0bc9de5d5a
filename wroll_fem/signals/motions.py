"""Registry of the base motions: kind of excitation -> base motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from wroll_fem.errors import InputError
from wroll_fem.signals.base_motion import BaseMotion, Chirp, Dwell
from wroll_fem.signals.random_motion import RandomMotion


def _ramp(excitation: Any) -> dict[str, float]:
    ramp = getattr(excitation, "ramp_cycles", None)
    return {} if ramp is None else {"ramp_cycles": float(ramp)}


def _chirp(e: Any) -> Chirp:
    return Chirp(float(e.amplitude), float(e.f_start), float(e.f_end), float(e.rate_oct_per_min), **_ramp(e))


def _dwell(e: Any) -> Dwell:
    return Dwell(float(e.amplitude), float(e.frequency), float(e.cycles), **_ramp(e))


def _random(e: Any) -> RandomMotion:
    return RandomMotion(e.psd.table, float(e.duration), int(e.seed), float(e.factor), e.crest_limit)


MOTIONS: dict[str, Callable[[Any], BaseMotion]] = {
    "chirp": _chirp,
    "dwell": _dwell,
    "random": _random,
}
"""Kind -> function of an object with the attributes of that kind that returns the base motion."""


def base_motion(excitation: Any) -> BaseMotion:
    """Base motion described by a case section `excitation`, or by any object with the same attributes.

    Parameters
    ----------
    excitation
        Object with `kind`, a key of `MOTIONS`, and the attributes of that kind. If `ramp_cycles` of a chirp or a dwell
        is None or missing, the default of the kind is used (0 for a chirp, 5 for a dwell).

    Raises
    ------
    InputError
        If the kind is unknown, or a value is out of range.
    """
    if excitation.kind not in MOTIONS:
        raise InputError(
            f"unknown kind {excitation.kind!r} of base motion",
            key="excitation.kind",
            remedy=f"use one of: {', '.join(MOTIONS)}",
        )
    return MOTIONS[excitation.kind](excitation)
