r"""Shear stress of the solid coil in its modes, at quadrature points.

srz = G_rz gamma_rz and srt = G_rt gamma_rt are taken at the 2 x 2 x 2 Gauss points of each 27-node hex. There the
strain of a quadratic element is one order more accurate than elsewhere in it (Barlow's points), and it is what the
stiffness itself sees: the rest of the strain has only the small weight alpha (`solid`).

References
----------
J. Barlow (1976), doi:10.1002/nme.1620100202 (optimal stress locations);
thesis, section 2.4, eq 2.17 (the two components that make wraps slip).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.analyses.shared.assembly import DIRECTIONS, build_bodies
from wroll_fem.coiled_stiff.stress_modes import ShearModes
from wroll_fem.errors import InputError
from wroll_fem.fem.eigen import DEFAULT_SHIFT, solve_pairs
from wroll_fem.mesh.shells import VTK_GRID
from wroll_fem.structure.mode_shapes import align_pairs, are_twins, classify_mode
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import Case
    from wroll_fem.structure.body import SolidPart


GAUSS_POINTS = 2
"""Per direction and hex."""

_CELLS_AT_ONCE = 512  # bounds the memory of the gradients


def shear_modes(case: Case) -> ShearModes:
    """Lowest `modal.count` modes of the roll and the shear stress that each makes in its coil.

    The twin of the last one is taken too: the direction of half a pair would be arbitrary.

    Raises
    ------
    InputError
        If the case has no solid coil.
    """
    if case.coil.model != "solid":
        raise InputError("the shear stress is that of a solid coil", key="coil.model", remedy="use coil.model: solid")
    bodies = build_bodies(case, symmetric=False)
    body = bodies[0]
    assert body.solid is not None  # the coil model above
    count = case.modal.count
    pairs = solve_pairs(body.stiffness, body.mass, min(count + 1, body.n_dofs), sigma=DEFAULT_SHIFT)
    frequencies = np.sqrt(np.maximum(pairs.values, 0.0)) / (2 * np.pi)
    vectors = align_pairs(frequencies, pairs.vectors, body.mass, body.influence)
    kept = count + 1 if len(frequencies) > count and are_twins(frequencies, count - 1) else count
    frequencies, vectors = frequencies[:kept], vectors[:, :kept]
    direction = DIRECTIONS[case.excitation.direction]
    material = case.coil.material.solid()
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
    )


def coil_shear_strain(
    part: SolidPart, displacements: FloatArray, gauss_points: int = GAUSS_POINTS
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Engineering shear strains rz and rt of nodal displacements, at Gauss points.

    Parameters
    ----------
    part
        Mesh of the coil.
    displacements
        (3 n_nodes, n_fields), node-major [ux, uy, uz], m.
    gauss_points
        Per direction and hex.

    Returns
    -------
    points : (n, 3) theta in (-pi, pi] rad, z m, r m.
    volumes : (n,) m^3.
    rz, rt : (n_fields, n)
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
    """(n, 27) values and (n, 27, 3) derivatives of the quadratic basis of the unit cube, in VTK's order."""
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
    """Points (count^3, 3) and weights (count^3,) on the unit cube."""
    x, w = np.polynomial.legendre.leggauss(count)
    grid = np.stack(np.meshgrid(*[0.5 * (x + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    return grid, np.einsum("i,j,k->ijk", *[0.5 * w] * 3).ravel()
