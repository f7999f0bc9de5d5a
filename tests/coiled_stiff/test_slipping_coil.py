"""Coil whose wraps slide: friction at a point, limits, similarity, energy, and the analysis."""

from __future__ import annotations

import warnings
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from scipy.constants import g as GRAVITY
from scipy.integrate import trapezoid
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses import slip_damping, slip_path
from wroll_fem.analyses.shared.assembly import build_bodies
from wroll_fem.case import load_case
from wroll_fem.coiled_stiff.shear_points import ShearPoints, radial_stress
from wroll_fem.coiled_stiff.slipping_coil import slipping_system
from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.reduction.condensation import condense
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import ModalPath, first_slip, modal_path
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.training.enrichment import trained_backbone
from wroll_fem.errors import InputError
from wroll_fem.fem.eigen import DEFAULT_SHIFT, solve_pairs
from wroll_fem.plotting import style
from wroll_fem.plotting.slip_work import slip_onset_g

CASE = CONFIGS / "slipping_coil.yaml"
FINE = "mesh={circumferential: 8, axial: 8, grading: 20, radial: 2}"
LAMINA = "coil.material={kind: lamina, E_1: 1e9, E_2: 1e9, nu_12: 0.3, G_12: 1e8, G_23: 1e8, rho: 1e3}"
COARSE = "mesh={circumferential: 8, axial: 4, grading: 8, radial: 2}"  # for claims that hold on any mesh
MODULUS, MU = 1e9, 0.48


@cache
def coil(factor: float = 1.0, mesh: str = COARSE) -> tuple[System, ContactState, ShearPoints]:
    """The roll of the case with a pressure that falls outwards, times ``factor``."""
    (body,) = build_bodies(load_case(CASE, [mesh]), symmetric=True)
    assert body.solid is not None
    points = ShearPoints.of(body.solid).half()
    r = points.points[:, 2]
    pressure = factor * (5e6 - 4e6 * (r - r.min()) / np.ptp(r))
    return *slipping_system(body, points, shear_modulus=MODULUS, pressure=pressure, mu=MU, wrap_thickness=5e-5), points


def mode_of(path: LoadPath) -> np.ndarray:
    mode = path.stuck(path.system.mass @ path.system.influence)
    for _ in range(20):
        mode = path.stuck(path.system.mass @ mode)
        mode /= np.sqrt(mode @ (path.system.mass @ mode))
    return mode


@cache
def followed(factor: float = 1.0, tolerance: float = 1e-3) -> tuple[LoadPath, ModalPath]:
    system, state, _ = coil(factor)
    path = LoadPath(system, state, tolerance=tolerance)
    return path, modal_path(path, mode_of(path), np.geomspace(1.0, 10.0, 12), keep=True)


def test_shear_at_a_point_has_stiffness_limit_and_loop_of_the_law() -> None:
    """Displacements to and fro: every point has its own shear along a fixed direction, below or above its limit."""
    system, state, points = coil()
    limit = MU * state.pressure
    u = np.random.default_rng(5).standard_normal(system.n_dofs)
    (body,) = build_bodies(load_case(CASE, [COARSE]), symmetric=True)
    assert body.solid is not None
    strain = (points.strain @ body.solid.expand @ u).reshape(-1, 2)
    share = 2.0 * np.median(limit / (MODULUS * np.linalg.norm(strain, axis=1)))
    u, strain = share * u, share * strain
    size = np.linalg.norm(strain, axis=1)
    trial, at, plastic = TrialContact(system), state, []
    for factor in (1.0, -1.0, 1.0):
        jump = state.jump + factor * (system.jump @ u)
        tau = tangentials(trial(jump, at)).copy()
        at = trial.committed(factor * u, jump)
        np.testing.assert_allclose(
            tau, factor * strain / size[:, None] * np.minimum(MODULUS * size, limit)[:, None], rtol=1e-10
        )
        plastic.append(factor * strain - tau / MODULUS)
    slides = size > limit / MODULUS
    assert 0.2 < slides.mean() < 0.9
    loop = sum(limit * np.linalg.norm(b - a, axis=1) for a, b in pairwise(plastic))
    exact = np.where(slides, 4.0 * limit * (size - limit / MODULUS), 0.0)
    np.testing.assert_allclose(loop, exact, atol=1e-10 * exact.max())


