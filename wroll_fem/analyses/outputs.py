"""What each analysis leaves behind: parts of its summary, fields and figures, all from the Dataset alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from wroll_fem.analyses.shared import figures, summary

if TYPE_CHECKING:
    from wroll_fem.case import Case

Summary = Callable[[xr.Dataset, "Case"], dict[str, Any]]
Files = Callable[[xr.Dataset, "Case", Path], list[Path]]


@dataclass(frozen=True)
class Outputs:
    """Parts of what an analysis leaves behind, in the order in which they stand.

    Attributes
    ----------
    summary
        Functions of Dataset and case; each returns entries of summary.json.
    figures, fields
        Functions of Dataset, case and folder; each writes pictures (.png) or fields (.vtu) and returns the files.
    """

    summary: tuple[Summary, ...]
    figures: tuple[Files, ...]
    fields: tuple[Files, ...] = ()


def _own(module: str, function: str) -> Summary:
    """Summary in the module of an analysis, imported when it is asked for."""

    def part(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
        found: dict[str, Any] = getattr(import_module(f".{module}", __package__), function)(dataset)
        return found

    return part


_figure = figures.figure
_CONTACT = (summary.readings, summary.interfaces)
_HISTORY = Outputs(
    (*_CONTACT, summary.ledger, summary.slip),
    (
        _figure("transmissibility", "plot_transmissibility", needs="transmissibility_real"),
        _figure("response", "plot_response"),
        _figure("energy_ledger", "plot_energy_ledger"),
        figures.slip_maps, figures.slip_in_space,
    ),
    (figures.write_slip,),
)  # fmt: skip
_PERIODIC = (*_CONTACT, summary.work_per_cycle, summary.slip)

OUTPUTS: dict[str, Outputs] = {
    "sweep": _HISTORY,
    "dwell": _HISTORY,
    "harmonic": Outputs(
        _PERIODIC,
        (_figure("transmissibility", "plot_harmonic_response"), figures.slip_maps, figures.slip_in_space),
        (figures.write_slip,),
    ),
    "backbone": Outputs(
        _PERIODIC,
        (_figure("backbone", "plot_backbone"), figures.slip_maps, figures.slip_in_space),
        (figures.write_slip,),
    ),
    "modal": Outputs(
        (*_CONTACT, summary.modes),
        (_figure("modes", "plot_modes"), figures.mode_shapes),
        (figures.write_modes,),
    ),
    "modal_transient": Outputs(
        (*_CONTACT, _own("modal_transient", "slip_summary"), summary.modes),
        (
            _figure("steady_response", "plot_steady_response", "coil_slip"),
            _figure("shear_distribution", "plot_shear_distribution", "coil_slip"),
            figures.coil_sections, _figure("modes", "plot_modes"), figures.coil_in_space,
        ),
        (figures.write_coil,),
    ),
    "preload": Outputs(_CONTACT, (figures.pressure_maps,), (figures.write_slip,)),
    "design_map": Outputs((_own("design_map", "summarise_design_map"),), (_figure("design_map", "plot_design_map"),)),
    "winding": Outputs(_CONTACT, (_figure("winding", "plot_winding"),)),
    "two_dof": Outputs(
        (summary.readings, _own("two_dof", "summarise_two_dof")),
        (
            _figure("two_dof", "plot_two_dof"),
            _figure("two_dof_readings", "plot_two_dof_readings"),
            _figure("two_dof_design_space", "plot_two_dof_design_space", needs="zeta_max"),
        ),
    ),
}  # fmt: skip
"""Name in the case file -> what its results become; as complete as `ANALYSES`."""


def summarise(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
    """Flat summary in SI, the unit in the name; lists run over interfaces (inner first) or modes."""
    found: dict[str, Any] = {"analysis": case.analysis}
    for part in OUTPUTS[case.analysis].summary:
        found |= part(dataset, case)
    return found


def write_fields(dataset: xr.Dataset, case: Case, folder: Path) -> list[Path]:
    """Write the .vtu files of the analysis."""
    return _written(OUTPUTS[case.analysis].fields, dataset, case, folder)


def write_figures(dataset: xr.Dataset, case: Case, folder: Path) -> list[Path]:
    """Draw the figures of the analysis as far as the results go (those of an unconverged run hold less).

    Pictures in space need pyvista and are left out without it; slip maps need points that span a cylinder.
    """
    return _written(OUTPUTS[case.analysis].figures, dataset, case, folder)


def _written(parts: tuple[Files, ...], dataset: xr.Dataset, case: Case, folder: Path) -> list[Path]:
    folder.mkdir(parents=True, exist_ok=True)
    return [path for part in parts for path in part(dataset, case, folder)]
