"""Layers that stand for several wraps (`coil.per_wrap`): elastic slip of their interfaces, stiffness, forecasts."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from support.friction_point import CLOSED, GAMMA, MU, PRESSURE, V0, Point
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.forecasts.closed_forms import beam_frequency
from wroll_fem.analyses.forecasts.slip import slip_forecast
from wroll_fem.analyses.shared import summary
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.analyses.shared.preflight import missed_resonance
from wroll_fem.analyses.shared.self_contained import described
from wroll_fem.case import build_case, load_case
from wroll_fem.case.structural import OnRoll
from wroll_fem.contact.bouc_wen import BoucWen
from wroll_fem.contact.elastic_coulomb import ElasticCoulomb
from wroll_fem.contact.law import FrictionLaw
from wroll_fem.contact.laws import PenaltyCoulomb, RateCoulomb, SmoothedCoulomb
from wroll_fem.contact.polynomial_spring import PolynomialSpring
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.errors import InputError
from wroll_fem.numerics.linear import factorise
from wroll_fem.plotting import style
from wroll_fem.results.dataset import annotate, load_dataset, save_dataset
from wroll_fem.results.interface_slip import wrap_interfaces

LAWS = [
    PenaltyCoulomb(MU, GAMMA), RateCoulomb(MU, GAMMA, (0.0, 0.01, 0.1), (MU, 0.3, 0.42)), SmoothedCoulomb(MU, V0),
    BoucWen(MU, GAMMA, 1.5, 0.7), ElasticCoulomb(MU, GAMMA, MU * PRESSURE / GAMMA),
    PolynomialSpring(GAMMA, (0.4, 0.3, 0.5)),
]  # fmt: skip

WOUND = [
    "mesh={circumferential: 8, axial: 4, grading: 8}", "preload={kind: winding_stress}",
    "winding={tension_stress: 1e6, wraps: 12, wrap_thickness: 1e-4, mu: 0.25, "
    "web: {E_theta: 2.8e9, nu_theta: 0.35, radial_modulus: {law: pfeiffer, K1: 1e3, K2: 40}}}",
    "coil.total_thickness=1.2e-3",
]  # fmt: skip


def roll(layers: int, *more: str) -> OnRoll:
    return load_case(CONFIGS / "lab_backbone.yaml", [*WOUND, f"coil.layers={layers}", *more]).expect(OnRoll)


def stuck_hz(case: OnRoll) -> float:
    """First frequency with sticking layers, at the pressure of the wound roll."""
    system = build_system(case, build_bodies(case, symmetric=True))
    assert system.initial_pressure is not None
    stiffness = system.with_interface_springs(
        stick_springs(system, ContactState.pressed(system, system.initial_pressure))
    )
    factor, mode = factorise(stiffness), system.influence
    for _ in range(12):
        mode = factor.solve(system.mass @ mode)
        mode = mode / np.sqrt(mode @ (system.mass @ mode))
    return float(np.sqrt(mode @ (stiffness @ mode)) / (2.0 * np.pi))


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_interfaces_in_series_have_the_traction_of_one_and_the_sum_of_its_displacements(law: FrictionLaw) -> None:
    """To and fro in both directions, at constant pressure: four interfaces move by 4 g where one moves by g."""
    rng, dt, count = np.random.default_rng(3), 1e-4, 4.0
    path = np.cumsum(rng.standard_normal((60, 2)) * 0.6 * GAMMA, axis=0)
    one, four = Point(law), Point(law.in_series(count))
    sizes = []
    for g in path:
        traction, _ = one.move([*g, CLOSED], dt)
        lumped, _ = four.move([*(count * g), CLOSED], dt)
        np.testing.assert_allclose(lumped[:2], traction[:2], rtol=1e-10, atol=1e-10 * MU * PRESSURE)
        sizes.append(np.hypot(*traction[:2]))
    assert max(sizes) > 0.5 * MU * PRESSURE
    if law.name != "polynomial_spring":  # without loss
        assert one.work[0] > 0.0
    assert four.work[0] == pytest.approx(count * one.work[0], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("layers", [1, 3, 4, 12])
def test_all_interfaces_stand_for_the_wraps_below_the_outermost_mid_surface(layers: int) -> None:
    """12 interfaces of 12 wraps; those in the outer half of the outermost layer carry nothing."""
    count, case = 12 / layers, roll(layers, "coil.per_wrap=true")
    slips = np.array([law.elastic_slip for law in case.interface_laws]) / 1e-6
    assert slips.sum() == pytest.approx(12 - (count - 1) / 2)
    np.testing.assert_allclose(slips[1:], count)
    assert {law.mu for law in case.interface_laws} == {0.25}


def test_one_layer_per_wrap_is_the_roll_without_per_wrap() -> None:
    plain, wraps = roll(12), roll(12, "coil.per_wrap=true")
    assert wraps.interface_laws == plain.interface_laws
    assert "per_wrap" not in plain.resolved()["coil"]


@pytest.mark.slow
def test_few_layers_are_as_soft_as_the_roll_with_all_its_wraps() -> None:
    """Elastic slip of 4 um at a low pressure: interfaces take most of the shear, friction holds the coil weakly."""
    soft = ("contact.friction.elastic_slip=4 um", "mesh.axial=3")
    exact = stuck_hz(roll(12, *soft))
    errors = {n: stuck_hz(roll(n, *soft, "coil.per_wrap=true")) / exact - 1.0 for n in (2, 4)}
    stiff = stuck_hz(roll(4, *soft)) / exact - 1.0
    assert stiff > 0.01
    assert abs(errors[4]) < 0.15 * stiff
    assert abs(errors[4]) < 0.7 * abs(errors[2]) < 0.3 * stiff


@pytest.mark.parametrize(
    ("layers", "more"),
    [
        (1, []), (3, ["contact.friction.elastic_slip=20 um"]), (3, ["coil.base=clamped"]),
        pytest.param(4, [], marks=pytest.mark.slow),
        pytest.param(3, ["coil.base=inner_edge"], marks=pytest.mark.slow),
        pytest.param(3, ["coil.margins={base: 0.03, tip: 0.02}"], marks=pytest.mark.slow),
        pytest.param(3, ["coil.total_thickness=6e-3", "winding.wrap_thickness=5e-4"], marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_the_estimate_of_the_frequency_knows_the_wrap_interfaces(layers: int, more: list[str]) -> None:
    """Found: 0.5 to 2.6 %; bonded beams are 13 to 56 % stiff where the base is not clamped."""
    case = roll(layers, "coil.per_wrap=true", *more)
    exact, bonded = stuck_hz(case), beam_frequency(roll(layers, *more), bonded=True)
    assert beam_frequency(case, bonded=True) == pytest.approx(exact, rel=0.03)
    assert bonded > (1.02 if case.coil.base == "clamped" else 1.1) * exact
    assert beam_frequency(case, bonded=False) == beam_frequency(roll(layers, *more), bonded=False)


def test_preflight_names_the_sticking_resonance() -> None:
    chirp = "excitation={kind: chirp, f_start: 160, f_end: 200, rate_oct_per_min: 2, amplitude: 5}"
    case = roll(3, "coil.per_wrap=true", "analysis=sweep", "backbone=null", chirp)
    assert f"{beam_frequency(case, bonded=True):.0f} Hz (sticking)" in " ".join(missed_resonance(case))  # type: ignore[arg-type]
    plain = roll(3, "analysis=sweep", "backbone=null", chirp)
    assert not missed_resonance(plain)  # type: ignore[arg-type]


def test_results_say_that_slip_is_the_sum_over_wrap_interfaces(tmp_path: Path) -> None:
    """Three layers of four wraps: 2.5, 4 and 4 wrap interfaces."""
    theta, z = (grid.ravel() for grid in np.meshgrid(np.linspace(0.0, np.pi, 5), np.linspace(0.01, 0.29, 4)))
    slip = 1e-6 * np.array([[5.0], [4.0], [2.0]]) * (1.0 - 0.5 * z / 0.3)
    fields = {"cumulative_slip": slip, "max_slip": 1.2 * slip, "peak_slip_hoop": 0.0 * slip, "peak_slip_axial": slip}
    points = {name: (("interface", "point"), values) for name, values in fields.items()}
    whole = {name: (("interface", "point"), np.ones_like(slip)) for name in ("slipped", "area")}
    computed = xr.Dataset({"theta_rad": ("point", theta), "z_m": ("point", z), **points, **whole})
    found = described(annotate(computed), roll(3, "coil.per_wrap=true"))
    told = summary.attributes(found) | summary.slip(found)
    assert told["wrap_interfaces"] == [2.5, 4.0, 4.0]
    for name, entry in (("max_slip", "max_relative_displacement"), ("cumulative_slip", "max_accumulated_slip")):
        largest = found[name].max("point").values
        assert told[f"{entry}_m"] == largest.max() > 0.0
        assert told[f"{entry}_per_wrap_m"] == pytest.approx((largest / [2.5, 4.0, 4.0]).max(), rel=1e-12)
        assert "wrap interfaces" in found[name].attrs["comment"]
    for number, text in ((0, "sum of 2.5 wrap interfaces"), (1, "sum of 4 wrap interfaces")):
        assert text in wf.plot.slip_map(found, number).get_title(loc="left").replace("\n", " ")
        assert text in style.figure_of(wf.plot.peak_slip_vectors(found, number)).axes[-1].get_ylabel()
    saved = load_dataset(save_dataset(found, tmp_path / "results.nc"))
    assert saved["max_slip"].attrs["comment"] == found["max_slip"].attrs["comment"]
    assert [wrap_interfaces(saved, k) for k in (0, 1)] == [2.5, 4.0]
    plain = described(computed, roll(3))
    assert wrap_interfaces(plain, 0) == 1.0
    assert "wrap_interfaces" not in summary.attributes(plain) | summary.slip(plain)
    plt.close("all")


def test_forecast_and_matrices_take_the_law_of_each_interface() -> None:
    case = roll(3, "coil.per_wrap=true")
    system = build_system(case, build_bodies(case, symmetric=True))
    for interface, law, slip in zip(system.interfaces, case.interface_laws, (2.5e-6, 4e-6, 4e-6), strict=True):
        assert interface.friction == law
        assert law.elastic_slip == pytest.approx(slip)
    plain, wraps = slip_forecast(roll(3)), slip_forecast(case)
    assert plain is not None
    assert wraps is not None
    assert 1.3 < wraps.start / plain.start < 2.0  # the root of the elastic slip, 1.6 to 2
    assert wraps.gross == plain.gross


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        (
            ["winding=null"],
            "winding: required section is missing; add it .* because coil.per_wrap: true",
        ),
        (
            ["coil.layers=13"],
            "coil.layers: more layers than wraps: .* winding.wraps = 12 / layers, got 13",
        ),
        (
            ["coil.model=bonded"],
            "coil.per_wrap: is for layers that stand for several wraps, not for model: bonded",
        ),
        (["coil.per_wrap=2"], "coil.per_wrap: must be true or false"),
    ],
)
def test_wrong_input_is_told_in_one_line(changed: list[str], told: str) -> None:
    with pytest.raises(InputError, match=told) as error:
        roll(3, "coil.per_wrap=true", "preload={kind: external_pressure, pressure: 1e4}", *changed)
    assert "\n" not in str(error.value)


def test_a_solid_coil_has_its_own_section() -> None:
    data = load_case(CONFIGS / "slipping_coil.yaml").resolved()
    data["coil"]["per_wrap"] = True
    with pytest.raises(InputError, match=r"per_wrap: .* not for model: solid, got true; .* inside: slipping"):
        build_case(data)