def test_without_slip_it_is_the_stiff_coil() -> None:
    """The shear stiffness at 2 x 2 x 2 points in place of the rule of the elements changes the frequency by 0.1 %."""
    system, state, _ = coil(mesh=FINE)
    path, case = LoadPath(system, state, tolerance=1e-3), load_case(CASE, [FINE])
    found = modal_path(path, mode_of(path), [1.0, 3.0])
    solid = case.coil.model_copy(update={"inside": "stiff"})
    (stiff,) = build_bodies(case.model_copy(update={"coil": solid}), symmetric=True)
    mode = mode_of(path)
    hertz = np.sqrt(mode @ (path.stiffness @ mode)) / (2.0 * np.pi)
    exact = np.sqrt(solve_pairs(stiff.stiffness, stiff.mass, 1, sigma=DEFAULT_SHIFT).values[0]) / (2.0 * np.pi)
    assert hertz == pytest.approx(exact, rel=1e-3)
    assert found.slip_work[0] == pytest.approx(0.0, abs=1e-12 * found.slip_work[-1])
    assert found.frequency[0] == pytest.approx(2.0 * np.pi * hertz, rel=2e-3)


def test_twice_the_pressure_is_the_same_path_at_twice_the_amplitude() -> None:
    one, two = followed(1.0)[1], followed(2.0)[1]
    np.testing.assert_allclose(two.amplitude, 2.0 * one.amplitude, rtol=1e-6)
    np.testing.assert_allclose(two.dissipation, 4.0 * one.dissipation, rtol=1e-6, atol=1e-9 * one.dissipation[-1])
    np.testing.assert_allclose(two.frequency, one.frequency, rtol=1e-6)


def test_loop_area_slip_work_and_a_direct_cycle_agree() -> None:
    path, found = followed(tolerance=3e-4)
    twice = found.force >= 2.0 * found.force[0]
    np.testing.assert_allclose(found.loop_area[twice], found.dissipation[twice], rtol=0.01)
    system, mode = path.system, mode_of(path)
    inertia, before = system.mass @ mode, path.state
    steps = found.force[-1] * np.cos(np.linspace(0.0, 2.0 * np.pi, 81))[1:]
    work, q = 0.0, [found.amplitude[-1]]
    for alpha in steps:
        state = path.to(alpha * inertia)
        slip = tangentials(state.jump - before.jump) - (state.elastic_slip - before.elastic_slip).reshape(-1, 2)
        work += float(system.laws.area @ (tangentials(state.traction) * slip).sum(axis=1))
        q.append(float(inertia @ (state.displacement - path.start.displacement)))
        before = state
    assert work == pytest.approx(found.dissipation[-1], rel=0.01)
    area = trapezoid(np.append(found.force[-1], steps), q)
    assert abs(area) == pytest.approx(found.dissipation[-1], rel=0.01)
    assert q[-1] == pytest.approx(q[0], rel=1e-3)


def test_error_estimate_bounds_the_change_in_a_richer_basis() -> None:
    rough, fine = followed()[1], followed(tolerance=1e-5)[1]
    assert 0.0 < rough.error.max() <= 1e-3
    np.testing.assert_allclose(rough.amplitude, fine.amplitude, rtol=2e-4)
    np.testing.assert_allclose(rough.dissipation, fine.dissipation, rtol=0.01, atol=1e-3 * fine.dissipation[-1])


def test_first_slip_is_where_the_first_point_reaches_its_limit() -> None:
    system, state, _ = coil()
    path = LoadPath(system, state)
    load = system.mass @ mode_of(path)
    factor = first_slip(path, load)
    for share, slides in ((0.999, False), (1.01, True)):
        reached = LoadPath(system, state).to(share * factor * load)
        at_limit = np.linalg.norm(tangentials(reached.traction), axis=1) >= MU * state.pressure * (1.0 - 1e-9)
        assert at_limit.any() == slides


