r"""Circumferential harmonics: the invariant subspaces of a roll with rotational symmetry.

A roll meshed with C equal sectors maps onto itself under a rotation by 2 pi / C. In cylindrical components
(r, theta, z) its matrices then couple a circumferential harmonic :math:`\cos h\theta, \sin h\theta` of the nodes of
one ring only to the same harmonic of other rings. K and M, and the interface compliance, fall into about C/2 small
blocks. Nothing is neglected: the blocks are tested to be uncoupled before they are used (`cyclic_blocks`). A mesh
without the symmetry has no subspaces.

Motions of even parity are symmetric about the x-z plane (u_r, u_z, r_theta as cosines; u_theta, r_r, r_z as sines).
The other motions have odd parity. In a roll with this symmetry plane the parities are uncoupled as well, so that the
blocks are half as large and twice as many.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Body
from wroll_fem.bodies.levels import levels
from wroll_fem.typing import FloatArray

_Entries = tuple[np.ndarray, np.ndarray, FloatArray]
"""Column labels, row indices and values of entries of a basis."""

_Columns = dict[tuple[int, bool], list[_Entries]]

EVEN_COSINE = np.array([True, False, True, False, True, False])
"""Whether each of the components (u_r, u_theta, u_z, r_r, r_theta, r_z) is a cosine in a motion of even parity."""


@dataclass(frozen=True)
class Subspace:
    """Invariant subspace: motions of one circumferential harmonic and one parity.

    Attributes
    ----------
    harmonic, even
        Circumferential wave number, and whether the parity about the x-z plane is even.
    basis
        (n_dofs, k) sparse basis; all subspaces together span all motions.
    """

    harmonic: int
    even: bool
    basis: sp.csc_matrix

    def profile(self, theta: FloatArray) -> FloatArray:
        """(3, n) circumferential variation of hoop, axial and normal components at the angles ``theta`` (n,), rad."""
        cosine, sine = np.cos(self.harmonic * theta), np.sin(self.harmonic * theta)
        return np.array([sine, cosine, cosine] if self.even else [cosine, sine, sine])


def cyclic_subspaces(bodies: Sequence[Body]) -> tuple[Subspace, ...]:
    """Invariant subspaces of stacked bodies; empty if their meshes have no common rotational symmetry."""
    rings = [_rings(body) for body in bodies]
    if not bodies or any(r is None for r in rings) or len({r.shape[1] for r in rings if r is not None}) != 1:
        return ()
    columns: _Columns = {}
    start = label = 0
    for body, of_body in zip(bodies, rings, strict=True):
        label = _body_columns(body, of_body, start, label, columns)  # type: ignore[arg-type]
        start += body.n_dofs
    subspaces = []
    for (harmonic, even), parts in sorted(columns.items()):
        labels, rows, values = (np.concatenate(part) for part in zip(*parts, strict=True))
        names, width = np.unique(labels, return_inverse=True)
        basis = sp.csc_matrix((values, (rows, width)), shape=(start, len(names)))
        subspaces.append(Subspace(harmonic, even, basis))
    if sum(s.basis.shape[1] for s in subspaces) != start:
        return ()
    return tuple(subspaces)


def _rings(body: Body) -> np.ndarray | None:
    """(n_rings, nodes per ring) node numbers, ordered by angle from 0 to 2 pi; None without rotational symmetry.

    The rings need equal numbers of nodes and equal spacing of the nodes. A shell has one ring at each height, a solid
    has one at each height and radius.
    """
    if body.unknown_node is None or body.unknown_component is None:
        return None
    x, y, z = body.places.T
    theta = np.mod(np.arctan2(y, x), 2 * np.pi)
    theta[theta > 2 * np.pi - 1e-6] = 0.0
    radius = np.hypot(x, y)
    size = max(np.ptp(z), np.ptp(radius))
    heights, height = levels(z)
    radii, distance = levels(radius, 1e-6 * size)
    level = height + len(heights) * distance
    order = np.lexsort((theta, level))
    counts = np.bincount(level, minlength=len(heights) * len(radii))
    if np.ptp(counts) or counts[0] % 4:
        return None
    rings = order.reshape(-1, counts[0])
    expected = 2 * np.pi * np.arange(counts[0]) / counts[0]
    if np.abs(theta[rings] - expected).max() > 1e-6 or (body.solid is None and len(radii) > 1):
        return None
    return rings


def _body_columns(body: Body, rings: np.ndarray, start: int, label: int, columns: _Columns) -> int:
    """Add the basis vectors of one body to ``columns``, by wave number and parity; returns the next free column label.

    Each column has a label for ring, orbit and component. An orbit consists of the nodes of a ring that a rotation by
    whole sectors maps onto each other. Quadratic quads have two nodes per sector and ring, so the nodes of a ring form
    two orbits.
    """
    unknown_node, unknown_component = np.asarray(body.unknown_node), np.asarray(body.unknown_component)
    row_of = np.full((len(body.places), 6), -1)
    own = unknown_node >= 0
    row_of[unknown_node[own], unknown_component[own]] = start + np.flatnonzero(own)
    sectors = rings.shape[1] // 2
    ring_label = label + 12 * np.arange(len(rings))
    for offset in (0, 1):
        orbits = rings[:, offset::2]
        free = (row_of[orbits] >= 0).any(axis=(1, 2))
        theta = np.arctan2(body.places[orbits[free], 1], body.places[orbits[free], 0])
        rows, first_label = row_of[orbits[free]], ring_label[free, None] + 6 * offset
        for even in (True,) if body.symmetric else (True, False):
            for harmonic in range(sectors // 2 + 1):
                parts = columns.setdefault((harmonic, even), [])
                for c in range(6):
                    wave = np.cos(harmonic * theta) if EVEN_COSINE[c] == even else np.sin(harmonic * theta)
                    if np.abs(wave).max(initial=0.0) > 1e-9:
                        parts += _entries(rows, c, theta, wave, first_label + c)
    next_label = label + 12 * len(rings)
    for row in np.flatnonzero(~own):
        component = int(unknown_component[row])
        key = (0 if component in (2, 5) else 1, component in (0, 2, 4))
        columns.setdefault(key, []).append((np.array([next_label + row]), np.array([start + row]), np.ones(1)))
    return next_label + body.n_dofs


def _entries(
    rows: np.ndarray, component: int, theta: FloatArray, wave: FloatArray, label: np.ndarray
) -> list[_Entries]:
    """Basis entries of one cylindrical component with the values ``wave`` (n_rings, nodes) around the circumference.

    ``rows`` (n_rings, nodes, 6) are the indices of the Cartesian unknowns; -1 marks a missing unknown.
    """
    first = 3 * (component // 3)
    along = [(0, np.cos(theta)), (1, np.sin(theta))], [(0, -np.sin(theta)), (1, np.cos(theta))], [(2, np.ones(1))]
    entries = []
    for axis, share in along[component % 3]:
        index, value = rows[:, :, first + axis], wave * share
        keep = (index >= 0) & (np.abs(value) > 1e-14)
        entries.append((np.broadcast_to(label, index.shape)[keep], index[keep], value[keep]))
    return entries
