"""Circumferential blocks and the static solver built on them, against the whole structure."""

from __future__ import annotations

import dataclasses
from functools import cache, partial

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from support.paths import CONFIGS
from support.twisted_wall import TWISTED

from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.case import load_case
from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.reduction.condensation import Condensation, condense, condense_cyclic
from wroll_fem.dynamics.reduction.cyclic_blocks import Blocks, spread
from wroll_fem.dynamics.statics.condensed import CondensedStatic
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.full import solve_static
from wroll_fem.dynamics.statics.preload import solve_load_path, solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping import condensed
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.simulate import simulate
from wroll_fem.signals.base_motion import Dwell

LAB = CONFIGS / "lab_sweep.yaml"


@cache
def roll(
    symmetric: bool = True, layers: int = 1, mesh: str = "{circumferential: 8, axial: 3, grading: 1}", *more: str
) -> System:
    case = load_case(LAB, [f"mesh={mesh}", f"coil.layers={layers}", *more])
    return build_system(case, build_bodies(case, symmetric=symmetric))


def springs_of(system: System) -> np.ndarray:
    return np.concatenate([np.full(2 * system.n_points, 3e9), system.laws.kn])


def equilibrium_error(system: System, force: np.ndarray, state: ContactState) -> float:
    internal, contact = system.stiffness @ state.displacement, system.jump.T @ (system.weights * state.traction)
    scale = np.linalg.norm(force) + np.linalg.norm(internal) + np.linalg.norm(contact)
    return float(np.linalg.norm(internal + contact - force) / scale)


@pytest.mark.parametrize(("symmetric", "layers"), [(True, 1), (False, 1), (True, 2)])
def test_blocks_carry_the_compliance_of_the_interfaces(symmetric, layers):
    assert_compliance(roll(symmetric, layers), waves=1, error=1e-9)


@pytest.mark.parametrize("layers", [1, 2])
def test_blocks_of_angle_plies_have_both_parities(layers):
    assert_compliance(roll(False, layers, "{circumferential: 8, axial: 2, grading: 1}", TWISTED), waves=2, error=1e-8)


def assert_compliance(system: System, waves: int, error: float) -> None:
    blocks = Blocks.of(system, springs_of(system))
    assert blocks is not None
    assert blocks.profiles.shape[1] == waves
    area = system.laws.area
    per_block = [
        blocks.jump(b) @ spla.spsolve(blocks.stiffness(b).tocsc(), blocks.jump(b).T.tocsc()) for b in range(len(blocks))
    ]
    compliance = spread(np.array([c.toarray() for c in per_block]), blocks.profiles, area)
    whole = spla.splu(system.with_interface_springs(springs_of(system)))
    expected = system.jump @ whole.solve(system.jump.T.toarray() * system.weights)
    np.testing.assert_allclose(compliance, expected, atol=error * np.abs(expected).max())


def by_block(values: np.ndarray, c: Condensation) -> list[np.ndarray]:
    return np.split(values, c.blocks[1:-1])


def test_modes_carry_the_compliance_of_the_interfaces():
    system = roll()
    condensation = condense_cyclic(system, springs_of(system))
    assert condensation is not None
    dense = condensation.compliance(by_block(1.0 / condensation.eigenvalues, condensation), system.laws.area)[1]
    whole = spla.splu(system.with_interface_springs(condensation.springs))
    expected = system.jump @ whole.solve(system.jump.T.toarray() * system.weights)
    np.testing.assert_allclose(dense, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("symmetric", "more", "error"), [(True, (), 1e-9), (False, (), 1e-9), (False, (TWISTED,), 1e-8)]
)
def test_tangential_springs_can_be_taken_from_the_compliance(symmetric, more, error):
    """As in a time step, with the inertia of the structure; both parities of angle plies are one block."""
    system, shift = roll(symmetric, 2, "{circumferential: 8, axial: 2, grading: 1}", *more), 1e7
    condensation = condense_cyclic(system, springs_of(system))
    assert condensation is not None
    inverse = by_block(1.0 / (condensation.eigenvalues + shift), condensation)
    blocks, _ = condensation.compliance(inverse, system.laws.area)
    dense = condensation.sliding_compliance(blocks, system.laws.area)[1]
    springs = condensation.springs.copy()
    tangentials(springs)[:] = 0.0
    whole = spla.splu((system.with_interface_springs(springs) + shift * system.mass).tocsc())
    expected = system.jump @ whole.solve(system.jump.T.toarray() * system.weights)
    np.testing.assert_allclose(dense, expected, atol=error * np.abs(expected).max())


