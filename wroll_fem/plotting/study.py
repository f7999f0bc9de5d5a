"""Finished cases of a study: grid values, resonance, and texts for axes and legends."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.results.resonance import Resonance, resonance
from wroll_fem.signals.transmissibility import undamped
from wroll_fem.typing import FloatArray

PRESSURE, LAYER_BASE = "preload.pressure", "coil.base"
MARKERS = ("o", "s", "^", "D", "v", "P")

_QUANTITIES: dict[str, tuple[str, str, float]] = {
    PRESSURE: ("external pressure", "kPa", 1e-3),
    "contact.friction.elastic_slip": ("elastic slip γ*", "µm", 1e6),
    "contact.friction.mu": ("friction coefficient", "", 1.0),
    "coil.material.E": ("layer modulus", "GPa", 1e-9),
    "coil.material.E_theta": ("in-plane modulus", "GPa", 1e-9),
    "coil.material.G_r_theta": ("shear stiffness between wraps", "MPa", 1e-6),
    "coil.layers": ("layers", "", 1.0),
    "excitation.amplitude": ("base acceleration", "g", 1.0 / 9.80665),
    "coil.wrap_interfaces.elastic_slip": ("elastic slip between wraps", "µm", 1e6),
    "geometry.mandrel_thickness": ("mandrel wall", "mm", 1e3),
    "winding.mu": ("friction coefficient", "", 1.0),
    "winding.tension_stress": ("tension stress", "MPa", 1e-6),
    "winding.tension_newton": ("winding tension", "N", 1.0),
    "mesh.axial": ("elements along the axis", "", 1.0),
    "mesh.circumferential": ("elements around", "", 1.0),
    "mesh.grading": ("grading", "", 1.0),
    "mesh.radial": ("elements through the coil", "", 1.0),
}
"""Dotted key of the case file, such as "coil.layers" -> name, unit and scale factor in figures."""


@dataclass(frozen=True)
class StudyCase:
    """One finished case of a study.

    Attributes
    ----------
    name
        Name of the run folder.
    values
        Dotted key -> value in the grid; "case" -> name of the case file when the grid has several.
    data
        Results of the case.
    reference
        Whether it is a reference case outside the grid.
    """

    name: str
    values: Mapping[str, Any]
    data: xr.Dataset
    reference: bool = False


def read(member: StudyCase) -> Resonance:
    """Resonance and damping in the results of a case."""
    return resonance(member.data)


def natural_frequency(member: StudyCase) -> float:
    """Natural frequency (Hz) of the mode with the largest tip participation, from the results of a modal analysis.

    Raises
    ------
    InputError
        If the Dataset holds no modes or no participation.
    """
    style.require(member.data, ("mode_frequency", "tip_participation"), "reference of the figure")
    return float(member.data["mode_frequency"].values[np.abs(member.data["tip_participation"].values).argmax()])


def undamped_curve(member: StudyCase, frequency: FloatArray) -> FloatArray:
    """(n,) undamped transmissibility |T| at frequencies (n,) in Hz, from the modes of a modal analysis.

    Raises
    ------
    InputError
        If the Dataset holds no modes or no participation.
    """
    style.require(member.data, ("mode_frequency", "tip_participation"), "reference of the figure")
    return undamped(frequency, member.data["mode_frequency"].values, member.data["tip_participation"].values)


def friction_work(member: StudyCase) -> float:
    """Friction work of the whole run, J.

    Raises
    ------
    InputError
        If the Dataset holds no friction work.
    """
    style.require(member.data, ("friction_energy",), "figure of friction work")
    return float(member.data["friction_energy"].values[-1])


def is_sweep(member: StudyCase) -> bool:
    """Whether the results of a case are a sweep: a time history with a transmissibility, but no coherence."""
    data = member.data
    return "time" in data.dims and "transmissibility_real" in data and "coherence" not in data


def shown(key: str, value: Any) -> str:
    """Value of a key as text: "10 kPa", "0.1 µm", "free base"."""
    if key == LAYER_BASE:
        return f"{str(value).replace('_', ' ')} base"
    if isinstance(value, list):
        alike = all(entry == value[0] for entry in value)
        return f"{len(value)} x {shown(key, value[0])}" if alike else ", ".join(shown(key, entry) for entry in value)
    if key in _QUANTITIES and isinstance(value, int | float):
        name, unit, scale = _QUANTITIES[key]
        number = f"{scale * value:.4g}"
        if key == "coil.layers":
            return f"{number} layer{'s' if value != 1 else ''}"
        return f"{number} {unit}" if unit else f"{name} {number}"
    return str(value).replace("_", " ")


def axis_label(key: str) -> str:
    """Axis label for a key of the grid."""
    name, unit, _ = _QUANTITIES[key]
    return f"{name[0].upper()}{name[1:]}" + (f" ({unit})" if unit else "")


def grid_cases(members: Sequence[StudyCase], figure: str, *keys: str) -> list[StudyCase]:
    """Cases of the grid that have a value for each of the given keys; reference cases are left out.

    Raises
    ------
    InputError
        If there are no such cases.
    """
    found = [m for m in members if not m.reference and all(key in m.values for key in keys)]
    if not found:
        raise InputError(
            f"the figure {figure} needs cases with values of {' and '.join(keys)}", key="figure",
            remedy="add these keys to the grid, or choose another figure",
        )  # fmt: skip
    return found


def values_of(members: Sequence[StudyCase], key: str) -> list[Any]:
    """Distinct values of a key. Numbers are in ascending order, other values in the order of the cases."""
    unique = {json.dumps(m.values[key]): m.values[key] for m in members if key in m.values}
    found = list(unique.values())
    return sorted(found) if all(isinstance(value, int | float) for value in found) else found


def having(members: Sequence[StudyCase], key: str, value: Any) -> list[StudyCase]:
    """Cases with a given value of a key, and cases without the key."""
    return [m for m in members if key not in m.values or m.values[key] == value]


def scaled(key: str, value: float) -> float:
    """Value of a key in the unit used in figures."""
    return _QUANTITIES[key][2] * value


def percent(zeta: float) -> str:
    """Damping ratio as text, in percent with two decimals."""
    return f"{100 * zeta:.2f} %" if np.isfinite(zeta) else "no estimate"


def trend(values: Sequence[float], *, slack: float = 0.005) -> str:
    """Trend of values: "rises", "falls" or "changes both ways"; `slack` is a tolerance relative to their range."""
    steps = np.diff(np.asarray(values, dtype=float))
    allowed = slack * float(np.ptp(values))
    if np.all(steps > -allowed):
        return "rises"
    return "falls" if np.all(steps < allowed) else "changes both ways"


def lines_of(members: Sequence[StudyCase], key: str | None) -> dict[str, list[StudyCase]]:
    """Lines of a figure, label -> cases: one line per value of a key, separately for sweeps and steady states."""
    groups: dict[str, list[StudyCase]] = {}
    for value in values_of(members, key) if key is not None else [None]:
        for m in having(members, key, value) if key is not None else members:
            text = shown(key, value) if key is not None else ""
            text += "" if is_sweep(m) else ", harmonic balance" if text else "harmonic balance"
            groups.setdefault(text, []).append(m)
    return groups
