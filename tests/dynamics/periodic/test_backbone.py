"""Backbones by extended periodic motion against describing functions, forced motions and differences."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.sparse as sp
from support.exact_systems import coulomb_oscillator, slipping_pair
from support.periodic import TURN, balance, complete, small_roll, trained_roll

from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.backbone import BACKBONE_STEPS, ModalMotion, solve_backbone
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance, solve_motion
from wroll_fem.dynamics.training.enrichment import _BackboneTask, trained_backbone


def test_backbone_of_the_bilinear_oscillator_follows_its_loop_area() -> None:
    """H = 1 is Caughey's describing function: 2 pi zeta m w^2 X^2 is the loop's area 4 F (X - F/k_t) exactly.

    From the stuck frequency without damping to the frictionless one, again without.
    """
    gamma, limit = 2e-4, 3.0
    system = coulomb_oscillator(gamma=gamma)
    model, preload = complete(system)
    curve = solve_backbone(model, preload, system.laws, tip_amplitudes=(1e-5, 1.0), harmonics=1, samples=2048)
    tip, w = curve.tip, curve.frequencies
    assert w[0] == pytest.approx(np.sqrt(1e4 + limit / gamma), rel=1e-9)
    assert curve.damping[0] == pytest.approx(0.0, abs=1e-9)
    assert w[-1] == pytest.approx(100.0, rel=2e-4)
    assert curve.damping[-1] < 3e-4
    slips = tip > 1.05 * gamma
    area = 4.0 * limit * (tip[slips] - gamma)
    np.testing.assert_allclose(TURN * curve.damping[slips] * (w * tip)[slips] ** 2, area, rtol=2e-4)
    # Caughey (1960): stiffness of the describing function at X = 2 delta is half the slider's spring
    there = int(np.argmin(np.abs(tip - 2.0 * gamma)))
    angle = np.arccos(1.0 - 2.0 * gamma / tip[there])
    stiffness = 1e4 + limit / gamma / np.pi * (angle - 0.5 * np.sin(2.0 * angle))
    assert w[there] == pytest.approx(np.sqrt(stiffness), rel=1e-4)


def test_backbone_jacobian_is_that_of_central_differences() -> None:
    system = dataclasses.replace(slipping_pair(gamma=2e-4), damping=sp.csr_matrix(np.diag([3.0, 1.0, 2.0])))
    contact = balance(system, 0.0).contact
    problem = ModalMotion(HarmonicBalance(contact, 0.0), contact.model.main_mode, (1e-4, 1e-3))
    z = problem.start() + 0.02 * np.random.default_rng(2).standard_normal(len(problem.start()))
    matrix = problem.jacobian(z)
    # the phase condition and the norm included; the points' threshold only leaves out points that stick
    for index in range(len(z)):
        step = np.zeros(len(z))
        step[index] = 1e-6
        difference = (problem.residual(z + step) - problem.residual(z - step)) / 2e-6
        np.testing.assert_allclose(matrix[:, index], difference, atol=1e-7 * np.abs(matrix).max())


def test_forced_resonance_lies_on_the_backbone() -> None:
    """At 90 degrees the forced motion is the mode at the base level that the backbone gives for it."""
    system = coulomb_oscillator(gamma=2e-4)
    model, preload = complete(system)
    curve = solve_backbone(model, preload, system.laws, tip_amplitudes=(1e-5, 1e-2), samples=512)
    k = int(np.argmin(np.abs(curve.tip - 5e-4)))
    forced = HarmonicBalance(HarmonicContact(model, preload, system.laws, Sampling(3, 512)), curve.base_acceleration[k])
    q = solve_motion(forced, curve.frequencies[k])
    amplitude = q[1] @ model.tip - 1j * (q[2] @ model.tip)
    assert abs(amplitude) == pytest.approx(curve.tip[k], rel=0.02)
    assert abs(np.angle(-amplitude) - np.pi / 2) < 0.05 or abs(np.angle(-amplitude) + np.pi / 2) < 0.05
    work = curve.balance.cycle_work(curve.coefficients[k], curve.frequencies[k])
    assert work.interface == pytest.approx(curve.dissipation[k], rel=1e-6)


def test_a_backbone_is_cut_before_its_inaccurate_motions_if_they_are_its_last() -> None:
    system = coulomb_oscillator(gamma=2e-4)
    model, preload = complete(system)
    curve = solve_backbone(model, preload, system.laws, tip_amplitudes=(1e-5, 1e-2), samples=128)
    count = len(curve.frequencies) - curve.beyond
    for good in (count - 1, count - 3):
        part = _BackboneTask.shortened(None, curve, curve, [k < good for k in range(len(curve.frequencies))])
        np.testing.assert_array_equal(part.tip, curve.tip[:good])
    between = [k != 3 for k in range(len(curve.frequencies))]
    assert _BackboneTask.shortened(None, curve, curve, between) is None


def test_backbone_of_the_roll_starts_stuck_and_agrees_with_the_forced_peak() -> None:
    system, preload, condensation = small_roll(12, 4)
    trained = trained_backbone(condensation, preload, system.laws, tip_amplitudes=(1e-6, 2e-4))
    curve = trained.curve
    main = int(np.argmax(np.abs(condensation.base * condensation.tip) / condensation.eigenvalues))
    # friction that the preload left behind follows the pressure, which springs do not: 2e-5 of the frequency
    assert curve.frequencies[0] == pytest.approx(np.sqrt(condensation.eigenvalues[main]), rel=1e-4)
    assert abs(curve.damping[0]) < 1e-9
    assert np.all(np.diff(curve.frequencies) < 1e-6 * curve.frequencies[0])
    assert curve.damping[-1] > 0.02
    response = trained_roll(12, 4).curve
    size = np.abs(response.fundamental(response.balance.model.tip))
    top = int(size.argmax())
    level = np.flatnonzero(curve.damping > 1e-4)
    expected = np.interp(5.0, curve.base_acceleration[level], curve.tip[level])
    assert size[top] == pytest.approx(expected, rel=0.02)
    at = np.interp(size[top], curve.tip[level], curve.frequencies[level])
    assert response.frequencies[top] == pytest.approx(at, rel=0.01)


@pytest.mark.slow
def test_backbone_ends_where_friction_no_longer_holds_a_layer_whatever_the_range() -> None:
    """At 2 kPa all points slide and open in every period: the layer's mean displacement is free, the curve turns.

    The end belongs to the roll, not to the range asked for, and below it both curves are the same.
    """
    system, preload, condensation = small_roll(8, 3, "preload.pressure=2000.0")
    # straight lines between points of the usual distance miss 1 % of the damping, between these 0.3 %
    close = dataclasses.replace(BACKBONE_STEPS, largest=0.08, chord=0.003, angle=0.1)
    short, long = (
        trained_backbone(condensation, preload, system.laws, tip_amplitudes=(1e-7, top), control=close).curve
        for top in (1e-3, 1e-2)
    )
    for curve, top in ((short, 1e-3), (long, 1e-2)):
        # both hold there; rounding decides which of the two the last point shows
        assert "mean displacement is undetermined" in curve.cut or "layers rattle" in curve.cut
        assert curve.beyond == 0
        assert curve.tip[-1] < 0.5 * top
    # rounding decides how far the last, rattling points reach: 0.34 and 0.39 mm on one processor, equal on another
    assert short.tip[-1] == pytest.approx(long.tip[-1], rel=0.2)
    common = long.tip <= 0.95 * min(short.tip[-1], long.tip[-1])
    for values in ("frequencies", "damping"):
        at = np.interp(np.log(long.tip[common]), np.log(short.tip), getattr(short, values))
        scale = np.abs(getattr(short, values)).max()
        np.testing.assert_allclose(getattr(long, values)[common], at, atol=0.01 * scale)


def test_backbone_with_a_reachable_range_is_not_cut() -> None:
    system, preload, condensation = small_roll(8, 3, "preload.pressure=2000.0")
    curve = trained_backbone(condensation, preload, system.laws, tip_amplitudes=(1e-7, 1e-4)).curve
    assert curve.cut == ""
    assert curve.tip[-1] > 0.9e-4
