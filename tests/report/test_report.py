"""`wroll report`: content of the page about a run or a batch."""

from __future__ import annotations

import base64
import shutil
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr
from support import synthetic_roll
from support.paths import ROOT
from support.report_pages import parsed, rows, section, with_modulation, words

from wroll_fem import load_case
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.run import run_case
from wroll_fem.report import write_report
from wroll_fem.report.damping import damping_table
from wroll_fem.report.ledger import energy_ledger
from wroll_fem.report.run import metrics
from wroll_fem.report.values import quantity
from wroll_fem.results.summary import label
from wroll_fem.signals.estimators import single_dof_transmissibility

# ---- a run -----------------------------------------------------------------------------------------


def test_report_of_a_run_holds_everything(run: RunFolder, tmp_path: Path) -> None:
    root = parsed(write_report(run.path, tmp_path / "new" / "run.html"))
    headings = [h.text for h in root.iter("h2")]
    assert headings == [
        "What was solved", "Warnings", "Metrics", "Figures", "Damping by several methods", "Energy ledger",
        "Versions and provenance", "Files",
    ]  # fmt: skip
    solved = words(section(root, "What was solved"))
    assert "outer diameter of the mandrel80 mmgeometry.mandrel_outer_diameter" in solved
    assert run.case_file.read_text().splitlines()[-1] in solved
    assert "just a remark" in words(section(root, "Warnings"))
    origin = words(section(root, "Versions and provenance"))
    assert "wroll run lab_sweep.yaml" in origin
    assert f"numpy {run.provenance()['versions']['numpy']}" in origin
    assert {p.name for p in run.path.iterdir() if p.is_file()} - {".lock"} <= set(rows(section(root, "Files")))


def test_metrics_are_those_of_the_summary_with_units(run: RunFolder, run_file: Path) -> None:
    found = rows(section(parsed(run_file), "Metrics"))
    assert found["Resonance frequency f_n"] == ["148.25 Hz", "f_n_hz"]
    assert found["Damping ratio zeta"] == ["1.23 %", "zeta"]
    summary = run.summary()
    assert found["Largest accumulated slip"] == [
        quantity(summary["max_accumulated_slip_m"], "m"),
        "max_accumulated_slip_m",
    ]
    named = {cells[-1] for cells in found.values()}
    assert {k for k, v in summary.items() if not isinstance(v, list) and k != "analysis"} <= named
    assert [found[str(k + 1)][0] for k in range(2)] == ["50 kPa", "50 kPa"]  # interfaces


def test_figures_are_the_runs_own_and_complete(run: RunFolder, run_file: Path) -> None:
    root = parsed(run_file)
    shown_pictures = [image.get("src", "") for image in root.iter("img")]
    held = {p.read_bytes() for p in run.figures.glob("*.png")}
    assert {base64.b64decode(src.removeprefix("data:image/png;base64,")) for src in shown_pictures} == held
    assert all(image.get("alt") for image in root.iter("img"))


def test_energy_ledger_adds_up(run_file: Path) -> None:
    found = rows(section(parsed(run_file), "Energy ledger"))
    shares = {name: float(cells[1].removesuffix(" %")) for name, cells in found.items()}
    assert shares.pop("Work put in by the base motion") == 100.0
    assert shares["Energy dissipated by friction"] > 1.0
    assert sum(shares.values()) == pytest.approx(100.0, abs=0.5)  # each has three digits
    data = synthetic_roll.history()
    lost = data.assign(friction_energy=0.5 * data["friction_energy"])  # half of it is nowhere
    found = rows(ElementTree.fromstring(f"<div>{energy_ledger(with_modulation(lost))}</div>"))
    assert found["Balance error"] == found["Energy dissipated by friction"]


def test_damping_is_read_by_every_method() -> None:
    f = np.linspace(130.0, 170.0, 801)
    T = single_dof_transmissibility(f, 150.0, 0.02)
    parts = {"transmissibility_real": ("frequency", T.real), "transmissibility_imag": ("frequency", T.imag)}
    data = xr.Dataset(parts, coords={"frequency": f})
    told = damping_table(data)
    found = rows(ElementTree.fromstring(f"<div>{told}</div>"))
    assert found["half power"][1] == "2.002 %"
    assert found["rational fraction (linear structure)"][:2] == ["150 Hz", "2 %"]
    assert len(found) == 3
    assert "prominence 0.8" in told
    assert damping_table(data.isel(frequency=slice(None, None, -1))) == ""
    assert "no half-power point" in damping_table(data.isel(frequency=slice(0, 405)))


def check_drawn_figures(run: RunFolder, copy: Path) -> None:
    shutil.copytree(run.path, copy)
    shutil.rmtree(copy / "figures")
    root = parsed(write_report(copy))
    assert len(list(root.iter("img"))) == len(list(run.figures.glob("*.png"))) > 0
    assert not (copy / "figures").exists()
    assert (copy / "report.html").is_file()


def test_figures_are_drawn_when_the_run_made_none(tmp_path: Path) -> None:
    case = load_case(ROOT / "configs" / "oscillator.yaml", ["analysis=modal"])
    check_drawn_figures(run_case(case, tmp_path / "run").folder, tmp_path / "copy")


@pytest.mark.slow
def test_all_figures_of_a_sweep_are_drawn_when_the_run_made_none(run: RunFolder, tmp_path: Path) -> None:
    check_drawn_figures(run, tmp_path / "copy")


