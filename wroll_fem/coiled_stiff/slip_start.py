r"""Load at which slip starts between the wraps of a coil: at the first point, and averaged over a length.

At an edge of the coil the shear stress is singular, :math:`\tau \sim \rho^{-\lambda}` with :math:`\lambda < 1`. The
load at which the first point of a mesh slides therefore falls with the size of the elements and has no limit but zero.
The mean of the stress over a region of fixed size has a limit. Here the region is a rectangle of height and depth l at
one angle (the depth at most that of the coil), at any place in the coil; it slips where the mean of the shear stress
reaches the mean of its friction limit. This is the line method of the theory of critical distances, for friction.

References
----------
D. Taylor (2007), The Theory of Critical Distances, Elsevier, chapter 2.
"""

from __future__ import annotations

import numpy as np

from wroll_fem.mesh.point_grid import CoilGrid
from wroll_fem.typing import FloatArray


def start_at_points(shear: FloatArray, limit: FloatArray, change: FloatArray | float = 0.0) -> FloatArray:
    """(n,) factor on a load, of either sign, at which each point slides; infinite without stress.

    Parameters
    ----------
    shear
        (n, 2) shear stress under the load, Pa.
    limit
        (n,) friction limit at rest, Pa.
    change
        (n,) change of this limit under the load, Pa.
    """
    rate = np.linalg.norm(shear, axis=-1) + np.abs(change)
    return np.divide(limit, rate, out=np.full(rate.shape, np.inf), where=rate > 0.0)


def averaged_start(
    grid: CoilGrid,
    volume: FloatArray,
    shear: FloatArray,
    limit: FloatArray,
    length: float,
    *,
    r: tuple[float, float],
    height: float,
    change: FloatArray | float = 0.0,
) -> float:
    """Smallest factor on a load at which the mean stress over a rectangle reaches the mean friction limit.

    Parameters
    ----------
    grid
        Grid of the points.
    volume
        (n,) volume of each point, m^3.
    shear, limit, change
        See `start_at_points`.
    length
        Height and depth of the rectangle, m; at most those of the coil.
    r, height
        Inner and outer radius, and height, of the coil, m.
    """
    volume = volume[grid.numbers]
    share = [np.append(0.0, np.cumsum(volume.sum(axis=others))) / volume.sum() for others in ((1, 2), (0, 2))]
    radius = np.sqrt(r[0] ** 2 + share[0] * (r[1] ** 2 - r[0] ** 2))
    inside = [_rectangles(faces, length) for faces in (radius, height * share[1])]

    def mean(values: FloatArray) -> FloatArray:
        """Mean over each rectangle (n_r', n_z', n_theta) of ``values`` at the points."""
        weighted = np.broadcast_to(values, limit.shape)[grid.numbers] * volume
        return np.asarray(np.einsum("ai,bj,ijt->abt", *inside, weighted))  # the volumes cancel in the ratio

    components = np.stack([mean(shear[:, number]) for number in (0, 1)], axis=-1)
    return float(start_at_points(components, mean(limit), mean(np.asarray(change))).min())


def _rectangles(faces: FloatArray, length: float) -> FloatArray:
    """(m, n) share of each of n cells in intervals of a ``length`` that begin, or end, at one of the ``faces``."""
    length = min(length, float(faces[-1] - faces[0]))
    first = np.clip(np.concatenate([faces[:-1], faces[1:] - length]), faces[0], faces[-1] - length)
    overlap = np.minimum(first[:, None] + length, faces[1:]) - np.maximum(first[:, None], faces[:-1])
    return np.asarray(np.maximum(overlap, 0.0) / np.diff(faces))
