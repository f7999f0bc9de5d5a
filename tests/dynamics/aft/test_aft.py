"""Contact forces in harmonics: the law in alternating frequency and time, and its derivatives."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.sparse as sp
from support.exact_systems import orbiting_mass, slipping_pair
from support.periodic import TURN, balance, complete, small_roll, with_friction

from wroll_fem.contact.bouc_wen import BoucWen
from wroll_fem.contact.elastic_coulomb import ElasticCoulomb
from wroll_fem.contact.rate_coulomb import RateCoulomb
from wroll_fem.contact.smoothed_coulomb import SmoothedCoulomb
from wroll_fem.dynamics.aft import harmonic_contact
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.harmonic_balance import solve_motion
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.training.enrichment import trained_response

LAWS = {
    "penalty": None,
    "rate": RateCoulomb(0.3, 1e-5, rates=(0.0, 1e-3, 2e-2), coefficients=(0.3, 0.25, 0.15)),
    "smoothed": SmoothedCoulomb(0.3, 1e-3),
    "bouc_wen": BoucWen(0.3, 1e-5, 1.5, 0.7),
    "elastic": ElasticCoulomb(0.3, 1e-5, 3e5),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("normal", [2e-8, 2e-7])
def test_jacobian_is_that_of_central_differences(law: str, normal: float) -> None:
    """Slip in a plane, pressure that varies, and (2e-7 m) separation; by coefficients and by frequency."""
    system = orbiting_mass(gamma=1e-5)
    if LAWS[law] is not None:
        system = with_friction(system, LAWS[law])
    contact = balance(system, 1.0).contact
    rng = np.random.default_rng(3)
    a = 2e-5 * rng.standard_normal((3, 7)) * np.array([1, 2, 2, 0.3, 0.3, 0.3, 0.3])
    a[2] = normal * rng.standard_normal(7)
    frequency = 60.0
    found = contact.evaluate(a, frequency)
    assert found.periodicity_error < 1e-8
    assert 0.3 < found.hysteresis.sliding.mean() <= 1.0
    assert bool(found.open.any()) == (normal > 1e-7)
    _, blocks, by_frequency = contact.point_blocks(found, threshold=0.0)
    for index in np.ndindex(3, 7):
        step = np.zeros((3, 7))
        step[index] = 1e-6 * (2e-5 if index[0] < 2 else normal)
        ends = [contact.evaluate(a + sign * step, frequency).coefficients for sign in (1, -1)]
        difference = (ends[0] - ends[1]) / (2 * step[index])
        np.testing.assert_allclose(blocks[0][:, :, index[0], index[1]], difference, atol=1e-7 * np.abs(blocks).max())
    _, of_mean, _ = contact.point_blocks(found, threshold=0.0, mean=True)
    np.testing.assert_allclose(of_mean[..., 0], blocks[:, :, :1, :, 0], atol=1e-12 * np.abs(blocks).max())
    _, single, _ = contact.point_blocks(found, threshold=0.0, precision=np.float32)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, blocks, atol=1e-6 * np.abs(blocks).max())
    ends = [contact.evaluate(a, frequency * (1 + h)).coefficients[:2] for h in (1e-6, -1e-6)]
    scale = np.abs(found.coefficients).max()
    np.testing.assert_allclose(by_frequency[0], (ends[0] - ends[1]) / 2e-6, atol=1e-8 * scale)
    assert (np.abs(by_frequency).max() > 1e-6 * scale) == (law in ("rate", "smoothed"))


@pytest.mark.parametrize("law", LAWS)
def test_reduced_jacobian_is_that_of_central_differences(law: str) -> None:
    system = dataclasses.replace(slipping_pair(), damping=sp.csr_matrix(np.diag([3.0, 1.0, 2.0])))
    frequency = TURN * 20.0
    q = solve_motion(balance(system, 2.0), frequency)  # derivatives hold at any motion: that of the first law does
    if LAWS[law] is not None:
        system = with_friction(system, LAWS[law])
    problem = balance(system, 2.0)
    _, contact = problem.residual(q, frequency)
    assert contact.hysteresis.sliding.any()
    matrix, by_frequency = problem.jacobian(q, frequency, contact, threshold=0.0)
    scale = np.abs(q).max()
    for index in range(q.size):
        step = np.zeros(q.size)
        step[index] = 1e-6 * scale
        ends = [problem.residual(q + sign * step.reshape(q.shape), frequency)[0].ravel() for sign in (1, -1)]
        difference = (ends[0] - ends[1]) / (2e-6 * scale)
        np.testing.assert_allclose(matrix[:, index], difference, atol=1e-7 * np.abs(matrix).max())
    ends = [problem.residual(q, frequency * (1 + h))[0].ravel() for h in (1e-6, -1e-6)]
    difference = (ends[0] - ends[1]) / (2e-6 * frequency)
    np.testing.assert_allclose(by_frequency, difference, atol=1e-7 * np.abs(by_frequency).max())
    product, as_map = problem.derivative(q, frequency, contact, threshold=0.0)
    columns = [product(one.reshape(q.shape)).ravel() for one in np.eye(q.size)]
    np.testing.assert_allclose(np.column_stack(columns), matrix, atol=1e-12 * np.abs(matrix).max())
    np.testing.assert_allclose(as_map.ravel(), by_frequency, atol=1e-12 * np.abs(by_frequency).max())


def test_a_memory_that_does_not_settle_is_reported() -> None:
    system = orbiting_mass(gamma=1e-5)
    model, preload = complete(system)
    a = np.zeros((3, 7))
    a[0, 1], a[1, 2] = 1.3e-5, 0.4e-5
    settled = HarmonicContact(model, preload, system.laws, Sampling(3, 64), max_periods=60).evaluate(a, 60.0)
    cut = HarmonicContact(model, preload, system.laws, Sampling(3, 64), max_periods=1).evaluate(a, 60.0)
    assert settled.hysteresis.periods.max() > 1
    assert settled.periodicity_error < 1e-8 < cut.periodicity_error


def test_single_precision_of_the_newton_matrix_does_not_change_the_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    system, preload, condensation = small_roll(8, 3)
    places, sizes = np.linspace(141.0, 164.0, 200), []
    for unknowns in (0, 10**6):
        monkeypatch.setattr(harmonic_contact, "SINGLE", unknowns)
        found = trained_response(condensation, preload, system.laws, amplitude=5.0, frequencies=(140.0, 165.0))
        sizes.append(np.interp(places, found.curve.frequencies / TURN, np.abs(found.curve.transmissibility)))
    assert max(sizes[0]) > 10.0
    np.testing.assert_allclose(sizes[0], sizes[1], rtol=1e-5)


def test_samples_follow_the_motion_of_a_roll() -> None:
    """Forces of a motion that is later by a share of a sample are later by as much, where all of its points slide."""
    system, preload, condensation = small_roll(12, 4)
    model = ReducedModel.of_vectors(condensation, np.eye(len(condensation.eigenvalues))[:, :3])
    contact = HarmonicContact(model, preload, system.laws, Sampling(3, 64))
    q = np.zeros((7, 3))
    q[1] = condensation.base[:3]
    q *= 300e-6 / np.abs(contact.motion(q)[: 2 * contact.n]).max()
    q[2] = 0.4 * q[1]

    def later(coefficients: np.ndarray, samples: float) -> np.ndarray:
        turned, angle = coefficients.copy(), 2.0 * np.pi / 64 * samples * np.arange(1, 4)[:, None]
        turned[1::2] = np.cos(angle) * coefficients[1::2] - np.sin(angle) * coefficients[2::2]
        turned[2::2] = np.sin(angle) * coefficients[1::2] + np.cos(angle) * coefficients[2::2]
        return turned

    def force(motion: np.ndarray) -> np.ndarray:
        evaluated = contact.evaluate(contact.motion(motion), 900.0)
        slides = evaluated.hysteresis.sliding.any(axis=1)
        own = np.where(slides[:, None], evaluated.coefficients[contact.dofs[:, 0]], 0.0)
        assert slides.mean() > 0.5
        return own.T

    here = force(q)
    for samples in (0.1, 0.5, 0.9):
        np.testing.assert_allclose(force(later(q, samples)), later(here, samples), atol=1e-9 * np.abs(here).max())
