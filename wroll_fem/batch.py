"""Run a grid of cases: only what is not yet done, each case in a process of its own; one table of all."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import CancelledError, Future, as_completed, wait
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .errors import InputError
from .grid import REFERENCE, Grid, Member
from .pools import ClusterPool, Ended, LocalPool, Pool
from .progress import Progress, SilentProgress
from .run_folder import RunFolder, plain

if TYPE_CHECKING:
    import xarray as xr

STOP_SECONDS = 30.0
"""How long cases may take to save themselves when a batch is interrupted."""

_UNITS = {"hz": "Hz", "j": "J", "pa": "Pa", "m": "m", "s": "s", "kg": "kg", "m_s2": "m s-2", "rad": "rad"}
"""Last words of a name in summary.json -> unit."""


@dataclass(frozen=True)
class Outcome:
    """What became of one case.

    Attributes
    ----------
    status
        "complete", "already done" or "failed".
    error
        One line; empty unless failed.
    exit_code
        That of `wroll run`.
    """

    member: Member
    status: Literal["complete", "already done", "failed"]
    error: str = ""
    exit_code: int = 0


def run_grid(
    grid: Grid,
    out: str | Path,
    *,
    workers: int = 1,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> list[Outcome]:
    """Run every case of a grid that is not yet done, each in a process and a run folder of its own.

    Parameters
    ----------
    grid
        What to run.
    out
        Folder that gets one run folder per case and the tables batch.csv and batch.nc.
    workers
        Cases at a time, each on one thread, on this machine.
    scheduler
        Address of a Dask scheduler, "tcp://HOST:PORT", whose workers run the cases; they must see the same files.
    progress
        Gets one line per finished case.

    Returns
    -------
    list of Outcome
        In the order of the grid. A failed case stops no other.

    Raises
    ------
    InputError
        For fewer than one worker, a scheduler that does not answer, a folder that cannot be written or holds another
        batch.
    KeyboardInterrupt
        After every running case has saved itself; the tables hold what was done.

    Notes
    -----
    A case counts as done when its folder holds the results of a case with the same hash; an unfinished one goes on from
    its checkpoint.
    """
    progress = progress if progress is not None else SilentProgress()
    out = Path(out)
    _check_own(grid, out)
    pool: Pool = LocalPool(workers) if scheduler is None else ClusterPool(scheduler)
    try:
        return _run_all(grid, out, pool, progress)
    finally:
        pool.close()


def _run_all(grid: Grid, out: Path, pool: Pool, progress: Progress) -> list[Outcome]:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"cannot be written ({error.strerror})", file=str(out), remedy="choose another --out"
        ) from None
    outcomes: dict[str, Outcome] = {}
    total = len(grid.members)

    def finished(outcome: Outcome) -> None:
        outcomes[outcome.member.name] = outcome
        progress.info(f"{len(outcomes)} of {total}  {outcome.member.name}: {_told(outcome, out)}")

    todo = []
    for member in grid.members:
        done = _found(member, out)
        if done is None:
            todo.append(member)
        else:
            finished(done)
    started = {pool.submit(_words(member, out), out / member.name): member for member in todo}
    try:
        for future in as_completed(started):
            finished(_outcome(started[future], future))
    except KeyboardInterrupt:
        pool.stop()
        wait(started, timeout=STOP_SECONDS)
        raise
    finally:
        write_tables(list(outcomes.values()), out)
    ordered = [outcomes[member.name] for member in grid.members]
    write_tables(ordered, out)
    return ordered


def _words(member: Member, out: Path) -> list[str]:
    """Arguments of `wroll run` for one case."""
    words = [str(member.file), "--out", str(out / member.name), "--resume"]
    return words + [word for text in member.overrides for word in ("--set", text)]


def _outcome(member: Member, future: Future[Ended]) -> Outcome:
    try:
        code, said = future.result()
    except (CancelledError, Exception) as error:  # a worker lost for good must not stop the other cases
        return Outcome(member, "failed", f"its worker failed: {type(error).__name__}: {error}".splitlines()[0], 1)
    return Outcome(member, "complete") if code == 0 else Outcome(member, "failed", said, code)


def _check_own(grid: Grid, out: Path) -> None:
    """Refuse a folder that holds the table of a batch without any case of this one."""
    table = out / "batch.csv"
    if not table.is_file():
        return
    with table.open(newline="", encoding="utf-8") as stream:
        names = [row.get("name", "") for row in csv.DictReader(stream)]
    if names and not {member.name for member in grid.members} & set(names):
        raise InputError(
            f"holds another batch ({len(names)} cases, the first is {names[0]})", file=str(out), key="--out",
            remedy="choose another folder, or delete this one",
        )  # fmt: skip


def _found(member: Member, out: Path) -> Outcome | None:
    """Outcome of a case that need not, or must not, be run."""
    try:
        start = RunFolder(out / member.name).check(member.case, resume=True)
    except InputError as error:
        return Outcome(member, "failed", str(error), error.exit_code)
    return Outcome(member, "already done") if start == "complete" else None


def _told(outcome: Outcome, out: Path) -> str:
    if outcome.status == "failed":
        return f"FAILED: {outcome.error}"
    summary = RunFolder(out / outcome.member.name).summary()
    words: list[str] = [outcome.status]
    if summary.get("f_n_hz") is not None:
        words.append(f"f_n {summary['f_n_hz']:.2f} Hz")
    if summary.get("zeta") is not None:
        words.append(f"zeta {100 * summary['zeta']:.2f} %")
    if outcome.status == "complete" and summary.get("wall_time_s") is not None:
        words.append(f"{summary['wall_time_s']:.1f} s")
    return ", ".join(words)


def table_rows(outcomes: Sequence[Outcome], out: Path) -> list[dict[str, Any]]:
    """One row per case: name, status, error, the grid's keys, and every single value of its summary."""
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


