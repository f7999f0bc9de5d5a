"""Words, labels and numbers of a report."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from support.paths import CONFIGS

from wroll_fem import load_case
from wroll_fem.report.values import shown
from wroll_fem.report.words import analysis_words, case_rows
from wroll_fem.results.summary import SUMMARY, label, split_unit

CASES = sorted(CONFIGS.glob("*.yaml"))


@pytest.mark.parametrize("path", CASES, ids=lambda p: p.stem)
def test_every_case_is_described_by_the_words_of_its_models(path: Path) -> None:
    given = yaml.safe_load(load_case(path).resolved_yaml())
    assert analysis_words(given).startswith(f"{given['analysis']}. ")
    rows = case_rows(given)
    assert len({row.key for row in rows}) == len(rows) > 5
    for row in rows:
        assert row.name, row.key
        assert row.value, row.key
        assert row.name[0] not in " ,;:", row
        assert row.value[0] not in "{[", row  # nothing is shown as it is written


def test_values_are_shown_in_the_units_of_their_descriptions() -> None:
    given = yaml.safe_load(load_case(CONFIGS / "lab_sweep.yaml").resolved_yaml())
    found = {row.key: (row.section, row.name, row.value) for row in case_rows(given)}
    assert found["geometry.length"] == ("Geometry", "length of mandrel and coil from base to tip", "300 mm")
    assert found["mandrel.material.rho"] == ("Mandrel", "density", "1200 kg/m³")
    assert found["mandrel.tip"] == ("Mandrel", "tip", "rigid: the tip ring moves as a rigid body (spool cap)")
    assert found["coil.base"][2] == "free: held by friction or the bond alone"
    assert found["contact.friction.elastic_slip"][2] == "1 µm"
    assert found["contact.normal.separation"] == ("Contact", "surfaces may separate", "yes")
    assert found["excitation.amplitude"] == ("Excitation", "amplitude of the base acceleration (0-peak)", "5 m/s²")
    assert found["excitation.rate_oct_per_min"][2] == "2 oct/min"
    assert found["integrator.scheme"][1:] == ("scheme", "hht")
    membranes = case_rows(given | {"coil": given["coil"] | {"bending": False}})
    assert next(row for row in membranes if row.key == "coil.bending").value == "no: membranes"
    space = yaml.safe_load(load_case(CONFIGS / "two_dof_design_space.yaml").resolved_yaml())
    units = {row.key: row.value.split()[-1] for row in case_rows(space) if row.key.endswith(".stop")}
    assert units == {
        "two_dof.omega.stop": "rad/s", "two_dof.design_space.m2.stop": "kg", "two_dof.design_space.k2.stop": "N/m",
    }  # fmt: skip


def test_sections_of_another_version_are_shown_as_written() -> None:
    rows = case_rows({"analysis": "new", "geometry": {"size": 2.0}, "extra": {"a": [1.0] * 20, "b": {"c": 3}}})
    assert [tuple(row) for row in rows] == [
        ("Geometry", "size", "2", "geometry.size"),
        ("Extra", "a", "20 values from 1 to 1", "extra.a"),
        ("Extra", "c", "3", "extra.b.c"),
    ]
    assert analysis_words({"analysis": "new"}) == "new."


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("f_n_hz", 133.58764, "133.588 Hz"),
        ("friction_energy_j", 7.0866e-4, "708.7 µJ"),
        ("pressure_mandrel_pa", 6.2884e6, "6.288 MPa"),
        ("slipping_area_fraction", [0.34, 0.0], "34 %, 0 %"),
        ("effective_mass_fraction", 3e-29, "0 %"),
        ("energy_balance_error", 6.8e-7, "below 0.001 %"),
        ("mass_total_kg", 0.0543, "54.3 g"),
        ("mass_total_kg", 25.0, "25 kg"),
        ("solver_time_s", 170.25, "170.2 s"),
        ("steady_amplitude_m_s2", 38.7474, "38.75 m/s²"),
        ("dofs", 21315, "21\u202f315"),
        ("zeta", None, "none"),
        ("zeta", float("nan"), "none"),
        ("half_power_complete", True, "yes"),
        ("max_slip_m", 9.9996e-7, "1 µm"),
        ("max_slip_m", -0.0, "0 m"),
        ("impact_dissipation_j", -2.12e-21, "-2e-21 J"),
        ("k2_at_zeta_max_n_m", 2.68, "2.68 N/m"),
        ("zeta_max_over_design", 0.2854, "28.54 %"),
    ],
)
def test_values_are_shown_with_their_units(name: str, value: object, told: str) -> None:
    assert shown(name, value) == told


def test_units_are_those_at_the_end_of_a_name() -> None:
    assert split_unit("base_acceleration_at_zeta_max_m_s2") == ("base_acceleration_at_zeta_max", "m/s²")
    assert split_unit("slip_onset_g") == ("slip_onset", "g")
    assert split_unit("dofs") == ("dofs", "")
    assert label("slip_zone_height_m") == "Slip zone height"


def test_the_table_of_the_summary_has_the_units_of_its_names() -> None:
    for name, entry in SUMMARY.items():
        assert entry.unit == split_unit(name)[1], name
        assert entry.label, name


@pytest.mark.parametrize(("name", "shown_sections"), [("backbone", {"Harmonic", "Backbone"}), ("dwell", set())])
def test_a_section_with_defaults_is_shown_for_the_analyses_that_use_it(name: str, shown_sections: set[str]) -> None:
    given = yaml.safe_load(load_case(CONFIGS / f"lab_{name}.yaml").resolved_yaml())
    found = {row.section for row in case_rows(given)}
    assert found & {"Modal", "Harmonic", "Backbone"} == shown_sections


def test_entries_of_a_list_are_written_in_brief() -> None:
    """Plies of a laminate and rows of a wall table: one line each, with units, not the dictionaries of Python."""
    ply = {"material": {"kind": "lamina", "E_1": 1.4e11}, "thickness": 2.5e-4, "angle": 45.0}
    mandrel = {"material": {"kind": "laminate", "plies": [ply, ply]}, "wall": [{"z": 0.05, "thickness": 0.006}]}
    rows = {row.key: (row.name, row.value) for row in case_rows({"analysis": "modal", "mandrel": mandrel})}
    assert rows["mandrel.material.plies.1"] == ("plies 2", "lamina, thickness 250 µm, angle 45 deg")
    assert rows["mandrel.wall.0"] == ("wall 1", "z 50 mm, thickness 6 mm")
