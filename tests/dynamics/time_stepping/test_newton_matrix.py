"""Newton's matrix of the condensed steps: solutions, and no subnormal numbers, which are slow on some processors."""

import numpy as np
import pytest
from support.rubbing_roll import roll

from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.contact import kernels
from wroll_fem.contact.point import contact_dofs
from wroll_fem.dynamics.reduction.cyclic_blocks import without_tangential_springs
from wroll_fem.dynamics.reduction.interface_operator import Compliance, InterfaceOperator
from wroll_fem.dynamics.reduction.newton_matrix import (
    KRYLOV_TOLERANCE,
    _factor,
    factored,
    krylov_step,
    newton_step,
    workspace,
)
from wroll_fem.dynamics.time_stepping import condensed
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.simulate import make_stepper, simulate
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.numerics import lu
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.base_motion import Dwell

HHT = Scheme.hht(-0.05)


def test_entries_that_symmetry_makes_zero_are_zero() -> None:
    """Two groups of points that a roll decouples by symmetry: rounding leaves 1e-40 of the couplings."""
    rng, n = np.random.default_rng(3), 20
    stiffness, tiny = 1.0, np.finfo(np.float32).tiny
    compliance = rng.normal(size=(3 * n, 3 * n))
    compliance = compliance @ compliance.T / (200.0 * n * stiffness)
    group = np.r_[np.repeat(np.arange(n) % 2, 2), np.arange(n) % 2]
    apart = group[:, None] != group
    compliance[apart] *= 1e-37
    single, springs = compliance.astype(np.float32), np.full(3 * n, stiffness)
    tangent = np.zeros((n, 3, 3))  # all points slide or are open, with a rest of stiffness from rounding
    tangent[:, 0, 0] = 1e-30 * stiffness
    active = np.arange(3 * n)
    factors = _factor(active, False, tangent, springs, single)
    size = np.abs(factors.matrix)
    assert np.mean((single[apart] != 0.0) & (np.abs(single[apart]) < tiny)) > 0.9
    assert not np.any((size > 0.0) & (size < tiny))
    right = rng.normal(size=3 * n)
    solution = right.astype(np.float32)
    lu.solve(factors.matrix, factors.pivots, solution)
    np.testing.assert_allclose(solution, np.linalg.solve(np.eye(3 * n) - stiffness * compliance, right), rtol=2e-4)


@pytest.mark.parametrize(("open_share", "slides"), [(0.0, False), (0.3, True), (1.0, True)])
def test_newton_steps_are_exact_from_either_compliance(open_share, slides):
    """Points that are open, slide under a pressure that varies, or stick; stiff springs, as at the interface of a roll.

    Where points are open, the matrix without tangential springs has fewer rows and is taken.
    """
    rng, n = np.random.default_rng(7), 30
    area, springs = rng.uniform(1.0, 2.0, n), np.concatenate([np.full(2 * n, 40.0), np.full(n, 60.0)])
    free = rng.normal(size=(3 * n, 3 * n))
    weights = np.concatenate([np.repeat(area, 2), area])
    inverse = np.linalg.inv(free @ free.T / n + 0.5 * np.eye(3 * n)) + np.diag(weights * springs)
    order = contact_dofs(n).T.ravel()  # all hoop components, then the axial and the normal ones
    blocks, profiles = np.linalg.inv(inverse)[np.ix_(order, order)][None], np.ones((3, 1, 1))
    sliding = without_tangential_springs(blocks, profiles.transpose(1, 0, 2)[:, None], springs, area)
    dense = np.empty((3 * n, 3 * n))
    found = []
    for part in (blocks, sliding):
        dense[np.ix_(order, order)] = part[0]
        found.append(Compliance(part, (dense * weights).astype(np.float32)))
    nothing = Compliance(np.zeros((0, 0, 0)), np.zeros((0, 0), np.float32))
    compliance = np.linalg.inv(inverse) * weights
    tangent, status = np.zeros((n, 3, 3)), np.zeros(n, np.int64)
    tangent[:, 2, 2] = 60.0
    tangent[:, 0, 0] = tangent[:, 1, 1] = 40.0
    slip = rng.random(n) < 0.6
    along = rng.normal(size=(n, 2))
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = np.eye(2) - along[:, :, None] * along[:, None, :]
    tangent[slip, :2, :2] = 8.0 * across[slip]
    tangent[slip, :2, 2] = -15.0 * along[slip]
    status[slip] = kernels.SLIP
    tangent[rng.random(n) < open_share] = 0.0
    change = np.zeros((3 * n, 3 * n))
    for k, dofs in enumerate(contact_dofs(n)):
        change[np.ix_(dofs, dofs)] = tangent[k] - np.diag(springs[dofs])
    rho = rng.normal(size=3 * n)
    expected = -np.linalg.solve(np.eye(3 * n) + compliance @ change, rho)
    delta, step = np.zeros(3 * n), np.zeros(3 * n)
    taken = []
    for others in (nothing, found[1]):
        interface = InterfaceOperator(np.zeros(2, np.int64), np.zeros(0), profiles, found[0], others)
        work = workspace(interface, n, 90)
        work.tangent[:] = tangent
        factors = factored(interface, springs, status, work)
        newton_step(factors, interface, area, springs, rho, work, delta)
        np.testing.assert_allclose(delta, expected, atol=2e-4 * np.abs(expected).max())
        taken.append(factors)
        # from the factors of another state of a point, GMRES gives the same step to its tolerance
        work.tangent[3] = 0.0 if open_share < 1.0 else np.diag([40.0, 40.0, 60.0])
        before = factored(interface, springs, status, work)
        work.tangent[:] = tangent
        assert krylov_step(before, interface, area, springs, rho, 90, work, step)
        matrix = np.eye(3 * n) + compliance @ change
        assert np.linalg.norm(matrix @ step + rho) <= 1.01 * KRYLOV_TOLERANCE * np.linalg.norm(rho)
    assert [one.slides for one in taken] == [False, slides]
    assert not slides or len(taken[1].active) < len(taken[0].active)


def test_an_opening_roll_moves_as_with_springs_that_stick(monkeypatch):
    """Eight cycles of a coil that opens on its mandrel: the Newton matrices differ, the steps do not."""
    system, state = prepare(roll("sweep", preload={"pressure": 2e3}), SilentProgress())
    runs, built = [], []
    for least in (condensed.LEAST_OPEN, 1.0):
        monkeypatch.setattr(condensed, "LEAST_OPEN", least)
        stepper = make_stepper(system, state, method="condensed", scheme=HHT, options=NewtonOptions(), dt=1 / 6000)
        runs.append(simulate(system, state, Dwell(20.0, 150.0, 8, 2), dt=1 / 6000, scheme=HHT, stepper=stepper))
        built.append([len(interface.sliding.dense) > 0 for _, interface in stepper._operators.values()])
    assert built == [[True], [False]]
    opened, plain = runs
    tip = plain["tip_displacement"].values
    assert np.abs(opened["tip_displacement"].values - tip).max() <= 1e-9 * np.abs(tip).max()
    assert float(plain["open_time_fraction"].max()) > 0.05
