"""Run folder: lock, status, files, and check whether a case can run in it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from filelock import FileLock, Timeout

from wroll_fem.case import Case, load_case
from wroll_fem.errors import InputError
from wroll_fem.results.atomic import replacing
from wroll_fem.results.json_types import json_types
from wroll_fem.results.provenance import program_version, provenance

if TYPE_CHECKING:
    import xarray as xr

Start = Literal["new", "resume", "complete"]
Status = Literal["running", "complete", "not_converged", "interrupted", "failed"]


class RunFolder:
    """Paths and state of one run.

    Parameters
    ----------
    path
        Path of the folder; only `open` creates it.

    Attributes
    ----------
    case_file, summary_file, results_file, log_file, provenance_file, checkpoint_file : Path
        case.yaml (resolved), summary.json, results.nc, run.log, provenance.json, checkpoint.npz (while unfinished).
    lock_file : Path
        .lock (empty), locked by the process that works in the folder. It is not deleted:
        a deleted lock file could be locked twice.
    fields, figures : Path
        Subfolders for .vtu files and for figures.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.case_file = self.path / "case.yaml"
        self.summary_file = self.path / "summary.json"
        self.results_file = self.path / "results.nc"
        self.log_file = self.path / "run.log"
        self.lock_file = self.path / ".lock"
        self.provenance_file = self.path / "provenance.json"
        self.checkpoint_file = self.path / "checkpoint.npz"
        self.fields = self.path / "fields"
        self.figures = self.path / "figures"

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
            a checkpoint of another case; or if `resume` is False and it contains the checkpoint of an unfinished run of
            this case.
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
            return "complete"
        if not self.checkpoint_file.is_file():
            return "new"
        if not resume:
            raise self._refuse("contains an unfinished run of this case", "add --resume, or delete the folder")
        return "resume"

    def _held(self) -> Iterator[Path]:
        """Files of the folder, except log, lock and partial files."""
        return (p for p in self.path.iterdir() if p not in (self.log_file, self.lock_file) and p.suffix != ".partial")

    def holds_results(self) -> bool:
        """Whether the folder has results, a summary or a checkpoint."""
        return any(file.is_file() for file in (self.results_file, self.summary_file, self.checkpoint_file))

    def case_hash(self) -> str | None:
        """Hash of the case of this folder; None if it is not a run folder."""
        held = self.provenance().get("case_hash")
        if held is not None:
            return str(held)
        return load_case(self.case_file).hash() if self.case_file.is_file() else None

    def status(self) -> Status | None:
        """Status of the last run, from provenance.json."""
        return self.provenance().get("status")

    def provenance(self) -> dict[str, Any]:
        """Content of provenance.json; empty if the file is missing."""
        return self._read_json(self.provenance_file) if self.provenance_file.is_file() else {}

    def summary(self) -> dict[str, Any]:
        """Content of summary.json."""
        return self._read_json(self.summary_file)

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

    @contextmanager
    def open(self, case: Case, command: str) -> Iterator[None]:
        """Create and lock the folder; write case.yaml and provenance.json.

        Raises
        ------
        InputError
            If the folder cannot be written, or another process uses it.
        """
        lock = FileLock(self.lock_file)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            self.log_file.open("a").close()
            held = lock.acquire(timeout=0)
        except Timeout:
            raise self._refuse("is in use by another process", "wait for it, or choose another --out") from None
        except OSError as error:
            raise self._refuse(f"cannot be written ({error.strerror})", "choose another --out") from None
        with held:
            self.summary_file.unlink(missing_ok=True)
            self._write(
                self.case_file,
                f"# resolved by wroll_fem {program_version()}; all defaults are filled in\n{case.resolved_yaml()}",
            )
            self.record("running", case_hash=case.hash(), command=command)
            yield

    def record(self, status: Status, **entries: Any) -> None:
        """Write `status`, `entries`, versions, git revision and machine to provenance.json.

        Older entries are kept, except at the start of a run (status "running").
        """
        kept = self.provenance() if status != "running" else {}
        self.write_json(self.provenance_file, {**kept, **provenance(), **entries, "status": status})

    def write_json(self, path: Path, content: Mapping[str, Any]) -> None:
        """Write JSON atomically, with null for numbers that are not finite."""
        self._write(path, json.dumps(json_types(content), indent=2, allow_nan=False) + "\n")

    def _write(self, path: Path, text: str) -> None:
        with replacing(path) as file:
            file.write_text(text, encoding="utf-8")

    def _read_json(self, path: Path) -> dict[str, Any]:
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise InputError(
                f"cannot be read ({error})", file=str(path), remedy="delete the run folder and run again"
            ) from None
        if not isinstance(content, dict):
            raise InputError("is not a JSON object", file=str(path), remedy="delete the run folder and run again")
        return content

    def _refuse(self, problem: str, remedy: str) -> InputError:
        return InputError(problem, file=str(self.path), remedy=remedy)
