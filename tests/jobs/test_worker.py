"""Processes of a batch that run the cases of one structure one after another."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from support.paths import CONFIGS, ROOT

from wroll_fem.analyses import harmonic
from wroll_fem.cli.worker import executed
from wroll_fem.dynamics.reduction.kept_structure import keeping_structure
from wroll_fem.jobs import executors, run
from wroll_fem.jobs.batch import run_grid
from wroll_fem.jobs.executors import Ended, Job, LocalPool
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.grid import load_grid
from wroll_fem.jobs.run import run_case

TINY = ROOT / "configs" / "tiny.yaml"
HANGS = 60.0


def test_a_run_ends_as_the_command_does_and_a_defect_stops_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    quick = ["--set", "output={figures: false, fields: none}"]
    assert executed([str(TINY), "--out", str(tmp_path / "good"), *quick])[0] == 0
    assert RunFolder(tmp_path / "good").status() == "complete"
    code, told = executed([str(TINY), "--out", str(tmp_path / "wrong"), "--set", "mesh.axial=0"])
    assert (code, "mesh.axial" in told) == (2, True)

    def defect(*words: object, **more: object) -> None:
        raise RuntimeError("a defect")

    monkeypatch.setattr(run, "run_case", defect)
    assert executed([str(TINY), "--out", str(tmp_path / "bad"), *quick]) == (1, "RuntimeError: a defect")


class StandIn:
    """Worker that notes its runs; a run waits until as many workers as there are threads are at work."""

    made: list[StandIn]
    both: threading.Barrier

    def __init__(self, structure: str) -> None:
        self.structure, self.alive, self.runs, self.closed = structure, True, [], False
        self.made.append(self)

    def run(self, words: list[str]) -> Ended:
        self.runs.append(words[0])
        self.both.wait(HANGS)
        if words[0] == "dies":
            self.alive = False
        return Ended(0, "")

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[StandIn]:
    StandIn.made, StandIn.both = [], threading.Barrier(2)
    monkeypatch.setattr(executors, "_Worker", StandIn)
    return StandIn.made


def work(jobs: list[tuple[str, str]], folder: Path) -> None:
    pool = LocalPool(2)
    for future in pool.submit([Job([name], folder / name, structure) for name, structure in jobs]):
        assert future.result(HANGS).code == 0
    pool.close()


def test_every_process_keeps_to_its_structure_while_it_has_runs(made: list[StandIn], tmp_path: Path) -> None:
    work([("a1", "a"), ("a2", "a"), ("a3", "a"), ("b1", "b"), ("b2", "b"), ("b3", "b")], tmp_path)
    assert {worker.structure: worker.runs for worker in made} == {"a": ["a1", "a2", "a3"], "b": ["b1", "b2", "b3"]}
    assert len(made) == 2
    assert all(worker.closed for worker in made)


def test_runs_of_the_last_structure_are_shared_by_all_processes(made: list[StandIn], tmp_path: Path) -> None:
    work([(f"a{k}", "a") for k in range(6)], tmp_path)
    assert [len(worker.runs) for worker in made] == [3, 3]


def test_runs_without_structure_and_after_a_death_get_a_new_process(made: list[StandIn], tmp_path: Path) -> None:
    work([("x1", ""), ("x2", ""), ("x3", ""), ("x4", "")], tmp_path)
    assert sorted(worker.runs for worker in made) == [["x1"], ["x2"], ["x3"], ["x4"]]
    made.clear()
    work([("dies", "a"), ("dies", "a"), ("a1", "a"), ("a2", "a")], tmp_path)
    assert len(made) == 4


@pytest.mark.slow
def test_a_batch_has_the_results_of_its_runs(tmp_path: Path) -> None:
    """Bit by bit, although the second case uses bodies and modes of the first one."""
    mesh = "mesh: [{circumferential: 8, axial: 4, grading: 8}]"
    off = "output: [{figures: false, fields: none}], harmonic: [{harmonics: 1, reduction_tolerance: 0.1}]"
    path = tmp_path / "grid.yaml"
    path.write_text(f"base: {CONFIGS / 'lab_harmonic.yaml'}\ngrid: {{preload.pressure: [1e5, 2e5], {mesh}, {off}}}\n")
    grid = load_grid(path)
    outcomes = run_grid(grid, tmp_path / "out")
    assert [outcome.status for outcome in outcomes] == ["complete", "complete"]
    for member in grid.members:
        found = RunFolder(tmp_path / "out" / member.name).summary()
        alone = run_case(member.case, tmp_path / f"alone_{member.name}").summary
        timed = ("wall_time_s", "solver_time_s")
        assert {k: v for k, v in found.items() if k not in timed} == {k: v for k, v in alone.items() if k not in timed}


def test_a_process_computes_the_modes_of_its_structure_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    computed: list[int] = []
    condense = harmonic.condense
    monkeypatch.setattr(harmonic, "condense", lambda *words, **more: computed.append(1) or condense(*words, **more))
    mesh, off = "mesh={circumferential: 8, axial: 4, grading: 8}", "output={figures: false, fields: none}"
    few = ("harmonic={harmonics: 1, reduction_tolerance: 0.1}", "excitation.f_start=150", "excitation.f_end=152")
    coarse = tuple(word for text in (mesh, off, *few) for word in ("--set", text))
    with keeping_structure():
        for pressure in ("1e5", "2e5"):
            changes = (*coarse, "--set", f"preload.pressure={pressure}")
            assert executed([str(CONFIGS / "lab_harmonic.yaml"), "--out", str(tmp_path / pressure), *changes])[0] == 0
    assert len(computed) == 1
