"""Skin of a body of revolution as biquadratic quads, with the displacements of a harmonic on it. FEM-free."""

from __future__ import annotations

import numpy as np

from wroll_fem.typing import FloatArray, IntArray


def revolve(outline: FloatArray, around: int) -> tuple[FloatArray, IntArray]:
    """Revolve a closed outline of quadratic edges.

    Parameters
    ----------
    outline
        (2 e, 2) nodes [r, z] once around: corner, middle, corner, ...
    around
        Cells around the axis.

    Returns
    -------
    nodes : (2 e * 2 around, 3) Cartesian, station after station from theta = 0.
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
    """(2 around,) angles of the stations of `revolve`, rad."""
    return np.asarray(np.pi * np.arange(2 * around) / around)


def cartesian(values: FloatArray, harmonic: int, around: int, turned: bool = False) -> FloatArray:
    """Displacement of a harmonic on the revolved nodes.

    Parameters
    ----------
    values
        (n, 3) amplitudes [U, V, W] on the outline.
    harmonic
        m: u_r = U cos m theta, u_theta = V sin m theta (V itself for m = 0), u_z = W cos m theta.
    around
        As in `revolve`.
    turned
        The twin, turned about the axis by pi / (2 m).

    Returns
    -------
    (n * 2 around, 3) [ux, uy, uz].
    """
    theta = station_angles(around)[:, None]
    phase = harmonic * theta - (0.5 * np.pi if turned else 0.0)
    cos_m = np.cos(phase)
    sin_m = np.sin(phase) if harmonic else np.ones_like(theta)
    radial, hoop, axial = values[:, 0] * cos_m, values[:, 1] * sin_m, values[:, 2] * cos_m
    x = radial * np.cos(theta) - hoop * np.sin(theta)
    y = radial * np.sin(theta) + hoop * np.cos(theta)
    return np.stack([x, y, axial], axis=-1).reshape(-1, 3)
