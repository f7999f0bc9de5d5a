"""The loosest coil whose roll still bends in its lowest mode (thesis, section 2.5), in harmonics around the axis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from wroll_fem.errors import ConvergenceError
from wroll_fem.fem.fourier_modes import FourierMode, family_modes, lowest_modes
from wroll_fem.fem.fourier_roll import AXIAL, BENDING, TORSION, Family, FourierRoll
from wroll_fem.structure.materials import CylindricalOrthotropic

LOWEST_MODULUS = 1.0
"""Pa: next to nothing beside any web. A coil that leaves bending the fundamental mode down to here has no limit."""

_TOLERANCE = 1e-8  # of ln G
_REACH = 2.5  # first interval over the gap at its start; 2 would meet the zero where the gap has the slope 1/2
_ASIDE = 1e-3  # step above the crossing at which the fundamental mode is looked up, in the shear modulus


@dataclass(frozen=True)
class LooseCoil:
    """Coil of the lowest shear modulus between wraps that leaves bending the fundamental mode.

    Attributes
    ----------
    shear_modulus
        G_r_theta = G_r_z, Pa.
    bending
        Bending mode there.
    tightest
        Bending mode of the roll with the tightest coil.
    rival
        Kind of the mode that takes its place below: "torsion" or "axial" shear of the coil, or "ovalling-n"; "" when
        bending stays the fundamental mode down to `LOWEST_MODULUS` (a coil clamped at its base).
    """

    shear_modulus: float
    bending: FourierMode
    tightest: FourierMode
    rival: str


def with_shear_modulus(material: CylindricalOrthotropic, G: float) -> CylindricalOrthotropic:
    """Same web with another shear modulus between wraps, G_r_theta = G_r_z, Pa."""
    return replace(material, G_r_theta=G, G_r_z=G)


def fundamental(roll: FourierRoll) -> FourierMode:
    """Lowest mode of a roll over all harmonics."""
    return lowest_modes(roll, 1)[0]


def loosest_coil(roll: FourierRoll, material: CylindricalOrthotropic) -> LooseCoil | None:
    """Lower the shear modulus between wraps until another mode is as low as bending.

    Parameters
    ----------
    roll
        Roll with a solid coil; it is left with the loosest one.
    material
        The tightest coil considered.

    Returns
    -------
    LooseCoil or None
        None if bending is not the fundamental mode of the tightest coil either.

    Raises
    ------
    ConvergenceError
        If the crossing is not found.

    Notes
    -----
    Bending is the lowest mode of m = 1. A soft coil's own lowest motions are uniform shear on the wall, around or along
    the axis, near sqrt(G / rho) / (4 t): they fall with sqrt(G) while bending hardly changes, so they cross once. Modes
    of other harmonics are looked up at the crossing and, if one lies lower, take part in the next search.
    """
    roll.set_coil(material)
    first = fundamental(roll)
    if first.family != BENDING:
        return None
    rivals: list[Family] = [TORSION, AXIAL]
    while True:
        found: dict[float, tuple[FourierMode, FourierMode]] = {}

        def gap(log_modulus: float, rivals: list[Family] = rivals, found: dict = found) -> float:
            if log_modulus not in found:
                roll.set_coil(with_shear_modulus(material, float(np.exp(log_modulus))))
                bending = family_modes(roll, BENDING, 1)[0]
                rival = min((family_modes(roll, f, 1)[0] for f in rivals), key=lambda mode: mode.frequency_hz)
                found[log_modulus] = bending, rival
            bending, rival = found[log_modulus]
            return float(np.log(rival.frequency_hz / bending.frequency_hz))

        thickness = roll.model.section.radii[-1] - roll.model.section.wall_radius
        estimate = float(np.log(material.rho * (4 * thickness * first.frequency_hz) ** 2))
        root = _crossing(gap, estimate, float(np.log(max(material.G_r_theta, material.G_r_z))))
        G = float(np.exp(root))
        roll.set_coil(with_shear_modulus(material, G * (1 + _ASIDE)))
        lowest = fundamental(roll)
        roll.set_coil(with_shear_modulus(material, G))
        if lowest.family == BENDING or lowest.family in rivals:
            bending, rival = found[root]
            unlimited = rival.frequency_hz > bending.frequency_hz * (1 + _ASIDE)
            return LooseCoil(G, bending, first, "" if unlimited else rival.kind)
        rivals = [*rivals, lowest.family]


def _crossing(gap: Callable[[float], float], start: float, top: float) -> float:
    """Zero of a growing function below ``top``, or the lowest modulus where the function is still positive there.

    Parameters
    ----------
    gap
        ln(rival / bending frequency) by ln G.
    start
        Estimate of the zero. A shear frequency grows as sqrt(G), so the zero is about 2 gap(start) below it.

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
                "bending stops being the fundamental mode above the coil's own shear modulus", time_s=None,
                iterations=3, residual_history=[], advice="give design_map.loosest as a shear modulus in Pa",
            )  # fmt: skip
    if gap(low) > 0:
        low = floor
        if gap(low) > 0:
            return floor
    return float(brentq(gap, low, high, xtol=_TOLERANCE))