@pytest.mark.slow  # 60 s: harmonic balance with friction at every point of the coil
def test_the_path_is_the_nonlinear_mode_of_harmonic_balance() -> None:
    """The same system by the machinery of the layered rolls, seven harmonics, on a coarse mesh."""
    coarse = load_case(CASE, ["mesh={circumferential: 8, axial: 5, grading: 12, radial: 2}"])
    (body,) = build_bodies(coarse, symmetric=True)
    assert body.solid is not None
    points = ShearPoints.of(body.solid).half()
    r = points.points[:, 2]
    pressure = 5e6 - 4e6 * (r - r.min()) / np.ptp(r)
    system, state = slipping_system(body, points, shear_modulus=MODULUS, pressure=pressure, mu=MU, wrap_thickness=5e-5)
    path = LoadPath(system, state)
    mode = mode_of(path)
    found = modal_path(path, mode, np.geomspace(1.0, 10.0, 12))
    tip = abs(float(system.probes["tip"] @ mode)) * found.amplitude
    modes = condense(system, path.springs, Scheme.hht(0.0), 1e-4)
    reach = (0.9 * tip[0], 1.05 * tip[-1])
    exact = trained_backbone(modes, state, system.laws, tip_amplitudes=reach, harmonics=7).curve
    np.testing.assert_allclose(found.frequency, np.interp(tip, exact.tip, exact.frequencies), rtol=2.5e-3)
    slips = found.damping > 0.01
    assert slips.sum() >= 9
    np.testing.assert_allclose(found.damping[slips], np.interp(tip, exact.tip, exact.damping)[slips], rtol=0.025)


@cache
def result() -> xr.Dataset:
    return wf.run(load_case(CASE, [COARSE]), progress=False)


@cache
def still() -> xr.Dataset:
    """The same roll at a level at which nothing slides."""
    return wf.run(load_case(CASE, [COARSE, "excitation.amplitude_g=[0.01]"]), progress=False)


def test_analysis_gives_response_per_level_with_the_prediction_without_slip() -> None:
    found = result()
    tip, linear = found["tip_at_level"].values, found["tip_at_level_without_slip"].values
    assert np.all(tip <= linear * (1.0 + 1e-9))
    assert np.all(np.diff(tip) > 0.0)
    assert tip[-1] < 0.5 * linear[-1]
    # the base works as much as damping dissipates
    base, q_tip = found["resonant_base_acceleration"].values, found["tip_amplitude"].values
    dissipated = found["friction_work_per_cycle"] + found["material_damping_work_per_cycle"]
    per_tip = dissipated.values[0] / (base[0] * q_tip[0])
    np.testing.assert_allclose(dissipated, per_tip * base * q_tip, rtol=0.015)  # the shape changes
    # a dashpot: its damping ratio grows as the frequency falls
    dashpot = 0.02 * found.attrs["f_stuck_hz"] / found["resonance_frequency"]
    np.testing.assert_allclose(found["material_modal_damping"], dashpot, rtol=1e-9)
    np.testing.assert_allclose(found["modal_damping"], found["friction_modal_damping"] + dashpot, rtol=1e-9)
    worked = float((found["slip_work_density"] * found["volume"]).sum())
    assert worked == pytest.approx(float(found["friction_work_per_cycle"][-1]), rel=1e-9)
    for name in ("rt", "rz"):
        at_points = float((found[f"slip_work_density_{name}"] * found["volume"]).sum())
        assert at_points == pytest.approx(float(found[f"friction_work_{name}_per_cycle"][-1]), rel=1e-9)
        assert at_points > 0.1 * worked
    np.testing.assert_allclose(
        found["friction_work_rt_per_cycle"] + found["friction_work_rz_per_cycle"], found["friction_work_per_cycle"],
        rtol=1e-9,
    )  # fmt: skip
    np.testing.assert_allclose(
        found["slip_work_density_rt"] + found["slip_work_density_rz"], found["slip_work_density"], rtol=1e-12
    )
    assert found["volume"].sum() == pytest.approx(np.pi * (0.025**2 - 0.01**2) * 0.3, rel=1e-3)
    slipping = found["slipping_volume_fraction"].values
    assert slipping[0] == 0.0
    assert np.all(np.diff(slipping) >= 0.0)


