r"""Elastic slip gamma* from the slope of the force before slip, over the preload.

n interfaces of each stack with the stick stiffness mu F_N/gamma* lie in series with layers and fixture of compliance c,
two stacks in parallel:

.. math:: \frac1K = \frac{n \gamma^*}{2 \mu F_N} + c, \qquad F_c = 2 \mu F_N

The compliance over 1/F_N is a straight line with the slope s = n gamma*/(2 mu); the capacity over F_N gives mu, and
gamma* = 2 mu s/n.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.friction.rate_law import pooled
from wroll_fem.numerics.inference import Estimate, combined_freedom
from wroll_fem.typing import FloatArray

PRELOADS = 3
"""Different preloads from which a compliance in series is fitted."""

CLEAR = 3.0
"""Ratio of a compliance in series to its error from which it is reported although it is not fitted."""


class ElasticSlip(NamedTuple):
    """Elastic slip.

    Attributes
    ----------
    elastic_slip
        gamma*, m.
    mu
        Coefficient of friction from the capacities.
    series
        Compliance c in series, m/N; 0 with no error if it is given.
    doubts
        Doubts, one sentence each.
    """

    elastic_slip: Estimate
    mu: Estimate
    series: Estimate
    doubts: tuple[str, ...]


def fit_elastic_slip(
    normal_force: FloatArray, stiffness: list[Estimate], capacity: list[Estimate], *, interfaces: int = 1,
    series: float | None = None,
) -> ElasticSlip:  # fmt: skip
    """Fit the elastic slip to tests at several preloads.

    Parameters
    ----------
    normal_force
        (m,) preload F_N of each test, N.
    stiffness, capacity
        Stiffness K, N/m, and capacity F_c, N, of each test.
    interfaces
        Interfaces n of one stack: layers + 1.
    series
        Known compliance of layers and fixture, m/N, such as 0 after the fixture is removed; None to fit it.

    Raises
    ------
    InputError
        If there are too few tests or preloads, or the compliance does not fall with the preload.
    """
    levels = len(np.unique(np.round(np.log(normal_force) / 0.02)))
    needed = PRELOADS if series is None else 1
    if levels < needed or len(stiffness) < needed + 1:
        raise InputError(
            f"{len(stiffness)} tests at {levels} preloads", key="normal_force",
            remedy=f"test at {needed} preloads or more, {needed + 1} tests in all, or give series_compliance",
        )  # fmt: skip
    mu, doubts = _coefficient(normal_force, capacity)
    values = np.array([1.0 / one.value for one in stiffness])
    errors = np.array([one.error / one.value**2 for one in stiffness])
    slope = {"slope": 1.0 / normal_force}
    both = slope | {"series": np.ones(len(values))}
    known = 0.0 if series is None else series
    found, _ = pooled(both if series is None else slope, values - known, errors)
    rest = found["series"] if series is None else Estimate(known, 0.0, np.inf)
    if series is not None and levels >= PRELOADS and len(values) > 2:
        more = pooled(both, values - known, errors)[0]["series"]
        if abs(more.value) > CLEAR * more.error:
            doubts.append(
                f"the stiffness over the preload shows {more.value:.2g} m/N in series beyond series_compliance; leave "
                "it out to fit it, or remove the fixture"
            )
    if not found["slope"].value > 0.0:
        raise InputError(
            "the stiffness does not rise with the preload", key="normal_force",
            remedy="check the order of normal_force, and the fixture",
        )  # fmt: skip
    if series is None and rest.interval()[0] > 0.5 * float(values.min()):
        doubts.append("most of the compliance lies in series with the interfaces; a stiffer fixture is needed")
    return ElasticSlip(_product(mu, found["slope"], 2.0 / interfaces), mu, rest, tuple(doubts))


def _coefficient(normal_force: FloatArray, capacity: list[Estimate]) -> tuple[Estimate, list[str]]:
    """mu from F_c = 2 mu F_N, and a doubt if the line misses the origin."""
    values = np.array([one.value for one in capacity])
    errors = np.array([one.error for one in capacity])
    found, _ = pooled({"slope": 2.0 * normal_force}, values, errors)
    doubts = []
    if len(np.unique(normal_force)) >= PRELOADS:
        both, _ = pooled({"slope": 2.0 * normal_force, "offset": np.ones(len(values))}, values, errors)
        if abs(both["offset"].value) > CLEAR * both["offset"].error:
            doubts.append(
                f"capacity over preload misses the origin by {both['offset'].value:.3g} N: adhesion, or an offset of "
                "force or preload"
            )
    return found["slope"], doubts


def _product(one: Estimate, other: Estimate, factor: float) -> Estimate:
    """Product of two independent estimates and a known factor."""
    value = factor * one.value * other.value
    shares = ((one.error / one.value) ** 2, (other.error / other.value) ** 2)
    return Estimate(
        value, abs(value) * float(np.sqrt(sum(shares))), combined_freedom(shares, (one.freedom, other.freedom))
    )
