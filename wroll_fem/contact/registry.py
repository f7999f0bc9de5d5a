"""Registry of the friction laws: those of the package, and laws of the user (docs/joints.md).

A law of the package needs a file of its own and an entry here (docs/extend.md). A law of the user is registered from
outside, before the compiled functions are loaded: by `register_law` in a script, or by the entry point `wroll_fem.laws`
of an installed package, which also reaches the command line and the processes of a batch.
"""

from __future__ import annotations

import hashlib
import os
import sys
from importlib.metadata import entry_points
from pathlib import Path

from wroll_fem.contact.bouc_wen import BoucWen
from wroll_fem.contact.elastic_coulomb import ElasticCoulomb
from wroll_fem.contact.law import FrictionLaw
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.contact.polynomial_spring import PolynomialSpring
from wroll_fem.contact.rate_coulomb import RateCoulomb
from wroll_fem.contact.smoothed_coulomb import SmoothedCoulomb
from wroll_fem.errors import InputError

LAWS: list[type[FrictionLaw]] = [
    PenaltyCoulomb,
    RateCoulomb,
    SmoothedCoulomb,
    BoucWen,
    PolynomialSpring,
    ElasticCoulomb,
]
"""All friction laws. The index of a law in this list is its number `PointLaws.kind`."""

BY_NAME: dict[str, type[FrictionLaw]] = {law.name: law for law in LAWS}
"""Friction law for each name in case files and matrix files."""

_PACKAGE = Path(__file__).parents[1]
_LATE = ("wroll_fem.contact.laws", "wroll_fem.case.contact")
"""Modules that read the registry once: the compiled functions, and the section of the case file."""


def register_law(law: type[FrictionLaw]) -> type[FrictionLaw]:
    """Add a friction law of the user; usable as a decorator of its class.

    Parameters
    ----------
    law
        Frozen dataclass derived from `FrictionLaw`, with the function `slip_update` as a static method or in its
        module, and `slip_derivatives`; without the latter, derivatives are central differences.

    Raises
    ------
    InputError
        If the name is taken by another law, or the laws are in use already.
    """
    known = BY_NAME.get(law.name)
    if known is law:
        return law
    if known is not None:
        raise InputError(f"the friction law {law.name!r} exists", key="law", remedy="give your law another name")
    if any(module in sys.modules for module in _LATE):
        raise InputError(
            f"the friction law {law.name!r} comes too late: the other laws are in use already", key="law",
            remedy="register it directly after `import wroll_fem`, before any case is run",
        )  # fmt: skip
    LAWS.append(law)
    BY_NAME[law.name] = law
    _use_own_cache()
    return law


def _use_own_cache() -> None:
    """Let numba keep the functions compiled with the present laws in a folder of their own.

    The functions of the package contain the laws. In the cache of the package, a process without the laws of the user
    would find functions that contain them, or the reverse.
    """
    own = (getattr(sys.modules[law.__module__], "__file__", None) for law in LAWS)
    files = {*_PACKAGE.rglob("*.py"), *(Path(path) for path in own if path and Path(path).is_file())}
    stamp = "".join(f"{path}{path.stat().st_mtime_ns}" for path in sorted(files))
    key = hashlib.sha256((stamp + "".join(BY_NAME)).encode()).hexdigest()[:16]
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "wroll_fem" / "laws" / key
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(folder)


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


for _entry in entry_points(group="wroll_fem.laws"):
    register_law(_entry.load())
