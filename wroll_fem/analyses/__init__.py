"""Run analyses by name, and summarise, draw and write their results."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from wroll_fem.analyses.registry import Analysis, all_analyses, find_analysis
from wroll_fem.errors import ConvergenceError

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

    from wroll_fem.case import Case
    from wroll_fem.progress import Progress

__all__ = [
    "Analysis", "all_analyses", "case_warnings", "estimate", "find_analysis", "run_analysis", "summarise",
    "write_fields", "write_figures",
]  # fmt: skip


def case_warnings(case: Case) -> list[str]:
    """Warnings about a case before its run, each with a remedy; the file named in `structure` is read.

    Raises
    ------
    InputError
        If that file is invalid.
    """
    from wroll_fem.analyses.shared.preflight import CHECKS, unusual_frequency
    from wroll_fem.case.plausibility import implausible

    known = CHECKS.get(case.analysis)  # without the imports of the analysis
    checks = find_analysis(case.analysis).preflight if known is None else known
    numbers = implausible(case) or unusual_frequency(case)
    return case.renamed + numbers + [text for check in checks for text in check(case)]


def estimate(case: Case) -> dict[str, Any]:
    """Problem size and approximate computing time, for ``--dry-run``.

    Returns
    -------
    dict
        dofs, interface_points, steps, time_step_s, duration_s, and for a roll estimated_seconds (one core, set-up
        included).
    """
    return find_analysis(case.analysis).estimate(case)


def run_analysis(case: Case, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False) -> xr.Dataset:
    """Run the analysis of a case; the results contain all warnings, including those issued before the run.

    Parameters
    ----------
    checkpoint
        File for checkpoints of resumable analyses; None writes none.
    resume
        Continue from the checkpoint.

    Returns
    -------
    xr.Dataset
        Self-contained results, sufficient for `summarise`, `write_fields` and `write_figures`.

    Raises
    ------
    ConvergenceError
        If a step does not converge; attribute ``partial`` contains the results up to that step, if any.
    """
    from wroll_fem.analyses.shared.doubts import doubts
    from wroll_fem.analyses.shared.self_contained import described, with_warnings
    from wroll_fem.progress import KeptWarnings

    analysis = find_analysis(case.analysis)
    saved = {"checkpoint": checkpoint, "resume": resume} if analysis.resumable else {}
    kept = KeptWarnings(progress)
    try:
        dataset = described(analysis.run(case, progress=kept, **saved), case)
    except ConvergenceError as error:
        if error.partial is not None:
            error.partial = with_warnings(described(error.partial, case), [*case_warnings(case), *kept.warnings])
        raise
    for text in doubts(dataset, summarise(dataset), case):
        kept.warning(text)
    return with_warnings(dataset, [*case_warnings(case), *kept.warnings])


def summarise(dataset: xr.Dataset, case: Case | None = None) -> dict[str, Any]:
    """Flat summary in SI units, with the unit in each name; lists have one entry per interface (inner first) or mode.

    Parameters
    ----------
    case
        Case of the Dataset; needed only if the Dataset does not name its analysis.

    Raises
    ------
    InputError
        If the analysis is unknown.
    """
    from wroll_fem.analyses.shared.summary import attributes

    dataset, analysis = _own(dataset, case)
    found: dict[str, Any] = {"analysis": analysis.name} | attributes(dataset)
    for part in analysis.summary:
        found |= part(dataset)
    return found


def write_fields(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Write the .vtu files of the analysis: slip maps, stored fields, mode shapes."""
    dataset, analysis = _own(dataset)
    return _written(analysis.fields, dataset, folder)


def write_figures(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the figures of the analysis (.png); figures whose data are missing in incomplete results are omitted.

    Three-dimensional figures need pyvista and are omitted without it. Slip maps need points that span a cylinder.
    """
    dataset, analysis = _own(dataset)
    return _written(analysis.figures, dataset, folder)


def _own(dataset: xr.Dataset, case: Case | None = None) -> tuple[xr.Dataset, Analysis]:
    """Return the Dataset with the case data that summary, fields and figures need, and the analysis of the Dataset."""
    from wroll_fem.analyses.shared.self_contained import completed, described

    dataset = completed(dataset) if case is None else described(dataset, case)
    return dataset, find_analysis(str(dataset.attrs["analysis"]))


def _written(
    parts: tuple[Callable[[xr.Dataset, Path], list[Path]], ...], dataset: xr.Dataset, folder: Path
) -> list[Path]:
    return [path for part in parts for path in part(dataset, folder)]
