"""Causes of periodic motions that are not found, read from the last motion and from the structure."""

from __future__ import annotations

import numpy as np

from wroll_fem.contact.laws import PointLaws
from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.errors import ConvergenceError

WIDE = 0.2
"""Share of the points that open within a period above which opening is the cause."""

FREE = 1e-6
"""Eigenvalue, over that of the main mode, of a body that nothing holds."""


def cause(error: ConvergenceError, condensation: Condensation, laws: PointLaws) -> str:
    """Sentence with the likely cause of ``error``; empty if none is known."""
    if not laws.sticks.all() and unheld(condensation):
        return (
            "the friction law transmits nothing at rest and nothing else holds the layers, so that their mean "
            "displacement is undetermined: use penalty_coulomb, or clamp coil.base"
        )
    curve = error.partial
    if isinstance(curve, HarmonicCurve | BackboneCurve) and len(curve.frequencies):
        contact = curve.balance.contact
        state = contact.evaluate(contact.motion(curve.coefficients[-1]), float(curve.frequencies[-1]))
        share = float(state.open.any(axis=1).mean()) if contact.n else 0.0
        if share > WIDE:
            return (
                f"the surfaces open at {100 * share:.0f} % of the points within a period: rattling layers have no "
                "simple periodic motion; raise preload.pressure, lower the amplitude, or compute a time history"
            )
    return ""


def unheld(condensation: Condensation) -> bool:
    """Whether some motion of the structure meets no stiffness, with the springs of contact at rest."""
    model = condensation
    main = int(np.argmax(np.abs(model.base * model.tip) / np.maximum(model.eigenvalues, 1e-300)))
    return bool(model.eigenvalues.min() < FREE * abs(model.eigenvalues[main]))


def with_cause(error: ConvergenceError, condensation: Condensation, laws: PointLaws) -> ConvergenceError:
    """The same error with its cause in place of the advice, where one is known."""
    found = cause(error, condensation, laws)
    if not found:
        return error
    message = str(error).split(" after ")[0]
    named = ConvergenceError(
        message, time_s=None, iterations=error.iterations, residual_history=error.residual_history, advice=found
    )
    named.partial = error.partial
    return named
