"""Contact laws of an interface as fields of a matrix file (see `io`): names, writing and reading."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from wroll_fem.contact.interface import Interface, NormalPenalty
from wroll_fem.contact.law import FrictionLaw, parameters, sequence_parameters
from wroll_fem.contact.pointwise import PointwiseFriction
from wroll_fem.contact.registry import BY_NAME, check_registered
from wroll_fem.dynamics.system.array_file import ArrayFile
from wroll_fem.errors import InputError

FRICTION_LAWS = BY_NAME
"""Friction laws by their name in `contact.friction.law`; parameters have the same names in a file as in the law."""


def law_field_names(file: ArrayFile) -> list[str]:
    """Names of all fields for the contact laws of an interface in ``file``, without the prefix ``interface_<k>_``."""
    of_law = ["law", *dict.fromkeys(name for law in FRICTION_LAWS.values() for name in parameters(law))]
    numbered = {m[1] for name in file.names if (m := re.match(r"interface_\d+_(friction_\d+_)", name))}
    names = [f"{start}{name}" for start in ("friction_", *sorted(numbered)) for name in of_law]
    return [*names, "friction_index", "normal_stiffness", "normal_separation"]


def law_fields(interface: Interface) -> dict[str, Any]:
    """Fields with the contact laws of an interface, by name without the prefix ``interface_<k>_``.

    Raises
    ------
    InputError
        If a law is not registered.
    """
    law, normal = interface.friction, interface.normal
    content: dict[str, Any] = {}
    if isinstance(law, PointwiseFriction):
        content["friction_index"] = law.index + 1.0
        for number, one in enumerate(law.laws, start=1):
            content |= _law_content(one, f"friction_{number}_")
    else:
        content |= _law_content(law, "friction_")
    content["normal_stiffness"] = normal.stiffness
    content["normal_separation"] = np.array(normal.separation, float)
    return content


def _law_content(law: FrictionLaw, start: str) -> dict[str, Any]:
    check_registered(law)
    values = {f"{start}{name}": np.array(getattr(law, name), float) for name in parameters(type(law))}
    return {f"{start}law": law.name} | values


def read_laws(
    file: ArrayFile, number: int, friction: FrictionLaw | None, stiffness: float | None, separation: bool | None
) -> tuple[FrictionLaw | PointwiseFriction, NormalPenalty, bool]:
    """Friction law and normal law to be used in interface ``number``, and whether they differ from those in the file.

    ``friction``, ``stiffness`` (Pa/m) and ``separation`` replace the values in the file.

    Raises
    ------
    InputError
        If a field is missing or invalid; the message names file and field.
    """
    own = f"interface_{number}_"
    given = f"{own}friction_law" in file or f"{own}friction_index" in file
    law = _friction(file, own) if friction is None or given else None
    key, meaning = f"{own}normal_stiffness", "normal contact stiffness, Pa/m; or give contact.normal.penalty"
    kn = _one_or_many(file.vector(key, None, meaning)) if stiffness is None or key in file else None
    if kn is not None and not np.all(kn > 0.0):
        raise file.error(f"is {np.min(kn):g} Pa/m", key=key, remedy="give a positive stiffness")
    key = f"{own}normal_separation"
    opens = _one_or_many(file.vector(key, None, "1: opens, 0: does not") != 0.0) if key in file else True
    used = friction or law, kn if stiffness is None else stiffness, opens if separation is None else separation
    assert used[0] is not None
    assert used[1] is not None
    kept = (friction is None or friction == law) and np.array_equal(used[1], kn) and np.array_equal(used[2], opens)  # type: ignore[arg-type]
    return used[0], NormalPenalty(used[1], used[2]), not kept


def _one_or_many(values: np.ndarray) -> Any:
    """The single value of an array of length 1 (for all points), otherwise the array (one value per point)."""
    return values[0].item() if values.size == 1 else values


def _friction(file: ArrayFile, own: str) -> FrictionLaw | PointwiseFriction:
    key = f"{own}friction_index"
    if key not in file:
        return _law(file, f"{own}friction_")
    index = file.vector(key, None, "law of each point, counted from 1").astype(np.int64)
    laws = [_law(file, f"{own}friction_{number}_") for number in range(1, int(index.max(initial=0)) + 1)]
    try:
        return PointwiseFriction(tuple(laws), index - 1)
    except InputError as error:
        raise file.error(error.problem, key=key, remedy="give the number of a law, from 1, for each point") from None


def _law(file: ArrayFile, start: str) -> FrictionLaw:
    key = f"{start}law"
    name = file.text(key, "friction law; or give contact.friction in the case file")
    if name not in FRICTION_LAWS:
        raise file.error(f"is {name!r}", key=key, remedy=f"use one of: {', '.join(FRICTION_LAWS)}")
    law = FRICTION_LAWS[name]
    values: dict[str, Any] = {}
    for parameter in parameters(law):
        field, meaning = f"{start}{parameter}", f"{parameter} of {name}"
        if parameter in sequence_parameters(law):
            values[parameter] = tuple(file.vector(field, None, meaning).tolist())
        else:
            values[parameter] = file.number(field, meaning)
    try:
        return law(**values)
    except InputError as error:
        raise file.error(error.problem, key=key, remedy=error.remedy or "correct the parameter") from None
