r"""Friction laws point by point: parameters of all points, and the dispatch on the kind of law.

All laws share one form. The tangential traction is :math:`\tau = (\mu p/\gamma^*)\, e`; a law says how e follows
from the trial slip :math:`e_c + \Delta g_t` and the increment :math:`\Delta g_t` of the step. Penalty and rate law
keep e as elastic slip. The smoothed law has no memory: its e is the traction normalised by :math:`\mu p/\gamma^*`,
nothing is stored, and the committed elastic slip stays zero. Statics use an infinite step, so all rates are zero.

The functions of a point are inlined by numba: called, their array arguments cost ten times their arithmetic.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.contact import penalty_coulomb, rate_coulomb, smoothed_coulomb
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.contact.rate_coulomb import RateCoulomb
from wroll_fem.contact.smoothed_coulomb import SmoothedCoulomb
from wroll_fem.errors import InputError
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__)

PENALTY, RATE, SMOOTHED = penalty_coulomb.KIND, rate_coulomb.KIND, smoothed_coulomb.KIND

FrictionLaw = PenaltyCoulomb | RateCoulomb | SmoothedCoulomb


class PointLaws(NamedTuple):
    """Law parameters of every point of all interfaces, stacked (inner interface first).

    Attributes
    ----------
    area : (n,) m^2
    kn : (n,) normal penalty, Pa/m
    separation : (n,) bool
    mu : (n,) coefficient of friction, at rest for the rate law
    gamma : (n,) elastic slip, m; for the smoothed law the length that normalises its traction
    kind : (n,) int64, PENALTY, RATE or SMOOTHED
    speed : (n,) reference speed of the smoothed law, m/s
    table : (n,) int64, row of the rate tables
    rates, coefficients : (n_tables, L) slip rates in m/s and coefficients; short tables end in copies of their last
    """

    area: np.ndarray
    kn: np.ndarray
    separation: np.ndarray
    mu: np.ndarray
    gamma: np.ndarray
    kind: np.ndarray
    speed: np.ndarray
    table: np.ndarray
    rates: np.ndarray
    coefficients: np.ndarray

    @property
    def n(self) -> int:
        """Number of points."""
        return len(self.area)

    def take(self, points: np.ndarray) -> PointLaws:
        """Laws of some ``points`` (index array): every column of them, the tables being shared by all."""
        return self._replace(**{name: getattr(self, name)[points] for name in self._fields if name not in SHARED})


SHARED = ("rates", "coefficients")
"""Fields of `PointLaws` that have no entry per point."""


def stack_laws(
    areas: list[np.ndarray], friction: list[FrictionLaw], stiffness: list[float], separation: list[bool]
) -> PointLaws:
    """Parameters of all points from the laws of each interface.

    Parameters
    ----------
    areas : (n_i,) area per point of each interface, m^2
    friction, stiffness, separation : tangential law, normal penalty (Pa/m) and flag of each interface

    Raises
    ------
    InputError
        For an object that is not a known friction law.
    """
    counts = [len(area) for area in areas]
    tables = [law for law in friction if isinstance(law, RateCoulomb)]
    length = max((len(law.rates) for law in tables), default=0)

    def stacked(values: list, dtype: type = float) -> np.ndarray:
        return np.repeat(np.array(values, dtype), counts) if counts else np.zeros(0, dtype)

    def padded(rows: list[tuple[float, ...]]) -> np.ndarray:
        return np.array([[*row, *[row[-1]] * (length - len(row))] for row in rows]).reshape(len(rows), length)

    return PointLaws(
        area=np.concatenate([*areas, np.zeros(0)]),
        kn=stacked(stiffness),
        separation=stacked(separation, bool),
        mu=stacked([law.mu for law in friction]),
        gamma=stacked([law.elastic_slip for law in friction]),
        kind=stacked([_kind(law) for law in friction], np.int64),
        speed=stacked([law.reference_speed if isinstance(law, SmoothedCoulomb) else 1.0 for law in friction]),
        table=stacked([tables.index(law) if isinstance(law, RateCoulomb) else 0 for law in friction], np.int64),
        rates=padded([law.rates for law in tables]),
        coefficients=padded([law.coefficients for law in tables]),
    )


_KINDS: dict[type, int] = {PenaltyCoulomb: PENALTY, RateCoulomb: RATE, SmoothedCoulomb: SMOOTHED}


def _kind(law: FrictionLaw) -> int:
    if type(law) not in _KINDS:
        known = ", ".join(kind.__name__ for kind in _KINDS)
        raise InputError(
            f"{type(law).__name__} is not a registered friction law", key="contact.friction", remedy=f"use {known}"
        )
    return _KINDS[type(law)]


@numba.njit(cache=True, inline="always")
def slip_update(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, laws: PointLaws, dt: float
) -> tuple[float, float, bool]:
    """Normalised traction e (hoop, axial) of point ``k`` in m, and whether it slides.

    Parameters
    ----------
    trial_h, trial_z : e_c plus increment, m
    dg_h, dg_z : increment of the relative displacement in this step, m
    dt : step, s; infinite in statics
    """
    if laws.kind[k] == PENALTY:
        return penalty_coulomb.slip_update(trial_h, trial_z, laws.gamma[k])
    if laws.kind[k] == RATE:
        return rate_coulomb.slip_update(
            trial_h, trial_z, dg_h, dg_z, laws.gamma[k], laws.table[k], laws.rates, laws.coefficients, dt
        )
    return smoothed_coulomb.slip_update(dg_h, dg_z, laws.gamma[k], laws.speed[k], dt)


@numba.njit(cache=True, inline="always")
def slip_derivatives(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, laws: PointLaws, dt: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Derivatives of `slip_update`: (00, 01, 10, 11) by the trial slip at fixed increment, then the other way round."""
    if laws.kind[k] == PENALTY:
        a00, a01, a10, a11 = penalty_coulomb.slip_derivatives(trial_h, trial_z, laws.gamma[k])
        return a00, a01, a10, a11, 0.0, 0.0, 0.0, 0.0
    if laws.kind[k] == RATE:
        return rate_coulomb.slip_derivatives(
            trial_h, trial_z, dg_h, dg_z, laws.gamma[k], laws.table[k], laws.rates, laws.coefficients, dt
        )
    b00, b01, b10, b11 = smoothed_coulomb.slip_derivatives(dg_h, dg_z, laws.gamma[k], laws.speed[k], dt)
    return 0.0, 0.0, 0.0, 0.0, b00, b01, b10, b11
