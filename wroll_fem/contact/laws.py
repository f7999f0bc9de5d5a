r"""Friction laws of all contact points: arrays of their parameters, and the compiled functions of all registered laws.

All laws share one form. The tangential traction is :math:`\tau = (\mu p/\gamma^*)\, e`, or :math:`\tau = k_t e` with a
constant stick stiffness :math:`k_t`; a law gives e from the trial
slip :math:`e_c + \Delta g_t` and the increment :math:`\Delta g_t` of the step. A law with memory stores e as elastic
slip (trait ``stores_slip``). In a law without memory e is the traction divided by :math:`\mu p/\gamma^*`. It is not
stored, and the committed elastic slip stays zero. In statics the step is infinite, so all rates are zero.

numba inlines the functions of a point. If they were called, passing their array arguments would take ten times as long
as their arithmetic.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any, NamedTuple

import numba
import numpy as np
from numba.extending import register_jitable

from wroll_fem.contact.law import DIFFERENCE, FrictionLaw, own_parameters, sequence_parameters
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.contact.pointwise import PointwiseFriction, different_laws
from wroll_fem.contact.rate_coulomb import RateCoulomb
from wroll_fem.contact.registry import LAWS
from wroll_fem.contact.smoothed_coulomb import SmoothedCoulomb, regularised_sign, regularised_sign_slope
from wroll_fem.errors import InputError
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import BoolArray, FloatArray, IntArray

__all__ = [
    "SHARED", "FrictionLaw", "PenaltyCoulomb", "PointLaws", "PointwiseFriction", "RateCoulomb", "SmoothedCoulomb",
    "regularised_sign", "regularised_sign_slope", "slip_derivatives", "slip_update", "stack_laws",
]  # fmt: skip

drop_stale_cache(__file__)


class PointLaws(NamedTuple):
    """Parameters of the friction and normal laws at the points of all interfaces, innermost interface first.

    Attributes
    ----------
    area : (n,) m^2
    kn : (n,) normal penalty, Pa/m
    separation : (n,) bool
    mu : (n,) coefficient of friction; its value at rest if the law depends on the slip rate
    gamma : (n,) largest elastic slip, m; for a law without memory the length that normalises its traction
    kind : (n,) int64, index of the law in `registry.LAWS`
    stores_slip, sticks, elastic, exact_increment : (n,) bool, traits of the law (see `FrictionLaw`)
    weakening : (n,) velocity-weakening slope of the law, s/m
    stick : (n,) constant stick stiffness of the law, Pa/m; 0 if it is proportional to the pressure
    follows : (n,) 1 if the stick stiffness is proportional to the pressure, 0 if it is constant
    own : (n, c) other parameters of the law that are numbers, in the order of its parameters; c is the largest number
        of such parameters in a law
    table : (n,) int64, index of the law's table in ``tables``
    tables : (n_tables, c, L) parameters of the laws that are sequences: at most c sequences of at most L numbers per
        law, in the order of its parameters. Short sequences repeat their last number. Shared by all points.
    """

    area: FloatArray
    kn: FloatArray
    separation: BoolArray
    mu: FloatArray
    gamma: FloatArray
    kind: IntArray
    stores_slip: BoolArray
    sticks: BoolArray
    elastic: BoolArray
    exact_increment: BoolArray
    weakening: FloatArray
    stick: FloatArray
    follows: FloatArray
    own: FloatArray
    table: IntArray
    tables: FloatArray

    @property
    def n(self) -> int:
        """Number of contact points."""
        return len(self.area)

    def take(self, points: np.ndarray) -> PointLaws:
        """Law parameters at the contact ``points`` with the given indices; ``tables`` is kept unchanged."""
        return self._replace(**{name: getattr(self, name)[points] for name in self._fields if name not in SHARED})


SHARED = ("tables",)
"""Fields of `PointLaws` that all points share; the other fields have one entry for each point."""


def stack_laws(
    areas: Sequence[FloatArray],
    friction: Sequence[FrictionLaw | PointwiseFriction],
    stiffness: Sequence[float | FloatArray],
    separation: Sequence[bool | BoolArray],
) -> PointLaws:
    """Law parameters at all contact points, collected from the laws of each interface.

    Parameters
    ----------
    areas : (n_i,) tributary areas of the points of each interface, m^2
    friction : friction law of each interface, or the laws of its points
    stiffness, separation : normal penalty (Pa/m) and separation flag of each interface; one value, or (n_i,) values

    Raises
    ------
    InputError
        If an object is not a registered friction law.
    """
    found, which = different_laws(friction, [len(area) for area in areas])

    def column(values: Sequence[Any], dtype: type = float) -> np.ndarray:
        return np.array(values, dtype)[which]

    def normal(values: Sequence[Any], dtype: type) -> np.ndarray:
        spread = [np.broadcast_to(value, len(area)) for value, area in zip(values, areas, strict=True)]
        return np.concatenate([*spread, np.zeros(0)]).astype(dtype)

    rows = [[getattr(law, name) for name in sequence_parameters(type(law))] for law in found]
    tabled = [row for row in rows if row]
    return PointLaws(
        area=np.concatenate([*areas, np.zeros(0)]),
        kn=normal(stiffness, float),
        separation=normal(separation, bool),
        mu=column([law.mu for law in found]),
        gamma=column([law.elastic_slip for law in found]),
        kind=column([LAWS.index(type(law)) for law in found], np.int64),
        stores_slip=column([law.stores_slip for law in found], bool),
        sticks=column([law.sticks for law in found], bool),
        elastic=column([law.elastic for law in found], bool),
        exact_increment=column([law.exact_increment for law in found], bool),
        weakening=column([law.weakening_slope for law in found]),
        stick=column([law.constant_stick for law in found]),
        follows=column([float(not law.constant_stick) for law in found]),
        own=_padded([[[getattr(law, name)] for name in own_parameters(type(law))] for law in found])[which, :, 0],
        table=column([sum(bool(row) for row in rows[:i]) if row else 0 for i, row in enumerate(rows)], np.int64),
        tables=_padded(tabled),
    )


def _padded(rows: Sequence[Sequence[Sequence[float]]]) -> FloatArray:
    """Put n rows into one array (n, c, L). A row contains at most c sequences, a sequence at most L numbers.

    Missing sequences become 0. Short sequences repeat their last number.
    """
    columns = max((len(row) for row in rows), default=0)
    length = max((len(values) for row in rows for values in row), default=1)
    out = np.zeros((len(rows), columns, length))
    for i, row in enumerate(rows):
        for c, values in enumerate(row):
            out[i, c] = [*values, *[values[-1]] * (length - len(values))]
    return out


# ---- compiled functions ----------------------------------------------------------------------------------------------


_INLINED: dict[Callable[..., Any], Callable[..., Any]] = {}


def _inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function from the file of a law such that numba inlines it and every Python function that it calls.

    Functions of numbers alone that the file lists in ``CALLED`` are called instead; long ones compile faster so.

    `register_jitable` with inlining would also work, but numba would then count references to the array arguments, and
    the loops over the points would take twenty times as long.
    """
    if function not in _INLINED:
        names = dict(function.__globals__)
        for name in function.__code__.co_names:
            if inspect.isfunction(names.get(name)):
                names[name] = _inlined(names[name])
        called = function.__name__ in names.get("CALLED", ())
        _INLINED[function] = numba.njit(inline="never" if called else "always")(
            FunctionType(function.__code__, names, function.__name__)
        )
    return _INLINED[function]


