r"""Rate-and-state friction at prescribed slip rates (thesis, equation E.4).

.. math:: \mu = \mu_R + a \ln\frac{V}{V_R} + b \ln\frac{V_R \theta}{D_R}

with the ageing law (Dieterich) or the slip law (Ruina) for the state theta,

.. math:: \dot\theta = 1 - \frac{V\theta}{D_R}, \qquad \dot\theta = -\frac{V\theta}{D_R}\ln\frac{V\theta}{D_R}

At a constant rate both have closed forms. With x = V t/D_R and u = V theta/D_R

.. math:: u = 1 + (u_0 - 1)\, e^{-x}, \qquad \ln u = e^{-x} \ln u_0

so histories of piecewise constant rates are computed exactly. In steady sliding u = 1 and theta = D_R/V; the third term
is then -b ln(V/V_R), and mu = mu_R + (a - b) ln(V/V_R).

References
----------
Marone (1998), Annu. Rev. Earth Planet. Sci. 26, 643-696, doi:10.1146/annurev.earth.26.1.643. The logarithm is undefined
at zero slip rate; Rice, Lapusta, Ranjith (2001), J. Mech. Phys. Solids 49, 1865-1898, give the regularised form.
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
    """Parameters of the rate-and-state friction law.

    Attributes
    ----------
    mu
        Coefficient of friction mu_R in steady sliding at the reference rate.
    a, b
        Coefficients of the direct effect and of the state effect; either may be 0.
    rate
        Reference slip rate V_R, m/s.
    distance
        Characteristic slip distance D_R, m.
    law
        Evolution law of the state, "ageing" or "slip".

    Raises
    ------
    InputError
        If a parameter is out of range or the law is unknown.
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
                raise InputError(f"must not be negative, got {getattr(self, name)}", key=name, remedy="give 0 or more")
        if self.law not in LAWS:
            raise InputError(f"unknown state law {self.law!r}", key="law", remedy=f"use {' or '.join(LAWS)}")

    def coefficient(self, rate: npt.ArrayLike, state: npt.ArrayLike) -> FloatArray:
        """Coefficient of friction at a slip rate (m/s, above 0) and a state (s, above 0).

        Raises
        ------
        InputError
            If a rate or a state is not positive.
        """
        rate, state = positive("rate", rate), positive("state", state)
        return np.asarray(
            self.mu + self.a * np.log(rate / self.rate) + self.b * np.log(self.rate * state / self.distance)
        )

    def regularised(self, rate: npt.ArrayLike, state: npt.ArrayLike) -> FloatArray:
        """Signed coefficient of friction, regularised at zero slip rate by the inverse hyperbolic sine.

        The difference from `coefficient`, a exp(-2 mu/a), is far below rounding errors for measured parameters.

        Parameters
        ----------
        rate
            Slip rate of either sign, m/s.
        state
            State, s, above 0.

        Raises
        ------
        InputError
            If a is 0, or a state is not positive.
        """
        if self.a == 0.0:
            raise InputError(
                "the regularised law needs a direct effect, got a = 0", key="a", remedy="give a positive a"
            )
        at = (self.mu + self.b * np.log(self.rate * positive("state", state) / self.distance)) / self.a
        share = np.asarray(rate, dtype=float) / (2.0 * self.rate)
        # asinh(s e^at) for large at: sign(s) (at + ln(2 |s|)) with its correction
        size = np.abs(share)
        with np.errstate(divide="ignore"):
            log = np.log(size) + at
        value = np.where(log > 20.0, log + np.log(2.0), np.arcsinh(np.exp(np.minimum(log, 20.0))))
        return np.asarray(self.a * np.sign(share) * value)

    def steady_state(self, rate: npt.ArrayLike) -> FloatArray:
        """State in steady sliding at a slip rate (m/s, above 0), theta = D_R/V, s.

        Raises
        ------
        InputError
            If a rate is not positive.
        """
        return self.distance / positive("rate", rate)

    def steady_coefficient(self, rate: npt.ArrayLike) -> FloatArray:
        """Coefficient of friction in steady sliding, mu_R + (a - b) ln(V/V_R), at a slip rate V (m/s, above 0).

        Raises
        ------
        InputError
            If a rate is not positive.
        """
        return np.asarray(self.mu + (self.a - self.b) * np.log(positive("rate", rate) / self.rate))

    def state_after(self, state: npt.ArrayLike, rate: npt.ArrayLike, time: npt.ArrayLike) -> FloatArray:
        """State after a given time at constant slip rate, from the closed-form solution.

        Parameters
        ----------
        state
            Initial state, s, above 0.
        rate
            Slip rate, m/s, 0 or more.
        time
            Elapsed time, s.

        Returns
        -------
        State, s

        Raises
        ------
        InputError
            If a state is not positive, or a rate or a time is negative.

        Notes
        -----
        At zero slip rate the state grows with time under the ageing law and is constant under the slip law.
        """
        state, rate, time = positive("state", state), np.asarray(rate, dtype=float), np.asarray(time, dtype=float)
        if np.any(rate < 0.0) or np.any(time < 0.0):
            raise InputError("slip rates and times must not be negative", remedy="give the magnitude of the slip rate")
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
    """Convert values to an array and check that they are positive.

    Raises
    ------
    InputError
        If a value is not positive.
    """
    found = np.asarray(values, dtype=float)
    if not np.all(found > 0.0):
        raise InputError("must be positive", key=name, remedy="give numbers above 0")
    return found


