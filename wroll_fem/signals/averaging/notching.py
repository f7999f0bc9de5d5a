"""Level of a random base acceleration at which a response reaches its limit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from wroll_fem.errors import InputError

STEP, REACH = 4.0, 1e12
"""Factor between the levels tried, and largest factor from the given level in either direction."""


def factor_at_limit(response: Callable[[float], float], limit: float, *, tolerance: float = 1e-8) -> float:
    """Factor on the PSD at which a response that increases with it equals its limit.

    Parameters
    ----------
    response
        Response, for example three times an rms, as a function of the factor on the PSD.
    limit
        Its limit, in the same unit.
    tolerance
        Relative error of the factor.

    Raises
    ------
    InputError
        If the limit is not positive, or not reached at any level up to `REACH` times the given one.
    """
    if not 0.0 < limit < np.inf:
        raise InputError(f"a limit must be positive, got {limit:g}", remedy="give it in SI units")

    def gap(log_factor: float) -> float:
        return float(np.log(max(response(float(np.exp(log_factor))), 1e-300) / limit))

    here = gap(0.0)
    step = -np.sign(here) * np.log(STEP)
    if here == 0.0:
        return 1.0
    low = 0.0
    while abs(low) < np.log(REACH):
        high = low + step
        if gap(high) * here <= 0.0:
            return float(np.exp(brentq(gap, low, high, xtol=tolerance, rtol=1e-12)))
        low = high
    raise InputError(
        f"the limit {limit:g} is not reached at any level between {1 / REACH:g} and {REACH:g} times the PSD",
        remedy="check its unit",
    )