@pytest.mark.parametrize(("moments", "slow", "fast"), [(2, 1e-5, 5e-3), (3, 1e-9, 1e-5), (4, 1e-9, 5e-9)])
def test_a_few_inertia_corrections_give_the_compliance(moments, slow, fast):
    """Against all modes: in statics, at the chirp's third harmonic, and at the weight of inertia in a time step."""
    system = roll(mesh="{circumferential: 12, axial: 4, grading: 1}")
    every, few = (condense_cyclic(system, springs_of(system), m) for m in (0, moments))
    assert every is not None
    assert few is not None
    assert few.moments == moments
    # loads along the surface at both heights of a row of cells and normal ones at its borders: an eighth per moment
    assert len(few.eigenvalues) < (0.05 + 0.125 * moments) * len(every.eigenvalues)
    for shift, error in ((0.0, 1e-10), (-((2 * np.pi * 525.0) ** 2), slow), (2e8, fast)):
        a, b = (c.compliance(by_block(1.0 / (c.eigenvalues + shift), c), system.laws.area)[1] for c in (every, few))
        np.testing.assert_allclose(b, a, atol=error * np.abs(a).max(), rtol=0)
        a, b = (c.tip @ (c.base / (c.eigenvalues + shift)) for c in (every, few))
        assert b == pytest.approx(a, rel=error)


def test_a_slipping_dwell_needs_few_inertia_corrections(monkeypatch):
    system = roll()
    preload = solve_preload(system)
    run = partial(simulate, system, preload, Dwell(60.0, 150.0, 6, 2), dt=1 / 6000, scheme=Scheme.hht(-0.05))
    every = run()
    monkeypatch.setattr(condensed, "condense", partial(condense, moments=4))
    few = run()
    assert float(every["slipping_fraction"].max()) > 0.05
    for name in ("tip_displacement", "friction_energy"):
        a = every[name].values
        np.testing.assert_allclose(few[name].values, a, atol=2e-5 * np.abs(a).max(), rtol=0)
    assert not np.array_equal(few["tip_displacement"].values, every["tip_displacement"].values)


@pytest.mark.parametrize(("symmetric", "layers"), [(True, 1), pytest.param(False, 2, marks=pytest.mark.slow)])
def test_sideways_push_with_slip_agrees_with_the_whole_structure(symmetric, layers):
    """Pressure, then a transverse acceleration of the base that makes part of the interface slip, then back."""
    system = roll(symmetric, layers, "{circumferential: 8, axial: 2, grading: 1}")
    push = system.mass @ system.influence * 400.0
    forces = [0.5 * system.loads["preload"], system.loads["preload"]]
    forces += [system.loads["preload"] + share * push for share in (0.5, 1.0, -0.3)]
    solver = CondensedStatic.of(system, 5e4)
    whole = solve_load_path(system, forces)
    blocks = solve_load_path(system, forces, condensed=solver)
    assert 0.02 < np.mean(whole[3].status == 1) < 1.0
    for a, b in zip(whole, blocks, strict=True):
        np.testing.assert_array_equal(a.status, b.status)
        np.testing.assert_allclose(b.traction, a.traction, atol=1e-6 * np.abs(a.traction).max())
        np.testing.assert_allclose(b.displacement, a.displacement, atol=1e-6 * np.abs(a.displacement).max())


