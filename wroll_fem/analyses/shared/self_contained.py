"""Self-contained results: attributes with the case data for summary and figures, added to older results."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from wroll_fem.case import OnRoll, StructuralCase, build_case
from wroll_fem.case.strict_yaml import parse_yaml
from wroll_fem.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.case import Case


RELATIVE_MOTION = (
    "cumulative_slip", "max_slip", "peak_slip_hoop", "peak_slip_axial", "slip_amplitude", "relative_displacement_hoop",
    "relative_displacement_axial",
)  # fmt: skip
"""Variables with the relative displacement, or the slip, of the two bodies at an interface."""

SUM_OF_WRAPS = "sum over the wrap interfaces of the layers (attribute wrap_interfaces)"


def described(dataset: xr.Dataset, case: Case) -> xr.Dataset:
    """Copy of a Dataset with the case data for summary, fields and figures; existing attributes are kept.

    The attributes are `analysis`; `excitation_direction` if effective masses are stored for each direction;
    `output_every` if fields are stored during the motion; `winding_pressure_pa` with `preload.kind: winding_tension`;
    `wrap_interfaces` with `coil.per_wrap`.
    """
    attrs: dict[str, Any] = {"analysis": case.analysis}
    if "component" in dataset.dims:
        attrs["excitation_direction"] = case.expect(StructuralCase).direction
    if "snapshot_time" in dataset.dims:
        attrs["output_every"] = case.output.every
    attrs |= _wound_pressure(case)
    return _over_wraps(dataset.assign_attrs(attrs | dataset.attrs), case)


def _over_wraps(dataset: xr.Dataset, case: Case) -> xr.Dataset:
    """Copy of a Dataset that states for how many wrap interfaces each interface stands (`coil.per_wrap`)."""
    if not isinstance(case, OnRoll) or not case.coil.per_wrap or case.winding is None:
        return dataset
    summed = {
        name: dataset[name].assign_attrs(comment=SUM_OF_WRAPS) for name in RELATIVE_MOTION if name in dataset.variables
    }
    return dataset.assign(summed).assign_attrs(wrap_interfaces=case.coil.interfaces_in_series(case.winding.wraps))


def with_warnings(dataset: xr.Dataset, warnings: Sequence[str]) -> xr.Dataset:
    """Copy of a Dataset with the warnings in the attribute `warnings`, one per line and without repetitions."""
    return dataset.assign_attrs(warnings="\n".join(dict.fromkeys(warnings)))


def completed(dataset: xr.Dataset) -> xr.Dataset:
    """Dataset with the attributes of `described`; for results of version 0.1.0, they are read from `case_yaml`.

    Raises
    ------
    InputError
        If neither the attributes nor the case name the analysis.
    """
    if "analysis" in dataset.attrs:
        return dataset
    given = parse_yaml(str(dataset.attrs.get("case_yaml", "")), "results") or {}
    if "analysis" not in given:
        raise InputError(
            "does not name its analysis", key="result", remedy="pass a result of wf.run, or pass its case as well"
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
    """Interface pressure of the wound roll, for `preload.kind: winding_tension`; empty otherwise."""
    if not isinstance(case, OnRoll) or case.preload is None or case.wound is None or case.coil.model != "layers":
        return {}
    if case.preload.kind != "winding_tension":
        return {}
    from wroll_fem.winding.interface import target_pressures

    return {"winding_pressure_pa": target_pressures(case.wound, case.coil.layers).tolist()}
