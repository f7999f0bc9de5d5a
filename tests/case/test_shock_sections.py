"""Case section `excitation` of shocks: what is accepted, and one line for what is not."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.errors import InputError

SHOCK = CONFIGS / "lab_shock.yaml"


def record(folder: Path, text: str = "") -> Path:
    path = folder / "base.csv"
    rows = text or "time,base,tip\n" + "".join(f"{0.001 * k:.3f},{k % 7 - 3},0.5\n" for k in range(40))
    path.write_text(rows)
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("excitation.kind=sine", "analysis shock needs a half_sine or sawtooth"),
        ("excitation.decay=-1", "excitation.decay: must be a number above zero, got -1"),
        ("excitation.highest_frequency=fast", "excitation.highest_frequency: must be a number"),
        ("excitation.q=0.5", "excitation.q: "),
        ("excitation.amplitude=3", "the amplitude is given twice"),
        ("excitation={kind: half_sine, duration: 1}", "excitation.amplitude: required key is missing"),
        (
            "excitation={kind: trapezoid, amplitude: 1, duration: 1, rise: 0.8, fall: 0.3}",
            "rise and fall take 1.1 times",
        ),
        ("excitation={kind: srs, srs: {frequency: [10, 100], acceleration_g: [1]}}", "2 frequencies and 1 accel"),
        ("excitation={kind: srs, srs: {frequency: [10, 9], acceleration_g: [1, 1]}}", "does not ascend"),
        ("excitation={kind: srs, srs: {frequency: [10, 100, 900], acceleration_g: [1, 90, .1]}}", "no shock has this"),
        ("excitation={kind: file, file: missing.csv, unit: g}", "excitation.file: file not found"),
        ("excitation={kind: file, file: 3, unit: g}", "must be the path of a record"),
    ],
)
def test_wrong_shock_is_refused_in_one_line(change, message):
    with pytest.raises(InputError) as error:
        wf.load_case(SHOCK, [change])
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("unit: gal, column: base", "excitation.unit: unknown unit 'gal'"),
        ("unit: g, column: bse", "excitation.column: no column 'bse'"),
        ("unit: g", "excitation.column: 2 columns besides the time"),
        ("unit: g, column: base, time: clock", "excitation.time: no column 'clock'"),
        ("unit: g, column: base, low_pass: 600", "excitation.low_pass: low_pass = 600 Hz"),
        ("unit: g, column: base, baseline: mean", "excitation.baseline"),
        ("unit: g, column: base, scale: 0", "must be a number other than zero"),
        ("unit: g, column: 1.5", "excitation.column: must be a name, or a place"),
        ("column: base", "excitation.unit: required key is missing"),
    ],
)
def test_wrong_record_is_refused_in_one_line(tmp_path, options, message):
    with pytest.raises(InputError) as error:
        wf.load_case(SHOCK, [f"excitation={{kind: file, file: {record(tmp_path)}, {options}}}"])
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_record_is_found_beside_the_case_file_and_enters_the_hash(tmp_path):
    path = record(tmp_path)
    text = SHOCK.read_text(encoding="utf-8").splitlines()
    text = [line for line in text if not line.startswith("excitation:")]
    case_file = tmp_path / "case.yaml"
    case_file.write_text("\n".join([*text, "excitation: {kind: file, file: base.csv, unit: m/s^2, column: 2}"]))
    case = wf.load_case(case_file)
    assert case.excitation.file == path.resolve()
    assert case.excitation.highest_frequency_hz > 100.0
    assert wf.Case.model_validate(case.resolved()) == case
    before = case.hash()
    record(tmp_path, path.read_text().replace("0.005,2,", "0.005,1,"))
    assert wf.load_case(case_file).hash() != before


def test_shocks_are_made_in_python_and_round_trip():
    for excitation in (
        wf.HalfSine(amplitude_g=20, duration=0.011),
        wf.Sawtooth(amplitude=100.0, duration=0.011, decay=0.3),
        wf.Trapezoid(amplitude=100.0, duration=0.011, rise=0.2, fall=0.2, direction="y"),
        wf.ShockSpectrum(srs={"frequency": [20, 200], "acceleration_g": [5, 20]}, seed=2),
    ):
        case = wf.load_case(SHOCK).replace({"excitation": excitation.model_dump(exclude_none=True)})
        assert wf.Case.model_validate(case.resolved()) == case
        assert case.excitation.attributes["amplitude_m_s2"] > 0.0
