"""Progress and checkpoints of the training of a basis, for `harmonic` and `backbone`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.training.training_state import TrainingFile
from wroll_fem.errors import ConvergenceError

if TYPE_CHECKING:
    from wroll_fem.case import StructuralCase
    from wroll_fem.progress import Progress, Stage


def pass_line(number: int, size: int, error: float, target: float) -> str:
    """Message about the adaptive basis after a pass along the curve.

    Parameters
    ----------
    number
        Number of the pass.
    size
        Number of basis vectors.
    error, target
        Residual error and its tolerance, relative.
    """
    return f"pass {number}: {size} basis vectors, residual error {100 * error:.2g} % (target {100 * target:.2g} %)"


class Passes:
    """Progress of an adaptive basis: the place on the curve of the present pass, and a line after each pass."""

    def __init__(self, progress: Progress, stage: Stage, target: float) -> None:
        self._progress, self._stage, self._target, self._number = progress, stage, target, 1

    def at_point(self, share: float, count: int, place: str) -> None:
        """Show the ``share`` of the range that this pass has covered; no time is estimated: passes may follow."""
        note = f"pass {self._number}: {place}, {count} points (until the error is {100 * self._target:.2g} %)"
        self._stage.update(min(max(share, 0.0), 0.99), note, left=float("nan"))

    def in_time(self, share: float) -> None:
        """Show the ``share`` of a chirp in time that is computed."""
        note = f"chirp in time: {100 * share:.0f} %"
        self._stage.update(min(max(share, 0.0), 0.99), note, left=float("nan"))

    def report(self, number: int, model: ReducedModel, error: float) -> None:
        """Print a line after a pass."""
        self._progress.info(pass_line(number, model.size, error, self._target))
        self._number = number + 1


@contextmanager
def training_file(case: StructuralCase, checkpoint: Path | None, *, resume: bool) -> Iterator[TrainingFile | None]:
    """Context manager that yields the checkpoint file of a training; None without a path.

    An interrupt writes the latest state. After a `ConvergenceError` nothing is left to continue.
    """
    file = None if checkpoint is None else TrainingFile(checkpoint, case.solver.checkpoint_seconds, resume)
    try:
        yield file
    except KeyboardInterrupt:
        if file is not None:
            file.write()
        raise
    except ConvergenceError:
        if checkpoint is not None:
            checkpoint.unlink(missing_ok=True)
        raise
