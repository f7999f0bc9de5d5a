"""The case file: what is accepted, and the one line that says what is wrong."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import ValidationError
from support.paths import CONFIGS

from wroll_fem import Case, example_case, load_case
from wroll_fem.case import OnStructure, schema_text
from wroll_fem.errors import InputError

CASES = sorted(CONFIGS.glob("*.yaml"))
SWEEP = next(path for path in CASES if path.name == "lab_sweep.yaml")


def error_of(*overrides: str, file: Path = SWEEP) -> str:
    with pytest.raises(InputError) as caught:
        load_case(file, overrides)
    text = str(caught.value)
    assert "\n" not in text
    return text


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "case.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def edited(tmp_path: Path, edit: Any) -> Path:
    data = yaml.safe_load(SWEEP.read_text(encoding="utf-8"))
    edit(data)
    return written(tmp_path, yaml.safe_dump(data))


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_every_config_loads_and_points_to_the_schema(path: Path) -> None:
    assert load_case(path).source == path
    assert path.read_text().splitlines()[0] == "# yaml-language-server: $schema=../docs/wroll-case.schema.json"


def test_the_lab_config_holds_the_values_of_tables_4_1_and_4_2() -> None:
    case = load_case(SWEEP)
    assert (case.geometry.length, case.geometry.mandrel_outer_diameter) == (0.3, 0.08)
    assert (case.geometry.mandrel_thickness, case.coil.total_thickness) == (1.5e-3, 1.25e-3)
    assert (case.mandrel.material.E, case.mandrel.material.rho, case.mandrel.tip_mass) == (2.7e9, 1200, 0.05)
    assert (case.coil.material.E, case.coil.material.rho, case.coil.base) == (2.8e9, 2000, "free")
    assert (case.contact.friction.mu, case.contact.friction.elastic_slip) == (0.25, 1e-6)
    excitation = case.excitation
    assert excitation.kind == "chirp"
    assert (excitation.f_start, excitation.f_end, excitation.rate_oct_per_min, excitation.amplitude) == (125, 175, 2, 5)
    assert case.time_step == pytest.approx(1 / (175 * 40))


def test_the_clamped_config_differs_from_the_free_one_in_the_layer_base_alone() -> None:
    clamped = load_case(SWEEP.with_name("lab_sweep_clamped.yaml")).resolved()
    free = load_case(SWEEP).resolved()
    assert clamped["coil"].pop("base") == "clamped"
    assert free["coil"].pop("base") == "free"
    assert clamped == free


def test_committed_schema_equals_the_generated_one(root: Path) -> None:
    committed = (root / "docs" / "wroll-case.schema.json").read_text(encoding="utf-8")
    assert committed == schema_text(), "run `make schema`"


# ---- what is wrong, in one line -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("override", "expected"),
    [
        ("geometry.lenght=1", "geometry.lenght: unknown key, got 1; did you mean length?"),
        ("contact.mu=0.3", "contact.mu: unknown key, got 0.3; did you mean contact.friction.mu?"),
        ("excitation.frequency=3", "excitation.frequency: unknown key, got 3; did you mean excitation.profile.freq"),
        ("geometry.mandrel_thickness=-1e-3", "mandrel_thickness: must be greater than 0, got -0.001; give the wall"),
        ("geometry.mandrel_thickness=0.05", "the mandrel wall must be thinner than its radius, got 0.05; use"),
        ("coil.total_thickness=0", "coil.total_thickness: must be greater than 0, got 0"),
        ("mandrel.material.nu=0.5", "mandrel.material.nu: must be less than 0.5, got 0.5; give the Poisson's ratio"),
        ("coil.material.nu=-1", "coil.material.nu: must be greater than -1, got -1; give the Poisson's ratio"),
        ("excitation.f_end=125", "excitation.f_end: is excitation.f_start = 125 Hz, got 125.0; give two diff"),
        ("excitation.rate_hz_per_s=2", "rate_hz_per_s: the rate is given twice: rate_oct_per_min = 2, got 2.0; give"),
        ("excitation.rate_oct_per_min=null", "rate_oct_per_min: required key is missing; add it (sweep rate, octaves"),
        ("excitation.profile={frequency: [9, 8], factor: [1, 1]}", "profile: 2 frequencies and 2 factors, whi"),
        ("excitation.profile={frequency: [8, 9], factor: [1, 0]}", "profile: 2 frequencies and 2 factors, whi"),
        ("integrator.steps_per_cycle=19", "highest frequency, 175 Hz, got 19; use 20 or more (dt <= 0.000286 s"),
        ("integrator.scheme=no_damping", "scheme no_damping has a fixed alpha, got -0.05; leave alpha out"),
        ("integrator.alpha=-0.5", "integrator.alpha: must be -0.41422 or more, got -0.5"),
        ("integrator.alpha=0.1", "integrator.alpha: must be 0 or less, got 0.1"),
        ("preload.pressure=[1, 2]", "preload.pressure: 2 pressures for 1 layer, got [1.0, 2.0]; give 1 (inner first)"),
        ("preload.pressure=-5", "preload.pressure: must be 0 or positive (inward pressure), got -5; write a pressure"),
        ("preload.pressure=[]", "preload.pressure: the list of pressures is empty, got []"),
        ("analysis=dwell", "excitation.kind: analysis dwell needs a dwell, got 'chirp'; use excitation.kind: dwell"),
        ("analysis=flutter", "analysis: this analysis is not available, got 'flutter'; use one of: sweep, dwell"),
        ("coil.model=solid", "coil.layers: does not apply to a solid coil, got 1; leave it out"),
        (
            "solver.method=explicit",
            "solver.method: is not one of the choices, got 'explicit'; use reduced, condensed, full",
        ),
        ("excitation.kind=noise", "excitation.kind: is not one of the choices, got 'noise'; use chirp, dwell"),
        ("excitation={}", "excitation.kind: required key is missing; add it"),
        ("mandrel.base=free", "mandrel.base: analysis sweep needs a supported mandrel, got 'free'; use mandrel.base:"),
        ("geometry.length=true", "geometry.length: must be a number, got true"),
        ("geometry.length=[1]", "geometry.length: must be a number, got [1]; give the length"),
        ("geometry.length=300 Pa", "geometry.length: must be a length, not a stress or pressure, got '300 Pa'; give"),
        ("geometry.length=.inf", "geometry.length: must be a finite number, got inf"),
        ("geometry.length=null", "geometry.length: must be a number, got null"),
        ("geometry=3", "geometry: must be a section (key: value pairs), got 3; write its keys"),
        ("coil.layers=1.5", "coil.layers: must be a whole number, got 1.5"),
        ("coil.bending=1", "coil.bending: must be true or false, got 1"),
        ("contact.friction.law=rough", "friction.law: is not one of the choices, got 'rough'; use penalty_coulomb, ra"),
        ("contact.friction.law=rate_coulomb", "contact.friction.rate_table: required section is missing; add it (coef"),
        ("contact.friction.law=smoothed_coulomb", "contact.friction.elastic_slip: unknown key, got 1e-06; known keys:"),
        ("contact.friction.reference_speed=1", "contact.friction.reference_speed: unknown key, got 1; known keys: law"),
        ("contact.normal.penalty=stiff", "contact.normal.penalty: must be auto or a positive number, got 'stiff'"),
        ("contact.normal.penalty=0", "contact.normal.penalty: must be auto or a positive number, got 0"),
        ("mesh.circumferential=25", "mesh.circumferential: must be even, because of the symmetry plane, got 25; "
        "use 24 or 26"),
        ("mesh.circumferential=6", "mesh.circumferential: must be 8 or more, got 6"),
        ("mesh.grading=0.5", "mesh.grading: must be 1 or more, got 0.5"),
        ("mesh.file=/no/such.msh", "mesh.file: mesh file not found, got '/no/such.msh'; give the path of a .msh"),
        ("mesh.file=3", "mesh.file: must be the path of a .msh file, got 3"),
        ("geometry.length.x=3", "geometry.length is not a section, so it has no key 'x'"),
        ("coil={model: layers}", "coil.total_thickness: required key is missing; add it (thickness of all layers"),
    ],
)  # fmt: skip
def test_a_wrong_value_gets_one_line_with_key_value_and_remedy(override: str, expected: str) -> None:
    assert expected in error_of(override)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("slip_rate: [0, 0.01], mu: [0.25]", "rate_table.mu: has 1 values for 2 slip rates, got [0.25]; give one mu f"),
        ("slip_rate: [], mu: []", "rate_table.slip_rate: is empty, got []; give at least the slip rate 0, m/s, and it"),
        ("slip_rate: [0.01, 0.1], mu: [0.2, 0.3]", "rate_table.slip_rate: must start at 0 m/s, got [0.01, 0.1]; start"),
        ("slip_rate: [0, 0.1, 0.1], mu: [0.2, 0.3, 0.4]", "rate_table.slip_rate: must rise, got [0.0, 0.1, 0.1]; sort"),
        ("slip_rate: [0, 0.1], mu: [0.2, -0.3]", "rate_table.mu: must be 0 or more, got [0.2, -0.3]; give coefficient"),
        ("slip_rate: [0, 0.1], mu: [0, 0.3]", "rate_table.mu: must not start at 0, got [0.0, 0.3]; give a positive mu"),
        ("slip_rate: [0, fast], mu: [0.2, 0.3]", "rate_table.slip_rate.1: must be a number, got 'fast'; write a plain"),
        ("slip_rate: 0, mu: [0.2, 0.3]", "rate_table.slip_rate: must be a list, got 0; give the slip rates, m/s, risi"),
    ],
)  # fmt: skip
def test_a_wrong_rate_table_gets_one_line(table: str, expected: str) -> None:
    assert expected in error_of(f"contact.friction={{law: rate_coulomb, elastic_slip: 1e-6, rate_table: {{{table}}}}}")


def test_the_coefficient_at_rest_is_the_first_of_the_rate_table(tmp_path: Path) -> None:
    """It may be left out, then follows the table; a different one is refused."""
    friction = "{law: rate_coulomb, elastic_slip: 1e-6, rate_table: {slip_rate: [0, 0.008, 0.1], mu: [0.2, 0.2, 0.4]}}"
    case = load_case(SWEEP, [f"contact.friction={friction}"])
    assert case.contact.friction.mu == 0.2
    assert case.resolved()["contact"]["friction"]["mu"] == 0.2
    again = load_case(written(tmp_path, case.resolved_yaml()))
    assert again == case
    assert again.hash() == case.hash() != load_case(SWEEP).hash()
    assert case.changed("contact.friction.rate_table.mu=[0.3, 0.3, 0.4]").contact.friction.mu == 0.3
    text = error_of(f"contact.friction={friction}", "contact.friction.mu=0.5")
    assert "contact.friction.mu: must equal the first coefficient of rate_table, 0.2, got 0.5; leave mu out, or" in text


def test_friction_without_a_law_is_penalty_coulomb(tmp_path: Path) -> None:
    case = load_case(edited(tmp_path, lambda data: data["contact"]["friction"].pop("law")))
    assert case.resolved() == load_case(SWEEP).resolved()
    assert case.hash() == load_case(SWEEP).hash()


def test_a_bad_override_names_set_and_the_file() -> None:
    text = error_of("contact.friction.mu=-1")
    assert text.startswith(f"{SWEEP}: --set contact.friction.mu: must be 0 or more, got -1; give the coefficient")


@pytest.mark.parametrize("override", ["mu", "=3", "contact..mu=3", ".mu=1"])
def test_a_malformed_override_is_refused(override: str) -> None:
    assert "must look like key=value" in error_of(override)


def test_an_error_of_the_file_names_file_and_key_without_set(tmp_path: Path) -> None:
    path = edited(tmp_path, lambda data: data["geometry"].update(length=-1.0))
    line = 1 + next(k for k, text in enumerate(path.read_text().splitlines()) if "length: -1.0" in text)
    assert error_of(file=path).startswith(
        f"{path}:{line}: geometry.length: must be greater than 0, got -1.0; give the length"
    )


@pytest.mark.parametrize("section", ["analysis", "geometry", "mandrel", "coil", "contact", "preload", "excitation"])
def test_a_missing_required_section_is_named(tmp_path: Path, section: str) -> None:
    path = edited(tmp_path, lambda data: data.pop(section))
    kind = "key" if section == "analysis" else "section"
    assert error_of(file=path).startswith(f"{path}: {section}: required {kind} is missing; add it (")


def test_a_misspelt_key_is_reported_before_the_key_it_leaves_missing(tmp_path: Path) -> None:
    path = edited(tmp_path, lambda data: data["geometry"].update(lenght=data["geometry"].pop("length")))
    text = error_of(file=path)
    assert "geometry.lenght: unknown key, got 0.3; did you mean length?" in text
    assert "more)" not in text


def test_further_errors_are_counted() -> None:
    text = error_of("geometry.length=-1", "mesh.axial=0", "coil.layers=0")
    assert "--set geometry.length: must be greater than 0, got -1" in text
    assert text.endswith("(and 2 more)")


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("analysis: [sweep", "is not valid YAML at line"),
        ("a: b: c", "is not valid YAML at line 1"),
        ("", "is empty; write sections"),
        ("- sweep\n", "is not a case: it contains a list"),
        ("analysis: sweep\nanalysis: dwell\n", "key 'analysis' occurs twice"),
        ("analysis: sweep\ngeometry: {length: 1, length: 2}\n", "key 'length' occurs twice"),
        ("!!python/object:os.system {}\n", "is not valid YAML"),
        ("\t- a", "is not valid YAML"),
    ],
)
def test_a_file_that_is_no_case_is_refused_in_one_line(tmp_path: Path, content: str, expected: str) -> None:
    path = written(tmp_path, content)
    text = error_of(file=path)
    assert text.startswith(f"{path}: ")
    assert expected in text


def test_missing_folder_and_binary_files_are_refused(tmp_path: Path) -> None:
    assert error_of(file=tmp_path / "nothing.yaml") == (
        f"{tmp_path / 'nothing.yaml'}: file not found; give the path of a case file (see configs/)"
    )
    assert "cannot be read (is a directory)" in error_of(file=tmp_path)
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00\x81")
    assert "is not a UTF-8 text file" in error_of(file=binary)
    strange = written(tmp_path, "3: 4\n")
    assert error_of(file=strange).startswith(f"{strange}:1: ")


# ---- what is accepted ---------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["1e-3", "1.0e-3", "0.001", "'1e-3'"])
def test_numbers_that_yaml_reads_as_text_become_floats(text: str) -> None:
    case = load_case(SWEEP, [f"geometry.mandrel_thickness={text}", f"contact.normal.penalty={text}"])
    assert case.geometry.mandrel_thickness == 1e-3
    assert case.contact.normal.penalty == 1e-3
    assert isinstance(case.contact.normal.penalty, float)


def test_exponents_without_a_point_inside_lists_and_counts_become_numbers() -> None:
    case = load_case(SWEEP, ["coil.layers=2", "preload.pressure=[1e4, 2e4]", "solver.max_iterations=1e2"])
    assert case.preload.pressure == [1e4, 2e4]
    assert case.solver.max_iterations == 100


def test_coarse_steps_are_accepted_on_request_only() -> None:
    case = load_case(SWEEP, ["integrator.steps_per_cycle=10", "solver.allow_coarse=true"])
    assert case.integrator.steps_per_cycle == 10
    assert load_case(SWEEP, ["integrator.steps_per_cycle=20"]).integrator.steps_per_cycle == 20


@pytest.mark.parametrize(
    ("scheme", "alpha"),
    [("transient_fidelity", -0.05), ("moderate_dissipation", -0.41421), ("no_damping", 0.0), ("quasi_static", 0.0)],
)
def test_named_schemes_bring_their_own_alpha(scheme: str, alpha: float) -> None:
    case = example_case().changed(f"integrator.scheme={scheme}")
    assert case.integrator.alpha == alpha
    assert case.changed("integrator.scheme=hht").integrator.alpha == -0.05
    assert Case.model_validate(yaml.safe_load(case.resolved_yaml())) == case


def test_pressure_on_the_outermost_layer_alone_or_on_each() -> None:
    case = load_case(SWEEP, ["coil.layers=3"])
    assert case.preload.per_layer(3) == [0.0, 0.0, 1e5]
    assert load_case(SWEEP, ["coil.layers=2", "preload.pressure=[3, 4]"]).preload.per_layer(2) == [3.0, 4.0]


def test_a_mandrel_alone_needs_neither_layers_nor_contact_nor_preload() -> None:
    data = example_case().resolved()
    data["coil"] = {"model": "none"}
    del data["contact"], data["preload"]
    case = Case.model_validate(data)
    assert case.resolved()["coil"] == {"model": "none", "layers": 1, "base": "free", "bending": True}
    assert "preload" not in case.resolved()
    assert case.contact is None
    assert Case.model_validate(yaml.safe_load(case.resolved_yaml())) == case


def test_stuck_modes_need_contact_and_preload_but_bonded_ones_do_not() -> None:
    data = example_case().resolved()
    data["analysis"] = "modal"
    for section in ("contact", "preload", "excitation"):
        del data[section]
    assert Case.model_validate(data).modal.interface == "bonded"
    with pytest.raises(InputError, match=r"^contact: required section is missing; .*interface: stuck"):
        Case.model_validate({**data, "modal": {"interface": "stuck"}})


def test_preload_analysis_needs_layers() -> None:
    with pytest.raises(InputError, match=r"coil.model: analysis preload needs layers, or a solid"):
        example_case().changed("analysis=preload", "coil.model=bonded")


def test_a_start_ramp_longer_than_the_dwell_is_refused() -> None:
    with pytest.raises(InputError, match=r"ramp_cycles: the smooth start is longer than the dwell of 4 cycles, got 6"):
        example_case().changed("excitation.ramp_cycles=6")


def test_cases_are_frozen_and_copies_are_checked() -> None:
    case = example_case()
    with pytest.raises(ValidationError):
        case.geometry.length = 1.0  # type: ignore[misc]
    assert case.changed("geometry.length=0.5").geometry.length == 0.5
    assert case.geometry.length == 0.3
    with pytest.raises(InputError, match=r"^geometry\.length: must be greater"):
        case.changed("geometry.length=-1")


# ---- resolved text and hash ---------------------------------------------------------------------


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_the_resolved_text_writes_every_value_and_loads_to_the_same_case(path: Path, tmp_path: Path) -> None:
    case = load_case(path)
    again = load_case(written(tmp_path, case.resolved_yaml()))
    assert again == case
    assert again.hash() == case.hash()
    written_out = set(yaml.safe_load(case.resolved_yaml()))
    if case.analysis == "winding":
        assert {"winding", "output"} <= written_out
        assert "cells: 2400" in case.resolved_yaml()
        return
    if case.analysis == "two_dof":
        assert written_out == {"analysis", "two_dof", "output"}
        assert "preload_dependent: true" in case.resolved_yaml()
        return
    if case.analysis == "sizing":
        assert written_out == {"analysis", "sizing", "mesh", "output"}
        assert "yield_stress: 280000000.0" in case.resolved_yaml()
        return
    assert {
        "integrator",
        "solver",
        "modal",
        "output",
        "structure" if isinstance(case, OnStructure) else "mesh",
    } <= written_out
    assert "max_cuts: 6" in case.resolved_yaml()


def test_the_hash_follows_the_physics_and_not_the_output() -> None:
    case = example_case()
    assert case.changed("output.figures=false", "solver.checkpoint_seconds=5").hash() == case.hash()
    assert case.changed("contact.friction.mu=0.26").hash() != case.hash()
    assert case.changed("mesh.axial=5").hash() != case.hash()


def test_a_mesh_file_is_found_beside_the_case_and_hashed_by_its_content(tmp_path: Path) -> None:
    def with_mesh(folder: str, content: str) -> Case:
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "roll.msh").write_text(content)
        path = edited(tmp_path / folder, lambda data: data["mesh"].update(file="roll.msh"))
        return load_case(path)

    one, same, other = with_mesh("a", "mesh"), with_mesh("b", "mesh"), with_mesh("c", "another mesh")
    assert one.mesh.file == (tmp_path / "a" / "roll.msh").resolve()
    assert one.hash() == same.hash()
    assert one.hash() != other.hash()


def test_loading_a_case_imports_nothing_heavy() -> None:
    code = (
        "import sys, wroll_fem; wroll_fem.load_case(sys.argv[1]); import wroll_fem.cli; "
        "heavy = {'dolfinx', 'gmsh', 'pyvista', 'numba', 'matplotlib', 'xarray', 'numpy'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code, str(SWEEP)], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("file", "steps", "reason"),
    [("tiny.yaml", 2, "every sample could be zero"), ("lab_sweep.yaml", 8, "too few to demodulate")],
)
def test_steps_that_do_not_sample_the_motion_are_refused_whatever_is_allowed(
    file: str, steps: int, reason: str
) -> None:
    words = ["solver.allow_coarse=true"]
    with pytest.raises(InputError, match=reason):
        load_case(CONFIGS / file, [*words, f"integrator.steps_per_cycle={steps}"])
    assert load_case(CONFIGS / file, [*words, f"integrator.steps_per_cycle={steps + 1}"])
