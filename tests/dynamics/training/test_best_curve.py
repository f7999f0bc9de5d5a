"""The result of a training whose errors do not fall from one basis to the next: the best of its accurate curves."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from support.periodic import small_roll

from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.training import checked_curve, course, enrichment, training
from wroll_fem.dynamics.training.enrichment import trained_backbone, trained_response
from wroll_fem.dynamics.training.training import Trained
from wroll_fem.dynamics.training.training_state import TrainingFile
from wroll_fem.errors import ConvergenceError


def response(errors: tuple[float, ...], **settings: object) -> Trained[HarmonicCurve]:
    """Response curve of a small roll from as many passes as there are errors; no basis reaches its tolerance."""
    system, preload, condensation = small_roll(12, 4)
    asked = {"amplitude": 5.0, "frequencies": (140.0, 165.0), "tolerance": 1e-9, "max_rounds": len(errors)}
    return trained_response(condensation, preload, system.laws, **asked, **settings)  # type: ignore[arg-type]


def with_errors(monkeypatch: pytest.MonkeyPatch, errors: tuple[float, ...]) -> list[int]:
    """Let the errors of the passes be the given ones, and their curves move; returns the sizes of the bases."""
    monkeypatch.setattr(training, "COARSE", 1.0)
    monkeypatch.setattr(course, "MOVABLE", 1e9)
    next_curve, sizes = course._Course.next_curve, list[int]()

    def checked(self, number):  # type: ignore[no-untyped-def]
        found = next_curve(self, number)
        sizes.append(found.curve.balance.model.size)
        share = errors[number - 1] / found.error
        held = [dataclasses.replace(one, energy=share * one.energy, tip=share * one.tip) for one in found.held]
        return dataclasses.replace(found, held=held)

    monkeypatch.setattr(course._Course, "next_curve", checked)
    return sizes


def assert_solved(curve: HarmonicCurve | BackboneCurve) -> None:
    """A Newton step changes no point by more than 2e-6 of its motion, in the energy norm.

    The residual itself is no measure: Newton's method ends by its correction, and the stiffest modes, whose motion is
    rounding, hold most of the residual (1e-5 to 4e-5 of the load, depending on the kernels of OpenBLAS).
    """
    assert isinstance(curve, HarmonicCurve)
    balance = curve.balance
    active = balance.contact.active
    for q, w in zip(curve.coefficients, curve.frequencies, strict=True):
        residual, contact = balance.residual(q, w)
        step = np.zeros(q.size)
        step[active] = np.linalg.solve(balance.jacobian(q, w, contact)[0], residual.ravel()[active])
        root = np.sqrt(np.maximum(balance.model.eigenvalues, 0.0) + w**2)
        assert np.linalg.norm(root * step.reshape(q.shape)) < 2e-6 * np.linalg.norm(root * q)


@pytest.mark.parametrize("sparse", [0.0, 10.0])
@pytest.mark.parametrize(
    ("errors", "best"),
    [((0.05, 0.004, 0.006, 0.02), 2), ((0.05, 0.006, 0.004, 0.005), 3), ((0.05, 0.006, 0.004), 3)],
)
def test_the_best_accurate_curve_is_the_result(
    errors: tuple[float, ...], best: int, sparse: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether all of its points were solutions when it was kept, or only the checked ones and those of the basis."""
    monkeypatch.setattr(course, "SPARSE", sparse)
    sizes = with_errors(monkeypatch, errors)
    found = response(errors)
    assert found.rounds == len(errors)
    assert found.energy_error == pytest.approx(errors[best - 1])
    assert 0.0 < found.tip_error < found.energy_error
    assert found.curve.balance.model.size == sizes[best - 1]
    assert_solved(found.curve)


def test_the_best_backbone_is_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = with_errors(monkeypatch, (0.004, 0.02))
    system, preload, condensation = small_roll(12, 4)
    found = trained_backbone(
        condensation, preload, system.laws, tip_amplitudes=(1e-6, 3e-5), tolerance=1e-9, max_rounds=2
    )
    assert found.energy_error == pytest.approx(0.004)
    assert found.curve.balance.model.size == sizes[0] < sizes[1]
    assert found.curve.beyond == 0


def test_a_backbone_that_ends_early_is_kept_without_what_lies_beyond_its_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """Motions beyond the end train a basis only; amplitudes there may fall again."""
    with_errors(monkeypatch, (0.004, 0.02))
    solve = enrichment._BackboneTask.solve
    solved: list[BackboneCurve] = []

    def ended(self, model, factor):  # type: ignore[no-untyped-def]
        curve = solve(self, model, factor)
        solved.append(dataclasses.replace(curve, cut="it slides", beyond=3))
        return solved[-1]

    monkeypatch.setattr(enrichment._BackboneTask, "solve", ended)
    monkeypatch.setattr(checked_curve, "UNSURE", np.inf)
    system, preload, condensation = small_roll(12, 4)
    reach = {"tip_amplitudes": (1e-6, 3e-5), "tolerance": 1e-9, "max_rounds": 2}
    found = trained_backbone(condensation, preload, system.laws, **reach)  # type: ignore[arg-type]
    assert found.energy_error == pytest.approx(0.004)
    assert (found.curve.cut, found.curve.beyond) == ("it slides", 0)
    np.testing.assert_array_equal(found.curve.frequencies, solved[0].frequencies[:-3])


