"""Equilibrium of the preloaded roll, and its ledger against work measured point by point."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from support.exact_systems import STEPPERS, stepper
from support.paths import CONFIGS

from wroll_fem.analyses.shared.assembly import build_bodies, build_system, normal_penalty
from wroll_fem.case import load_case
from wroll_fem.contact import kernels
from wroll_fem.dynamics.statics.preload import equilibrium_force, solve_preload
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import (
    CONTACT,
    FRICTION,
    INPUT,
    INTERFACE,
    KINETIC,
    MODULATION,
    NUMERICAL,
    OPEN,
    RECORDS,
    SLIPPING,
)

LAB = CONFIGS / "lab_sweep.yaml"
SMALLER = "mesh={circumferential: 8, axial: 3, grading: 1}"
FREQUENCY = 150.0  # Hz, near the resonance


@cache
def prepared(*overrides, symmetric=True):
    """Case, bodies, system and preload state of the lab roll on a small mesh."""
    case = load_case(LAB, ["mesh={circumferential: 12, axial: 4, grading: 1}", *overrides])
    bodies = build_bodies(case, symmetric=symmetric)
    system = build_system(case, bodies)
    return case, bodies, system, solve_preload(system, steps=4)


def with_mu(system, mu):
    parts = [dataclasses.replace(i, friction=dataclasses.replace(i.friction, mu=mu)) for i in system.interfaces]
    return dataclasses.replace(system, interfaces=tuple(parts))


def shaken(method, system, preload, *, cycles, steps=40, amplitude=30.0, alpha=-0.05):
    """A stepper, the base acceleration of a ramped dwell, and the step."""
    dt = 1.0 / (FREQUENCY * steps)
    time = dt * np.arange(cycles * steps + 1)
    base = amplitude * np.minimum(time * FREQUENCY / 3.0, 1.0) * np.sin(2 * np.pi * FREQUENCY * time)
    return stepper(method, system, preload, Scheme.hht(alpha), dt), base, dt


# --- preload ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("symmetric", [True, False], ids=["half", "whole"])
def test_preload_is_in_equilibrium(symmetric):
    """Every force balances; the layer, which nothing but the interface holds, gets no net axial force or moment.

    Friction is at work near the ends: the mandrel's base is held and the layer's is not.
    """
    _, bodies, system, state = prepared(symmetric=symmetric)
    load = system.loads["preload"]
    np.testing.assert_allclose(equilibrium_force(system, state), load, atol=1e-8 * np.abs(load).max())
    n, first = system.n_points, bodies[0].n_dofs
    force = (system.jump.T @ (system.weights * state.traction))[first:]
    axial = (system.weights * state.traction)[1 : 2 * n : 2]
    assert np.abs(state.traction[1 : 2 * n : 2]).max() > 100.0
    assert abs(axial.sum()) < 1e-8 * np.abs(axial).sum()
    along_x = system.influence[first:]  # a rigid motion of the layer, whose base is free
    assert abs(along_x @ force) < 1e-8 * np.abs(force).sum()
    assert abs(along_x @ load[first:]) < 1e-8 * np.abs(load).sum()


def test_rings_share_the_pressure_by_their_hoop_stiffness():
    r"""Long rings under P: hoop force p r = E t u / R with each surface's own radius, and the penalty between them.

    The mandrel (mid-radius R_m) carries p at its outer radius r, hence u_m = p r R_m / (E t)_m. The layer carries P at
    its outer radius r_P less p at its inner radius r, hence u_l = (P r_P - p r) R_l / (E t)_l. With u_l - u_m = p / k_n

    .. math:: p = P \frac{r_P R_l / (E t)_l}{r R_l / (E t)_l + r R_m / (E t)_m + 1 / k_n},

    in thin-ring terms P k_m / (k_m + k_l), k = E t / R^2. Both rings shorten by the same strain and share Poisson's
    ratio, so that they stretch alike along the axis and friction has nothing to do away from the ends.
    """
    case, _, system, state = prepared("mesh={circumferential: 12, axial: 16, grading: 1}")
    r, t_m, t_l = 0.5 * case.geometry.mandrel_outer_diameter, case.geometry.mandrel_thickness, case.coil.layer_thickness
    soft_m = (r - 0.5 * t_m) / (case.mandrel.material.E * t_m)
    soft_l = (r + 0.5 * t_l) / (case.coil.material.E * t_l)
    split = (r + t_l) * soft_l / (r * soft_l + r * soft_m + 1.0 / normal_penalty(case, case.contact.normal))
    height = system.interfaces[0].points[:, 1]
    middle = np.abs(height - 0.5 * case.geometry.length) < 0.2 * case.geometry.length
    pressure = state.pressure[middle]
    assert middle.sum() > 20
    assert pressure.mean() == pytest.approx(split * 1.0e5, rel=0.01)
    assert np.ptp(pressure) < 0.1 * pressure.mean()


@pytest.mark.parametrize("condensed", [True, False], ids=["on the interfaces", "whole structure"])
def test_frictionless_preload_needs_no_support(condensed):
    """Without friction the layer could float along the axis: no spurious force holds it, pressures are the same."""
    system = with_mu(prepared()[2], 0.0)
    state = solve_preload(system, steps=4, condensed=condensed)
    load = system.loads["preload"]
    np.testing.assert_array_equal(state.traction[: 2 * system.n_points], 0.0)
    np.testing.assert_allclose(equilibrium_force(system, state), load, atol=1e-7 * np.abs(load).max())
    rough = prepared()[3].pressure
    area = system.laws.area
    assert area @ state.pressure == pytest.approx(area @ rough, rel=0.02)


@pytest.mark.parametrize("mu", [1.0e-6, 1.0e-5, 1.0e-4])
def test_weak_friction_holds_the_preloaded_layer(mu):
    """Friction far below the least stiffness of Newton's matrix still decides where the layer rests."""
    system = with_mu(prepared("mesh={circumferential: 12, axial: 4, grading: 3}", "preload.pressure=1e3")[2], mu)
    state = solve_preload(system, steps=4)
    load = system.loads["preload"]
    np.testing.assert_allclose(equilibrium_force(system, state), load, atol=1e-7 * np.abs(load).max())
    axial = (system.weights * state.traction)[1 : 2 * system.n_points : 2]
    assert np.abs(axial).sum() > 0.0
    assert abs(axial.sum()) < 1e-2 * np.abs(axial).sum()


