"""Maps between points and modes in harmonics, with and without symmetry, against those of the whole structure."""

from __future__ import annotations

import numpy as np
import pytest
from support.periodic import small_roll
from support.twisted_wall import TWISTED

from wroll_fem.dynamics.periodic.aft import HarmonicContact
from wroll_fem.dynamics.periodic.half_period import HalfPeriod
from wroll_fem.dynamics.periodic.sampling import Sampling
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