def test_what_went_wrong_stands_in_the_warnings(run: RunFolder, tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "half")
    folder.path.mkdir()
    shutil.copy(run.case_file, folder.case_file)
    folder.write_json(folder.provenance_file, {"status": "interrupted"})
    folder.log_file.write_text("2026-01-01T00:00:00+00:00 warning: mind the mesh\nx info: fine\n")
    said = words(section(parsed(write_report(folder.path)), "Warnings"))
    for part in ("interrupted", "mind the mesh", "no results"):
        assert part in said
    assert "fine" not in said
    folder.write_json(folder.provenance_file, {"status": "failed", "error": "no such mode; take more"})
    assert "no such mode; take more" in words(section(parsed(write_report(folder.path)), "Warnings"))
    folder.results_file.write_text("no netcdf")
    assert "not a readable NetCDF file" in words(parsed(write_report(folder.path)))


def test_doubtful_numbers_are_warned_of(run: RunFolder, tmp_path: Path) -> None:
    copy = RunFolder(tmp_path / "copy")
    shutil.copytree(run.path, copy.path)
    copy.write_json(
        copy.summary_file, {**run.summary(), "energy_balance_error": 0.02, "step_cuts": 7, "steady_drift": 0.1}
    )
    said = words(section(parsed(write_report(copy.path)), "Warnings"))
    for part in ("balance error is 2.00%", "7 time steps were cut", "not steady: it still changes by 10.0%"):
        assert part in said


def test_energies_of_a_family_of_curves_are_taken_at_each_peak() -> None:
    frequency, capacity = np.linspace(0.5, 1.5, 5), np.array([1.0, 2.0])
    peaks = np.array([[1.0, 4.0, 2.0, 1.0, 1.0], [1.0, 1.0, 2.0, 9.0, 1.0]])  # at the second and fourth frequency
    given = np.array([[1.0, 8.0, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 4.0, 1.0]])
    dims = ("friction_capacity", "omega")
    data = xr.Dataset(
        {
            "transmissibility": (dims, peaks),
            "input_work_per_cycle": (dims, given),
            "friction_work_per_cycle": (dims, np.where(peaks > 2.0, 0.75 * given, np.nan)),
            "viscous_work_primary": (dims, np.where(peaks > 2.0, 0.25 * given - 0.2, np.nan)),
        },
        coords={"friction_capacity": capacity, "omega": frequency},
    )
    found = rows(ElementTree.fromstring(f"<div>{energy_ledger(data)}</div>"))
    assert found == {"1": ["8", "75 %", "22.5 %", "2.5 %"], "2": ["4", "75 %", "20 %", "5 %"]}


def test_lists_of_one_length_share_a_table() -> None:
    shown_tables = metrics({"amplitude_g": [1.0, 5.0], "slip_zone_height_m": [0.0065, 0.022], "other": [1, 2, 3]})
    tables = list(ElementTree.fromstring(f"<div>{shown_tables}</div>").iter("table"))
    assert [words(t if (head := t.find("thead")) is None else head) for t in tables] == [
        "numberBase acceleration (0-peak)Slip zone height", "numberOther",
    ]  # fmt: skip
    assert rows(tables[0]) == {"1": ["1 g", "6.5 mm"], "2": ["5 g", "22 mm"]}


@pytest.mark.parametrize(
    ("file", "overrides", "parts"),
    [
        (
            "two_dof.yaml",
            ["two_dof.omega.points=8", "two_dof.friction_capacity=[3, 10]"],
            {"Figures", "Energy ledger"},
        ),
        ("winding_lab.yaml", [], {"Figures"}),
        ("oscillator.yaml", ["analysis=modal"], {"Figures"}),
        ("oscillator.yaml", ["analysis=preload"], set()),  # one point: no map
    ],
)
def test_other_analyses_are_reported(file: str, overrides: list[str], parts: set[str], tmp_path: Path) -> None:
    run_case(load_case(ROOT / "configs" / file, overrides), tmp_path / "run")
    root = parsed(write_report(tmp_path / "run"))
    always = {"What was solved", "Warnings", "Metrics", "Versions and provenance", "Files"}
    assert {h.text for h in root.iter("h2")} == always | parts
    for name, cells in rows(section(root, "Metrics")).items():
        assert name
        assert all(cells), name
    plain_names = {label(p.stem) for p in (tmp_path / "run" / "figures").glob("*.png")}
    assert not {image.get("alt") for image in root.iter("img")} & plain_names  # every figure has a caption of its own


# ---- a batch ---------------------------------------------------------------------------------------


def test_report_of_a_batch_tells_what_varies_and_what_failed(batch: Path, tmp_path: Path) -> None:
    root = parsed(write_report(batch, tmp_path / "b.html"))
    solved = words(section(root, "What was solved"))
    assert "preload.pressure3 values: 10000, 30000, 100000" in solved
    assert "analysis2" not in solved  # the failed case has none in the table
    assert "mesh.axial = 12" in solved
    warned = words(section(root, "Warnings"))
    assert "pressure_100000 failed: no convergence <script>" in warned
    assert "2 cases, at worst pressure_30000: the energy balance error is 3.00%" in warned
    assert "2 cases, first pressure_10000: the root element is 10 mm high" in warned
    cases = rows(section(root, "Cases"))
    assert cases["pressure_10000"][:3] == ["complete", "10000", "148.25 Hz"]
    assert cases["pressure_100000"][:3] == ["failed", "100000", ""]
    assert len(list(root.iter("img"))) == 1
    ledger = rows(section(root, "Energy ledger"))
    assert set(ledger) == {"pressure_10000", "pressure_30000"}
    assert ledger["pressure_10000"][1].endswith("%")
    everything = words(section(root, "All metrics"))
    assert "f_n_hz" in everything
    assert "148.25" in everything
