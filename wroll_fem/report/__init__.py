"""Self-contained HTML report of a run folder or a batch folder."""

from __future__ import annotations

from pathlib import Path

from wroll_fem.errors import InputError
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.results.storage.atomic import make_folder, replacing
from wroll_fem.results.storage.paths import check_path

__all__ = ["write_report"]

_OTHER_OUT = "choose another --out"


def write_report(folder: str | Path, out: str | Path | None = None) -> Path:
    """Write the report of a run or of a batch.

    Parameters
    ----------
    folder
        Folder of a `wroll run` (also an unfinished one) or of a `wroll batch`, or a results file (.nc) alone.
    out
        File to write; `folder`/report.html, or the results file with the ending .html, by default.

    Returns
    -------
    Path
        The report. It needs no other file: figures and styles are embedded, and nothing is loaded from elsewhere.

    Raises
    ------
    InputError
        If the folder is neither a run nor a batch, or the report cannot be written.
    StorageError
        If the disk is full or fails.
    """
    folder = Path(folder)
    for path in (folder, out or folder):
        check_path(path)
    beside = folder.with_suffix(".html") if folder.is_file() else folder / "report.html"
    target = Path(out) if out is not None else beside
    if folder.is_file():
        from wroll_fem.report.run import result_page

        text = result_page(folder)
    elif RunFolder(folder).case_file.is_file():
        from wroll_fem.report.run import run_page

        text = run_page(folder)
    elif (folder / "batch.csv").is_file():
        from wroll_fem.report.batch import batch_page

        text = batch_page(folder)
    else:
        problem = "is neither the folder of a run (no case.yaml) nor of a batch (no batch.csv)"
        if not folder.is_dir():
            problem = "is not a folder"
        raise InputError(problem, file=str(folder), remedy="give the folder of a `wroll run` or a `wroll batch`")
    make_folder(target.parent, _OTHER_OUT)
    with replacing(target, _OTHER_OUT) as file:
        file.write_text(text, encoding="utf-8")
    return target
