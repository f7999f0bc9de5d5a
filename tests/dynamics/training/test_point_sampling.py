"""Hyper-reduction: forces of a weighted subset of the contact points, and curves that are followed on it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from support.periodic import small_roll

from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.harmonic_balance import FrequencyCurve, HarmonicBalance
from wroll_fem.dynamics.periodic.point_sample import Motions, sample_error, sampled
from wroll_fem.dynamics.periodic.reading_points import with_reading_points
from wroll_fem.dynamics.periodic.response import HarmonicCurve, response_curve
from wroll_fem.dynamics.reduction.evaluated_points import PointSample
from wroll_fem.dynamics.training.enrichment import trained_backbone, trained_response
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.dynamics.training.training import Trained
from wroll_fem.numerics.continuation import StepControl

SHAKEN = {"amplitude": 5.0, "frequencies": (140.0, 165.0)}


class Roll(NamedTuple):
    """Roll of 18 x 10 cells with its curve, computed with all points."""

    structure: Structure
    trained: Trained[HarmonicCurve]
    whole: HarmonicContact
    motions: Motions


@cache
def roll(*overrides: str, amplitude: float = 5.0) -> Roll:
    system, preload, condensation = small_roll(18, 10, "mesh.grading=40", *overrides)
    found = trained_response(condensation, preload, system.laws, **SHAKEN | {"amplitude": amplitude})
    structure = Structure.of(condensation, preload, system.laws, Sampling(3, 64), 8)
    curve = found.curve
    whole = structure.contact(curve.balance.model)
    chosen = np.linspace(0, len(curve.frequencies) - 1, 12).astype(int)
    vectors = curve.balance.model.vectors
    return Roll(structure, found, whole, Motions(curve.coefficients[chosen], curve.frequencies[chosen], vectors))


def test_the_factors_are_positive_and_give_forces_and_work_of_the_motions() -> None:
    """Tolerance 5e-3 of the sketched equations: 1e-2 for the forces alone. Works: 5e-4 of the largest, not sketched."""
    structure, _, whole, motions = roll()
    sample = sampled(whole, motions)
    assert sample is not None
    assert (sample.factors > 0.0).all()
    assert len(sample.points) < whole.n / 2
    part, root = structure.contact(whole.model, sample=sample), np.sqrt(whole.model.eigenvalues)
    wrong = size = 0.0
    works = []
    for q, w in zip(motions.coefficients, motions.frequencies, strict=True):
        forces = [c.force(c.evaluate(c.motion(q), w)) / root / np.linalg.norm(q * root) for c in (part, whole)]
        wrong, size = wrong + np.sum((forces[0] - forces[1]) ** 2), size + np.sum(forces[1] ** 2)
        works.append([HarmonicBalance(c, 5.0).cycle_work(q, w) for c in (part, whole)])
    assert np.sqrt(wrong / size) < 1e-2
    largest = max(whole_work.interface for _, whole_work in works)
    for of_part, of_whole in works:
        assert of_part.friction >= -1e-12 * largest
        assert of_part.interface == pytest.approx(of_whole.interface, abs=6e-4 * largest)


def test_a_subset_of_all_points_is_the_whole_interface() -> None:
    structure, _, whole, motions = roll()
    every = PointSample(np.arange(whole.n), np.ones(whole.n))
    same = structure.contact(whole.model, sample=every)
    q, w = motions.coefficients[6], float(motions.frequencies[6])
    ours, theirs = (c.evaluate(c.motion(q), w) for c in (same, whole))
    np.testing.assert_array_equal(same.force(ours), whole.force(theirs))
    np.testing.assert_array_equal(same.jacobian(ours)[0], whole.jacobian(theirs)[0])
    error = sample_error(whole, every, q[None], np.array([w]), q[None], np.array([w]))
    assert max(error.force, error.work) < 1e-12
    assert error.motion == 0.0


def test_the_tangents_of_two_halves_are_the_tangent_of_the_whole() -> None:
    """Newton's matrix of a subset with the forces of all points: additive, and proportional to the factors."""
    structure, _, whole, motions = roll()
    q, w = motions.coefficients[6], float(motions.frequencies[6])
    state = whole.evaluate(whole.motion(q), w)
    halves = [PointSample(np.arange(k, whole.n, 2), np.full(len(range(k, whole.n, 2)), 3.0)) for k in (0, 1)]
    parts = [structure.contact(whole.model, tangent=half).jacobian(state) for half in halves]
    expected = whole.jacobian(state)
    assert np.abs(parts[0][0]).max() > 0.0
    for ours, theirs in zip((parts[0][0] + parts[1][0], parts[0][1] + parts[1][1]), expected, strict=True):
        np.testing.assert_allclose(ours, 3.0 * theirs, atol=1e-5 * np.abs(theirs).max())  # single precision
    assert structure.contact(whole.model, tangent=halves[0]).complete
    assert not structure.contact(whole.model, sample=halves[0]).complete


