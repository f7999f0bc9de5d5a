"""Registry of the base motions: kind of excitation -> base motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wroll_fem.errors import InputError
from wroll_fem.signals.base_motion import BaseMotion, Dwell
from wroll_fem.signals.random.random_motion import RandomMotion
from wroll_fem.signals.shock.pulses import HalfSine, Sawtooth, Trapezoid
from wroll_fem.signals.sweeps import Chirp, LinearSweep, Profile, Sweep
from wroll_fem.signals.there_and_back import ThereAndBack

if TYPE_CHECKING:
    from wroll_fem.signals.records.record import Record
    from wroll_fem.signals.shock.table import SpectrumTable
    from wroll_fem.signals.shock.wavelets import Wavelets


def _ramp(excitation: Any) -> dict[str, float]:
    ramp = getattr(excitation, "ramp_cycles", None)
    return {} if ramp is None else {"ramp_cycles": float(ramp)}


def _chirp(e: Any) -> Sweep:
    rows = getattr(e, "profile", None)
    profile = Profile() if rows is None else Profile(tuple(rows.frequency), tuple(rows.factor))
    ends = float(e.amplitude), float(e.f_start), float(e.f_end)
    linear = getattr(e, "rate_hz_per_s", None)
    if linear is not None:
        return LinearSweep(*ends, float(linear), **_ramp(e), profile=profile)
    return Chirp(*ends, float(e.rate_oct_per_min), **_ramp(e), profile=profile)


def _passes(e: Any) -> Sweep | ThereAndBack:
    return ThereAndBack(_chirp(e)) if getattr(e, "sweep_direction", None) == "up_down" else _chirp(e)


def _dwell(e: Any) -> Dwell:
    return Dwell(float(e.amplitude), float(e.frequency), float(e.cycles), **_ramp(e))


def _random(e: Any) -> RandomMotion:
    return RandomMotion(e.psd.table, float(e.duration), int(e.seed), float(e.factor), e.crest_limit)


def _after(e: Any) -> float:
    """Time after a shock, s; 0 for a section whose `decay` is not yet chosen."""
    return 0.0 if e.decay == "auto" else float(e.decay)


def _half_sine(e: Any) -> BaseMotion:
    return HalfSine(float(e.amplitude), float(e.duration), after=_after(e))


def _sawtooth(e: Any) -> BaseMotion:
    return Sawtooth(float(e.amplitude), float(e.duration), after=_after(e))


def _trapezoid(e: Any) -> BaseMotion:
    return Trapezoid(float(e.amplitude), float(e.duration), after=_after(e), rise=float(e.rise), fall=float(e.fall))


def _srs(e: Any) -> BaseMotion:
    return replace(_synthesised(e.srs.table, int(e.seed)), after=_after(e))


@lru_cache(maxsize=16)
def _synthesised(table: SpectrumTable, seed: int) -> Wavelets:
    from wroll_fem.signals.shock.synthesis import synthesise_shock  # compiled; the other motions do not wait for it

    return synthesise_shock(table, seed=seed)


def _file(e: Any) -> BaseMotion:
    from wroll_fem.signals.records.motion import RecordedMotion

    path = Path(e.file)
    changed = path.stat().st_mtime_ns if path.is_file() else 0
    record = _record(path, changed, e.unit, e.column, e.time, e.sampling_rate, e.rows, e.length)
    return RecordedMotion(record, e.baseline, float(e.taper), e.low_pass, float(e.scale), after=_after(e))


@lru_cache(maxsize=4)
def _record(
    path: Path, changed: int, unit: str, column: str | int | None, time: str | int | None, rate: float | None,
    rows: int | None, length: float | None,
) -> Record:  # fmt: skip
    """Record of a file, which is read again when it has changed."""
    from wroll_fem.signals.records.record import read_record

    return read_record(path, unit=unit, column=column, time=time, sampling_rate=rate, rows=rows, length=length)


MOTIONS: dict[str, Callable[[Any], BaseMotion]] = {
    "chirp": _passes,
    "dwell": _dwell,
    "random": _random,
    "half_sine": _half_sine,
    "sawtooth": _sawtooth,
    "trapezoid": _trapezoid,
    "srs": _srs,
    "file": _file,
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


def sweep_motion(excitation: Any) -> Sweep:
    """Sweep of a case section `excitation` of kind "chirp", of one up and down its first branch; see `base_motion`."""
    return _chirp(excitation)
