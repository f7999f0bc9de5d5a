"""The suite runs wherever pytest does: started by `pytest`, under load, and in a terminal that cannot draw."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest
from support.paths import ROOT

LEAST_WAIT = 60.0
"""s: a shorter limit fails on a loaded machine; limits are there for what would hang for ever."""


def pytest_of(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """`pytest` as a command, outside of the folder's own `python -m pytest`."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "COLUMNS", "FORCE_COLOR")}
    command = [str(Path(sys.executable).with_name("pytest")), "-q", "-p", "no:cacheprovider", *words]
    if not Path(command[0]).is_file():
        pytest.skip("pytest is not installed as a command beside this Python")
    return subprocess.run(command, cwd=ROOT, env=kept | environment, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def started() -> subprocess.CompletedProcess[str]:
    """Files with imports from `support` and `tests` are collected; two tests of them run in a dumb terminal."""
    files = [path for path in (ROOT / "tests").rglob("test_*.py") if "\nfrom tests." in path.read_text()]
    some = sorted(map(str, files)) or [str(ROOT / "tests" / "results" / "test_atomic.py")]
    some += [str(ROOT / "tests" / "winding" / "test_winding.py"), "tests/test_progress.py"]
    return pytest_of(*some, "-k", "time_is_left or bar_and_nested", TERM="dumb")


def test_every_import_of_the_suite_is_found_without_python_m(started: subprocess.CompletedProcess[str]) -> None:
    """`pytest` does not put the working folder on the path; the settings do, for `support` and for `tests`."""
    assert started.returncode in (0, 1), started.stdout + started.stderr  # 2: a file could not be collected
    assert "ERROR" not in started.stdout


def test_progress_is_tested_in_a_terminal_that_cannot_draw_too(started: subprocess.CompletedProcess[str]) -> None:
    """Emacs and many CI logs have TERM=dumb, where rich draws no bar."""
    assert started.returncode == 0, started.stdout + started.stderr


def test_no_test_gives_up_within_a_minute() -> None:
    """A limit of seconds measures the load of the machine; tests wait for events."""
    waits = []
    for path in (ROOT / "tests").rglob("test_*.py"):
        text = path.read_text()
        nodes = ast.walk(ast.parse(text)) if "timeout=" in text else ()
        found = [node.value for node in nodes if isinstance(node, ast.keyword) and node.arg == "timeout"]
        waits += [(path.name, value.value) for value in found if isinstance(value, ast.Constant)]
    assert waits
    assert not [(name, seconds) for name, seconds in waits if 0.0 < float(seconds) < LEAST_WAIT]


def test_no_test_judges_a_speed_by_the_clock() -> None:
    """A loaded machine takes any time; CPU seconds are those of the program."""
    clocks = ("monotonic() - ", "perf_counter() - ", "time.time() - ")
    files = [path for path in (ROOT / "tests").rglob("test_*.py") if path.name != "test_suite_settings.py"]
    assert not [path.name for path in files if any(clock in path.read_text() for clock in clocks)]
