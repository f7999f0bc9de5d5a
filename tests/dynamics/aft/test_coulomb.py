"""Points with Coulomb friction side by side: as one after the other, and as a law that is computed in general."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.contact.elastic_coulomb import ElasticCoulomb
from wroll_fem.contact.kernels import PointLaws, Reference
from wroll_fem.contact.laws import stack_laws
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.contact.point import dofs_of
from wroll_fem.dynamics.aft import coulomb, kernel
from wroll_fem.dynamics.aft.derivatives import derivatives
from wroll_fem.dynamics.aft.sampling import Sampling

MU, GAMMA, STIFFNESS = 0.3, 1e-6, 1e11
SAMPLING = Sampling(3, 64)


def laws_of(count: int, *, constant: bool = False, pressure: float = 1e5) -> PointLaws:
    """Coulomb friction with the elastic slip `GAMMA` at ``pressure``, with a constant stick stiffness or not."""
    law = ElasticCoulomb(MU, GAMMA, MU * pressure / GAMMA) if constant else PenaltyCoulomb(MU, GAMMA)
    return stack_laws([np.full(count, 1e-4)], [law], [STIFFNESS], [True])


def points(count: int, seed: int, *, closed: bool = False) -> tuple[kernel.SampledMotion, kernel.Series, Reference]:
    """Random motions in all harmonics and directions, from none to 30 times `GAMMA`, and preload states.

    A quarter of the points move in one direction, and a quarter of them have slid in the preload already.
    """
    rng = np.random.default_rng(seed)
    size = GAMMA * 10.0 ** rng.uniform(-1.0, 1.5, count)
    decay = np.array([0.3, 1.0, 1.0, 0.3, 0.3, 0.2, 0.2])
    motion = rng.standard_normal((3, count, 7)) * decay * np.array([1.0, 1.0, 0.0 if closed else 0.1])[:, None, None]
    motion[:2] *= size[:, None]
    motion[2] *= 1e-6  # m; the preload compresses the contact by as much
    motion[1, : count // 4] = 0.0
    motion[:2, 0] = 0.0
    coefficients = np.concatenate([motion[:2].transpose(1, 0, 2).reshape(2 * count, 7), motion[2]])
    series, ramp, ramp_rate = SAMPLING.shifted(0.3)
    path = kernel.SampledMotion(
        coefficients @ series.values.T, coefficients @ series.velocities.T, ramp, ramp_rate, 1e-4
    )
    slip, turn = GAMMA * rng.choice([0.0, 0.5, 1.0], count), rng.uniform(0.0, 2.0 * np.pi, count)
    elastic = np.column_stack([slip * np.cos(turn), slip * np.sin(turn)]).ravel()
    jump = np.concatenate([np.zeros(2 * count), np.full(count, -1e-6)])
    stick = MU * STIFFNESS * 1e-6 / GAMMA
    traction = np.concatenate([stick * elastic, STIFFNESS * jump[2 * count :]])
    springs = np.concatenate([np.full(2 * count, stick), np.full(count, STIFFNESS)])
    return path, series, Reference(jump, elastic, traction, springs)


def hysteresis(path: kernel.SampledMotion, reference: Reference, laws: PointLaws) -> kernel.Hysteresis:
    n, count = laws.n, len(path.ramp) - 1
    slip, sliding = np.empty((2 * n, count)), np.empty((n, count), np.bool_)
    out = kernel.Hysteresis(slip, sliding, np.empty(n, np.bool_), np.empty(n, np.int64), np.empty(n))
    kernel.iterate_to_periodic(path, reference, laws, 8, 1e-8, out)
    return out


def blocks(
    path: kernel.SampledMotion, series: kernel.Series, reference: Reference, laws: PointLaws, found: kernel.Hysteresis
) -> np.ndarray:
    out, by_frequency = np.zeros((laws.n, 3, 7, 3, 7)), np.zeros((laws.n, 2, 7))
    derivatives(np.arange(laws.n), path, found, reference, laws, series, SAMPLING.products(0.3), out, by_frequency)
    assert not by_frequency.any()
    return out


@pytest.mark.parametrize("count", [coulomb.LANES, 150])
def test_points_side_by_side_move_as_each_alone(count: int) -> None:
    path, _, reference = points(count, seed=count)
    found = hysteresis(path, reference, laws_of(count))
    assert 0.3 < found.moved.mean() < 0.9
    assert len(set(found.periods)) > 2
    for k in range(count):
        own, two = dofs_of(np.array([k]), count), slice(2 * k, 2 * k + 2)
        alone = Reference(*(part[own] if len(part) == 3 * count else part[two] for part in reference))
        single = hysteresis(path._replace(motion=path.motion[own], rate=path.rate[own]), alone, laws_of(1))
        np.testing.assert_allclose(found.slip[two], single.slip, rtol=0, atol=1e-14 * GAMMA * 100)
        assert (found.sliding[k] == single.sliding[0]).all()
        assert found.moved[k] == single.moved[0]
        np.testing.assert_allclose(found.change[k], single.change[0], atol=1e-13)
        if found.moved[k]:
            assert found.periods[k] == single.periods[0]


def test_slip_and_derivatives_are_those_of_a_constant_stick_stiffness_at_constant_pressure() -> None:
    """The other law is computed point by point, by code of its own."""
    count = 120
    path, series, reference = points(count, seed=7, closed=True)
    ours, other = laws_of(count), laws_of(count, constant=True)
    found, expected = hysteresis(path, reference, ours), hysteresis(path, reference, other)
    np.testing.assert_allclose(found.slip, expected.slip, rtol=0, atol=1e-12 * GAMMA)
    tangential = blocks(path, series, reference, ours, found)[:, :2, :, :2]
    right = blocks(path, series, reference, other, expected)[:, :2, :, :2]
    np.testing.assert_allclose(tangential, right, rtol=0, atol=1e-11 * np.abs(right).max())
    sticking = blocks(path, series, reference, ours, found._replace(moved=np.zeros(count, np.bool_)))[:, :2, :, :2]
    changed = np.abs(right - sticking).max(axis=(1, 2, 3, 4)) > 1e-3 * np.abs(right).max()
    assert changed[found.sliding.any(axis=1)].all()
    assert 0.3 < changed.mean() < 0.9


def test_a_point_that_slides_at_every_sample_does_not_resist_a_mean_displacement() -> None:
    """Exactly, so that Newton's matrix of a body that nothing holds is singular."""
    path, series, reference = points(8, seed=3, closed=True)
    turn = 2.0 * np.pi * np.arange(64) / 64
    path.motion[:16] = 100.0 * GAMMA * np.tile([np.cos(turn), np.sin(turn)], (8, 1))
    laws = laws_of(8)
    found = hysteresis(path, reference, laws)
    assert found.sliding.all()
    mean = blocks(path, series, reference, laws, found)[:, :2, :, :2, 0]
    mean[:, :, 0] += np.diag(reference.springs[:2])  # the derivatives are those beyond the springs
    assert np.abs(mean).max() < 1e-6 * reference.springs[0]
