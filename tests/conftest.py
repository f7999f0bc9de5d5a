"""Settings of every test: one thread per process, no window."""

from __future__ import annotations

import gc
import os

from support.paths import ROOT

os.environ["OMP_NUM_THREADS"] = "1"
os.environ["MPLBACKEND"] = "Agg"

import wroll_fem  # isort: skip  (before numpy: it selects the kernels of OpenBLAS)

import sys
from collections.abc import Callable, Generator, Iterator
from pathlib import Path

import pytest
from support.fake_analyses import FakeAnalyses
from support.quick_figures import quick_figures
from typer.testing import CliRunner, Result

from wroll_fem import cli
from wroll_fem.dynamics.reduction.kept_structure import keeping_structure

gc.set_threshold(50_000, 20, 20)
"""A tenth of the time of the suite went into looks for garbage among the objects of pytest and of libraries."""

ROLLS = 20
"""Number of rolls whose bodies a process keeps."""

LONGEST = ("pages", "jobs", "results")
"""Folders with tests of more than ten seconds each."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the longest tests, so that no process of pytest-xdist ends with one while the others wait."""
    items.sort(key=lambda item: item.path.parent.name not in LONGEST)


def pytest_collection_finish() -> None:
    """Leave what is there before the first test out of later looks for garbage."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, bool | None, bool | None]:
    """Figures are arranged and drawn in full in the tests of figures; elsewhere they have few pixels."""
    if "plotting" in item.path.parts:
        return (yield)
    with quick_figures():
        return (yield)


@pytest.fixture(scope="session", autouse=True)
def _bodies_of_recent_rolls() -> Iterator[None]:
    """Many tests run the same small rolls: their bodies are assembled once per process."""
    with keeping_structure(ROLLS, bodies_alone=True):
        yield


@pytest.fixture(scope="session")
def root() -> Path:
    """Folder of the checkout."""
    return ROOT


@pytest.fixture
def analyses(monkeypatch: pytest.MonkeyPatch) -> FakeAnalyses:
    module = FakeAnalyses()
    monkeypatch.setitem(sys.modules, "wroll_fem.analyses", module)
    monkeypatch.setattr(wroll_fem, "analyses", module, raising=False)
    return module


@pytest.fixture
def wroll(analyses: FakeAnalyses, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()

    def call(*words: object) -> Result:
        return runner.invoke(cli.app, [str(word) for word in words])

    return call


@pytest.fixture
def evidence(tmp_path):
    """Evidence for the judges of `wroll reproduce`, nothing kept yet."""
    from reproduction import Evidence

    return Evidence(tmp_path, workers=1)
