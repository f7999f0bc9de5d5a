"""Layers that nothing holds at rest are refused for steady motions: one line, exit code 2, no run folder."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.paths import CONFIGS
from typer.testing import CliRunner

from wroll_fem.case import load_case
from wroll_fem.case.contact import friction_law
from wroll_fem.case.preload import Preload
from wroll_fem.cli import app
from wroll_fem.errors import InputError

BARE = "preload.pressure: leaves {} without pressure, and coil.base: {} does not hold it"
SMOOTHED = "contact.friction={law: smoothed_coulomb, mu: 0.25, reference_speed: 1e-4}"
WOUND = "preload={kind: winding_stress, pressure: [0, 1e5]}"


@pytest.mark.parametrize("name", ["harmonic", "backbone", "random_response"])
@pytest.mark.parametrize(
    ("changed", "says"),
    [
        (["preload.pressure=0"], BARE.format("the coil", "free")),
        (["preload.pressure=0", "contact.normal.separation=false"], BARE.format("the coil", "free")),
        (["preload.pressure=0", "contact.friction.mu=0"], BARE.format("the coil", "free")),
        (["preload.pressure=0", "coil.base=guided"], BARE.format("the coil", "guided")),
        (["coil.layers=3", "preload.pressure=[1e5, 1e5, 0]"], BARE.format("layer 3", "free")),
        (["coil.layers=2", "preload.pressure=0", "coil.base=inner_edge"], BARE.format("layer 2", "inner_edge")),
        (["coil.layers=2", WOUND], BARE.format("layer 1", "free")),
        ([SMOOTHED], "contact.friction.law: transmits no traction at rest, and coil.base: free does not hold the coil"),
        ([SMOOTHED, "coil.layers=2", "coil.base=inner_edge"], "coil.base: inner_edge does not hold layer 2"),
    ],
)
def test_a_layer_that_nothing_holds_is_refused(name: str, changed: list[str], says: str, tmp_path: Path) -> None:
    words = [word for text in changed for word in ("--set", text)]
    file, out = CONFIGS / f"lab_{name}.yaml", tmp_path / "out"
    done = CliRunner().invoke(app, ["run", str(file), *words, "--out", str(out)])
    assert done.exit_code == 2, done.output
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"{file}: --set ")
    assert says in done.stderr
    assert not out.exists()


@pytest.mark.parametrize(
    "changed",
    [
        ["coil.layers=2", "preload.pressure=[0, 1e5]"],  # the outer layer presses both interfaces
        ["preload.pressure=0", "coil.base=clamped"],
        ["preload.pressure=0", "coil.base=guided", "coil.base_stiffness=1e5"],
        ["coil.layers=2", WOUND, "coil.base=inner_edge"],  # the inner layer is held, and the outer one pressed on it
        ["contact.friction.mu=0"],
        ["preload.pressure=0", "contact.friction.mu=0", "contact.normal.separation=false"],
        [SMOOTHED, "coil.base=inner_edge"],
        [SMOOTHED, "contact.friction.mu=0"],
    ],
)
def test_a_layer_that_something_holds_is_accepted(changed: list[str]) -> None:
    assert load_case(CONFIGS / "lab_harmonic.yaml", changed).analysis == "harmonic"


@pytest.mark.parametrize("name", ["dwell", "sweep", "modal", "random"])
def test_other_analyses_follow_a_floating_layer(name: str) -> None:
    for changed in ("preload.pressure=0", SMOOTHED):
        assert load_case(CONFIGS / f"lab_{name}.yaml", [changed]).analysis == name


def test_a_solid_coil_without_pressure_is_refused() -> None:
    with pytest.raises(InputError, match=r"preload\.pressure: leaves the coil without pressure"):
        load_case(CONFIGS / "habex_friction.yaml", ["preload.kind=winding_stress", "preload.pressure=0"])


@pytest.mark.parametrize(
    ("kind", "pressure", "bare"),
    [
        ("external_pressure", 0.0, [1, 2, 3]),
        ("external_pressure", 1e4, []),
        ("external_pressure", [0.0, 1e4, 0.0], [3]),
        ("external_pressure", [0.0, 0.0, 1e4], []),
        ("winding_stress", 0.0, [1, 2, 3]),
        ("winding_stress", [1e4, 0.0, 1e4], [2]),
        ("winding_stress", None, []),
        ("interface_pressure", 1e4, []),
        ("winding_tension", None, []),
    ],
)
def test_interfaces_that_given_pressures_leave_bare(kind: str, pressure: float | list[float], bare: list[int]) -> None:
    assert Preload(kind=kind, pressure=pressure).bare_interfaces(3) == bare


@pytest.mark.parametrize(
    ("law", "acts"),
    [
        ("{law: penalty_coulomb, mu: 0.25, elastic_slip: 1e-6}", True),
        ("{law: rate_coulomb, elastic_slip: 1e-6, rate_table: {slip_rate: [0, 0.1], mu: [0.2, 0.3]}}", True),
        ("{law: bouc_wen, mu: 0.25, elastic_slip: 1e-6, exponent: 2, unloading: 0.5}", True),
        ("{law: smoothed_coulomb, mu: 0.25, reference_speed: 1e-4}", False),
    ],
)
def test_which_laws_act_at_rest(law: str, acts: bool) -> None:
    case = load_case(CONFIGS / "lab_dwell.yaml", [f"contact.friction={law}"])
    assert friction_law(case.friction).acts_at_rest is acts
