r"""Symmetry of motions whose second half period mirrors the first.

Let a roll be unchanged by a symmetry operation S: half a turn, or the reflection in the plane normal to the motion of
its base. Excited along one direction, it has motions with :math:`u(t + T/2) = S\,u(t)`. Circumferential harmonics
whose sign is reversed by S then have odd harmonics in time only; the others have the mean and the even harmonics. This
halves the number of unknowns. Of each pair of contact points that S maps onto each other, one is evaluated.

The symmetry is not assumed: `HalfPeriod.of` checks it on the profiles of all modes, on the laws and on the preload. One
choice is made. Where slip ceases after the first periods (shakedown), the residual tractions depend on how the motion
began. Here the motions of the two points of a pair begin half a period apart, as in a motion that grows slowly. Points
in the plane of the mirror are their own partners and have no such residual tractions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.contact.laws import SHARED, PointLaws
from wroll_fem.contact.point import HOOP, contact_dofs, normals, tangentials
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.typing import BoolArray, FloatArray, IntArray

SAME = 1e-7
"""Relative tolerance of the symmetry check: values at two points that the symmetry operation maps onto each other count
as equal if they differ by at most this fraction of the largest value at any point."""


@dataclass(frozen=True)
class HalfPeriod:
    """Effect of a shift by half a period on modes and contact points.

    Attributes
    ----------
    odd : (r,) whether a mode of the condensation changes its sign
    first : (k,) indices of the evaluated points, one of each pair
    weight : (k,) number of points that each evaluated point represents, 1 or 2
    source : (n,) for each point, the index among the k evaluated points of the one that represents it
    mirrored : (n,) whether a point moves as its source does half a period later
    signs : (3,) signs of the hoop, axial and normal components of a mirrored point relative to its source
    """

    odd: BoolArray
    first: IntArray
    weight: FloatArray
    source: IntArray
    mirrored: BoolArray
    signs: FloatArray

    @classmethod
    def of(cls, condensation: Condensation, preload: ContactState, laws: PointLaws) -> HalfPeriod | None:
        """Half-period symmetry of a structure; None if it has none."""
        c, n_theta = condensation, condensation.n_theta
        if n_theta < 2 or laws.n == 0:
            return None
        index = np.arange(n_theta)
        maps = [(index[::-1], -1.0)]  # mirrored: the hoop component is reversed
        if n_theta % 2 == 0:
            maps.append(((index + n_theta // 2) % n_theta, 1.0))
        for around, hoop in maps:
            parity = _parity(c.profiles, around, hoop)
            if parity is None:
                continue
            odd = np.repeat(parity, np.diff(c.blocks))
            if np.abs(c.base[~odd]).max(initial=0.0) > SAME * np.abs(c.base).max(initial=1e-300):
                continue
            partner = (n_theta * np.arange(laws.n // n_theta)[:, None] + around).ravel()
            if not _alike(partner, hoop, preload, laws, c.springs):
                continue
            first = np.flatnonzero(partner >= np.arange(laws.n))
            source = np.full(laws.n, -1)
            source[partner[first]] = source[first] = np.arange(len(first))
            mirrored = partner < np.arange(laws.n)
            weight = np.where(partner[first] == first, 1.0, 2.0)
            return cls(odd, first, weight, source, mirrored, np.array([hoop, 1.0, 1.0]))
        return None

    def parts(self, vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Split modal ``vectors`` (r, k) into the modes whose motion changes sign after half a period, and the rest."""
        odd = np.where(self.odd[:, None], vectors, 0.0)
        return odd, vectors - odd

    def spread(self, coefficients: FloatArray, orders: FloatArray) -> FloatArray:
        """(3 n, R) Fourier coefficients at all n contact points, by symmetry from those at the evaluated points.

        ``coefficients`` (3 k, R) are those of a traction or relative displacement at the k evaluated points.

        ``orders`` (R,) is the harmonic number of each coefficient. At a point that is its own mirror image only the
        symmetric part is kept; the rest is residual traction from the start of the motion.
        """
        n, k = len(self.source), len(self.first)
        later = np.where(orders % 2 == 1, -1.0, 1.0)
        out = coefficients[contact_dofs(k)[self.source]]  # (n, 3, R)
        mirror = self.signs[:, None] * later  # (3, R)
        out[self.mirrored] *= mirror
        out[self.weight[self.source] == 1.0] *= 0.5 * (1.0 + mirror)  # points that are their own mirror image
        whole = np.empty((3 * n, coefficients.shape[1]))
        whole[contact_dofs(n)] = out
        return whole

    def reversed_ones(self, vectors: FloatArray) -> BoolArray:
        """(m,) for each of the modal ``vectors`` (r, m), whether its motion changes sign after half a period."""
        return np.asarray(np.einsum("rm,rm->m", vectors[self.odd], vectors[self.odd]) > 0.5)


def _parity(profiles: FloatArray, around: IntArray, hoop: float) -> BoolArray | None:
    """(n_blocks,) whether the symmetry operation reverses the sign of each circumferential block.

    None if the operation neither keeps nor reverses a block. ``profiles`` (n_blocks, n_waves, 3, n_theta).
    """
    mapped = profiles[..., around].copy()
    mapped[:, :, HOOP] *= hoop
    of_block = (1, 2, 3)
    size = np.abs(profiles).max(axis=of_block)
    kept = np.abs(mapped - profiles).max(axis=of_block) <= SAME * size
    reverses = np.abs(mapped + profiles).max(axis=of_block) <= SAME * size
    return reverses & ~kept if np.all(kept | reverses) else None


def _alike(partner: IntArray, hoop: float, preload: ContactState, laws: PointLaws, springs: FloatArray) -> bool:
    """Whether each contact point and its ``partner`` have the same laws, contact springs and preload."""
    for name in laws._fields:
        if name not in SHARED and not _same(getattr(laws, name), getattr(laws, name)[partner]):
            return False
    turned = np.array([hoop, 1.0])
    # the elastic slip has no normal component: one is appended so that all arrays have the same order
    slip = np.concatenate([preload.elastic_slip, np.zeros(laws.n)])
    for values, signs in ((preload.jump, turned), (preload.traction, turned), (slip, turned), (springs, np.ones(2))):
        along, across = tangentials(values), normals(values)
        if not (_same(along, signs * along[partner]) and _same(across, across[partner])):
            return False
    return True


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    if a.dtype.kind != "f":
        return bool(np.array_equal(a, b))
    return bool(np.abs(a - b).max(initial=0.0) <= SAME * np.abs(a).max(initial=0.0))
