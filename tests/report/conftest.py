"""Folders of a run and of a batch, with a synthetic roll's results."""

from __future__ import annotations

import pickle
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
import xarray as xr
from support.report_pages import NASTY, SWEEP, synthetic_run

from wroll_fem import load_case
from wroll_fem.jobs.batch import Outcome, write_tables
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.grid import Member
from wroll_fem.report import run as run_report
from wroll_fem.report import write_report
from wroll_fem.report.damping import damping_table
from wroll_fem.report.html import Markup

DAMPING: dict[bytes, Markup] = {}
"""Curve -> table of its damping estimates. Most pages show the same curve, and its table takes a second."""


def known_damping_table(dataset: xr.Dataset) -> Markup:
    names = [name for name in ("frequency", "transmissibility_real", "transmissibility_imag") if name in dataset]
    parts = [(name, dataset[name].dims, dataset[name].values) for name in names]
    key = pickle.dumps((parts, dataset.attrs.get("zeta_method")))
    if key not in DAMPING:
        DAMPING[key] = damping_table(dataset)
    return DAMPING[key]


@pytest.fixture(scope="module", autouse=True)
def one_damping_table() -> Iterator[None]:
    """Estimate the damping of each curve once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run_report, "damping_table", known_damping_table)
        yield


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    return synthetic_run(tmp_path_factory.mktemp("report") / "a run")


@pytest.fixture(scope="session")
def batch(run: RunFolder, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a batch: two finished cases, one that failed, one figure."""
    out = tmp_path_factory.mktemp("batch")
    outcomes = []
    for pressure in (1.0e4, 3.0e4, 1.0e5):
        name, override = f"pressure_{pressure:.0f}", f"preload.pressure={pressure}"
        case = load_case(SWEEP, [override])
        member = Member(name, SWEEP, {"preload.pressure": pressure, "mesh.axial": 12}, [override], case)
        if pressure == 1.0e5:
            outcomes.append(Outcome(member, "failed", f"no convergence {NASTY[:-2]}", 3))
            continue
        shutil.copytree(run.path, out / name)
        (out / name / "case.yaml").write_text(case.resolved_yaml())
        folder = RunFolder(out / name)
        folder.log_file.write_text(f"now warning: the root element is {pressure / 1e3:g} mm high\n")
        folder.write_json(folder.summary_file, {**run.summary(), "energy_balance_error": pressure * 1e-6})
        outcomes.append(Outcome(member, "complete"))
    write_tables(outcomes, out)
    (out / "figures").mkdir()
    shutil.copy(run.figures / "transmissibility.png", out / "figures" / "damping_over_frequency.png")
    return out


@pytest.fixture(scope="session")
def run_file(run: RunFolder, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Report of the run."""
    return write_report(run.path, tmp_path_factory.mktemp("run_file") / "r.html")


@pytest.fixture(scope="session")
def batch_file(batch: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Report of the batch."""
    return write_report(batch, tmp_path_factory.mktemp("batch_file") / "r.html")
