"""Shear stress of a solid coil in the bending modes of the Fourier model, at quadrature points around the axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.fem.fourier import COSINE, SINE
from wroll_fem.fem.fourier_modes import lowest_modes
from wroll_fem.fem.fourier_roll import FourierRoll
from wroll_fem.materials import CylindricalOrthotropic
from wroll_fem.shear import ShearModes

if TYPE_CHECKING:
    from wroll_fem.case import Case
    from wroll_fem.fem.fourier import FourierModel

FloatArray = npt.NDArray[np.float64]

GAUSS_POINTS = 3
"""Per direction and cell: where the stress of cubic cells is most accurate."""


def shear_modes(case: Case) -> ShearModes:
    """Modes along the excitation among the lowest `modal.count` of the roll, with their shear stress in the coil.

    Only the modes of harmonic 1 answer a lateral base motion, and of each pair only the one along the excitation: the
    others are left out. There are 2 x `mesh.circumferential` stations around the axis, of which four lie on the
    excitation's axis and its normal.

    Raises
    ------
    InputError
        If the case has no solid coil.
    """
    if case.coil.model != "solid":
        raise InputError("the shear stress is that of a solid coil", key="coil.model", remedy="use coil.model: solid")
    roll = FourierRoll(case)
    modes = [mode for mode in lowest_modes(roll, case.modal.count) if mode.family.harmonic == 1]
    turn = 0.5 * np.pi if case.excitation.direction == "y" else 0.0
    section = roll.model.section
    grid, weights = _gauss_grid()
    r, z = np.moveaxis(roll.model.positions(grid)[section.wall_cells :], -1, 0)
    size = np.diff(section.radii)[section.wall_cells :, None, None] * np.diff(section.heights)[None, :, None]
    stations = 4 * -(-case.mesh.circumferential // 2)
    theta = np.pi * (2 * (np.arange(stations) + 1) / stations - 1)
    volume = (weights * size * r).ravel() * (2 * np.pi / stations)
    fields = [section_shear(roll.model, mode.values, case.coil.material.solid(), 1, grid) for mode in modes]
    cosine, sine = np.cos(theta - turn), np.sin(theta - turn)
    return ShearModes(
        frequencies_hz=np.array([mode.frequency_hz for mode in modes]),
        participation=np.array([mode.participation for mode in modes]),
        tip=np.array([mode.tip for mode in modes]),
        points=np.stack(
            [np.repeat(theta, r.size), np.tile(z.ravel(), stations), np.tile(r.ravel(), stations)], axis=-1
        ),
        volumes=np.tile(volume, stations),
        srz=np.array([np.outer(cosine, srz.ravel()).ravel() for srz, _ in fields]).reshape(len(modes), -1),
        srt=np.array([np.outer(sine, srt.ravel()).ravel() for _, srt in fields]).reshape(len(modes), -1),
        mass_total=roll.mass_total,
        kinds=tuple(mode.kind for mode in modes),
    )


def section_shear(
    model: FourierModel, values: FloatArray, material: CylindricalOrthotropic, harmonic: int, points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Amplitudes of srz (cos m theta) and srt (sin m theta) in the coil's cells, Pa.

    Parameters
    ----------
    values
        (n_nodes, 3) nodal [U, V, W], m.
    points
        (q, 2) reference points of each cell.

    Returns
    -------
    srz, srt : (n_r of the coil, n_z, q)
    """
    first = model.section.wall_cells
    at, gradient = (field[first:] for field in model.evaluate(values, points))
    r = model.positions(points)[first:, ..., 0]
    C = material.stiffness()
    rr, zz = gradient[..., 0, 0], gradient[..., 2, 1]
    tt = (at[..., 0] + harmonic * at[..., 1]) / r
    rz = gradient[..., 0, 1] + gradient[..., 2, 0]
    tz = gradient[..., 1, 1] - harmonic * at[..., 2] / r
    rt = gradient[..., 1, 0] - (at[..., 1] + harmonic * at[..., 0]) / r
    srz = np.tensordot(C[4, COSINE], np.stack([rr, tt, zz, rz]), axes=1)
    srt = np.tensordot(C[5, SINE], np.stack([tz, rt]), axes=1)
    return srz, srt


def _gauss_grid() -> tuple[FloatArray, FloatArray]:
    """Points (q, 2) and weights (q,) on the unit square."""
    x, w = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    x, w = 0.5 * (x + 1), 0.5 * w
    a, b = np.meshgrid(x, x, indexing="ij")
    return np.column_stack([a.ravel(), b.ravel()]), np.outer(w, w).ravel()
