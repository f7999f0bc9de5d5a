"""Numbers far outside their usual range: the warning names the unit that was probably meant."""

from __future__ import annotations

import pytest
from support.paths import CONFIGS

from wroll_fem import load_case
from wroll_fem.analyses import case_warnings
from wroll_fem.case.plausibility import USUAL, implausible

SWEEP = CONFIGS / "lab_sweep.yaml"


@pytest.mark.parametrize(
    ("change", "meant"),
    [
        ("mandrel.material.E=70", "70 GPa"),
        ("mandrel.material.E=68300", "68300 MPa"),
        ("coil.material.rho=1.42", "1.42 g/cm^3"),
        ("coil.material.rho=1.42e-9", "1.42e-09 t/mm^3"),
        ("geometry.length=300", "300 mm"),
        ("preload.pressure=0.1", "0.1 MPa"),
        ("preload.pressure=[0.1]", "0.1 MPa"),
        ("contact.friction.elastic_slip=1", "1 um"),
        ("excitation.amplitude=9810", "9810 mm/s^2"),
    ],
)
def test_a_number_in_another_unit_is_recognised(change: str, meant: str) -> None:
    (warning,) = implausible(load_case(SWEEP, [change]))
    assert warning.startswith(change.split("=")[0])
    assert f"did you mean {meant}? write the unit" in warning
    assert warning in case_warnings(load_case(SWEEP, [change]))


def test_millimetres_and_megapascals_throughout_are_told_key_by_key() -> None:
    """The usual set of units of a finite-element model in mm, N and MPa."""
    case = load_case(
        SWEEP,
        [
            "geometry={length: 300, mandrel_outer_diameter: 80, mandrel_thickness: 1.5}", "coil.total_thickness=1.25",
            "mandrel.material={E: 2700, nu: 0.35, rho: 1.2e-9}", "coil.material={E: 2800, nu: 0.35, rho: 2e-9}",
        ],
    )  # fmt: skip
    told = " ".join(implausible(case))
    for value in ("300 mm", "80 mm", "1.5 mm", "1.25 mm", "2700 MPa", "1.2e-09 t/mm^3", "2800 MPa", "2e-09 t/mm^3"):
        assert f"did you mean {value}?" in told


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_cases_are_plausible(path: object) -> None:
    assert implausible(load_case(path)) == []


def test_usual_numbers_give_an_unusual_frequency() -> None:
    """Every number alone is plausible, the roll is not: a length in metres that was meant in millimetres."""
    (warning,) = [text for text in case_warnings(load_case(SWEEP, ["geometry.length=45"])) if "first bending" in text]
    assert "about 0.0" in warning
    assert "check the units of geometry, mandrel and coil" in warning


def test_zero_and_the_limits_are_allowed() -> None:
    assert implausible(load_case(SWEEP, ["preload.pressure=0", f"mandrel.material.E={USUAL['E'].high}"])) == []
