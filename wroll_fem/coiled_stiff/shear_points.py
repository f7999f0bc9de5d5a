r"""Shear strain between the wraps at the Gauss points of a solid coil, as a linear map of its nodal displacements.

The two strains rt and rz act on cylindrical surfaces. They are taken at the 2 x 2 x 2 Gauss points of each 27-node
hexahedron. At these points (Barlow points) the strain of a quadratic element is one order more accurate than elsewhere.

References
----------
J. Barlow (1976), doi:10.1002/nme.1620100202 (optimal stress locations).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from wroll_fem.bodies.body import SolidPart
from wroll_fem.mesh.shells import VTK_GRID
from wroll_fem.typing import FloatArray

AXIAL = np.array([0.0, 0.0, 1.0])
"""Unit vector of the axis."""

GAUSS_POINTS = 2
"""Number of Gauss points per direction in each hexahedron."""


@dataclass(frozen=True)
class ShearPoints:
    """Quadrature points of a solid coil, and the shear strains there.

    Attributes
    ----------
    points
        (n, 3) coordinates theta in (-pi, pi] (rad), z (m), r (m).
    volumes
        (n,) volume of each point, m^3; their sum is the volume of the coil.
    strain
        (2 n, 3 n_nodes) map from the nodal displacements (node-major [ux, uy, uz], m) to the engineering shear strains:
        rt and rz of the first point, then those of the next.
    kept
        Numbers of the points among those of the whole coil; None if they are all.
    """

    points: FloatArray
    volumes: FloatArray
    strain: sp.csr_matrix
    kept: npt.NDArray[np.int64] | None = None

    @classmethod
    def of(cls, part: SolidPart, gauss_points: int = GAUSS_POINTS) -> ShearPoints:
        """Points of the mesh of a coil, ``gauss_points`` per direction in each hexahedron."""
        at = _Geometry.of(part, gauss_points)
        along_r, along_t = (at.slope @ axis[..., None] for axis in (at.radial, at.hoop))
        rt = along_r * at.hoop[:, :, None] + along_t * at.radial[:, :, None]
        rz = along_r * AXIAL + at.slope[..., 2, None] * at.radial[:, :, None]
        theta = np.arctan2(at.x[..., 1], at.x[..., 0])
        theta[theta <= -np.pi] = np.pi
        points = np.stack([theta, at.x[..., 2], np.hypot(at.x[..., 0], at.x[..., 1])], axis=-1)
        return cls(points.reshape(-1, 3), at.volumes.ravel(), at.rows(part, rt, rz))

    def half(self) -> ShearPoints:
        """Points with theta > 0, each with the volume of its mirror image: enough for motions symmetric about x-z."""
        kept = np.flatnonzero(self.points[:, 0] > 0.0)
        rows = (2 * kept[:, None] + np.arange(2)).ravel()
        return ShearPoints(self.points[kept], 2.0 * self.volumes[kept], self.strain[rows], kept)


def radial_stress(part: SolidPart, stiffness: FloatArray, gauss_points: int = GAUSS_POINTS) -> sp.csr_matrix:
    """(n, 3 n_nodes) map from the nodal displacements to the radial stress at the points of `ShearPoints`, Pa.

    ``stiffness`` (6, 6), Pa, is that of the material, with the Voigt order of `materials`.
    """
    at = _Geometry.of(part, gauss_points)
    along_r, along_t = (at.slope @ axis[..., None] for axis in (at.radial, at.hoop))
    parts = along_r * at.radial[:, :, None], along_t * at.hoop[:, :, None], at.slope[..., 2, None] * AXIAL
    return at.rows(part, sum(c * strain for c, strain in zip(stiffness[0, :3], parts, strict=True)))


def full_rule_weight(part: SolidPart) -> FloatArray:
    """(n_cells,) weight of the 3 x 3 x 3 Gauss points in the stiffness of the elements; 2 x 2 x 2 points have the rest.

    It is alpha of `fem.solid`: squared thickness of the coil divided by the area of the cell's face, at most 1.
    """
    inner, outer = (part.nodes[part.cells[:, VTK_GRID.index((1, 1, side))]] for side in (0, 2))
    face = _Geometry.of(part, 3).volumes.sum(axis=1) / np.linalg.norm(outer - inner, axis=1)
    wall = float(np.ptp(np.hypot(*part.nodes[:, :2].T)))
    return np.asarray(np.minimum(1.0, wall**2 / face))


@dataclass(frozen=True)
class _Geometry:
    """Gauss points of c cells: positions, axes (c, q, 3), volumes (c, q), slopes of shape functions (c, q, 27, 3)."""

    x: FloatArray
    volumes: FloatArray
    slope: FloatArray
    radial: FloatArray
    hoop: FloatArray

    @classmethod
    def of(cls, part: SolidPart, gauss_points: int) -> _Geometry:
        """Gauss points of all cells, ``gauss_points`` per direction."""
        local, weights = _gauss_points(gauss_points)
        N, dN = quadratic_basis(local)
        corners = part.nodes[part.cells]
        x = np.einsum("qk,ckd->cqd", N, corners)
        jacobian = np.einsum("qka,ckd->cqda", dN, corners)
        slope = np.einsum("qka,cqad->cqkd", dN, np.linalg.inv(jacobian))
        radius = np.hypot(x[..., 0], x[..., 1])
        radial = np.stack([x[..., 0] / radius, x[..., 1] / radius, np.zeros_like(radius)], axis=-1)
        hoop = np.stack([-radial[..., 1], radial[..., 0], np.zeros_like(radius)], axis=-1)
        return cls(x, weights * np.abs(np.linalg.det(jacobian)), slope, radial, hoop)

    def rows(self, part: SolidPart, *values: FloatArray) -> sp.csr_matrix:
        """Rows in turn of each of the ``values`` (c, q, 27, 3) at every point, over the displacements of all nodes."""
        columns = (3 * part.cells[:, :, None] + np.arange(3)).reshape(len(part.cells), 1, 1, -1)
        stacked = np.stack(values, axis=2).reshape(*self.volumes.shape, len(values), -1)
        columns = np.broadcast_to(columns, stacked.shape)
        count, width = stacked[..., 0].size, stacked.shape[-1]
        ends = width * np.arange(count + 1)
        return sp.csr_matrix((stacked.ravel(), columns.ravel(), ends), shape=(count, 3 * len(part.nodes)))


def quadratic_basis(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shape functions (n, 27) and derivatives (n, 27, 3) of a quadratic unit cube at points (n, 3), in VTK order."""
    s = np.asarray(points, float)[:, None, :]
    line = np.concatenate([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)], axis=1)  # (n, 3 nodes, 3 axes)
    slope = np.concatenate([4 * s - 3, 4 - 8 * s, 4 * s - 1], axis=1)
    grid = np.array(VTK_GRID)
    value = np.stack([line[:, grid[:, axis], axis] for axis in range(3)])
    derivative = np.stack([slope[:, grid[:, axis], axis] for axis in range(3)])
    gradient = [
        derivative[0] * value[1] * value[2],
        value[0] * derivative[1] * value[2],
        value[0] * value[1] * derivative[2],
    ]
    return value.prod(axis=0), np.stack(gradient, axis=-1)


def _gauss_points(count: int) -> tuple[FloatArray, FloatArray]:
    """Gauss points (count^3, 3) and weights (count^3,) on the unit cube."""
    x, w = np.polynomial.legendre.leggauss(count)
    grid = np.stack(np.meshgrid(*[0.5 * (x + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    return grid, np.einsum("i,j,k->ijk", *[0.5 * w] * 3).ravel()
