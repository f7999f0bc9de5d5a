"""Newton's method in all modes: motions of the full model, without a reduced model being solved."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from support.periodic import small_roll, trained_roll

from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.dynamics.periodic.point_sample import Motions
from wroll_fem.dynamics.periodic.response import HarmonicCurve, response_curve
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.training import correction as corrections_module
from wroll_fem.dynamics.training import full_motions as newton
from wroll_fem.dynamics.training.basis import REACH, principal_span, reached_modes
from wroll_fem.dynamics.training.correction import (
    KRYLOV_TOLERANCE,
    Correction,
    corrected_means,
    correction,
    corrections,
    modal_corrections,
)
from wroll_fem.dynamics.training.full_motions import full_motions, modal, scaled_means
from wroll_fem.dynamics.training.structure import Structure


def checked(points: HarmonicCurve) -> list[Correction]:
    along = [points.direction(k)[None] for k in range(len(points.frequencies))]
    return corrections(points.balance, points.coefficients, points.frequencies, along)


@pytest.fixture(scope="module")
def rough() -> tuple[Structure, HarmonicCurve]:
    """Points of the curve through the resonance in the first basis, whose motions miss up to one percent."""
    system, preload, condensation = small_roll(12, 4)
    structure = Structure.of(condensation, preload, system.laws, Sampling(3, 64), 8)
    curve = response_curve(structure.contact(structure.first_model()), amplitude=5.0, frequencies=(140.0, 165.0))
    return structure, curve.take(list(range(0, len(curve.frequencies), 3)))


def distances(points: HarmonicCurve, motions: np.ndarray) -> np.ndarray:
    """(p, 2) energy norms, whole and without the mean, of the way to the curve of the full model.

    Corrections at two neighbouring frequencies give the direction of this curve.
    """
    ends = [modal_corrections(points.balance, motions, points.frequencies * (1.0 + e)) for e in (3e-4, -3e-4)]
    along = [(above.modal - below.modal).T[None] for above, below in zip(*ends, strict=True)]
    found = modal_corrections(points.balance, motions, points.frequencies, along)
    return np.array([(one.energy, one.moving) for one in found])


def test_motions_are_those_of_the_full_model(
    rough: tuple[Structure, HarmonicCurve], monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are as near the curve of the full model as those that Newton's method finds with every component."""
    _, points = rough
    found = checked(points)
    assert max(one.energy for one in found) > 5e-3
    monkeypatch.setattr(newton, "LAST", 1e-5)
    full = full_motions(points, found, KRYLOV_TOLERANCE)
    assert full is not None
    np.testing.assert_array_equal(full.frequencies, points.frequencies)
    along = [(points.direction(k) @ points.balance.model.vectors.T)[None] for k in range(len(points.frequencies))]
    left = modal_corrections(points.balance, full.coefficients, full.frequencies, along)
    assert max(one.moving for one in left) < 2e-5
    iterated = modal(points)
    for _ in range(4):
        steps = modal_corrections(points.balance, iterated, points.frequencies, along)
        iterated += np.array([one.modal.T for one in steps])
    assert max(one.energy for one in steps) < 2e-5
    new, old = distances(points, full.coefficients), distances(points, iterated)
    assert (new[:, 1] <= 1.01 * old[:, 1] + 1e-6).all()
    assert (new[:, 0] <= 1.01 * old[:, 0] + 1e-6).all()
    assert (new[:, 0] < 0.2 * distances(points, modal(points))[:, 0]).all()


