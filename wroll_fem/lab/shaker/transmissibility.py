"""Evaluation `transmissibility`: resonance frequency and damping over level and tension (thesis, Figs 3.10 to 3.13)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, field_validator
from scipy.signal import stft

from wroll_fem.case.base import Real, Switch, validation_error
from wroll_fem.errors import InputError
from wroll_fem.lab.kinds import Figure, Kind
from wroll_fem.lab.result import LabResult
from wroll_fem.lab.settings import LabSettings
from wroll_fem.lab.shaker.conditions import ConditionSettings, grouped
from wroll_fem.lab.shaker.curve import Curve
from wroll_fem.lab.shaker.family import Measured, family_dataset, family_doubts, family_summary
from wroll_fem.lab.shaker.random_trials import random_curve, suited_resolution, with_doubts
from wroll_fem.lab.shaker.sweep_trials import Swept, sweep_curve, swept
from wroll_fem.lab.shaker.synthetic import shaker_example
from wroll_fem.lab.shaker.trial import Trial, read_trial
from wroll_fem.progress import Progress

Method = Literal["random", "sweep"]

ESTIMATORS: Mapping[Method, str] = {"random": "rational_fraction", "sweep": "half_power"}
"""Estimator that `damping: auto` takes."""

WINDOWS = 60
"""Windows in which `method: auto` looks at the base."""

SINE, NOISE = 0.7, 0.4
"""Share of the power of a window in its highest lines, from which the base counts as a sweep, and up to which as random
(median of the windows)."""


class TransmissibilitySettings(LabSettings):
    """Columns, units, conditions and method of the evaluation `transmissibility`."""

    base: str | int = Field("base", description="column of the base, by name, or by its place (count, the first is 1)")
    tip: str | int = Field("tip", description="column of the tip, by name, or by its place (count, the first is 1)")
    base_unit: str = Field(
        description="unit of the base, which also tells its quantity: acceleration `m/s^2` `g` `mm/s^2`; velocity "
        "`m/s` `mm/s` `um/s`; displacement `m` `mm` `um`",
    )
    tip_unit: str = Field(description="unit of the tip, as for the base")
    tip_relative: Switch = Field(False, description="whether the tip is measured relative to the base")
    time: str | int | None = Field(
        None, description="column of the time, s, by name or by its place (count); by default the one called time or t"
    )
    sampling_rate: Real | None = Field(
        None, gt=0, description="samples per second, Hz, in place of a column of the time"
    )
    method: Literal["auto", "random", "sweep"] = Field(
        "auto",
        description="random: averaged spectra; sweep: demodulation with the phase of the base; auto: by the base",
    )
    band: tuple[Real, Real] | None = Field(
        None, description="lowest and highest frequency of the curves, Hz; by default where the base moves"
    )
    resolution: Real | Literal["auto"] = Field(
        "auto", description="distance between the lines of the spectra, Hz; auto: to suit the resonance and the record"
    )
    damping: Literal["auto", "half_power", "gaussian_fit", "rational_fraction", "choose"] = Field(
        "auto", description="estimator; auto: rational_fraction for random, half_power for sweep"
    )
    conditions: list[ConditionSettings] = Field(
        default=[], description="files, level and tension of each condition; by default each folder is one condition"
    )

    @field_validator("base", "tip", "time", mode="before")
    @classmethod
    def _a_column(cls, value: Any) -> Any:
        if value is not None and (isinstance(value, bool) or not isinstance(value, str | int)):
            raise validation_error("must be a name, or a place", remedy="count from 1", value=value)
        return value

    @field_validator("band")
    @classmethod
    def _ascending(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        if value is not None and not 0.0 < value[0] < value[1]:
            remedy = "give the lower frequency first, above 0 Hz"
            raise validation_error("must be two frequencies in ascending order", remedy=remedy, value=list(value))
        return value

    @field_validator("resolution", mode="before")
    @classmethod
    def _positive(cls, value: Any) -> Any:
        if isinstance(value, int | float) and not isinstance(value, bool) and not value > 0.0:
            raise validation_error("must be greater than 0", remedy="give a frequency in Hz, or auto", value=value)
        return value


def evaluate(files: Sequence[Path], settings: TransmissibilitySettings, progress: Progress) -> LabResult:
    """Evaluate the trials of all conditions.

    Raises
    ------
    InputError
        If a file or setting is wrong.
    """
    conditions = grouped(files, settings.conditions)
    with progress.stage("records", len(files)) as stage:
        trials: dict[Path, Trial] = {}
        for path in files:
            trials[path] = _read(path, settings)
            for text in trials[path].remarks:
                progress.warning(text)
            stage.update(len(trials))
    method = settings.method if settings.method != "auto" else common_method(list(trials.values()))
    progress.info(f"the base moves {'at random' if method == 'random' else 'in sweeps'}")
    evaluate_group = _random if method == "random" else _sweep
    measured = []
    with progress.stage("conditions", len(conditions)) as stage:
        for condition in conditions:
            whole, each = evaluate_group([trials[path] for path in condition.files], settings)
            measured.append(Measured(condition, whole, tuple(each)))
            stage.update(len(measured))
    for one in measured:
        for text in family_doubts(one):
            progress.warning(f"{one.condition.name}: {text}")
    return LabResult(family_summary(measured, method), family_dataset(measured, method))


def _read(path: Path, settings: TransmissibilitySettings) -> Trial:
    return read_trial(
        path, base=settings.base, tip=settings.tip, base_unit=settings.base_unit, tip_unit=settings.tip_unit,
        relative=settings.tip_relative, time=settings.time, sampling_rate=settings.sampling_rate,
    )  # fmt: skip


def _estimator(settings: TransmissibilitySettings, method: Method) -> str:
    return ESTIMATORS[method] if settings.damping == "auto" else settings.damping


def _random(trials: Sequence[Trial], settings: TransmissibilitySettings) -> tuple[Curve, list[Curve]]:
    """Curve of a condition, and of each trial."""
    method, band = _estimator(settings, "random"), settings.band
    given = settings.resolution
    resolution = suited_resolution(trials, band, method) if given == "auto" else float(given)
    whole = with_doubts(random_curve(trials, resolution, band, method))
    each = [random_curve([trial], resolution, band, method) for trial in trials] if len(trials) > 1 else [whole]
    return whole, each


def _sweep(trials: Sequence[Trial], settings: TransmissibilitySettings) -> tuple[Curve, list[Curve]]:
    """Curve of a condition, and of each trial."""
    method = _estimator(settings, "sweep")
    parts: list[Swept] = [swept(trial, settings.band) for trial in trials]
    whole = sweep_curve(parts, method)
    return whole, [sweep_curve([part], method, errors=False) for part in parts] if len(parts) > 1 else [whole]


def common_method(trials: Sequence[Trial]) -> Method:
    """Method that suits all trials.

    Raises
    ------
    InputError
        If the motion of the base is not recognised, or the trials differ.
    """
    found = {trial.path: recognised(trial) for trial in trials}
    if len(set(found.values())) > 1:
        first = {method: path for path, method in reversed(found.items())}
        remedy = "evaluate them separately, or set method"
        raise InputError(f"{first['random']} is random and {first['sweep']} a sweep", key="method", remedy=remedy)
    return next(iter(found.values()))


def recognised(trial: Trial) -> Method:
    """Kind of the motion of the base, from the share of the strongest lines in the power of short windows.

    Raises
    ------
    InputError
        If neither a sweep nor a random motion is recognised.
    """
    length = int(np.clip(len(trial.base) // WINDOWS, 64, 1 << 14))
    if len(trial.base) < 4 * length:
        return "random"
    power = np.abs(stft(trial.base - trial.base.mean(), nperseg=length, boundary=None)[2][1:]) ** 2
    moving = power.sum(axis=0) > 1e-3 * power.sum(axis=0).max()
    top = power.argmax(axis=0)
    rows = np.arange(len(power))[:, None]
    near = np.where(np.abs(rows - top) <= 3, power, 0.0).sum(axis=0) / np.maximum(power.sum(axis=0), 1e-300)
    share = float(np.median(near[moving]))
    if NOISE < share < SINE:
        raise InputError(
            f"the motion of the base is not recognised ({100 * share:.0f} % of its power in the strongest lines)",
            file=str(trial.path), key="method", remedy="set method: random, or method: sweep",
        )  # fmt: skip
    return "sweep" if share >= SINE else "random"


KIND = Kind(
    settings=TransmissibilitySettings,
    evaluate=evaluate,
    files="One trial per file (CSV, .npz, .mat, UFF 58), with columns of the time, of the base and of the tip: "
    "accelerations, velocities or displacements.",
    figures={
        "transmissibility": Figure("wroll_fem.plotting.laboratory.transmissibility:plot_curves", "family_real"),
        "damping": Figure("wroll_fem.plotting.laboratory.transmissibility:plot_levels", "condition_f_n"),
    },
    variables={
        "condition, frequency": ("family_real", "family_imag"),
        "condition": ("condition_f_n", "condition_zeta", "base_level", "tip_level", "tension"),
        "trial": ("trial_f_n", "trial_zeta"),
    },
    example=shaker_example,
)