def test_pressure_of_the_half_is_that_of_the_whole():
    """Points of the half roll carry the same tractions; areas stand for the whole circumference."""
    half, whole = prepared()[2:], prepared(symmetric=False)[2:]
    assert half[0].laws.area.sum() == pytest.approx(whole[0].laws.area.sum(), rel=1e-10)
    points, every = half[0].interfaces[0].points, whole[0].interfaces[0].points
    for k, point in enumerate(points):
        near = np.abs(every[:, 1] - point[1]) < 1e-9
        same = near & (np.abs(np.exp(1j * every[:, 0]) - np.exp(1j * point[0])) < 1e-7)
        assert same.sum() == 1
        assert half[1].pressure[k] == pytest.approx(whole[1].pressure[same][0], rel=1e-8)


# --- dynamics ---------------------------------------------------------------------------------------------------------


def test_half_and_whole_roll_move_alike():
    """The symmetry plane of the excitation is exact: tip and ledger of both condensed runs agree."""
    results = []
    for symmetric in (True, False):
        run, base, dt = shaken("condensed", *prepared(symmetric=symmetric)[2:], cycles=3)
        results.append(run.advance(base, dt, 0.0))
    half, whole = results
    assert half[:, SLIPPING].max() > 0.05
    for column in (0, 1, 2, INPUT, FRICTION, KINETIC):
        np.testing.assert_allclose(half[:, column], whole[:, column], atol=1e-7 * np.abs(whole[:, column]).max())


@pytest.mark.parametrize(("method", "cycles"), [("full", 3), ("condensed", 30)])
@pytest.mark.parametrize("alpha", [0.0, -0.05])
def test_energy_balance_of_the_roll_closes(method, cycles, alpha):
    """Input = kinetic + strain + contact + friction + modulation + numerical at every step, under slip.

    0.5 % is asked for; the identity is exact up to Newton's tolerance, 1e-8 of the elastic slip.
    """
    roll = prepared(SMALLER) if method == "full" else prepared()
    run, base, dt = shaken(method, *roll[2:], cycles=cycles, alpha=alpha)
    records = run.advance(base, dt, 0.0)
    assert records[:, SLIPPING].max() > 0.05
    assert records[:, OPEN].max() == 0.0
    scale = records[-1, INPUT]
    assert np.abs(records[:, INPUT] - records[:, KINETIC : NUMERICAL + 1].sum(axis=1)).max() < 1e-8 * scale
    parts = records[:, FRICTION] + records[:, CONTACT] + records[:, MODULATION]
    assert np.abs(parts - records[:, INTERFACE]).max() < 1e-8 * scale
    if alpha == 0.0:
        assert np.abs(records[:, NUMERICAL]).max() < 1e-10 * scale
    assert np.all(np.diff(records[:, FRICTION]) > -1e-9 * scale)