def test_corrections_are_those_of_a_model_of_all_modes(rough: tuple[Structure, HarmonicCurve]) -> None:
    structure, points = rough
    c = structure.condensation
    everything = ReducedModel.on(c, np.eye(len(c.eigenvalues)), c.eigenvalues)
    balance = HarmonicBalance(structure.contact(everything), points.balance.acceleration)
    motions, found = modal(points), checked(points)
    for k in (0, len(motions) // 2):
        along = (points.direction(k) @ points.balance.model.vectors.T)[None]
        one = correction(balance, motions[k], points.frequencies[k], along)
        np.testing.assert_allclose(one.modal, found[k].modal, rtol=0.0, atol=1e-4 * np.abs(one.modal).max())


def test_the_mean_alone_is_corrected_as_with_the_motion(rough: tuple[Structure, HarmonicCurve]) -> None:
    """At a motion of the full model whose mean is disturbed, both corrections lead back to its mean."""
    structure, points = rough
    full = full_motions(points, checked(points), KRYLOV_TOLERANCE)
    assert full is not None
    means = corrected_means(points.balance, full.coefficients, full.frequencies)
    values = structure.condensation.eigenvalues
    disturbed = full.coefficients.copy()
    disturbed[:, 0] *= 1.0 + 1e-3
    again = corrected_means(points.balance, disturbed, full.frequencies)
    for mean, other, before in zip(means, again, full.coefficients[:, 0], strict=True):
        size = np.linalg.norm(np.sqrt(values) * before)
        assert np.linalg.norm(np.sqrt(values) * (mean - before)) < 1e-3 * size
        assert np.linalg.norm(np.sqrt(values) * (other - mean)) < 2e-5 * size


def test_means_along_a_curve_count_as_in_their_motions(
    rough: tuple[Structure, HarmonicCurve], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of two unused points and of the motion where the means differ most, per energy norm of each motion."""
    _, points = rough
    monkeypatch.setattr(newton, "MOST_MEANS", 2)
    monkeypatch.setattr(newton, "MIDDLES", 1)
    last = len(points.frequencies) - 1
    found = scaled_means(points, {1, last}, KRYLOV_TOLERANCE)
    motions, root = modal(points), np.sqrt(points.balance.model.condensation.eigenvalues)
    sizes = np.linalg.norm(root * motions, axis=(1, 2))
    wide = int(np.argmax(np.linalg.norm(root * np.diff(motions[:, 0] / sizes[:, None], axis=0), axis=1)))
    chosen = np.stack([motions[0], motions[last - 1], motions[wide : wide + 2].mean(axis=0)])
    frequencies = np.array([*points.frequencies[[0, last - 1]], points.frequencies[wide : wide + 2].mean()])
    means = corrected_means(points.balance, chosen, frequencies)
    norms = [sizes[0], sizes[last - 1], sizes[wide : wide + 2].mean()]
    assert found.shape[1] == 3
    for column, mean, size in zip(found.T, means, norms, strict=True):
        assert np.linalg.norm(root * (column * size - mean)) < 1e-4 * np.linalg.norm(root * mean) + 1e-12 * size


def test_motions_that_do_not_converge_are_left_out(rough: tuple[Structure, HarmonicCurve]) -> None:
    _, points = rough
    found = checked(points)
    lost = SimpleNamespace(energy=np.inf, moving=np.inf, modal=np.full_like(found[0].modal, np.nan))
    assert full_motions(points, [lost] * len(found), 1e-3) is None
    rest = full_motions(points, [lost, *found[1:]], 1e-3)
    assert rest is not None
    np.testing.assert_array_equal(rest.frequencies, points.frequencies[1:])
    assert np.isfinite(rest.coefficients).all()


def test_a_basis_of_motions_holds_the_modes_that_harmonics_reach_and_the_means(
    rough: tuple[Structure, HarmonicCurve],
) -> None:
    """Modes up to 1.05 times the third harmonic; the span misses the rest of the shapes by less than ``least`` each."""
    structure, points = rough
    c, least = structure.condensation, 1e-3
    full = full_motions(points, checked(points), KRYLOV_TOLERANCE)
    assert full is not None
    reached = reached_modes(c, full, points.balance.orders, least)
    highest = REACH * 3.0 * points.frequencies.max()
    assert len(reached)
    assert (np.sqrt(c.eigenvalues[reached]) < highest).all()
    means = scaled_means(points, (), 1e-5)
    model = principal_span(c, full.coefficients, least, structure.symmetry, modes=reached, means=means)
    kept = np.linalg.norm(model.vectors[reached], axis=1)
    np.testing.assert_allclose(kept, 1.0, rtol=1e-9)
    root = np.sqrt(c.eigenvalues)
    norms = np.linalg.norm(full.coefficients * root, axis=(1, 2))
    shapes = np.column_stack([*(motion.T / norm for motion, norm in zip(full.coefficients, norms, strict=True)), means])
    left = root[:, None] * (shapes - model.vectors @ (model.vectors.T @ shapes))
    assert np.linalg.norm(left, axis=0).max() < 2.0 * least
    smaller = principal_span(c, full.coefficients, least, structure.symmetry)
    without = root[:, None] * (means - smaller.vectors @ (smaller.vectors.T @ means))
    assert np.linalg.norm(without, axis=0).max() > np.linalg.norm(left[:, -means.shape[1] :], axis=0).max()


def test_a_basis_needs_no_mode_that_no_motion_has(rough: tuple[Structure, HarmonicCurve]) -> None:
    structure, points = rough
    motions = np.zeros((2, 3, len(structure.condensation.eigenvalues)))
    lowest = np.argsort(structure.condensation.eigenvalues)
    motions[:, 1, lowest[0]], motions[:, 1, lowest[-1]] = 1.0, 1.0
    few = Motions(motions, points.frequencies[:2], None)
    reached = reached_modes(structure.condensation, few, np.array([0.0, 1.0, 1.0]), 1e-3)
    assert set(reached) <= {lowest[0]}


def test_corrections_together_are_those_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    curve = trained_roll(12, 4).curve
    points = curve.take(list(range(0, len(curve.frequencies), 4)))
    monkeypatch.setattr(corrections_module, "TOGETHER", 3)
    for k, one in enumerate(checked(points)):
        alone = correction(points.balance, points.coefficients[k], points.frequencies[k], points.direction(k)[None])
        np.testing.assert_allclose(one.modal, alone.modal, rtol=0.0, atol=1e-4 * np.abs(alone.modal).max())
        assert one.energy == pytest.approx(alone.energy, rel=1e-4)
