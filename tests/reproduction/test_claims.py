"""`wroll reproduce`: the checklist, the evidence for verdicts, reports of failures."""

from __future__ import annotations

import contextlib
import csv
import os
import re
import signal
from concurrent.futures import Future
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from support.here_pool import HerePool
from support.paths import ROOT
from support.processes import process_and_square
from typer.testing import CliRunner

from reproduction import CHAPTERS, ClaimGroup, Evidence, Verdict, checklist, evidence, page, queue, reproduce
from reproduction.checklist import explanations, of_chapters
from reproduction.verdict import MET, NOT_COMPUTED, NOT_MET, NOT_YET, THESIS_ERROR, VERDICTS
from wroll_fem.cli import app
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.jobs.batch import Outcome
from wroll_fem.jobs.executors import Job
from wroll_fem.plotting import style
from wroll_fem.progress import SilentProgress

REPRODUCED = list(reproduce.GROUPS)


def test_checklist_is_complete_and_in_order() -> None:
    claims = checklist()
    assert list(claims) == [f"C{number}" for number in range(1, 127)]
    assert {claim.kind for claim in claims.values()} == {"value", "ordering", "definition", "experiment"}
    assert list(dict.fromkeys(claim.chapter for claim in claims.values())) == list(CHAPTERS)
    assert all(claim.claim and claim.accept and claim.where for claim in claims.values())


def test_chapters_are_chosen_by_name() -> None:
    assert [claim.number for claim in of_chapters(["ch5"])] == list(range(77, 91))
    assert len(of_chapters([])) == 126
    with pytest.raises(InputError, match="no such chapter: ch7"):
        of_chapters(["ch2", "ch7"])


def test_explanations_belong_to_claims() -> None:
    assert set(explanations()) <= set(checklist())
    assert all(len(text) > 80 for text in explanations().values())


@pytest.mark.parametrize("chapter", REPRODUCED)
def test_every_claim_of_a_chapter_has_one_judge(chapter: str) -> None:
    names = [name for group in reproduce.claim_groups(chapter) for name in group.judges]
    assert sorted(names) == sorted(claim.id for claim in of_chapters([chapter]))


def test_every_figure_has_a_name_of_its_own() -> None:
    names = [name for chapter in REPRODUCED for group in reproduce.claim_groups(chapter) for name in group.figures]
    assert len(names) == len(set(names)) > 30


def test_claims_that_are_not_met_or_name_an_error_are_explained() -> None:
    """By the verdicts on the page."""
    text = (ROOT / "docs" / "claims.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| (C\d+) \|.*\*\*(.+)\*\*(?:, by construction)? \|$", text, re.MULTILINE))
    assert list(rows) == list(checklist())
    needed = [name for name, word in rows.items() if word in (NOT_MET, THESIS_ERROR)]
    assert len(needed) > 15
    for name in needed:
        assert name in explanations()
        if rows[name] == NOT_MET:
            assert "computed" in explanations()[name].lower(), name
            assert "cause" in explanations()[name].lower(), name


def test_a_verdict_that_the_checklist_does_not_know_is_refused() -> None:
    assert Verdict("1", True).word == MET
    with pytest.raises(ValueError, match="maybe"):
        Verdict("1", True, "maybe")


# ---- evidence ------------------------------------------------------------------------------------


