r"""Interlayer shear stress of a solid coil in the modes of the three-dimensional model.

srz = G_rz gamma_rz and srt = G_rt gamma_rt are evaluated at the 2 x 2 x 2 Gauss points of each 27-node hexahedron. At
these points (Barlow points) the strain of a quadratic element is one order more accurate than elsewhere.

References
----------
J. Barlow (1976), doi:10.1002/nme.1620100202 (optimal stress locations);
thesis, section 2.4, equation 2.17 (the two components that cause slip between wraps).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from wroll_fem.bodies.body import Body, SolidPart
from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.bodies.mode_shapes import align_pairs, are_degenerate, classify_mode
from wroll_fem.bodies.probe import Probe, probe_row
from wroll_fem.coiled_stiff.stress_modes import ShearModes, needs_solid_coil
from wroll_fem.fem.eigen import DEFAULT_SHIFT, solve_pairs
from wroll_fem.mesh.shells import VTK_GRID
from wroll_fem.typing import FloatArray

GAUSS_POINTS = 2
"""Number of Gauss points per direction in each hexahedron."""

_CELLS_AT_ONCE = 512  # limits the memory for the gradients


def shear_modes(
    bodies: Sequence[Body],
    material: CylindricalOrthotropic,
    *,
    count: int,
    direction: int,
    probes: Mapping[str, Probe] | None = None,
) -> ShearModes:
    """Lowest modes of a roll and the shear stress of each mode in the solid coil.

    Parameters
    ----------
    bodies
        The mandrel with the solid coil bonded to it, whole circumference (no symmetry plane).
    material
        Material of the coil.
    count
        Number of modes. If the last one is half of a degenerate pair, its partner is added, because the direction of
        a single mode of a pair is arbitrary.
    direction
        Direction of the base motion: 0 for x, 1 for y.
    probes
        Points of the mandrel whose displacement the modes contain, by name.

    Raises
    ------
    InputError
        If the mandrel carries no solid coil.
    WrollError
        If the eigensolver misses modes or does not converge.
    """
    body = bodies[0]
    if body.solid is None:
        raise needs_solid_coil()
    pairs = solve_pairs(body.stiffness, body.mass, min(count + 1, body.n_dofs), sigma=DEFAULT_SHIFT)
    frequencies = np.sqrt(np.maximum(pairs.values, 0.0)) / (2 * np.pi)
    vectors = align_pairs(frequencies, pairs.vectors, body.mass, body.influence)
    kept = count + 1 if len(frequencies) > count and are_degenerate(frequencies, count - 1) else count
    frequencies, vectors = frequencies[:kept], vectors[:, :kept]
    points, volumes, rz, rt = coil_shear_strain(body.solid, body.solid.expand @ vectors)
    return ShearModes(
        frequencies_hz=frequencies,
        participation=np.asarray(vectors.T @ (body.mass @ body.influence[:, direction])),
        tip=np.asarray((body.probes["tip"] @ vectors)[direction]),
        points=points,
        volumes=volumes,
        srz=material.G_r_z * rz,
        srt=material.G_r_theta * rt,
        mass_total=body.mass_total,
        kinds=tuple(classify_mode(bodies, vector).kind for vector in vectors.T),
        probes={name: np.asarray(probe_row(body, probe) @ vectors) for name, probe in (probes or {}).items()},
    )


def coil_shear_strain(
    part: SolidPart, displacements: FloatArray, gauss_points: int = GAUSS_POINTS
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Engineering shear strains rz and rt at the Gauss points of a solid coil.

    Parameters
    ----------
    part
        Mesh of the coil.
    displacements
        (3 n_nodes, n_fields) nodal displacements, node-major [ux, uy, uz], m.
    gauss_points
        Number of Gauss points per direction in each hexahedron.

    Returns
    -------
    points : (n, 3) coordinates theta in (-pi, pi] (rad), z (m), r (m).
    volumes : (n,) volume of each point, m^3.
    rz, rt : (n_fields, n) shear strains.
    """
    local, weights = _gauss_points(gauss_points)
    N, dN = quadratic_basis(local)
    fields = displacements.reshape(len(part.nodes), 3, -1)
    parts = []
    for start in range(0, len(part.cells), _CELLS_AT_ONCE):
        cells = part.cells[start : start + _CELLS_AT_ONCE]
        x = np.einsum("qk,ckd->cqd", N, part.nodes[cells])
        jacobian = np.einsum("qka,ckd->cqda", dN, part.nodes[cells])
        dN_dx = np.einsum("qka,cqad->cqkd", dN, np.linalg.inv(jacobian))
        gradient = np.einsum("ckif,cqkd->cqidf", fields[cells], dN_dx)  # d u_i / d x_d
        radius = np.hypot(x[..., 0], x[..., 1])
        radial = np.stack([x[..., 0] / radius, x[..., 1] / radius, np.zeros_like(radius)], axis=-1)
        hoop = np.stack([-radial[..., 1], radial[..., 0], np.zeros_like(radius)], axis=-1)
        towards_z = gradient[..., 2, :, :] + gradient[..., :, 2, :]
        rz = np.einsum("cqd,cqdf->fcq", radial, towards_z)
        rt = np.einsum("cqi,cqd,cqidf->fcq", radial, hoop, gradient + np.swapaxes(gradient, 2, 3))
        volume = weights * np.abs(np.linalg.det(jacobian))
        theta = np.arctan2(x[..., 1], x[..., 0])
        theta[theta <= -np.pi] = np.pi
        at = np.stack([theta, x[..., 2], radius], axis=-1).reshape(-1, 3)
        parts.append((at, volume.ravel(), rz.reshape(len(rz), -1), rt.reshape(len(rt), -1)))
    points, volumes, all_rz, all_rt = zip(*parts, strict=True)
    return np.concatenate(points), np.concatenate(volumes), np.hstack(all_rz), np.hstack(all_rt)


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
