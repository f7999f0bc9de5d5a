"""Force on a degree of freedom, with phase and harmonic."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wroll_fem.dynamics.joints.joint import At, row_of
from wroll_fem.dynamics.system.harmonic_force import HarmonicForce
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray


@dataclass(frozen=True, kw_only=True)
class Force:
    """Force a cos(h w t + phase), times the amplitude of the excitation.

    Attributes
    ----------
    at
        Degree of freedom, pair (i, j) for equal and opposite forces, or row (n,).
    amplitude
        Amplitude a, N.
    phase
        Phase, degrees.
    harmonic
        Harmonic h of the excitation frequency.
    """

    at: At
    amplitude: float = 1.0
    phase: float = 0.0
    harmonic: int = 1

    def __post_init__(self) -> None:
        if self.harmonic != int(self.harmonic) or self.harmonic < 1:
            raise InputError(f"Force: harmonic is {self.harmonic}", key="harmonic", remedy="give 1, 2, 3, ...")
        if not np.isfinite([self.amplitude, self.phase]).all():
            raise InputError("Force: amplitude or phase is not finite", key="amplitude", remedy="give numbers")


def patterns(forces: Sequence[Force], n: int) -> tuple[FloatArray, tuple[HarmonicForce, ...]]:
    """Pattern (n,) of all forces that go as cos(wt), N, and the other parts by harmonic."""
    first = np.zeros(n)
    parts: dict[int, tuple[FloatArray, FloatArray]] = {}
    for force in forces:
        row, angle = row_of(force.at, n), np.deg2rad(force.phase)
        cosine, sine = force.amplitude * np.cos(angle) * row, -force.amplitude * np.sin(angle) * row
        order = int(force.harmonic)
        if order == 1:
            first += cosine
            cosine = np.zeros(n)
        if np.any(np.abs([cosine, sine]) > NO_FORCE * abs(force.amplitude)):
            old = parts.get(order, (np.zeros(n), np.zeros(n)))
            parts[order] = old[0] + cosine, old[1] + sine
    return first, tuple(HarmonicForce(order, *parts[order]) for order in sorted(parts))


NO_FORCE = 1e-15
"""Part of a force, relative to its amplitude, below which it is rounding error of its phase."""
