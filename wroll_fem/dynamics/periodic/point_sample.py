r"""Hyper-reduction: a weighted subset of the contact points gives the contact forces of a reduced model.

Where all points stick, the reduced model is linear and exact. Only the traction corrections s (`harmonic_contact`),
which vanish at sticking points, have to be sampled. Point k with area w_k contributes :math:`w_k (G_k \Phi)^T s_k` to
the generalised forces. Of given motions, the nonnegative factors :math:`\xi_k`, most of them zero, are such that

.. math:: \sum_k \xi_k w_k (G_k \Phi)^T s_k \approx \sum_k w_k (G_k \Phi)^T s_k

for every harmonic, and likewise for the work of the interfaces per cycle (energy-conserving sampling and weighting).
As the factors are nonnegative, a sampled interface is an interface with other areas: its friction dissipates, and its
tangent keeps its sign. Forces are divided by the energy norm of their motion and by the root of the energy of unit
coordinates, so that errors count as they change the motion.

References
----------
Farhat, Avery, Chapman, Cortial (2014), Int. J. Numer. Methods Eng. 98, 625, doi:10.1002/nme.4668.
Morsy, Kast, Tiso (2022), arXiv:2204.12160 (contact and friction in harmonic balance).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.periodic_contact import PeriodicContact
from wroll_fem.dynamics.reduction.evaluated_points import PointSample
from wroll_fem.numerics.nonnegative import sparse_nonnegative
from wroll_fem.typing import FloatArray

SAMPLE_TOLERANCE = 5e-3
"""Largest error of the sampled forces and works of the training motions, relative to those of all points."""

WORK, WORK_TOLERANCE = 5.0, 5e-4
"""Weight of the work of a motion among its forces, and largest error of each work, relative to the largest work. The
height of a resonance is inverse to the work: with the first tolerance alone it was off by up to 0.3 %."""

SKETCH = 1024
"""Number of random combinations (each equation with a random sign in one of them) that replace the equations of the
factors where there are more. They keep the norm of a residual to some ten percent."""

SEED = 1
"""Seed of these combinations: equal runs give equal results."""

NEGLIGIBLE = 1e-9
"""Contribution of a point, relative to the largest one, up to which the point is no candidate."""


class Motions(NamedTuple):
    """Periodic motions of a structure.

    Attributes
    ----------
    coefficients : (p, R, k) Fourier coefficients
    frequencies : (p,) rad/s
    vectors : (r, k) displacement per unit coefficient, in modal coordinates of the condensation; None if the
        coefficients are those of all modes, k = r
    """

    coefficients: FloatArray
    frequencies: FloatArray
    vectors: FloatArray | None

    def some(self, most: int) -> Motions:
        """At most so many of these motions, evenly spaced and with both ends."""
        kept = np.unique(np.linspace(0, len(self.frequencies) - 1, min(len(self.frequencies), most)).astype(int))
        return self._replace(coefficients=self.coefficients[kept], frequencies=self.frequencies[kept])


def contributions(contact: HarmonicContact, coefficients: FloatArray, frequency: float) -> FloatArray:
    """(n, k + 1) contributions of the n evaluated points to the k generalised forces and to the work of a motion.

    They are without unit; see the module. ``coefficients`` (R, m) are the motion at ``frequency``, rad/s.
    """
    root = np.sqrt(np.maximum(contact.model.eigenvalues, 0.0) + frequency**2)
    size = max(float(np.linalg.norm(coefficients * root)), 1e-300)
    state = contact.evaluate(contact.motion(coefficients), frequency)
    force = (contact.weights[:, None] * state.coefficients)[contact.dofs]  # (n, 3, R)
    jump, rows = contact.jump[contact.dofs] / (size * root), force.transpose(0, 2, 1)
    parts = [
        (np.ascontiguousarray(rows[:, own]) @ jump[:, :, columns]).reshape(contact.n, len(own) * len(columns))
        for own, columns in contact.groups
    ]
    return np.column_stack([*parts, works(contact, state) / size**2])


def works(contact: HarmonicContact, state: PeriodicContact) -> FloatArray:
    """(n,) work of the tractions at each evaluated point during a period, J."""
    power = contact.weights * np.einsum("ij,ij->i", state.correction, state.rate)
    return np.asarray(power[contact.dofs].sum(axis=1))


def sampled(
    contact: HarmonicContact, motions: Motions, tolerance: float = SAMPLE_TOLERANCE,
    work_tolerance: float = WORK_TOLERANCE,
) -> PointSample | None:  # fmt: skip
    """Subset of the points of ``contact`` that gives its forces and works in ``motions``; None if nothing slips.

    Harmonics of the motions beyond those of the contact are left out. For the tolerances see `SAMPLE_TOLERANCE` and
    `WORK_TOLERANCE`.
    """
    shift, size = contact.model.vectors, contact.sampling.size
    if motions.vectors is not None:
        shift = motions.vectors.T @ shift
    forces, of_work = [], []
    for motion, frequency in zip(motions.coefficients, motions.frequencies, strict=True):
        own = np.zeros((size, contact.model.size))
        own[: len(motion)] = motion[:size] @ shift
        found = contributions(contact, own, float(frequency))
        forces.append(found[:, :-1])
        of_work.append(WORK * found[:, -1])
    work = np.array(of_work)
    matrix = np.vstack([_sketch(forces), work])
    limits = np.full(len(matrix), np.inf)
    limits[-len(work) :] = work_tolerance * np.abs(work.sum(axis=1)).max()
    largest = np.linalg.norm(matrix, axis=0)
    candidates = np.flatnonzero(largest > NEGLIGIBLE * largest.max(initial=0.0))
    if not len(candidates):
        return None
    chosen = np.ascontiguousarray(matrix[:, candidates])
    factors = sparse_nonnegative(chosen, chosen.sum(axis=1), tolerance, limits)
    kept = np.flatnonzero(factors)
    return PointSample(candidates[kept], factors[kept])


def _sketch(equations: list[FloatArray]) -> FloatArray:
    """(e, n) equations of the n factors from the columns of arrays (n, k); random combinations if there are many."""
    if sum(found.shape[1] for found in equations) <= SKETCH:
        return np.column_stack(equations).T
    random, out = np.random.default_rng(SEED), np.zeros((SKETCH, len(equations[0])))
    for found in equations:
        count = found.shape[1]
        places, signs = random.integers(SKETCH, size=count), random.choice([-1.0, 1.0], size=count)
        out += sp.csr_matrix((signs, (np.arange(count), places)), (count, SKETCH)).T @ found.T
    return out


class SampleError(NamedTuple):
    """Errors of a subset of the contact points in motions; see `sample_error`.

    Attributes
    ----------
    points, of : number of points of the subset, and of all evaluated points
    force : error of the forces, relative to those of all points, as a norm over all motions
    work : largest error of the work of the interfaces per cycle, relative to the largest work
    motion : largest change of a motion when all points replace the subset, relative to it; both in the energy norm
    """

    points: int
    of: int
    force: float
    work: float
    motion: float

    def as_attrs(self) -> dict[str, float]:
        """Attributes of a result."""
        return {
            "sampled_points": self.points,
            "sampling_force_error": self.force,
            "sampling_work_error": self.work,
            "sampling_motion_error": self.motion,
        }


def sample_error(
    contact: HarmonicContact, sample: PointSample, coefficients: FloatArray, frequencies: FloatArray,
    completed: FloatArray, places: FloatArray,
) -> SampleError:  # fmt: skip
    """Errors of a subset in the motions ``coefficients`` (p, R, m) at ``frequencies`` (p,), rad/s.

    ``contact`` evaluates all points, and ``completed`` (p, R, m) at ``places`` (p,), rad/s, are the motions with all
    points.
    """
    wrong = whole = worst = largest = moved = 0.0
    for q, w, after in zip(coefficients, frequencies, completed, strict=True):
        parts = contributions(contact, q, float(w))
        every, some = parts.sum(axis=0), sample.factors @ parts[sample.points]
        wrong, whole = wrong + float(np.sum((some - every)[:-1] ** 2)), whole + float(np.sum(every[:-1] ** 2))
        worst, largest = max(worst, abs(float(some[-1] - every[-1]))), max(largest, abs(float(every[-1])))
        root = np.sqrt(np.maximum(contact.model.eigenvalues, 0.0) + w**2)
        moved = max(moved, float(np.linalg.norm((after - q) * root) / np.linalg.norm(q * root)))
    return SampleError(
        len(sample.points), contact.n, float(np.sqrt(wrong / max(whole, 1e-300))), worst / max(largest, 1e-300), moved
    )
