"""Dataset and summary of evaluated shear records."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from wroll_fem.lab.common.intervals import entries, variables
from wroll_fem.lab.friction.rate_law import pooled
from wroll_fem.lab.shear.evaluation import Measured
from wroll_fem.lab.shear.stiffness import moduli
from wroll_fem.numerics.inference import Estimate
from wroll_fem.typing import FloatArray

SAMPLES = 800
"""Samples of each record in the Dataset, for figures."""


def record_dataset(found: Sequence[Measured], area: float | None, thickness: float | None) -> xr.Dataset:
    """Dataset of records: results over `test_record`, coefficients over `point`, thinned curves over `sample`."""
    data: dict[str, tuple[Any, Any]] = {
        "record_profile": ("test_record", [one.read.profile for one in found]),
        "normal_force": ("test_record", [one.read.record.normal_force for one in found]),
        "onset_rule": ("test_record", [one.capacity.rule if one.capacity else "" for one in found]),
    }
    data |= variables("shear_capacity", "test_record", [one.capacity.force if one.capacity else None for one in found])
    data |= variables("shear_stiffness", "test_record", [one.stiffness for one in found])
    if area is not None and thickness is not None:
        both = [moduli(one.stiffness, area, thickness) if one.stiffness else (None, None) for one in found]
        data |= variables("shear_modulus", "test_record", [pair[0] for pair in both])
        data["shear_modulus_one_stack"] = ("test_record", [pair[1].value if pair[1] else np.nan for pair in both])
    means = [one.loop_means or (None, None, None) for one in found]
    for k, name in enumerate(("loop_energy", "loop_displacement", "loop_force")):
        data |= variables(name, "test_record", [one[k] for one in means])
    data["loop_count"] = ("test_record", [len(one.loops.energy) if one.loops else 0 for one in found])
    data |= point_variables(found)
    data |= _curves(found)
    names = [Path(one.read.record.source).name for one in found]
    return xr.Dataset(data, coords={"test_record": names})


def point_variables(found: Sequence[Measured]) -> dict[str, tuple[Any, Any]]:
    """Variables over `point`: slip rate, coefficient with interval, profile, record (from 0)."""
    points = [(k, point) for k, one in enumerate(found) for point in one.points]
    if not points:
        return {}
    data: dict[str, tuple[Any, Any]] = {
        "point_slip_rate": ("point", [point.rate for _, point in points]),
        "point_profile": ("point", [point.profile for _, point in points]),
        "point_record": ("point", [k for k, _ in points]),
    }
    return data | variables("point_coefficient", "point", [point.coefficient for _, point in points])


def _curves(found: Sequence[Measured]) -> dict[str, tuple[Any, Any]]:
    rows = []
    for one in found:
        at = np.linspace(0, len(one.read.specimen.time) - 1, SAMPLES).round().astype(int)
        rows.append((one.read.specimen.displacement[at], one.read.specimen.force[at]))
    table = np.array(rows)
    return {
        "curve_displacement": (("test_record", "sample"), table[:, 0]),
        "curve_force": (("test_record", "sample"), table[:, 1]),
    }


def shear_summary(found: Sequence[Measured], area: float | None, thickness: float | None) -> dict[str, Any]:
    """Entries of summary.json of the evaluation `shear`; lists over the ramps, loops or points."""
    ramps = [one for one in found if one.stiffness is not None]
    summary: dict[str, Any] = {}
    caught = [one for one in ramps if one.capacity is not None]
    if caught:
        summary |= entries("shear_capacity", "n", [one.capacity.force for one in caught if one.capacity])
        summary["onset_rules"] = [one.capacity.rule for one in caught if one.capacity]
        coefficient = capacity_coefficient(found)
        if coefficient is not None:
            summary |= entries("capacity_coefficient", "", coefficient)
    if ramps:
        summary |= entries("shear_stiffness", "n_per_m", [one.stiffness for one in ramps])
        if area is not None and thickness is not None:
            both = [moduli(one.stiffness, area, thickness) for one in ramps if one.stiffness]
            summary |= entries("shear_modulus", "pa", [pair[0] for pair in both])
            summary["shear_modulus_one_stack_pa"] = [pair[1].value for pair in both]
    cyclic = [one.loop_means for one in found if one.loop_means is not None]
    if cyclic:
        summary |= entries("loop_energy", "j", [one[0] for one in cyclic])
    points = sorted((point for one in found for point in one.points), key=lambda point: point.rate)
    if points:
        summary["slip_rates_m_s"] = [point.rate for point in points]
        summary |= entries("sliding_coefficient", "", [point.coefficient for point in points])
    return summary


def capacity_coefficient(found: Sequence[Measured]) -> Estimate | None:
    """Coefficient of friction from the capacities over the preload, F_c = 2 mu F_N; None without preloads."""
    rows = [
        (one.read.record.normal_force, one.capacity.force.value, one.capacity.force.error)
        for one in found
        if one.capacity is not None and not np.isnan(one.read.record.normal_force)
    ]
    if len(rows) < 2:
        return None
    preload, value, error = np.array(rows).T
    columns: dict[str, FloatArray] = {"mu": 2.0 * preload}
    return pooled(columns, value, error)[0]["mu"]
