"""Analyses by name, and what every run does with their results. Importing this is cheap."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .advice import case_warnings, estimate

if TYPE_CHECKING:
    import xarray as xr

    from ..case import Case
    from ..progress import Progress

__all__ = ["ANALYSES", "case_warnings", "estimate", "run_analysis", "summarise", "write_fields", "write_figures"]


def _time_history(case: Case, **keywords: Any) -> xr.Dataset:
    from .history import run_history

    return run_history(case, **keywords)


def _modal(case: Case, *, progress: Progress, checkpoint: Path | None, resume: bool) -> xr.Dataset:
    if case.mesh.discretisation == "fourier":
        from .fourier import run_fourier_modal

        return run_fourier_modal(case, progress=progress)
    from .modal import run_modal

    return run_modal(case, progress=progress)


def _design_map(case: Case, *, progress: Progress, checkpoint: Path | None, resume: bool) -> xr.Dataset:
    from .design_map import run_design_map

    return run_design_map(case, progress=progress)


def _harmonic(case: Case, *, progress: Progress, checkpoint: Path | None, resume: bool) -> xr.Dataset:
    from .harmonic import run_harmonic

    return run_harmonic(case, progress=progress)


def _backbone(case: Case, *, progress: Progress, checkpoint: Path | None, resume: bool) -> xr.Dataset:
    from .backbone import run_backbone

    return run_backbone(case, progress=progress)


def _preload(case: Case, *, progress: Progress, checkpoint: Path | None, resume: bool) -> xr.Dataset:
    from .history import run_preload

    return run_preload(case, progress=progress)


def _modal_transient(case: Case, *, progress: Progress, checkpoint: Path | None, resume: bool) -> xr.Dataset:
    from .modal_transient import run_modal_transient

    return run_modal_transient(case, progress=progress)


def _winding(case: Case, *, progress: Progress, checkpoint: Path | None, resume: bool) -> xr.Dataset:
    from .winding import run_winding

    return run_winding(case, progress=progress)


def _two_dof(case: Case, *, progress: Progress, checkpoint: Path | None, resume: bool) -> xr.Dataset:
    from .two_dof import run_two_dof

    return run_two_dof(case, progress=progress)


ANALYSES: dict[str, Callable[..., xr.Dataset]] = {
    "sweep": _time_history,
    "dwell": _time_history,
    "harmonic": _harmonic,
    "backbone": _backbone,
    "modal": _modal,
    "modal_transient": _modal_transient,
    "preload": _preload,
    "design_map": _design_map,
    "winding": _winding,
    "two_dof": _two_dof,
}
"""Name in the case file -> function of the case, returning an annotated Dataset."""


def run_analysis(case: Case, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False) -> xr.Dataset:
    """Run the analysis that the case asks for.

    Parameters
    ----------
    checkpoint
        File for checkpoints of long runs; None writes none.
    resume
        Go on from it.

    Raises
    ------
    ConvergenceError
        With the results until then in ``partial`` (or no such attribute when there are none).
    """
    return ANALYSES[case.analysis](case, progress=progress, checkpoint=checkpoint, resume=resume)


def summarise(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
    """Flat summary in SI, the unit in the name (summary.json)."""
    from .outputs import summarise as summary

    return summary(dataset, case)


def write_fields(dataset: xr.Dataset, case: Case, folder: Path) -> list[Path]:
    """Slip maps, kept fields and mode shapes as .vtu."""
    from .outputs import write_fields as write

    return write(dataset, case, folder)


def write_figures(dataset: xr.Dataset, case: Case, folder: Path) -> list[Path]:
    """Figures of the analysis as .png."""
    from .outputs import write_figures as write

    return write(dataset, case, folder)
