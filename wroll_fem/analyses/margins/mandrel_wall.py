"""Wall of a mandrel for a margin against yield: largest stress of each reading, margins, and search for the wall.

The largest von Mises stress is read in eight ways: on the middle surface (membrane) or on the faces (surface), in the
whole tube or away from its ends, with or without the pressure. The margin is (thesis, eq. 6.1)

    margin = yield stress / (largest stress x factor of safety) - 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import get_args

import numpy as np
from scipy.constants import g as GRAVITY
from scipy.optimize import brentq

from wroll_fem.bodies.stress import largest_von_mises
from wroll_fem.bodies.tube import Tube
from wroll_fem.case.sizing import THICKEST, Reading, Sizing
from wroll_fem.typing import BoolArray, FloatArray

READINGS: tuple[str, ...] = get_args(Reading)
SURFACES = ("inner", "middle", "outer")
THINNEST = 2e-4
"""Thinnest wall of the search divided by the outer diameter of the mandrel."""
SAMPLES = 41
"""Number of walls, evenly spaced in log t, at which the margin is computed before the search."""


def tube_of(sizing: Sizing, wall: float) -> Tube:
    """Mandrel with a wall (m), with the coil as non-structural mass."""
    return Tube(
        length=sizing.length, outer_radius=0.5 * sizing.mandrel_outer_diameter, thickness=wall, E=sizing.E,
        nu=sizing.nu, rho=sizing.rho, extra_mass=sizing.coil_mass,
    )  # fmt: skip


def cap_mass(sizing: Sizing, wall: float) -> float:
    """Mass of the end cap, a disc of the outer diameter that is as thick as the wall, kg."""
    return sizing.rho * 0.25 * math.pi * sizing.mandrel_outer_diameter**2 * wall


@dataclass(frozen=True)
class Peak:
    """Largest von Mises stress of a reading.

    Attributes
    ----------
    stress
        Pa.
    z, theta
        Height above the base (m), and angle from the direction of the inertial load (rad, 0 to pi).
    surface
        "inner", "middle" or "outer".
    """

    stress: float
    z: float
    theta: float
    surface: str


class MandrelStress:
    """Stresses of the mandrel of a case section `sizing` for any wall.

    Parameters
    ----------
    sizing
        Case section.
    cells
        Number of cells along the axis.
    """

    def __init__(self, sizing: Sizing, cells: int):
        from wroll_fem.fem.fourier_shell.model import FourierShellModel

        self.sizing, self.cells = sizing, cells
        self.model = FourierShellModel(cells)
        self.peaks: Callable[[float], dict[str, Peak | None]] = lru_cache(maxsize=None)(self._peaks)

    def _peaks(self, wall: float) -> dict[str, Peak | None]:
        from wroll_fem.fem.fourier_shell.mandrel import ClampedMandrel, end_zone, graded_heights

        tube, cap = tube_of(self.sizing, wall), cap_mass(self.sizing, wall)
        mandrel = ClampedMandrel(self.model, tube, graded_heights(tube, self.cells), cap)
        z, pressed = self.model.surface_stress(self.sizing.pressure * mandrel.under_pressure(), 0)
        inertial = GRAVITY * self.sizing.acceleration_g * mandrel.under_acceleration()
        bent = self.model.surface_stress(inertial, 1)[1]
        zone = end_zone(tube) * (1.0 - 1e-9)
        away = (z >= zone) & (z <= tube.length - zone)
        found: dict[str, Peak | None] = {}
        for suffix, constant in (("", pressed), ("_without_pressure", np.zeros_like(pressed))):
            stress, theta = largest_von_mises(np.moveaxis(constant, 1, 0), np.moveaxis(bent, 1, 0))  # (3, points)
            for name, rows in (("membrane", [1]), ("surface", [0, 2])):
                for place, here in (("", np.ones_like(away)), ("_away_from_ends", away)):
                    found[name + place + suffix] = _largest(stress, theta, z, rows, here)
        return {name: found[name] for name in READINGS}

    def margins(self, wall: float) -> dict[str, float]:
        """Margin of each reading (eq. 6.1); nan where a reading has no points."""
        allowed = self.sizing.yield_stress / self.sizing.factor_of_safety
        return {
            name: math.nan if peak is None else allowed / peak.stress - 1.0 for name, peak in self.peaks(wall).items()
        }

    def margin(self, name: str, wall: float) -> float:
        """Margin of one reading."""
        return self.margins(wall)[name]


def _largest(stress: FloatArray, theta: FloatArray, z: FloatArray, rows: list[int], here: BoolArray) -> Peak | None:
    if not here.any():
        return None
    within = np.where(here, stress[rows], -np.inf)
    number, point = divmod(int(within.argmax()), within.shape[1])
    row = rows[number]
    return Peak(float(stress[row, point]), float(z[point]), float(theta[row, point]), SURFACES[row])


def walls_of_search(sizing: Sizing) -> FloatArray:
    """(SAMPLES,) walls at which the margin is computed before the search, m."""
    diameter = sizing.mandrel_outer_diameter
    return np.geomspace(THINNEST * diameter, THICKEST * diameter, SAMPLES)


def wall_for_margin(
    margin: Callable[[float], float], walls: Sequence[float] | FloatArray, wanted: float
) -> float | None:
    """Thinnest wall above which all sampled walls up to the largest margin have the wanted margin.

    Parameters
    ----------
    margin
        Margin of a wall (m).
    walls
        Ascending walls, m, at which the margin is evaluated first.
    wanted
        Wanted margin.

    Returns
    -------
    Wall, m; None if no sampled wall has the wanted margin, or if the thinnest already has it.
    """
    gap = np.array([margin(float(wall)) - wanted for wall in walls])
    if not np.isfinite(gap).any():
        return None
    top = int(np.nanargmax(gap))
    below = np.flatnonzero(gap[:top] < 0.0)
    if gap[top] < 0.0 or not len(below):
        return None
    low, high = (math.log(float(walls[k])) for k in (below[-1], below[-1] + 1))
    return math.exp(float(brentq(lambda x: margin(math.exp(x)) - wanted, low, high, xtol=1e-9)))


def unreachable(margins: Mapping[float, float], wanted: float) -> str:
    """Reason why the search found no wall, with the margins at both ends of the search.

    Parameters
    ----------
    margins
        Wall (m) -> margin, ascending.
    wanted
        Wanted margin.
    """
    known = {wall: value for wall, value in margins.items() if math.isfinite(value)}
    if not known:
        return "no part of the tube is far enough from both ends to be away from them"
    (thin, at_thin), (thick, at_thick) = next(iter(known.items())), list(known.items())[-1]
    best = max(known, key=lambda wall: known[wall])
    ends = f"{at_thin:.3g} at {1e3 * thin:.3g} mm and {at_thick:.3g} at {1e3 * thick:.3g} mm"
    if known[best] >= wanted:
        return f"the thinnest wall of the search already has the margin {wanted:g}: it is {ends}"
    return f"no wall has the margin {wanted:g}: it is {ends}, at most {known[best]:.3g}"
