"""Quantities with units in case files: what they become in SI, and the line that says what is wrong."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
import yaml
from support.paths import CONFIGS

from wroll_fem import load_case
from wroll_fem.case import Case
from wroll_fem.case.units import KINDS, WrongQuantity, in_si
from wroll_fem.errors import InputError

SWEEP = CONFIGS / "lab_sweep.yaml"


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1200 mm", "m", 1.2),
        ("1.2e3mm", "m", 1.2),
        ("80 µm", "m", 80e-6),
        ("3 in", "m", 0.0762),
        ("70 GPa", "Pa", 70e9),
        ("14.5 psi", "Pa", 14.5 * 6894.757293168361),
        ("1 N/mm^2", "Pa", 1e6),
        ("200 N", "N", 200.0),
        ("0.5 g", "m/s^2", 0.5 * 9.80665),
        ("0.5 g0", "m/s^2", 0.5 * 9.80665),
        ("2 g", "kg", 2e-3),
        ("1.4 g/cm^3", "kg/m^3", 1400.0),
        ("19.6133 m/s^2", "multiples of 9.80665 m/s^2", 2.0),
        ("2 kHz", "Hz", 2000.0),
        ("30 min^-1", "Hz", 0.5),
        ("30 1/min", "Hz", 0.5),
        ("30 rpm", "Hz", 0.5),
        ("6.283185307179586 rad/s", "Hz", 1.0),
        ("60 rpm", "rad/s", 6.28318530717959),
        ("1 Hz", "rad/s", 6.28318530717959),
        ("90 deg", "rad", 1.5707963267949),
        ("25 %", "dimensionless", 0.25),
        ("5 MPa/mm", "Pa/m", 5e9),
        ("-3 mm", "m", -3e-3),
    ],
)
def test_a_quantity_becomes_a_number_in_si(text: str, unit: str, value: float) -> None:
    assert in_si(text, unit) == pytest.approx(value, rel=1e-13)


@pytest.mark.parametrize(("unit", "kind"), KINDS.items())
def test_the_example_of_every_kind_is_a_quantity_of_it(unit: str, kind: object) -> None:
    assert isinstance(in_si(KINDS[unit].example, unit), float)
    assert not isinstance(in_si(KINDS[unit].example, unit), WrongQuantity)


@pytest.mark.parametrize("text", ["auto", "1e-6", "12", "", "free", "mm", "1 200 mm"])
def test_what_is_no_number_with_a_unit_stays_as_it_is(text: str) -> None:
    assert in_si(text, "m") is text


@pytest.mark.parametrize(
    ("text", "unit", "problem", "remedy"),
    [
        ("70 Gpa", "Pa", "unknown unit 'Gpa'", "did you mean GPa? give a number in Pa"),
        ("70 kg", "m", "must be a length, not a mass", "for example 1200 mm"),
        ("200 N", "Pa", "must be a stress or pressure, not a force", "for example 70 GPa"),
        ("0.3 %", "m", "must be a length, not a pure number", "give a number in m"),
        ("5 parsnips", "m", "unknown unit 'parsnips'", "give a number in m, or a length with its unit"),
        ("3 mm", "dimensionless", "must be a pure number, not a length", "give a plain number"),
    ],
)
def test_a_wrong_quantity_says_what_and_how(text: str, unit: str, problem: str, remedy: str) -> None:
    found = in_si(text, unit)
    assert isinstance(found, WrongQuantity)
    assert found.problem == problem
    assert remedy in found.remedy


def test_a_case_in_millimetres_is_the_case_in_metres() -> None:
    """Converted when it is read: same resolved case, same hash."""
    units = load_case(
        SWEEP,
        [
            "geometry.length=300 mm", "geometry.mandrel_outer_diameter=8 cm", "mandrel.material.E=2.7 GPa",
            "mandrel.material.rho=1.2 g/cm^3", "mandrel.tip_mass=50 g", "contact.friction.elastic_slip=1 um",
            "preload.pressure=1 bar", "excitation.f_end=175 Hz",
        ],
    )  # fmt: skip
    assert units == load_case(SWEEP)
    assert units.hash() == load_case(SWEEP).hash()


def test_lists_take_quantities_too() -> None:
    case = load_case(CONFIGS / "design_map.yaml", ["design_map.mandrel_radius=[30 mm, 0.04]"])
    assert case.design_map.mandrel_radius == [0.03, 0.04]


def test_all_wrong_keys_are_told_at_once_with_their_lines(tmp_path: Path) -> None:
    """One line for each, in the order of the file, with the number of its line."""
    text = SWEEP.read_text(encoding="utf-8")
    for right, wrong in (
        ("length: 0.300", "length: 300 kg"),
        ("layers: 1", "layers: 0"),
        ("elastic_slip: 1", "elastic_slop: 1"),
    ):
        text = text.replace(right, wrong, 1)
    path = tmp_path / "case.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_case(path)
    lines = caught.value.lines
    numbers = [int(line.removeprefix(f"{path}:").split(":")[0]) for line in lines]
    assert numbers == sorted(numbers)
    for number, wanted in zip(numbers, ("length: 300 kg", "layers: 0", "elastic_slop"), strict=True):
        assert wanted in text.splitlines()[number - 1]
    assert "must be a length, not a mass" in lines[0]
    assert "did you mean elastic_slip?" in lines[2]


def test_a_level_in_multiples_of_gravity_is_the_same_case() -> None:
    text = SWEEP.read_text(encoding="utf-8")
    assert "amplitude: 5.0" in text
    case = load_case(SWEEP, ["excitation.amplitude=4.903325"])
    with_g = Case.model_validate(yaml.safe_load(text.replace("amplitude: 5.0", "amplitude_g: 0.5", 1)))
    assert with_g == case
    assert with_g.hash() == case.hash()


def test_one_of_two_amplitudes() -> None:
    with pytest.raises(InputError, match=r"given twice: amplitude = 5 m/s\^2, got 0\.5; give only one of them"):
        load_case(SWEEP, ["excitation.amplitude_g=0.5"])
    without = yaml.safe_load(SWEEP.read_text(encoding="utf-8"))
    del without["excitation"]["amplitude"]
    with pytest.raises(InputError, match=r"excitation\.amplitude: required key is missing; add it .* or amplitude_g"):
        Case.model_validate(without)


def test_an_areal_mass_gives_the_density() -> None:
    case = load_case(CONFIGS / "lab_sweep.yaml", ["coil.areal_mass=2500 g/m^2", "coil.material={E: 3e+9, nu: 0.3}"])
    assert case.coil.material.rho == pytest.approx(2.5 / 1.25e-3)
    assert "areal_mass" not in case.resolved()["coil"]
    named = load_case(CONFIGS / "lab_sweep.yaml", ["coil.areal_mass=2.5", "coil.material=kapton"])
    assert named.coil.material.rho == pytest.approx(2000.0)
    with pytest.raises(InputError, match=r"does not go with material\.rho"):
        load_case(CONFIGS / "lab_sweep.yaml", ["coil.areal_mass=2.5"])
    with pytest.raises(InputError, match="needs the thickness and the material"):
        load_case(CONFIGS / "lab_sweep.yaml", ["coil={model: none, areal_mass: 2.5}", "analysis=modal"])


def test_angles_of_plies_are_degrees() -> None:
    ply = "{material: kapton, thickness: 1.25e-3, angle: 0.5 rad}"
    case = load_case(CONFIGS / "lab_sweep.yaml", [f"coil.material={{plies: [{ply}]}}"])
    assert case.coil.material.plies[0].angle == pytest.approx(28.6478897565)


def test_no_text_of_a_unit_stops_the_reading() -> None:
    """pint raises TokenError for an open bracket, AssertionError for a bracket alone, KeyError for nepers."""
    chance, found = random.Random(3), set()
    for _ in range(2000):
        text = list("1 " + chance.choice(["mm", "GPa", "kg/m^3", "N s/m", "(m", "1/s", "rpm", "Np"]))
        for _ in range(chance.choice((1, 2, 4))):
            text.insert(chance.randrange(2, len(text) + 1), chance.choice("mkgPaNs()*^/ .12-µ°%[]{},'#@!=<:;|&~`"))
        found.add(type(in_si("".join(text), chance.choice(list(KINDS)))))
    assert found == {str, float, WrongQuantity}
