"""One class of case per analysis: which one a case gets, what it holds, and the schema of each."""

from __future__ import annotations

import json
import pickle
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import yaml
from support.paths import CONFIGS

from wroll_fem import Case, InputError, case_warnings, example_case, load_case
from wroll_fem.case import (
    ANALYSES,
    ChirpExcitation,
    DwellCase,
    ModalCase,
    ModalTransientCase,
    OnRoll,
    OnStructure,
    PreloadCase,
    RollSections,
    StructuralCase,
    SweepCase,
    TwoDofCase,
    WindingCase,
    schema_text,
)
from wroll_fem.case.case import case_kinds
from wroll_fem.case.kinds import RollPreloadCase
from wroll_fem.case.kinds_history import RollDwellCase, RollSweepCase, StructureSweepCase

CASES = sorted(CONFIGS.glob("*.yaml"))
SWEEP = CONFIGS / "lab_sweep.yaml"


def content(path: Path) -> dict[str, Any]:
    """A case file as an editor reads it (YAML 1.2: 2.7e9 is a number), paths as written."""
    data: dict[str, Any] = _with_numbers(yaml.safe_load(path.read_text(encoding="utf-8")))
    return data


def _with_numbers(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _with_numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_with_numbers(item) for item in value]
    if isinstance(value, str):
        with suppress(ValueError):
            return float(value)
    return value


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_a_case_is_of_the_class_of_its_analysis(path: Path) -> None:
    case = load_case(path)
    kind = case_kinds()[case.analysis, "structure" in content(path)]
    assert type(case) is kind
    assert isinstance(case, Case)
    assert isinstance(case, OnStructure) == ("structure" in content(path))


def test_every_analysis_has_a_class_and_every_class_an_analysis() -> None:
    assert [analysis for analysis, on_structure in case_kinds() if not on_structure] == list(ANALYSES)
    structural = {analysis for analysis, on_structure in case_kinds() if on_structure}
    histories = {"sweep", "dwell", "random", "shock"}
    assert structural == histories | {"harmonic", "backbone", "random_response", "modal", "preload"}


def test_every_way_to_make_a_case_finds_its_class() -> None:
    one = example_case()
    sections = {name: getattr(one, name) for name in one.model_fields_set}
    for case in (
        Case(**sections),
        Case.model_validate(one.resolved()),
        DwellCase(**sections),
        RollDwellCase(**sections),
    ):
        assert type(case) is RollDwellCase
        assert case == one
    assert Case.model_validate(one) is one
    assert pickle.loads(pickle.dumps(one)) == one


def test_a_class_of_one_analysis_needs_no_analysis() -> None:
    one = load_case(SWEEP).expect(SweepCase)
    sections = {name: getattr(one, name) for name in one.model_fields_set - {"analysis"}}
    case = SweepCase(**sections)  # type: ignore[arg-type]
    assert type(case) is RollSweepCase
    assert case.hash() == one.hash()
    with pytest.raises(InputError, match=r"^analysis: required key is missing; add it \(what to compute\)"):
        StructuralCase(**sections)
    with pytest.raises(InputError, match=r"^analysis: this analysis is not available, got 'dwell'; use one of: sweep"):
        SweepCase.model_validate({**one.resolved(), "analysis": "dwell"})


def test_a_case_has_the_sections_of_its_analysis_and_no_others() -> None:
    sweep = load_case(SWEEP)
    assert isinstance(sweep, SweepCase)
    assert isinstance(sweep.excitation, ChirpExcitation)
    for section in ("structure", "two_dof", "design_map", "damping_ratio"):
        assert not hasattr(sweep, section)
    matrices = load_case(CONFIGS / "oscillator.yaml")
    assert isinstance(matrices, StructureSweepCase)
    for section in ("geometry", "mandrel", "coil", "mesh", "preload"):
        assert not hasattr(matrices, section)
    masses = load_case(CONFIGS / "two_dof.yaml")
    assert isinstance(masses, TwoDofCase)
    assert set(type(masses).model_fields) == {"analysis", "two_dof", "output"}


def test_another_analysis_of_the_same_file_keeps_the_sections_that_it_does_not_use() -> None:
    sweep = load_case(SWEEP, ["harmonic.harmonics=5"])
    pressed = sweep.replace("analysis=preload")
    assert isinstance(pressed, RollPreloadCase)
    assert isinstance(pressed, PreloadCase)
    assert pressed.resolved() == {**sweep.resolved(), "analysis": "preload"}
    assert pressed.replace("analysis=sweep") == sweep
    assert isinstance(sweep.replace("analysis=modal"), ModalCase)


def test_a_section_that_is_null_is_left_out() -> None:
    sweep = load_case(SWEEP)
    assert Case.model_validate({**sweep.resolved(), "two_dof": None, "winding": None}).resolved() == sweep.resolved()
    with pytest.raises(InputError, match="contact: required section is missing"):
        sweep.replace("contact=null")


def test_expect_returns_the_case_or_says_what_it_is() -> None:
    case = example_case()
    assert case.expect(OnRoll) is case
    assert case.expect(RollSections).geometry.length == 0.3
    with pytest.raises(InputError, match=r"^analysis: a case of analysis dwell is a RollDwellCase, not a SweepCase"):
        case.expect(SweepCase)


