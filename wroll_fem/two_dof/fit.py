"""Parameters of the two masses from a family of transmissibilities: bounded least squares from several starts."""

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
from threadpoolctl import threadpool_limits

from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.two_dof.model import TwoMasses
from wroll_fem.two_dof.periodic import PeriodicSolver
from wroll_fem.typing import FloatArray

FREE = ("m1", "k1", "c1", "m2", "k2", "c2", "base_amplitude", "smoothing")
"""What can be fitted besides the capacities."""
ACCURACY = 1e-6
"""Of the computed curves, well below the step of the differences."""
STEP = 1e-4
"""Relative step of the differences that make the Jacobian."""
LOST = 10.0
"""Residual where the model finds no motion: far worse than any fit."""


@dataclass(frozen=True)
class Measured:
    """One curve of the family.

    Attributes
    ----------
    omega : (n,) rising, rad/s (divide by the primary's own resonance where the model is scaled)
    transmissibility : (n,) largest abs(x_1) over Y_0, above 0
    capacity : friction capacity in N; with free capacities the first guess
    """

    omega: FloatArray
    transmissibility: FloatArray
    capacity: float

    def __post_init__(self) -> None:
        omega, values = np.asarray(self.omega, float), np.asarray(self.transmissibility, float)
        if omega.ndim != 1 or omega.shape != values.shape or omega.size < 3:
            raise InputError(f"a curve of shapes {omega.shape} and {values.shape}", remedy="give two equal series")
        good = np.all(np.isfinite(values)) and np.all(values > 0.0) and omega[0] > 0.0 and np.all(np.diff(omega) > 0.0)
        if not good or not self.capacity > 0.0:
            raise InputError("a curve that is not positive, or whose frequencies do not rise", remedy="leave gaps out")


@dataclass(frozen=True)
class Fit:
    """Best of several fits.

    Attributes
    ----------
    model : parameters found
    capacities : (c,) friction capacities, N, found or given
    error : root mean square of ln(model / measured)
    errors : (s,) the same of every start, best first; fits that end alike are a sign that there is one
    at_bound : names that ended on a bound (`capacity k` for the k-th curve), to be doubted
    """

    model: TwoMasses
    capacities: FloatArray
    error: float
    errors: FloatArray
    at_bound: tuple[str, ...]


@dataclass(frozen=True)
class _Problem:
    measured: tuple[Measured, ...]
    model: TwoMasses
    names: tuple[str, ...]
    low: FloatArray
    high: FloatArray

    def unpack(self, x: FloatArray) -> tuple[TwoMasses, FloatArray]:
        values = np.exp(x)
        count = len(self.names)
        changes: dict[str, Any] = dict(zip(self.names, map(float, values[:count]), strict=True))
        model = replace(self.model, **changes)
        given = np.array([m.capacity for m in self.measured])
        return model, values[count:] if len(values) > count else given

    def residuals(self, x: FloatArray) -> FloatArray:
        model, capacities = self.unpack(x)
        found = []
        for one, capacity in zip(self.measured, capacities, strict=True):
            try:
                curve = PeriodicSolver(model.pressed(float(capacity)), accuracy=ACCURACY).curve(one.omega)
                found.append(np.log([m.transmissibility for m in curve]) - np.log(one.transmissibility))
            except ConvergenceError:
                found.append(np.full(len(one.omega), LOST))
        return np.concatenate(found)

    def solve(self, start: FloatArray) -> tuple[FloatArray, float]:
        with threadpool_limits(1, "blas"):
            done = least_squares(
                self.residuals, start, bounds=(self.low, self.high), diff_step=STEP, x_scale=1.0, xtol=1e-5, ftol=1e-5
            )
        return done.x, float(np.sqrt(2.0 * done.cost / len(done.fun)))


def fit_family(
    measured: Sequence[Measured],
    bounds: Mapping[str, tuple[float, float]],
    *,
    model: TwoMasses | None = None,
    capacity_bounds: tuple[float, float] | None = None,
    starts: int = 4,
    seed: int = 1,
    workers: int | None = None,
) -> Fit:
    """Fit the model to curves under several preloads.

    Least squares of ln(T), so that flanks count as much as peaks, over the logarithms of the parameters; the first
    start is ``model`` itself, the others a Latin hypercube in the bounds.

    Parameters
    ----------
    measured
        The family, loose to tight or in any order.
    bounds
        Name of a free parameter (`FREE`) -> lowest and highest value; all others keep the value of ``model``.
    model
        Fixed values and first guess; Table 5.2 when None.
    capacity_bounds
        Lowest and highest capacity in N, when the capacities are to be found too; None takes those of ``measured``.
    starts, seed
        Number of starts, and the seed of the hypercube.
    workers
        Processes; the cores of this machine when None.

    Raises
    ------
    InputError
        For no curve, an unknown name, or bounds that are not positive and rising.

    Notes
    -----
    All stiffnesses, masses, dashpots and capacities times one factor give the same curves, as do F_c and Y_0 together
    (except through S(F_c) of equations 5.6 and 5.7): fix m1 and k1, and do not free everything at once.
    """
    model = TwoMasses() if model is None else model
    if not measured:
        raise InputError("no curve to fit", remedy="give at least one `Measured`")
    for name, (low, high) in bounds.items():
        if name not in FREE:
            raise InputError(f"no parameter {name!r} to fit", remedy=f"use {', '.join(FREE)}")
        if not 0.0 < low < high:
            raise InputError(f"bounds {low:g} to {high:g}", key=name, remedy="give two rising positive numbers")
    if capacity_bounds is not None and not 0.0 < capacity_bounds[0] < capacity_bounds[1]:
        raise InputError(f"bounds {capacity_bounds}", key="capacity", remedy="give two rising positive numbers")
    names = tuple(bounds)
    free = [bounds[name] for name in names] + [capacity_bounds] * len(measured) * (capacity_bounds is not None)
    if not free or starts < 1:
        raise InputError("nothing to fit", remedy="free at least one parameter, from at least one start")
    low, high = (np.log(np.array([pair[i] for pair in free if pair is not None])) for i in (0, 1))
    first = [getattr(model, name) for name in names]
    first += [one.capacity for one in measured] if capacity_bounds is not None else []
    problem = _Problem(tuple(measured), model, names, low, high)
    inside = 1e-6 * (high - low)
    points = [np.clip(np.log(first), low + inside, high - inside)]
    points += (
        list(low + (high - low) * qmc.LatinHypercube(len(low), seed=seed).random(starts - 1)) if starts > 1 else []
    )
    count = min(len(os.sched_getaffinity(0)) if workers is None else workers, starts)
    if count > 1:
        with ProcessPoolExecutor(count) as pool:
            found = list(pool.map(partial(_Problem.solve, problem), points))
    else:
        found = [problem.solve(point) for point in points]
    found.sort(key=lambda pair: pair[1])
    best, error = found[0]
    labels = [*names, *(f"capacity {k + 1}" for k in range(len(measured)))]
    edge = np.minimum(best - low, high - best) < 1e-3 * (high - low)
    fitted, capacities = problem.unpack(best)
    return Fit(
        fitted,
        np.asarray(capacities),
        error,
        np.array([e for _, e in found]),
        tuple(label for label, at in zip(labels, edge, strict=False) if at),
    )
