"""Why a curve of periodic motions ends: likely causes, and ends that no further basis would change.

The causes are determined from the last motion and from the structure. Curves that stop at one motion, rattling layers
and strong overtones end the training of a basis.
"""

from __future__ import annotations

import numpy as np

from wroll_fem.contact.laws import PointLaws
from wroll_fem.contact.point import normals
from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.errors import ConvergenceError
from wroll_fem.typing import FloatArray

WIDE = 0.2
"""Share of contact points that open within a period, above which opening is reported as the cause."""

SOME = 0.02
"""Share of contact points that open, above which opening is reported as the reason for the end of a backbone."""

MIXED = 0.3
"""Energy norm of the higher harmonics at the end or at the largest tip amplitude of a response curve, relative to the
whole motion, above which an internal resonance is reported as the cause."""

LOST = 0.5
"""Largest relative correction of a first curve above which wide opening calls for motions in time."""

FREE = 1e-6
"""Smallest eigenvalue, relative to the eigenvalue of the main mode, below which a body counts as unrestrained."""

SAME_END = 0.005, 0.15
"""Relative differences of frequency and size of the motion within which two curves end at the same motion."""

SAFE_END = 0.1
"""Largest relative correction at which the end of a single curve is that of the structure, not of its basis."""

RATTLING = ((1, 0.5, 0.5), (2, 10.0, WIDE), (2, 0.5, 0.35), (3, 0.5, WIDE))
"""Number of curves from which the limits of a row apply, relative correction, and fraction of contact points that open.
If both limits of a row are exceeded, the training ends: bases for rattling layers have hundreds of vectors, and each
curve takes minutes."""

UNDETERMINED_MEAN = (
    "the mean displacement is undetermined: every point of some layer slides within each period, so that nothing holds "
    "this layer; a sweep shows the motion, and backbone the amplitudes at which friction holds it"
)
"""Cause why a layer that slides as a whole has no periodic motion."""

MIXING = 2, 0.4
"""Number of curves and relative correction from which the training ends at a peak with strong overtones (`MIXED`). A
curve with a gap has no peak: only its flanks are wanted."""


def cause(error: ConvergenceError, condensation: Condensation, laws: PointLaws) -> str:
    """Text that states the likely cause of ``error``; empty if no cause is known."""
    if not laws.sticks.all() and unheld(condensation):
        return (
            "the friction law transmits no traction at rest and no other support holds the layers, so that their mean "
            "displacement is undetermined: use penalty_coulomb"
        )
    curve, share = error.partial, error.opening
    if isinstance(curve, HarmonicCurve | BackboneCurve) and len(curve.frequencies):
        share = opening(curve)
    if isinstance(curve, HarmonicCurve) and len(curve.frequencies) and curve.drifts:
        return UNDETERMINED_MEAN
    if share > WIDE:
        return (
            f"the surfaces open at {100 * share:.0f} % of the points within a period: rattling layers have no "
            "simple periodic motion; a dwell shows the motion, and backbone the amplitudes at which they stay closed"
        )
    if isinstance(curve, HarmonicCurve) and len(curve.frequencies):
        point = max((-1, largest(curve)), key=curve.overtones)
        if curve.overtones(point) > MIXED:
            return (
                f"an internal resonance at {curve.frequencies[point] / (2.0 * np.pi):.4g} Hz: higher harmonics are "
                f"{100 * curve.overtones(point):.0f} % of the motion, because they excite another mode; "
                "change the band or the amplitude, or compute a sweep"
            )
    return ""


def opening(curve: HarmonicCurve | BackboneCurve) -> float:
    """Share of the contact points closed at rest that open in the motion of a curve with the largest tip amplitude."""
    contact = curve.balance.contact
    closed = (normals(contact.reference.traction) < 0.0) | ~contact.laws.separation
    if not closed.any():
        return 0.0
    k = largest(curve)
    state = contact.evaluate(contact.motion(curve.coefficients[k]), float(curve.frequencies[k]))
    return float(state.open.any(axis=1)[closed].mean())


def largest(curve: HarmonicCurve | BackboneCurve) -> int:
    """Index of the point of a curve with the largest tip amplitude."""
    return int(np.argmax(np.abs(curve.fundamental(curve.balance.model.tip))))


def end_of_backbone(curve: BackboneCurve) -> str:
    """Text that states why a backbone does not continue to larger amplitudes."""
    share = opening(curve)
    if share > SOME:
        return f"the surfaces then open at {100 * share:.0f} % of the points within a period, and the layers rattle"
    return "no periodic motion is found beyond it, for example because of an internal resonance with another mode"


def unheld(condensation: Condensation) -> bool:
    """Whether the structure has a motion without stiffness when its interfaces are held by the contact springs."""
    model = condensation
    main = int(np.argmax(np.abs(model.base * model.tip) / np.maximum(model.eigenvalues, 1e-300)))
    return bool(model.eigenvalues.min() < FREE * abs(model.eigenvalues[main]))


def with_cause(error: ConvergenceError, condensation: Condensation, laws: PointLaws) -> ConvergenceError:
    """Copy of the error whose ``advice`` states the likely cause; the error itself if no cause is known."""
    found = cause(error, condensation, laws)
    if not found:
        return error
    message = str(error).split(" after ")[0]
    named = ConvergenceError(
        message, time_s=None, iterations=error.iterations, residual_history=error.residual_history, advice=found
    )
    named.partial = error.partial
    return named


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


def opens_widely(curve: HarmonicCurve | BackboneCurve, error: float) -> bool:
    """Whether a response curve needs the shapes of motions in time: wide opening, and corrections that lead nowhere."""
    return isinstance(curve, HarmonicCurve) and error > LOST and opening(curve) > WIDE


def _same_end(before: HarmonicCurve | BackboneCurve, curve: HarmonicCurve | BackboneCurve) -> bool:
    """Whether two curves end at the same motion within `SAME_END`."""
    return all(abs(b / a - 1.0) <= limit for a, b, limit in zip(_end(before), _end(curve), SAME_END, strict=True))


def _end(curve: HarmonicCurve | BackboneCurve) -> FloatArray:
    """Frequency and size of the last motion of a curve; all bases are orthonormal in the mass, so sizes compare."""
    return np.array([curve.frequencies[-1], np.linalg.norm(curve.coefficients[-1])])
