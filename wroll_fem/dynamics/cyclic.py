r"""Circumferential harmonics: the invariant subspaces of a roll with rotational symmetry.

A roll meshed with C equal sectors maps onto itself under a rotation by 2 pi / C. In cylindrical components
(r, theta, z) its matrices then couple a harmonic :math:`\cos h\theta, \sin h\theta` of the nodes of one ring
only to the same harmonic of other rings: K and M fall into about C/2 small blocks (twice that without a
symmetry plane), and so does the interface compliance. Nothing is neglected; whoever uses the blocks checks
first that they do not couple (`condensation`), and a mesh without the symmetry simply has none.

Parity "even" holds motions symmetric about the x-z plane (u_r, u_z, r_theta as cosines; u_theta, r_r, r_z as sines),
"odd" the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..body import Body, FloatArray

EVEN_COSINE = np.array([True, False, True, False, True, False])
"""Components (u_r, u_theta, u_z, r_r, r_theta, r_z) that are cosines in an even motion."""


@dataclass(frozen=True)
class Subspace:
    """Motions of one harmonic and parity.

    Attributes
    ----------
    harmonic, even
        Number of waves around, and parity about the x-z plane.
    basis
        (n_dofs, k) sparse; all subspaces together span all motions.
    """

    harmonic: int
    even: bool
    basis: sp.csc_matrix

    def profile(self, theta: FloatArray) -> FloatArray:
        """(3, n) values of the hoop, axial and normal components around the circumference."""
        cosine, sine = np.cos(self.harmonic * theta), np.sin(self.harmonic * theta)
        return np.array([sine, cosine, cosine] if self.even else [cosine, sine, sine])


def cyclic_subspaces(bodies: Sequence[Body]) -> tuple[Subspace, ...]:
    """Harmonic subspaces of stacked bodies, or an empty tuple when their meshes have no common rotational symmetry."""
    columns: dict[tuple[int, bool], list[tuple[FloatArray, FloatArray, FloatArray]]] = {}
    start = 0
    sectors = {_sector_count(body) for body in bodies}
    if len(sectors) != 1 or None in sectors:
        return ()
    (count,) = sectors
    for body in bodies:
        _body_columns(body, int(count), start, columns)  # type: ignore[arg-type]
        start += body.n_dofs
    subspaces = []
    for (harmonic, even), parts in sorted(columns.items()):
        width = np.concatenate([np.full(len(p[0]), i) for i, p in enumerate(parts)])
        rows, values = np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
        basis = sp.csc_matrix((values, (rows, width)), shape=(start, len(parts)))
        subspaces.append(Subspace(harmonic, even, basis))
    if sum(s.basis.shape[1] for s in subspaces) != start:
        return ()
    return tuple(subspaces)


def _rings(body: Body) -> list[np.ndarray] | None:
    """Node numbers of each ring, by angle from 0 to 2 pi; None when rings differ in size or are not even."""
    x, y, z = body.nodes.T
    theta = np.mod(np.arctan2(y, x), 2 * np.pi)
    theta[theta > 2 * np.pi - 1e-6] = 0.0
    size = np.ptp(z)
    order = np.argsort(z, kind="stable")
    level = np.empty(len(z), np.int64)
    level[order] = np.cumsum(np.diff(z[order], prepend=z.min()) > 1e-7 * size)
    order = np.lexsort((theta, level))
    counts = np.bincount(level)
    if np.ptp(counts) or counts[0] % 4:
        return None
    rings = order.reshape(-1, counts[0])
    expected = 2 * np.pi * np.arange(counts[0]) / counts[0]
    if np.abs(theta[rings] - expected).max() > 1e-6 or np.ptp(np.hypot(x, y)) > 1e-6 * size:
        return None
    return list(rings)


def _sector_count(body: Body) -> int | None:
    if body.unknown_node is None or body.unknown_component is None:
        return None
    rings = _rings(body)
    return None if rings is None else len(rings[0]) // 2


def _body_columns(
    body: Body,
    sectors: int,
    start: int,
    columns: dict[tuple[int, bool], list[tuple[FloatArray, FloatArray, FloatArray]]],
) -> None:
    """Add this body's harmonic motions, orbit by orbit (quadratic quads have two nodes per sector and ring)."""
    rows_of = np.full((len(body.nodes), 6), -1)
    own = body.unknown_node >= 0  # type: ignore[operator]
    rows_of[body.unknown_node[own], body.unknown_component[own]] = np.flatnonzero(own)  # type: ignore[index]
    parities = (True,) if body.symmetric else (True, False)
    for ring in _rings(body) or []:
        for offset in (0, 1):
            orbit = ring[offset::2]
            if np.all(rows_of[orbit] < 0):
                continue
            theta = np.arctan2(body.nodes[orbit, 1], body.nodes[orbit, 0])
            for even in parities:
                for harmonic in range(sectors // 2 + 1):
                    for c in range(6):
                        cosine = EVEN_COSINE[c] == even
                        wave = np.cos(harmonic * theta) if cosine else np.sin(harmonic * theta)
                        if np.abs(wave).max() > 1e-9:
                            _append(columns, (harmonic, even), rows_of[orbit], c, theta, wave, start)
    for row in np.flatnonzero(~own):
        component = int(body.unknown_component[row])  # type: ignore[index]
        harmonic = 0 if component in (2, 5) else 1
        key = (harmonic, component in (0, 2, 4))
        columns.setdefault(key, []).append((np.array([start + row]), np.ones(1), theta[:1]))


def _append(columns, key, rows, component, theta, wave, start):  # type: ignore[no-untyped-def]
    """One cylindrical component of one orbit as a column over the Cartesian unknowns."""
    first = 3 * (component // 3)
    axes = {0: (np.cos(theta), np.sin(theta)), 1: (-np.sin(theta), np.cos(theta))}
    if component % 3 == 2:
        picks = [(first + 2, wave)]
    else:
        along = axes[component % 3]
        picks = [(first, wave * along[0]), (first + 1, wave * along[1])]
    index = np.concatenate([rows[:, c] for c, _ in picks])
    value = np.concatenate([v for _, v in picks])
    keep = (index >= 0) & (np.abs(value) > 1e-14)
    columns.setdefault(key, []).append((start + index[keep], value[keep], theta))
