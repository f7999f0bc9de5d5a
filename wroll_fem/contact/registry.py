"""Registry of the friction laws. A new law needs a file of its own and an entry here (docs/extend.md)."""

from __future__ import annotations

from wroll_fem.contact.bouc_wen import BoucWen
from wroll_fem.contact.law import FrictionLaw
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.contact.polynomial_spring import PolynomialSpring
from wroll_fem.contact.rate_coulomb import RateCoulomb
from wroll_fem.contact.smoothed_coulomb import SmoothedCoulomb
from wroll_fem.errors import InputError

LAWS: tuple[type[FrictionLaw], ...] = (
    PenaltyCoulomb,
    RateCoulomb,
    SmoothedCoulomb,
    BoucWen,
    PolynomialSpring,
)
"""All friction laws. The index of a law in this tuple is its number `PointLaws.kind`."""

BY_NAME: dict[str, type[FrictionLaw]] = {law.name: law for law in LAWS}
"""Friction law for each name in case files and matrix files."""


def check_registered(law: object) -> None:
    """Refuse an object that is not a registered friction law.

    Raises
    ------
    InputError
        If it is not; the remedy lists the registered laws.
    """
    if type(law) not in LAWS:
        known = ", ".join(kind.__name__ for kind in LAWS)
        raise InputError(
            f"{type(law).__name__} is not a registered friction law", key="contact.friction", remedy=f"use {known}"
        )
