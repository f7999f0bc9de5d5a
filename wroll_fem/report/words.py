"""A case in words, from the plain content of its case.yaml (so that cases of other versions can be told, too)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from wroll_fem.analyses.registry import MODULES, find_analysis
from wroll_fem.report.values import quantity

Plain = Mapping[str, Any]

_MODELS = {
    "layers": "concentric layers that touch and slip",
    "bonded": "concentric layers bonded to the mandrel",
    "solid": "one homogenised solid",
    "nonstructural_mass": "mass without stiffness",
    "none": "no coil",
}
_QUIET = ("output", "modal", "harmonic", "backbone")  # written out in the YAML
_WITHOUT_STEPS = ("modal", "modal_transient", "winding", "design_map", "two_dof")


def case_words(data: Plain) -> list[tuple[str, str]]:
    """Headings and sentences, one for each section that matters; unknown sections as they are written."""
    analysis = str(data.get("analysis", "unknown"))
    said = [("Analysis", f"{analysis}. {find_analysis(analysis).sentence if analysis in MODULES else ''}".strip())]
    for key, value in data.items():
        if key == "analysis" or value is None or (key in _QUIET and key != analysis):
            continue
        if key in ("integrator", "solver") and analysis in _WITHOUT_STEPS:
            continue
        if isinstance(value, Mapping):
            words = _tell(_SECTIONS[key], value) if key in _SECTIONS else _as_written(value)
        else:
            words = _as_written({key: value})
        if words:
            said.append((key.replace("_", " ").capitalize(), words))
    return said


def _tell(section: Callable[[Plain], str], value: Plain) -> str:
    """Sentence of a section; as it is written where it holds something else than expected."""
    try:
        return section(value)
    except (KeyError, TypeError, ValueError):
        return _as_written(value)


def _number(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list) and len(value) > 12:
        return f"{len(value)} values from {_number(value[0])} to {_number(value[-1])}"
    if isinstance(value, list):
        return "[" + ", ".join(_number(item) for item in value) + "]"
    return f"{{{_as_written(value)}}}" if isinstance(value, Mapping) else str(value)


def _as_written(section: Plain) -> str:
    return ", ".join(f"{key}: {_number(value)}" for key, value in section.items() if value is not None)


def _geometry(s: Plain) -> str:
    return (
        f"tube of {_mm(s['length'])} length, {_mm(s['mandrel_outer_diameter'])} outer diameter, "
        f"{_mm(s['mandrel_thickness'])} wall"
    )


def _mm(value: float) -> str:
    return f"{1e3 * value:.4g} mm"


def _material(m: Plain) -> str:
    if "E" in m:
        return f"E = {quantity(m['E'], 'Pa')}, nu = {m['nu']:.3g}, density {m['rho']:.4g} kg/m³"
    moduli = ", ".join(f"{k} = {quantity(v, 'Pa')}" for k, v in m.items() if k[:2] in ("E_", "G_"))
    return f"orthotropic: {moduli}, density {m['rho']:.4g} kg/m³"


def _mandrel(s: Plain) -> str:
    words = f"{_material(s['material'])}; base {s['base']}, tip {s['tip']}"
    return words + (f" with {quantity(s['tip_mass'], 'kg')} on it" if s.get("tip_mass") else "")


def _coil(s: Plain) -> str:
    words = _MODELS[s["model"]]
    if s["model"] == "none":
        return words
    if s["model"] in ("layers", "bonded"):
        words = f"{s['layers']} " + (
            words
            if s["layers"] != 1
            else words.replace("layers", "layer").replace("that touch and slip", "that touches and slips")
        )
    thickness = s.get("total_thickness") or s.get("thickness")
    words += f", {_mm(thickness)} thick in all" if thickness else ""
    return f"{words}; {_material(s['material'])}; base {s['base']}"


def _contact(s: Plain) -> str:
    f = s["friction"]
    words = f"{f['law'].replace('_', ' ')}, mu = {_number(f['mu'])}"
    words += f", elastic slip {quantity(f['elastic_slip'], 'm')}" if "elastic_slip" in f else ""
    words += f", reference speed {quantity(f['reference_speed'], 'm')}/s" if "reference_speed" in f else ""
    if "normal" in s:
        words += "; surfaces may separate" if s["normal"]["separation"] else "; surfaces never separate"
    return words


def _preload(s: Plain) -> str:
    if s["kind"] != "external_pressure":
        return "pressures that the winding leaves" if s["kind"] == "winding_tension" else _as_written(s)
    pressure = s["pressure"]
    if isinstance(pressure, list):
        return "external pressure on the layers, inner first: " + ", ".join(quantity(p, "Pa") for p in pressure)
    return f"external pressure of {quantity(pressure, 'Pa')}"


def _excitation(s: Plain) -> str:
    along = f" along {s['direction']}" if "direction" in s else ""
    if s["kind"] == "chirp":
        return (
            f"sine sweep from {s['f_start']:g} to {s['f_end']:g} Hz at {s['rate_oct_per_min']:.4g} oct/min, "
            f"{s['amplitude']:.4g} m/s² (0-peak){along}"
        )
    if s["kind"] == "dwell":
        return f"{s['cycles']:g} cycles at {s['frequency']:g} Hz, {s['amplitude']:.4g} m/s² (0-peak){along}"
    frequency = s["frequency"] if isinstance(s["frequency"], str) else f"{s['frequency']:g} Hz"
    return f"sine at {frequency}, levels of {', '.join(f'{a:g}' for a in s['amplitude_g'])} g (0-peak){along}"


def _integrator(s: Plain) -> str:
    alpha = f", alpha = {s['alpha']:g}" if s["scheme"] == "hht" else ""
    return f"{s['scheme'].replace('_', ' ')}{alpha}; {s['steps_per_cycle']} steps per cycle of the highest frequency"


def _mesh(s: Plain) -> str:
    if s.get("file"):
        return f"from {s['file']}"
    return f"{s['circumferential']} elements around, {s['axial']} along the axis (grading {s['grading']:g})"


def _solver(s: Plain) -> str:
    return f"{s['method']}, residual below {s['tolerance']:g}" + ("; half roll by symmetry" if s["symmetry"] else "")


def _winding(s: Plain) -> str:
    words = f"{s['wraps']} wraps of {_mm(s['wrap_thickness'])}"
    if s.get("tension_stress"):
        words += f", tension stress {quantity(s['tension_stress'], 'Pa')}"
    if s.get("tension_newton"):
        words += f", tension {quantity(s['tension_newton'], 'N')} over {_mm(s['web_width'])} of width"
    words += f" ({s['tension_profile']['kind']})" if "tension_profile" in s else ""
    words += f", mu = {s['mu']:g}" if s.get("mu") is not None else ""
    if s.get("mandrel"):
        words += f"; on a mandrel of {_mm(s['mandrel']['outer_radius'])} radius"
    web = s["web"]
    modulus = _as_written(web["radial_modulus"])
    return f"{words}; web with E = {quantity(web['E_theta'], 'Pa')} along it, radial modulus {modulus}"


_SECTIONS: dict[str, Callable[[Plain], str]] = {
    "geometry": _geometry, "mandrel": _mandrel, "coil": _coil, "contact": _contact, "preload": _preload,
    "excitation": _excitation, "winding": _winding, "integrator": _integrator, "mesh": _mesh, "solver": _solver,
}  # fmt: skip
