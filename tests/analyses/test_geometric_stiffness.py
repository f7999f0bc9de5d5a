"""Geometric stiffness of a whole roll: contact, rigid tip, both preloads, the key of the case, and buckling."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.analyses.shared.prestress import body_pressures, prestressed_roll
from wroll_fem.case import load_case
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.errors import InputError
from wroll_fem.fem.constraints import rigid_motions
from wroll_fem.fem.eigen import solve_modes
from wroll_fem.progress import SilentProgress

COARSE = ["mesh.circumferential=12", "mesh.axial=6"]
ON = "preload.geometric_stiffness=true"
WOUND = [
    "preload={kind: winding_tension, geometric_stiffness: true}",
    "winding={tension_newton: 60, web_width: 0.3, wraps: 25, wrap_thickness: 5.0e-5, mu: 0.25, "
    "web: {E_theta: 2.8e9, nu_theta: 0.35, radial_modulus: {law: pfeiffer, K1: 1.0e3, K2: 40}}}",
]


def lab(*overrides):
    return load_case(CONFIGS / "lab_modal.yaml", [*COARSE, "modal.count=3", *overrides])


def run(case):
    return run_analysis(case, progress=SilentProgress())


def in_unknowns(bodies, nodal):
    """Unknowns of all bodies for a rigid motion (n bodies of nodal values)."""
    parts = []
    for body, values in zip(bodies, nodal, strict=True):
        E = body.expand
        parts.append(spla.spsolve((E.T @ E).tocsc(), E.T @ values))
        assert np.abs(E @ parts[-1] - values).max() < 1e-12
    return np.concatenate(parts)


@pytest.mark.parametrize("load", [["preload.pressure=1e5", ON], WOUND], ids=["external pressure", "winding tension"])
def test_rigid_rotations_of_a_free_roll_cost_no_energy(load):
    """Stresses, pressure, contact, friction and rigid tip together, on a roll that nothing holds."""
    case = lab("mandrel.base=free", "modal.interface=stuck", "mesh.circumferential=8", "mesh.axial=3", *load)
    roll = prestressed_roll(case, build_bodies(case, symmetric=False))
    system = build_system(case, roll.bodies)
    held = replace(system, stiffness=(system.stiffness + 1e-3 * system.mass).tocsr())  # the load is self-equilibrated
    state = solve_preload(held, steps=2)
    assert state.pressure.min() > 1e3
    assert np.abs(state.traction[: 2 * system.n_points]).max() > 10.0  # friction acts, too
    geometric = roll.geometric_stiffness(system, state, body_pressures(case, system))
    nodal = [rigid_motions(body.nodes, np.array([0.0, 0.0, 0.1])) for body in roll.bodies]
    motions = np.column_stack([in_unknowns(roll.bodies, [body[:, k] for body in nodal]) for k in range(6)])
    energies = np.einsum("ij,ij->j", motions, geometric @ motions)
    layer = motions[:, 5].copy()
    layer[: roll.bodies[0].n_dofs] = 0.0
    pressing = 0.04 * float(system.laws.area @ state.pressure)  # contact pressure on the radius: that of the prestress
    assert np.abs(energies).max() < 1e-10 * pressing
    # a layer that slides around the mandrel keeps its distance; friction tractions, fixed in direction, do not turn
    assert abs(layer @ geometric @ layer) < 1e-3 * pressing


def test_without_preload_nothing_changes():
    plain, stiff = (prepare(lab("modal.interface=stuck", "preload.pressure=0", *more), SilentProgress())[0]
                    for more in ([], [ON]))  # fmt: skip
    assert abs(plain.stiffness - stiff.stiffness).max() <= 1e-12 * abs(plain.stiffness).max()
    assert np.array_equal(plain.loads["preload"], stiff.loads["preload"])


def test_the_key_is_off_by_default_and_then_no_part_of_the_hash():
    """The hash of a case without the key is the one it had before the key existed."""
    plain, off, on = lab(), lab("preload.geometric_stiffness=false"), lab(ON)
    assert plain == off
    assert plain.hash() == off.hash() != on.hash()
    assert "geometric_stiffness: false" in plain.resolved_yaml()
    assert on.replace({}) == on
    assert "geometric_stiffness: true" in on.resolved_yaml()


@pytest.mark.parametrize("load", [["preload.pressure=2e5", ON], WOUND], ids=["external pressure", "winding tension"])
def test_half_of_the_roll_has_the_modes_of_the_whole(load):
    case = lab("modal.interface=stuck", "mesh.circumferential=8", "mesh.axial=2", *load)
    whole = run(case)
    system, state = prepare(case, SilentProgress())
    half = solve_modes(system.with_interface_springs(stick_springs(system, state)), system.mass, 2)[0]
    np.testing.assert_allclose(half, whole["mode_frequency"].values[[0, 2]], rtol=1e-8)
    residual = system.stiffness @ state.displacement + system.jump.T @ (system.weights * state.traction)
    np.testing.assert_allclose(residual, system.loads["preload"], atol=1e-9 * np.abs(residual).max())


@pytest.mark.slow
def test_external_pressure_softens_and_web_tension_does_not():
    """Ovalling of the stuck roll: pressure from outside compresses the rings, web tension leaves them balanced."""
    plain, pressed = (run(lab("modal.interface=stuck", "preload.pressure=2e5", *more)) for more in ([], [ON]))
    ovalling = [float(d["mode_frequency"].where(d["mode_harmonic"] == 2, drop=True)[0]) for d in (plain, pressed)]
    assert ovalling[1] < 0.9 * ovalling[0]
    assert pressed.attrs["buckling_load_factor"] > 1.0
    assert "buckling_load_factor" not in plain.attrs
    wound = run(lab("modal.interface=stuck", *WOUND))
    loose = run(lab("modal.interface=stuck", *(text.replace(", geometric_stiffness: true", "") for text in WOUND)))
    np.testing.assert_allclose(wound["mode_frequency"], loose["mode_frequency"], rtol=0.02)


def test_a_preload_above_the_buckling_load_is_refused():
    with pytest.raises(
        InputError, match=r"exceeds the linear buckling load: at 0\.\d+ times .* 3 circumferential waves"
    ):
        run(lab("modal.interface=frictionless", "preload.pressure=4e5", ON))
    with pytest.raises(InputError, match="geometric_stiffness: needs shells; a solid coil has no preload"):
        load_case(CONFIGS / "coiled_stiff.yaml", ["preload={pressure: 1.0e5, geometric_stiffness: true}"])
    with pytest.raises(InputError, match="analysis: needs shells; a solid coil has no preload, got 'buckling'; use"):
        load_case(CONFIGS / "coiled_stiff.yaml", ["analysis=buckling", "preload={pressure: 1.0e5}"])


def test_buckling_of_the_mandrel_alone_is_that_of_the_modal_analysis():
    """The frequency of the buckling mode falls to zero at the buckling pressure: f^2 is linear in the pressure."""
    alone = ["coil={model: none}", "mesh.circumferential=12", "mesh.axial=6"]
    found = run(lab("analysis=buckling", "preload.pressure=1e4", *alone))
    summary = summarise(found)
    assert summary["buckling_pressure_pa"] == pytest.approx(1e4 * summary["buckling_load_factor"])
    waves = summary["buckling_wave_number"]
    squares = []
    for share in (0.6, 0.9):
        pressure = share * summary["buckling_pressure_pa"]
        modes = run(lab("modal.count=6", f"preload.pressure={pressure}", ON, *alone))
        of_waves = modes["mode_frequency"].where(modes["mode_harmonic"] == waves, drop=True)
        squares.append(float(of_waves[0]) ** 2)
        assert modes.attrs["buckling_load_factor"] == pytest.approx(1 / share, rel=1e-6)
    zero = 0.9 + 0.3 * squares[1] / (squares[0] - squares[1])
    assert zero == pytest.approx(1.0, abs=0.01)


def test_stuck_layers_buckle_later_than_frictionless_ones():
    stuck, loose = (
        run(lab("mesh.axial=4", "analysis=buckling", f"modal.interface={kind}")).attrs["buckling_pressure_pa"]
        for kind in ("stuck", "frictionless")
    )
    assert 1.5 * loose < stuck


SHORT = [
    "analysis=dwell", "mesh.circumferential=8", "mesh.axial=2", "preload.pressure=1e5", "preload.steps=2",
    "excitation={kind: dwell, amplitude: 60.0, frequency: 150, cycles: 1, ramp_cycles: 0.5}",
    "integrator.steps_per_cycle=20",
]  # fmt: skip


@cache
def tip(method, *overrides):
    """Motion of a short dwell near resonance with slip."""
    case = load_case(CONFIGS / "lab_dwell.yaml", [*SHORT, f"solver.method={method}", *overrides])
    return run(case)["tip_displacement"].values


@pytest.mark.parametrize("method", ["condensed", pytest.param("full", marks=pytest.mark.slow)])
def test_all_methods_have_the_stiffness_of_the_preload(method):
    """The whole or the condensed structure against its reduced form, and against the one without this stiffness."""
    exact = tip(method, ON)
    largest = np.abs(exact).max()
    np.testing.assert_allclose(tip("condensed", ON), exact, atol=1e-6 * largest)
    np.testing.assert_allclose(tip("reduced", ON), exact, atol=1e-2 * largest)
    assert np.abs(tip("condensed") - exact).max() > 1e-3 * largest
