"""Interlayer shear stress of a solid coil in the bending modes of the semi-analytical Fourier model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.bodies.probe import Probe
from wroll_fem.coiled_stiff.stress_modes import ShearModes
from wroll_fem.errors import InputError
from wroll_fem.fem.fourier import COSINE, SINE, FourierModel
from wroll_fem.fem.fourier_modes import lowest_modes
from wroll_fem.fem.fourier_probe import mode_at_probe
from wroll_fem.fem.fourier_roll import FourierRoll
from wroll_fem.mesh.axisymmetric import AxisymmetricMesh
from wroll_fem.typing import FloatArray

GAUSS_POINTS = 2
"""Number of Gauss points per direction in each cell of the unrefined mesh, as in the three-dimensional model."""


def shear_modes(
    roll: FourierRoll,
    material: CylindricalOrthotropic,
    quadrature_mesh: AxisymmetricMesh,
    *,
    count: int,
    direction: int,
    circumferential: int,
    probes: Mapping[str, tuple[Probe, float]] | None = None,
) -> ShearModes:
    """Compute those of the lowest modes of a roll that the base motion excites, and their shear stress in the coil.

    A lateral base motion excites only modes of circumferential wave number 1. In each degenerate pair it excites only
    the mode along the excitation. All other modes are omitted.

    Parameters
    ----------
    roll
        Roll with a solid coil.
    material
        Material of the coil.
    quadrature_mesh
        Unrefined mesh of the case. The stress is computed on the refined mesh of `roll` and evaluated at the Gauss
        points of this mesh. The stress is singular at the lower inner edge of the coil, where the clamp ends, so the
        distance of the points from that edge must not depend on the refinement.
    count
        Number of lowest modes of the roll to search.
    direction
        Direction of the base motion: 0 for x, 1 for y.
    circumferential
        Number of elements around the circumference of the equivalent three-dimensional mesh. The stress is evaluated
        at twice as many angles, rounded up to a multiple of four, so that points lie on the axis of the excitation and
        on its normal.
    probes
        Points whose displacement the modes contain, by name, each with the radius of its mid-surface, m.

    Raises
    ------
    InputError
        If none of the modes has wave number 1.
    WrollError
        If the eigensolver misses modes or does not converge.
    """
    modes = [mode for mode in lowest_modes(roll, count) if mode.symmetry.wave_number == 1]
    if not modes:
        raise InputError(
            f"none of the lowest {count} modes has effective mass along the excitation", key="modal.count",
            remedy="increase modal.count",
        )  # fmt: skip
    turn = 0.5 * np.pi if direction == 1 else 0.0
    r, z, area = _quadrature(quadrature_mesh)
    stations = 4 * -(-circumferential // 2)
    theta = np.pi * (2 * (np.arange(stations) + 1) / stations - 1)
    points = np.column_stack([r, z])
    fields = [shear_amplitudes(roll.model, mode.values, material, 1, points) for mode in modes]
    cosine, sine = np.cos(theta - turn), np.sin(theta - turn)
    return ShearModes(
        frequencies_hz=np.array([mode.frequency_hz for mode in modes]),
        participation=np.array([mode.participation for mode in modes]),
        tip=np.array([mode.tip for mode in modes]),
        points=np.column_stack([np.repeat(theta, len(r)), np.tile(z, stations), np.tile(r, stations)]),
        volumes=np.tile(2 * np.pi / stations * area * r, stations),
        srz=np.array([np.outer(cosine, srz).ravel() for srz, _ in fields]).reshape(len(modes), -1),
        srt=np.array([np.outer(sine, srt).ravel() for _, srt in fields]).reshape(len(modes), -1),
        mass_total=roll.mass_total,
        kinds=tuple(mode.kind for mode in modes),
        probes={
            name: np.array([mode_at_probe(roll, mode, probe, radius, turned=turn > 0.0) for mode in modes])
            for name, (probe, radius) in (probes or {}).items()
        },
    )


def shear_amplitudes(
    model: FourierModel, values: FloatArray, material: CylindricalOrthotropic, harmonic: int, points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Amplitudes of the shear stresses srz (times cos m theta) and srt (times sin m theta) at points of the coil.

    Parameters
    ----------
    model
        Finite elements of the half plane.
    values
        (n_nodes, 3) nodal displacement amplitudes [U, V, W], m.
    material
        Material of the coil.
    harmonic
        Circumferential wave number m.
    points
        (p, 2) coordinates [r, z], m.

    Returns
    -------
    srz, srt : (p,) Pa
    """
    at, gradient = model.evaluate(values, points)
    r, C = points[:, 0], material.stiffness()
    rr, zz = gradient[:, 0, 0], gradient[:, 2, 1]
    tt = (at[:, 0] + harmonic * at[:, 1]) / r
    rz = gradient[:, 0, 1] + gradient[:, 2, 0]
    tz = gradient[:, 1, 1] - harmonic * at[:, 2] / r
    rt = gradient[:, 1, 0] - (at[:, 1] + harmonic * at[:, 0]) / r
    return C[4, COSINE] @ np.stack([rr, tt, zz, rz]), C[5, SINE] @ np.stack([tz, rt])


def _quadrature(mesh: AxisymmetricMesh) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coordinates r and z (p,) in m and weights (p,) in m^2 of the Gauss points of the coil's cells."""
    x, w = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    at, weight = [], []
    for borders in (mesh.radii[mesh.wall_cells :], mesh.heights):
        size = np.diff(borders)[:, None]
        at.append((borders[:-1, None] + 0.5 * size * (x + 1)).ravel())
        weight.append((0.5 * size * w).ravel())
    r, z = np.meshgrid(*at, indexing="ij")
    return r.ravel(), z.ravel(), np.outer(*weight).ravel()
