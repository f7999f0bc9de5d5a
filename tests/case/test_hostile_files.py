"""Hostile and odd case files: each is refused in one line with a remedy, or read as YAML 1.2 reads it."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support.paths import CONFIGS
from typer.testing import CliRunner, Result

from wroll_fem import cli, load_case
from wroll_fem.analyses import case_warnings
from wroll_fem.case import Case
from wroll_fem.case.strict_yaml import MOST_CHARACTERS, dump_yaml, parse_yaml
from wroll_fem.errors import InputError

TINY = CONFIGS / "tiny.yaml"


def wroll(*words: object) -> Result:
    return CliRunner().invoke(cli.app, [str(word) for word in words])


def refused(done: Result) -> str:
    """The one line of a command that refuses its input."""
    assert isinstance(done.exception, SystemExit), done.exception
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1), done.output
    return done.stderr


def dry(text: str) -> Result:
    return wroll("run", TINY, "--dry-run", "--set", f"preload.pressure={text}")


def validated(path: Path, text: str) -> Result:
    path.write_text(text, encoding="utf-8", errors="surrogatepass")
    return wroll("validate", path)


# ---- numbers ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [("0150", 150), ("+7", 7), ("-0010", -10), ("0o17", 15), ("0x1F", 31), ("1e3", 1e3), ("1.e-3", 1e-3), (".5", 0.5),
     ("-1E+2", -100.0), ("0.0", 0.0), ("00", 0), ("true", True), ("~", None), ("", None)],
)  # fmt: skip
def test_scalars_are_read_as_yaml_1_2_reads_them(text: str, value: Any) -> None:
    found = parse_yaml(text, "here")
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    "text",
    ["2:30", "1_000", "１５０", "2001-12-14", "2001-99-99", "0b11", "0b_", "0x_", "1e", "0.5.1", "+", ".", "12e03x"],
)
def test_what_yaml_1_2_reads_as_text_is_no_number(text: str) -> None:
    assert parse_yaml(text, "here") == text
    line = refused(dry(text))
    assert "preload.pressure: " in line
    assert "; " in line


@pytest.mark.parametrize(
    "text", ["0150", "1e3", "2:30", "yes", "~", "0o17", "1.5", "<<", "2001-12-14", "x: y", "!a", "é"]
)
def test_a_text_that_looks_like_a_number_is_written_so_that_it_stays_one(text: str) -> None:
    """case.yaml of a run is read again: a probe may be called 1e3."""
    assert parse_yaml(dump_yaml({"name": text}, default_flow_style=None), "here") == {"name": text}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("!!binary MTUw", "the tag !!binary is not used here; write the plain value"),
        ("!!timestamp x", "the tag !!timestamp is not used here"),
        ("!!set {a}", "the tag !!set is not used here"),
        ("!!python/object:os.system x", "the tag !!python/object:os.system is not used here"),
        ("!own 3", "the tag !own is not used here"),
        ("!!int abc", "not a whole number"),
        ("!!float x", "not a number"),
        ("!!bool maybe", "neither true nor false; write true or false"),
        ("9" * 5000, "a number of 5000 digits"),
        ('"\\uD83D"', "a text contains a control character; write printable characters"),
        ('"\\0"', "a text contains a control character"),
        ("[" * 3000, "more than 40 levels of sections; close brackets, or indent less"),
        ("&a [*a]", "an alias refers to the section around it; write the value itself"),
    ],
)
def test_a_fault_of_a_scalar_is_one_line(text: str, told: str) -> None:
    assert told in refused(dry(text))


@pytest.mark.parametrize("text", ["9" * 400, "1e31", "-1e300", "5e-324", "1e-31", "1e40 GPa"])
def test_numbers_beyond_all_quantities_are_refused(text: str) -> None:
    """Products of them overflow or vanish somewhere in the forecasts."""
    line = refused(dry(text))
    assert "preload.pressure: is beyond all quantities of a roll, got " in line
    assert line.endswith("; write 0, or a number between 1e-06 and 1e+18 in Pa\n")
    other = refused(wroll("run", TINY, "--dry-run", "--set", f"contact.friction.mu={text.split()[0]}"))
    assert other.endswith("; write 0, or a number between 1e-30 and 1e+30 in SI units\n")


ROLLS = ["tiny", "sspp_friction", "slipping_coil", "design_map", "lab_random"]


@pytest.mark.parametrize("name", [*ROLLS, pytest.param("winding_sweep", marks=pytest.mark.slow)])
def test_extreme_numbers_are_refused_or_have_a_forecast(name: str) -> None:
    """Ends of the ranges, and a tube that is only a ring: divisions by zero and singular matrices in forecasts."""
    keys = ["length", "mandrel_thickness", "mandrel_outer_diameter"]
    sections = [f"geometry.{key}" for key in keys] + ["mandrel.material.E", "coil.material.E", "coil.total_thickness"]
    outcomes = []
    for key in sections:
        for value in ("1e-15", "1 mm", "1 km", "1e18"):
            try:
                case_warnings(load_case(CONFIGS / f"{name}.yaml", [f"{key}={value}"]))
                outcomes.append("valid")
            except InputError as error:
                outcomes.append(str(error))
    assert "valid" in outcomes
    assert any("is beyond all quantities of a roll" in text for text in outcomes)


def keys_of(data: dict[str, Any], section: str = "") -> Iterator[str]:
    for key, value in data.items():
        yield section + key
        if isinstance(value, dict):
            yield from keys_of(value, f"{section}{key}.")


def test_no_key_of_any_shipped_case_takes_infinity_or_nan() -> None:
    """An infinite count raised OverflowError in a validator; every key is tried in the first case that has it."""
    cases = {path: load_case(path).model_dump(mode="json") for path in sorted(CONFIGS.glob("*.yaml"))}
    owners = {key: path for path in reversed(cases) for key in keys_of(cases[path])}
    assert len(owners) > 200
    for key, path in owners.items():
        for value in (".inf", ".nan"):
            with pytest.raises(InputError, match=re.escape(key.rpartition(".")[2])):
                load_case(path, [f"{key}={value}"])


@pytest.mark.parametrize(
    "unit", ["m**9**9**9**9", "9^9^9^9", "m^(9)^(9)^9", "m^99999999", "(m)^9^9", "(" * 60, "x" * 500]
)
def test_a_unit_is_not_a_computation(unit: str) -> None:
    """pint evaluates the powers in a unit."""
    started = time.process_time()
    refused(dry(f"1 {unit}"))
    assert time.process_time() - started < 5.0


def test_powers_in_units_stay() -> None:
    case = load_case(
        TINY, ["mandrel.material.rho=1.2 g/cm^3", "excitation.amplitude=2 m s^-2", "preload.pressure=3 kg m**-1 s**-2"]
    )
    assert case.mandrel.material.rho == 1200.0
    assert case.preload.pressure == 3.0


# ---- size ---------------------------------------------------------------------------------------

LISTS = "a0: &a0 [1, 1]\n" + "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]\n" for k in range(1, 12))
MERGED = "a0: &a0 {x: 1}\n" + "".join(f"a{k}: &a{k} {{<<: [{', '.join([f'*a{k - 1}'] * 10)}]}}\n" for k in range(1, 12))
CHAIN = "".join(f"a{k}: &a{k} [{f'*a{k - 1}' if k else 1}]\n" for k in range(500))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (LISTS, "more than 20000 keys and values, with every alias expanded; write less"),
        (MERGED, "more than 20000 keys and values"),
        (CHAIN, "more than 40 levels of sections"),
        ("a: [" + "1, " * 30000 + "1]\n", "more than 20000 keys and values"),
        ("#" * MOST_CHARACTERS + "\n", f"is too long ({MOST_CHARACTERS + 1} characters; at most {MOST_CHARACTERS})"),
    ],
    ids=["lists", "merge keys", "chain", "table", "text"],
)
def test_a_file_that_is_too_large_is_refused_at_once(text: str, told: str, tmp_path: Path) -> None:
    started = time.process_time()
    assert told in refused(validated(tmp_path / "case.yaml", text))
    assert time.process_time() - started < 5.0


def test_thousands_of_errors_are_told_in_seconds_and_in_bounds(tmp_path: Path) -> None:
    started = time.process_time()
    done = validated(tmp_path / "case.yaml", "".join(f"key{k}: 1\n" for k in range(2500)) + TINY.read_text())
    assert time.process_time() - started < 20.0  # one search for a similar key per error
    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) <= 40


@pytest.mark.parametrize(
    ("key", "most"),
    [("coil.layers", 200), ("mesh.circumferential", 2000), ("mesh.axial", 2000), ("mesh.radial", 200),
     ("preload.steps", 10000), ("solver.max_cuts", 30), ("solver.max_iterations", 10000)],
)  # fmt: skip
@pytest.mark.parametrize("value", ["1000000", "1e18"])
def test_counts_have_a_limit(key: str, most: int, value: str) -> None:
    line = refused(wroll("run", TINY, "--dry-run", "--set", f"{key}={value}"))
    assert f"--set {key}: must be {most} or less, got " in line


@pytest.mark.parametrize(
    "words",
    [["excitation.cycles=1e12"], ["integrator.steps_per_cycle=100000", "excitation.cycles=1e5"],
     ["analysis=sweep", "excitation={kind: chirp, amplitude: 1, f_start: 100, f_end: 200, rate_oct_per_min: 1e-6}"],
     ["analysis=sweep", "excitation={kind: chirp, amplitude: 1, f_start: 100, f_end: 200, rate_hz_per_s: 1e-6}"]],
)  # fmt: skip
def test_time_steps_have_a_limit(words: list[str]) -> None:
    line = refused(wroll("run", TINY, "--dry-run", *[part for word in words for part in ("--set", word)]))
    assert re.search(r"excitation: the motion takes [\d.e+]+ time steps, at most 5e\+07 are possible; shorten it", line)


def test_a_grid_has_a_limit(tmp_path: Path) -> None:
    grid = tmp_path / "grid.yaml"
    values = ", ".join(map(str, range(1, 31)))
    keys = ("preload.pressure", "geometry.length", "contact.friction.mu", "excitation.amplitude", "mandrel.tip_mass")
    grid.write_text(f"base: {TINY}\ngrid:\n" + "".join(f"  {key}: [{values}]\n" for key in keys))
    assert "has 24300000 cases, at most 10000 are possible; give fewer values" in refused(wroll("validate", grid))


# ---- messages and paths -------------------------------------------------------------------------


def test_a_message_has_an_end(tmp_path: Path) -> None:
    line = refused(validated(tmp_path / "case.yaml", TINY.read_text() + "x" * 900 + ": 1\n"))
    assert "xxx ... xxx" in line
    assert len(line) < 900


def test_a_message_shows_no_control_characters() -> None:
    text = str(InputError("line\nend\x1b[31m", key="\ud83d", remedy="a\tb", file="\udcff.yaml"))
    assert text == "\\udcff.yaml: \\ud83d: line\\nend\\x1b[31m; a\\tb"
    text.encode()


def test_a_kind_that_is_no_text_is_refused(tmp_path: Path) -> None:
    assert "excitation" in refused(wroll("run", TINY, "--dry-run", "--set", "excitation.kind=[[1]]"))


@pytest.fixture(params=["long", "loop"])
def unusable(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param == "long":
        return str(tmp_path / ("x" * 300))
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    return str(tmp_path / "loop")


@pytest.mark.parametrize(
    "words",
    ["validate @", "run @", "batch @", "plot @", "report @", "compare @", "init @", "schema --out @",
     "mesh TINY --out @",
     "run TINY --out @", "compare TINY --out @", "report . --out @", "batch STUDY --out @", "mesh @ --out x",
     "run TINY --dry-run --set mesh.file=@", "run TINY --dry-run --set structure.file=@"],
)  # fmt: skip
def test_a_path_that_no_file_can_have_is_refused(words: str, unusable: str) -> None:
    study = CONFIGS / "studies" / "six_preloads.yaml"
    parts = [
        word.replace("TINY", str(TINY)).replace("STUDY", str(study)).replace("@", unusable) for word in words.split()
    ]
    line = refused(wroll(*parts))
    if "structure" not in words:
        assert "the path is not usable (" in line


def test_a_nul_character_in_a_path_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the path contains a NUL character"):
        load_case("a\0b")
    data = parse_yaml(TINY.read_text(), "here")
    data["mesh"]["file"] = "a\0b"
    with pytest.raises(InputError, match="the path contains a NUL character"):
        Case.model_validate(data)


def test_a_text_read_twice_is_read_anew_although_its_content_is_kept() -> None:
    text = "a: &one {b: [1, 2]}\nc: *one\n"
    first = parse_yaml(text, "here")
    assert first["a"] is first["c"]
    first["a"]["b"].append(3)
    assert parse_yaml(text, "here") == {"a": {"b": [1, 2]}, "c": {"b": [1, 2]}}
    for _ in range(2):
        with pytest.raises(InputError, match="is not valid YAML"):
            parse_yaml("a: [", "here")
