r"""Rate-and-state friction under prescribed slip rates (thesis, equation E.4).

.. math:: \mu = \mu_R + a \ln\frac{V}{V_R} + b \ln\frac{V_R \theta}{D_R}

with the ageing law (Dieterich) or the slip law (Ruina) for the state theta,

.. math:: \dot\theta = 1 - \frac{V\theta}{D_R}, \qquad \dot\theta = -\frac{V\theta}{D_R}\ln\frac{V\theta}{D_R}

At a constant rate both have closed forms. With x = V t/D_R and u = V theta/D_R

.. math:: u = 1 + (u_0 - 1)\, e^{-x}, \qquad \ln u = e^{-x} \ln u_0

so that a history of piecewise constant rates is exact. Steady sliding is u = 1, theta = D_R/V: the third term is then
-b ln(V/V_R), not zero, and mu = mu_R + (a - b) ln(V/V_R).

References
----------
Marone (1998), Annu. Rev. Earth Planet. Sci. 26, 643-696, doi:10.1146/annurev.earth.26.1.643. At a rate of zero the
logarithm has no value; Rice, Lapusta, Ranjith (2001), J. Mech. Phys. Solids 49, 1865-1898, give the regularised form.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt
import xarray as xr

from wroll_fem.errors import InputError, require_positive
from wroll_fem.results.dataset import annotate
from wroll_fem.typing import FloatArray

StateLaw = Literal["ageing", "slip"]
LAWS: tuple[StateLaw, ...] = get_args(StateLaw)


@dataclass(frozen=True)
class RateAndState:
    """Constants of the law.

    Attributes
    ----------
    mu
        mu_R, coefficient of steady sliding at the reference rate.
    a, b
        Direct effect and effect of the state; either may be 0.
    rate
        V_R, m/s.
    distance
        D_R, slip over which the state is renewed, m.
    law
        Evolution of the state, "ageing" or "slip".

    Raises
    ------
    InputError
        For values without a meaning.
    """

    mu: float = 0.25
    a: float = 0.01
    b: float = 0.015
    rate: float = 1.0e-6
    distance: float = 2.0e-5
    law: StateLaw = "ageing"

    def __post_init__(self) -> None:
        require_positive(self, ("mu", "rate", "distance"))
        for name in ("a", "b"):
            if not getattr(self, name) >= 0.0:
                raise InputError(f"{name} = {getattr(self, name)}", key=name, remedy="give 0 or more")
        if self.law not in LAWS:
            raise InputError(f"no state law {self.law!r}", key="law", remedy=f"use {' or '.join(LAWS)}")

    def coefficient(self, rate: npt.ArrayLike, state: npt.ArrayLike) -> FloatArray:
        """Coefficient of friction at slip ``rate`` (m/s, above 0) with ``state`` (s)."""
        rate, state = positive("rate", rate), positive("state", state)
        return np.asarray(
            self.mu + self.a * np.log(rate / self.rate) + self.b * np.log(self.rate * state / self.distance)
        )

    def regularised(self, rate: npt.ArrayLike, state: npt.ArrayLike) -> FloatArray:
        """Coefficient that goes through zero with the ``rate`` (m/s, of either sign), by the inverse hyperbolic sine.

        It equals `coefficient` but for a exp(-2 mu/a), far below rounding for friction laws as measured.
        """
        if self.a == 0.0:
            raise InputError("a = 0 leaves nothing to regularise", key="a", remedy="give a positive direct effect")
        at = (self.mu + self.b * np.log(self.rate * positive("state", state) / self.distance)) / self.a
        share = np.asarray(rate, dtype=float) / (2.0 * self.rate)
        # asinh(s e^at) for large at: sign(s) (at + ln(2 |s|)) with its correction
        size = np.abs(share)
        with np.errstate(divide="ignore"):
            log = np.log(size) + at
        value = np.where(log > 20.0, log + np.log(2.0), np.arcsinh(np.exp(np.minimum(log, 20.0))))
        return np.asarray(self.a * np.sign(share) * value)

    def steady_state(self, rate: npt.ArrayLike) -> FloatArray:
        """State of steady sliding, theta = D_R/V, s."""
        return self.distance / positive("rate", rate)

    def steady_coefficient(self, rate: npt.ArrayLike) -> FloatArray:
        """mu_R + (a - b) ln(V/V_R)."""
        return np.asarray(self.mu + (self.a - self.b) * np.log(positive("rate", rate) / self.rate))

    def state_after(self, state: npt.ArrayLike, rate: npt.ArrayLike, time: npt.ArrayLike) -> FloatArray:
        """State (s) a ``time`` (s) later at a constant ``rate`` (m/s, 0 or more), exactly.

        Notes
        -----
        At rest the ageing law's state grows with time, the slip law's stays.
        """
        state, rate, time = positive("state", state), np.asarray(rate, dtype=float), np.asarray(time, dtype=float)
        if np.any(rate < 0.0) or np.any(time < 0.0):
            raise InputError("a slip rate or a time below 0", remedy="give the size of the slip rate")
        x = rate * time / self.distance
        if self.law == "ageing":
            # theta_0 e^-x + t (1 - e^-x)/x, the last factor 1 at x = 0
            share = np.where(x > 0.0, -np.expm1(-x) / np.where(x > 0.0, x, 1.0), 1.0)
            return np.asarray(state * np.exp(-x) + time * share)
        moving = np.where(rate > 0.0, rate, 1.0)
        # ln theta = ln theta_0 + (e^-x - 1) ln u_0
        log = np.log(state) + np.expm1(-x) * np.log(moving * state / self.distance)
        return np.asarray(np.where(rate > 0.0, np.exp(log), state))


def positive(name: str, values: npt.ArrayLike) -> FloatArray:
    """Values as an array of numbers above 0; raises InputError for others."""
    found = np.asarray(values, dtype=float)
    if not np.all(found > 0.0):
        raise InputError(f"a {name} that is not above 0", key=name, remedy="give positive numbers")
    return found


@dataclass(frozen=True)
class VelocitySteps:
    """Platen driven alternately at two rates (thesis, Fig. E.11), first at the lower.

    Attributes
    ----------
    low, high
        V_1 and V_2, m/s; the source takes V_2 = 10 V_1.
    every, total
        Slip between changes and in all, m.
    """

    low: float
    high: float
    every: float = 0.5e-3
    total: float = 3.0e-3

    def history(self, points: int = 200) -> tuple[FloatArray, FloatArray]:
        """Rates (n,) in m/s and durations (n,) in s of ``points`` equal parts of each stretch."""
        positive("rate", (self.low, self.high, self.every, self.total))
        stretches = round(self.total / self.every)
        rates = np.repeat(np.where(np.arange(stretches) % 2 == 0, self.low, self.high), points)
        return rates, self.every / points / rates


def sine_history(amplitude: float, frequency: float, *, cycles: int = 3, points: int = 2000) -> tuple[FloatArray, ...]:
    """Signed mid-step rates (n,) in m/s and durations (n,) in s of a sine displacement; ``amplitude`` m, 0-peak."""
    positive("amplitude", (amplitude, frequency))
    time = np.arange(cycles * points + 1) / (points * frequency)
    slip = amplitude * np.sin(2.0 * np.pi * frequency * time)
    return np.diff(slip) / np.diff(time), np.diff(time)


def shear_history(
    law: RateAndState, rates: FloatArray, durations: FloatArray, *, state: float | None = None
) -> xr.Dataset:
    """Friction along a history of piecewise constant slip rates; exact for such a history.

    Parameters
    ----------
    rates, durations
        (n,) m/s, of either sign, and s.
    state
        At the start, s; that of steady sliding at the first rate without.

    Returns
    -------
    xr.Dataset
        Over `time` (end of each part): `slip_rate`, `slip_distance`, `state_variable`, `friction_coefficient`. Where
        the sign of the rate changes in the history the coefficient is the regularised one, with sign.
    """
    rates, durations = np.asarray(rates, dtype=float), positive("duration", durations)
    speeds = np.abs(rates)
    if state is None:
        state = float(law.steady_state(speeds[speeds > 0.0][0]))
    states = np.empty(len(rates))
    for k, (speed, duration) in enumerate(zip(speeds, durations, strict=True)):
        state = float(law.state_after(state, speed, duration))
        states[k] = state
    reverses = bool(np.any(rates <= 0.0))
    found = law.regularised(rates, states) if reverses else law.coefficient(rates, states)
    return annotate(
        xr.Dataset(
            {
                "slip_rate": ("time", rates),
                "slip_distance": ("time", np.cumsum(rates * durations)),
                "state_variable": ("time", states),
                "friction_coefficient": ("time", found),
            },
            {"time": np.cumsum(durations)},
        )
    )
