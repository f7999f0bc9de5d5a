r"""Interlayer shear stress of a solid coil in the modes of the three-dimensional model.

srz = G_rz gamma_rz and srt = G_rt gamma_rt are evaluated at the points of `shear_points`.

References
----------
Thesis, section 2.4, equation 2.17 (the two components that cause slip between wraps).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from wroll_fem.bodies.body import Body, SolidPart
from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.bodies.mode_shapes import align_pairs, are_degenerate, classify_mode
from wroll_fem.bodies.probe import Probe, probe_row
from wroll_fem.coiled_stiff.shear_points import GAUSS_POINTS, ShearPoints
from wroll_fem.coiled_stiff.stress_modes import ShearModes, needs_solid_coil
from wroll_fem.fem.eigen import DEFAULT_SHIFT, solve_pairs
from wroll_fem.typing import FloatArray


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
    at = ShearPoints.of(part, gauss_points)
    strain = (at.strain @ displacements).T.reshape(displacements.shape[1], -1, 2)
    return at.points, at.volumes, strain[..., 1], strain[..., 0]