def test_friction_of_the_ledger_is_the_area_of_all_loops():
    """Traction over relative displacement, recorded step by step at every point and integrated apart from the ledger.

    Over one cycle of a steady dwell, W times the loop areas is friction + modulation + change of elastic slip's
    energy: exactly, and the last is what the cycle is not closed by. Modulation, the exchange with a stick stiffness
    that follows the pressure, is small: the pressure of a shaken roll varies by some per cent.
    """
    _, _, system, preload = prepared()
    run, base, dt = shaken("condensed", system, preload, cycles=41)
    settled = 40 * 40
    before = run.advance(base[: settled + 1], dt, 0.0)[-1]
    jumps, tractions, slips = [run.jump.copy()], [run.traction.copy()], [run.elastic_slip.copy()]
    for k in range(settled, settled + 40):
        after = run.advance(base[k : k + 2], dt, k * dt)[-1]
        jumps.append(run.jump.copy())
        tractions.append(run.traction.copy())
        slips.append(run.elastic_slip.copy())
    jump, traction, slip = np.array(jumps), np.array(tractions), np.array(slips)
    n, area = system.n_points, system.laws.area
    mean, step = 0.5 * (traction[1:] + traction[:-1]), np.diff(jump, axis=0)
    loops = area @ (mean * step).sum(axis=0)[: 2 * n].reshape(n, 2).sum(axis=1)
    plastic = step[:, : 2 * n] - np.diff(slip, axis=0)
    rubbed = area @ (mean[:, : 2 * n] * plastic).sum(axis=0).reshape(n, 2).sum(axis=1)
    change = after - before
    friction, modulation = change[FRICTION], change[MODULATION]
    elastic = change[CONTACT] - area @ (0.5 * np.diff(traction[[0, -1], 2 * n :] ** 2, axis=0)[0] / system.laws.kn)
    assert friction > 1e-4
    assert friction == pytest.approx(rubbed, rel=1e-9)
    assert loops == pytest.approx(friction + modulation + elastic, rel=1e-9)
    assert loops == pytest.approx(friction, rel=5e-3)
    assert abs(elastic) < 1e-3 * friction
    # a steady cycle turns the work of the base into heat, all but what the scheme itself takes
    assert change[INPUT] == pytest.approx(friction + change[NUMERICAL], rel=5e-3)


def test_no_point_exceeds_its_friction_limit():
    """|tau| <= mu p with the pressure of the moment, and slip is reported where the limit is reached."""
    _, _, system, preload = prepared()
    run, base, dt = shaken("condensed", system, preload, cycles=8)
    run.advance(base, dt, 0.0)
    n, law = system.n_points, system.laws
    shear = np.hypot(*run.traction[: 2 * n].reshape(n, 2).T)
    pressure = np.maximum(0.0, -run.traction[2 * n :])
    assert np.all(shear <= law.mu * pressure * (1.0 + 1e-9))
    ratio = np.hypot(*run.elastic_slip.reshape(n, 2).T) / law.gamma
    np.testing.assert_allclose(shear, law.mu * pressure * ratio, rtol=1e-9)
    rubbed = run.slip.path > 1e-9
    assert 0.05 < np.mean(rubbed) < 0.9
    assert np.all(run.slip.peak[rubbed] > law.gamma[rubbed] * 0.5)


def test_vanishing_excitation_moves_the_roll_without_loss():
    """A millionth of the lab's excitation sticks everywhere: no friction work, tenfold motion when tenfold."""
    _, _, system, preload = prepared()
    tips = []
    for amplitude in (1e-5, 1e-4):
        run, base, dt = shaken("condensed", system, preload, cycles=4, amplitude=amplitude)
        records = run.advance(base, dt, 0.0)
        assert records[:, SLIPPING].max() == 0.0
        assert abs(records[-1, FRICTION]) < 1e-8 * records[-1, INPUT]
        assert run.slip.path.max() == 0.0
        tips.append(records[:, RECORDS.index("tip_displacement")])
    np.testing.assert_allclose(tips[1], 10.0 * tips[0], atol=1e-6 * np.abs(tips[1]).max())
    assert preload.status.max() == kernels.STICK


@pytest.mark.parametrize("method", STEPPERS)
def test_roll_repeats_bit_by_bit_from_a_snapshot(method):
    """What a checkpoint keeps is all that the future depends on."""
    system, preload = prepared(SMALLER)[2:]
    run, base, dt = shaken(method, system, preload, cycles=2, steps=20, amplitude=150.0)
    half = len(base) // 2
    run.advance(base[: half + 1], dt, 0.0)
    saved = run.snapshot()
    first = run.advance(base[half:], dt, half * dt)
    fresh = shaken(method, system, preload, cycles=2, steps=20)[0]
    fresh.restore(saved)
    np.testing.assert_array_equal(fresh.advance(base[half:], dt, half * dt), first)
    np.testing.assert_array_equal(fresh.slip.path, run.slip.path)
    assert first[:, SLIPPING].max() > 0.0
