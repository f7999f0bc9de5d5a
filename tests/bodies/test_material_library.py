"""Materials that a case file may name: the same case as with their numbers; the laminate follows from its lamina."""

from __future__ import annotations

import pytest
from support.paths import CONFIGS
from typer.testing import CliRunner

from wroll_fem import cli, load_case
from wroll_fem.bodies.material_library import LIBRARY
from wroll_fem.errors import InputError


@pytest.mark.parametrize("name", LIBRARY)
def test_a_name_stands_for_its_numbers(name: str) -> None:
    known = LIBRARY[name]
    named = load_case(CONFIGS / "lab_sweep.yaml", [f"mandrel.material={name}", f"coil.material={name}"])
    numbers = f"{{E: {known.E}, nu: {known.nu}, rho: {known.rho}}}"
    assert named == load_case(CONFIGS / "lab_sweep.yaml", [f"mandrel.material={numbers}", f"coil.material={numbers}"])
    assert named.mandrel.material.E == known.E
    assert known.range_E[0] <= known.E <= known.range_E[1]


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match="did you mean aluminium_6061_t6") as caught:
        load_case(CONFIGS / "lab_sweep.yaml", ["mandrel.material=aluminum"])
    assert all(name in str(caught.value) for name in LIBRARY)


def test_the_quasi_isotropic_laminate_follows_from_its_lamina() -> None:
    """Invariants of Tsai and Pagano: E = (U1^2 - U4^2)/U1, nu = U4/U1."""
    E1, E2, G12, nu12 = 164e9, 12e9, 5.2e9, 0.32
    divisor = 1.0 - nu12**2 * E2 / E1
    Q11, Q22, Q12 = E1 / divisor, E2 / divisor, nu12 * E2 / divisor
    U1 = (3 * Q11 + 3 * Q22 + 2 * Q12 + 4 * G12) / 8
    U4 = (Q11 + Q22 + 6 * Q12 - 4 * G12) / 8
    laminate = LIBRARY["cfrp_quasi_isotropic"]
    assert pytest.approx((U1**2 - U4**2) / U1, rel=1e-3) == laminate.E
    assert pytest.approx(U4 / U1, abs=1e-3) == laminate.nu


def test_the_command_prints_every_material_with_its_source() -> None:
    text = CliRunner().invoke(cli.app, ["materials"]).stdout
    for name, known in LIBRARY.items():
        assert f"{name}: {known.title}" in text
        assert known.source in text
