"""Modes of a roll from all harmonics, merged, named and weighed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.errors import WrollError
from wroll_fem.fem.eigen import solve_pairs
from wroll_fem.fem.fourier_roll import AXIAL, TORSION, Family, FamilyMatrices, FourierRoll, families
from wroll_fem.typing import FloatArray

SHIFT = -((2 * np.pi * 100.0) ** 2)
"""Shift in (rad/s)^2: below the spectrum, and large enough that rounding in cells of half a millimetre stays small."""

HIGHEST_HARMONIC = 80
_BEYOND = 4
"""Harmonics in a row whose lowest frequency must lie above all wanted ones, and rise, before the search stops."""
_NO_STRAIN = 1.0  # (rad/s)^2, as in wroll_fem.structure.mode_shapes: a motion below this is a rigid one


@dataclass(frozen=True)
class FourierMode:
    """One mode of a family, normalised to unit modal mass; every m >= 1 has a twin turned by pi / (2 m).

    Attributes
    ----------
    family
        What it belongs to.
    frequency_hz, residual
        Natural frequency (Hz), relative residual of the eigenpair.
    values
        (n_nodes, 3) nodal [U, V, W], m per modal coordinate.
    kind
        "bending", "torsion", "axial", "breathing", "ovalling-n" or "rigid", as in `wroll_fem.structure.mode_shapes`.
    participation
        phi^T M i along the family's direction, sqrt(kg); its square is the effective mass.
    tip
        Displacement of the tip's centre along that direction per modal coordinate, 1/sqrt(kg).
    """

    family: Family
    frequency_hz: float
    residual: float
    values: FloatArray
    kind: str
    participation: float
    tip: float


def family_modes(roll: FourierRoll, family: Family, count: int, shift: float = SHIFT) -> list[FourierMode]:
    """Lowest `count` modes of a family (all of them, if it has fewer), ascending."""
    system = roll.matrices(family)
    pairs = solve_pairs(system.stiffness, system.mass, min(count, system.stiffness.shape[0]), shift)
    modes = []
    for value, residual, vector in zip(pairs.values, pairs.residuals, pairs.vectors.T, strict=True):
        participation = float(vector @ (system.mass @ system.influence))
        if participation < 0.0:
            vector, participation = -vector, -participation
        modes.append(
            FourierMode(
                family=family,
                frequency_hz=float(np.sqrt(max(value, 0.0)) / (2 * np.pi)),
                residual=float(residual),
                values=(system.expand @ vector).reshape(-1, 3),
                kind=_kind(family, float(value), vector, system),
                participation=participation,
                tip=float(system.tip @ vector),
            )
        )
    return modes


def _kind(family: Family, value: float, vector: FloatArray, system: FamilyMatrices) -> str:
    if value < _NO_STRAIN:
        return "rigid"
    if family == TORSION:
        return "torsion"
    if family == AXIAL:
        inertia = vector * (system.mass @ vector)
        axial = (system.expand.T @ np.tile([0.0, 0.0, 1.0], system.expand.shape[0] // 3)) != 0.0
        return "axial" if inertia[axial].sum() > inertia[~axial].sum() else "breathing"
    return "bending" if family.harmonic == 1 else f"ovalling-{family.harmonic}"


def lowest_modes(roll: FourierRoll, count: int) -> list[FourierMode]:
    """Modes of the whole roll below or at its mode number `count`, twins counted and listed once.

    Returns
    -------
    list of FourierMode
        Ascending; with every m >= 1 taken twice there are `count` or `count` + 1 of them.

    Raises
    ------
    WrollError
        If the frequencies have not risen above the wanted ones at harmonic `HIGHEST_HARMONIC`.
    """
    found: list[FourierMode] = []
    above, last = 0, 0.0
    for harmonic in range(HIGHEST_HARMONIC + 1):
        limit = _frequency_of(found, count)
        here = [mode for f in families(harmonic) for mode in _up_to(roll, f, count, limit)]
        found += here
        lowest = min(mode.frequency_hz for mode in here)
        above = above + 1 if lowest > max(limit, last) else 0
        last = lowest
        if above == _BEYOND:
            break
    else:
        raise WrollError(
            f"harmonic {HIGHEST_HARMONIC} still has modes among the lowest {count}: ask for fewer modes (modal.count)"
        )
    found.sort(key=lambda mode: mode.frequency_hz)
    return [mode for mode in found if mode.frequency_hz <= _frequency_of(found, count)]


def _up_to(roll: FourierRoll, family: Family, count: int, limit: float) -> list[FourierMode]:
    """Modes of a family up to a frequency, at least one, at most what `count` modes of the roll can take from it."""
    most = count if family.harmonic == 0 else (count + 1) // 2
    some = min(3, most)
    while True:
        modes = family_modes(roll, family, some)
        if len(modes) < some or some == most or modes[-1].frequency_hz > limit:
            return modes
        some = min(2 * some, most)


def _frequency_of(modes: list[FourierMode], count: int) -> float:
    """Frequency of mode number `count`, twins counted; infinite while there are fewer."""
    counted = sorted(f for mode in modes for f in [mode.frequency_hz] * (2 if mode.family.harmonic else 1))
    return counted[count - 1] if len(counted) >= count else np.inf
