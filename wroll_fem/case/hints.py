"""Remedies for keys that engineers write in place of those of a case file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from wroll_fem.case.units import in_si

_OTHER_NAMES = {
    "E": ("young", "youngs_modulus", "young_modulus", "elastic_modulus", "modulus", "e_modulus"),
    "nu": ("poisson", "poissons_ratio", "poisson_ratio"),
    "rho": ("density", "mass_density"),
    "mu": ("friction_coefficient", "coefficient_of_friction", "cof"),
    "amplitude": ("acceleration", "level"),
    "f_start": ("f_min", "fmin", "start_frequency"),
    "f_end": ("f_max", "fmax", "f_stop", "end_frequency"),
    "rate_oct_per_min": ("rate", "sweep_rate"),
    "mandrel_thickness": ("thickness", "wall", "wall_thickness"),
}
"""Key -> names under which it is known elsewhere."""

_SAID = {
    ("winding", "tension"): "give tension_newton, the force on the web, N, with web_width; or tension_stress, "
    "the force divided by web_width x wrap_thickness, Pa",
    ("coil", "layer_thickness"): "give total_thickness, the thickness of all layers together, m",
    ("coil", "wrap_thickness"): "give total_thickness, the thickness of all wraps together, m",
    ("coil", "wraps"): "give total_thickness, the thickness of all wraps together, m, and layers, the number of shells "
    "that represent them",
}
"""Section and unknown key -> remedy."""

_SIZES = {"radius": ("diameter", 2.0, "twice"), "diameter": ("radius", 0.5, "half")}


def meant(keys: Sequence[str], value: Any, siblings: Sequence[str]) -> tuple[str, str]:
    """Remedy for an unknown key, and the key of the same section that was probably meant; both "" if none is known.

    Parameters
    ----------
    keys
        Path to the unknown key.
    value
        Its value.
    siblings
        Keys of its section.
    """
    name = keys[-1].lower().replace("-", "_")
    section = keys[-2] if len(keys) > 1 else ""
    said = _SAID.get((section, name.removeprefix("web_").removeprefix("winding_")))
    if said:
        return said, said.split()[1].strip(",")
    for key, others in _OTHER_NAMES.items():
        if name in others and key in siblings:
            return f"did you mean {key}?", key
    for word, (other, factor, ratio) in _SIZES.items():
        found = [key for key in siblings if other in key]
        if word in name and len(found) == 1:
            side = next((side for side in ("inner", "outer") if side in found[0]), "")
            this = f"{side} {word}".strip()
            number = in_si(value, "m") if isinstance(value, str) else value
            other_side = next((s for s in ("inner", "outer") if s in name), side)
            known = ""
            if isinstance(number, int | float) and math.isfinite(number) and side == other_side:
                known = f": {factor * number:g} m"
            return f"give {found[0]}, {ratio} the {this}{known}", found[0]
    return "", ""