def test_levels_between_the_loads_are_interpolated() -> None:
    """Also between the first load, at which nothing slides yet, and the second."""
    base, tip = (result()[name].values for name in ("resonant_base_acceleration", "tip_amplitude"))
    levels = (np.array([base[0] + 0.3 * (base[1] - base[0]), base[1], base[5]]) / GRAVITY).tolist()
    at = wf.run(load_case(CASE, [COARSE, f"excitation.amplitude_g={levels}"]), progress=False)["tip_at_level"].values
    assert tip[0] < at[0] < tip[0] + 0.5 * (tip[1] - tip[0])
    # rounding of the assembly, 3e-16 from run to run, becomes 2e-7 within the tolerance of the states
    np.testing.assert_allclose(at[1:], tip[[1, 5]], rtol=2e-6)


def test_the_summary_has_damping_and_slip_work_per_level() -> None:
    found = result()
    told = slip_damping.slip_damping_summary(found)
    tip, at = found["tip_amplitude"].values, found["tip_at_level"].values
    work = np.array(told["slip_work_per_cycle_j"])
    # straight lines between the loads, not near the first slip
    np.testing.assert_allclose(work[1:], np.interp(at, tip, found["friction_work_per_cycle"])[1:], rtol=0.03)
    by_direction = np.add(told["slip_work_rt_per_cycle_j"], told["slip_work_rz_per_cycle_j"])
    np.testing.assert_allclose(by_direction, work, rtol=0.01)
    # what the dashpot adds grows as the frequency falls
    dashpot = np.subtract(told["zeta_total"], told["zeta_friction"])
    np.testing.assert_allclose(dashpot, 0.02 * found.attrs["f_stuck_hz"] / found["frequency_at_level"], rtol=2e-3)
    share = np.array(told["slipping_volume_fraction"])
    assert np.all(np.diff(share) > 0.0)
    assert share[-1] == pytest.approx(np.interp(at[-1], tip, found["slipping_volume_fraction"]), rel=0.05)
    assert slip_damping.slip_damping_summary(still())["slip_work_per_cycle_j"] == [0.0]


def test_low_levels_have_the_response_without_slip() -> None:
    found = still()
    assert found["tip_at_level"].values == pytest.approx(found["tip_at_level_without_slip"].values, rel=1e-12)
    assert found["damping_at_level"].values == pytest.approx(0.02)
    assert "no slip" in slip_damping.statement(found)
    wf.plot.slip_damping(found)


def test_slip_work_is_drawn_where_it_is_done() -> None:
    found = result()
    onset = slip_onset_g(found)
    slid = found["slip_work_density"].values > 1e-9 * float(found["slip_work_density"].max())
    assert 0.0 < slid.mean() < 1.0
    np.testing.assert_array_equal(np.isfinite(onset), slid)
    assert onset.min() == pytest.approx(float(found["resonant_base_acceleration"][1]) / GRAVITY)  # the second load
    zone = wf.plot.slip_work(found)
    figure = style.figure_of(zone)
    assert [ax.get_ylabel() for ax in figure.axes[:3]] == [
        "Height above the base (mm)", "Height above the base (mm)", "Share of the slip work (%)"
    ]  # fmt: skip
    around = 100.0 * found["friction_work_rt_per_cycle"][-1] / found["friction_work_per_cycle"][-1]
    title = figure.axes[1].get_title(loc="left").replace("\n", " ").replace("\u00a0", " ")
    assert f"{float(around):.0f} % of the work around the roll" in title
    for line in figure.axes[2].lines:
        share = line.get_ydata()
        assert share[0] == 0.0
        assert share[-1] == pytest.approx(100.0)
        assert np.all(np.diff(share) >= 0.0)


def test_without_slip_the_slip_work_is_an_empty_map() -> None:
    found = result()
    stuck = found.assign(
        slip_work_density=0.0 * found["slip_work_density"],
        tip_amplitude_at_slip=np.nan * found["tip_amplitude_at_slip"],
    )
    assert "0 % of the volume" in wf.plot.slip_work(stuck).get_title(loc="left").replace("\u00a0", " ")


def test_levels_beyond_the_path_have_no_result(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slip_path, "MOST_LEVELS", 3)
    with pytest.warns(UserWarning, match="higher levels have no result"):
        found = wf.run(load_case(CASE, [COARSE, "excitation.amplitude_g=[0.5, 15]"]), progress=False)
    assert np.isfinite(found["tip_at_level"].values).tolist() == [True, False]
    assert "0.5 g" in slip_damping.statement(found)


