"""Run folder: lock, status, files, and check whether a case can run in it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from filelock import FileLock, Timeout

from wroll_fem.case import Case, load_case
from wroll_fem.errors import InputError, StorageError
from wroll_fem.results.json_types import json_types
from wroll_fem.results.provenance import program_version, provenance
from wroll_fem.results.storage.atomic import PARTIAL, make_folder, replacing, writing_error
from wroll_fem.results.storage.checkpoint import check_checkpoint
from wroll_fem.results.storage.paths import check_path
from wroll_fem.results.summary_types import well_typed

if TYPE_CHECKING:
    import xarray as xr

LOCK = ".lock"
"""Name of the file that is locked while a process works in a folder."""

_OTHER_OUT = "choose another --out"
_NO_LINKS = "delete it: nothing is written through links in a run folder"
_AGAIN = "delete this file and run the case again"
_RESERVE = 16384  # bytes: more than a provenance.json

_TYPES: dict[str, type | tuple[type, ...]] = {
    "status": str, "case_hash": str, "command": str, "time_utc": str, "error": str, "exit_code": int, "resumed": bool,
    "wall_time_s": (int, float), "seeds": dict, "versions": dict, "git": dict, "machine": dict,
}  # fmt: skip
"""Entry of provenance.json -> type."""

Start = Literal["new", "resume", "complete"]
Status = Literal["running", "complete", "not_converged", "interrupted", "failed"]


@contextmanager
def locked_by_one(file: Path, folder: Path) -> Iterator[None]:
    """Lock a file for this process while it works in a folder.

    Raises
    ------
    InputError
        If another process holds the lock, or the file cannot be created.
    StorageError
        If the disk is full or fails.
    """
    try:
        held = FileLock(file).acquire(timeout=0)
    except Timeout:
        remedy = f"wait for it, or {_OTHER_OUT}"
        raise InputError("is in use by another process", file=str(folder), remedy=remedy) from None
    except OSError as error:
        raise writing_error(error, folder, _OTHER_OUT) from None
    with held:
        yield


class RunFolder:
    """Paths and state of one run.

    Parameters
    ----------
    path
        Path of the folder; only `locked` creates it.

    Attributes
    ----------
    case_file, summary_file, results_file, log_file, provenance_file, checkpoint_file : Path
        case.yaml (resolved), summary.json, results.nc, run.log, provenance.json, checkpoint.npz (while unfinished).
    lock_file : Path
        .lock (empty), locked by the process that works in the folder. It is not deleted:
        a deleted lock file could be locked twice.
    reserve_file : Path
        .reserve, some kilobytes kept while a run works, so that its end can be recorded on a full disk.
    fields, figures : Path
        Subfolders for .vtu files and for figures.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        check_path(self.path, _OTHER_OUT)
        self.case_file = self.path / "case.yaml"
        self.summary_file = self.path / "summary.json"
        self.results_file = self.path / "results.nc"
        self.log_file = self.path / "run.log"
        self.lock_file = self.path / LOCK
        self.reserve_file = self.path / ".reserve"
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

    def _held(self) -> Iterator[Path]:
        """Files of the folder, except log, lock, reserve and partial files."""
        other = (self.log_file, self.lock_file, self.reserve_file)
        return (p for p in self.path.iterdir() if p not in other and p.suffix != PARTIAL)

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
        """Content of provenance.json, without entries of a wrong type; empty if the file is missing."""
        found = self._read_json(self.provenance_file) if self.provenance_file.is_file() else {}
        return {key: value for key, value in found.items() if isinstance(value, _TYPES.get(key, object))}

    def summary(self) -> dict[str, Any]:
        """Content of summary.json.

        Raises
        ------
        InputError
            If the file cannot be read, or an entry is not of its type.
        """
        found = self._read_json(self.summary_file)
        wrong = next((key for key, value in found.items() if not well_typed(key, value)), None)
        if wrong is not None:
            raise InputError(f"entry {wrong} has a wrong type", file=str(self.summary_file), remedy=_AGAIN)
        return found

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

    def refuse_in_use(self) -> None:
        """Raise an InputError if another process works in the folder; nothing is written."""
        if self.lock_file.is_file() and not self.lock_file.is_symlink():
            with self._lock():
                pass

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Create and lock the folder.

        Raises
        ------
        InputError
            If the folder cannot be written, another process uses it, or a name in it is a symbolic link, through which
            files elsewhere would be written.
        StorageError
            If the disk is full or fails.
        """
        make_folder(self.path, _OTHER_OUT)
        for place in (self.log_file, self.lock_file, self.fields, self.figures):
            if place.is_symlink():
                raise InputError("is a symbolic link", file=str(place), remedy=_NO_LINKS)
        with self._lock():
            try:
                yield
            finally:
                with suppress(OSError):  # a rest of it does no harm
                    self.reserve_file.unlink(missing_ok=True)

    @contextmanager
    def _lock(self) -> Iterator[None]:
        with locked_by_one(self.lock_file, self.path):
            yield

    def begin(self, case: Case, command: str) -> None:
        """Write case.yaml and provenance.json of a run that starts in the locked folder.

        Raises
        ------
        InputError, StorageError
            If the folder cannot be written.
        """
        try:
            self.log_file.open("a").close()
            self.summary_file.unlink(missing_ok=True)
        except OSError as error:
            raise writing_error(error, self.path, _OTHER_OUT) from None
        with replacing(self.reserve_file, _OTHER_OUT) as file:
            file.write_bytes(bytes(_RESERVE))
        self._write(
            self.case_file,
            f"# resolved by wroll_fem {program_version()}; all defaults are filled in\n{case.resolved_yaml()}",
        )
        self.record("running", case_hash=case.hash(), command=command)

    def subfolder(self, path: Path) -> Path:
        """Create a folder in the run folder; return its path.

        Raises
        ------
        InputError, StorageError
            If it cannot be created, or is a symbolic link.
        """
        if path.is_symlink():
            raise InputError("is a symbolic link", file=str(path), remedy=_NO_LINKS)
        return make_folder(path, _OTHER_OUT)

    def record(self, status: Status, **entries: Any) -> None:
        """Write `status`, `entries`, versions, git revision and machine to provenance.json.

        Older entries are kept, except at the start of a run (status "running").
        """
        kept = self.provenance() if status != "running" else {}
        content = {**kept, **provenance(), **entries, "status": status}
        try:
            self.write_json(self.provenance_file, content)
        except StorageError:
            with suppress(OSError):
                self.reserve_file.unlink(missing_ok=True)  # it leaves room for this file
            self.write_json(self.provenance_file, content)

    def write_json(self, path: Path, content: Mapping[str, Any]) -> None:
        """Write JSON atomically, with null for numbers that are not finite."""
        self._write(path, json.dumps(json_types(content), indent=2, allow_nan=False) + "\n")

    def _write(self, path: Path, text: str) -> None:
        with replacing(path, _OTHER_OUT) as file:
            file.write_text(text, encoding="utf-8")

    def _read_json(self, path: Path) -> dict[str, Any]:
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError) as error:
            reason = " ".join(str(error).split())[:80]
            raise InputError(f"cannot be read ({reason})", file=str(path), remedy=_AGAIN) from None
        if not isinstance(content, dict):
            raise InputError("is not a JSON object", file=str(path), remedy=_AGAIN)
        return content

    def _refuse(self, problem: str, remedy: str) -> InputError:
        return InputError(problem, file=str(self.path), remedy=remedy)
