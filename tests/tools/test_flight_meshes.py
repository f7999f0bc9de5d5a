"""The table of flight meshes tells what moves, what is beyond the limits, and what has no curve."""

from __future__ import annotations

import importlib
import json
from pathlib import Path

import pytest

from wroll_fem.case.loader import load_case
from wroll_fem.case.roll import RollSections


@pytest.fixture(scope="module")
def meshes(root: Path):
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(root / "benchmarks"))
        return importlib.import_module("flight_meshes")


def report(factor: int, **changes: object) -> dict:
    found = {
        "roll": "irosa", "base": "free", "pressure": 2e5, "factor": factor, "cause": "", "f_n_hz": 75.0,
        "peak_transmissibility": 10.0, "zeta_apparent": 0.12, "zeta_quality": "ok", "cpu_s": 20.0 * factor,
        "memory_mb": 1024.0 * factor,
    }  # fmt: skip
    return found | changes


def test_a_row_has_the_changes_and_what_the_finer_mesh_costs(meshes) -> None:
    line = meshes.row(report(1), report(2, f_n_hz=75.3, peak_transmissibility=9.6, zeta_apparent=0.1254))
    assert line == "| iROSA | free | 200 | 75.00 | 10.00 | 12.00 | +0.40 | -4.00 | +4.50 | yes | 40 | 2.0 |"


@pytest.mark.parametrize("reading", ["f_n_hz", "peak_transmissibility", "zeta_apparent"])
def test_one_reading_beyond_its_limit_is_told(meshes, reading: str) -> None:
    own = report(1)
    beyond = report(2, **{reading: own[reading] * (1.0 - 1.01e-2 * meshes.LIMITS[reading])})
    assert "| no |" in meshes.row(own, beyond)
    assert "| yes |" in meshes.row(own, report(2, **{reading: own[reading] * (1.0 - 0.99e-2 * meshes.LIMITS[reading])}))


def test_a_run_without_a_curve_and_a_doubtful_damping_are_told(meshes) -> None:
    assert "no curve on the finer mesh" in meshes.row(report(1), report(2, cause="rattles"))
    assert "no curve on both meshes" in meshes.row(report(1, cause="rattles"), report(2, cause="rattles"))
    assert "12.00 (doubtful)" in meshes.row(report(1, zeta_quality="doubtful"), report(2))


def test_the_page_has_the_pairs_of_the_reports(meshes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pairs = [report(1), report(2), report(1, roll="habex", pressure=1e5)]  # HabEx: no finer mesh yet
    (tmp_path / "FILE").write_text("".join(json.dumps(line) + "\n" for line in pairs), encoding="utf-8")
    words = ["flight_meshes.py", "--page", str(tmp_path / "page.md"), "--read", str(tmp_path / "FILE")]
    monkeypatch.setattr("sys.argv", words)
    meshes.main()
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert text.count("| iROSA |") == 1
    assert "HabEx" not in text
    assert "at most 20 s of CPU and 1.0 GB" in text


def test_the_finer_mesh_has_twice_as_many_elements_in_every_direction(meshes) -> None:
    path = meshes.CONFIGS / "habex_friction.yaml"
    own = load_case(path).expect(RollSections).mesh
    fine = load_case(path, meshes.overrides("habex", "inner_edge", 2e5, 2)).expect(RollSections)
    assert (fine.mesh.circumferential, fine.mesh.axial) == (2 * own.circumferential, 2 * own.axial)
    assert fine.mesh.radial == 2 * own.radial
    assert fine.coil.base == "inner_edge"
