"""A history that is stopped at random chunks, several times, equals one that is not, bit by bit."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from support.exact_systems import orbiting_mass, slipping_pair
from support.interrupted import interrupted
from support.paths import CONFIGS

from wroll_fem import load_case
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping import simulate as module
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.full import FullStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.dynamics.time_stepping.simulate import Checkpointing, Motion, simulate
from wroll_fem.errors import InputError
from wroll_fem.progress import SilentProgress
from wroll_fem.results.storage.checkpoint import read_checkpoint, write_checkpoint
from wroll_fem.signals.base_motion import Dwell

STEPPERS = {"reduced": ReducedStepper, "condensed": CondensedStepper, "full": FullStepper}
HHT = Scheme.hht(-0.05)


def resumed_equals_whole(
    system: System, preload: ContactState, motion: Motion, dt: float, method: str, stops: list[int], path: Path,
    patch: pytest.MonkeyPatch, whole: xr.Dataset | None = None,
) -> xr.Dataset:  # fmt: skip
    """Compare a run that is stopped at each of ``stops`` chunks, and resumed, with the ``whole`` one, which is not."""
    options = {"dt": dt, "scheme": HHT, "method": method, "every": 10}
    if whole is None:
        whole = simulate(system, preload, motion, **options)  # type: ignore[arg-type]
    path.unlink(missing_ok=True)
    for number, stop in enumerate(stops):
        with interrupted(patch, STEPPERS[method], stop):
            simulate(system, preload, motion, checkpoint=Checkpointing(path, resume=number > 0), **options)  # type: ignore[arg-type]
    rest = simulate(system, preload, motion, checkpoint=Checkpointing(path, resume=True), **options)  # type: ignore[arg-type]
    for name in whole.variables:
        np.testing.assert_array_equal(rest[name].values, whole[name].values, err_msg=str(name))
    for name in ("steps", "step_cuts", "newton_iterations_mean"):
        assert rest.attrs[name] == whole.attrs[name]
    return whole


@pytest.mark.parametrize("method", STEPPERS)
@pytest.mark.parametrize("build", [slipping_pair, orbiting_mass])
def test_small_systems_resume_bit_by_bit(build, method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:  # type: ignore[no-untyped-def]
    """Seed 17: two stops within the first half of the chunks."""
    monkeypatch.setattr(module, "CHUNK", 11)
    system, chance = build(), random.Random(17)
    preload, motion = solve_preload(system), Dwell(20.0, 12.0, 2.0, ramp_cycles=1.0)
    stops = [chance.randrange(2, 7) for _ in range(2)]
    whole = resumed_equals_whole(system, preload, motion, 1e-3, method, stops, tmp_path / "c.npz", monkeypatch)
    assert float(whole["friction_energy"][-1]) > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("method", STEPPERS)
def test_a_roll_resumes_bit_by_bit_at_twenty_random_checkpoints(
    method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Seed 18; a chunk of 6 of 120 steps."""
    monkeypatch.setattr(module, "CHUNK", 6)
    case = load_case(CONFIGS / "tiny.yaml", ["mesh={circumferential: 8, axial: 3, grading: 1}"])
    system, preload = prepare(case, SilentProgress())
    chance, motion, whole = random.Random(18), Dwell(60.0, 150.0, 3.0, ramp_cycles=1.0), None
    for _ in range(20):
        stops = [chance.randrange(1, 19)]
        whole = resumed_equals_whole(
            system, preload, motion, 1 / 6000, method, stops, tmp_path / "c.npz", monkeypatch, whole
        )
        assert float(whole["friction_energy"][-1]) > 0.0


def test_a_checkpoint_of_another_format_or_run_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, system = tmp_path / "c.npz", slipping_pair()
    preload, motion = solve_preload(system), Dwell(20.0, 12.0, 4.0, ramp_cycles=2.0)

    def run(method: str = "full", *, dt: float = 1e-3) -> None:
        simulate(system, preload, motion, dt=dt, scheme=HHT, method=method, checkpoint=Checkpointing(path, resume=True))

    monkeypatch.setattr(module, "CHUNK", 50)
    with interrupted(monkeypatch, FullStepper, 3):
        simulate(system, preload, motion, dt=1e-3, scheme=HHT, method="full", checkpoint=Checkpointing(path))
    saved = read_checkpoint(path)
    remedy = "; delete this file and run the same command again, which starts from the beginning"
    with pytest.raises(InputError, match=f"the checkpoint belongs to another run{remedy}"):
        run(dt=2e-3)
    del saved[next(name for name in saved if name.startswith("state_"))]
    write_checkpoint(path, saved)
    with pytest.raises(InputError, match=f"the checkpoint belongs to another run or version{remedy}"):
        run()
    monkeypatch.setattr("wroll_fem.results.storage.checkpoint.FORMAT", 9)
    with pytest.raises(InputError, match="the checkpoint has format 2; this version reads format 9"):
        run()
    np.savez(path, done=3)  # as version 0.1.0 wrote it
    with pytest.raises(InputError, match=f"the checkpoint was cut off, or is of an older version{remedy}"):
        run()
