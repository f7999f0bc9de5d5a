"""Self-contained HTML report of the folder of a run, of a batch or of a laboratory evaluation."""

from __future__ import annotations

from pathlib import Path

from wroll_fem.errors import InputError
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.lab_folder import LabFolder
from wroll_fem.results.storage.atomic import make_folder, replacing
from wroll_fem.results.storage.paths import check_path

__all__ = ["write_report"]

_OTHER_OUT = "choose another --out"


def write_report(folder: str | Path, out: str | Path | None = None) -> Path:
    """Write the report of a run, of a batch or of a laboratory evaluation.

    Parameters
    ----------
    folder
        Folder of a `wroll run` or a `wroll lab` (also an unfinished one) or of a `wroll batch`, or a results file (.nc)
        alone.
    out
        File to write; `folder`/report.html, or the results file with the ending .html, by default.

    Returns
    -------
    Path
        The report. It needs no other file: figures and styles are embedded, and nothing is loaded from elsewhere.

    Raises
    ------
    InputError
        If the folder is none of these, or the report cannot be written.
    StorageError
        If the disk is full or fails.
    """
    folder = Path(folder)
    for path in (folder, out or folder):
        check_path(path)
    beside = folder.with_suffix(".html") if folder.is_file() else folder / "report.html"
    target = Path(out) if out is not None else beside
    if folder.is_file():
        text = _page_of_file(folder)
    elif RunFolder(folder).case_file.is_file():
        from wroll_fem.report.run import run_page

        text = run_page(folder)
    elif (folder / "batch.csv").is_file():
        from wroll_fem.report.batch import batch_page

        text = batch_page(folder)
    elif LabFolder(folder).is_one():
        from wroll_fem.report.lab import lab_page

        text = lab_page(folder)
    else:
        problem = (
            "is neither the folder of a run (no case.yaml), of a batch (no batch.csv) "
            "nor of the laboratory (no settings.yaml)"
        )
        if not folder.is_dir():
            problem = "is not a folder"
        raise InputError(
            problem, file=str(folder), remedy="give the folder of a `wroll run`, `wroll batch` or `wroll lab`"
        )
    make_folder(target.parent, _OTHER_OUT)
    with replacing(target, _OTHER_OUT) as file:
        file.write_text(text, encoding="utf-8")
    return target


def _page_of_file(path: Path) -> str:
    from wroll_fem.lab.evaluation import is_evaluation
    from wroll_fem.results.dataset import load_dataset

    dataset = load_dataset(path)
    if is_evaluation(dataset):
        from wroll_fem.report.lab import lab_result_page

        return lab_result_page(path, dataset)
    from wroll_fem.report.run import result_page

    return result_page(path, dataset)