def count_runs(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    seen: list[str] = []
    run = evidence.run_analysis

    def counted(case, **keywords):
        seen.append(case.hash())
        return run(case, **keywords)

    monkeypatch.setattr(evidence, "run_analysis", counted)
    return seen


def test_a_case_is_computed_once_and_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = count_runs(monkeypatch)
    first = Evidence(tmp_path, workers=1)
    a, b = first.results([("winding_lab",), ("winding_lab", "winding.tension_newton=20")])
    again = Evidence(tmp_path, workers=1).result("winding_lab")
    assert len(seen) == 2
    xr.testing.assert_identical(a, again)
    assert float(b["pressure_pa"][0]) < float(a["pressure_pa"][0])


def test_a_study_with_a_failed_case_is_not_used_and_not_run_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs: list[str] = []

    def half(grid, out, **keywords):
        runs.append(out.name)
        good, *others = grid.members
        return [Outcome(good, "complete"), *(Outcome(member, "failed", "no convergence", 3) for member in others)]

    monkeypatch.setattr(evidence, "run_grid", half)
    given = Evidence(tmp_path, workers=1)
    for _ in range(2):
        with pytest.raises(InputError, match="study preload_low is not complete"):
            given.study("preload_low")
    assert runs == ["preload_low"]


def test_the_groups_declare_the_studies_that_their_modules_name() -> None:
    stems = {path.stem for path in (ROOT / "configs" / "studies").glob("*.yaml")}
    text = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "reproduction").glob("*.py"))
    named = {stem for stem in stems - {"integrators"} if f'"{stem}"' in text}  # "integrators" is a module as well
    groups = [group for chapter in REPRODUCED for group in reproduce.claim_groups(chapter)]
    declared = {study for group in groups for study in (*group.studies, *group.partial_studies)}
    assert declared == named


class QueuedJobs:
    """Pool that notes jobs in place of running them; the results of a job never come."""

    def __init__(self, workers: int) -> None:
        self.folders: list[str] = []
        self.calls: list[str] = []

    def submit(self, jobs):
        self.folders += [f"{job.folder.parent.name}/{job.folder.name}" for job in jobs]
        return [Future() for _ in jobs]

    def stop(self) -> None:
        self.calls.append("stop")

    def close(self) -> None:
        self.calls.append("close")


def test_all_studies_of_the_chapters_are_queued_before_the_first_claim_is_judged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(queue, "LocalPool", QueuedJobs)
    given = Evidence(tmp_path, fast=True, workers=2)
    reproduce.begin_studies(["ch4", "appendices"], given)
    pool = given._studies_queue._pool
    assert pool.folders[0].startswith("bounds/")
    assert {folder.split("/")[0] for folder in pool.folders} >= {"preload", "layer_count", "friction_laws"}
    assert len(set(pool.folders)) == len(pool.folders)  # "bounds" serves two groups
    given.__exit__(KeyboardInterrupt, KeyboardInterrupt(), None)
    assert pool.calls == ["stop", "close"]


def test_a_queued_case_is_awaited_and_not_started_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "LocalPool", QueuedJobs)
    shared = queue.StudyQueue(2)
    a, b, c = (Job([name], tmp_path / name) for name in "abc")
    shared.begin([a, b])
    futures = shared.submit([b, c, a])
    assert shared._pool.folders == [f"{tmp_path.name}/{name}" for name in "abc"]
    assert len(set(futures)) == 3
    assert shared.submit([b]) == futures[:1]


def test_a_computation_is_kept_under_its_inputs(tmp_path: Path) -> None:
    calls: list[int] = []

    def compute(value: float) -> xr.Dataset:
        calls.append(1)
        return xr.Dataset({"square": ("x", np.array([value**2]))})

    for value in (2.0, 3.0, 2.0):
        found = Evidence(tmp_path).kept("square", lambda value=value: compute(value), value=value)
        assert float(found["square"][0]) == value**2
    assert len(calls) == 2


def test_map_keeps_the_order_and_leaves_this_process(tmp_path: Path) -> None:
    with Evidence(tmp_path, workers=2) as many:
        found = many.map(process_and_square, list(range(6)))
    assert [square for _, square in found] == [x * x for x in range(6)]
    assert os.getpid() not in {number for number, _ in found}


