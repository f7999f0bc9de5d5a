"""Shear stress of a solid coil in the bending modes of the Fourier model, at quadrature points around the axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.coiled_stiff.stress_modes import ShearModes
from wroll_fem.errors import InputError
from wroll_fem.fem.fourier import COSINE, SINE
from wroll_fem.fem.fourier_modes import lowest_modes
from wroll_fem.fem.fourier_roll import FourierRoll
from wroll_fem.mesh.axisymmetric import RollSection, plain_section
from wroll_fem.structure.materials import CylindricalOrthotropic
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import Case
    from wroll_fem.fem.fourier import FourierModel


GAUSS_POINTS = 2
"""Per direction and cell of the case, as in the three-dimensional model."""


def shear_modes(case: Case) -> ShearModes:
    """Modes along the excitation among the lowest `modal.count` of the roll, with their shear stress in the coil.

    Only the modes of harmonic 1 answer a lateral base motion, and of each pair only the one along the excitation: the
    others are left out. The stress is that of the refined section, taken at the quadrature points of the cells that
    the case asks for: it is singular at the coil's lower inner edge, where the clamp ends, and how near points come to
    that edge follows from `mesh.axial`, `mesh.radial` and their gradings alone. There are 2 x `mesh.circumferential`
    stations around the axis (a multiple of four), of which four lie on the excitation's axis and its normal.

    Raises
    ------
    InputError
        If the case has no solid coil, or none of the modes moves sideways.
    """
    if case.coil.model != "solid":
        raise InputError("the shear stress is that of a solid coil", key="coil.model", remedy="use coil.model: solid")
    roll = FourierRoll(case)
    modes = [mode for mode in lowest_modes(roll, case.modal.count) if mode.family.harmonic == 1]
    if not modes:
        raise InputError(
            f"none of the lowest {case.modal.count} modes moves along the excitation", key="modal.count",
            remedy="take more modes",
        )  # fmt: skip
    turn = 0.5 * np.pi if case.excitation.direction == "y" else 0.0
    r, z, area = _quadrature(plain_section(case))
    stations = 4 * -(-case.mesh.circumferential // 2)
    theta = np.pi * (2 * (np.arange(stations) + 1) / stations - 1)
    material, points = case.coil.material.solid(), np.column_stack([r, z])
    fields = [section_shear(roll.model, mode.values, material, 1, points) for mode in modes]
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
    )


def section_shear(
    model: FourierModel, values: FloatArray, material: CylindricalOrthotropic, harmonic: int, points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Amplitudes of srz (cos m theta) and srt (sin m theta) at points of the coil, Pa.

    Parameters
    ----------
    values
        (n_nodes, 3) nodal [U, V, W], m.
    points
        (p, 2) [r, z], m.

    Returns
    -------
    srz, srt : (p,)
    """
    at, gradient = model.evaluate(values, points)
    r, C = points[:, 0], material.stiffness()
    rr, zz = gradient[:, 0, 0], gradient[:, 2, 1]
    tt = (at[:, 0] + harmonic * at[:, 1]) / r
    rz = gradient[:, 0, 1] + gradient[:, 2, 0]
    tz = gradient[:, 1, 1] - harmonic * at[:, 2] / r
    rt = gradient[:, 1, 0] - (at[:, 1] + harmonic * at[:, 0]) / r
    return C[4, COSINE] @ np.stack([rr, tt, zz, rz]), C[5, SINE] @ np.stack([tz, rt])


def _quadrature(section: RollSection) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Gauss points r, z (p,) of the coil's cells and the area in m^2 that each stands for."""
    x, w = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    at, weight = [], []
    for borders in (section.radii[section.wall_cells :], section.heights):
        size = np.diff(borders)[:, None]
        at.append((borders[:-1, None] + 0.5 * size * (x + 1)).ravel())
        weight.append((0.5 * size * w).ravel())
    r, z = np.meshgrid(*at, indexing="ij")
    return r.ravel(), z.ravel(), np.outer(*weight).ravel()
