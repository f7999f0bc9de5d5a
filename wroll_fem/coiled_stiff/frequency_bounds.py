"""Softest coil with which bending is still the fundamental mode of the roll (thesis, section 2.5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.errors import ConvergenceError
from wroll_fem.fem.fourier_modes import FourierMode, lowest_modes, symmetry_class_modes
from wroll_fem.fem.fourier_roll import AXIAL, BENDING, TORSION, FourierRoll, SymmetryClass

LOWEST_MODULUS = 1.0
"""Lowest interlayer shear modulus of the search, Pa. If bending is still the fundamental mode at this modulus, the
search returns this modulus."""

_TOLERANCE = 1e-8  # absolute tolerance of ln G
_REACH = 2.5  # length of the first interval per gap at its start; with the slope 1/2 the zero is at 2
_OFFSET = 1e-3  # relative increase of the shear modulus above the crossing at which the fundamental mode is checked


@dataclass(frozen=True)
class SoftestCoil:
    """Coil with the lowest interlayer shear modulus for which bending is the fundamental mode.

    Attributes
    ----------
    shear_modulus
        Interlayer shear modulus G_r_theta = G_r_z, Pa.
    bending
        Bending mode of the roll with this coil.
    stiffest
        Bending mode of the roll with the stiffest coil.
    competing_kind
        Kind of the mode that is lower than bending for softer coils: "torsion" or "axial" (shear of the coil) or
        "ovalling-n"; "" if bending is the fundamental mode down to `LOWEST_MODULUS` (a coil clamped at its base).
    """

    shear_modulus: float
    bending: FourierMode
    stiffest: FourierMode
    competing_kind: str


def with_shear_modulus(material: CylindricalOrthotropic, G: float) -> CylindricalOrthotropic:
    """Copy of a material with the interlayer shear modulus G = G_r_theta = G_r_z, Pa.

    Raises
    ------
    InputError
        If the material with this modulus is not admissible.
    """
    return replace(material, G_r_theta=G, G_r_z=G)


def fundamental(roll: FourierRoll) -> FourierMode:
    """Fundamental mode of a roll: the mode of lowest frequency among all circumferential wave numbers.

    Raises
    ------
    WrollError
        If the eigensolver fails.
    """
    return lowest_modes(roll, 1)[0]


def softest_coil(roll: FourierRoll, material: CylindricalOrthotropic) -> SoftestCoil | None:
    """Reduce the interlayer shear modulus until the frequency of another mode falls to the bending frequency.

    Parameters
    ----------
    roll
        Roll with a solid coil; on return it has the softest coil.
    material
        Material of the stiffest coil.

    Returns
    -------
    SoftestCoil or None
        None if bending is not the fundamental mode even with the stiffest coil.

    Raises
    ------
    ConvergenceError
        If the crossing of the two frequencies is not found.

    Notes
    -----
    Bending is the lowest mode with wave number 1. The lowest modes of a soft coil are uniform shear around or along the
    axis, near sqrt(G / rho) / (4 t). They decrease with sqrt(G) while bending hardly changes, so the frequencies cross
    once. The modes of all other wave numbers are checked at the crossing; if one is lower than bending, it is included
    in a further search.
    """
    roll.set_coil(material)
    first = fundamental(roll)
    if first.symmetry != BENDING:
        return None
    competing: list[SymmetryClass] = [TORSION, AXIAL]
    while True:
        found: dict[float, tuple[FourierMode, FourierMode]] = {}

        def gap(log_modulus: float, competing: list[SymmetryClass] = competing, found: dict = found) -> float:
            if log_modulus not in found:
                roll.set_coil(with_shear_modulus(material, float(np.exp(log_modulus))))
                bending = symmetry_class_modes(roll, BENDING, 1)[0]
                other = min(
                    (symmetry_class_modes(roll, f, 1)[0] for f in competing), key=lambda mode: mode.frequency_hz
                )
                found[log_modulus] = bending, other
            bending, other = found[log_modulus]
            return float(np.log(other.frequency_hz / bending.frequency_hz))

        thickness = roll.model.half_plane.radii[-1] - roll.model.half_plane.wall_radius
        estimate = float(np.log(material.rho * (4 * thickness * first.frequency_hz) ** 2))
        root = _crossing(gap, estimate, float(np.log(max(material.G_r_theta, material.G_r_z))))
        G = float(np.exp(root))
        roll.set_coil(with_shear_modulus(material, G * (1 + _OFFSET)))
        lowest = fundamental(roll)
        roll.set_coil(with_shear_modulus(material, G))
        if lowest.symmetry == BENDING or lowest.symmetry in competing:
            bending, other = found[root]
            unlimited = other.frequency_hz > bending.frequency_hz * (1 + _OFFSET)
            return SoftestCoil(G, bending, first, "" if unlimited else other.kind)
        competing = [*competing, lowest.symmetry]


def _crossing(gap: Callable[[float], float], start: float, top: float) -> float:
    """Zero of the increasing function ``gap`` between ln `LOWEST_MODULUS` and ``top``.

    If ``gap`` is positive at ln `LOWEST_MODULUS`, this lower end is returned.

    Parameters
    ----------
    gap
        Logarithm of the ratio of competing to bending frequency, as a function of ln G.
    start
        Estimate of the zero. Shear frequencies are proportional to sqrt(G), so the zero is about 2 gap(start) below
        it.
    top
        Upper end of the search, ln of the interlayer shear modulus of the stiffest coil.

    Raises
    ------
    ConvergenceError
        If the function is negative at ``top``.
    """
    floor = float(np.log(LOWEST_MODULUS))
    start = min(max(start, floor), top)
    beyond = min(max(start - _REACH * gap(start), floor), top)
    low, high = sorted((start, beyond))
    if gap(high) < 0:
        high = top
        if gap(high) < 0:
            raise ConvergenceError(
                "bending is not the fundamental mode at the interlayer shear modulus of the stiffest coil", time_s=None,
                iterations=3, residual_history=[], advice="give design_map.softest as a shear modulus in Pa",
            )  # fmt: skip
    if gap(low) > 0:
        low = floor
        if gap(low) > 0:
            return floor
    root = float(brentq(gap, low, high, xtol=0.1 * _TOLERANCE))
    while gap(root) < 0:  # brentq may end on either side; above the crossing, bending is the fundamental mode
        root += 0.5 * _TOLERANCE
    return root
