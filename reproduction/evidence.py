"""Evidence for the claims: results of cases and studies, computed once and stored."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeVar

import xarray as xr
import yaml

from reproduction.queue import StudyQueue
from wroll_fem.analyses import run_analysis
from wroll_fem.case import Case, OnRoll, load_case
from wroll_fem.errors import InputError
from wroll_fem.jobs.batch import load_series, run_grid, unfinished_jobs
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.grid import REFERENCE, Grid, Member, load_grid
from wroll_fem.plotting.study import StudyCase
from wroll_fem.progress import Progress, SilentProgress
from wroll_fem.results.dataset import load_dataset, save_dataset
from wroll_fem.results.storage.atomic import replacing

CONFIGS = Path(__file__).resolve().parents[1] / "configs"

T = TypeVar("T")
R = TypeVar("R")


class Evidence:
    """Results of the case files and studies in configs/, read from a folder or computed on demand.

    Parameters
    ----------
    folder
        Folder of the results: studies/NAME as written by `wroll batch`, cases/, and kept/ for computations that are not
        described by a case file. Stored results of the same case are used again.
    fast
        Use coarse meshes and fewer values, as specified in fast.yaml.
    workers
        Number of processes.
    """

    def __init__(
        self,
        folder: str | Path,
        *,
        fast: bool = False,
        workers: int = 2,
        progress: Progress | None = None,
        configs: str | Path = CONFIGS,
    ) -> None:
        self.folder, self.configs = Path(folder), Path(configs)
        self.fast, self.workers = fast, workers
        self.progress: Progress = progress if progress is not None else SilentProgress()
        if not (self.configs / "studies").is_dir():
            raise InputError(
                "the case files of the studies are missing", file=str(self.configs),
                remedy="run from a clone of the project, which contains configs/",
            )  # fmt: skip
        self._studies: dict[str, list[StudyCase]] = {}
        self._partial: dict[str, tuple[list[StudyCase], list[Member]]] = {}
        self._results: dict[str, xr.Dataset] = {}
        self._pool: ProcessPoolExecutor | None = None
        self._queue: StudyQueue | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._queue is not None:
            if error is not None:
                self._queue.stop()
            self._queue.close()
        if self._pool is not None:
            self._pool.shutdown(wait=error is None, cancel_futures=True)

    # ---- cases -----------------------------------------------------------------------------------

    def case(self, config: str, *overrides: str) -> Case:
        """Case of configs/ by name, with a coarse mesh if `fast`; `overrides` as for `--set` are applied last."""
        coarse = self._coarse["cases"].get(config, []) if self.fast else []
        return load_case(self.configs / f"{config}.yaml", [*coarse, *overrides])

    def roll(self, config: str, *overrides: str) -> OnRoll:
        """Case of configs/ that describes a roll, with the arguments of `case`."""
        return self.case(config, *overrides).expect(OnRoll)

    def result(self, config: str, *overrides: str) -> xr.Dataset:
        """Results of a case file."""
        return self.results([(config, *overrides)])[0]

    def results(self, cases: Iterable[Sequence[str]]) -> list[xr.Dataset]:
        """Results of many cases, each (config, override, ...), computed in parallel."""
        wanted = [(words[0], self.case(*words)) for words in cases]
        keys = [f"{config}-{case.hash()[:16]}" for config, case in wanted]
        todo = {
            key: case
            for key, (_, case) in zip(keys, wanted, strict=True)
            if key not in self._results and not self._file("cases", key).is_file()
        }
        self.map(_compute, [(case, self._file("cases", key)) for key, case in todo.items()], what="cases")
        for key in keys:
            if key not in self._results:
                self._results[key] = load_dataset(self._file("cases", key))
        return [self._results[key] for key in keys]

    def kept(self, name: str, compute: Callable[[], xr.Dataset], **inputs: Any) -> xr.Dataset:
        """Result of a computation that is not described by a case file, stored under its name and inputs.

        Parameters
        ----------
        compute
            Function called if there is no stored result; its Dataset contains real numbers and text.
        inputs
            All inputs that affect the result, in types of JSON.
        """
        file = self._kept_file(name, inputs)
        if not file.is_file():
            _write(compute(), file)
        return _read(file)

    def kept_each(
        self, name: str, work: Callable[..., xr.Dataset], inputs: Sequence[Mapping[str, Any]]
    ) -> list[xr.Dataset]:
        """Results of a module-level function for several sets of keyword arguments, computed in parallel and stored."""
        kept = [(one, self._kept_file(name, one)) for one in inputs]
        todo = [(work, dict(one), file) for one, file in kept if not file.is_file()]
        self.map(_keep, todo, what=name.replace("_", " "))
        return [_read(file) for _, file in kept]

    def map(self, work: Callable[[T], R], tasks: Sequence[T], what: str = "tasks") -> list[R]:
        """Results of a module-level function for several tasks, in parallel if there are several workers."""
        if self.workers == 1 or len(tasks) < 2:
            return [work(task) for task in tasks]
        if self._pool is None:  # spawned: a forked child would share MPI and PETSc with its parent
            self._pool = ProcessPoolExecutor(self.workers, mp_context=multiprocessing.get_context("spawn"))
        found = []
        with self.progress.stage(what, len(tasks)) as stage:
            for result in self._pool.map(work, tasks):
                found.append(result)
                stage.update(len(found))
        return found

    # ---- studies ---------------------------------------------------------------------------------

    def begin(self, studies: Iterable[str], *, partial: bool = False) -> None:
        """Start the missing cases of studies in the background; `study` and `finished` wait for them.

        Parameters
        ----------
        partial
            Whether cases of these studies may fail (see `finished`).
        """
        for name in studies:
            self._studies_queue.begin(unfinished_jobs(self.grid(name), self._study_folder(name), retry=not partial))

    @property
    def _studies_queue(self) -> StudyQueue:
        if self._queue is None:
            self._queue = StudyQueue(self.workers)
        return self._queue

    def _study_folder(self, name: str) -> Path:
        return self.folder / "studies" / name

    def study(self, name: str) -> list[StudyCase]:
        """Finished cases of configs/studies/NAME.yaml in the order of the grid; missing cases are run.

        Raises
        ------
        InputError
            If cases of the study failed.
        """
        if name not in self._studies:
            grid, out = self.grid(name), self._study_folder(name)
            outcomes = run_grid(grid, out, pool=self._studies_queue, progress=self.progress, retry=True)
            failed = [o for o in outcomes if o.status == "failed"]
            self._studies[name] = [] if failed else load_series(grid, out, lazy=True)
            if failed:
                what = f"{len(failed)} of {len(outcomes)} cases failed, the first with: {failed[0].error}"
                self.progress.warning(f"study {name}: {what}")
        if not self._studies[name]:  # told once, and not run again for every claim
            raise InputError(f"study {name} is not complete", remedy=f"see {self._study_folder(name)}")
        return self._studies[name]

    def finished(self, name: str) -> tuple[list[StudyCase], list[Member]]:
        """Finished and failed cases of a study in which some cases may fail; failed cases are not run again."""
        if name not in self._partial:
            grid, out = self.grid(name), self._study_folder(name)
            outcomes = run_grid(grid, out, pool=self._studies_queue, progress=self.progress)
            failed = [o.member for o in outcomes if o.status == "failed"]
            self._partial[name] = load_series(grid, out, lazy=True), failed
        return self._partial[name]

    def one(self, study: str, **wanted: Any) -> StudyCase:
        """Case of a study with given values; argument names are dotted keys with __ for each dot.

        Raises
        ------
        InputError
            If the study has no such case.
        """
        values = {key.replace("__", "."): value for key, value in wanted.items()}
        for member in self.study(study):
            if not member.reference and all(member.values.get(key) == value for key, value in values.items()):
                return member
        raise InputError(f"study {study} has no finished case with {values}", remedy="check its run folders")

    def reference(self, study: str) -> StudyCase:
        """Reference case of a study, outside its grid.

        Raises
        ------
        InputError
            If the study has none.
        """
        for member in self.study(study):
            if member.reference:
                return member
        raise InputError(f"the reference of study {study} is not finished", remedy="see its run folder")

    def summary(self, study: str, member: StudyCase) -> dict[str, Any]:
        """Content of summary.json of a case of a study."""
        return RunFolder(self.run_folder(study, member)).summary()

    def run_folder(self, study: str, member: StudyCase) -> Path:
        """Run folder of a case of a study."""
        return self._study_folder(study) / member.name

    def grid(self, name: str) -> Grid:
        """Cases of a study; with `fast`, fewer cases with coarse meshes."""
        grid = load_grid(self.configs / "studies" / f"{name}.yaml")
        change = self._coarse["studies"].get(name) if self.fast else None
        if change is None:
            return grid
        keep: dict[str, list[Any]] = change.get("keep", {})
        members = [
            self._coarser(member, change)
            for member in grid.members
            if all(member.values.get(key, values[0]) in values for key, values in keep.items())
        ]
        return replace(grid, members=members)

    def _coarser(self, member: Member, change: dict[str, Any]) -> Member:
        overrides = [*member.overrides, *change.get("overrides", [])]
        if member.name == REFERENCE:
            overrides = [*member.overrides, *change.get("reference", [])]
        return replace(member, overrides=overrides, case=load_case(member.file, overrides))

    @cached_property
    def _coarse(self) -> dict[str, dict[str, Any]]:
        text = (files(__package__) / "fast.yaml").read_text(encoding="utf-8")
        return {"cases": {}, "studies": {}} | {key: part or {} for key, part in yaml.safe_load(text).items()}

    def _file(self, kind: str, name: str) -> Path:
        return self.folder / kind / f"{name}.nc"

    def _kept_file(self, name: str, inputs: Mapping[str, Any]) -> Path:
        text = json.dumps(inputs, sort_keys=True)
        return self._file("kept", f"{name}-{hashlib.sha256(text.encode()).hexdigest()[:16]}")


def _compute(task: tuple[Case, Path]) -> None:
    case, file = task
    save_dataset(run_analysis(case, progress=SilentProgress()), file)


def _keep(task: tuple[Callable[..., xr.Dataset], dict[str, Any], Path]) -> None:
    work, inputs, file = task
    _write(work(**inputs), file)


def _write(data: xr.Dataset, file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    with replacing(file) as partial:
        data.to_netcdf(partial, engine="h5netcdf")


def _read(file: Path) -> xr.Dataset:
    with xr.open_dataset(file, engine="h5netcdf") as data:
        return data.load()