@dataclass(frozen=True)
class VelocitySteps:
    """Velocity-stepping test: slip alternates between two rates, starting with the lower one (thesis, Fig. E.11).

    Attributes
    ----------
    low, high
        Slip rates V_1 and V_2, m/s; V_2 = 10 V_1 in the thesis.
    every, total
        Slip distance between two changes, and total slip distance, m.
    """

    low: float
    high: float
    every: float = 0.5e-3
    total: float = 3.0e-3

    def history(self, points: int = 200) -> tuple[FloatArray, FloatArray]:
        """Slip rates (n,) in m/s and durations (n,) in s, with `points` steps between two changes of the rate.

        Raises
        ------
        InputError
            If a rate or a distance is not positive.
        """
        positive("rate", (self.low, self.high, self.every, self.total))
        stretches = round(self.total / self.every)
        rates = np.repeat(np.where(np.arange(stretches) % 2 == 0, self.low, self.high), points)
        return rates, self.every / points / rates


def sine_history(amplitude: float, frequency: float, *, cycles: int = 3, points: int = 2000) -> tuple[FloatArray, ...]:
    """Mean slip rate and duration of each step of a sinusoidal displacement.

    Parameters
    ----------
    amplitude
        Amplitude of the displacement, 0-peak, m.
    frequency
        Frequency, Hz.
    cycles, points
        Number of cycles, and of steps per cycle.

    Returns
    -------
    rates : (n,) mean slip rate of each step, with sign, m/s
    durations : (n,) s

    Raises
    ------
    InputError
        If amplitude or frequency is not positive.
    """
    positive("amplitude", (amplitude, frequency))
    time = np.arange(cycles * points + 1) / (points * frequency)
    slip = amplitude * np.sin(2.0 * np.pi * frequency * time)
    return np.diff(slip) / np.diff(time), np.diff(time)


def shear_history(
    law: RateAndState, rates: FloatArray, durations: FloatArray, *, state: float | None = None
) -> xr.Dataset:
    """Coefficient of friction during a history of piecewise constant slip rates, computed exactly.

    Parameters
    ----------
    law
        Rate-and-state friction law.
    rates, durations
        (n,) slip rates of either sign, m/s, and their durations, s.
    state
        Initial state, s; None for steady sliding at the first rate.

    Returns
    -------
    xr.Dataset
        `slip_rate`, `slip_distance`, `state_variable` and `friction_coefficient` versus `time` (end of each part). If
        a rate is zero or negative, the coefficient is the signed, regularised one.

    Raises
    ------
    InputError
        If a duration is not positive.
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
