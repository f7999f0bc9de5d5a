"""Folder of results: paths, lock, status and atomic writes, for runs of cases and for laboratory evaluations."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, ClassVar, Literal

from filelock import FileLock, Timeout

from wroll_fem.errors import InputError, StorageError
from wroll_fem.results.json_types import json_types
from wroll_fem.results.provenance import program_version, provenance
from wroll_fem.results.storage.atomic import PARTIAL, make_folder, replacing, writing_error
from wroll_fem.results.storage.paths import check_path
from wroll_fem.results.summary_types import well_typed

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


class ResultFolder:
    """Paths and state of one folder of results.

    Parameters
    ----------
    path
        Path of the folder; only `locked` creates it.

    Attributes
    ----------
    INPUT
        Name of the file with the complete input.
    input_file, summary_file, results_file, log_file, provenance_file : Path
        The input, summary.json, results.nc, run.log, provenance.json.
    lock_file : Path
        .lock (empty), locked by the process that works in the folder. It is not deleted:
        a deleted lock file could be locked twice.
    reserve_file : Path
        .reserve, some kilobytes kept while a run works, so that its end can be recorded on a full disk.
    figures : Path
        Subfolder for figures.
    """

    INPUT: ClassVar[str] = "settings.yaml"

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        check_path(self.path, _OTHER_OUT)
        self.input_file = self.path / self.INPUT
        self.summary_file = self.path / "summary.json"
        self.results_file = self.path / "results.nc"
        self.log_file = self.path / "run.log"
        self.lock_file = self.path / LOCK
        self.reserve_file = self.path / ".reserve"
        self.provenance_file = self.path / "provenance.json"
        self.figures = self.path / "figures"

    @property
    def subfolders(self) -> tuple[Path, ...]:
        """Folders in the folder."""
        return (self.figures,)

    def check_empty(self) -> None:
        """Refuse a path that is a file, and a folder with results or with other files, without writing to it.

        Files of an evaluation that did not end may be in the folder.

        Raises
        ------
        InputError
            If the path cannot be a new folder of results.
        """
        if self.path.exists() and not self.path.is_dir():
            raise self._refuse("is a file, not a folder", "choose another --out")
        if not self.path.exists() or not any(self._held()):
            return
        own = (self.input_file, self.provenance_file, self.summary_file, self.results_file, self.figures)
        unfinished = self.status() not in (None, "complete") and set(self._held()) <= set(own)
        if not unfinished:
            raise self._refuse("is not empty", "choose another --out, or delete the folder")

    def _held(self) -> Iterator[Path]:
        """Files of the folder, except log, lock, reserve and partial files."""
        other = (self.log_file, self.lock_file, self.reserve_file)
        return (p for p in self.path.iterdir() if p not in other and p.suffix != PARTIAL)

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
        for place in (self.log_file, self.lock_file, *self.subfolders):
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

    def start(self, text: str, **entries: Any) -> None:
        """Write the input and provenance.json when the work in the locked folder starts.

        Parameters
        ----------
        text
            Complete input (YAML).
        entries
            Entries of provenance.json.

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
        head = f"# resolved by wroll_fem {program_version()}; all defaults are filled in\n"
        self.write_text(self.input_file, head + text)
        self.record("running", **entries)

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
        self.write_text(path, json.dumps(json_types(content), indent=2, allow_nan=False) + "\n")

    def write_text(self, path: Path, text: str) -> None:
        """Write a text atomically."""
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
