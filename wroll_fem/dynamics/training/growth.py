"""Growth of a basis during a training: shapes of corrections and of motions in time join it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from wroll_fem.dynamics.periodic.point_sample import Motions
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.training.basis import (
    COMPRESSION,
    principal_span,
    reached_modes,
    with_shapes,
    with_snapshots,
)
from wroll_fem.dynamics.training.correction import Correction
from wroll_fem.dynamics.training.full_motions import LINEAR, POINT_ROUNDS, modal, scaled_means
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.dynamics.training.training import TRAINING_HARMONICS, Curve, Task, Training
from wroll_fem.typing import FloatArray

POINT_SHARE = 0.5
"""Correction of a motion, relative to the tolerance, from which on the motion is corrected and the basis enriched."""

OPEN_TOLERANCE, SNAPSHOT_SHARE = 5e-3, 2.0
"""Smallest tolerance where interfaces open widely: a smaller one asks for hundreds of basis vectors, and neglected
harmonics weigh as much. Energy norm, relative to it, above which a principal shape of motions in time is added."""


def enriched(
    structure: Structure,
    training: Training,
    points: Curve,
    found: list[Correction],
    task: Task[Curve],
    *,
    around: Curve | None,
    used: Collection[int] = (),
) -> ReducedModel:
    """Reduced model with a basis enriched until the motions at ``points`` need only small corrections.

    ``found`` are the corrections of these motions in the present basis. The shapes of large corrections are added to
    the basis and the motions are recomputed, up to `POINT_ROUNDS` times. If the curve ``around`` the points is given,
    another basis replaces the present one: that of the motions of the full model (`Task.full_motions`), of the modes
    that their harmonics reach, and of the mean displacements along the curve, at points that are not ``used``. Where
    there are no such motions, a basis of the corrected motions first replaces the present one, and finally one of the
    recomputed motions replaces the enriched one; neither replacement is made if a point does not converge.
    """
    model, condensation, symmetry = points.balance.model, structure.condensation, structure.symmetry
    wanted, settled = len(points.frequencies), []
    if around is not None and (full := task.full_motions(points, found, training)) is not None:
        return _of_motions(structure, training, full, around, used)
    if around is not None and max(f.energy for f in found) < LINEAR:
        motions = modal(points) + np.array([f.modal.T for f in found])
        corrected = principal_span(condensation, motions, POINT_SHARE * training.tolerance, symmetry)
        moved = task.again(points, corrected, motions @ corrected.vectors)
        if len(moved.frequencies) == wanted:
            model, points, found = corrected, moved, task.check(moved, training.rough)
    for number in range(POINT_ROUNDS + 1):
        large = [
            k for k, f in enumerate(found) if f.energy > POINT_SHARE * training.tolerance and number < POINT_ROUNDS
        ]
        small = sorted(set(range(len(found))) - set(large))
        settled.append(points.take(small))
        if not large:
            break
        model = joined(structure, training, model, [found[k] for k in large])
        points = points.take(large)
        starts = points.coefficients @ (points.balance.model.vectors.T @ model.vectors)
        for start, k in zip(starts, large, strict=True):
            if found[k].energy < LINEAR:
                start += found[k].modal.T @ model.vectors
        points = task.again(points, model, starts)
        if not len(points.frequencies):
            break
        found = task.check(points, training.rough)
    if around is None or sum(len(part.frequencies) for part in settled) < wanted:
        return model
    kept = [part for part in settled if len(part.frequencies)]
    motions = np.concatenate([modal(part) for part in kept])
    frequencies = np.concatenate([part.frequencies for part in kept])
    return _of_motions(structure, training, Motions(motions, frequencies, None), around, used)


def _of_motions(
    structure: Structure, training: Training, motions: Motions, around: Curve, used: Collection[int]
) -> ReducedModel:
    """Model of the principal shapes of motions, of the modes that they reach, and of the means along a curve.

    The motions belong to the ``used`` points of the curve.
    """
    condensation, least = structure.condensation, COMPRESSION * training.tolerance
    modes = reached_modes(condensation, motions, around.balance.orders, least)
    means = scaled_means(around, used, training.rough)
    return principal_span(condensation, motions.coefficients, least, structure.symmetry, modes=modes, means=means)


def joined(structure: Structure, training: Training, model: ReducedModel, found: list[Correction]) -> ReducedModel:
    """Reduced model whose basis is extended by the shapes of the large corrections in ``found``.

    A correction is large if its energy norm, relative to the motion, exceeds `POINT_SHARE` times the tolerance.
    """
    large = [f.shapes for f in found if f.energy > POINT_SHARE * training.tolerance]
    return with_shapes(model, np.column_stack(large), 0.2 * training.tolerance, structure.symmetry)


def loosened(training: Training) -> tuple[Training, float]:
    """Training of a roll whose interfaces open widely, and its tolerance."""
    tolerance = max(training.tolerance, OPEN_TOLERANCE)
    return replace(training, tolerance=tolerance), tolerance


def watched(structure: Structure, training: Training, snapshots: FloatArray) -> ReducedModel:
    """First model with the shapes of motions in time."""
    first = structure.with_harmonics(TRAINING_HARMONICS).first_model()
    return with_snapshots(first, snapshots, SNAPSHOT_SHARE * training.tolerance, structure.symmetry)
