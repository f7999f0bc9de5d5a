"""Time histories: advance a stepper through a base motion, write checkpoints, and collect the results in a Dataset."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
import xarray as xr

from wroll_fem.blas import one_thread
from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.energy_check import check_energy, largest_energies, rounding_energy
from wroll_fem.dynamics.time_stepping.fields import interface_fields, per_interface
from wroll_fem.dynamics.time_stepping.full import FullStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import (
    FIRST_PROBE,
    ITERATIONS,
    OF_PROBE,
    RECORDS,
    TIP_ACCELERATION,
    TIP_DISPLACEMENT,
)
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions, Stepper
from wroll_fem.dynamics.trigonometric.stepper import TrigonometricStepper
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.numerics.time_grid import TimeGrid
from wroll_fem.progress import Progress, SilentProgress
from wroll_fem.results.dataset import annotate
from wroll_fem.results.storage.checkpoint import read_checkpoint, refused, write_checkpoint
from wroll_fem.signals.tip import EXCITED_BY
from wroll_fem.typing import FloatArray

CHUNK = 200
"""Number of steps in a chunk. Progress, checkpoints and interrupts are handled between chunks; a resumed run has the
same chunks."""


class Motion(Protocol):
    """Base motion of a time history; see `signals.base_motion`."""

    @property
    def duration(self) -> float:
        """Duration in s."""
        ...

    def acceleration(self, time: FloatArray) -> FloatArray:
        """Base acceleration in m/s^2 at ``time`` (n,) in s."""
        ...


@runtime_checkable
class HasFrequency(Protocol):
    """Base motion that has a frequency at each time, such as a chirp."""

    def frequency(self, time: FloatArray) -> FloatArray:
        """Instantaneous frequency in Hz at ``time`` (n,) in s."""
        ...


@dataclass(frozen=True)
class Checkpointing:
    """File and interval of the checkpoints of a run.

    Attributes
    ----------
    path
        Checkpoint file (.npz).
    seconds
        Wall time between checkpoints, s.
    resume
        Whether to continue the run that is saved in ``path``.
    """

    path: Path
    seconds: float = 60.0
    resume: bool = False


def make_stepper(
    system: System, preload: ContactState, *, method: str, scheme: Scheme, options: NewtonOptions, dt: float,
    reduction_tolerance: float = 2e-3, largest_error: float = np.inf, condensation: Condensation | None = None,
) -> Stepper:  # fmt: skip
    """Stepper for a value of `solver.method`: "reduced", "condensed" or "full".

    ``condensation``, for "reduced" and "condensed", has the modes of the structure; they are computed if it is None.
    """
    if scheme.exact_modes and method != "reduced":
        remedy = "use solver.method: reduced, or integrator.scheme: hht"
        raise InputError(f"method {method} does not propagate modes", key="integrator.scheme", remedy=remedy)
    if method == "reduced":
        return (TrigonometricStepper if scheme.exact_modes else ReducedStepper)(
            system, preload, scheme, options, dt=dt, tolerance=reduction_tolerance, largest_error=largest_error,
            condensation=condensation,
        )  # fmt: skip
    if method == "condensed":
        return CondensedStepper(system, preload, scheme, options, dt=dt, condensation=condensation)
    if method == "full":
        return FullStepper(system, preload, scheme, options)
    raise InputError(f"unknown method {method!r}", key="solver.method", remedy="use reduced, condensed or full")


def simulate(
    system: System,
    preload: ContactState,
    motion: Motion,
    *,
    dt: float,
    grid: TimeGrid | None = None,
    scheme: Scheme,
    method: str = "condensed",
    options: NewtonOptions | None = None,
    progress: Progress | None = None,
    checkpoint: Checkpointing | None = None,
    every: int = 0,
    stepper: Stepper | None = None,
    recover: Callable[[FloatArray], xr.Dataset] | None = None,
) -> xr.Dataset:
    """Time history of a preloaded system under base motion.

    Parameters
    ----------
    motion
        Base motion (signals.base_motion).
    dt
        Time step, s; the shortest one of ``grid``.
    grid
        Ends of the steps; by default all steps are equal.
    every
        Number of steps between two stored fields of the relative displacement of all points; 0 stores none.
    stepper
        Stepper from `make_stepper`, for example to inspect its modes first; created here when None.
    recover
        Function whose Dataset is merged into the result; it is called with the displacement (n_dofs,) at the largest
        tip displacement, m, relative to the preload state.

    Returns
    -------
    xr.Dataset
        Records along `time` (first entry: the state at rest), with energies in J from the start of the run, and
        interface fields.

    Raises
    ------
    ConvergenceError
        If a step does not converge; its ``partial`` holds the Dataset of all steps before.
    """
    options = options or NewtonOptions()
    progress = progress or SilentProgress()
    if stepper is None:
        stepper = make_stepper(system, preload, method=method, scheme=scheme, options=options, dt=dt)
    stepper.follow(motion)
    grid = TimeGrid.constant(motion.duration, dt) if grid is None else grid
    steps, times = grid.count, grid.times
    base = np.asarray(motion.acceleration(times))
    run = _Run(stepper, np.zeros((steps, stepper.record_size)), [], [])
    fingerprint = np.array([dt, steps, every, system.n_dofs, system.n_points, float(np.abs(base).sum())])
    if checkpoint is not None and checkpoint.resume:
        run.load(checkpoint.path, fingerprint)
    saved = clock.monotonic()
    try:
        with one_thread(), progress.stage("time integration", steps, "steps") as stage:
            while run.done < steps:
                run.advance(base, grid, every)
                stage.update(run.done, _place(motion, times[run.done : run.done + 1]))
                if checkpoint is not None and clock.monotonic() - saved > checkpoint.seconds:
                    run.save(checkpoint.path, fingerprint)
                    saved = clock.monotonic()
    except (ConvergenceError, KeyboardInterrupt) as stop:
        stepper.restore(run.state)
        if checkpoint is not None:
            run.save(checkpoint.path, fingerprint)
        if isinstance(stop, ConvergenceError):
            stop.partial = run.dataset(system, preload, times, base, motion)
        raise
    found = run.dataset(system, preload, times, base, motion)
    if recover is None:
        return found
    return xr.merge([found, recover(run.at_largest(base, grid))], combine_attrs="override")


def _place(motion: Motion, time: FloatArray) -> str:
    """Words for the progress display: frequency of the base motion at ``time`` (1,), s, or the time itself."""
    return f"{motion.frequency(time)[0]:.1f} Hz" if isinstance(motion, HasFrequency) else f"{time[0]:.2f} s"


def saved_method(checkpoint: Checkpointing | None) -> str | None:
    """Method (`solver.method`) of the checkpoint from which a run is to be resumed; None without such a checkpoint."""
    if checkpoint is None or not checkpoint.resume or not checkpoint.path.is_file():
        return None
    method = read_checkpoint(checkpoint.path).get("method")
    return None if method is None else str(method)


@dataclass
class _Run:
    """Progress of a time history: stepper, records (steps, columns), stored displacement fields, CPU time in s."""

    stepper: Stepper
    records: FloatArray
    kept: list[FloatArray]
    kept_times: list[float]
    seconds: float = 0.0
    largest_energy: float = 0.0  # stored so far, J
    largest_tip: float = 0.0  # displacement so far, m

    def __post_init__(self) -> None:
        self._committed = (0, self.stepper.snapshot())
        self._largest = self._committed  # before the chunk with the largest tip displacement
        self._rounding = rounding_energy(self.stepper.system.laws, self.stepper.preload)

    @property
    def done(self) -> int:
        """Number of completed steps."""
        return self._committed[0]

    @property
    def state(self) -> dict[str, np.ndarray]:
        """State of the stepper after the completed steps."""
        return self._committed[1]

    def advance(self, base: FloatArray, grid: TimeGrid, every: int) -> None:
        """Compute one chunk of steps; after an interrupt at any moment, `done` and `state` belong to the same step."""
        done, times = self.done, grid.times
        count = min(CHUNK, grid.left(done))
        if every:
            count = min(count, every - done % every)
        started = clock.process_time()
        part = self.stepper.advance(base[done : done + count + 1], grid.steps[done], times[done])
        self.seconds += clock.process_time() - started
        self.records[done : done + count] = part
        tip = float(np.abs(part[:, TIP_DISPLACEMENT]).max())
        if tip > self.largest_tip:
            self.largest_tip, self._largest = tip, self._committed
        first = max(done - 1, 0)
        self.largest_energy = check_energy(
            self.records[first : done + count], times[first + 1 : done + count + 1], self.largest_energy, self._rounding
        )
        done += count
        if every and done % every == 0 and len(self.kept) < done // every:
            jump = self.stepper.jump - self.stepper.preload.jump
            self.kept.append(tangentials(jump).ravel().copy())
            self.kept_times.append(float(times[done]))
        self._committed = (done, self.stepper.snapshot())

    def at_largest(self, base: FloatArray, grid: TimeGrid) -> FloatArray:
        """(n_dofs,) displacement at the largest tip displacement; the steps of its chunk are computed again."""
        before, state = self._largest
        last = int(np.abs(self.records[: self.done, TIP_DISPLACEMENT]).argmax())
        stepper = self.stepper
        stepper.restore(state)
        stepper.advance(base[before : last + 2], grid.steps[before], grid.times[before])
        found = stepper.displacement()
        stepper.restore(self.state)
        return found

    def save(self, path: Path, fingerprint: FloatArray) -> None:
        """Write a checkpoint; an existing file is replaced once the new one is complete."""
        n = 2 * self.stepper.system.n_points
        arrays: dict[str, Any] = {
            "method": self.stepper.name,
            "fingerprint": fingerprint,
            "done": self.done,
            "seconds": self.seconds,
            "records": self.records[: self.done],
            "kept": np.array(self.kept).reshape(len(self.kept), n),
            "kept_times": np.array(self.kept_times),
            "largest_done": self._largest[0],
        }
        arrays |= {f"state_{name}": value for name, value in self.state.items()}
        arrays |= {f"largest_{name}": value for name, value in self._largest[1].items()}
        write_checkpoint(path, arrays)

    def load(self, path: Path, fingerprint: FloatArray) -> None:
        """Continue from a checkpoint of the same run.

        Raises
        ------
        InputError
            If the file is missing, damaged or belongs to another run.
        """
        data = read_checkpoint(path)
        if not np.array_equal(data.get("fingerprint", np.empty(0)), fingerprint):
            raise refused(path, "the checkpoint belongs to another run")
        try:
            states = {
                part: {k.removeprefix(part): data[k] for k in data if k.startswith(part)}
                for part in ("state_", "largest_")
            }
            self.stepper.restore(states["state_"])
            self._committed = (int(data["done"]), self.stepper.snapshot())
            self._largest = (int(states["largest_"].pop("done")), states["largest_"])
            self.records[: self.done] = data["records"]
            self.largest_tip = float(np.abs(self.records[: self.done, TIP_DISPLACEMENT]).max(initial=0.0))
            self.largest_energy = float(largest_energies(self.records[: self.done]).max(initial=0.0))
            self.seconds = float(data["seconds"])
            self.kept, self.kept_times = list(data["kept"]), list(data["kept_times"])
        except (KeyError, ValueError):  # arrays of another stepper
            raise refused(path, "the checkpoint belongs to another run or version") from None

    def dataset(
        self, system: System, preload: ContactState, times: FloatArray, base: FloatArray, motion: Motion
    ) -> xr.Dataset:
        """Dataset of all completed steps."""
        m = self.done + 1
        columns = np.vstack([np.zeros(self.stepper.record_size), self.records[: self.done]])
        columns[0, TIP_ACCELERATION] = -base[0] * (system.probes["tip"] @ system.influence)
        columns[0, FIRST_PROBE + 2 :: OF_PROBE] = -base[0] * (system.output_rows @ system.influence)
        data: dict[str, tuple[tuple[str, ...], np.ndarray]] = {
            name: (("time",), columns[:m, i]) for i, name in enumerate(RECORDS)
        }
        data["base_acceleration"] = (("time",), base[:m])
        if isinstance(motion, HasFrequency):
            data["instantaneous_frequency"] = (("time",), np.asarray(motion.frequency(times[:m])))
        dataset = xr.Dataset(data, coords={"time": times[:m]})
        if len(system.probe_names) > 1:
            dataset = dataset.assign_coords(probe=list(system.probe_names))
            last = FIRST_PROBE + OF_PROBE * len(system.named_probes)
            motions = np.column_stack([columns[:m, :OF_PROBE], columns[:m, FIRST_PROBE:last]])
            for c, name in enumerate(("displacement", "velocity", "acceleration")):
                dataset[f"probe_{name}"] = (("probe", "time"), motions[:, c::OF_PROBE].T)
        accelerations = columns[:m, FIRST_PROBE + 2 :: OF_PROBE][:, len(system.named_probes) :]
        for (name, (_, rigid)), relative in zip(system.base_loads.items(), accelerations.T, strict=True):
            dataset[name] = ("time", -relative - rigid * base[:m])
        if system.interfaces:
            dataset = xr.merge([dataset, interface_fields(system, preload, self.stepper, float(times[m - 1]))])
        if self.kept:
            kept = np.array([per_interface(system, jump.reshape(-1, 2)) for jump in self.kept])
            for c, name in enumerate(("hoop", "axial")):
                dataset[f"relative_displacement_{name}"] = (("snapshot_time", "interface", "point"), kept[..., c])
            dataset = dataset.assign_coords(snapshot_time=np.array(self.kept_times))
        iterations = self.records[: self.done, ITERATIONS]
        dataset.attrs |= {
            "steps": self.done,
            "step_cuts": self.stepper.cuts,
            "solver_time_s": self.seconds,
            "newton_iterations_mean": float(iterations.mean()) if self.done else 0.0,
            "dofs": system.n_dofs,
            "interface_points": system.n_points,
            **self.stepper.report(),
            **({} if system.force is None else {EXCITED_BY: "force"}),
        }
        return annotate(dataset)
