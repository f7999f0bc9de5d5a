"""Batch: run the unfinished cases of a grid in separate processes, and write the table and figures of the study."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from wroll_fem.case.roll import RollSections
from wroll_fem.errors import ConvergenceError, InputError, StorageError
from wroll_fem.jobs.batch_progress import BatchProgress
from wroll_fem.jobs.executors import ClusterPool, Ended, Job, LocalPool, Pool
from wroll_fem.jobs.folder import LOCK, RunFolder, locked_by_one
from wroll_fem.jobs.grid import REFERENCE, Grid, Member
from wroll_fem.progress import Progress, SilentProgress
from wroll_fem.results.json_types import json_types
from wroll_fem.results.storage.atomic import make_folder, replacing
from wroll_fem.results.storage.paths import check_path
from wroll_fem.results.storage.seal import write_sealed
from wroll_fem.results.summary import netcdf_unit

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.plotting.study import StudyCase

STOP_SECONDS = 30.0
"""Longest wait for running cases to save checkpoints after an interrupt, s."""

LOOK_SECONDS = 1.0
"""Interval between updates of the list of running cases, s."""


@dataclass(frozen=True)
class Outcome:
    """Result of one case of a batch.

    Attributes
    ----------
    status
        "complete", "already done" or "failed".
    error
        One line; empty unless failed.
    exit_code
        Exit code of `wroll run`.
    tried
        False for a case that failed in an earlier call and was not tried again.
    """

    member: Member
    status: Literal["complete", "already done", "failed"]
    error: str = ""
    exit_code: int = 0
    tried: bool = True


def run_grid(
    grid: Grid,
    out: str | Path,
    *,
    workers: int = 1,
    scheduler: str | None = None,
    pool: Pool | None = None,
    retry: bool = False,
    progress: Progress | None = None,
) -> list[Outcome]:
    """Run the unfinished cases of a grid, each in its own process and run folder.

    Parameters
    ----------
    grid
        Grid of cases.
    out
        Folder that gets one run folder per case and the tables batch.csv and batch.nc.
    workers
        Number of cases that run at the same time on this machine, each on one thread.
    scheduler
        Address of a Dask scheduler, "tcp://HOST:PORT", whose workers run the cases; they must see the same files.
    pool
        Pool that runs the cases in place of ``workers`` and ``scheduler``; it stays open.
    retry
        Run again the cases that failed in earlier calls (no convergence, or an error).
    progress
        Receives one line per finished case, and the names of the running cases.

    Returns
    -------
    list of Outcome
        In the order of the grid. A failed case does not stop the others.

    Raises
    ------
    InputError
        For fewer than one worker, a scheduler that does not answer, a folder that cannot be written, holds another
        batch, or in which another batch is at work.
    StorageError
        If the tables cannot be written because the disk is full or fails.
    KeyboardInterrupt
        After all running cases have saved checkpoints; the tables contain the finished cases.

    Notes
    -----
    A case counts as done when its folder holds the results of a case with the same hash. A failed case
    is reported as failed and runs again only with `retry`, because it would fail in the same way. An interrupted or
    killed case, and one that a full disk stopped, is unfinished and continues from its checkpoint.
    """
    progress = progress if progress is not None else SilentProgress()
    out = Path(out)
    check_path(out, "choose another --out")
    _check_own(grid, out)
    chosen: Pool = pool or (LocalPool(workers) if scheduler is None else ClusterPool(scheduler))
    try:
        with locked_by_one(make_folder(out, "choose another --out") / LOCK, out):
            return _run_all(grid, out, chosen, progress, retry=retry)
    finally:
        if pool is None:
            chosen.close()


def unfinished_jobs(grid: Grid, out: str | Path, *, retry: bool = False) -> list[Job]:
    """Runs of the cases of a grid that `run_grid` would start, in the order of the grid."""
    out = Path(out)
    return [_job(member, out) for member in grid.members if _found(member, out, retry=retry) is None]


def _run_all(grid: Grid, out: Path, pool: Pool, progress: Progress, *, retry: bool) -> list[Outcome]:
    outcomes: dict[str, Outcome] = {}
    counts = BatchProgress(len(grid.members))

    def finished(outcome: Outcome, started: float | None = None) -> None:
        outcomes[outcome.member.name] = outcome
        counts.add(failed=outcome.status == "failed", started=started)
        progress.info(f"{counts.done} of {counts.total}  {outcome.member.name}: {_outcome_line(outcome, out)}")

    todo = []
    for member in grid.members:
        done = _found(member, out, retry=retry)
        if done is None:
            todo.append(member)
        else:
            finished(done)
    try:
        if todo:
            _run_some(todo, out, pool, progress, counts, finished)
    finally:
        write_tables([outcomes[member.name] for member in grid.members if member.name in outcomes], out)
    return [outcomes[member.name] for member in grid.members]


def _run_some(
    todo: Sequence[Member],
    out: Path,
    pool: Pool,
    progress: Progress,
    counts: BatchProgress,
    finished: Callable[..., None],
) -> None:
    """Run cases in parallel, show the running cases, and report each finished case."""
    seen: dict[str, float] = {}  # name -> start of every case that was seen at work
    pending = dict(zip(pool.submit([_job(member, out) for member in todo]), todo, strict=True))
    with progress.stage("batch", counts.total, "cases") as stage:
        try:
            while pending:
                ended, _ = wait(pending, timeout=LOOK_SECONDS, return_when=FIRST_COMPLETED)
                for future in ended:
                    member = pending.pop(future)
                    finished(_outcome(member, future), seen.get(member.name, counts.begun))
                names = {member.name for member in pending.values()}  # the pool may have others, of another batch
                running = {name: start for name, start in pool.at_work().items() if name in names}
                seen |= running
                stage.update(counts.done, counts.note(running), counts.left(running))
        except KeyboardInterrupt:
            pool.stop()
            wait(pending, timeout=STOP_SECONDS)
            raise


def _job(member: Member, out: Path) -> Job:
    """`wroll run` of one case, with its structure if it is that of a roll."""
    words = [str(member.file), "--out", str(out / member.name), "--resume"]
    words += [word for text in member.overrides for word in ("--set", text)]
    structure = member.case.structure_text if isinstance(member.case, RollSections) else ""
    return Job(words, out / member.name, structure)


def _outcome(member: Member, future: Future[Ended]) -> Outcome:
    try:
        code, message = future.result()
    except CancelledError:
        return Outcome(
            member,
            "failed",
            "the cluster cancelled it; check that the scheduler still runs, then run the batch again",
            1,
        )
    except Exception as error:  # a worker lost for good must not stop the other cases
        return Outcome(member, "failed", f"its worker failed: {type(error).__name__}: {error}".splitlines()[0], 1)
    return Outcome(member, "complete") if code == 0 else Outcome(member, "failed", message, code)


def _check_own(grid: Grid, out: Path) -> None:
    """Refuse a folder with the table of another batch."""
    table = out / "batch.csv"
    if not table.is_file():
        return
    with table.open(newline="", encoding="utf-8") as stream:
        names = [row.get("name", "") for row in csv.DictReader(stream)]
    if names and not {member.name for member in grid.members} & set(names):
        raise InputError(
            f"contains another batch ({len(names)} cases, the first is {names[0]})", file=str(out), key="--out",
            remedy="choose another folder, or delete this one",
        )  # fmt: skip


def _found(member: Member, out: Path, *, retry: bool) -> Outcome | None:
    """Outcome of a case that is already done or failed in an earlier call; None if the case is to be run."""
    folder = RunFolder(out / member.name)
    try:
        start = folder.check(member.case, resume=True)
        held = folder.provenance()
        if start == "complete":
            folder.summary()
    except InputError as error:
        return Outcome(member, "failed", str(error), error.exit_code)
    if start == "complete":
        return Outcome(member, "already done")
    ended = held.get("status") in ("not_converged", "failed") and held.get("case_hash") == member.case.hash()
    ended = ended and held.get("exit_code") != StorageError.exit_code  # there may be room by now
    if retry or not ended:
        return None
    message = str(held.get("error", "see its run.log")).splitlines()[0]
    return Outcome(member, "failed", message, int(held.get("exit_code", ConvergenceError.exit_code)), tried=False)


def _outcome_line(outcome: Outcome, out: Path) -> str:
    if outcome.status == "failed":
        return f"FAILED{'' if outcome.tried else ' before'}: {outcome.error}"
    summary = RunFolder(out / outcome.member.name).summary()
    single = {key: value for key, value in summary.items() if isinstance(value, float)}
    words: list[str] = [outcome.status]
    if "f_n_hz" in single:
        words.append(f"f_n {single['f_n_hz']:.2f} Hz")
    if "zeta" in single:
        doubtful = " (doubtful)" if summary.get("zeta_quality") == "doubtful" else ""
        words.append(f"zeta {100 * single['zeta']:.2f} %{doubtful}")
    if outcome.status == "complete" and "wall_time_s" in single:
        words.append(f"{single['wall_time_s']:.1f} s")
    return ", ".join(words)


def table_rows(outcomes: Sequence[Outcome], out: Path) -> list[dict[str, Any]]:
    """Rows of the table, one per case: name, status, error, keys of the grid, and scalar values of the summary."""
    rows = []
    for outcome in outcomes:
        status = "failed" if outcome.status == "failed" else "complete"
        row: dict[str, Any] = {"name": outcome.member.name, "status": status, "error": outcome.error}
        row |= {key: _cell(value) for key, value in outcome.member.values.items()}
        if status == "complete":
            summary = RunFolder(out / outcome.member.name).summary()
            row |= {key: value for key, value in summary.items() if not isinstance(value, list | dict)}
        rows.append(row)
    return rows


def _no_formula(value: Any) -> Any:
    """Cell that a spreadsheet shows: a text that it would take for a formula begins with an apostrophe."""
    return f"'{value}" if isinstance(value, str) and value.startswith(("=", "+", "-", "@", "\t", "\r")) else value


def _cell(value: Any) -> Any:
    return json.dumps(json_types(value)) if isinstance(value, list | dict) else value


def write_tables(outcomes: Sequence[Outcome], out: Path) -> None:
    """Write batch.csv (one row per case) and batch.nc (the same data with units and the dimension `case`)."""
    rows = table_rows(outcomes, out)
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with replacing(out / "batch.csv") as file, file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, columns)
        writer.writeheader()
        writer.writerows({key: _no_formula(value) for key, value in row.items()} for row in rows)
    from wroll_fem.results.dataset import netcdf_image

    write_sealed(out / "batch.nc", netcdf_image(table_dataset(rows)))


def table_dataset(rows: Sequence[Mapping[str, Any]]) -> xr.Dataset:
    """Table as a Dataset with the dimension `case`: numbers with units (nan if missing), all other values as text."""
    import xarray as xr

    data = {}
    for key in dict.fromkeys(key for row in rows for key in row):
        values = [row.get(key) for row in rows]
        if all(value is None or isinstance(value, int | float) for value in values):
            numbers = np.array([np.nan if value is None else float(value) for value in values])
            data[key] = ("case", numbers, {"units": netcdf_unit(key), "long_name": key.replace("_", " ")})
        else:
            texts = np.array(["" if value is None else str(value) for value in values], dtype=object)
            data[key] = ("case", texts, {"long_name": key.replace("_", " ")})
    return xr.Dataset(data, coords={"case_number": ("case", np.arange(1, len(rows) + 1))})


def load_series(grid: Grid, out: str | Path, *, lazy: bool = False) -> list[StudyCase]:
    """Read the finished cases of a grid from the folder of its batch, in the order of the grid.

    Parameters
    ----------
    lazy
        Read each variable on first use.

    Notes
    -----
    A folder with the results of another case (another hash) is skipped.
    """
    from wroll_fem.plotting.study import StudyCase
    from wroll_fem.results.dataset import load_dataset

    out = Path(out)
    series = []
    for member in grid.members:
        done = _found(member, out, retry=False)
        if done is not None and done.status != "failed":
            data = load_dataset(RunFolder(out / member.name).results_file, lazy=lazy)
            series.append(StudyCase(member.name, member.values, data, reference=member.name == REFERENCE))
    return series


def draw_figures(grid: Grid, out: str | Path) -> list[Path]:
    """Draw the figures that the grid file requests from the finished cases, into `out`/figures.

    Raises
    ------
    InputError
        If the results lack data that a figure needs.
    """
    from wroll_fem.plotting.names import save
    from wroll_fem.plotting.series import FIGURES

    finished = load_series(grid, out, lazy=True)
    if not any(not member.reference for member in finished):
        return []
    return [save(FIGURES[name](finished), Path(out) / "figures" / f"{name}.png") for name in grid.figures]
