"""Wrong files and settings of shear, friction and tension: one line, exit code 2, and the remedy."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import wroll_fem as wf
from wroll_fem.cli import app
from wroll_fem.errors import InputError
from wroll_fem.lab.shear.kind import write_csv
from wroll_fem.lab.shear.simulated import ramp, sine_loops, velocity_steps
from wroll_fem.tribology import RateAndState, ShearTest

TEST = ShearTest(interfaces=1, normal_force=100.0)
UNITS = {"units.displacement": "um", "units.force": "N"}


def constant(speed: np.ndarray) -> np.ndarray:
    return 0.25 + 0.0 * speed


@pytest.fixture
def files(tmp_path: Path) -> dict[str, str]:
    records = {"ramp": ramp(TEST), "short": ramp(TEST).part(0, 500), "loops": sine_loops(constant)}
    records["steps"] = velocity_steps(RateAndState())
    return {name: str(write_csv(tmp_path / f"{name}.csv", record)) for name, record in records.items()}


def spoiled(path: str, line: int, text: str) -> str:
    """Copy of a file with one line replaced."""
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    lines[line] = text
    other = Path(path).with_name(f"spoiled_{line}.csv")
    other.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(other)


def message(kind: str, paths: list[str], **settings: object) -> str:
    with pytest.raises(InputError) as caught:
        wf.lab.evaluate(kind, paths, **settings)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_columns_and_units(files: dict[str, str]) -> None:
    one = [files["ramp"]]
    cases = {
        "columns.force: no column 'Force_N'; did you mean 'force'?": {**UNITS, "columns.force": "Force_N"},
        "columns.time: column 4 of 3; count from 1": {**UNITS, "columns.time": 4},
        "units: required section is missing; add it": {},
        "units.force: required key is missing; add it (unit of the force": {"units.displacement": "um"},
        "units.force: must be a force, not": {**UNITS, "units.force": "mm"},
        "units.displacement: unknown unit 'furlongg'": {**UNITS, "units.displacement": "furlongg"},
        "normal_force: 2 values for 1 files; give one number, or one per file": {**UNITS, "normal_force": [1.0, 2.0]},
        "profile: 2 values for 1 files": {**UNITS, "profile": ["ramp", "ramp"]},
        "normal_force and columns.normal_force are both given": {
            **UNITS, "normal_force": 1.0, "columns.normal_force": "force"
        },
        "window: [0.8, 0.2] is no window": {**UNITS, "window": [0.8, 0.2]},
        "rigid and fixture_stiffness are both given": {**UNITS, "rigid": files["ramp"], "fixture_stiffness": 1e7},
    }  # fmt: skip
    for expected, settings in cases.items():
        assert expected in message("shear", one, **settings), expected


def test_values_and_times(files: dict[str, str]) -> None:
    assert "column force: sample 5 is nan (1 such)" in message(
        "shear", [spoiled(files["ramp"], 5, "0.3,1,nan")], **UNITS
    )
    assert "time does not rise: sample 6 is at 0 s" in message("shear", [spoiled(files["ramp"], 6, "0,1,2")], **UNITS)
    assert "line 8 has 2 columns" in message("shear", [spoiled(files["ramp"], 7, "0,1")], **UNITS)


def changed(path: str, column: str, change: Callable[[np.ndarray], np.ndarray]) -> str:
    """Copy of a file with one column changed."""
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    at = lines[0].split(",").index(column)
    table = np.array([line.split(",") for line in lines[1:]], dtype=float)
    table[:, at] = change(table[:, at])
    other = Path(path).with_name(f"changed_{column}.csv")
    np.savetxt(other, table, "%.10g", ",", header=lines[0], comments="")
    return str(other)


def test_gaps_absurd_numbers_and_columns_that_stand_still(files: dict[str, str]) -> None:
    one = files["ramp"]
    gap = changed(one, "time", lambda t: t + 20.0 * (np.arange(len(t)) >= 300))
    assert "gap of 20.07 s after" in message("shear", [gap], **UNITS)
    assert "fill the gap, or cut the record there" in message("shear", [gap], **UNITS)
    huge = changed(one, "force", lambda force: 1e20 * force)
    assert "units.force: the largest value is" in message("shear", [huge], **UNITS)
    tiny = changed(one, "displacement", lambda x: 1e-20 * x)
    assert "units.displacement: the largest value is" in message("shear", [tiny], **UNITS)
    still = changed(one, "displacement", np.zeros_like)
    assert "the displacement stands still while the force changes" in message("shear", [still], **UNITS)


def test_a_test_whose_steps_change_with_its_rate_has_no_gap(files: dict[str, str]) -> None:
    found = wf.lab.evaluate("shear", [files["steps"]], normal_force=200.0, **UNITS)
    assert len(found.summary["slip_rates_m_s"]) == 6


def test_a_clipped_force_or_tension_is_a_warning(files: dict[str, str], tmp_path: Path) -> None:
    cut = changed(files["loops"], "force", lambda force: np.clip(force, -90.0, 90.0))
    found = wf.lab.evaluate("shear", [cut], normal_force=200.0, **UNITS)
    assert any("extreme value 90: the record may be clipped" in text for text in found.warnings)
    tension = np.minimum(40.0 + np.random.default_rng(1).standard_normal(200), 39.5)
    path = tmp_path / "t.csv"
    np.savetxt(path, np.column_stack([np.arange(200.0), tension]), delimiter=",", header="time,tension", comments="")
    told = wf.lab.evaluate("tension", [path], **{"units.tension": "N", "voltage": 6.0, "current": 0.5}).warnings
    assert any("extreme value 39.5" in text for text in told)


def test_records_that_are_not_what_they_should_be(files: dict[str, str]) -> None:
    assert "no slip is reached: the force never falls by 1 N" in message("shear", [files["short"]], **UNITS)
    free = wf.lab.evaluate("shear", [files["short"]], event_rule="none", **UNITS)
    assert free.summary["shear_stiffness_n_per_m"] == [pytest.approx(TEST.stiffness, rel=1e-4)]
    assert "shear_capacity_n" not in free.summary
    assert "no complete cycle" in message("shear", [files["ramp"]], profile="loops", **UNITS)
    many = message("shear", [files["loops"]], skip_cycles=9, **UNITS)
    assert "skip_cycles: 6 complete cycles, of which skip_cycles leaves out 9" in many
    assert "the normal force is missing; add it" in message("shear", [files["steps"]], **UNITS)


def test_fits_that_the_records_do_not_allow(files: dict[str, str]) -> None:
    known = {**UNITS, "normal_force": 200.0}
    assert "fits: state needs a record with velocity steps" in message(
        "friction", [files["ramp"]], fits=["state"], **known
    )
    assert "the records allow no fit" in message("friction", [files["ramp"]], **known)
    few = message("friction", [files["ramp"], files["steps"]], fits=["elastic_slip"], **known)
    assert "fits: elastic_slip needs two ramps" in few
    found = wf.lab.evaluate("friction", [files["steps"]], **known)
    assert any("friction.yaml is not written, because the elastic slip is unknown" in w for w in found.warnings)
    assert not found.texts
    given = wf.lab.evaluate("friction", [files["steps"]], elastic_slip=2e-6, **known)
    assert "elastic_slip: 2.0e-06" in given.texts["friction.yaml"]
    table = message(
        "friction", [files["steps"]], rate_model="table", knots=[1e-6, 0.5], elastic_slip=1e-6, fits=["rate"], **known
    )
    assert "knots: no test near the rate 0.5 m/s" in table


def test_tension(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rng = np.random.default_rng(1)
    rows = np.column_stack([np.arange(100.0), 40.0 + rng.standard_normal(100)])
    np.savetxt(path, rows, delimiter=",", header="time,tension", comments="")
    settings = {"units.tension": "N", "voltage": 6.0, "current": 0.5}
    cases = {
        "units: required section is missing; add it": {"voltage": 6.0, "current": 0.5},
        "voltage: is missing; give voltage, one number or one per file, or columns.voltage": {
            "units.tension": "N", "current": 0.5
        },
        "current: 2 values for 1 files": {**settings, "current": [0.5, 1.0]},
        "columns.tension: no column 'tensoin'; did you mean 'tension'?": {**settings, "columns.tension": "tensoin"},
        "uncertain needs a case file": {**settings, "uncertain": {"winding.web_width": 0.1}},
        "file not found": {**settings, "case": str(tmp_path / "none.yaml")},
    }  # fmt: skip
    for expected, given in cases.items():
        assert expected in message("tension", [str(path)], **given), expected
    found = wf.lab.evaluate("tension", [path], **settings)
    assert any("one trial at 6 V and 0.5 A" in text for text in found.warnings)
    assert found.texts["tension.csv"].splitlines()[1] == "V,A,1,N,N,N,N,N"


def test_measured_voltage_and_current_are_read_with_their_units(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    rng = np.random.default_rng(1)
    current = 500.0 + 60.0 * np.sign(rng.standard_normal(200))
    np.savez(path, time=np.arange(200.0), tension=40.0 + rng.standard_normal(200), u=np.full(200, 6.0), i=current)
    found = wf.lab.evaluate(
        "tension",
        [path],
        **{"units.tension": "N", "units.current": "mA", "columns.voltage": "u", "columns.current": "i"},
    )
    assert found.summary["voltages_v"] == [6.0]
    assert found.summary["currents_ampere"] == [pytest.approx(0.5, rel=0.02)]
    assert any("the current is not constant" in text for text in found.warnings)


def test_the_command_prints_one_line(files: dict[str, str], tmp_path: Path) -> None:
    words = [
        "lab",
        "shear",
        files["short"],
        "--set",
        "units={displacement: um, force: N}",
        "--out",
        str(tmp_path / "out"),
    ]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 2
    assert "no slip is reached" in done.output
    assert "Traceback" not in done.output
