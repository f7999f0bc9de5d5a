"""Analyses by name, and what every run does with their results. Importing this is cheap."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wroll_fem.analyses.shared.preflight import case_warnings, estimate
from wroll_fem.case import RESUMABLE

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.case import Case
    from wroll_fem.progress import Progress

__all__ = ["ANALYSES", "case_warnings", "estimate", "run_analysis", "summarise", "write_fields", "write_figures"]


def _imported(module: str, function: str) -> Callable[..., xr.Dataset]:
    """Analysis in a module of this package, imported when it runs."""

    def run(case: Case, **keywords: Any) -> xr.Dataset:
        dataset: xr.Dataset = getattr(import_module(f".{module}", __name__), function)(case, **keywords)
        return dataset

    return run


_MODAL = {
    "three_dimensional": _imported("modal", "run_modal"),
    "fourier": _imported("fourier", "run_fourier_modal"),
}


def _modal(case: Case, **keywords: Any) -> xr.Dataset:
    return _MODAL[case.mesh.discretisation](case, **keywords)


ANALYSES: dict[str, Callable[..., xr.Dataset]] = {
    "sweep": _imported("history", "run_history"),
    "dwell": _imported("history", "run_history"),
    "harmonic": _imported("harmonic", "run_harmonic"),
    "backbone": _imported("backbone", "run_backbone"),
    "modal": _modal,
    "modal_transient": _imported("modal_transient", "run_modal_transient"),
    "preload": _imported("history", "run_preload"),
    "design_map": _imported("design_map", "run_design_map"),
    "winding": _imported("winding", "run_winding"),
    "two_dof": _imported("two_dof", "run_two_dof"),
}
"""Name in the case file -> function of the case, returning an annotated Dataset."""


def run_analysis(case: Case, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False) -> xr.Dataset:
    """Run the analysis that the case asks for.

    Parameters
    ----------
    checkpoint
        File for checkpoints of the analyses that write them (`case.RESUMABLE`); None writes none.
    resume
        Go on from it.

    Raises
    ------
    ConvergenceError
        With the results until then in ``partial`` (or no such attribute when there are none).
    """
    saved = {"checkpoint": checkpoint, "resume": resume} if case.analysis in RESUMABLE else {}
    return ANALYSES[case.analysis](case, progress=progress, **saved)


def summarise(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
    """Flat summary in SI, the unit in the name (summary.json)."""
    from wroll_fem.analyses.outputs import summarise as summary

    return summary(dataset, case)


def write_fields(dataset: xr.Dataset, case: Case, folder: Path) -> list[Path]:
    """Slip maps, kept fields and mode shapes as .vtu."""
    from wroll_fem.analyses.outputs import write_fields as write

    return write(dataset, case, folder)


def write_figures(dataset: xr.Dataset, case: Case, folder: Path) -> list[Path]:
    """Figures of the analysis as .png."""
    from wroll_fem.analyses.outputs import write_figures as write

    return write(dataset, case, folder)
