"""Base class of the friction laws: a law declares its name, its parameters with meaning and bounds, and its traits.

Each law has its own file. The file contains a frozen dataclass derived from `FrictionLaw` and a function for one
point, `slip_update`, and usually its `slip_derivatives` (see `laws`). It imports neither numba nor numpy, because the
case file is read without them. `laws` compiles the functions of all laws in `registry`.
"""

from __future__ import annotations

import math
from dataclasses import fields, replace
from functools import cache
from typing import Annotated, Any, ClassVar, NamedTuple, Self, cast, get_args, get_origin, get_type_hints

from wroll_fem.errors import InputError

DIFFERENCE = 1e-5
"""Increment of central differences of a law, relative to gamma*."""


class Parameter(NamedTuple):
    """Meaning (with unit) and bound of a parameter: greater than ``above``, or at least ``least``."""

    meaning: str
    above: float | None = None
    least: float | None = None


class FrictionLaw:
    """Base class of the friction laws.

    The traction is tau = (mu p / elastic_slip) e; the law gives e. A parameter is a field with the annotation
    ``Annotated[float, Parameter(...)]``. The compiled functions find the parameters of point k other than ``mu`` and
    ``elastic_slip`` in ``laws.own[k, i]`` (numbers) and in ``laws.tables[laws.table[k], i, :]`` (sequences of numbers).
    The index i counts each of the two kinds in the order of the fields.

    Attributes
    ----------
    name : value of `contact.friction.law` in the case file
    sentence : one sentence about the law, for the reference of the case file
    stores_slip : True: e is an elastic slip, kept from step to step, and its energy is recovered. False: the law has no
        memory
    sticks : True: at a point that does not slide, e is equal to the trial slip
    elastic : True: e depends on the relative displacement from the reference state alone. The trial slip is then this
        displacement, and it is stored in place of e
    exact_increment : True: harmonic balance passes the difference between two samples as the increment, as a law that
        integrates along the path requires; False: the slip rate times the time between samples
    in_rolls : True: the law can be chosen in `contact.friction`; False: only in matrix files and joints
    mu : coefficient of friction at rest
    elastic_slip : gamma*, m; relative displacement at which sliding starts, or the length that normalises the traction
    """

    name: ClassVar[str]
    sentence: ClassVar[str]
    stores_slip: ClassVar[bool] = True
    sticks: ClassVar[bool] = True
    elastic: ClassVar[bool] = False
    exact_increment: ClassVar[bool] = False
    in_rolls: ClassVar[bool] = True
    mu: float
    elastic_slip: float

    @property
    def weakening_slope(self) -> float:
        """Velocity-weakening slope: largest -d mu / dV, s/m; 0 if mu never decreases with the slip rate V."""
        return 0.0

    @property
    def constant_stick(self) -> float:
        """Stick stiffness, Pa/m, if it is constant; 0 if it is mu p / elastic_slip, proportional to the pressure."""
        return 0.0

    @property
    def acts_at_rest(self) -> bool:
        """Whether a point at rest transmits a tangential traction under pressure."""
        return self.constant_stick > 0.0 or math.isfinite(self.rest_length(math.inf))

    def rest_length(self, dt: float) -> float:
        """Length L, m, in the tangent stiffness mu p / L at rest, for a step ``dt`` (s; infinite in statics)."""
        return self.elastic_slip

    def in_series(self, count: float) -> Self:
        """Law of an interface that stands for ``count`` interfaces in series, each with this law.

        All of them carry the same traction, so their relative displacements add up: lengths and slip rates of the law
        are multiplied by ``count``, the limit mu p stays. A law with a length other than ``elastic_slip``, or with a
        slip rate or a stiffness, overrides this.

        Raises
        ------
        InputError
            If the law has no elastic slip of its own.
        """
        if count == 1.0:
            return self
        if "elastic_slip" not in parameters(type(self)):
            raise InputError(
                f"{self.name} has no elastic slip that interfaces in series could add up", key="contact.friction.law",
                remedy="leave coil.per_wrap out, or give the law a method in_series",
            )  # fmt: skip
        return replace(self, elastic_slip=count * self.elastic_slip)  # type: ignore[type-var]

    @classmethod
    def from_section(cls, section: Any) -> Self:
        """Law from the case section `contact.friction`, whose keys are the parameters of the law."""
        return cls(**{name: getattr(section, name) for name in parameters(cls)})


@cache
def _hints(law: Any) -> dict[str, Any]:
    """Annotations of a law; their evaluation takes a millisecond, and every set of laws of points asks for them."""
    return get_type_hints(law, include_extras=True)


def parameters(law: type[FrictionLaw]) -> dict[str, Parameter]:
    """Parameters of a law by name, in the order of its fields."""
    hints = _hints(cast(Any, law))  # mypy takes the hash of the class for that of its objects
    found = {}
    for entry in fields(law):  # type: ignore[arg-type]  # every law is a dataclass
        hint = hints[entry.name]
        notes = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
        found[entry.name] = next((note for note in notes if isinstance(note, Parameter)), Parameter(entry.name))
    return found


def sequence_parameters(law: type[FrictionLaw]) -> list[str]:
    """Names of the parameters that are sequences of numbers."""
    hints = _hints(cast(Any, law))
    return [name for name in parameters(law) if _is_sequence(hints[name])]


def _is_sequence(hint: Any) -> bool:
    return get_origin(get_args(hint)[0] if get_origin(hint) is Annotated else hint) is tuple


def own_parameters(law: type[FrictionLaw]) -> list[str]:
    """Names of the parameters that are numbers, except ``mu`` and ``elastic_slip``, which every law has."""
    sequences = sequence_parameters(law)
    return [name for name in parameters(law) if name not in ("mu", "elastic_slip", *sequences)]
