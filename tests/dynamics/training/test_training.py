"""Training of the basis: curves with more harmonics, points moved to another model, rolls of which little moves."""

from __future__ import annotations

import dataclasses
import re
from types import SimpleNamespace

import numpy as np
import pytest
from support.periodic import small_roll, trained_roll

from wroll_fem.analyses.curve_reading import unbounded_reading
from wroll_fem.dynamics.aft.half_period import HalfPeriod
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic import causes
from wroll_fem.dynamics.periodic.causes import with_cause
from wroll_fem.dynamics.periodic.first_guesses import carried_along
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.dynamics.periodic.response import HarmonicCurve, response_curve
from wroll_fem.dynamics.training import checked_curve, course, enrichment, training
from wroll_fem.dynamics.training.correction import correction
from wroll_fem.dynamics.training.enrichment import trained_backbone, trained_response
from wroll_fem.dynamics.training.growth import enriched
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.dynamics.training.training import Training
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.continuation import CurvePoint, StepControl


def test_a_roll_that_sticks_has_a_curve() -> None:
    """Nothing slips, so that no even harmonic moves: a basis of one kind of shapes."""
    system, preload, condensation = small_roll(8, 3)
    trained = trained_response(condensation, preload, system.laws, amplitude=1e-4, frequencies=(100.0, 120.0))
    assert trained.energy_error < 1e-3
    assert np.all(np.diff(np.abs(trained.curve.transmissibility)) > 0.0)  # below resonance


def test_further_harmonics_leave_the_motion_and_the_direction_of_the_curve() -> None:
    system, preload, condensation = small_roll(12, 4)
    symmetry = HalfPeriod.of(condensation, preload, system.laws)
    model = Structure.of(condensation, preload, system.laws, Sampling(3, 64), 8).first_model()
    contacts = [HarmonicContact(model, preload, system.laws, Sampling(h, 64), symmetry=symmetry) for h in (3, 5)]
    curve = response_curve(contacts[0], amplitude=5.0, frequencies=(140.0, 165.0), control=StepControl().longer(2.5))
    richer = curve.extended(contacts[1])
    assert richer.coefficients.shape[1] == contacts[1].sampling.size
    np.testing.assert_array_equal(richer.coefficients[:, :7], curve.coefficients)
    k = len(curve.frequencies) // 2
    np.testing.assert_allclose(richer.direction(k)[:7], curve.direction(k), rtol=1e-12, atol=0.0)
    assert not richer.direction(k)[7:].any()
    few = richer.take([0, k])
    moved = few.moved_to(contacts[1], StepControl())
    for q, w in zip(moved.coefficients, moved.frequencies, strict=True):
        residual, _ = moved.balance.residual(q, w)
        assert np.linalg.norm(residual) < 1e-5 * np.linalg.norm(moved.balance.load())
    np.testing.assert_allclose(moved.frequencies, few.frequencies, rtol=5e-3)
    assert np.abs(moved.coefficients[1, 7:]).max() > 0.0


