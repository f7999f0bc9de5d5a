"""Checkpoints of the training of a basis: its state between two curves, and the file that keeps it."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from wroll_fem.dynamics.periodic.backbone import BackboneCurve, ModalMotion
from wroll_fem.dynamics.periodic.harmonic_balance import FrequencyCurve, HarmonicBalance
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.results.storage.checkpoint import read_checkpoint, refused, write_checkpoint
from wroll_fem.typing import FloatArray

_OF_CURVE = ("frequencies", "coefficients", "tangents", "iterations")


@dataclass(frozen=True)
class KeptCurve:
    """Accurate curve of a training: its result if no later curve is better.

    Attributes
    ----------
    vectors, eigenvalues : basis (r, m) of its reduced model and its eigenvalues (m,), rad^2/s^2
    curve : its arrays
    energy_error, tip_error : see `Trained`
    incomplete : whether it has a gap or ends early
    partial : whether only the checked points and those used for the basis are solutions
    """

    vectors: FloatArray
    eigenvalues: FloatArray
    curve: dict[str, np.ndarray]
    energy_error: float
    tip_error: float
    incomplete: bool
    partial: bool

    @property
    def rank(self) -> tuple[bool, bool, float]:
        """The smaller, the better: first sound curves (all that are kept), then complete ones, then by their errors."""
        return False, self.incomplete, self.energy_error

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """All of it for a checkpoint; `of_arrays` is the inverse."""
        marks = np.array([self.energy_error, self.tip_error, self.incomplete, self.partial], float)
        basis = {"vectors": self.vectors, "eigenvalues": self.eigenvalues, "marks": marks}
        return basis | _under("curve_", self.curve)

    @classmethod
    def of_arrays(cls, found: dict[str, np.ndarray]) -> KeptCurve | None:
        """Curve from its `arrays`; None if there are none."""
        if not found:
            return None
        energy, tip, incomplete, partial = found["marks"].tolist()
        return cls(
            found["vectors"], found["eigenvalues"], _with_prefix(found, "curve_"), energy, tip, bool(incomplete),
            bool(partial),
        )  # fmt: skip


def _with_prefix(arrays: dict[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    """Arrays whose names begin with ``prefix``, by the rest of their names."""
    return {name.removeprefix(prefix): value for name, value in arrays.items() if name.startswith(prefix)}


def _under(prefix: str, arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Arrays with a prefix before their names; `_with_prefix` is the inverse."""
    return {f"{prefix}{name}": value for name, value in arrays.items()}


@dataclass(frozen=True)
class TrainingState:
    """State of a training before a curve.

    Attributes
    ----------
    number : number of the curve, from 1
    vectors, eigenvalues : basis (r, m) of the reduced model and its eigenvalues (m,), rad^2/s^2
    factor : factor on the step lengths of the curve
    stuck : whether the basis grows no further
    error : largest correction on the curve before
    used : points of this curve that are in the basis
    checks : points of this curve to be checked, if only they and those in the basis are recomputed; None if all are
    curve : arrays of the curve if its points are moved to the basis already; None if it has to be computed
    watched : whether the basis contains shapes of motions in time
    kept : the best of the accurate curves so far; None if there is none
    """

    number: int
    vectors: FloatArray
    eigenvalues: FloatArray
    factor: float
    stuck: bool
    error: float
    used: tuple[int, ...]
    checks: tuple[int, ...] | None
    curve: dict[str, np.ndarray] | None
    watched: bool
    kept: KeptCurve | None


