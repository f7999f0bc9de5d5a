"""Motions of the full model by Newton's method in all modes, from points of a response curve of a reduced model.

A correction (`correction`) solves the linearised equations of the full model, without its component along the curve:
this one leads to another point of the curve. Corrections that are repeated at the corrected motions converge to the
curve of the full model as Newton's method does, to the first order in that component. No reduced model is solved in
between.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.point_sample import Motions
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.training.correction import Correction, corrected_means, modal_corrections
from wroll_fem.typing import FloatArray

POINT_ROUNDS = 4
"""Largest number of times that the motion at a point of a curve is corrected."""

LINEAR = 0.5
"""Largest relative correction at which the corrected motion is more accurate than the uncorrected motion."""

LAST = 1e-2
"""Relative correction, without the mean displacement, up to which the corrected motion needs no further one, as its
error is of second order. The mean is corrected once more."""

MOST_MEANS, MIDDLES = 40, 4
"""Largest number of points of a curve whose mean displacement is corrected, and number of motions halfway between two
of them. The mean follows from the history of slip and changes in smaller steps than the harmonics."""

FEWEST = 0.8
"""Smallest share of the motions that have to converge."""


def full_motions(points: HarmonicCurve, found: list[Correction], residual: float) -> Motions | None:
    """Motions of the full model, in all modes, near the p points of a curve; None if few of them converge.

    Those that do not converge are left out.

    Parameters
    ----------
    found
        Corrections of the motions at the points.
    residual
        Relative residual of the linear equations of further corrections.
    """
    balance, motions = points.balance, modal(points)
    along = [(points.direction(k) @ balance.model.vectors.T)[None] for k in range(len(motions))]
    good, left = np.ones(len(motions), bool), list(range(len(motions)))
    for number in range(POINT_ROUNDS):
        if number:
            directions = [along[k] for k in left]
            found = modal_corrections(balance, motions[left], points.frequencies[left], directions, tolerance=residual)
        further = []
        for place, one in zip(left, found, strict=True):
            good[place] = one.energy <= LINEAR
            if good[place]:
                motions[place] += one.modal.T
                if one.moving > LAST:
                    further.append(place)
        if good.mean() < FEWEST:
            return None
        left = further
        if not left:
            break
    motions, frequencies = motions[good], points.frequencies[good]
    means = corrected_means(balance, motions, frequencies, tolerance=residual)
    found_one = np.isfinite(means).all(axis=1)
    motions[found_one, 0] = means[found_one]
    return Motions(motions, frequencies, None)


def scaled_means(curve: HarmonicCurve | BackboneCurve, used: Collection[int], residual: float) -> FloatArray:
    """(r, k) corrected mean displacements along a curve, per unit energy norm of their motions.

    They are those at its points, without the ``used`` ones and at most `MOST_MEANS`, and those of the `MIDDLES` motions
    halfway between the neighbours whose means differ most. A mean that is not found is left out.
    """
    motions, values = modal(curve), np.maximum(curve.balance.model.condensation.eigenvalues, 0.0)
    norms = np.sqrt((values * motions**2).sum(axis=(1, 2)))
    apart = np.linalg.norm(np.sqrt(values) * np.diff(motions[:, 0] / norms[:, None], axis=0), axis=1)
    wide = np.argsort(-apart)[:MIDDLES]
    others = np.array([k for k in range(len(motions)) if k not in used], np.int64)
    if len(others) > MOST_MEANS:
        others = others[np.linspace(0, len(others) - 1, MOST_MEANS).astype(int)]
    halfway = [0.5 * (part[wide] + part[wide + 1]) for part in (motions, curve.frequencies, norms)]
    chosen = [
        np.concatenate([part[others], middle])
        for part, middle in zip((motions, curve.frequencies, norms), halfway, strict=True)
    ]
    means = corrected_means(curve.balance, chosen[0], chosen[1], tolerance=residual) / chosen[2][:, None]
    return np.asarray(means[np.isfinite(means).all(axis=1)].T)


def modal(points: HarmonicCurve | BackboneCurve) -> FloatArray:
    """(p, R, r) Fourier coefficients of the motions at p ``points``, in modal coordinates of the condensation."""
    return np.asarray(points.coefficients @ points.balance.model.vectors.T)