def _compiled(name: str) -> list[Callable[..., Any]]:
    """Compiled function ``name`` of every registered law, in the order of the registry."""
    return [_inlined(_function(law, name)) for law in LAWS]


def _function(law: type[FrictionLaw], name: str) -> Callable[..., Any]:
    """Function ``name`` of a law: a static method of its class, or a function of its module.

    Missing derivatives are central differences.

    Raises
    ------
    InputError
        If the law has no function `slip_update`.
    """
    found = getattr(law, name, None) or getattr(sys.modules[law.__module__], name, None)
    if found is None and name == "slip_derivatives":
        names = {"UPDATE": _inlined(_function(law, "slip_update")), "H": DIFFERENCE}
        return FunctionType(_differences.__code__, names, "differences")
    if found is None:
        raise InputError(f"the friction law {law.name!r} has no function {name}", key="law", remedy="write it")
    return getattr(found, "py_func", found)  # that of a function which numba has compiled


def _differences(k, trial_h, trial_z, dg_h, dg_z, p, laws, dt):  # type: ignore[no-untyped-def]
    d = H * laws.gamma[k]  # type: ignore[name-defined]  # noqa: F821
    r_h, r_z, _ = UPDATE(k, trial_h + d, trial_z, dg_h, dg_z, p, laws, dt)  # type: ignore[name-defined]  # noqa: F821
    l_h, l_z, _ = UPDATE(k, trial_h - d, trial_z, dg_h, dg_z, p, laws, dt)  # type: ignore[name-defined]  # noqa: F821
    a00, a10 = 0.5 * (r_h - l_h) / d, 0.5 * (r_z - l_z) / d
    r_h, r_z, _ = UPDATE(k, trial_h, trial_z + d, dg_h, dg_z, p, laws, dt)  # type: ignore[name-defined]  # noqa: F821
    l_h, l_z, _ = UPDATE(k, trial_h, trial_z - d, dg_h, dg_z, p, laws, dt)  # type: ignore[name-defined]  # noqa: F821
    a01, a11 = 0.5 * (r_h - l_h) / d, 0.5 * (r_z - l_z) / d
    r_h, r_z, _ = UPDATE(k, trial_h, trial_z, dg_h + d, dg_z, p, laws, dt)  # type: ignore[name-defined]  # noqa: F821
    l_h, l_z, _ = UPDATE(k, trial_h, trial_z, dg_h - d, dg_z, p, laws, dt)  # type: ignore[name-defined]  # noqa: F821
    b00, b10 = 0.5 * (r_h - l_h) / d, 0.5 * (r_z - l_z) / d
    r_h, r_z, _ = UPDATE(k, trial_h, trial_z, dg_h, dg_z + d, p, laws, dt)  # type: ignore[name-defined]  # noqa: F821
    l_h, l_z, _ = UPDATE(k, trial_h, trial_z, dg_h, dg_z - d, p, laws, dt)  # type: ignore[name-defined]  # noqa: F821
    return a00, a01, a10, a11, b00, 0.5 * (r_h - l_h) / d, b10, 0.5 * (r_z - l_z) / d


