"""Simulated records of the shaker tests of chapter 3, read by the laboratory's evaluation of transmissibility."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from reproduction.evidence import Evidence
from wroll_fem.lab.evaluation import evaluate
from wroll_fem.plotting.study import StudyCase
from wroll_fem.signals.tip import absolute_tip
from wroll_fem.typing import FloatArray

RATE = 4096.0
"""Samples per second of a record, Hz."""


def sampled(history: xr.Dataset) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Time (s), base and absolute tip acceleration (m/s^2) of a time history at equal steps."""
    time = history["time"].values
    even = np.arange(0.0, time[-1], 1.0 / RATE)
    base, tip = (CubicSpline(time, x)(even) for x in (history["base_acceleration"].values, absolute_tip(history)))
    return even, base, tip


def measured(histories: Mapping[str, xr.Dataset], **settings: Any) -> xr.Dataset:
    """Curves and readings of the laboratory evaluation `transmissibility`, one condition per history.

    Parameters
    ----------
    histories
        Name of each condition -> time history.
    settings
        Settings of the evaluation.

    Returns
    -------
    xr.Dataset
        Dimensions `condition` and `frequency`.
    """
    with tempfile.TemporaryDirectory() as folder:
        files, conditions = [], []
        for k, (name, history) in enumerate(histories.items()):
            files.append(Path(folder) / f"trial_{k}.npz")
            np.savez(files[-1], **dict(zip(("time", "base", "tip"), sampled(history), strict=True)))
            conditions.append({"files": [files[-1].name], "name": name})
        found = evaluate(
            "transmissibility", files, conditions=conditions, base_unit="m/s^2", tip_unit="m/s^2", **settings
        )
    wanted = ["family_real", "family_imag", "base_level", "tip_level"]
    wanted += [f"condition_{name}" for name in ("f_n", "zeta", "peak", "f_n_error", "zeta_error")]
    data = found.data[wanted].drop_attrs().drop_vars("trial", errors="ignore")
    data["quality"] = "condition", list(found.summary["zeta_quality"])
    data["skewness"] = "condition", np.array(found.summary["skewness"], dtype=float)
    return data


def hashes(members: Sequence[StudyCase]) -> list[str]:
    """Hashes of the cases of a study: what a computation from their results depends on."""
    return [str(member.data.attrs["case_hash"]) for member in members]


def with_reference(evidence: Evidence, study: str, key: str) -> list[StudyCase]:
    """Mandrel alone, then the rolls of a study in ascending order of a key."""
    rolls = [m for m in evidence.study(study) if not m.reference]
    return [evidence.reference(study), *sorted(rolls, key=lambda m: float(m.values[key]))]
