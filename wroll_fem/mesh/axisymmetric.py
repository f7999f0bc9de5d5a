"""The r-z half plane of a roll as a grid of rectangles: wall of the mandrel inside, coil outside. FEM-free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.typing import FloatArray, IntArray

if TYPE_CHECKING:
    from wroll_fem.case import Case


WALL_CELLS = 1
"""Cells through the mandrel's wall: cubic ones need no more (docs/design-map.md)."""

END_CELLS = 3
"""Cells by which the lowest and the topmost one are split towards clamp and tip, where stresses have an edge."""

BOND_CELLS = 2
"""Cells by which the innermost one of the coil is split towards the wall: its lower edge is where the clamp ends."""

BOND_RATIO = 0.3
"""Size of a cell over that of its outer neighbour there."""

IN_SECTION = ("solid", "bonded")
"""Coil models that are meshed; the others are a mass on the wall, or nothing."""


@dataclass(frozen=True)
class RollSection:
    """Rectangles between radii and heights.

    Attributes
    ----------
    radii
        (n_r + 1,) ascending, m: borders of the cells from the mandrel's bore outwards.
    heights
        (n_z + 1,) ascending, m: borders of the cells from the base upwards.
    wall_cells
        Number of cells, counted from the inside, that are the mandrel's wall; the rest is coil.
    """

    radii: FloatArray
    heights: FloatArray
    wall_cells: int

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along r and z."""
        return len(self.radii) - 1, len(self.heights) - 1

    @property
    def wall_radius(self) -> float:
        """Outer radius of the mandrel, m."""
        return float(self.radii[self.wall_cells])

    @property
    def length(self) -> float:
        """Height of the tip above the base, m."""
        return float(self.heights[-1] - self.heights[0])

    @property
    def nodes(self) -> FloatArray:
        """((n_r + 1) (n_z + 1), 2) corners of the cells [r, z], z running fastest."""
        r, z = np.meshgrid(self.radii, self.heights, indexing="ij")
        return np.column_stack([r.ravel(), z.ravel()])

    @property
    def cells(self) -> IntArray:
        """(n_r n_z, 4) corners of each cell in dolfinx's order, (inner, lower) first, z running fastest."""
        n_r, n_z = self.shape
        i, j = np.meshgrid(np.arange(n_r), np.arange(n_z), indexing="ij")
        first = (i * (n_z + 1) + j).ravel()
        return np.column_stack([first, first + n_z + 1, first + 1, first + n_z + 2])

    @property
    def outline(self) -> FloatArray:
        """(2 e, 2) corners and middles [r, z] of the border's edges, once around from the inner lower corner."""
        r, z = (_with_middles(borders) for borders in (self.radii, self.heights))
        lower = np.column_stack([r, np.full_like(r, z[0])])
        outer = np.column_stack([np.full_like(z, r[-1]), z])
        upper = np.column_stack([r[::-1], np.full_like(r, z[-1])])
        inner = np.column_stack([np.full_like(z, r[0]), z[::-1]])
        return np.concatenate([side[:-1] for side in (lower, outer, upper, inner)])

    def volume(self, *, coil: bool) -> float:
        """Volume of revolution of the coil, or of the wall, m^3."""
        inner, outer = (self.wall_radius, self.radii[-1]) if coil else (self.radii[0], self.wall_radius)
        return float(np.pi * (outer**2 - inner**2) * self.length)


def _with_middles(borders: FloatArray) -> FloatArray:
    both = np.empty(2 * len(borders) - 1)
    both[::2], both[1::2] = borders, 0.5 * (borders[1:] + borders[:-1])
    return both


def split_ends(heights: FloatArray, smallest: float, count: int = END_CELLS) -> FloatArray:
    """Heights with the first and the last cell split in geometric progression down to about `smallest`, m."""

    def steps(cell: float) -> FloatArray:
        ratio = float(np.clip((smallest / cell) ** (1.0 / count), 0.1, 0.5)) if count else 1.0
        return cell * ratio ** np.arange(1, count + 1)

    first, last = steps(heights[1] - heights[0]), steps(heights[-1] - heights[-2])
    return np.concatenate([heights[:1], heights[0] + first[::-1], heights[1:-1], heights[-1] - last, heights[-1:]])


def make_section(case: Case) -> RollSection:
    """Section on which a case is solved: `plain_section`, refined towards clamp, tip and bond.

    Cells at both ends are split down to half the wall's thickness. The harmonics cost so little that accuracy need not
    hang on the numbers of cells in the case.
    """
    plain = plain_section(case)
    heights = split_ends(plain.heights, 0.5 * case.geometry.mandrel_thickness)
    w = plain.wall_cells
    if len(plain.radii) == w + 1:
        return RollSection(plain.radii, heights, w)
    bond = (plain.radii[w + 1] - plain.radii[w]) * BOND_RATIO ** np.arange(BOND_CELLS, 0, -1)
    radii = np.concatenate([plain.radii[: w + 1], plain.radii[w] + bond, plain.radii[w + 1 :]])
    return RollSection(radii, heights, w)


def plain_section(case: Case) -> RollSection:
    """Cells that a case asks for: `mesh.axial`, `mesh.grading` along the axis, `mesh.radial` through a solid coil.

    A bonded coil gets a cell per layer.
    """
    from wroll_fem.mesh.generate import axial_stations

    g, coil, mesh = case.geometry, case.coil, case.mesh
    outer = 0.5 * g.mandrel_outer_diameter
    radii = [np.linspace(outer - g.mandrel_thickness, outer, WALL_CELLS + 1)]
    if coil.model == "solid":
        radii.append(outer + axial_stations(coil.total_thickness, mesh.radial, mesh.radial_grading)[1:])
    elif coil.model == "bonded":
        radii.append(outer + coil.layer_thickness * np.arange(1, coil.layers + 1))
    return RollSection(np.concatenate(radii), axial_stations(g.length, mesh.axial, mesh.grading), WALL_CELLS)
