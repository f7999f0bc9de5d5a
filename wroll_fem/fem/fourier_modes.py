"""Lowest modes of a roll among all circumferential wave numbers, with their kinds and participation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.errors import WrollError
from wroll_fem.fem.eigen import solve_pairs
from wroll_fem.fem.fourier_roll import (
    AXIAL,
    TORSION,
    FourierRoll,
    SymmetryClass,
    SymmetryClassMatrices,
    symmetry_classes,
)
from wroll_fem.typing import FloatArray

SHIFT = -((2 * np.pi * 100.0) ** 2)
"""Spectral shift, (rad/s)^2. It is below all eigenvalues, and far enough to limit rounding errors with 0.5 mm cells."""

HIGHEST_WAVE_NUMBER = 80
"""Largest circumferential wave number in a search for modes; a search not complete by then stops with an error."""
_BEYOND = 4
"""Number of consecutive wave numbers without a wanted mode, after which the search ends."""
_NO_STRAIN = 1.0  # (rad/s)^2, as in wroll_fem.bodies.mode_shapes: modes with a smaller eigenvalue are rigid


@dataclass(frozen=True)
class FourierMode:
    """Mode of unit modal mass, with circumferential wave number m.

    For m >= 1 it represents a degenerate pair; the second mode is the first one rotated about the axis by pi / (2 m).

    Attributes
    ----------
    symmetry
        Symmetry class of the mode.
    frequency_hz, residual
        Natural frequency (Hz), relative residual of the eigenpair.
    values
        (n_nodes, 3) nodal [U, V, W], m per modal coordinate.
    kind
        "bending", "torsion", "axial", "breathing", "ovalling-n" or "rigid", as in `wroll_fem.bodies.mode_shapes`.
    participation
        phi^T M i along the direction of the symmetry class, sqrt(kg); its square is the effective mass.
    tip
        Displacement of the centre of the tip along that direction per modal coordinate, 1/sqrt(kg).
    """

    symmetry: SymmetryClass
    frequency_hz: float
    residual: float
    values: FloatArray
    kind: str
    participation: float
    tip: float


def symmetry_class_modes(
    roll: FourierRoll, symmetry: SymmetryClass, count: int, shift: float = SHIFT
) -> list[FourierMode]:
    """Lowest modes of a symmetry class, in order of frequency.

    Parameters
    ----------
    roll
        Roll with its materials.
    symmetry
        Symmetry class.
    count
        Number of modes; all of them if the class has fewer.
    shift
        Spectral shift, (rad/s)^2.

    Raises
    ------
    WrollError
        If the eigensolver misses modes or does not converge.
    """
    system = roll.matrices(symmetry)
    pairs = solve_pairs(system.stiffness, system.mass, min(count, system.stiffness.shape[0]), shift)
    modes = []
    for value, residual, vector in zip(pairs.values, pairs.residuals, pairs.vectors.T, strict=True):
        participation = float(vector @ (system.mass @ system.influence))
        if participation < 0.0:
            vector, participation = -vector, -participation
        modes.append(
            FourierMode(
                symmetry=symmetry,
                frequency_hz=float(np.sqrt(max(value, 0.0)) / (2 * np.pi)),
                residual=float(residual),
                values=(system.expand @ vector).reshape(-1, 3),
                kind=_kind(symmetry, float(value), vector, system),
                participation=participation,
                tip=float(system.tip @ vector),
            )
        )
    return modes


def _kind(symmetry: SymmetryClass, value: float, vector: FloatArray, system: SymmetryClassMatrices) -> str:
    if value < _NO_STRAIN:
        return "rigid"
    if symmetry == TORSION:
        return "torsion"
    if symmetry == AXIAL:
        inertia = vector * (system.mass @ vector)
        axial = (system.expand.T @ np.tile([0.0, 0.0, 1.0], system.expand.shape[0] // 3)) != 0.0
        return "axial" if inertia[axial].sum() > inertia[~axial].sum() else "breathing"
    return "bending" if symmetry.wave_number == 1 else f"ovalling-{symmetry.wave_number}"


def lowest_modes(roll: FourierRoll, count: int) -> list[FourierMode]:
    """Lowest `count` modes of the whole roll; each degenerate pair is listed once.

    Returns
    -------
    list of FourierMode
        In order of frequency. Counting every mode with m >= 1 twice gives `count` or `count` + 1 modes.

    Raises
    ------
    WrollError
        If wave number `HIGHEST_WAVE_NUMBER` still has modes among the lowest, or if the eigensolver fails.
    """
    found: list[FourierMode] = []
    above, last = 0, 0.0
    for wave_number in range(HIGHEST_WAVE_NUMBER + 1):
        limit = _frequency_of(found, count)
        here = [mode for f in symmetry_classes(wave_number) for mode in _up_to(roll, f, count, limit)]
        found += here
        lowest = min(mode.frequency_hz for mode in here)
        above = above + 1 if lowest > max(limit, last) else 0
        last = lowest
        if above == _BEYOND:
            break
    else:
        raise WrollError(
            f"wave number {HIGHEST_WAVE_NUMBER} still has modes among the lowest {count}; reduce modal.count"
        )
    found.sort(key=lambda mode: mode.frequency_hz)
    return [mode for mode in found if mode.frequency_hz <= _frequency_of(found, count)]


def _up_to(roll: FourierRoll, symmetry: SymmetryClass, count: int, limit: float) -> list[FourierMode]:
    """Lowest modes of a symmetry class, at least up to the frequency `limit` (Hz).

    Modes that cannot be among the lowest `count` of the roll are not computed.
    """
    most = count if symmetry.wave_number == 0 else (count + 1) // 2
    some = min(3, most)
    while True:
        modes = symmetry_class_modes(roll, symmetry, some)
        if len(modes) < some or some == most or modes[-1].frequency_hz > limit:
            return modes
        some = min(2 * some, most)


def _frequency_of(modes: list[FourierMode], count: int) -> float:
    """Frequency (Hz) of mode number `count`, counting both modes of each pair; infinite if there are fewer modes."""
    counted = sorted(f for mode in modes for f in [mode.frequency_hz] * (2 if mode.symmetry.wave_number else 1))
    return counted[count - 1] if len(counted) >= count else np.inf
