"""Cycles followed load by load: against the closed form of a point whose pressure varies, and against Masing's rule."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from wroll_fem.contact.elastic_coulomb import ElasticCoulomb
from wroll_fem.contact.interface import Interface, NormalPenalty
from wroll_fem.contact.kernels import OPEN, SLIP, STICK
from wroll_fem.contact.point import contact_dofs
from wroll_fem.dynamics.statics import load_path
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.cycle_path import CyclePath, cycle_path
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import first_slip, modal_path
from wroll_fem.dynamics.system.system import System

MASS, STIFFNESS, SPRING, MU, PRESSURE = 2.0, 1e4, 5e3, 0.3, 10.0
SHAPE, AREA = np.array([MASS**-0.5]), 1.0


def point(rate: float) -> LoadPath:
    """Mass on a spring with one point of friction, whose pressure is P - ``rate`` u."""
    interface = Interface(
        "point", sp.csr_matrix([[0.0], [1.0], [0.0]]), np.array([AREA]), np.zeros((1, 3)),
        ElasticCoulomb(MU, 1e-3, SPRING), NormalPenalty(1e6, True),
    )  # fmt: skip
    matrices = (sp.csr_matrix([[STIFFNESS]]), sp.csr_matrix([[MASS]]), np.ones(1))
    system = System(*matrices, interfaces=(interface,), probes={"tip": np.ones(1)})
    start = ContactState.unloaded(system)
    normal = contact_dofs(1)[:, 2]
    start.jump[normal], start.traction[normal] = -PRESSURE / 1e6, -PRESSURE
    return LoadPath(system, start, tolerance=1e-10, stress=sp.csr_matrix([[rate]]))


def exact(force: float, rate: float) -> tuple[float, float]:
    """Half the range of the displacement in a steady cycle between +-``force``, and the energy it dissipates.

    The point slides at the ends, or is open at the upper one. In between it sticks after each end.
    """
    s = MU * rate
    upper, lower = (force - MU * PRESSURE) / (STIFFNESS - s), (force - MU * PRESSURE) / (STIFFNESS + s)
    opens = PRESSURE / rate if rate else np.inf
    upper = force / STIFFNESS if upper > opens else upper

    def limit(u: float) -> float:
        return MU * max(0.0, PRESSURE - rate * u)

    def integral(low: float, high: float) -> float:
        return MU * (PRESSURE * (high - low) - 0.5 * rate * (high**2 - low**2))

    down = min(opens, (SPRING * upper - limit(upper) - MU * PRESSURE) / (SPRING - s))
    up = (MU * PRESSURE + limit(-lower) - SPRING * lower) / (SPRING + s)
    end = min(upper, opens)
    work = (1.0 - s / SPRING) * integral(-lower, down) + (1.0 + s / SPRING) * integral(up, end)
    return 0.5 * (upper + lower), work


def loaded(rate: float, force: float, steps: int) -> CyclePath:
    path = point(rate)
    first = first_slip(path, path.system.mass @ SHAPE) * float(path.system.mass[0, 0]) * SHAPE[0]
    return cycle_path(path, SHAPE, [force / first], steps=steps, keep=True)


@pytest.mark.parametrize(("rate", "force"), [(0.0, 12.0), (2e3, 12.0), (-2e3, 12.0), (8e3, 12.0), (8e3, 40.0)])
def test_a_point_whose_pressure_varies_has_the_closed_form_of_its_cycle(rate: float, force: float) -> None:
    """Its upper end is closed, or open where rate u exceeds the pressure; the sign of the rate mirrors the cycle."""
    found = loaded(rate, force, 64)
    amplitude, work = exact(force, abs(rate))
    assert found.force[0] * SHAPE[0] * MASS == pytest.approx(force, rel=1e-12)
    assert found.amplitude[0] / SHAPE[0] / MASS == pytest.approx(amplitude, rel=1e-9)
    assert found.closure[0] < 1e-9
    # exact while it is closed; it opens within a step
    assert found.dissipation[0] == pytest.approx(work, rel=1e-9 if force == 12.0 else 3e-4)
    assert found.loop_area[0] == pytest.approx(work, rel=3e-4)
    np.testing.assert_allclose(found.dissipation_by_component, [[found.dissipation[0], 0.0]], rtol=1e-12)
    assert found.states[0].status[0] == SLIP


def test_halved_steps_reduce_the_error_of_the_dissipation() -> None:
    """A point that opens; the default is sixteen steps."""
    work = exact(40.0, 8e3)[1]
    errors = [abs(loaded(8e3, 40.0, steps).dissipation[0] / work - 1.0) for steps in (8, 16, 64)]
    assert errors[0] < 0.01
    assert errors[1] < 0.5 * errors[0]
    assert errors[2] < 0.1 * errors[1]


def test_first_slip_counts_the_change_of_the_pressure() -> None:
    path = point(2e3)
    factor = first_slip(path, np.ones(1))
    for share, slides in ((-0.999, False), (0.999, False), (1.001, True)):
        state = point(2e3).to(np.array([share * factor]))
        assert (state.status[0] == SLIP) == slides
    assert factor < first_slip(point(0.0), np.ones(1))


def test_at_constant_pressure_cycles_follow_the_rule_of_masing() -> None:
    levels = np.geomspace(0.5, 6.0, 7)
    masing = modal_path(point(0.0), SHAPE, np.geomspace(0.5, 6.0, 61))
    found = cycle_path(point(0.0), SHAPE, levels, steps=64)
    np.testing.assert_allclose(found.amplitude, masing.amplitude[::10], rtol=1e-9)
    np.testing.assert_allclose(found.frequency, masing.frequency[::10], rtol=5e-4)
    np.testing.assert_allclose(found.dissipation, masing.dissipation[::10], rtol=2e-3, atol=1e-9)


def test_levels_can_be_added_to_cycles() -> None:
    levels, path = [0.9, 2.0, 3.0, 4.0], point(2e3)
    whole = cycle_path(point(2e3), SHAPE, levels)
    found = cycle_path(path, SHAPE, levels[:2])
    found = found.joined(cycle_path(path, SHAPE, levels[2:], after=found))
    for name in ("amplitude", "force", "dissipation", "frequency", "closure", "loop_area"):
        np.testing.assert_allclose(getattr(found, name), getattr(whole, name), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(found.dissipation_by_point, whole.dissipation_by_point, rtol=1e-12)
    with pytest.raises(ValueError, match="at least one level"):
        cycle_path(path, SHAPE, [])


def test_a_point_without_pressure_is_open_and_closes_again() -> None:
    path = point(8e3)
    for force, status in ((40.0, OPEN), (-12.0, SLIP), (-11.9, STICK), (40.0, OPEN)):
        state = path.to(np.array([force]))
        assert state.status[0] == status
        assert (state.pressure[0] == 0.0) == (status == OPEN)


def test_the_matrix_of_newton_is_the_derivative_of_the_residual() -> None:
    """Two points whose pressures depend on both displacements; one slides, the other one is open."""
    operator = sp.csr_matrix([[0.0, 0.0], [1.0, 0.2], [0.0, 0.3], [0.0, 0.0], [0.1, 1.0], [0.4, 0.0]])
    interface = Interface(
        "points", operator, np.array([1.0, 0.5]), np.zeros((2, 3)), ElasticCoulomb(MU, 1e-3, SPRING),
        NormalPenalty(1e6, True),
    )  # fmt: skip
    stiffness, mass = sp.csr_matrix([[1e4, -2e3], [-2e3, 8e3]]), sp.identity(2, format="csr")
    system = System(stiffness, mass, np.ones(2), interfaces=(interface,), probes={"tip": np.ones(2)})
    start = ContactState.unloaded(system)
    normal = contact_dofs(2)[:, 2]
    start.jump[normal], start.traction[normal] = -PRESSURE / 1e6, -PRESSURE
    path = LoadPath(system, start, tolerance=1e-10, stress=sp.csr_matrix([[1e3, 5e2], [2e3, 6e3]]))
    for column in np.eye(2):
        path.add(path.stuck(column))
    problem, x = load_path._InBasis(path, np.array([10.0, 30.0]), 0.0), path.forces @ np.array([1.5e-3, 2.5e-3])
    r, _ = problem.residual(x)
    assert path.trial.status.tolist() == [SLIP, OPEN]
    step = problem.linearise(x)(r)
    h = 1e-6
    change = (problem.residual(x + h * step)[0] - problem.residual(x - h * step)[0]) / (2.0 * h)
    np.testing.assert_allclose(change, r, rtol=1e-6)
