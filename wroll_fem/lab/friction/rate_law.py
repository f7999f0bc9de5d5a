r"""Coefficient of friction over slip rate, mu(V), fitted to points, and its table for a case file.

Three models: a constant; a logarithm

.. math:: \mu = \mu_R + c \ln \frac{V}{V_R}

with the geometric mean of the rates as V_R; and a table with free values at given rates, linear between them as in
`wroll_fem.contact.rate_coulomb`. The points scatter by more than their own noise, because each mounting of a specimen
differs; this scatter between points is estimated (random effects) and enters all intervals.

References
----------
.. [1] Hartung, Knapp (2001), Statistics in Medicine 20, 3875-3889, doi:10.1002/sim.1009 (intervals with a variance
   between points).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from wroll_fem.contact.rate_table import table_problem
from wroll_fem.errors import InputError
from wroll_fem.lab.shear.rates import RatePoint
from wroll_fem.numerics.inference import Estimate, Fit, linear_fit
from wroll_fem.typing import FloatArray

Model = Literal["constant", "logarithmic", "table"]
MODELS: tuple[Model, ...] = ("constant", "logarithmic", "table")

SAME_RATE = 1.1
"""Ratio of two rates below which they are one rate of the table."""

MOST_KNOTS, POINTS_PER_KNOT = 16, 2
"""Rates of a table at most, and points for each of them, from which all tested rates are taken."""

ROWS = 16
"""Rows of the table of a logarithmic law."""

TURNS = 30
"""Turns of the variance between points."""


@dataclass(frozen=True)
class RateLaw:
    """Fitted mu(V).

    Attributes
    ----------
    model
        Constant, logarithmic or table.
    rates
        (k,) slip rates of the table, m/s; the first is 0.
    coefficients
        Estimate at each rate of the table.
    fit
        Fit of the parameters to the points.
    between
        Standard deviation between points beyond their own noise.
    criterion
        Akaike's criterion with its correction for few points; the smallest fits best.
    """

    model: Model
    rates: FloatArray
    coefficients: tuple[Estimate, ...]
    fit: Fit
    between: float
    criterion: float

    def section(self, elastic_slip: float) -> dict[str, object]:
        """Case section `contact.friction`: penalty_coulomb for a constant, else rate_coulomb with its table.

        Raises
        ------
        InputError
            If the table is not admissible, for example if a coefficient is negative.
        """
        values = [float(f"{one.value:.6g}") for one in self.coefficients]
        if self.model == "constant":
            return {"law": "penalty_coulomb", "mu": values[0], "elastic_slip": elastic_slip}
        rates = [float(f"{rate:.6g}") for rate in self.rates]
        wrong = table_problem(rates, values)
        if wrong is not None:
            raise InputError(
                f"the fitted table is not admissible: {wrong.column} {wrong.problem}", key="rate_model",
                remedy="use rate_model: constant, or give knots at which the coefficient is measured",
            )  # fmt: skip
        return {"law": "rate_coulomb", "elastic_slip": elastic_slip, "rate_table": {"slip_rate": rates, "mu": values}}


class RateFits(NamedTuple):
    """All models fitted to the same points, the one with the smallest criterion, and doubts, one sentence each."""

    fits: dict[Model, RateLaw]
    best: Model
    doubts: tuple[str, ...]


def fit_rate_laws(points: Sequence[RatePoint], *, knots: Sequence[float] = ()) -> RateFits:
    """Fit all models that the points determine.

    Parameters
    ----------
    points
        Measured points.
    knots
        Rates of the table, m/s, above 0; by default the tested rates.

    Raises
    ------
    InputError
        If there are fewer than two points, or a given knot is not among the tested rates.
    """
    if len(points) < 2:
        raise InputError(
            f"{len(points)} point of slip rate and coefficient", remedy="give records at more rates, or repeat them"
        )
    rates = np.array([point.rate for point in points])
    reference = float(np.exp(np.mean(np.log(rates))))
    given = np.array(knots, dtype=float) if len(knots) else default_knots(rates, *_values(points))
    _check(given, rates)
    ones = np.ones(len(rates))
    bases: dict[Model, dict[str, FloatArray]] = {"constant": {"mu": ones}}
    if np.ptp(np.log(rates)) > np.log(SAME_RATE):
        bases["logarithmic"] = {"mu": ones, "slope": np.log(rates / reference)}
        if len(points) > len(given) > 1:
            bases["table"] = {f"mu{k}": hat for k, hat in enumerate(hats(rates, given))}
    fits = {model: _law(model, basis, points, given, reference) for model, basis in bases.items()}
    best = min(fits, key=lambda model: fits[model].criterion)
    doubts = []
    if "table" not in fits and len(given) > 1:
        doubts.append(f"{len(points)} points do not determine a table of {len(given)} rates; repeat the tests")
    if best != "constant" and fits["constant"].criterion - fits[best].criterion < 4.0:
        doubts.append("a constant coefficient fits nearly as well as one that depends on the rate")
    return RateFits(fits, best, tuple(doubts))


def default_knots(rates: FloatArray, values: FloatArray, errors: FloatArray) -> FloatArray:
    """Rates of a table (k,), m/s, for points (n,) of coefficients with standard errors.

    Tested rates within `SAME_RATE` are joined to their geometric mean. All are taken if the tests are repeated;
    otherwise, from the lowest and the highest one on, each that lowers Akaike's criterion most.
    """
    logs = np.sort(np.log(rates))
    groups = np.split(logs, np.flatnonzero(np.diff(logs) > np.log(SAME_RATE)) + 1)
    centres = np.exp([float(group.mean()) for group in groups])
    if len(centres) <= 2 or (len(centres) <= MOST_KNOTS and len(rates) >= POINTS_PER_KNOT * len(centres)):
        return centres
    weight = 1.0 / np.hypot(errors, np.median(errors) + 1e-6 * np.abs(values).max())
    taken = [0, len(centres) - 1]
    best = _coarse_criterion(rates, values, weight, centres[taken])
    while len(taken) < min(MOST_KNOTS, len(rates) - 3):
        trials = {
            k: _coarse_criterion(rates, values, weight, centres[sorted([*taken, k])])
            for k in range(len(centres))
            if k not in taken
        }
        k = min(trials, key=lambda one: trials[one])
        if not trials[k] < best:
            break
        taken, best = sorted([*taken, k]), trials[k]
    return np.asarray(centres[taken])


def _coarse_criterion(rates: FloatArray, values: FloatArray, weight: FloatArray, knots: FloatArray) -> float:
    """Akaike's criterion of a table with these knots, with given weights of the points."""
    matrix = (weight * hats(rates, knots)).T
    solution, _, _, _ = np.linalg.lstsq(matrix, weight * values, rcond=None)
    squares = float(np.sum((weight * values - matrix @ solution) ** 2))
    n, k = len(values), len(knots) + 1
    return float(n * np.log(squares / n + 1e-12) + 2.0 * k + 2.0 * k * (k + 1.0) / max(1.0, n - k - 1.0))


