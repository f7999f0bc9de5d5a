"""Folder of results: paths, lock, status and atomic writes, for runs of cases and for laboratory evaluations."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar, Literal

from filelock import FileLock, Timeout

from wroll_fem.errors import InputError
from wroll_fem.results.atomic import replacing
from wroll_fem.results.json_types import json_types
from wroll_fem.results.provenance import program_version, provenance

Status = Literal["running", "complete", "not_converged", "interrupted", "failed"]


class ResultFolder:
    """Paths and state of one folder of results.

    Parameters
    ----------
    path
        Path of the folder; only `opened` creates it.

    Attributes
    ----------
    INPUT
        Name of the file with the complete input.
    input_file, summary_file, results_file, log_file, provenance_file : Path
        The input, summary.json, results.nc, run.log, provenance.json.
    lock_file : Path
        .lock (empty), locked by the process that works in the folder. It is not deleted:
        a deleted lock file could be locked twice.
    figures : Path
        Subfolder for figures.
    """

    INPUT: ClassVar[str] = "settings.yaml"

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.input_file = self.path / self.INPUT
        self.summary_file = self.path / "summary.json"
        self.results_file = self.path / "results.nc"
        self.log_file = self.path / "run.log"
        self.lock_file = self.path / ".lock"
        self.provenance_file = self.path / "provenance.json"
        self.figures = self.path / "figures"

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
        """Files of the folder, except log, lock and partial files."""
        return (p for p in self.path.iterdir() if p not in (self.log_file, self.lock_file) and p.suffix != ".partial")

    def status(self) -> Status | None:
        """Status of the last run, from provenance.json."""
        return self.provenance().get("status")

    def provenance(self) -> dict[str, Any]:
        """Content of provenance.json; empty if the file is missing."""
        return self._read_json(self.provenance_file) if self.provenance_file.is_file() else {}

    def summary(self) -> dict[str, Any]:
        """Content of summary.json."""
        return self._read_json(self.summary_file)

    @contextmanager
    def opened(self, text: str, **entries: Any) -> Iterator[None]:
        """Create and lock the folder; write the input and provenance.json.

        Parameters
        ----------
        text
            Complete input (YAML).
        entries
            Entries of provenance.json.

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
            head = f"# resolved by wroll_fem {program_version()}; all defaults are filled in\n"
            self.write_text(self.input_file, head + text)
            self.record("running", **entries)
            yield

    def record(self, status: Status, **entries: Any) -> None:
        """Write `status`, `entries`, versions, git revision and machine to provenance.json.

        Older entries are kept, except at the start of a run (status "running").
        """
        kept = self.provenance() if status != "running" else {}
        self.write_json(self.provenance_file, {**kept, **provenance(), **entries, "status": status})

    def write_json(self, path: Path, content: Mapping[str, Any]) -> None:
        """Write JSON atomically, with null for numbers that are not finite."""
        self.write_text(path, json.dumps(json_types(content), indent=2, allow_nan=False) + "\n")

    def write_text(self, path: Path, text: str) -> None:
        """Write a text atomically."""
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
