"""Axisymmetric mesh of a roll: rectangular cells in the r-z half plane, for the mandrel wall and the coil around it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.typing import FloatArray, IntArray

if TYPE_CHECKING:
    from wroll_fem.case.roll import RollSections


WALL_CELLS = 1
"""Number of cells through the wall of the mandrel; one cell of degree 3 suffices (docs/design-map.md)."""

END_CELLS = 3
"""Number of cells added at each end of the roll by splitting the last cell; stress is concentrated there."""

BOND_CELLS = 2
"""Number of cells added at the inner surface of the coil by splitting its innermost cell. Stress is singular at the
lower end of this surface, which is the outer edge of the clamped base of the wall."""

BOND_RATIO = 0.3
"""Ratio of the radial sizes of adjacent cells in the refinement at the inner surface of the coil."""

MESHED_COILS = ("solid", "bonded")
"""Coil models that are meshed; the other models add at most a mass to the wall."""


@dataclass(frozen=True)
class AxisymmetricMesh:
    """Axisymmetric mesh of rectangular cells between given radii and heights.

    Attributes
    ----------
    radii
        (n_r + 1,) cell borders from the bore of the mandrel outwards, m, ascending.
    heights
        (n_z + 1,) cell borders from the base upwards, m, ascending.
    wall_cells
        Number of cells through the wall of the mandrel, counted from the inside; all others belong to the coil.
    """

    radii: FloatArray
    heights: FloatArray
    wall_cells: int

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells along r, and along z."""
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
        """((n_r + 1) (n_z + 1), 2) coordinates [r, z] of the cell corners, m; z varies fastest."""
        r, z = np.meshgrid(self.radii, self.heights, indexing="ij")
        return np.column_stack([r.ravel(), z.ravel()])

    @property
    def cells(self) -> IntArray:
        """(n_r n_z, 4) corner numbers of each cell in dolfinx's order, inner lower corner first; z varies fastest."""
        n_r, n_z = self.shape
        i, j = np.meshgrid(np.arange(n_r), np.arange(n_z), indexing="ij")
        first = (i * (n_z + 1) + j).ravel()
        return np.column_stack([first, first + n_z + 1, first + 1, first + n_z + 2])

    @property
    def outline(self) -> FloatArray:
        """(2 e, 2) coordinates [r, z], m, of ends and midpoints of the e boundary edges; inner lower corner first."""
        r, z = (_with_middles(borders) for borders in (self.radii, self.heights))
        lower = np.column_stack([r, np.full_like(r, z[0])])
        outer = np.column_stack([np.full_like(z, r[-1]), z])
        upper = np.column_stack([r[::-1], np.full_like(r, z[-1])])
        inner = np.column_stack([np.full_like(z, r[0]), z[::-1]])
        return np.concatenate([side[:-1] for side in (lower, outer, upper, inner)])

    def volume(self, *, coil: bool) -> float:
        """Volume of revolution of the coil (or, with coil=False, of the wall), m^3."""
        inner, outer = (self.wall_radius, self.radii[-1]) if coil else (self.radii[0], self.wall_radius)
        return float(np.pi * (outer**2 - inner**2) * self.length)


def _with_middles(borders: FloatArray) -> FloatArray:
    both = np.empty(2 * len(borders) - 1)
    both[::2], both[1::2] = borders, 0.5 * (borders[1:] + borders[:-1])
    return both


def split_ends(heights: FloatArray, smallest: float, count: int = END_CELLS) -> FloatArray:
    """Split the first and the last cell; the distances of the new borders from each end form a geometric progression.

    Parameters
    ----------
    heights
        (n,) cell borders, m, ascending.
    smallest
        Approximate height of the smallest cell, m.
    count
        Number of cells added at each end.

    Returns
    -------
    (n + 2 count,) cell borders, m.
    """

    def steps(cell: float) -> FloatArray:
        ratio = float(np.clip((smallest / cell) ** (1.0 / count), 0.1, 0.5)) if count else 1.0
        return cell * ratio ** np.arange(1, count + 1)

    first, last = steps(heights[1] - heights[0]), steps(heights[-1] - heights[-2])
    return np.concatenate([heights[:1], heights[0] + first[::-1], heights[1:-1], heights[-1] - last, heights[-1:]])


def refined_mesh(roll: RollSections) -> AxisymmetricMesh:
    """Mesh on which a case is solved: `unrefined_mesh`, refined towards the clamp, the tip and the wall.

    The cells at both ends are split down to half the wall thickness. Fourier elements are cheap enough to make the
    result almost independent of the numbers of cells in the case.
    """
    unrefined = unrefined_mesh(roll)
    heights = split_ends(unrefined.heights, 0.5 * roll.geometry.mandrel_thickness)
    w = unrefined.wall_cells
    if len(unrefined.radii) == w + 1:
        return AxisymmetricMesh(unrefined.radii, heights, w)
    bond = (unrefined.radii[w + 1] - unrefined.radii[w]) * BOND_RATIO ** np.arange(BOND_CELLS, 0, -1)
    radii = np.concatenate([unrefined.radii[: w + 1], unrefined.radii[w] + bond, unrefined.radii[w + 1 :]])
    return AxisymmetricMesh(radii, heights, w)


def unrefined_mesh(roll: RollSections) -> AxisymmetricMesh:
    """Mesh with the numbers of cells given in the case: `mesh.axial` along the axis, `mesh.radial` in a solid coil.

    A bonded coil has one cell per layer.
    """
    from wroll_fem.mesh.generate import axial_stations

    g, coil, mesh = roll.geometry, roll.coil, roll.mesh
    outer = 0.5 * g.mandrel_outer_diameter
    radii = [np.linspace(outer - g.mandrel_thickness, outer, WALL_CELLS + 1)]
    if coil.model == "solid":
        radii.append(outer + axial_stations(coil.total_thickness, mesh.radial, mesh.radial_grading)[1:])
    elif coil.model == "bonded":
        radii.append(outer + coil.layer_thickness * np.arange(1, coil.layers + 1))
    return AxisymmetricMesh(np.concatenate(radii), axial_stations(g.length, mesh.axial, mesh.grading), WALL_CELLS)