for _scalar in (regularised_sign, regularised_sign_slope):
    register_jitable(_scalar)  # so that compiled code elsewhere may call them


def _by_kind(functions: Sequence[Callable[..., Any]], number: int = 0) -> Callable[..., Any]:
    """One compiled function that selects the law of a point by its number `PointLaws.kind` and calls it."""
    if len(functions) == 1:
        return functions[0]
    names = {"NUMBER": number, "LAW": functions[0], "OTHERS": _by_kind(functions[1:], number + 1)}
    return numba.njit(inline="always")(FunctionType(_choose.__code__, names, "choose"))


def _choose(k, trial_h, trial_z, dg_h, dg_z, p, laws, dt):  # type: ignore[no-untyped-def]
    if laws.kind[k] == NUMBER:  # type: ignore[name-defined]  # noqa: F821
        return LAW(k, trial_h, trial_z, dg_h, dg_z, p, laws, dt)  # type: ignore[name-defined]  # noqa: F821
    return OTHERS(k, trial_h, trial_z, dg_h, dg_z, p, laws, dt)  # type: ignore[name-defined]  # noqa: F821


slip_update = _by_kind(_compiled("slip_update"))
"""Friction law of a point: e (hoop, axial), m, and whether the point slides. e is the tangential traction divided by
the stick stiffness.

Arguments: index k of the point; trial slip (hoop, axial), m; increment of the relative displacement (hoop, axial), m;
pressure at the end of the step, Pa, which only laws with a constant stick stiffness use; `PointLaws`; size of the time
step, s (infinite in statics). The trial slip is the committed elastic slip plus the increment.
"""

slip_derivatives = _by_kind(_compiled("slip_derivatives"))
"""Derivatives of e (see `slip_update`) with respect to the trial slip, then with respect to the increment. Each is a
2 x 2 matrix, given by its entries 00, 01, 10, 11 (0: hoop, 1: axial)."""
