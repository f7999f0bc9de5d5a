"""Bases of reduced models for periodic motions: the first basis, its enrichment, and bases of given motions.

The first basis holds the modes that the base excites, static responses, and corrections (`correction`) of imposed
motions in the main mode, from the onset of slip to gross slip. It therefore contains shapes of slip before the first
curve is computed. With half-period symmetry (`half_period`) every vector is of one kind: half a period either reverses
its sign or leaves it unchanged.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg as la

from wroll_fem.dynamics.aft.half_period import HalfPeriod
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.dynamics.periodic.point_sample import Motions
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel, ritz_vectors
from wroll_fem.dynamics.training.correction import corrections
from wroll_fem.typing import FloatArray, IntArray

SMALL = 40
"""Largest number of modes of a structure that is not reduced."""

COMPRESSION = 0.2
"""Singular value, relative to the tolerance, below which a principal shape of the motions of a curve is dropped from
the next basis."""

REACH = 1.05
"""Frequency, relative to the highest harmonic of the motions, up to which modes are basis vectors."""

ROUNDING = 1e-9
"""Norm of a part of a vector, relative to the norm of the vector, below which the part counts as rounding error."""

START_MODES = 12
SLIP_LEVELS = (1.2, 1.6, 2.5, 5.0, 12.0, 40.0)
"""Amplitudes of the motions imposed for the first basis: largest relative displacement divided by gamma*."""
IMPOSED = 3e-3
"""Energy norm below which a principal shape is not added to the first basis. The shapes represent the corrections of
the imposed motions; each correction is divided by the energy norm of its motion."""


def first_model(
    condensation: Condensation, contact: Callable[[ReducedModel], HarmonicContact], symmetry: HalfPeriod | None
) -> ReducedModel:
    """First reduced model; its basis consists of modes, static responses, and shapes of slip under imposed motions.

    ``contact`` makes the periodic contact of a reduced model.
    """
    c = condensation
    count = len(c.eigenvalues)
    if count <= SMALL:
        return span(c, np.eye(count), symmetry) if symmetry else ReducedModel.complete(c)
    values = np.maximum(c.eigenvalues, 1e-6 * c.eigenvalues[c.eigenvalues > 0].min())
    leading = np.argsort(-np.abs(c.base * c.tip))[:START_MODES]
    modes = np.zeros((count, len(leading)))
    modes[leading, np.arange(len(leading))] = 1.0
    pushed = [part / values for force in c.forces for part in (force.cosine, force.sine)]
    model = span(c, np.column_stack([modes, c.base / values, c.tip / values, *pushed]), symmetry)
    rest = HarmonicBalance(contact(model), 0.0)
    if not rest.contact.n:
        return model
    shapes, imposed = [], imposed_motions(rest.contact)
    found = corrections(rest, imposed.coefficients, imposed.frequencies, tolerance=0.1 * IMPOSED)
    for q, one in zip(imposed.coefficients, found, strict=True):
        scale = float(np.linalg.norm(np.sqrt(np.maximum(model.eigenvalues, 0.0)) * q[1]))
        shapes.append(one.modal / scale)
    return with_shapes(model, np.column_stack(shapes), IMPOSED, symmetry)


def imposed_motions(contact: HarmonicContact) -> Motions:
    """Motions in the main mode, from the onset of slip to gross slip (`SLIP_LEVELS`)."""
    model, gamma = contact.model, contact.laws.gamma
    main = model.main_mode
    reach = float(np.max(np.abs(contact.jump[: 2 * contact.n, main]) / np.repeat(gamma, 2)))
    q = np.zeros((len(SLIP_LEVELS), contact.sampling.size, model.size))
    q[:, 1, main] = np.array(SLIP_LEVELS) / max(reach, 1e-300)
    frequency = 0.95 * float(np.sqrt(model.eigenvalues[main]))
    return Motions(q, np.full(len(q), frequency), model.vectors)


def span(condensation: Condensation, vectors: FloatArray, symmetry: HalfPeriod | None) -> ReducedModel:
    """Reduced model on the span of ``vectors`` (r, k).

    With symmetry, each vector is split into its two parts, and the basis of the reversed parts comes first.
    """
    if symmetry is None:
        return ReducedModel.of_vectors(condensation, vectors)
    size, found, values = np.linalg.norm(vectors, axis=0), [], []
    for part in symmetry.parts(vectors):
        kept = part[:, np.linalg.norm(part, axis=0) > ROUNDING * size]
        if kept.shape[1]:
            ritz, squares = ritz_vectors(condensation, kept)
            found.append(ritz)
            values.append(squares)
    return ReducedModel.on(condensation, np.column_stack(found), np.concatenate(values))


def with_shapes(model: ReducedModel, shapes: FloatArray, least: float, symmetry: HalfPeriod | None) -> ReducedModel:
    """Model whose basis also contains the principal shapes of ``shapes`` (r, k) with an energy norm above ``least``.

    The given shapes are corrections per unit energy norm of the motion.
    """
    values = model.condensation.eigenvalues
    root = np.sqrt(np.maximum(values, 1e-12 * values.max()))[:, None]
    kept = [_principal(root * part, least) / root for part in _parts(shapes, symmetry)]
    found = np.column_stack([model.vectors, *kept])
    return span(model.condensation, found, symmetry) if found.shape[1] > model.size else model


def principal_span(
    condensation: Condensation, motions: FloatArray, least: float, symmetry: HalfPeriod | None, *,
    modes: IntArray | None = None, means: FloatArray | None = None,
) -> ReducedModel:  # fmt: skip
    """Reduced model on the principal shapes of modal motions (p, R, r), and on some of the ``modes`` themselves.

    Each motion is scaled to unit energy norm; ``means`` (r, k) are further shapes in this scale. Principal shapes with
    a norm above ``least`` are kept. With modes, they are those of what is left without these modes.
    """
    values = condensation.eigenvalues
    modes = np.zeros(0, np.int64) if modes is None else modes
    root = np.sqrt(np.maximum(values, 1e-12 * values.max()))
    scaled = motions * root
    scaled /= np.linalg.norm(scaled, axis=(1, 2), keepdims=True)
    shapes = scaled.reshape(-1, len(values)).T  # (r, p R)
    shapes = shapes.copy() if means is None else np.column_stack([shapes, root[:, None] * means])
    shapes[modes] = 0.0
    own = np.zeros((len(values), len(modes)))
    own[modes, np.arange(len(modes))] = 1.0
    kept = [_principal(part, least) for part in _parts(shapes, symmetry)]
    return span(condensation, np.column_stack([own, *(part / root[:, None] for part in kept)]), symmetry)


def reached_modes(condensation: Condensation, motions: Motions, orders: FloatArray, least: float) -> IntArray:
    """Indices of the modes with frequencies up to the highest harmonic of ``motions`` in all modes.

    Harmonics meet these modes in internal resonances, where a small error of the force on a mode is a large error of
    its motion. Without the mode itself, moreover, a mixture of basis vectors takes its place, at another frequency. A
    mode counts if its largest energy norm in a motion, relative to it, exceeds ``least``. ``orders`` (R,) are the
    harmonic numbers of the coefficients.
    """
    values = condensation.eigenvalues
    scaled = motions.coefficients * np.sqrt(np.maximum(values, 0.0))
    scaled /= np.linalg.norm(scaled, axis=(1, 2), keepdims=True)
    highest = REACH * float(orders.max() * motions.frequencies.max())
    return np.flatnonzero((values < highest**2) & (np.linalg.norm(scaled, axis=1).max(axis=0) > least))


def with_snapshots(
    model: ReducedModel, snapshots: FloatArray, least: float, symmetry: HalfPeriod | None
) -> ReducedModel:
    """Model whose basis also contains the principal shapes of ``snapshots`` (r, k) above the energy norm ``least``.

    Every snapshot is scaled to unit energy norm.
    """
    c = model.condensation
    found = principal_span(c, snapshots.T[:, None, :], least, symmetry)
    return span(c, np.column_stack([model.vectors, found.vectors]), symmetry)


def _parts(shapes: FloatArray, symmetry: HalfPeriod | None) -> tuple[FloatArray, ...]:
    return (shapes,) if symmetry is None else symmetry.parts(shapes)


def _principal(shapes: FloatArray, least: float) -> FloatArray:
    """Left singular vectors (n, k) with singular values above ``least``."""
    rows = shapes.any(axis=1)
    if not rows.any():  # nothing of this kind moves
        return np.zeros((len(shapes), 0))
    if not rows.all():
        found = _principal(np.ascontiguousarray(shapes[np.ix_(rows, shapes.any(axis=0))]), least)
        out = np.zeros((len(shapes), found.shape[1]))
        out[rows] = found
        return out
    gram = shapes.T @ shapes if shapes.shape[1] < shapes.shape[0] else shapes @ shapes.T
    values, vectors = la.eigh(gram)
    kept = values > least**2
    if shapes.shape[1] < shapes.shape[0]:
        return np.asarray(shapes @ (vectors[:, kept] / np.sqrt(values[kept])))
    return np.asarray(vectors[:, kept])
