"""Self-contained results: data of the case for summary, fields and figures, as attributes of the Dataset."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import yaml

from wroll_fem.case import OnRoll, StructuralCase, build_case
from wroll_fem.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.case import Case


def described(dataset: xr.Dataset, case: Case) -> xr.Dataset:
    """Copy with the case data that summary, fields and figures need; existing attributes are kept.

    `analysis`; `excitation_direction` where fractions are kept for each direction; `output_every` with kept fields;
    `winding_pressure_pa` with `preload.kind: winding_tension`.
    """
    attrs: dict[str, Any] = {"analysis": case.analysis}
    if "component" in dataset.dims:
        attrs["excitation_direction"] = case.expect(StructuralCase).direction
    if "snapshot_time" in dataset.dims:
        attrs["output_every"] = case.output.every
    attrs |= _wound_pressure(case)
    return dataset.assign_attrs(attrs | dataset.attrs)


def with_warnings(dataset: xr.Dataset, warnings: Sequence[str]) -> xr.Dataset:
    """Copy whose attribute `warnings` holds the warnings, one a line; a repeated one counts once."""
    return dataset.assign_attrs(warnings="\n".join(dict.fromkeys(warnings)))


def completed(dataset: xr.Dataset) -> xr.Dataset:
    """Dataset with the attributes of `described`, which for results of version 0.1.0 are read from `case_yaml`.

    Raises
    ------
    InputError
        When neither attribute nor case name the analysis.
    """
    if "analysis" in dataset.attrs:
        return dataset
    given = yaml.safe_load(dataset.attrs.get("case_yaml", "")) or {}
    if "analysis" not in given:
        raise InputError(
            "does not name its analysis", key="result", remedy="pass a result of wf.run, or name its case as well"
        )
    attrs: dict[str, Any] = {
        "analysis": given["analysis"],
        "excitation_direction": (given.get("excitation") or {}).get("direction", "x"),
        "output_every": (given.get("output") or {}).get("every", 0),
    }
    if (given.get("preload") or {}).get("kind") == "winding_tension":
        with suppress(InputError):  # without its mesh file the entry is left out
            attrs |= _wound_pressure(build_case(given))
    return dataset.assign_attrs(attrs | dataset.attrs)


def _wound_pressure(case: Case) -> dict[str, Any]:
    """Pressure of the wound roll at the interfaces, for `preload.kind: winding_tension`; else empty."""
    if not isinstance(case, OnRoll) or case.preload is None or case.wound is None or case.coil.model != "layers":
        return {}
    if case.preload.kind != "winding_tension":
        return {}
    from wroll_fem.winding.interface import target_pressures

    return {"winding_pressure_pa": target_pressures(case.wound, case.coil.layers).tolist()}
