"""Case file to start from (`wroll init`): a roll of the laboratory, every key with its description as a comment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel

from wroll_fem.case.case import case_kinds
from wroll_fem.case.descriptions import sections
from wroll_fem.case.loader import build_case
from wroll_fem.case.overrides import overridden
from wroll_fem.case.strict_yaml import dump_yaml
from wroll_fem.errors import InputError

_ROLL: dict[str, Any] = {
    "geometry": {"length": "300 mm", "mandrel_outer_diameter": "80 mm", "mandrel_thickness": "1.5 mm"},
    "mandrel": {
        "material": {"E": "2.7 GPa", "nu": 0.35, "rho": "1200 kg/m^3"},
        "tip_mass": "50 g", "tip": "rigid", "base": "clamped",
    },
    "coil": {
        "model": "layers", "layers": 1, "total_thickness": "1.25 mm",
        "material": {"E": "2.8 GPa", "nu": 0.35, "rho": "2000 kg/m^3"},
        "base": "free",
    },
}  # fmt: skip
_CONTACT: dict[str, Any] = {
    "contact": {"friction": {"law": "penalty_coulomb", "mu": 0.25, "elastic_slip": "1 um"}},
    "preload": {"kind": "external_pressure", "pressure": "100 kPa"},
}
_MESH: dict[str, Any] = {"mesh": {"circumferential": 24, "axial": 8}}
_BAND = {"kind": "chirp", "amplitude": "0.5 g", "f_start": "125 Hz", "f_end": "175 Hz", "rate_oct_per_min": 2.0}
_NOISE = {"kind": "random", "psd": {"frequency": [20.0, 300.0], "g2_per_hz": [0.01, 0.01]}, "duration": 30.0}
_DWELL = {"kind": "dwell", "amplitude": "0.5 g", "frequency": "150 Hz", "cycles": 40}

STARTERS: dict[str, dict[str, Any]] = {
    "sweep": _ROLL | _CONTACT | {"excitation": _BAND} | _MESH,
    "dwell": _ROLL | _CONTACT | {"excitation": _DWELL} | _MESH,
    "random": _ROLL | _CONTACT | {"excitation": _NOISE} | _MESH,
    "harmonic": _ROLL | _CONTACT | {"excitation": _BAND} | _MESH,
    "backbone": _ROLL | _CONTACT | {"backbone": {"tip_smallest": "0.1 um", "tip_largest": "0.5 mm"}} | _MESH,
    "modal": _ROLL | _CONTACT | _MESH,
    "preload": _ROLL | _CONTACT | _MESH,
    "buckling": _ROLL | _CONTACT | _MESH,
}
"""Analysis -> sections of the case to start from."""

QUESTIONS = (
    "geometry.length", "geometry.mandrel_outer_diameter", "geometry.mandrel_thickness", "mandrel.material.E",
    "mandrel.material.rho", "mandrel.tip_mass", "coil.layers", "coil.total_thickness", "coil.material.E",
    "coil.material.rho", "contact.friction.mu", "preload.pressure", "excitation.amplitude", "excitation.f_start",
    "excitation.f_end", "excitation.frequency",
)  # fmt: skip
"""Keys that are asked for, as far as the analysis has them."""


def starter_text(analysis: str, overrides: Sequence[str] = ()) -> str:
    """Commented case file of an analysis of a roll.

    Parameters
    ----------
    analysis
        Key of `STARTERS`.
    overrides
        "dotted.key=value" texts; values may have units.

    Raises
    ------
    InputError
        If there is no such starter, or the changed case is invalid.
    """
    plain = {"analysis": analysis} | _starter(analysis)
    case = build_case(plain, overrides)
    content, _ = overridden(plain, overrides)
    head = [
        "# Case for `wroll run`. Units may be changed: 300 mm, 0.3 m and 0.3 are the same length.",
        f"analysis: {analysis}",
    ]
    body = _lines({key: value for key, value in content.items() if key != "analysis"}, type(case), "")
    return "\n".join([*head, *body]) + "\n"


def questions(analysis: str) -> Iterator[tuple[str, str, Any]]:
    """For each question: dotted key, description, value to start from.

    Raises
    ------
    InputError
        If there is no such starter.
    """
    content = _starter(analysis)
    for key in QUESTIONS:
        value: Any = content
        model: type[BaseModel] = case_kinds()[analysis, False]
        description = ""
        for part in key.split("."):
            value = value.get(part) if isinstance(value, Mapping) else None
            if value is None:
                break
            description, model = _described(model, part, value)
        else:
            yield key, description, value


def _starter(analysis: str) -> dict[str, Any]:
    if analysis not in STARTERS:
        raise InputError(
            f"there is no case to start from for analysis {analysis!r}", key="--analysis",
            remedy=f"use one of {', '.join(STARTERS)}, or copy a case file from configs/",
        )  # fmt: skip
    return STARTERS[analysis]


def _lines(content: Mapping[str, Any], model: type[BaseModel], indent: str) -> Iterator[str]:
    """YAML lines of a section, one key per line, with the descriptions of ``model`` as comments."""
    for key, value in content.items():
        description, inner = _described(model, key, value)
        comment = f" # {description}" if description else ""
        if isinstance(value, Mapping):
            yield f"{indent}{key}:{comment}"
            yield from _lines(value, inner, indent + "  ")
        else:
            written = dump_yaml(value, default_flow_style=True).removesuffix("\n...\n").strip()
            yield f"{indent}{key}: {written}{comment}"


def _described(model: type[BaseModel], key: str, value: Any) -> tuple[str, type[BaseModel]]:
    """Description of a key, and the model of its section: the one whose keys and tags ``value`` has."""
    field = model.model_fields[key]
    if not isinstance(value, Mapping):
        return field.description or "", model
    options = [option for option in sections(field.annotation) if value.keys() <= option.model_fields.keys()]
    return field.description or "", next(iter(options), model)