def test_a_wound_roll_takes_its_mandrel_from_the_case() -> None:
    case = load_case(CONFIGS / "winding_sweep.yaml").expect(OnRoll)
    assert case.winding is not None
    assert case.winding.mandrel is None
    assert case.wound is not None
    assert case.wound.core.outer_radius == 0.5 * case.geometry.mandrel_outer_diameter
    with pytest.raises(InputError, match=r"^winding\.mandrel: required section is missing"):
        _ = case.winding.core
    with pytest.raises(InputError, match=r"^winding\.mu: required key is missing"):
        _ = case.winding.model_copy(update={"mu": None}).friction_coefficient


def test_what_a_case_does_not_give_is_asked_for_where_it_is_needed() -> None:
    with pytest.raises(InputError, match=r"^contact: required section is missing; add it \(friction and normal"):
        _ = load_case(CONFIGS / "lab_mandrel.yaml").expect(OnRoll).friction
    assert load_case(CONFIGS / "lab_mandrel.yaml").expect(OnRoll).direction == "x"
    assert isinstance(load_case(CONFIGS / "winding_case_study.yaml"), WindingCase)
    assert isinstance(load_case(CONFIGS / "case_study.yaml"), ModalTransientCase)


def test_the_hash_is_that_of_earlier_results() -> None:
    """Results on disk carry the hash of their case: it changes with the physics alone."""
    assert example_case().hash() == "4da38d30977e8969c709985e2cd8783e8f68aeab4c13144403577396355b6ce7"
    former = load_case(SWEEP, ["mesh={circumferential: 32, axial: 8, grading: 8}"])
    assert former.hash() == "27f8550e4a517b933225910ad7b34168b2008be37e116761471feefeb76bc908"


def test_a_former_name_of_a_key_is_accepted_with_one_warning() -> None:
    path = CONFIGS / "design_map.yaml"
    case = load_case(path)
    data = content(path)
    data["design_map"]["loosest"] = data["design_map"].pop("softest")
    former = Case.model_validate(data)
    assert former.renamed == ["design_map.loosest is now called design_map.softest; both names are accepted"]
    assert case_warnings(former) == former.renamed
    assert case_warnings(case) == []
    assert former == case
    assert former.hash() == case.hash() == "11668c27116aec4ce41567113d8b54b9cf1a836a5776d51a8b5dda126fc0fec1"
    changed = case.replace("design_map.loosest=1e6")
    assert changed.resolved()["design_map"]["softest"] == 1e6
    assert changed.renamed == former.renamed
    with pytest.raises(InputError, match=r"^design_map\.loosest: is the former name of design_map\.softest, which the"):
        Case.model_validate({**data, "design_map": {**data["design_map"], "softest": 1e6}})
    with pytest.raises(InputError, match=r"--set design_map\.softest: must be positive, got -1"):
        load_case(path, ["design_map.loosest=-1"])


def test_a_file_that_changes_changes_the_hash(tmp_path: Path) -> None:
    mesh = tmp_path / "roll.msh"
    mesh.write_text("one", encoding="utf-8")
    case = load_case(SWEEP, [f"mesh.file={mesh}"])
    before = case.hash()
    assert case.hash() == before
    mesh.write_text("another", encoding="utf-8")
    assert case.hash() != before


# ---- JSON schema --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def problems() -> Any:
    """Function of a case file's content: the messages of a JSON schema validator."""
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft202012Validator(json.loads(schema_text()))
    validator.check_schema(validator.schema)

    def found(data: Mapping[str, Any]) -> list[str]:
        return [error.message for error in validator.iter_errors(data)]

    return found


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_the_schema_accepts_every_config(path: Path, problems: Any) -> None:
    assert problems(content(path)) == []


@pytest.mark.parametrize(
    ("config", "change"),
    [
        ("lab_sweep", {"two_dof": {"friction_capacity": [1], "omega": {"start": 1, "stop": 2, "points": 5}}}),
        ("lab_sweep", {"damping_ratio": 0.02}),
        ("lab_sweep", {"excitation": {"kind": "dwell", "frequency": 150, "amplitude": 5, "cycles": 4}}),
        ("lab_sweep", {"structure": {"file": "roll.npz"}}),
        ("lab_sweep", {"analysis": "flutter"}),
        ("lab_sweep", {"analysis": "two_dof"}),
        ("oscillator", {"geometry": {"length": 1, "mandrel_outer_diameter": 1, "mandrel_thickness": 0.1}}),
        ("two_dof", {"mesh": {"axial": 8}}),
        ("case_study", {"analysis": "modal"}),
    ],
)
def test_the_schema_refuses_what_the_analysis_does_not_have(config: str, change: dict[str, Any], problems: Any) -> None:
    data = content(CONFIGS / f"{config}.yaml") | change
    assert problems(data)
    with pytest.raises(InputError):
        Case.model_validate(data)


@pytest.mark.parametrize("section", ["analysis", "geometry", "excitation"])
def test_the_schema_asks_for_what_the_analysis_needs(section: str, problems: Any) -> None:
    data = content(SWEEP)
    del data[section]
    assert any("required" in text and section in text for text in problems(data))


@pytest.mark.parametrize(
    ("override", "problem"),
    [
        ("excitation.f_end=100", r"excitation.f_end: must be above excitation.f_start = 125 Hz, got 100.0"),
        (
            "excitation.profile={frequency: [1, 2], factor: [1, 2]}",
            r"excitation.profile: a response curve has one ampl",
        ),
    ],
)
def test_a_response_curve_needs_a_rising_band_and_one_amplitude(override: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        load_case(CONFIGS / "lab_harmonic.yaml", [override])
    load_case(CONFIGS / "lab_sweep.yaml", [override])  # a sweep takes both
