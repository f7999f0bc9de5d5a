"""Case file with matrices for a mass on a spring that is pressed onto the ground."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
import yaml
from typer.testing import CliRunner

from wroll_fem.cli import app

DWELL = {"kind": "dwell", "amplitude": 6.0, "frequency": 11.0, "cycles": 30.0, "ramp_cycles": 5.0}

K, MASS, FORCE, MU, GAMMA = 1.0e4, 1.0, 10.0, 0.3, 1.0e-5
"""Spring N/m, mass kg, pressing force N, coefficient, elastic slip m of the hand-written oscillator."""


def oscillator(**changes: Any) -> dict[str, Any]:
    """Fields of docs/matrices.md for a mass on a spring, pressed onto the ground; None takes a field out."""
    fields = {
        "K": np.diag([K, 0.0]), "M": MASS * np.eye(2), "influence": [1, 0], "probe_tip": [1, 0],
        "load_preload": [0, -FORCE], "interface_1_operator": [[0, 1], [1, 0], [0, 0]], "interface_1_area": 1,
        "interface_1_friction_law": "penalty_coulomb", "interface_1_friction_mu": MU,
        "interface_1_friction_elastic_slip": GAMMA, "interface_1_normal_stiffness": 1.0e8,
    } | changes  # fmt: skip
    return {name: value for name, value in fields.items() if value is not None}


def write_case(folder: Path, fields: dict[str, Any], **sections: Any) -> Path:
    """Case file with its .mat beside it."""
    scipy.io.savemat(folder / "structure.mat", fields)
    data = {
        "analysis": "dwell",
        "structure": {"file": "structure.mat"},
        "excitation": DWELL,
        "solver": {"method": "condensed"},
    } | sections
    path = folder / "case.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return path


def wroll(*words: object) -> Any:
    return CliRunner().invoke(app, [str(word) for word in words])