@pytest.mark.parametrize("kind", ["response", "backbone"])
def test_a_curve_of_which_some_points_were_recomputed_ends_as_one_of_solutions(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between the passes only the points of the basis and of the check are solved; at the end all are."""
    system, preload, condensation = small_roll(12, 4)
    recomputed: list[int] = []
    moved_to = HarmonicCurve.moved_to

    def counted(self: HarmonicCurve, contact: HarmonicContact, control: StepControl, *rest: object) -> HarmonicCurve:
        if len(rest) > 1 and rest[1] is not None:
            recomputed.append(len(rest[1]))  # type: ignore[arg-type]
        return moved_to(self, contact, control, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(HarmonicCurve, "moved_to", counted)
    monkeypatch.setattr(training, "COARSE", 1.0)
    monkeypatch.setattr(course, "MOVABLE", 1e9)
    found = []
    for sparse in (0.0, 10.0):
        monkeypatch.setattr(course, "SPARSE", sparse)
        if kind == "response":
            trained = trained_response(
                condensation, preload, system.laws, amplitude=5.0, frequencies=(140.0, 165.0), tolerance=1e-4
            )
            size = np.abs(trained.curve.transmissibility)
        else:
            trained = trained_backbone(condensation, preload, system.laws, tip_amplitudes=(1e-6, 3e-5), tolerance=1e-4)
            size = trained.curve.damping
        found.append((trained.curve.frequencies, size))
        assert trained.energy_error < 1e-4
    (frequencies, size), (others, other) = found
    np.testing.assert_allclose(others, frequencies, rtol=2e-5)
    np.testing.assert_allclose(other, size, rtol=2e-3, atol=1e-3 * size.max())
    if kind == "response":
        assert recomputed
        assert min(recomputed) < len(frequencies)
        for q, w in zip(trained.curve.coefficients, trained.curve.frequencies, strict=True):
            residual, _ = trained.curve.balance.residual(q, w)
            assert np.linalg.norm(residual) < 3e-5 * np.linalg.norm(trained.curve.balance.load())


@pytest.mark.parametrize("slow", [0.0, np.inf])
def test_more_points_enrich_the_basis_where_errors_fall_slowly(slow: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the few points of fast ones, HabEx with E = 1 GPa at 2 MPa stayed above 0.9 %, and had no curve."""
    system, preload, condensation = small_roll(12, 4)
    corrected: list[int] = []
    check = enrichment._ResponseTask.check

    def counted(self, points, *rest):  # type: ignore[no-untyped-def]
        corrected.append(len(points.frequencies))
        return check(self, points, *rest)

    monkeypatch.setattr(enrichment._ResponseTask, "check", counted)
    monkeypatch.setattr(training, "COARSE", 1.0)
    monkeypatch.setattr(course, "MOVABLE", 1e9)
    monkeypatch.setattr(course, "SLOW", slow)
    asked = {"amplitude": 5.0, "frequencies": (140.0, 165.0), "tolerance": 1e-9, "max_rounds": 3}
    found = trained_response(condensation, preload, system.laws, **asked)
    assert len(found.curve.frequencies) > training.MOST_TRAINED
    assert (max(corrected) > enrichment.RESPONSE_TRAINED) == (slow == 0.0)
    assert max(corrected) <= training.MOST_TRAINED


@pytest.mark.parametrize("tolerance", [1e-4, 1e-9])
def test_a_curve_that_loses_a_point_when_it_is_completed_is_computed_anew(
    tolerance: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also in the last pass, and where no basis reaches the tolerance but the error is small enough for a warning."""
    system, preload, condensation = small_roll(12, 4)
    asked = {"amplitude": 5.0, "frequencies": (140.0, 165.0), "tolerance": tolerance}
    monkeypatch.setattr(training, "COARSE", 1.0)
    monkeypatch.setattr(course, "MOVABLE", 1e9)
    monkeypatch.setattr(course, "SPARSE", 10.0)
    rounds = 3
    if tolerance == 1e-4:
        rounds = trained_response(condensation, preload, system.laws, **asked).rounds
    again, solve, lost, followed = enrichment._ResponseTask.again, enrichment._ResponseTask.solve, [], []

    def losing(self, points, model, starts=None, only=None):  # type: ignore[no-untyped-def]
        found = again(self, points, model, starts, only)
        if starts is None and only is None:
            lost.append(len(found.frequencies))
            return found.take(list(range(1, len(found.frequencies))))
        return found

    def counted(self, model, factor):  # type: ignore[no-untyped-def]
        followed.append(factor)
        return solve(self, model, factor)

    monkeypatch.setattr(enrichment._ResponseTask, "again", losing)
    monkeypatch.setattr(enrichment._ResponseTask, "solve", counted)
    found = trained_response(condensation, preload, system.laws, **asked, max_rounds=rounds)
    assert len(lost) == 1
    assert len(followed) == 2  # the first curve, and the one anew
    assert found.rounds == rounds
    assert found.energy_error < (tolerance if tolerance == 1e-4 else checked_curve.DOUBTFUL)
    for q, w in zip(found.curve.coefficients, found.curve.frequencies, strict=True):
        residual, _ = found.curve.balance.residual(q, w)
        assert np.linalg.norm(residual) < 3e-5 * np.linalg.norm(found.curve.balance.load())


def test_an_acceptable_curve_is_kept_when_the_basis_grows_too_large(monkeypatch: pytest.MonkeyPatch) -> None:
    """No curve is computed in a basis above the limit: it may be worse, and the training may end without a curve."""
    system, preload, condensation = small_roll(12, 4)
    sizes: list[int] = []

    def response():  # type: ignore[no-untyped-def]
        sizes.clear()
        return trained_response(
            condensation, preload, system.laws, amplitude=5.0, frequencies=(140.0, 165.0), tolerance=1e-12,
            on_round=lambda number, model, error: sizes.append(model.size),
        )  # fmt: skip

    response()
    largest = sizes[-2]
    monkeypatch.setattr(course, "LARGEST_BASIS", largest)
    found = response()
    assert max(sizes) <= largest
    assert 1e-12 < found.energy_error <= checked_curve.DOUBTFUL


def test_points_between_solutions_are_shifted_like_them() -> None:
    """A shift that is linear along the curve is found exactly; beyond the last solution it is constant."""
    x = np.array([0.0, 1.0, 1.5, 4.0, 6.0, 7.0])
    places = np.column_stack([x, 0.0 * x])
    shift = np.column_stack([0.1 * x, 2.0 - 0.3 * x])
    solved = {0, 3, 4}
    points = [
        CurvePoint(place + (k in solved) * move, np.array([1.0, 0.0]), 1, True)
        for k, (place, move) in enumerate(zip(places, shift, strict=True))
    ]
    out = np.array([point.z for point in carried_along(points, places, solved)])
    np.testing.assert_allclose(out[:5], (places + shift)[:5], rtol=1e-14)
    np.testing.assert_allclose(out[5], places[5] + shift[4], rtol=1e-14)
    assert carried_along(points[:5], places, solved) == points[:5]  # a point is missing


def test_estimate_holds_between_the_checked_points() -> None:
    trained = trained_roll(12, 4)
    curve = trained.curve
    errors = [
        correction(curve.balance, curve.coefficients[k], curve.frequencies[k], curve.direction(k)[None]).energy
        for k in range(0, len(curve.frequencies), 3)
    ]
    assert trained.energy_error < 1e-3
    assert max(errors) < 2.5e-3
    assert np.mean(errors) == pytest.approx(0.0, abs=1e-3)


def test_a_correction_that_is_not_finite_counts_as_infinite() -> None:
    """max() of 1e-3 and nan is 1e-3: such a motion would pass the check of the basis."""
    curve = trained_roll(12, 4).curve
    broken = HarmonicBalance(curve.balance.contact, np.nan)
    found = correction(broken, curve.coefficients[0], curve.frequencies[0], curve.direction(0)[None])
    assert found.energy == np.inf
    assert found.tip == np.inf
    assert not found.shapes.any()
    assert not found.modal.any()


def test_a_gap_has_its_resonance_in_its_middle_or_is_refused() -> None:
    """A stuck roll is undamped: the gap may grow while its edges are steep, as its middle is f_n then."""
    system, preload, condensation = small_roll(8, 3)
    curve = trained_response(condensation, preload, system.laws, amplitude=1e-4, frequencies=(100.0, 250.0)).curve
    assert curve.gap is not None
    main = np.argmax(np.abs(condensation.base * condensation.tip) / condensation.eigenvalues)
    f_n = np.sqrt(condensation.eigenvalues[main])
    assert np.mean(curve.gap) == pytest.approx(f_n, rel=1e-3)
    size = np.abs(curve.transmissibility)
    below, above = curve.frequencies <= curve.gap[0], curve.frequencies >= curve.gap[1]
    steep = curve.with_gap(curve.frequencies[below & (size > 250)][0], curve.frequencies[above & (size > 250)][-1])
    assert steep is not None
    assert len(steep.frequencies) < len(curve.frequencies)
    assert np.mean(steep.gap) == pytest.approx(f_n, rel=5e-3)
    edge = np.abs(steep.transmissibility[np.isin(steep.frequencies, steep.gap)]).min()
    assert 250.0 < edge < 500.0
    for found, height in ((steep, edge), (curve, 500.0)):
        reading = unbounded_reading(found)
        assert reading is not None
        assert f"grows beyond {height:.0f} times the base motion" in reading.damping.reason
    assert curve.with_gap(curve.frequencies[below & (size > 20)][0], curve.gap[1]) is None
    assert curve.with_gap(curve.frequencies[0], curve.frequencies[-1]) is None


def test_no_point_left_in_a_larger_basis_is_no_error() -> None:
    system, preload, condensation = small_roll(8, 3)
    structure = Structure.of(condensation, preload, system.laws, Sampling(3, 64), 8)
    model = structure.first_model()
    curve = response_curve(structure.contact(model), amplitude=5.0, frequencies=(140.0, 150.0))
    points = curve.take([0, 1])
    found = [
        correction(points.balance, points.coefficients[k], points.frequencies[k], points.direction(k)[None])
        for k in range(2)
    ]
    nothing = HarmonicCurve.of_points(points.problem, [])
    nowhere = SimpleNamespace(check=lambda *_: [], again=lambda *_: nothing, full_motions=lambda *_: None)
    larger = enriched(structure, Training(tolerance=1e-9), points, found, nowhere, around=curve)
    assert larger.size > model.size


@pytest.mark.parametrize(
    ("overtones", "drifts", "curves", "cause"),
    [
        (0.0, False, 2, "use a larger|else"),
        (0.43, False, 1, "internal resonance at .* Hz: higher harmonics are 43 %"),
        (0.0, True, 1, "mean displacement is undetermined"),
    ],
)
def test_curves_that_end_at_one_motion_are_not_trained_further(
    overtones: float, drifts: bool, curves: int, cause: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every basis gives up at the same place; two curves show it, and one is enough where the cause is known."""
    system, preload, condensation = small_roll(8, 3)
    ended = []

    def stopped(contact: HarmonicContact, **given: object) -> HarmonicCurve:
        curve = response_curve(contact, **given)
        error = ConvergenceError(
            "the curve could not be followed", time_s=None, iterations=12, residual_history=[0.1], advice="else"
        )
        error.partial = curve.take(list(range(int(0.6 * len(curve.frequencies)))))
        ended.append(error.partial)
        raise error

    monkeypatch.setattr(enrichment, "response_curve", stopped)
    monkeypatch.setattr(HarmonicCurve, "overtones", lambda self, k: overtones)
    monkeypatch.setattr(HarmonicCurve, "drifts", drifts)
    monkeypatch.setattr(causes, "SAFE_END", 10.0)  # the first bases of a small roll are rough
    with pytest.raises(ConvergenceError, match="could not be followed") as failure:
        trained_response(condensation, preload, system.laws, amplitude=5.0, frequencies=(140.0, 165.0), tolerance=1e-12)
    assert len(ended) <= curves + 1  # and the coarse first curve
    assert re.search(cause, str(with_cause(failure.value, condensation, system.laws)))


@pytest.mark.parametrize(("shift", "drifts"), [(20.0, False), (100.0, True)])
def test_a_curve_ends_where_its_mean_displacement_leaves_the_motion(shift: float, drifts: bool) -> None:
    """The mean displacement alone ends the curve; the oscillation is that of a good one."""
    system, preload, condensation = small_roll(8, 3)
    contact = Structure.of(condensation, preload, system.laws, Sampling(3, 64), 8)
    curve = response_curve(contact.contact(contact.first_model()), amplitude=5.0, frequencies=(140.0, 150.0))
    motion = curve.coefficients[-1].copy()
    oscillation = np.linalg.norm(motion[1:] * curve.problem.root)
    motion[0] = shift * max(curve.problem.size, oscillation) / curve.problem.root / np.sqrt(motion.shape[1])
    moved = dataclasses.replace(curve, coefficients=np.array([*curve.coefficients[:-1], motion]))
    assert moved.drifts == drifts
    assert curve.problem.ended(curve.problem.scaled(motion, curve.frequencies[-1])) == drifts
    assert not curve.drifts


@pytest.mark.parametrize(
    ("amplitude", "told"),
    [
        (10.0, "use a larger harmonic.reduction_tolerance"),
        (20.0, r"at 14\d\.\d Hz the basis vectors miss 3\d % of the mo"),
    ],
)
def test_a_training_that_fails_says_what_to_try(amplitude: float, told: str) -> None:
    """A larger tolerance if little of the motions is missed, or else the frequency at which most is."""
    system, preload, condensation = small_roll(12, 4)
    with pytest.raises(ConvergenceError, match=told):
        trained_response(
            condensation, preload, system.laws, amplitude=amplitude, frequencies=(140.0, 165.0), max_rounds=1
        )
