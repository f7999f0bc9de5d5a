"""Studies of the lab roll (configs/studies) on which the claims of chapter 4 are judged."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from reproduction.evidence import Evidence
from wroll_fem.errors import InputError
from wroll_fem.plotting.convergence import first_bending
from wroll_fem.plotting.study import PRESSURE, StudyCase, is_sweep, read

PRELOAD_STUDY = {"free": "preload", "clamped": "preload_clamped"}
"""Base condition of the layer -> study of sweeps over the preload."""


def sweeps(evidence: Evidence, base: str) -> list[StudyCase]:
    """Sweeps with one base condition, in order of increasing preload.

    Raises
    ------
    InputError
        If there are fewer than three.
    """
    study = PRELOAD_STUDY[base]
    found = sorted((m for m in evidence.study(study) if is_sweep(m)), key=lambda m: float(m.values[PRESSURE]))
    if len(found) < 3:
        raise InputError(f"study {study} has fewer than three finished sweeps", remedy="see its run folders")
    return found


def bound(evidence: Evidence, interface: str, base: str) -> float:
    """First bending frequency with the layer bonded or frictionless, Hz."""
    return first_bending(evidence.one("bounds", modal__interface=interface, coil__base=base))


def beside(
    evidence: Evidence, said: Callable[[Sequence[StudyCase]], str], found: Callable[[str], Sequence[StudyCase]]
) -> str:
    """Results for the free base, on which claims are judged, and for the clamped base, as text.

    Parameters
    ----------
    found
        Cases of a base condition, "free" or "clamped".
    """
    clamped = found("clamped")
    rings = " (it rings)" if any(is_sweep(m) and read(m).rings for m in clamped) else ""
    return f"free base: {said(found('free'))}; clamped: {said(clamped)}{rings}"
