"""Error estimate of a reduced time history from its projection error."""

from __future__ import annotations

import math

OPENING, CLOSED_PART, OPENED_PART = 30.0, 2.0, 1.2
"""Error estimate once contact points have opened: the smaller of ``OPENING`` e and ``CLOSED_PART`` e + ``OPENED_PART``
f. Here e is the estimate without opening, and f the largest change of the fraction of open points since the preload
state.

In docs/tables/opening_error.md (random rolls, and rolls at 30 to 10000 Pa) this estimate exceeds the measured errors of
tip motion and input work for every roll."""


def estimate(error: float, motion: float, opened: float) -> float:
    """Estimated relative error of the motion, in the energy norm.

    Parameters
    ----------
    error, motion
        Squared energy norms of the projection error and of the motion, summed over the residual checks, J.
    opened
        Largest change of the fraction of open points since the preload state; see `OPENING`.
    """
    if error == 0.0:
        return 0.0
    closed = math.sqrt(error / motion) if motion > 0.0 else math.inf
    return min(OPENING * closed, CLOSED_PART * closed + OPENED_PART * opened) if opened > 0.0 else closed