def hats(rates: FloatArray, knots: FloatArray) -> FloatArray:
    """(k, n) weight of the value at each knot in the table's value at each rate: linear, constant beyond the ends."""
    return np.array([np.interp(rates, knots, row) for row in np.eye(len(knots))])


def _check(knots: FloatArray, rates: FloatArray) -> None:
    if np.any(np.diff(knots) <= 0.0) or not knots[0] > 0.0:
        raise InputError("the rates must rise from above 0", key="knots", remedy="sort them, m/s")
    weight = hats(rates, knots).max(axis=1)
    if weight.min() < 0.05:
        k = int(np.argmin(weight))
        raise InputError(
            f"no test near the rate {knots[k]:.3g} m/s", key="knots",
            remedy=f"give rates between {rates.min():.3g} and {rates.max():.3g} m/s that are tested",
        )  # fmt: skip


def _values(points: Sequence[RatePoint]) -> tuple[FloatArray, FloatArray]:
    """Coefficients (n,) of the points and their standard errors; unknown ones equal the largest known one."""
    values = np.array([point.coefficient.value for point in points])
    errors = np.array([point.coefficient.standard_error for point in points])
    known = np.isfinite(errors)
    return values, np.where(known, errors, errors[known].max() if known.any() else 0.0)


def _law(
    model: Model, basis: dict[str, FloatArray], points: Sequence[RatePoint], knots: FloatArray, reference: float
) -> RateLaw:
    values, errors = _values(points)
    found, between = pooled(basis, values, errors)
    total = errors**2 + between**2
    count, used = len(values), len(basis) + 1
    rest = values - np.column_stack(list(basis.values())) @ found.x
    criterion = float(np.sum(rest**2 / total + np.log(total)))
    criterion += 2.0 * used + 2.0 * used * (used + 1.0) / max(1.0, count - used - 1.0)
    rates, rows = _table(model, knots, np.array([point.rate for point in points]), reference)
    coefficients = tuple(found.predicted(row, float(row @ found.x)) for row in rows)
    return RateLaw(model, rates, coefficients, found, between, criterion)


def _table(model: Model, knots: FloatArray, tested: FloatArray, reference: float) -> tuple[FloatArray, FloatArray]:
    """Rates of the table (k,), from 0, and the gradient of the coefficient by the parameters at each (k, p)."""
    if model == "constant":
        return np.zeros(1), np.ones((1, 1))
    if model == "table":
        rates, rows = knots, np.eye(len(knots))
    else:
        rates = np.geomspace(tested.min(), tested.max(), ROWS)
        rows = np.column_stack([np.ones(ROWS), np.log(rates / reference)])
    # nothing is measured below the slowest test: its value holds down to rest
    return np.concatenate([[0.0], rates]), np.concatenate([rows[:1], rows])


def pooled(basis: dict[str, FloatArray], values: FloatArray, errors: FloatArray) -> tuple[Fit, float]:
    """Fit to values (n,) with standard errors (n,) and an unknown scatter between them, and this scatter.

    The scatter is the one for which the weighted squares equal the degrees of freedom; it is 0 if the errors explain
    the squares. The covariance is scaled by the squares, so intervals need no knowledge of the errors' size.
    """
    size = float(np.max(errors)) if np.any(errors > 0.0) else 1.0
    floor = np.maximum(errors, 1e-3 * size)
    freedom = len(values) - len(basis)

    def solved(between: float) -> tuple[Fit, float]:
        weights = 1.0 / np.sqrt(floor**2 + between**2)
        found = linear_fit(basis, values, weights=weights, correlated=False)
        return found, float(np.sum(found.residuals**2))

    first, squares = solved(0.0)
    if squares <= freedom:
        return first, 0.0
    low, high = 0.0, float(np.ptp(values)) + size
    for _ in range(TURNS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if solved(middle)[1] > freedom else (low, middle)
    return solved(high)[0], high
