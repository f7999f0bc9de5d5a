"""Run folder: lock, status, files, and check whether a case can run in it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Literal

from wroll_fem.case import Case, load_case
from wroll_fem.jobs.result_folder import LOCK, ResultFolder, Status, locked_by_one
from wroll_fem.results.storage.checkpoint import check_checkpoint

if TYPE_CHECKING:
    import xarray as xr

Start = Literal["new", "resume", "complete"]

__all__ = ["LOCK", "ResultFolder", "RunFolder", "Start", "Status", "locked_by_one"]


class RunFolder(ResultFolder):
    """Paths and state of one run.

    Parameters
    ----------
    path
        Path of the folder; only `locked` creates it.

    Attributes
    ----------
    case_file, checkpoint_file : Path
        case.yaml (resolved); checkpoint.npz (while unfinished).
    fields : Path
        Subfolder for .vtu files. The other paths are those of `ResultFolder`.
    """

    INPUT: ClassVar[str] = "case.yaml"

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        self.case_file = self.input_file
        self.checkpoint_file = self.path / "checkpoint.npz"
        self.fields = self.path / "fields"

    @property
    def subfolders(self) -> tuple[Path, ...]:
        """Folders in the folder."""
        return (self.fields, self.figures)

    def check(self, case: Case, *, resume: bool = False) -> Start:
        """Determine how a run of `case` can start in this folder, without writing to it.

        Returns
        -------
        Start
            "new", "resume" (a checkpoint of this case exists) or "complete" (this case is finished).

        Raises
        ------
        InputError
            If the path is a file; if the folder is neither empty nor a run folder; if it contains results, a summary or
            a checkpoint of another case; if its results, or the checkpoint of an unfinished run, are damaged; or if
            `resume` is False and it contains the checkpoint of an unfinished run of this case.
        """
        if self.path.exists() and not self.path.is_dir():
            raise self._refuse("is a file, not a folder", "choose another --out")
        if not self.path.exists() or not any(self._held()):
            return "new"
        held, mine = self.case_hash(), case.hash()
        if held is None:
            raise self._refuse("is not empty and not a run folder", "choose another --out or an empty folder")
        if held != mine and not self.holds_results():
            return "new"
        if held != mine:
            raise self._refuse(
                f"contains results of another case (hash {held[:12]}, this case has {mine[:12]})",
                "choose another --out, or delete the folder",
            )
        if self.status() == "complete" and self.summary_file.is_file() and self.results_file.is_file():
            from wroll_fem.results.dataset import check_results

            check_results(self.results_file)
            return "complete"
        if not self.checkpoint_file.is_file():
            return "new"
        check_checkpoint(self.checkpoint_file)
        if not resume:
            raise self._refuse("contains an unfinished run of this case", "add --resume, or delete the folder")
        return "resume"

    def holds_results(self) -> bool:
        """Whether the folder has results, a summary or a checkpoint."""
        return any(file.is_file() for file in (self.results_file, self.summary_file, self.checkpoint_file))

    def case_hash(self) -> str | None:
        """Hash of the case of this folder; None if it is not a run folder."""
        held = self.provenance().get("case_hash")
        if held is not None:
            return str(held)
        return load_case(self.case_file).hash() if self.case_file.is_file() else None

    def load(self) -> xr.Dataset:
        """Load the results of the run.

        Raises
        ------
        InputError
            If the folder has no run or no results.
        """
        from wroll_fem.results.dataset import load_dataset

        if not self.case_file.is_file():
            raise self._refuse("is not a run folder (no case.yaml)", "give the folder of a finished `wroll run`")
        return load_dataset(self.results_file)

    def begin(self, case: Case, command: str) -> None:
        """Write case.yaml and provenance.json of a run that starts in the locked folder.

        Raises
        ------
        InputError, StorageError
            If the folder cannot be written.
        """
        self.start(case.resolved_yaml(), case_hash=case.hash(), command=command)
