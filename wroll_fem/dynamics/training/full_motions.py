"""Motions of the full model by Newton's method in all modes, from points of a response curve of a reduced model.

A correction (`correction`) solves the linearised equations of the full model, without its component along the curve:
this one leads to another point of the curve. Corrections that are repeated at the corrected motions converge to the
curve of the full model as Newton's method does, to the first order in that component. No reduced model is solved in
between; one on the principal shapes of the corrected motions only carries them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.training.basis import principal_span
from wroll_fem.dynamics.training.correction import Correction
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.typing import FloatArray

POINT_ROUNDS = 4
"""Largest number of times that the motion at a point of a curve is corrected."""

LINEAR = 0.5
"""Largest relative correction at which the corrected motion is more accurate than the uncorrected motion."""

LAST = 1e-2
"""Relative correction up to which the corrected motion needs no further one, as its error is of second order."""

FEWEST = 0.8
"""Smallest share of the motions that have to converge."""

CARRIED = 0.1
"""Norm of what the model that carries the motions leaves out of them, relative to the tolerance."""


def full_motions(
    structure: Structure, points: HarmonicCurve, found: list[Correction],
    check: Callable[[HarmonicCurve], list[Correction]], tolerance: float,
) -> FloatArray | None:  # fmt: skip
    """(k, R, r) motions of the full model near the p points of a curve; None if few of them converge.

    Those that do not converge are left out, so that k may be less than p.

    Parameters
    ----------
    found
        Corrections of the motions at the points.
    check
        Computes the corrections at points of a curve.
    tolerance
        That of the training.
    """
    motions, level = modal(points), structure.with_harmonics(points.balance.contact.sampling.harmonics)
    good, wanted = np.ones(len(motions), bool), np.arange(len(motions))
    for number in range(POINT_ROUNDS):
        left = []
        for k, (place, one) in enumerate(zip(wanted, found, strict=True)):
            good[place] = one.energy <= LINEAR
            if good[place]:
                motions[place] += one.modal.T
                if one.energy > LAST:
                    left.append(k)
        if good.mean() < FEWEST:
            return None
        if not left or number == POINT_ROUNDS - 1:
            break
        wanted = wanted[left]
        model = principal_span(structure.condensation, motions[wanted], CARRIED * tolerance, structure.symmetry)
        points = points.take(left).carried(level.contact(model), motions[wanted])
        motions[wanted] = modal(points)
        found = check(points)
    return motions[good]


def modal(points: HarmonicCurve | BackboneCurve) -> FloatArray:
    """(p, R, r) Fourier coefficients of the motions at p ``points``, in modal coordinates of the condensation."""
    return np.asarray(points.coefficients @ points.balance.model.vectors.T)