def test_radial_stress_of_a_uniform_strain_is_that_of_the_material() -> None:
    """Displacements a r along r and c z along z: strains a, a and c."""
    case = load_case(CASE, [COARSE])
    (body,) = build_bodies(case, symmetric=True)
    assert body.solid is not None
    stiffness, (a, c) = case.coil.solid().stiffness(), (1e-3, -4e-3)
    found = radial_stress(body.solid, stiffness) @ (body.solid.nodes * [a, a, c]).ravel()
    expected = stiffness[0, :3] @ [a, a, c]
    np.testing.assert_allclose(found, expected, rtol=2e-3)  # the circle is made of quadratic edges


def test_a_strong_change_of_the_pressure_is_told() -> None:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        low = wf.run(load_case(CASE, [COARSE, "excitation.amplitude_g=[5]"]), progress=False)
    assert not any("radial stress" in str(warning.message) for warning in told)
    with pytest.warns(UserWarning, match=r"radial stress of the motion exceeds 50 % of the pressure .* at most\)"):
        high = wf.run(load_case(CASE, [COARSE, "excitation.amplitude_g=[30]"]), progress=False)
    change = high["pressure_change_max"].values
    assert change[0] == 0.0  # nothing slides yet
    # while little slides, the motion is proportional to the load
    assert np.all(np.diff(change[1:]) > 0.0)
    share = high["pressure_change_volume_fraction"].values
    assert np.all((share > 0.0) == (change > 0.5))
    np.testing.assert_allclose(low["pressure_change_max"], change[: low.sizes["tip_amplitude"]], rtol=1e-6)


def test_a_clamped_coil_does_not_slip_at_moderate_levels() -> None:
    found = wf.run(load_case(CASE, [COARSE, "coil.base=clamped", "excitation.amplitude_g=[5]"]), progress=False)
    assert found["damping_at_level"].values == pytest.approx(0.02, rel=1e-12)
    assert "no slip that matters up to 5 g" in slip_damping.statement(found)


def test_a_mode_without_most_of_the_mass_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slip_damping, "LEAST_SHARE", 0.9)
    with pytest.warns(UserWarning, match=r"carries 6\d % of the mass, so that bending is not its main motion"):
        wf.run(load_case(CASE, [COARSE, "excitation.amplitude_g=[0.01]"]), progress=False)


def test_the_tip_motion_of_the_levels_alone_is_judged_by_small_displacement_theory() -> None:
    soft = ["coil.material.G_r_theta=1e5", "coil.thickness=0.03", "winding.wraps=600", "excitation.amplitude_g=[0.001]"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "the mesh does not resolve")  # it is coarse
        found = wf.run(load_case(CASE, [COARSE, *soft]), progress=False)
    assert found["tip_at_level"].values[0] < 1e-4 < 0.1 < found["tip_amplitude"].values[0]


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (["coil.inside=stiff"], "coil.inside"),
        (["analysis=modal_transient"], "coil.inside"),
        (["coil.material.G_r_z=2e9"], "the limit would be an ellipse"),
        (["coil.model=layers"], "coil"),
        (["excitation.frequency=90"], "excitation.frequency"),
        (["mesh.discretisation=fourier"], "mesh.discretisation"),
        (["winding.mu=0"], "winding.mu"),
        (["winding=null"], "winding: required section is missing; add it"),
        (
            [
                "coil.interface=friction",
                "contact={friction: {mu: 0.3, elastic_slip: 1e-6}}",
                "preload={kind: winding_stress}",
            ],
            "coil.interface",
        ),
        (
            ["coil.material={kind: lamina, E_1: 1e9, E_2: 1e9, nu_12: 0.3, G_12: 1e8, G_23: 1e8, rho: 1e3}"],
            "material.kind",
        ),
    ],
)
def test_wrong_cases_are_refused_in_one_line(changed: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said) as error:
        load_case(CASE, [COARSE, *changed])
    assert "\n" not in str(error.value)


def test_a_coil_without_pressure_is_refused() -> None:
    _, state, points = coil()
    (body,) = build_bodies(load_case(CASE, [COARSE]), symmetric=True)
    with pytest.raises(InputError, match="friction capacity between the wraps is 0 Pa"):
        slipping_system(body, points, shear_modulus=MODULUS, pressure=0.0 * state.pressure, mu=MU, wrap_thickness=5e-5)
