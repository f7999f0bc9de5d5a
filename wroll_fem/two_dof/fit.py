"""Fit of the two-mass model to transmissibility curves by bounded least squares from several starting points."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from wroll_fem.blas import one_thread
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.numerics.identifiability import Uncertainty, uncertainty
from wroll_fem.two_dof.model import TwoMasses
from wroll_fem.two_dof.periodic import PeriodicSolver
from wroll_fem.typing import FloatArray, IntArray

FREE = ("m1", "k1", "c1", "m2", "k2", "c2", "base_amplitude", "smoothing")
"""Names of the parameters that can be fitted, besides the friction capacities."""
ACCURACY = 1e-6
"""Relative accuracy of the computed curves; it must be well below the finite-difference step."""
STEP = 1e-4
"""Relative finite-difference step of the Jacobian."""
LOST = 10.0
"""Residual assigned to each point of a curve that cannot be computed; much larger than the residuals of any fit."""


@dataclass(frozen=True)
class Measured:
    """Measured transmissibility curve at one preload.

    Attributes
    ----------
    omega : (n,) frequencies, rad/s, ascending (for a scaled model, relative to the natural frequency of the primary)
    transmissibility : (n,) largest abs(x_1) divided by Y_0, above 0
    capacity : friction capacity, N; the initial value if capacities are fitted
    base_amplitude : amplitude Y_0 of the base of this curve, m; None for that of the model
    roll : number of the roll; fitted capacities are shared by the curves of a roll; None for a roll of its own

    Raises
    ------
    InputError
        If the arrays do not form a curve with positive values and increasing frequencies.
    """

    omega: FloatArray
    transmissibility: FloatArray
    capacity: float
    base_amplitude: float | None = None
    roll: int | None = None

    def __post_init__(self) -> None:
        omega, values = np.asarray(self.omega, float), np.asarray(self.transmissibility, float)
        if omega.ndim != 1 or omega.shape != values.shape or omega.size < 3:
            raise InputError(
                f"frequency and transmissibility have the shapes {omega.shape} and {values.shape}",
                remedy="give two series of the same length, 3 points or more",
            )
        if not self.capacity > 0.0:
            raise InputError(
                f"the capacity of a curve is {self.capacity:g} N", remedy="give a friction capacity above 0"
            )
        good = np.all(np.isfinite(values)) and np.all(values > 0.0) and omega[0] > 0.0 and np.all(np.diff(omega) > 0.0)
        if not good:
            raise InputError(
                "the values of a curve must be positive and finite and its frequencies must increase",
                remedy="sort the points by frequency and remove invalid ones",
            )


@dataclass(frozen=True)
class Fit:
    """Best fit from several starting points.

    Attributes
    ----------
    model : fitted parameters
    capacities : friction capacity of each curve, N, fitted or given
    error : root mean square of ln(model / measured)
    errors : error of each start, smallest first; equal values indicate a unique minimum
    at_bound : names of parameters that ended on a bound and are doubtful (`capacity k` for the k-th roll)
    uncertainty : confidence of the parameters, and what the data do not determine
    """

    model: TwoMasses
    capacities: FloatArray
    error: float
    errors: FloatArray
    at_bound: tuple[str, ...]
    uncertainty: Uncertainty


@dataclass(frozen=True)
class _Problem:
    measured: tuple[Measured, ...]
    model: TwoMasses
    names: tuple[str, ...]
    low: FloatArray
    high: FloatArray
    accuracy: float = ACCURACY

    def unpack(self, x: FloatArray) -> tuple[TwoMasses, FloatArray]:
        """Model and friction capacities (N) that belong to the logarithms of the free parameters."""
        values = np.exp(x)
        count = len(self.names)
        changes: dict[str, Any] = dict(zip(self.names, map(float, values[:count]), strict=True))
        model = replace(self.model, **changes)
        given = np.array([m.capacity for m in self.measured])
        return model, values[count:][self.rolls] if len(values) > count else given

    @property
    def rolls(self) -> IntArray:
        """(n,) place of the roll of each curve among the rolls."""
        keys = [("own", k) if one.roll is None else ("roll", one.roll) for k, one in enumerate(self.measured)]
        places = {key: k for k, key in enumerate(dict.fromkeys(keys))}
        return np.array([places[key] for key in keys])

    def residuals(self, x: FloatArray) -> FloatArray:
        """Differences of ln(T) between model and measurement at all points of all curves."""
        model, capacities = self.unpack(x)
        found = []
        for one, capacity in zip(self.measured, capacities, strict=True):
            try:
                own = model if one.base_amplitude is None else replace(model, base_amplitude=one.base_amplitude)
                curve = PeriodicSolver(own.preloaded(float(capacity)), accuracy=self.accuracy).curve(one.omega)
                found.append(np.log([m.transmissibility for m in curve]) - np.log(one.transmissibility))
            except ConvergenceError:
                found.append(np.full(len(one.omega), LOST))
        return np.concatenate(found)

    def solve(self, start: FloatArray) -> tuple[FloatArray, float, FloatArray, FloatArray]:
        """Logarithms of the best parameters from one start, root mean square residual, Jacobian and residuals."""
        with one_thread():
            done = least_squares(
                self.residuals,
                start,
                bounds=(self.low, self.high),
                diff_step=STEP / ACCURACY * self.accuracy,
                x_scale=1.0,
                xtol=1e-5,
                ftol=1e-5,
            )
        return done.x, float(np.sqrt(2.0 * done.cost / len(done.fun))), np.asarray(done.jac), np.asarray(done.fun)


def fit_curves(
    measured: Sequence[Measured],
    bounds: Mapping[str, tuple[float, float]],
    *,
    model: TwoMasses | None = None,
    capacity_bounds: tuple[float, float] | None = None,
    starts: int = 4,
    seed: int = 1,
    workers: int | None = None,
    accuracy: float = ACCURACY,
) -> Fit:
    """Fit the model to transmissibility curves measured at several preloads.

    The residuals are differences of ln(T), so that flanks and peaks have the same weight. The unknowns are the
    logarithms of the parameters. The first start is ``model``; the other starts are a Latin hypercube within the
    bounds.

    Parameters
    ----------
    measured
        Curves, in any order.
    bounds
        Lowest and highest value of each free parameter (names in `FREE`); all other parameters keep the values of
        ``model``.
    model
        Fixed values and initial values; Table 5.2 of the thesis if None.
    capacity_bounds
        Lowest and highest friction capacity, N, if the capacities are fitted too; None keeps those of ``measured``.
    starts, seed
        Number of starts; seed of the hypercube.
    workers
        Number of processes; None for the number of cores.
    accuracy
        Relative accuracy of the computed curves; the steps of the finite differences are a hundred times larger.

    Raises
    ------
    InputError
        If there is no curve or no free parameter, for an unknown name, or for bounds that are not positive and
        increasing.

    Notes
    -----
    A common factor of all stiffnesses, masses, dashpots and capacities does not change the curves, and neither does a
    common factor of F_c and Y_0 (except through S(F_c) in equations 5.6 and 5.7). Fix m1 and k1, and do not free all
    parameters at once.
    """
    model = TwoMasses() if model is None else model
    if not measured:
        raise InputError("there is no curve to fit", remedy="give at least one `Measured`")
    for name, (low, high) in bounds.items():
        if name not in FREE:
            raise InputError(f"unknown parameter {name!r}", remedy=f"use {', '.join(FREE)}")
        if not 0.0 < low < high:
            raise InputError(
                f"bounds must be positive and increasing, got {low:g} and {high:g}", key=name,
                remedy="give the lower bound first",
            )  # fmt: skip
    if capacity_bounds is not None and not 0.0 < capacity_bounds[0] < capacity_bounds[1]:
        raise InputError(
            f"bounds must be positive and increasing, got {capacity_bounds}", key="capacity",
            remedy="give the lower bound first",
        )  # fmt: skip
    names = tuple(bounds)
    problem = _Problem(tuple(measured), model, names, np.zeros(0), np.zeros(0), accuracy)
    count = int(problem.rolls.max()) + 1 if capacity_bounds is not None else 0
    free = [bounds[name] for name in names] + [capacity_bounds] * count
    if not free or starts < 1:
        raise InputError("there is nothing to fit", remedy="free at least one parameter and use at least one start")
    low, high = (np.log(np.array([pair[i] for pair in free if pair is not None])) for i in (0, 1))
    first = [getattr(model, name) for name in names]
    first += [measured[int(np.argmax(problem.rolls == k))].capacity for k in range(count)]
    problem = replace(problem, low=low, high=high)
    inside = 1e-6 * (high - low)
    points = [np.clip(np.log(first), low + inside, high - inside)]
    points += (
        list(low + (high - low) * qmc.LatinHypercube(len(low), seed=seed).random(starts - 1)) if starts > 1 else []
    )
    found = _solved(problem, points, workers)
    best, error, jacobian, residuals = found[0]
    labels = [*names, *(f"capacity {k + 1}" for k in range(count))]
    edge = np.minimum(best - low, high - best) < 1e-3 * (high - low)
    fitted, capacities = problem.unpack(best)
    return Fit(
        fitted,
        np.asarray(capacities),
        error,
        np.array([one[1] for one in found]),
        tuple(label for label, at in zip(labels, edge, strict=True) if at),
        uncertainty(labels, best, jacobian, residuals),
    )


def _solved(
    problem: _Problem, points: Sequence[FloatArray], workers: int | None
) -> list[tuple[FloatArray, float, FloatArray, FloatArray]]:
    """Solutions from all starting points, best first; see `_Problem.solve`."""
    count = min(len(os.sched_getaffinity(0)) if workers is None else workers, len(points))
    if count > 1:
        with ProcessPoolExecutor(count) as pool:
            found = list(pool.map(partial(_Problem.solve, problem), points))
    else:
        found = [problem.solve(point) for point in points]
    return sorted(found, key=lambda one: one[1])
