"""Progress of long work: bars, plain lines, the log; state of a batch."""

from __future__ import annotations

import io
import os
import pty
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from math import isnan, nan
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from support.paths import CONFIGS

from wroll_fem import progress
from wroll_fem.analyses import run_analysis
from wroll_fem.case import load_case
from wroll_fem.errors import StorageError
from wroll_fem.jobs import batch_progress
from wroll_fem.jobs.batch_progress import BatchProgress
from wroll_fem.progress import SilentProgress, TerminalProgress, draws_bars


def test_progress_without_a_terminal_is_sparse_plain_lines(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    clock = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    stream = io.StringIO()
    with TerminalProgress(stream) as report:
        report.log_to(tmp_path / "run.log")
        with report.stage("sweep", 1000, "steps") as stage:
            for step in range(1, 1001):
                clock[0] += 0.1
                stage.update(step, "125 Hz")
        report.warning("coarse")
    lines = stream.getvalue().splitlines()
    assert lines[0] == "sweep (1000 steps) ..."
    assert re.fullmatch(r"sweep: 10% \((99|100) of 1000 steps\), 1 min 30 s left, 125 Hz", lines[1])
    assert lines[-2:] == ["sweep: done in 1 min 40 s", "warning: coarse"]
    assert len(lines) == 12
    log = (tmp_path / "run.log").read_text().splitlines()
    assert log[0].endswith(" sweep (1000 steps): start")
    assert all(re.match(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", line) for line in log)
    assert log[-1].endswith(" warning: coarse")


def test_progress_on_a_terminal_is_a_bar_and_nested_stages_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")  # rich draws nothing on a dumb one
    stream = io.StringIO()
    with TerminalProgress(stream, bars=True) as report:
        with report.stage("outer", 2) as outer, report.stage("inner", 3, "points") as inner:
            inner.update(3)
            report.info("between [brackets]")
            outer.update(1, "[note]")
            report._bars.refresh()
        report.info("after")
    text = stream.getvalue()
    assert "━" in text
    assert "[note]" in text
    assert "between [brackets]" in text
    assert "inner: done in" in text
    assert text.rstrip().endswith("after")


def test_the_log_holds_progress_that_the_terminal_shows_as_a_bar(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    stream = io.StringIO()
    with TerminalProgress(stream, bars=True) as report:
        report.log_to(tmp_path / "run.log")
        with report.stage("sweep", 4, "steps") as stage:
            stage._last -= progress.LINE_SECONDS  # type: ignore[attr-defined]
            stage.update(1, "125 Hz", 60.0)
        report.warning("coarse")
    report.info("after the log is closed")
    said = [line.split(" ", 1)[1] for line in (tmp_path / "run.log").read_text().splitlines()]
    assert said[:2] == ["sweep (4 steps): start", "sweep: 25% (1 of 4 steps), 1 min 00 s left, 125 Hz"]
    assert said[2].startswith("sweep: done in ")
    assert said[3:] == ["warning: coarse"]
    assert "25% (1 of 4" not in stream.getvalue()


@pytest.mark.parametrize(("term", "bars"), [("xterm", True), ("dumb", False), ("unknown", False), (None, False)])
def test_bars_need_a_terminal_that_can_redraw_a_line(
    term: str | None, bars: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if term is None:
        monkeypatch.delenv("TERM", raising=False)
    else:
        monkeypatch.setenv("TERM", term)
    _, terminal = pty.openpty()
    with open(terminal, "w") as stream:
        assert draws_bars(stream) == bars
    assert not draws_bars(io.StringIO())


def test_a_run_in_the_background_of_a_shell_draws_no_bar() -> None:
    """A session with a terminal of its own; the same process, first in the foreground, then beside it."""
    code = """
import fcntl, os, pty, sys, termios
from wroll_fem.progress import draws_bars
terminal = open(pty.openpty()[1], "w")
fcntl.ioctl(terminal, termios.TIOCSCTTY, 0)
found = [draws_bars(terminal)]
if os.fork() == 0:
    os.setpgid(0, 0)
    print(found + [draws_bars(terminal)])
else:
    os.wait()
"""
    environment = os.environ | {"TERM": "xterm"}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=environment, start_new_session=True, capture_output=True, text=True, check=True)
    assert done.stdout == "[True, False]\n"


def test_messages_survive_a_stream_that_cannot_show_them() -> None:
    """LANG=C or a file of another encoding."""
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="ascii", write_through=True)
    TerminalProgress(stream).info("γ* = 1 µm")
    assert raw.getvalue() == b"?* = 1 ?m\n"


def test_a_log_that_cannot_be_written_ends_the_run(capsys: pytest.CaptureFixture[str]) -> None:
    report = TerminalProgress(io.StringIO())
    report.log_to(Path("/dev/full"))
    with pytest.raises(StorageError, match=r"^/dev/full: cannot be written \(No space left on device\); free some"):
        report.info("much")
    with pytest.raises(StorageError):  # the line is still in the buffer
        report.close()
    assert capsys.readouterr().err == ""


def test_a_stopped_stage_is_logged_as_stopped() -> None:
    stream = io.StringIO()
    report = TerminalProgress(stream)
    with pytest.raises(ZeroDivisionError), report.stage("sweep", 0):
        raise ZeroDivisionError
    assert "sweep: stopped in" in stream.getvalue()


@pytest.mark.parametrize(
    ("left", "told"), [(90.0, ", 1 min 30 s left, two run"), (nan, ", two run"), (None, ", 0.0 s left, two run")]
)
def test_a_stage_may_know_better_how_much_time_is_left(
    left: float | None, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = io.StringIO()
    with TerminalProgress(stream).stage("batch", 4, "cases") as stage:
        stage._last -= progress.LINE_SECONDS  # type: ignore[attr-defined]
        stage.update(2, "two run", left)
    assert f"batch: 50% (2 of 4 cases){told}\n" in stream.getvalue()
    bar = io.StringIO()
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    report = TerminalProgress(bar, bars=True)
    with report.stage("batch", 4, "cases") as stage:
        stage.update(2, "two run", left)
        report._bars.refresh()
    assert "two run" in bar.getvalue()
    assert ("1 min 30 s left" in bar.getvalue()) == (left == 90.0)
    assert (" left" in bar.getvalue()) == (left is None or left == 90.0)


def test_time_left_of_a_batch_follows_its_pace(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [1000.0]
    monkeypatch.setattr(batch_progress.time, "time", lambda: clock[0])
    count = BatchProgress(10, begun=1000.0)
    count.add(failed=False)  # done before: no pace
    count.add(failed=True)
    assert isnan(count.left({}))
    clock[0] += 20.0
    count.add(failed=False, started=1000.0)
    assert count.left({}) == 20.0 * 7  # one after the other
    assert count.left({"b": 1010.0}) == pytest.approx(20.0 * 6.5 / 1.5)  # half of a second one is done, side by side
    assert count.left({"b": 0.0}) == pytest.approx(20.0 * 6.1 / 1.9)  # a long one is never counted as done
    for _ in range(7):
        count.add(failed=False, started=1000.0)
    assert count.left({"of another batch": 0.0}) == 0.0  # never below
    assert (count.done, count.failed) == (10, 1)


def test_a_batch_names_what_runs_longest_first() -> None:
    count = BatchProgress(9, failed=2)
    assert count.note({}) == "2 failed"
    assert count.note({"a": 2.0, "b": 1.0}) == "2 failed; running b, a"
    assert BatchProgress(9).note({name: 1.0 * k for k, name in enumerate("abcde")}) == "running a, b, c and 2 more"


def test_no_time_left_is_told_before_a_twentieth_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first steps are not typical: kernels are compiled, contact changes."""
    clock = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    stream = io.StringIO()
    with TerminalProgress(stream).stage("sweep", 1000, "steps") as stage:
        for now, done in ((100.0, 49), (200.0, 50)):
            clock[0] = now
            stage.update(done)
    assert stream.getvalue().splitlines()[1:3] == [
        "sweep: 5% (49 of 1000 steps)",
        "sweep: 5% (50 of 1000 steps), 1 h 03 min left",
    ]


@pytest.mark.parametrize("config", [pytest.param("lab_harmonic", marks=pytest.mark.slow), "lab_backbone"])
def test_adaptive_analyses_show_their_place_and_their_target(config: str) -> None:
    """Every pass covers its range in growing shares, and says which error ends the passes."""
    notes: list[tuple[float, str]] = []

    class Told(SilentProgress):
        @contextmanager
        def stage(self, name: str, total: float, unit: str = "") -> Iterator[Any]:
            yield SimpleNamespace(update=lambda done, note="", left=None: notes.append((done, note)))

    words = ["mesh={circumferential: 8, axial: 3, grading: 1}", "output.figures=false"]
    run_analysis(load_case(CONFIGS / f"{config}.yaml", words), progress=Told())
    shown = [(done, note) for done, note in notes if note.startswith("pass ")]
    first = [done for done, note in shown if note.startswith("pass 1: ")]
    assert len(first) > 5
    assert first == sorted(first)
    assert 0.0 <= first[0] < 0.3 < 0.9 < first[-1] < 1.0
    assert all(" points (until the error is 0.1 %)" in note for _, note in shown)