@pytest.mark.parametrize(("symmetric", "layers"), [(True, 1), (False, 2)])
def test_one_point_stands_for_its_row_under_pressure(symmetric, layers):
    """Ring unknowns alone and all points give the same state; only blocks of harmonic 0 are factored."""
    system = roll(symmetric, layers)
    force = system.loads["preload"]
    solver = CondensedStatic.of(system, 5e4)
    assert solver is not None
    ring = solve_load_path(system, [0.5 * force, force], condensed=solver)[-1]
    assert {system.subspaces[b].harmonic for b in solver._factors} == {0}
    every = CondensedStatic.of(system, 5e4)
    assert every is not None
    every.__dict__["_even_around"] = None
    points = solve_load_path(system, [0.5 * force, force], condensed=every)[-1]
    np.testing.assert_array_equal(ring.status, points.status)
    for name in ("jump", "elastic_slip", "traction"):
        a, b = getattr(ring, name), getattr(points, name)
        np.testing.assert_allclose(a, b, atol=1e-8 * np.abs(b).max(), err_msg=name)
    apart = ring.displacement - points.displacement  # by energy: rounding moves single soft unknowns by 1e-8
    energy = [u @ (system.stiffness @ u) for u in (apart, points.displacement)]
    assert energy[0] < 1e-16 * energy[1]
    assert equilibrium_error(system, force, ring) < 1e-9


@pytest.mark.slow
def test_a_hard_first_step_descends_on_the_potential():
    """A soft coil pressed at once; the norm of the residual stalls, and hoop motion has no compliance."""
    case = load_case(
        CONFIGS / "sspp_friction.yaml",
        ["coil.material.E=1e9", "preload.pressure=1e6", "mesh={circumferential: 12, axial: 8, radial: 3, grading: 20}"],
    )
    system = build_system(case, build_bodies(case, symmetric=True))
    force, start = 0.1 * system.loads["preload"], ContactState.unloaded(system)
    solver = CondensedStatic.of(system, 5e4)
    assert solver is not None
    found, whole = solver(force, start), solve_static(system, force, start)
    np.testing.assert_array_equal(found.status, whole.status)
    np.testing.assert_allclose(found.traction, whole.traction, atol=1e-7 * np.abs(whole.traction).max())


def test_a_state_that_is_not_even_around_uses_every_point():
    system = roll()
    solver = CondensedStatic.of(system, 5e4)
    assert solver is not None
    force = system.loads["preload"]
    loaded = solver(force, ContactState.unloaded(system))
    assert solver._is_even(force, loaded)
    slipped = loaded.elastic_slip.copy()
    slipped[1] *= 0.5  # one point's axial elastic slip
    assert not solver._is_even(force, dataclasses.replace(loaded, elastic_slip=slipped))
    assert not solver._is_even(force + 1e-6 * system.mass @ system.influence, loaded)
    stirred = solver(force, dataclasses.replace(loaded, elastic_slip=slipped))
    assert equilibrium_error(system, force, stirred) < 1e-9
    assert np.ptp(stirred.traction[1 : 2 * solver.blocks.area.shape[1] : 2]) > 0.0  # axial, first row


def test_coupled_harmonics_have_no_blocks():
    system = roll()
    bumped = system.mass.tolil()
    bumped[0, 0] *= 1.5
    assert Blocks.of(dataclasses.replace(system, mass=bumped.tocsr()), springs_of(system)) is None
    assert CondensedStatic.of(dataclasses.replace(system, mass=bumped.tocsr()), 1e5) is None


def test_stuck_springs_of_a_pressed_roll_are_level():
    system = roll()
    solver = CondensedStatic.of(system, 5e4)
    assert solver is not None
    springs = stick_springs(system, solver(system.loads["preload"], ContactState.unloaded(system)))
    blocks = Blocks.of(system, springs)
    assert blocks is not None
    np.testing.assert_allclose(blocks.springs, springs, rtol=1e-14)