@pytest.mark.parametrize("gap", [False, True])
def test_a_complete_curve_is_better_than_one_with_a_gap(gap: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = with_errors(monkeypatch, (0.05, 0.004, 0.006, 0.02))
    next_curve = course._Course.next_curve

    def with_gap(self, number):  # type: ignore[no-untyped-def]
        found = next_curve(self, number)
        curve = dataclasses.replace(found.curve, gap=(900.0, 910.0) if gap and number == 2 else None)
        return dataclasses.replace(found, curve=curve)

    monkeypatch.setattr(course._Course, "next_curve", with_gap)
    found = response((0.05, 0.004, 0.006, 0.02))
    assert found.curve.gap is None
    assert found.curve.balance.model.size == sizes[2 if gap else 1]


@pytest.mark.parametrize("everywhere", [False, True])
def test_a_training_that_fails_after_an_accurate_curve_returns_it(
    everywhere: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Unless its curve ends in every basis: the accurate one has missed why."""
    errors = (0.05, 0.004, 0.006)
    sizes = with_errors(monkeypatch, errors)
    monkeypatch.setattr(course, "MOVABLE", 0.0)
    monkeypatch.setattr(course, "ends_in_every_basis", lambda *_: everywhere)
    solve, followed = enrichment._ResponseTask.solve, list[int]()

    def ending(self, model, factor):  # type: ignore[no-untyped-def]
        curve = solve(self, model, factor)
        followed.append(model.size)
        if len(followed) < 3:
            return curve
        stop = ConvergenceError("it ends", time_s=None, iterations=1, residual_history=[1.0], advice="none")
        stop.partial = curve.take(list(range(len(curve.frequencies) // 2)))
        raise stop

    monkeypatch.setattr(enrichment._ResponseTask, "solve", ending)
    if everywhere:
        with pytest.raises(ConvergenceError, match="it ends"):
            response(errors)
        return
    found = response(errors)
    assert found.energy_error == pytest.approx(0.004)
    assert found.curve.balance.model.size == sizes[1]
    assert found.rounds == len(followed) == 3
    assert_solved(found.curve)


@pytest.mark.parametrize("last", [0.006, 0.02])
def test_a_kept_curve_that_loses_a_point_is_no_result(last: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """The last curve takes its place if it is accurate enough."""
    errors = (0.05, 0.004, last)
    monkeypatch.setattr(course, "SPARSE", 10.0)
    sizes = with_errors(monkeypatch, errors)
    again = enrichment._ResponseTask.again

    def losing(self, points, model, starts=None, only=None):  # type: ignore[no-untyped-def]
        found = again(self, points, model, starts, only)
        lost = only is None and starts is None and model.size == sizes[1]
        return found.take(list(range(1, len(found.frequencies)))) if lost else found

    monkeypatch.setattr(enrichment._ResponseTask, "again", losing)
    if last > checked_curve.DOUBTFUL:
        with pytest.raises(ConvergenceError, match=r"does not reach harmonic\.reduction_tolerance"):
            response(errors)
        return
    found = response(errors)
    assert found.energy_error == pytest.approx(last)
    assert_solved(found.curve)


@pytest.mark.parametrize("sparse", [0.0, 10.0])
def test_every_state_of_a_training_continues_to_the_best_curve(
    sparse: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also from states after the best curve, which then exists only in the checkpoint."""
    errors, path = (0.05, 0.004, 0.006, 0.02), tmp_path / "state.npz"
    monkeypatch.setattr(course, "SPARSE", sparse)
    with_errors(monkeypatch, errors)
    states: list[bytes] = []
    keep = TrainingFile.keep

    def kept(self: TrainingFile, *rest: object) -> None:
        keep(self, *rest)  # type: ignore[arg-type]
        states.append(self.path.read_bytes())

    with monkeypatch.context() as patch:
        patch.setattr(TrainingFile, "keep", kept)
        whole = response(errors, file=TrainingFile(path, seconds=0.0))
    assert len(states) == 3
    for state in states:
        path.write_bytes(state)
        found = response(errors, file=TrainingFile(path, resume=True))
        assert (found.rounds, found.energy_error, found.tip_error) == (4, whole.energy_error, whole.tip_error)
        np.testing.assert_array_equal(found.curve.frequencies, whole.curve.frequencies)
        np.testing.assert_array_equal(found.curve.transmissibility, whole.curve.transmissibility)
