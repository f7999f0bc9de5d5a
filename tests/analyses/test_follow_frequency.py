"""Longer steps of a sweep where its frequency is low (`integrator.follow_frequency`)."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.forecasts.computing_time import estimate_history
from wroll_fem.analyses.shared.preflight import SHARE_OF_90, WANTED_DAMPING, fast_sweeps
from wroll_fem.analyses.shared.time_step import step_at, time_step
from wroll_fem.case import Case, load_case
from wroll_fem.errors import InputError
from wroll_fem.numerics.time_grid import LEAST_STEPS, TimeGrid
from wroll_fem.progress import SilentProgress
from wroll_fem.results.energy import energy_balance_error
from wroll_fem.signals.attainment import rate_for_attainment
from wroll_fem.signals.base_motion import sweep_rate_limit
from wroll_fem.signals.sweeps import Chirp

ROLL = (
    "mesh={circumferential: 8, axial: 3, grading: 4}", "output.figures=false", "preload.pressure=3.0e4",
    "excitation={kind: chirp, amplitude: 20.0, f_start: 20, f_end: 240, rate_oct_per_min: 240}",
)  # fmt: skip


def sweep(*overrides: str) -> Case:
    return load_case(CONFIGS / "lab_sweep.yaml", [*ROLL, *overrides])


def test_equal_steps_cover_the_duration():
    grid = TimeGrid.constant(1.0, 0.3)
    np.testing.assert_allclose(grid.times, [0.0, 0.3, 0.6, 0.9, 1.2])
    assert (grid.count, grid.left(0), grid.left(3)) == (4, 4, 1)


@pytest.mark.parametrize("seed", range(20))
def test_steps_are_halved_where_the_frequency_has_doubled(seed):
    """Upward and downward; a step is as long as its level at every time within it, and half as long as it could be."""
    rng = np.random.default_rng([7, seed])
    low, high, rate = rng.uniform(2.0, 20.0), rng.uniform(100.0, 200.0), rng.uniform(50.0, 900.0)
    levels, dt, down = int(rng.integers(0, 4)), 1.0 / (40.0 * high), bool(rng.integers(2))
    sweep = Chirp(1.0, high, low, rate) if down else Chirp(1.0, low, high, rate)
    order = np.arange(levels + 1)[:: 1 if down else -1]
    passed = high / 2.0 ** (order[1:] if down else order[:-1])
    grid = TimeGrid.of_levels(sweep.duration, dt, order.tolist(), sweep.time_of_frequency(passed))
    np.testing.assert_allclose(np.diff(grid.times), grid.steps, rtol=1e-9)
    assert sweep.duration <= grid.times[-1] * (1 + 1e-9) < sweep.duration + 2**levels * dt + 1e-12
    largest = np.maximum(*sweep.frequency(np.stack([grid.times[:-1], np.minimum(grid.times[1:], sweep.duration)])))
    per_cycle = 1.0 / (grid.steps * largest)
    assert per_cycle.min() > 40.0 * (1 - 1e-9)
    beside = np.abs(np.log2(high / largest) % 1.0) < 0.05  # at most one step of a coarser level is lost at a change
    inside = (largest > 1.05 * high / 2**levels) & ~beside & (np.abs(np.log2(high / largest) % 1.0) < 0.95)
    assert (per_cycle[inside] < 80.0).all()
    pieces = np.split(grid.steps, grid.ends[:-1])
    assert [grid.left(int(end) - len(piece)) for end, piece in zip(grid.ends, pieces, strict=True)] == [
        len(piece) for piece in pieces
    ]
    assert all(np.ptp(piece) == 0.0 for piece in pieces)


@pytest.fixture(scope="module", params=["reduced", pytest.param("condensed", marks=pytest.mark.slow)])
def histories(request) -> tuple[xr.Dataset, xr.Dataset]:
    """Sweep through the resonance of a small roll, with equal steps and with steps that follow the frequency."""
    method = f"solver.method={request.param}"
    equal, longer = (
        run_analysis(sweep(method, f"integrator.follow_frequency={on}"), progress=SilentProgress())
        for on in ("false", "true")
    )
    return equal, longer


def test_a_sweep_with_longer_steps_has_the_same_response(histories):
    """The resonance lies above 120 Hz, where both histories have the same steps."""
    equal, longer = histories
    assert longer.sizes["time"] < 0.65 * equal.sizes["time"]
    steps = np.diff(longer["time"].values)
    assert steps.max() == pytest.approx(2.0 * steps.min())
    assert steps.max() * LEAST_STEPS * longer.attrs["stuck_resonance_hz"] <= 1.0
    bases = {"condensed": 2e-5, "reduced": 1e-4}[longer.attrs["method"]]  # two adaptive bases: 3e-5 on Debian 13
    for name, tolerance in (("f_n_hz", bases), ("peak_transmissibility", 1e-3)):
        assert longer.attrs[name] == pytest.approx(equal.attrs[name], rel=tolerance)
    assert float(longer["friction_energy"][-1]) == pytest.approx(float(equal["friction_energy"][-1]), rel=2e-3)
    limit = {"condensed": 1e-9, "reduced": 2e-6}[longer.attrs["method"]]  # of equal steps: 2e-10, 6e-7
    assert energy_balance_error(longer) < limit


def test_the_error_of_a_sweep_is_that_of_the_step_at_the_resonance(histories):
    equal, longer = histories
    case = sweep()
    assert step_at(longer, longer.attrs["f_n_hz"]) == pytest.approx(time_step(case))
    assert step_at(longer, 30.0) == pytest.approx(2.0 * time_step(case))
    assert longer.attrs["time_step_error"] == pytest.approx(equal.attrs["time_step_error"], rel=0.05)


def test_the_part_of_the_steady_peak_that_is_reached_stands_in_the_result(histories):
    """240 oct/min through 150 Hz with some 4 % of damping is far too fast; the case is told so before the run."""
    reached = [history.attrs["sweep_attainment"] for history in histories]
    assert reached[0] == pytest.approx(reached[1], rel=1e-3)
    assert 0.5 < reached[0] < 0.98
    assert "only with a damping ratio of" in fast_sweeps(sweep())[0]
    assert fast_sweeps(load_case(CONFIGS / "lab_sweep.yaml")) == []
    limit = sweep_rate_limit(150.0, WANTED_DAMPING)
    assert pytest.approx(rate_for_attainment(150.0, WANTED_DAMPING) / limit, rel=2e-3) == SHARE_OF_90


def test_the_estimate_counts_the_longer_steps(histories):
    longer = histories[1]
    found = estimate_history(sweep("integrator.follow_frequency=true"))
    assert found["steps"] == pytest.approx(longer.sizes["time"] - 1, rel=0.01)


def test_a_dwell_has_nothing_to_follow():
    with pytest.raises(InputError, match=r"integrator.follow_frequency.*no frequency that changes"):
        load_case(CONFIGS / "lab_dwell.yaml", ["integrator.follow_frequency=true"])


def test_a_case_keeps_its_hash_without_longer_steps():
    assert sweep("integrator.follow_frequency=false").hash() == sweep().hash()
    assert sweep("integrator.follow_frequency=true").hash() != sweep().hash()
