"""Run a case into a run folder, for `wroll run`, scripts and batches."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wroll_fem.case import Case
from wroll_fem.errors import ConvergenceError, WrollError
from wroll_fem.jobs.folder import RunFolder, Status
from wroll_fem.jobs.interrupts import interrupt_arrived
from wroll_fem.progress import Progress, SilentProgress, TerminalProgress

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Run:
    """A finished run.

    Attributes
    ----------
    folder
        Run folder.
    summary
        Content of summary.json: flat, SI, unit in the name.
    figures
        Figures of the run.
    already_done
        True if the folder already contained the complete results of this case, so that nothing was computed.
    """

    folder: RunFolder
    summary: dict[str, Any]
    figures: list[Path]
    already_done: bool = False


def run_case(
    case: Case, out: str | Path, *, progress: Progress | None = None, resume: bool = False, command: str = ""
) -> Run:
    """Run a case into a folder.

    Parameters
    ----------
    case
        Case to run.
    out
        Run folder; created if missing. Results of another case are never overwritten.
    progress
        Receiver of progress reports; silent by default.
    resume
        Continue from the checkpoint in `out`, if there is one.
    command
        Command that started the run, for the provenance.

    Raises
    ------
    InputError
        If the folder contains another case or other files.
    ConvergenceError
        If a step does not converge; the results up to that step are in results.nc.
    StorageError
        If a file cannot be written because the disk is full or fails; the run can be continued.
    """
    progress = progress if progress is not None else SilentProgress()
    folder = RunFolder(out)
    folder.refuse_in_use()  # before a checkpoint of the other process is taken for that of an unfinished run
    if folder.check(case, resume=resume) == "complete":
        return _finished(folder)
    with folder.locked():
        start = folder.check(case, resume=resume)  # another process may have worked here since
        if start == "complete":
            return _finished(folder)
        folder.begin(case, command)
        if isinstance(progress, TerminalProgress):
            progress.log_to(folder.log_file)
        if resume and start == "new":
            progress.info(f"{folder.path}: no checkpoint to resume from, starting from the beginning")
        return _run(case, folder, progress, resume=start == "resume")


def _finished(folder: RunFolder) -> Run:
    return Run(folder, folder.summary(), sorted(folder.figures.glob("*.png")), already_done=True)


def _run(case: Case, folder: RunFolder, progress: Progress, *, resume: bool) -> Run:
    from wroll_fem import analyses

    started = time.perf_counter()
    status: Status = "failed"
    dataset: xr.Dataset | None = None
    failure: dict[str, Any] = {}
    try:
        for text in analyses.case_warnings(case):
            progress.warning(text)
        dataset = analyses.run_analysis(case, progress=progress, checkpoint=folder.checkpoint_file, resume=resume)
        summary, figures = _save(case, folder, dataset, progress, time.perf_counter() - started)
        status = "complete"
    except ConvergenceError as error:
        status, failure = "not_converged", failure_record(error)
        dataset = error.partial
        if dataset is not None:
            _save_dataset(case, folder, dataset, complete=False)
            progress.info(f"results up to this point are in {folder.results_file}")
        raise
    except KeyboardInterrupt:
        status = "interrupted"
        raise
    except Exception as error:  # input found wrong on the way, or a defect, whose traceback goes on to the caller
        if interrupt_arrived():
            status = "interrupted"
            raise KeyboardInterrupt from error
        failure = failure_record(error)
        raise
    finally:
        seeds = {} if dataset is None else {k: v for k, v in dataset.attrs.items() if "seed" in str(k)}
        ended = {"wall_time_s": time.perf_counter() - started, "resumed": resume, "seeds": seeds, **failure}
        try:
            folder.record(status, **ended)
        except KeyboardInterrupt:  # the folder must not say "running" for ever
            folder.record(status, **ended)
            raise
    with suppress(OSError):  # the run is complete with it, too
        folder.checkpoint_file.unlink(missing_ok=True)
    return Run(folder, summary, figures)


def failure_record(error: Exception) -> dict[str, Any]:
    """Entries of provenance.json after a failure."""
    if isinstance(error, WrollError):
        return {"error": str(error), "exit_code": error.exit_code}
    return {"error": f"{type(error).__name__}: {error}", "exit_code": 1}


def _save(
    case: Case, folder: RunFolder, dataset: xr.Dataset, progress: Progress, seconds: float
) -> tuple[dict[str, Any], list[Path]]:
    from wroll_fem import analyses

    dataset = _save_dataset(case, folder, dataset, complete=True)
    summary = {"analysis": case.analysis, **analyses.summarise(dataset)}
    summary.setdefault("wall_time_s", seconds)
    if case.output.fields != "none":
        analyses.write_fields(dataset, folder.subfolder(folder.fields))
    figures: list[Path] = []
    if case.output.figures:
        place = folder.subfolder(folder.figures)
        with progress.stage("figures", 1):
            figures = list(analyses.write_figures(dataset, place))
    folder.write_json(folder.summary_file, summary)
    return folder.summary(), figures


def with_provenance(dataset: xr.Dataset, case: Case, *, complete: bool = True) -> xr.Dataset:
    """Copy of a Dataset with its origin as attributes: analysis, case, hash, versions, and whether the run is complete.

    Parameters
    ----------
    dataset
        Results of the case.
    case
        Case that was run.
    complete
        Whether the run is complete.
    """
    from wroll_fem.results.dataset import provenance

    origin = {
        "analysis": case.analysis,
        "case_yaml": case.resolved_yaml(),
        "case_hash": case.hash(),
        "provenance": provenance(),
        "complete": complete,
    }
    return dataset.assign_attrs(origin)


def _save_dataset(case: Case, folder: RunFolder, dataset: xr.Dataset, *, complete: bool) -> xr.Dataset:
    """Write results.nc; return its content."""
    from wroll_fem.results.dataset import save_dataset

    dataset = with_provenance(dataset, case, complete=complete)
    save_dataset(dataset, folder.results_file)
    return dataset
