"""Plugin of pytest: which functions of the package each test calls, and how long it takes.

    WROLL_REACH=/tmp/reach PYTHONPATH=.:tests python -m pytest -p tests.fuzz.reach -m "not slow" tests/signals

Every process writes one JSON file into the folder ``WROLL_REACH``: test -> [seconds, passed, functions]. A function is
"file:qualified name". Compiled functions are not seen (mutants.py finds the callers of their names). Tests that
a file of the folder contains already are left out, so that a run can be interrupted and continued.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Generator
from pathlib import Path
from types import CodeType, FrameType

import pytest

PACKAGE = str(Path(__file__).resolve().parents[2] / "wroll_fem") + os.sep

_seen: set[CodeType] = set()
_found: dict[str, list] = {}
_shared: dict[str, set[str]] = {}
"""Functions called by the fixtures of a file, which later tests of this file use without calling them."""


def _trace(frame: FrameType, event: str, argument: object) -> None:
    _seen.add(frame.f_code)


def _names() -> set[str]:
    inside = (code for code in tuple(_seen) if code.co_filename.startswith(PACKAGE))
    return {f"wroll_fem/{code.co_filename[len(PACKAGE) :]}:{code.co_qualname}" for code in inside}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    known = {name for path in _folder().glob("*.json") for name in json.loads(path.read_text())}
    items[:] = [item for item in items if item.nodeid not in known]


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None]:
    _seen.clear()
    _found[item.nodeid] = [0.0, True, []]
    start = time.process_time()
    threading.settrace(_trace)  # type: ignore[arg-type]
    sys.settrace(_trace)  # type: ignore[arg-type]
    yield
    sys.settrace(None)
    threading.settrace(None)  # type: ignore[arg-type]
    _found[item.nodeid][0] = round(time.process_time() - start, 3)
    _found[item.nodeid][2] = sorted(_names() | _shared.get(str(item.path), set()))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None]:
    yield
    _shared.setdefault(str(item.path), set()).update(_names())


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if report.outcome != "passed" and report.nodeid in _found:
        _found[report.nodeid][1] = False


def pytest_runtest_logfinish() -> None:
    if len(_found) % 20 == 0:
        _write()


def pytest_sessionfinish() -> None:
    _write()


def _folder() -> Path:
    return Path(os.environ["WROLL_REACH"])


def _write() -> None:
    _folder().mkdir(parents=True, exist_ok=True)
    unfinished = _folder() / f"{os.getpid()}.part"
    unfinished.write_text(json.dumps(_found, indent=0))
    unfinished.replace(unfinished.with_suffix(".json"))