def _cell(value: Any) -> Any:
    return json.dumps(plain(value)) if isinstance(value, list | dict) else value


def write_tables(outcomes: Sequence[Outcome], out: Path) -> None:
    """Write batch.csv (one row per case) and batch.nc (the same over the dimension `case`, with units)."""
    rows = table_rows(outcomes, out)
    columns = list(dict.fromkeys(key for row in rows for key in row))
    partial = out / "batch.csv.partial"
    with partial.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, columns)
        writer.writeheader()
        writer.writerows(rows)
    os.replace(partial, out / "batch.csv")
    partial = out / "batch.nc.partial"
    table_dataset(rows).to_netcdf(partial, engine="h5netcdf")
    os.replace(partial, out / "batch.nc")


def table_dataset(rows: Sequence[Mapping[str, Any]]) -> xr.Dataset:
    """Rows of the table as a Dataset over `case`: numbers (nan where missing) with units, everything else as text."""
    import xarray as xr

    data = {}
    for key in dict.fromkeys(key for row in rows for key in row):
        values = [row.get(key) for row in rows]
        if all(value is None or isinstance(value, int | float) for value in values):
            numbers = np.array([np.nan if value is None else float(value) for value in values])
            words = key.split("_")
            unit = next((_UNITS[tail] for n in (2, 1) if (tail := "_".join(words[-n:])) in _UNITS), "1")
            data[key] = ("case", numbers, {"units": unit, "long_name": key.replace("_", " ")})
        else:
            texts = np.array(["" if value is None else str(value) for value in values], dtype=object)
            data[key] = ("case", texts, {"long_name": key.replace("_", " ")})
    return xr.Dataset(data, coords={"case_number": ("case", np.arange(1, len(rows) + 1))})


def draw_figures(grid: Grid, outcomes: Sequence[Outcome], out: str | Path) -> list[Path]:
    """Draw the figures that the grid file names from the finished cases, into `out`/figures.

    Raises
    ------
    InputError
        When the results lack what a figure needs.
    """
    from .plotting import save_figure
    from .plotting.series import FIGURES
    from .plotting.study import SeriesMember
    from .results import load_dataset

    finished = [
        SeriesMember(
            o.member.name, o.member.values, load_dataset(RunFolder(Path(out) / o.member.name).results_file),
            reference=o.member.name == REFERENCE,
        )
        for o in outcomes
        if o.status != "failed"
    ]  # fmt: skip
    if not any(not member.reference for member in finished):
        return []
    return [save_figure(FIGURES[name](finished), Path(out) / "figures" / f"{name}.png") for name in grid.figures]
