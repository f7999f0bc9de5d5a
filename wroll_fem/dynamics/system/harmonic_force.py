"""Periodic forces in addition to the excitation: any harmonic, any phase (harmonic balance only)."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from wroll_fem.dynamics.system.array_file import ArrayFile
from wroll_fem.typing import FloatArray

_FIELD = re.compile(r"force_(\d+)_(cos|sin)")


@dataclass(frozen=True, eq=False)
class HarmonicForce:
    """Force F_c cos(h w t) + F_s sin(h w t) per unit of the excitation A cos(w t).

    Attributes
    ----------
    order : harmonic h, 1 or more
    cosine, sine : (n,) F_c and F_s, N; of modal coordinates, (r,)
    """

    order: int
    cosine: FloatArray
    sine: FloatArray


def is_force_field(name: str) -> bool:
    """Whether a field of a matrix file belongs to a harmonic force."""
    return _FIELD.fullmatch(name) is not None


def force_content(forces: tuple[HarmonicForce, ...]) -> dict[str, FloatArray]:
    """Fields of a matrix file: ``force_<h>_cos`` and ``force_<h>_sin``."""
    content: dict[str, FloatArray] = {}
    for force in forces:
        for part, values in (("cos", force.cosine), ("sin", force.sine)):
            content[f"force_{force.order}_{part}"] = values
    return content


def read_forces(file: ArrayFile, n: int) -> tuple[HarmonicForce, ...]:
    """Harmonic forces of a matrix file with ``n`` degrees of freedom; a missing part is zero."""
    found: dict[int, dict[str, FloatArray]] = {}
    for name in file.names:
        match = _FIELD.fullmatch(name)
        if match is None:
            continue
        if int(match[1]) < 1:
            raise file.error("is a force at harmonic 0", key=name, remedy="give a harmonic from 1, or load_preload")
        found.setdefault(int(match[1]), {})[match[2]] = file.vector(name, n, "force on each DOF, N")
    zero = np.zeros(n)
    return tuple(HarmonicForce(h, parts.get("cos", zero), parts.get("sin", zero)) for h, parts in sorted(found.items()))
