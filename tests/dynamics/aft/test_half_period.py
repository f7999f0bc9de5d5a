"""Half-period symmetry: found where it is, refused where it is not, and equal to the evaluation of every point."""

from __future__ import annotations

import numpy as np
import pytest
from support.periodic import small_roll, trained_roll
from support.twisted_wall import TWISTED

from wroll_fem.dynamics.aft.half_period import HalfPeriod
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.dynamics.reduction.reduced_model import modal_force
from wroll_fem.dynamics.training.correction import correction
from wroll_fem.dynamics.training.structure import Structure


def test_a_roll_has_the_symmetry_and_an_uneven_one_has_none() -> None:
    system, preload, condensation = small_roll(12, 4)
    found = HalfPeriod.of(condensation, preload, system.laws)
    assert found is not None
    assert found.weight.sum() == system.n_points
    assert len(found.first) < 0.6 * system.n_points
    uneven = system.laws.mu.copy()
    uneven[0] *= 1.01
    assert HalfPeriod.of(condensation, preload, system.laws._replace(mu=uneven)) is None


@pytest.mark.parametrize(("twisted", "seed"), [(False, 5), (False, 8), (False, 15), (True, 5)])
def test_one_point_of_each_pair_gives_the_forces_of_all(twisted: bool, seed: int) -> None:
    """Gross slip, which forgets how it began: every point evaluated, against one of each pair and half the unknowns.

    The points of a pair start half a period apart, so the first period has to end at the motion itself, wherever its
    samples are. A roll with a wall of angle plies has no mirror plane; half a turn maps its points onto each other.
    """
    roll = small_roll(8, 3, TWISTED, mirrored=False) if twisted else small_roll(12, 4)
    system, preload, condensation = roll
    sampling, symmetry = Sampling(3, 64), HalfPeriod.of(condensation, preload, system.laws)
    model = Structure.of(condensation, preload, system.laws, sampling, 8).first_model()
    half = HarmonicContact(model, preload, system.laws, sampling, symmetry=symmetry)
    every = HarmonicContact(model, preload, system.laws, sampling)
    rng = np.random.default_rng(seed)
    q = np.zeros((sampling.size, model.size))
    q.ravel()[half.active] = rng.standard_normal(len(half.active))
    reach = np.abs(every.motion(q)[: 2 * every.n])
    q *= 100e-6 / reach.max()
    one, all_points = half.evaluate(half.motion(q), 900.0), every.evaluate(every.motion(q), 900.0)
    slides = np.flatnonzero(all_points.hysteresis.sliding.mean(axis=1) > 0.5)
    assert len(slides) > 0.5 * every.n
    np.testing.assert_allclose(half.spread(half.motion(q)), every.motion(q), atol=1e-12 * np.abs(every.motion(q)).max())
    spread, scale = half.spread(one.coefficients), np.abs(all_points.coefficients).max()
    for dofs in every.dofs[slides].T:
        np.testing.assert_allclose(spread[dofs], all_points.coefficients[dofs], atol=1e-9 * scale)
    anything = rng.standard_normal(one.coefficients.shape)  # a leftover traction in the plane of the mirror as well
    force = modal_force(condensation, half.all_weights[:, None] * half.spread(anything))
    even = sampling.orders % 2 == 0
    assert np.abs(force[symmetry.odd][:, even]).max() < 1e-12 * np.abs(force).max()
    assert np.abs(force[~symmetry.odd][:, ~even]).max() < 1e-12 * np.abs(force).max()
    balance = HarmonicBalance(half, 1.0)
    _, contact = balance.residual(q, 900.0)
    matrix, _ = balance.jacobian(q, 900.0, contact, threshold=0.0)
    step = rng.standard_normal(len(half.active))
    change = np.zeros_like(q)
    change.ravel()[half.active] = 1e-6 * np.linalg.norm(q) / np.linalg.norm(step) * step
    ends = [balance.residual(q + sign * change, 900.0)[0].ravel()[half.active] for sign in (1.0, -1.0)]
    expected = matrix @ change.ravel()[half.active]
    np.testing.assert_allclose(0.5 * (ends[0] - ends[1]), expected, atol=1e-4 * np.abs(expected).max())


def test_the_symmetric_curve_satisfies_the_balance_of_the_whole_roll() -> None:
    curve = trained_roll(12, 4).curve
    assert curve.balance.contact.symmetry is not None
    between = [k + 1 for k in range(2, len(curve.frequencies) - 2, 7)]
    found = [
        correction(curve.balance, curve.coefficients[k], curve.frequencies[k], curve.direction(k)[None])
        for k in between
    ]  # fmt: skip
    assert max(one.energy for one in found) < 3e-3  # trained to 1e-3 at other points
    odd, even = curve.balance.contact.symmetry.odd, curve.balance.orders % 2 == 0
    for one in found:  # a point in the plane of the mirror has no leftover traction that the symmetry excludes
        assert np.abs(one.modal[odd][:, even]).max() < 1e-9 * np.abs(one.modal).max()
