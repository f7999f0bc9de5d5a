"""Evaluate measurements into a folder, for `wroll lab`."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from wroll_fem.jobs.interrupts import interrupt_arrived
from wroll_fem.jobs.result_folder import ResultFolder, Status
from wroll_fem.jobs.run import failure_record
from wroll_fem.lab.evaluation import evaluate_with
from wroll_fem.lab.inputs import checked_inputs
from wroll_fem.lab.kinds import find_kind
from wroll_fem.lab.result import LabResult
from wroll_fem.lab.settings import LabSettings
from wroll_fem.progress import Progress, SilentProgress, TerminalProgress


def run_lab(
    kind: str,
    files: Sequence[str | Path],
    settings: LabSettings,
    out: str | Path,
    *,
    progress: Progress | None = None,
    command: str = "",
) -> tuple[LabResult, list[Path]]:
    """Evaluate measurements and write settings, summary, results, figures, log and provenance to a folder.

    Parameters
    ----------
    kind
        Kind of the evaluation.
    files
        Paths of the measurements.
    settings
        Complete settings of the kind.
    out
        Folder; created if missing.
    progress
        Receiver of progress reports; silent by default.
    command
        Command that started the evaluation, for the provenance.

    Returns
    -------
    tuple
        The result, and the files of its figures.

    Raises
    ------
    InputError
        If the folder is not empty, or files or settings are wrong; wrong paths leave no folder behind.
    ConvergenceError
        If a fit does not converge.
    StorageError
        If a file cannot be written because the disk is full or fails.
    """
    progress = progress if progress is not None else SilentProgress()
    paths = checked_inputs(files, folders=find_kind(kind).folders)
    folder = ResultFolder(out)
    folder.refuse_in_use()
    folder.check_empty()
    with folder.locked():
        folder.check_empty()  # another process may have worked here since
        folder.start(settings.yaml(), evaluation=kind, command=command)
        if isinstance(progress, TerminalProgress):
            progress.log_to(folder.log_file)
        started = time.perf_counter()
        status: Status = "failed"
        more: dict[str, Any] = {}
        try:
            result = evaluate_with(kind, paths, settings, progress=progress)
            figures = _save(result, folder, progress)
            status, more = "complete", {"inputs": result.inputs}
        except KeyboardInterrupt:
            status = "interrupted"
            raise
        except Exception as error:
            if interrupt_arrived():
                status = "interrupted"
                raise KeyboardInterrupt from error
            more = failure_record(error)
            raise
        finally:
            folder.record(status, wall_time_s=time.perf_counter() - started, **more)
    return result, figures


def _save(result: LabResult, folder: ResultFolder, progress: Progress) -> list[Path]:
    """Write results.nc, texts, figures and, last, summary.json; return the figures."""
    from wroll_fem.results.dataset import provenance, save_dataset

    save_dataset(result.data.assign_attrs(provenance=provenance(), complete=True), folder.results_file)
    for name, text in result.texts.items():
        folder.write_text(folder.path / name, text)
    figures: list[Path] = []
    if result.settings is not None and result.settings.figures and result.figures:
        folder.subfolder(folder.figures)
        with progress.stage("figures", 1):
            figures = result.write_figures(folder.figures)
    folder.write_json(folder.summary_file, result.summary)
    return figures