@pytest.fixture
def coarse(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Evidence:
    monkeypatch.setattr(queue, "LocalPool", HerePool)
    found = Evidence(tmp_path, fast=True, workers=1)
    change = {"overrides": ["winding.wraps=5"], "keep": {"winding.tension_newton": [20.0, 60.0]}}
    monkeypatch.setitem(
        found.__dict__, "_coarse",
        {"cases": {"winding_lab": ["winding.wraps=7", "winding.mu=0.3"]}, "studies": {"winding_tension": change}},
    )  # fmt: skip
    return found


def test_fast_changes_cases_unless_they_are_asked_for(coarse: Evidence) -> None:
    case = coarse.case("winding_lab", "winding.mu=0.4")
    assert case.winding is not None
    assert (case.winding.wraps, case.winding.mu) == (7, 0.4)
    whole = Evidence(coarse.folder).case("winding_lab").winding
    assert whole is not None
    assert whole.wraps == 25


def test_fast_studies_have_fewer_and_coarser_cases(coarse: Evidence) -> None:
    members = coarse.study("winding_tension")
    assert [m.values["winding.tension_newton"] for m in members] == [20.0, 60.0]
    assert {m.data.sizes["wrap"] for m in members} == {5}
    assert coarse.one("winding_tension", winding__tension_newton=60.0) is members[1]
    with pytest.raises(InputError, match="no finished case"):
        coarse.one("winding_tension", winding__tension_newton=40.0)
    with pytest.raises(InputError, match="reference"):
        coarse.reference("winding_tension")


def test_every_entry_of_fast_names_what_exists(tmp_path: Path) -> None:
    whole, quick = Evidence(tmp_path), Evidence(tmp_path, fast=True)
    for name in quick._coarse["cases"]:
        assert quick.case(name).hash() != whole.case(name).hash(), name
    for name in quick._coarse["studies"]:
        coarse, fine = quick.grid(name).members, whole.grid(name).members
        assert coarse, name
        assert len(coarse) < len(fine) or {m.case.hash() for m in coarse} != {m.case.hash() for m in fine}, name


def test_without_the_case_files_the_message_says_where_to_run(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="run from a clone of the project"):
        Evidence(tmp_path, configs=tmp_path)


# ---- verdicts and page ---------------------------------------------------------------------------


def figure(_: Evidence):
    ax = style.axes(None)
    ax.plot([0.0, 1.0], [0.0, 1.0])
    return ax


def broken(_: Evidence) -> Verdict:
    raise ConvergenceError("no step", time_s=0.1, iterations=9, residual_history=[1.0], advice="a smaller one")


def missing(_: Evidence):
    raise InputError("study x has no finished case")


@pytest.fixture
def pretend(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three claims of chapter 6: met, not met, one whose run fails; a figure that can be drawn and one that cannot."""
    group = ClaimGroup(
        {
            "C91": lambda _: Verdict("a | b", True),
            "C92": lambda _: Verdict("off", False),
            "C93": broken,
        },
        figures={"line": ("A line", figure), "none": ("Nothing", missing)},
        tables={"Numbers": lambda _: "| a |\n|---|\n| 1 |\n"},
    )
    real = reproduce.claim_groups
    monkeypatch.setattr(reproduce, "claim_groups", lambda name: [group] if name == "ch6" else real(name))
    monkeypatch.setattr(page, "claim_groups", lambda name: [group] if name == "ch6" else real(name))
    texts = {"C92": "Because of the sign."}
    monkeypatch.setattr(page, "explanations", lambda: texts)


def test_an_interrupt_that_becomes_another_error_ends_the_command(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The tables of an interrupted study may not be writable; the claim is then not "not computed"."""

    def interrupted(_: Evidence) -> Verdict:
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        raise InputError("cannot be written")

    monkeypatch.setattr(reproduce, "claim_groups", lambda _: [ClaimGroup({"C93": interrupted})])
    done = CliRunner().invoke(app, ["reproduce", "ch6", "--out", str(tmp_path)])
    assert done.exit_code == 130
    assert "interrupted" in done.output
    assert "C94" not in done.output


@pytest.mark.usefixtures("pretend")
def test_page_table_and_exit_code(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["reproduce", "ch6", "--out", str(tmp_path)])
    assert done.exit_code == 3
    assert "C93" in done.output
    assert "warning: figure none is not drawn: study x has no finished case" in done.output
    with (tmp_path / "claims.csv").open() as stream:
        rows = {row["id"]: row for row in csv.DictReader(stream)}
    assert len(rows) == len(of_chapters(["ch6"]))
    assert [rows[name]["verdict"] for name in ("C91", "C92", "C93", "C94")] == [MET, "not met", NOT_COMPUTED, NOT_YET]
    assert [rows[name]["basis"] for name in ("C91", "C92")] == ["construction", "evidence"]
    assert "did not converge" in rows["C93"]["value"]
    text = (tmp_path / "claims.md").read_text()
    assert "`wroll reproduce ch6`" in text
    assert r"a \| b | **met**, by construction |" in text
    assert "### C92: not met\n\nBecause of the sign." in text
    assert "![A line](figures/line.png)" in text
    assert "Nothing: not drawn (study x has no finished case)" in text
    assert "**Numbers**\n\n| a |" in text
    assert (tmp_path / "figures" / "line.png").stat().st_size > 1000


@pytest.mark.usefixtures("pretend")
def test_claims_without_an_explanation_are_named(tmp_path: Path) -> None:
    judged = reproduce.judge(["ch6"], Evidence(tmp_path), Evidence(tmp_path).progress)
    assert page.unexplained(judged) == []
    page.explanations().clear()
    told = SilentProgress()
    reproduce.reproduce(["ch6"], tmp_path, progress=told)
    assert told.warnings[0].startswith("no explanation of C92:")
    judged = [reproduce.Judged(checklist()["C94"], Verdict("", False), 0.0)]
    assert page.unexplained(judged) == ["C94"]


def test_count_names_each_verdict_once(tmp_path: Path) -> None:
    claims = [claim for claim in checklist().values() if not claim.by_construction]
    judged = [
        reproduce.Judged(claim, Verdict("", True, word), 0.0) for claim, word in zip(claims, VERDICTS, strict=False)
    ]
    assert reproduce.count(judged) == ", ".join(f"1 {word}" for word in VERDICTS)


def test_verdicts_that_cannot_fail_are_counted_apart() -> None:
    """A claim by construction counts apart once it has a verdict; without one it waits with the others."""
    built = [claim for claim in checklist().values() if claim.by_construction]
    other = [claim for claim in checklist().values() if not claim.by_construction]
    assert {claim.id for claim in built} >= {"C10", "C33", "C119"}
    assert {claim.id for claim in other} >= {"C14", "C64", "C85"}
    words = (MET, THESIS_ERROR, NOT_YET)
    judged = [reproduce.Judged(claim, Verdict("", True, word), 0.0) for claim, word in zip(built, words, strict=False)]
    judged += [reproduce.Judged(claim, Verdict("", True), 0.0) for claim in other[:2]]
    assert reproduce.count(judged) == "2 met, 1 not yet; by construction: 1 met, 1 thesis error: explained"
    assert judged[0].line.startswith("C1    met, by construction")


def test_a_chapter_without_groups_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(reproduce.GROUPS, "ch3")
    done = CliRunner().invoke(app, ["reproduce", "ch3", "--out", str(tmp_path / "new")])
    assert done.exit_code == 0
    assert done.output.count(NOT_YET) == len(of_chapters(["ch3"])) + 1


@pytest.mark.parametrize(
    ("words", "said"),
    [(["ch9"], "no such chapter: ch9"), (["ch3", "--workers", "0"], "--workers: must be at least 1, got 0")],
)
def test_wrong_input_is_one_line(words: list[str], said: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["reproduce", *words, "--out", str(tmp_path / "new")])
    assert done.exit_code == 2
    assert said in done.output
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
def test_the_claims_on_winding_from_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduce, "GROUPS", {"ch2": ("winding",)})
    done = CliRunner().invoke(app, ["reproduce", "ch2", "--fast", "--workers", "1", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    lines = {line.split()[0]: line for line in done.output.splitlines() if line.startswith("C")}
    assert "here: 50 mm" in lines["C10"]
    assert "thesis error: explained" in lines["C5"]
    assert NOT_YET in lines["C14"]  # its claim group is left out here
    page_text = (tmp_path / "claims.md").read_text()
    assert "### C5: thesis error: explained" in page_text
    assert (tmp_path / "figures" / "winding_case_study.png").stat().st_size > 10_000


@pytest.mark.slow
def test_every_claim_gets_a_verdict_from_coarse_runs(tmp_path: Path) -> None:
    """Ten minutes on two cores."""
    done = reproduce.reproduce([], tmp_path, fast=True)
    assert [one.claim for one in done.judged] == of_chapters([])
    assert NOT_COMPUTED not in {one.verdict.word for one in done.judged}
    assert NOT_YET not in {one.verdict.word for one in done.judged}
    assert page.unexplained(done.judged) == []