@dataclass
class TrainingFile:
    """File with the state of a training.

    Attributes
    ----------
    path
        Checkpoint file (.npz).
    seconds
        Least wall time between two checkpoints, s; shorter trainings write none.
    resume
        Whether to continue the training that is saved in ``path``.
    """

    path: Path
    seconds: float = 60.0
    resume: bool = False
    _written: float = field(default_factory=time.monotonic, init=False)
    _latest: tuple[FloatArray, TrainingState] | None = field(default=None, init=False)

    def start(self, structure: FloatArray) -> TrainingState | None:
        """State from which to continue; None to begin anew.

        ``structure`` (r,) are the eigenvalues of all modes, which tell whether the checkpoint is of this run.

        Raises
        ------
        InputError
            If the checkpoint belongs to another run, or cannot be read.
        """
        if not self.resume or not self.path.is_file():
            return None
        found = read_checkpoint(self.path)
        try:
            same = np.array_equal(found["structure"], structure)
            state = TrainingState(
                int(found["number"]), found["vectors"], found["eigenvalues"], float(found["factor"]),
                bool(found["stuck"]), float(found["error"]), tuple(found["used"].tolist()),
                tuple(found["checks"].tolist()) or None, _with_prefix(found, "curve_") or None, bool(found["watched"]),
                KeptCurve.of_arrays(_with_prefix(found, "kept_")),
            )  # fmt: skip
        except (ValueError, KeyError):  # arrays of another analysis
            raise refused(self.path, "the checkpoint belongs to another run or version") from None
        if not same:
            raise refused(self.path, "the checkpoint belongs to another run")
        return state

    def keep(self, structure: FloatArray, state: TrainingState) -> None:
        """Take over a state, and write it if the last checkpoint is old enough."""
        self._latest = structure, state
        if time.monotonic() - self._written >= self.seconds:
            self.write()

    def write(self) -> None:
        """Write the latest state, if there is one; an existing file is replaced once the new one is complete."""
        if self._latest is None:
            return
        structure, state = self._latest
        curve, kept = state.curve or {}, state.kept.arrays if state.kept else {}
        arrays: dict[str, Any] = {
            "structure": structure, "number": state.number, "vectors": state.vectors, "factor": state.factor,
            "eigenvalues": state.eigenvalues, "stuck": state.stuck, "error": state.error,
            "used": np.array(state.used, np.int64), "checks": np.array(state.checks or (), np.int64),
            "watched": state.watched,
        }  # fmt: skip
        write_checkpoint(self.path, arrays | _under("curve_", curve) | _under("kept_", kept))
        self._written = time.monotonic()


def arrays_of(curve: HarmonicCurve | BackboneCurve) -> dict[str, np.ndarray]:
    """Arrays from which `curve_of` makes the curve again."""
    found = {name: getattr(curve, name) for name in _OF_CURVE}
    if isinstance(curve, BackboneCurve):
        problem = curve.problem
        scale = np.array([problem.mode, problem.first, problem.per_unit])
        return found | {"damping": curve.damping, "cut": np.array(curve.cut), "scale": scale}
    gap = np.array(curve.gap or (), float)
    scale = np.array([*curve.problem.band, curve.problem.size])
    return found | {"stable": curve.stable, "gap": gap, "skipped": np.array(curve.skipped), "scale": scale}


def curve_of(balance: HarmonicBalance, arrays: dict[str, np.ndarray]) -> HarmonicCurve | BackboneCurve:
    """Curve from its arrays (`arrays_of`), in the model and with the excitation of ``balance``."""
    found: dict[str, Any] = {name: arrays[name] for name in _OF_CURVE}
    first, second, third = (float(value) for value in arrays["scale"])
    if "damping" in arrays:
        motion = ModalMotion(balance, int(first), (1.0, 2.0))
        motion.first, motion.per_unit = second, third
        return BackboneCurve(
            **found, damping=arrays["damping"], balance=balance, problem=motion, cut=str(arrays["cut"])
        )
    gap = (float(arrays["gap"][0]), float(arrays["gap"][1])) if len(arrays["gap"]) else None
    return HarmonicCurve(
        **found, stable=arrays["stable"], balance=balance, problem=FrequencyCurve(balance, (first, second), third),
        gap=gap, skipped=tuple(arrays["skipped"].tolist()),
    )  # fmt: skip
