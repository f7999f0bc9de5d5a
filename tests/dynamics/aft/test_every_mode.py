"""Maps between points and modes in harmonics, with and without symmetry, against those of the whole structure."""

from __future__ import annotations

import numpy as np
import pytest
from support.periodic import small_roll
from support.twisted_wall import TWISTED

from wroll_fem.dynamics.aft.every_mode import FAR, EveryMode
from wroll_fem.dynamics.aft.half_period import HalfPeriod
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel, contact_jump, modal_force


@pytest.mark.parametrize(("symmetric", "twisted"), [(True, False), (False, False), (True, True)])
def test_maps_are_those_of_all_points_and_modes(symmetric: bool, twisted: bool) -> None:
    roll = small_roll(8, 2, TWISTED, mirrored=False) if twisted else small_roll(12, 4)
    system, preload, condensation = roll
    assert condensation.profiles.shape[1] == 1 + twisted
    sampling = Sampling(3, 64)
    symmetry = HalfPeriod.of(condensation, preload, system.laws) if symmetric else None
    model = ReducedModel.of_vectors(condensation, np.eye(len(condensation.eigenvalues))[:, :3])
    contact = HarmonicContact(model, preload, system.laws, sampling, symmetry=symmetry)
    every = contact.every_mode
    assert len(every.groups) == 1 + symmetric
    rng = np.random.default_rng(4)
    motion = rng.standard_normal((len(condensation.eigenvalues), sampling.size))
    parts = every.split(motion)
    motion = every.joined(parts)  # the coefficients that each mode has
    if symmetric:
        assert np.all(motion[symmetry.odd][:, sampling.orders % 2 == 0] == 0.0)
        assert np.all(motion[~symmetry.odd][:, sampling.orders % 2 == 1] == 0.0)
    expected = contact_jump(condensation, motion)
    found = np.empty((3 * contact.n, sampling.size))
    found[every.dofs] = every.motion(parts)
    np.testing.assert_allclose(contact.spread(found), expected, atol=1e-12 * np.abs(expected).max())
    traction = rng.standard_normal((3 * contact.n, sampling.size))
    force = modal_force(condensation, contact.all_weights[:, None] * contact.spread(traction))
    weights = contact.laws.area[every.points][:, None, None]
    np.testing.assert_allclose(
        every.joined(every.force(weights * traction[every.dofs])), force, atol=1e-12 * np.abs(force).max()
    )


@pytest.mark.parametrize("symmetric", [True, False])
def test_residual_modes_yield_as_the_modes_that_they_replace(symmetric: bool) -> None:
    """Compliance of the contact points at four harmonics, with all modes and with residual modes; single precision."""
    system, preload, condensation = small_roll(12, 4)
    orders = Sampling(4, 64).orders
    symmetry = HalfPeriod.of(condensation, preload, system.laws) if symmetric else None
    every = EveryMode(condensation, symmetry, orders)
    lowest = np.sqrt(condensation.eigenvalues.min())
    squares = (orders * 1.1 * lowest) ** 2
    quick, values = every.with_residual_modes(squares.max())
    traction = np.random.default_rng(7).standard_normal((len(every.points), 3, len(orders)))

    def yielding(maps: EveryMode, eigenvalues: list[np.ndarray]) -> np.ndarray:
        forces = maps.force(traction.astype(maps.groups[0].jump.dtype))
        return maps.motion([
            force / (part[:, :, None] - squares[group.columns])
            for force, part, group in zip(forces, eigenvalues, maps.groups, strict=True)
        ])  # fmt: skip

    exact = yielding(every, [group.of_modes(condensation.eigenvalues, fill=1.0) for group in every.groups])
    for few, many, part in zip(quick.groups, every.groups, values, strict=True):
        assert few.jump.shape[1] == part.shape[1] < 0.6 * many.jump.shape[1]
        assert part.min() < FAR * squares.max()  # near modes are kept
    np.testing.assert_allclose(yielding(quick, values), exact, atol=2e-6 * np.abs(exact).max())


@pytest.mark.parametrize("symmetric", [True, False])
def test_maps_of_several_motions_are_those_of_each(symmetric: bool) -> None:
    system, preload, condensation = small_roll(12, 4)
    orders = Sampling(3, 64).orders
    every = EveryMode(condensation, HalfPeriod.of(condensation, preload, system.laws) if symmetric else None, orders)
    rng, size = np.random.default_rng(9), len(orders)
    for maps in (every, every.with_residual_modes(1e6)[0]):
        precision = maps.groups[0].jump.dtype
        close = 1e-13 if precision == np.float64 else 1e-5
        traction = rng.standard_normal((len(every.points), 3, 3 * size)).astype(precision)
        forces = maps.repeated(3).force(traction)
        motion = maps.repeated(3).motion(forces)
        for k in range(3):
            alone = maps.force(traction[:, :, k * size : (k + 1) * size])
            for together, part in zip(forces, alone, strict=True):
                own = together.reshape(*part.shape[:2], 3, -1)[:, :, k]
                np.testing.assert_allclose(own, part, rtol=0.0, atol=close * np.abs(part).max())
            expected = maps.motion(alone)
            moved = motion[:, :, k * size : (k + 1) * size]
            np.testing.assert_allclose(moved, expected, rtol=0.0, atol=close * np.abs(expected).max())


def test_a_structure_of_few_modes_keeps_them_all() -> None:
    condensation = small_roll(12, 4)[2]
    every = EveryMode(condensation, None, Sampling(3, 64).orders)
    quick, values = every.with_residual_modes(condensation.eigenvalues.max())
    assert [group.jump.shape for group in quick.groups] == [group.jump.shape for group in every.groups]
    np.testing.assert_array_equal(values[0], every.groups[0].of_modes(condensation.eigenvalues, fill=1.0))


@pytest.mark.parametrize("symmetric", [True, False])
def test_maps_of_the_mean_and_of_single_precision_are_those_of_all_coefficients(symmetric: bool) -> None:
    system, preload, condensation = small_roll(12, 4)
    symmetry = HalfPeriod.of(condensation, preload, system.laws) if symmetric else None
    every = EveryMode(condensation, symmetry, Sampling(2, 32).orders)
    rng, count, size = np.random.default_rng(8), 3, every.coefficients
    motion = rng.standard_normal((len(condensation.eigenvalues), count * size))
    traction = rng.standard_normal((len(every.points), 3, count * size))
    means = np.arange(0, count * size, size)
    whole, mean = every.repeated(count), every.of_mean().repeated(count)
    moved, forces = whole.motion(whole.split(motion)), whole.joined(whole.force(traction))
    np.testing.assert_allclose(
        mean.motion(mean.split(motion[:, means])), moved[:, :, means], atol=1e-14 * np.abs(moved).max()
    )
    found = mean.joined(mean.force(np.ascontiguousarray(traction[:, :, means])))
    np.testing.assert_allclose(found, forces[:, means], atol=1e-14 * np.abs(forces).max())
    single = every.single.repeated(count)
    quick, pushed = single.motion(whole.split(motion)), single.force(traction)
    assert quick.dtype == np.float32
    assert all(part.dtype == np.float32 for part in pushed)
    np.testing.assert_allclose(quick, moved, atol=2e-6 * np.abs(moved).max())
    np.testing.assert_allclose(single.joined(pushed), forces, atol=2e-6 * np.abs(forces).max())
