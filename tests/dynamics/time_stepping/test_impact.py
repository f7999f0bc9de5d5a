"""Surfaces that open and land: the steps that do it must not make energy (docs/theory.md)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from support.exact_systems import contact_point, dense_system, stepper

from wroll_fem.contact import kernels
from wroll_fem.contact.laws import stack_laws
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import CONTACT, IMPACT, INPUT, KINETIC, NUMERICAL, STRAIN

KN, AREA, DT = 1.0e9, 2.0e-4, 1.0e-5
LAW = stack_laws([np.array([AREA])], [PenaltyCoulomb(0.3, 1.0e-6)], [KN], [True])
WEIGHT, STIFFNESS, H = 10.0, 4.0e6, 2.0e-4


def normal_step(before, after):
    """Traction (Pa) at the end of a step in the gap alone, and its work, (5,) J."""
    t, e, status, work = np.zeros(3), np.zeros(2), np.zeros(1, np.int64), np.zeros(5)
    g_c, g = np.array([0.0, 0.0, before]), np.array([0.0, 0.0, after])
    kernels.trial_traction(g, g_c, np.zeros(2), LAW, DT, t, e, status)
    committed = np.array([0.0, 0.0, KN * min(before, 0.0)])
    kernels.interface_work(g_c, np.zeros(2), committed, g, e, t, LAW, work)
    return t[2], work


@pytest.mark.parametrize("after", [1e-9, 2.0e-7, 5.0e-6, 1.0e-3])
def test_opening_gives_back_what_the_penalty_stored(after):
    """Exactly, however far a point flies within its step."""
    before = -3.0e-7
    traction, work = normal_step(before, after)
    assert work[3] == pytest.approx(-0.5 * KN * before**2 * AREA, rel=1e-12)
    assert work[4] == pytest.approx(0.0, abs=1e-10 * abs(work[3]))
    assert 0.0 < traction < KN * abs(before)


def test_opening_traction_starts_smoothly():
    """At the gap zero it goes on with the penalty's own slope, so that Newton's method sees no corner."""
    before, small = -3.0e-7, 1e-13
    assert normal_step(before, small)[0] == pytest.approx(KN * small, rel=1e-5)


def test_a_gap_that_opens_and_lands_loses_energy_only():
    """Swings of random height, in steps that do not turn round where they open; the ledger counts all the work."""
    rng = np.random.default_rng(4)
    corners = 1e-6 * rng.uniform(0.5, 2.0, 300) * np.tile([1.0, -1.0], 150)
    gaps = np.concatenate([np.linspace(a, b, rng.integers(12, 20))[1:] for a, b in pairwise(corners)])
    assert 0.2 < np.mean(gaps < 0.0) < 0.8
    g_c, t_c, work = np.array([0.0, 0.0, gaps[0]]), np.array([0.0, 0.0, KN * min(gaps[0], 0.0)]), np.zeros(5)
    lost = [0.0]
    for gap in gaps[1:]:
        t, e, status, g = np.zeros(3), np.zeros(2), np.zeros(1, np.int64), np.array([0.0, 0.0, gap])
        kernels.trial_traction(g, g_c, np.zeros(2), LAW, DT, t, e, status)
        kernels.interface_work(g_c, np.zeros(2), t_c, g, e, t, LAW, work)
        g_c, t_c = g, t
        lost.append(work[4])
    assert min(b - a for a, b in pairwise(lost)) >= -1e-18
    assert lost[-1] > 0.0
    assert work[[0, 1, 2, 4]].sum() == pytest.approx(work[3], rel=1e-12)


@pytest.mark.parametrize("method", ["full", "condensed"])
@pytest.mark.parametrize("alpha", [0.0, -0.05])
def test_a_bouncing_mass_never_gains_height(method, alpha):
    """A mass on a stop, pressed by a constant force and thrown off by a stroke of the base.

    The stop is so stiff (omega h = 2.8) that a step sees an impact as one point in time. Without the traction of the
    opening step the mass bounces higher and higher.
    """
    system = dense_system(
        [[1.0e-3 * STIFFNESS]], [[0.02]], [1.0],
        contact_point([1.0], [0.0], [0.0], mu=0.0, gamma=1.0e-6, kn=STIFFNESS), tip=[1.0], preload=[-WEIGHT],
    )  # fmt: skip
    state = solve_preload(system)
    run = stepper(method, system, state, Scheme.hht(alpha), H)
    base = np.zeros(1001)
    base[1:20] = -3.0 * WEIGHT / 0.02
    records = run.advance(base, H, 0.0)
    stored = records[:, [KINETIC, STRAIN, CONTACT]].sum(axis=1)
    spent = records[:, [NUMERICAL, IMPACT]].sum(axis=1)
    scale = np.abs(records[:, INPUT]).max()
    assert np.sum(np.diff(records[:, IMPACT]) > 1e-6 * scale) > 3  # it did bounce
    np.testing.assert_allclose(records[:, INPUT], stored + spent, atol=1e-9 * scale)
    free = stored[40:]
    assert free.max() < 1.001 * free[0]
