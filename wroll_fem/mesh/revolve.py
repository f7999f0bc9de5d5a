"""Surface of a body of revolution as biquadratic quads, and Fourier displacements on it."""

from __future__ import annotations

import numpy as np

from wroll_fem.typing import FloatArray, IntArray


def revolve(outline: FloatArray, around: int) -> tuple[FloatArray, IntArray]:
    """Revolve a closed outline of quadratic edges about the z axis.

    Parameters
    ----------
    outline
        (2 e, 2) nodes [r, z] once around the outline, m: end, midpoint, end, ...
    around
        Number of cells around the axis.

    Returns
    -------
    nodes : (2 e * 2 around, 3) Cartesian coordinates, m, one outline after the other from theta = 0.
    cells : (e * around, 9) in VTK_BIQUADRATIC_QUAD order.
    """
    per, stations = len(outline), 2 * around
    theta = station_angles(around)[:, None]
    r, z = outline.T
    nodes = np.stack(np.broadcast_arrays(r * np.cos(theta), r * np.sin(theta), z), axis=-1).reshape(-1, 3)
    along, turn = np.meshgrid(np.arange(0, per, 2), np.arange(0, stations, 2), indexing="ij")
    along, turn = along.ravel(), turn.ravel()

    def at(a: int, b: int) -> IntArray:
        return np.asarray(((turn + b) % stations) * per + (along + a) % per, np.int64)

    order = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
    return nodes, np.column_stack([at(a, b) for a, b in order])


def station_angles(around: int) -> FloatArray:
    """(2 around,) angles theta of the copies of the outline in `revolve`, rad."""
    return np.asarray(np.pi * np.arange(2 * around) / around)


def cartesian(values: FloatArray, wave_number: int, around: int, rotated: bool = False) -> FloatArray:
    """Cartesian displacement of a Fourier mode on the revolved nodes.

    Parameters
    ----------
    values
        (n, 3) displacement amplitudes [U, V, W] on the outline.
    wave_number
        Wave number m: u_r = U cos m theta, u_theta = V sin m theta (V itself for m = 0), u_z = W cos m theta.
    around
        Number of cells around the axis, as in `revolve`.
    rotated
        Take the other mode of the degenerate pair, rotated about the axis by pi / (2 m).

    Returns
    -------
    (n * 2 around, 3) displacements [ux, uy, uz] in the unit of `values`.
    """
    theta = station_angles(around)[:, None]
    phase = wave_number * theta - (0.5 * np.pi if rotated else 0.0)
    cos_m = np.cos(phase)
    sin_m = np.sin(phase) if wave_number else np.ones_like(theta)
    radial, hoop, axial = values[:, 0] * cos_m, values[:, 1] * sin_m, values[:, 2] * cos_m
    x = radial * np.cos(theta) - hoop * np.sin(theta)
    y = radial * np.sin(theta) + hoop * np.cos(theta)
    return np.stack([x, y, axial], axis=-1).reshape(-1, 3)
