"""Probes: displacement of a point of a shell in one direction, as a row vector times the degrees of freedom."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from wroll_fem.bodies.body import Body
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

Direction = Literal["x", "y", "z", "radial", "hoop"]
DIRECTIONS: tuple[str, ...] = get_args(Direction)

_ORDER = ((0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (1, 2), (2, 1), (0, 2), (2, 2))
"""Indices (along, across) of the 1D shape functions of each node; 0: first end, 1: second end, 2: middle."""

_ITERATIONS = 20
_ON_CELL = 1e-6
"""Largest accepted distance of a point outside its cell, in reference coordinates."""


@dataclass(frozen=True)
class Probe:
    """Point on the mid-surface of a shell and direction of the displacement.

    Attributes
    ----------
    theta, z
        Angle from the x axis, rad, and height above the base, m.
    direction
        x, y, z (axial), radial (outward) or hoop (towards growing theta).
    body
        Name of the shell: mandrel, layer_01, ...
    """

    theta: float
    z: float
    direction: Direction = "x"
    body: str = "mandrel"


def probe_row(body: Body, probe: Probe) -> FloatArray:
    """Row (n_dofs,) that gives the displacement at the probe, m, from the degrees of freedom of a body.

    The displacement is interpolated with the shape functions of the body, so the row is exact between nodes as well.

    Raises
    ------
    InputError
        If the point is not on the body.
    """
    cell, local = _locate(body, probe)
    weights = shape_functions(local)
    row = np.zeros(body.n_dofs)
    for node, weight in zip(body.cells[cell], weights, strict=True):
        for component, share in enumerate(unit_vector(probe)):
            if share != 0.0:
                row += weight * share * np.asarray(body.expand[6 * node + component].todense()).ravel()
    return row


def unit_vector(probe: Probe) -> FloatArray:
    """Cartesian components (3,) of the probe's direction."""
    c, s = np.cos(probe.theta), np.sin(probe.theta)
    vectors = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "radial": (c, s, 0), "hoop": (-s, c, 0)}
    return np.array(vectors[probe.direction], float)


def shape_functions(local: FloatArray) -> FloatArray:
    """Values (9,) of the biquadratic shape functions at reference coordinates (2,) in [-1, 1].

    The order is that of VTK_BIQUADRATIC_QUAD: corners, midpoints of the edges, centre.
    """
    along, across = (np.array([x * (x - 1) / 2, x * (x + 1) / 2, 1 - x * x]) for x in local)
    return np.array([along[i] * across[j] for i, j in _ORDER])


def _slopes(local: FloatArray) -> FloatArray:
    """Derivatives (9, 2) of the biquadratic shape functions with respect to the reference coordinates."""
    along, across = (np.array([x * (x - 1) / 2, x * (x + 1) / 2, 1 - x * x]) for x in local)
    d_along, d_across = (np.array([x - 0.5, x + 0.5, -2 * x]) for x in local)
    return np.array([(d_along[i] * across[j], along[i] * d_across[j]) for i, j in _ORDER])


def _locate(body: Body, probe: Probe) -> tuple[int, FloatArray]:
    """Index of the cell that contains the probe, and reference coordinates (2,) of the probe in this cell."""
    nodes = body.nodes
    low, high = float(nodes[:, 2].min()), float(nodes[:, 2].max())
    length = high - low
    if not low - _ON_CELL * length <= probe.z <= high + _ON_CELL * length:
        remedy = f"give a height between {low:g} and {high:g} m"
        raise InputError(f"height {probe.z:g} m is outside {body.name}", key="z", remedy=remedy)
    turned = np.angle(np.exp(1j * (np.arctan2(nodes[:, 1], nodes[:, 0]) - probe.theta)))  # 0 at the probe
    height = (nodes[:, 2] - probe.z) / length
    corners = body.cells[:, :4]
    spread = np.ptp(turned[corners], axis=1) < np.pi  # not the cells opposite, whose angles jump by 2 pi
    close = spread & (np.abs(turned[corners]).min(axis=1) <= np.ptp(turned[corners], axis=1) + _ON_CELL)
    close &= (height[corners].min(axis=1) <= _ON_CELL) & (height[corners].max(axis=1) >= -_ON_CELL)
    best: tuple[float, int, FloatArray] | None = None
    for cell in np.flatnonzero(close):
        own = body.cells[cell]
        local = _invert(np.column_stack([turned[own], height[own]]))
        outside = float(np.abs(local).max()) - 1.0
        if best is None or outside < best[0]:
            best = (outside, int(cell), local)
    if best is None or best[0] > _ON_CELL:
        raise InputError(
            f"no element of {body.name} contains this point",
            key="theta",
            remedy="give theta and z of a point on the shell",
        )
    return best[1], np.clip(best[2], -1.0, 1.0)


def _invert(places: FloatArray) -> FloatArray:
    """Reference coordinates (2,) at which the position interpolated from nodal ``places`` (9, 2) is zero (Newton)."""
    local = np.zeros(2)
    for _ in range(_ITERATIONS):
        change = np.linalg.solve(places.T @ _slopes(local), -places.T @ shape_functions(local))
        local = local + change
        if np.abs(change).max() < 1e-12:
            break
    return local
