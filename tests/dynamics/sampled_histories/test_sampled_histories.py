"""Histories on a subset of the contact points: all points that follow, errors that are seen, and limit cases."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from support.interrupted import interrupted
from support.paths import CONFIGS

from wroll_fem import load_case
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.contact import kernels
from wroll_fem.dynamics.reduction.evaluated_points import EvaluatedPoints, PointSample
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.reduction.stuck_modes import modes_to_reduce
from wroll_fem.dynamics.reduction.trained_subset import TrainedSubset
from wroll_fem.dynamics.sampled_histories.following import Followers, _follow_stepwise, follow
from wroll_fem.dynamics.sampled_histories.stepper import SampledStepper, sampled_stepper
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping import simulate as module
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.dynamics.time_stepping.simulate import Checkpointing, make_stepper, simulate
from wroll_fem.dynamics.time_stepping.state import named_arrays
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions, Stepper
from wroll_fem.dynamics.training.enrichment import trained_response
from wroll_fem.dynamics.training.history_points import compressed, history_points, stable
from wroll_fem.errors import ConvergenceError, ReductionError
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.base_motion import Dwell

LAB = CONFIGS / "lab_sweep.yaml"
DT = 1.0 / (150.0 * 40)
STRONG = Dwell(30.0, 150.0, 8.0, ramp_cycles=3.0)
SCHEMES = pytest.mark.parametrize("name", ["hht", "trigonometric"])
FIELDS = ("cumulative_slip", "max_slip", "open_time_fraction", "least_pressure")


def scheme(name: str) -> Scheme:
    return Scheme.named("trigonometric") if name == "trigonometric" else Scheme.hht(-0.05)


@cache
def prepared(
    mesh: str = "{circumferential: 8, axial: 4, grading: 2}", pressure: float = 1e5
) -> tuple[System, ContactState]:
    case = load_case(LAB, [f"mesh={mesh}", f"preload.pressure={pressure}"])
    return prepare(case, SilentProgress())


@cache
def whole(name: str, pressure: float = 1e5) -> tuple[xr.Dataset, ReducedModel]:
    """History with all points, and the model in which it ends."""
    system, state = prepared(pressure=pressure)
    run = make_stepper(system, state, method="reduced", scheme=scheme(name), options=NewtonOptions(), dt=DT)
    assert isinstance(run, ReducedStepper)
    return history(run, name), run.model


def history(run: Stepper, name: str, motion: Dwell = STRONG, **more: object) -> xr.Dataset:
    return simulate(run.system, run.preload, motion, dt=DT, scheme=scheme(name), stepper=run, **more)  # type: ignore[arg-type]


def stepper(name: str, sample: PointSample, model: ReducedModel, pressure: float = 1e5) -> SampledStepper:
    system, state = prepared(pressure=pressure)
    trained = TrainedSubset(model, sample)
    return sampled_stepper(system, state, scheme(name), NewtonOptions(), dt=DT, trained=trained)


def every_point(factor: float = 1.0) -> PointSample:
    n = prepared()[0].n_points
    return PointSample(np.arange(n), np.full(n, factor))


def gap(found: xr.Dataset) -> float:
    """Error of the energy identity, relative to the largest input work."""
    stored = found["kinetic_energy"] + found["strain_energy"] + found["contact_energy"]
    names = ("friction_energy", "pressure_modulation_work", "numerical_dissipation", "material_damping")
    spent = sum(found[name] for name in (*names, "impact_dissipation"))
    return float(np.abs(found["input_work"] - stored - spent).max() / np.abs(found["input_work"]).max())


@SCHEMES
@pytest.mark.parametrize("pressure", [1e5, 1e4])
def test_points_that_follow_have_the_slip_and_the_opening_of_the_integration(name: str, pressure: float) -> None:
    """With all points in the subset both are the same; at 10 kPa points open.

    The trigonometric integration finds turning points within steps from the expected end of the step.
    """
    error = 5e-3 if name == "trigonometric" else 1e-5
    _, model = whole(name, pressure)
    run = stepper(name, every_point(), model, pressure)
    found = history(run, name)
    own = run.accumulated
    assert np.abs(own.slip.path).max() > 1e-6
    for a, b in ((run.slip.path, own.slip.path), (run.slip.peak, own.slip.peak), (run.opening.gap, own.opening.gap)):
        np.testing.assert_allclose(a, b, rtol=0, atol=error * np.abs(b).max())
    np.testing.assert_allclose(run.opening.open_time, own.opening.open_time, atol=1.5 * DT)
    assert abs(run.work_error) < error
    assert run.report()["sampling_motion_error"] < error
    assert gap(found) < 1e-7


@pytest.mark.parametrize("turning", [True, False])
@pytest.mark.parametrize("block", [1, 7, 60])
def test_points_that_stick_through_a_block_follow_as_in_single_steps(block: int, turning: bool) -> None:
    """Of a motion that grows until points slide and open; bit by bit."""
    system, state = prepared(pressure=1e4)
    points = EvaluatedPoints.of(system.laws, state, whole("hht", 1e4)[1].springs)
    rng, steps = np.random.default_rng(5), 120
    shape = rng.normal(size=(3 * points.n, 1)) * np.r_[np.full(2 * points.n, 3e-6), np.full(points.n, 1e-8)][:, None]
    jumps = shape * np.sin(np.arange(1, steps + 1) / 6.0) * np.linspace(0.0, 1.0, steps)
    together, single = Followers.of(state), Followers.of(state)
    shares = [follow(part, points, DT, together, to_turning_points=turning) for part in parts_of(jumps, block)]
    right = np.zeros((steps, 2))
    stepwise = np.ascontiguousarray(jumps.T)
    single.time_step[0] = DT
    _follow_stepwise(stepwise, points.reference, points.laws, DT, turning, single, right)
    assert 0.0 < right[:, 1].max() < points.n
    assert right[:, 0].max() > 0.0
    np.testing.assert_array_equal(np.vstack(shares), right / points.n)
    for name, values in named_arrays(single):
        found = dict(named_arrays(together))[name]
        if name != "accumulated_work":
            np.testing.assert_allclose(found, values, rtol=1e-14, atol=1e-30, err_msg=name)
    friction = single.accumulated.work[kernels.FRICTION]
    assert together.accumulated.work[kernels.FRICTION] == pytest.approx(friction, rel=1e-12)


def parts_of(jumps: np.ndarray, block: int) -> list[np.ndarray]:
    return [jumps[:, i : i + block] for i in range(0, jumps.shape[1], block)]


@SCHEMES
def test_all_points_in_the_subset_give_the_history_of_all_points(name: str) -> None:
    """In the same basis."""
    _, model = whole(name)
    system, state = prepared()
    every = make_stepper(
        system, state, method="reduced", scheme=scheme(name), options=NewtonOptions(), dt=DT, reduction_tolerance=0.1,
        condensation=model.condensation,
    )  # fmt: skip
    assert isinstance(every, ReducedStepper)
    every.adopt(model)
    right, found = history(every, name), history(stepper(name, every_point(), model), name)
    assert every.model.size == model.size
    error = 5e-3 if name == "trigonometric" else 1e-6
    for field in FIELDS:
        expected = right[field].values
        np.testing.assert_allclose(found[field].values, expected, rtol=0, atol=error * np.abs(expected).max())
    same = ("tip_displacement", "friction_energy", "open_fraction", *(("slipping_fraction",) if name == "hht" else ()))
    for field in same:
        np.testing.assert_allclose(found[field].values, right[field].values, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", [pytest.param("hht", marks=pytest.mark.slow), "trigonometric"])
def test_a_trained_subset_has_the_history_and_the_slip_of_all_points(name: str) -> None:
    """Its errors are within those that it states."""
    system, state = prepared("{circumferential: 16, axial: 8, grading: 10}")
    modes = modes_to_reduce(system, state, scheme(name), DT)
    trained = history_points(modes, state, system.laws, amplitude=5.0, frequencies=(140.0, 165.0), tolerance=1e-3)
    assert trained is not None
    assert len(trained.sample.points) < 0.4 * system.n_points
    motion = Dwell(5.0, 154.0, 30.0, ramp_cycles=5.0)
    every = make_stepper(
        system, state, method="reduced", scheme=scheme(name), options=NewtonOptions(), dt=DT, condensation=modes,
        reduction_tolerance=2e-4,
    )  # fmt: skip
    right = history(every, name, motion)
    run = sampled_stepper(system, state, scheme(name), NewtonOptions(), dt=DT, trained=trained)
    found = history(run, name, motion)
    assert float(run.looked[0]) == pytest.approx(trained.largest, rel=0.1)  # the dwell is near the peak of the curve
    tip, work = right["tip_displacement"].values, float(right["friction_energy"][-1])
    stated = found.attrs
    assert stated["sampled_points"] == len(trained.sample.points)
    assert stated["sampling_work_error"] < 1e-2
    assert stated["reduction_error_estimate"] < 5e-3
    assert np.abs(found["tip_displacement"].values - tip).max() < 5e-3 * np.abs(tip).max()
    assert float(found["friction_energy"][-1]) == pytest.approx(work, rel=5e-3)
    slip = right["max_slip"].values
    np.testing.assert_allclose(found["max_slip"].values, slip, rtol=0, atol=1e-2 * slip.max())
    assert gap(found) < 1e-7


def test_principal_shapes_leave_the_tolerance_of_every_motion() -> None:
    system, state = prepared("{circumferential: 16, axial: 8, grading: 10}")
    modes = modes_to_reduce(system, state, scheme("hht"), DT)
    curve = trained_response(
        modes, state, system.laws, amplitude=5.0, frequencies=(140.0, 165.0), harmonics=5, samples=64, tolerance=1e-3,
        hyper_reduction=True,
    ).curve  # fmt: skip
    model = curve.balance.model
    root = np.sqrt(modes.eigenvalues)
    motions = (curve.coefficients @ model.vectors.T) * root
    largest = np.linalg.norm(motions, axis=(1, 2)).max()
    for tolerance in (1e-2, 1e-3):
        small = compressed(curve, tolerance)
        assert small.size < model.size
        span, _ = np.linalg.qr(root[:, None] * small.vectors)
        left = np.linalg.norm(motions - motions @ span @ span.T, axis=(1, 2)).max()
        assert left < tolerance * largest
    assert left > 1e-2 * tolerance * largest  # no more shapes than needed


@pytest.mark.parametrize("factor", [0.5, 0.8])
def test_a_wrong_subset_is_seen(factor: float) -> None:
    """Areas that are wrong by a factor give the friction work this factor in the motion that they cause."""
    _, model = whole("hht")
    run = stepper("hht", every_point(factor), model)
    history(run, "hht")
    assert run.work_error == pytest.approx(factor - 1.0, rel=0.05)
    assert run.report()["sampling_motion_error"] > 0.02


def test_a_subset_that_takes_off_more_stiffness_than_there_is_counts_as_unstable() -> None:
    """Its history diverges: all areas twice as large."""
    system, state = prepared()
    _, model = whole("hht")
    for factor, right in ((0.5, True), (1.0, True), (2.0, False)):
        points = EvaluatedPoints.of(system.laws, state, model.springs, every_point(factor))
        assert stable(model, points) == right
    with pytest.raises(ConvergenceError):
        history(stepper("hht", every_point(2.0), model), "hht")


def test_a_basis_that_lacks_the_motion_is_seen() -> None:
    _, model = whole("hht")
    poor = ReducedModel.of_vectors(model.condensation, model.vectors[:, :6])
    run = stepper("hht", every_point(), poor)
    history(run, "hht")
    assert run.error_estimate > 0.02
    assert run.report()["sampling_motion_error"] < 1e-5
    stopped = stepper("hht", every_point(), poor)
    stopped.largest_error = 0.01
    with pytest.raises(ReductionError, match="the error of the reduced model reaches"):
        history(stopped, "hht")


@SCHEMES
def test_an_interrupted_history_goes_on_bit_by_bit(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _, model = whole(name)
    half = np.arange(0, prepared()[0].n_points, 2)
    some = PointSample(half, np.ones(len(half)))
    monkeypatch.setattr(module, "CHUNK", 40)
    right = history(stepper(name, some, model), name)
    file = Checkpointing(tmp_path / "state.npz")
    with interrupted(monkeypatch, SampledStepper, 4):
        history(stepper(name, some, model), name, checkpoint=file)
    found = history(stepper(name, some, model), name, checkpoint=Checkpointing(file.path, resume=True))
    for variable in ("tip_displacement", "slipping_fraction", "friction_energy", "cumulative_slip"):
        np.testing.assert_array_equal(found[variable], right[variable])
    assert found.attrs["sampling_work_error"] == right.attrs["sampling_work_error"]
