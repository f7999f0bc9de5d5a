"""Ends of a training that no further basis would change: curves that stop at one motion, rattling, strong overtones."""

from __future__ import annotations

import numpy as np

from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.causes import MIXED, WIDE, largest, opening
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.typing import FloatArray

SAME_END = 0.005, 0.15
"""Relative differences of frequency and size of the motion within which two curves end at the same motion."""

SAFE_END = 0.1
"""Largest relative correction at which the end of a single curve is that of the structure, not of its basis."""

RATTLING = ((1, 0.5, 0.5), (2, 10.0, WIDE), (2, 0.5, 0.35), (3, 0.5, WIDE))
"""Number of curves from which the limits of a row apply, relative correction, and fraction of contact points that open.
If both limits of a row are exceeded, the training ends: bases for rattling layers have hundreds of vectors, and each
curve takes minutes."""

MIXING = 2, 0.4
"""Number of curves and relative correction from which the training ends at a peak with strong overtones (`MIXED`). A
curve with a gap has no peak: only its flanks are wanted."""


def ends_in_every_basis(
    curve: HarmonicCurve | BackboneCurve, before: HarmonicCurve | BackboneCurve | None, error: float
) -> bool:
    """Whether a curve that stopped before its target would stop at the same place in other bases.

    Parameters
    ----------
    curve
        Curve that stopped, in a trained basis.
    before
        Earlier curve of this kind, if any.
    error
        Largest relative correction of the motions on the curve.
    """
    if isinstance(curve, HarmonicCurve) and curve.drifts:
        return error <= SAFE_END or (isinstance(before, HarmonicCurve) and before.drifts)
    mixed = isinstance(curve, HarmonicCurve) and curve.overtones(-1) > MIXED
    return error <= SAFE_END and (mixed or (before is not None and _same_end(before, curve)))


def beyond_training(curve: HarmonicCurve | BackboneCurve, number: int, error: float) -> bool:
    """Whether curve ``number`` of a training, with the relative correction ``error``, rattles or mixes too much.

    A backbone never does: its part at small amplitude is of use.
    """
    if not isinstance(curve, HarmonicCurve):
        return False
    first, most = MIXING
    if number >= first and error > most and curve.gap is None and curve.overtones(largest(curve)) > MIXED:
        return True
    widths = [wide for first, most, wide in RATTLING if number >= first and error > most]
    return bool(widths) and opening(curve) > min(widths)


def _same_end(before: HarmonicCurve | BackboneCurve, curve: HarmonicCurve | BackboneCurve) -> bool:
    """Whether two curves end at the same motion within `SAME_END`."""
    return all(abs(b / a - 1.0) <= limit for a, b, limit in zip(_end(before), _end(curve), SAME_END, strict=True))


def _end(curve: HarmonicCurve | BackboneCurve) -> FloatArray:
    """Frequency and size of the last motion of a curve; all bases are orthonormal in the mass, so sizes compare."""
    return np.array([curve.frequencies[-1], np.linalg.norm(curve.coefficients[-1])])