def random_roll(seed: int) -> tuple[tuple[str, ...], float]:
    """Overrides of the lab roll and base acceleration, m/s^2."""
    random = np.random.default_rng(seed)
    mu, pressure = random.uniform(0.15, 0.4), 10.0 ** random.uniform(4.7, 5.3)
    slip, amplitude = 10.0 ** random.uniform(-6.3, -5.7), random.uniform(3.0, 8.0)
    friction = f"contact.friction={{law: penalty_coulomb, mu: {mu:.3f}, elastic_slip: {slip:.3e}}}"
    return (friction, f"preload.pressure={pressure:.4e}"), amplitude


def test_points_that_fail_with_the_matrix_of_a_subset_take_that_of_all() -> None:
    """All points with a negative area: Newton's method fails with this matrix at every point."""
    structure, trained, whole, _ = roll()
    size = np.abs(trained.curve.transmissibility)
    near = np.flatnonzero(size > 0.5 * size.max())
    points = trained.curve.take(near[:: max(1, len(near) // 5)].tolist())
    far = replace(points, coefficients=1.1 * points.coefficients)
    poor = structure.contact(whole.model, tangent=PointSample(np.arange(whole.n), np.full(whole.n, -1.0)))
    assert not len(far.moved_to(poor, StepControl()).frequencies)
    largest = []
    control = StepControl(tolerance=3e-8)
    for found in (far.moved_to(poor, control, exact=whole), far.moved_to(whole, control)):
        motions = zip(found.coefficients, found.frequencies, strict=True)
        largest.append(max(float(np.linalg.norm(found.balance.residual(q, w)[0])) for q, w in motions))
        assert len(found.frequencies) == len(points.frequencies)
    assert largest[0] <= 1.01 * largest[1] < 1e-4 * np.linalg.norm(found.balance.load())


def test_points_of_the_readings_take_newtons_matrix_of_the_subset(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are solutions with all points; where Newton's method fails with this matrix, that of all points is taken."""
    structure, _, whole, motions = roll()
    sample = sampled(whole, motions)
    plain = response_curve(whole, **SHAKEN)
    expected = with_reading_points(plain, StepControl())
    built: list[HarmonicContact] = []
    jacobian = FrequencyCurve.jacobian
    monkeypatch.setattr(
        FrequencyCurve, "jacobian", lambda self, z: built.append(self.balance.contact) or jacobian(self, z)
    )
    found = with_reading_points(plain, StepControl(), structure.contact(whole.model, tangent=sample))
    assert built
    assert whole not in built
    assert len(found.frequencies) == len(expected.frequencies) > len(plain.frequencies)
    new = np.flatnonzero(~np.isin(expected.frequencies, plain.frequencies))
    assert len(new) == 5
    peak, beside = new[2], np.isin(np.arange(len(expected.frequencies)), new[[1, 3]])  # points on the flat top
    np.testing.assert_allclose(found.frequencies[~beside], expected.frequencies[~beside], rtol=1e-8)
    np.testing.assert_allclose(found.frequencies[beside], expected.frequencies[beside], rtol=1e-4)
    np.testing.assert_allclose(found.transmissibility[peak], expected.transmissibility[peak], rtol=1e-7)
    for k in new:
        residual, _ = found.balance.residual(found.coefficients[k], found.frequencies[k])
        assert np.linalg.norm(residual) < 1e-5 * np.linalg.norm(found.balance.load())
    poor = structure.contact(whole.model, tangent=PointSample(np.arange(whole.n), np.full(whole.n, -1.0)))
    again = with_reading_points(plain, StepControl(), poor)
    np.testing.assert_array_equal(again.frequencies, expected.frequencies)


def test_a_curve_is_completed_with_the_factors_of_its_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Motions as with new factors at every point; hardly any matrix is factorised."""
    structure, _, whole, motions = roll()
    sample = sampled(whole, motions)
    part, tangent = structure.contact(whole.model, sample=sample), structure.contact(whole.model, tangent=sample)
    curve = response_curve(part, **SHAKEN, control=StepControl(keeps=True))
    count = len(curve.frequencies)
    assert [kept is None for kept in curve.factors] == [True] + [False] * (count - 1)
    assert curve.take([0, 1]).factors == ()
    built = []
    jacobian = FrequencyCurve.jacobian
    monkeypatch.setattr(FrequencyCurve, "jacobian", lambda self, z: built.append(z) or jacobian(self, z))
    loose = StepControl(tolerance=1e-8, max_iterations=36, renewal=0.6)
    found, numbers = [], []
    for one in (curve, replace(curve, factors=())):
        found.append(one.moved_to(tangent, loose, curve.coefficients, exact=whole))
        numbers.append(len(built) - sum(numbers))
    assert len(found[0].frequencies) == len(found[1].frequencies) == count
    assert numbers[0] < 0.3 * count <= count <= numbers[1]
    scaled = found[0].problem.scaled
    for k in range(count):
        ends = [scaled(one.coefficients[k], one.frequencies[k]) for one in found]
        step = ends[0] - ends[1]
        along = found[1].tangents[k]
        assert np.linalg.norm(step - along * (along @ step)) < 1e-5 * max(1.0, np.linalg.norm(ends[0][:-1]))


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2, 3, 4))])
def test_a_curve_on_a_subset_has_peak_and_friction_work_of_the_whole(seed: int) -> None:
    """Peak 0.2 %, friction work 1 %; seed 0 is the lab roll."""
    overrides, amplitude = ((), 5.0) if seed == 0 else random_roll(seed)
    structure, _, whole, motions = roll(*overrides, amplitude=amplitude)
    sample = sampled(whole, motions)
    assert sample is not None
    curves = [
        with_reading_points(response_curve(contact, **SHAKEN | {"amplitude": amplitude}), StepControl())
        for contact in (structure.contact(whole.model, sample=sample), whole)
    ]
    peaks, works = [], []
    for curve in curves:
        top = int(np.argmax(np.abs(curve.transmissibility)))
        peaks.append(float(np.abs(curve.transmissibility[top])))
        works.append(curve.balance.cycle_work(curve.coefficients[top], curve.frequencies[top]).friction)
    assert len(sample.points) < whole.n / 2
    assert peaks[0] == pytest.approx(peaks[1], rel=2e-3)
    assert works[0] == pytest.approx(works[1], rel=1e-2)


def test_a_trained_curve_is_completed_with_all_points() -> None:
    """Peak as without subsets to 1e-4 (two bases, tolerance 1e-3 in the energy norm); energy 1e-6; motions exact."""
    structure, without, _, _ = roll()
    found = trained_response(structure.condensation, structure.preload, structure.laws, **SHAKEN, hyper_reduction=True)
    assert found.sample is not None
    assert 0 < found.sample.points < found.sample.of / 2
    assert 0.0 < found.sample.force < 2e-2
    assert found.sample.work < 1e-2
    assert 0.0 < found.sample.motion < 1e-2
    assert without.sample is None
    curve, balance = found.curve, found.curve.balance
    assert balance.contact.complete
    assert found.energy_error <= 1e-3
    peaks = [np.abs(c.transmissibility).max() for c in (curve, without.curve)]
    assert peaks[0] == pytest.approx(peaks[1], rel=3e-4)
    works = [balance.cycle_work(q, w) for q, w in zip(curve.coefficients, curve.frequencies, strict=True)]
    largest = max(work.input for work in works)
    assert max(abs(work.input - work.interface) for work in works) < 1e-6 * largest


@pytest.mark.slow
def test_a_backbone_is_completed_with_all_points() -> None:
    structure, _, _, _ = roll()
    reach = {"tip_amplitudes": (1e-6, 5e-5)}
    found, expected = (
        trained_backbone(structure.condensation, structure.preload, structure.laws, **reach, hyper_reduction=wanted)
        for wanted in (True, False)
    )
    assert found.sample is not None
    assert found.curve.balance.contact.complete
    for name in ("frequencies", "damping"):
        ours, theirs = (np.interp(3e-5, c.tip, getattr(c, name)) for c in (found.curve, expected.curve))
        assert ours == pytest.approx(theirs, rel=2e-3)


def test_few_points_and_stuck_rolls_go_without_a_subset() -> None:
    system, preload, condensation = small_roll(12, 4)
    found = trained_response(condensation, preload, system.laws, **SHAKEN, hyper_reduction=True)
    assert found.sample is None
    structure, _, _, _ = roll()
    stuck = trained_response(
        structure.condensation, structure.preload, structure.laws, amplitude=1e-4, frequencies=(100.0, 120.0),
        hyper_reduction=True,
    )  # fmt: skip
    assert stuck.energy_error < 1e-3
