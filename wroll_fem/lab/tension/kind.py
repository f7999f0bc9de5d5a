"""Tension of a winding machine over voltage and current, and the pressure that it winds (thesis, Fig. 3.6)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from pydantic import Field

from wroll_fem.case.base import Real, Section, Switch, Whole
from wroll_fem.errors import InputError
from wroll_fem.lab.common.channels import Channel, clipped, per_file, read_channels
from wroll_fem.lab.common.intervals import entries, variables
from wroll_fem.lab.kinds import Figure, Kind
from wroll_fem.lab.result import LabResult
from wroll_fem.lab.settings import LabSettings
from wroll_fem.lab.tension.pressure import Pressure, WindingModel
from wroll_fem.lab.tension.trials import Setting, Trial, doubts, measure_trial, settings_of
from wroll_fem.progress import Progress

DRAW = "wroll_fem.plotting.laboratory.tension"

STEADY = 0.02
"""Relative standard deviation of a measured voltage or current above which it is reported."""


class TensionColumns(Section):
    """Columns of the files: a name, or the place counted from 1."""

    time: str | int = Field("time", description="column of the time: name, or place (count)")
    tension: str | int = Field("tension", description="column of the tension of the web: name, or place (count)")
    voltage: str | int | None = Field(
        None, description="column of the voltage, in place of the key voltage: name, or place (count)"
    )
    current: str | int | None = Field(
        None, description="column of the current, in place of the key current: name, or place (count)"
    )


class TensionUnits(Section):
    """Units of the columns."""

    time: str = Field("s", description="unit of the time, such as s or ms")
    tension: str = Field(description="unit of the tension, such as N")
    voltage: str = Field("V", description="unit of the column of the voltage")
    current: str = Field("A", description="unit of the column of the current, such as A or mA")


class TensionSettings(LabSettings):
    """Settings of the evaluation `tension`."""

    PATHS: ClassVar[tuple[str, ...]] = ("case",)

    columns: TensionColumns = Field(default_factory=TensionColumns, description="columns of the files")
    units: TensionUnits = Field(description="units of the columns; that of the tension is required")
    voltage: Real | list[Real] | None = Field(
        None, description="voltage of the winding motor, V: one number, or one per file"
    )
    current: Real | list[Real] | None = Field(
        None, description="current of the membrane roller, A: one number, or one per file"
    )
    skip: Real = Field(0.0, ge=0, description="time at the start and at the end of a trial that is left out, s")
    pooled: Switch = Field(False, description="whether all settings share one scatter between trials")
    case: str | None = Field(
        None, description="case file with a section winding; the pressure that each tension winds is computed from it"
    )
    uncertain: dict[str, Real] = Field(
        default_factory=dict,
        description="dotted keys of the case and their relative standard errors, dimensionless",
    )
    draws: Whole = Field(400, ge=100, le=100000, description="size of the sample that checks the linear error (count)")
    seed: Whole = Field(1, ge=0, description="seed of the sample (count)")


def tension(files: Sequence[Path], settings: TensionSettings, progress: Progress) -> LabResult:
    """Evaluate records of the tension; each file is one trial."""
    trials = _trials(files, settings, progress)
    found = settings_of(trials, pooled=settings.pooled)
    for text in doubts(trials, found):
        progress.warning(text)
    pressures = _pressures(found, settings, progress)
    summary: dict[str, Any] = {
        "voltages_v": [one.voltage for one in found],
        "currents_ampere": [one.current for one in found],
        "trial_counts": [one.trials for one in found],
        **entries("winding_tension", "n", [one.mean for one in found]),
        "tension_within_n": [one.within for one in found],
        "tension_between_n": [one.between for one in found],
        "tension_scatter_n": [one.scatter for one in found],
    }
    data = _setting_variables(found) | _trial_variables(trials, found)
    if pressures:
        summary |= entries("wound_pressure", "pa", [one.mandrel if one else None for one in pressures])
        summary["wound_pressure_sample_pa"] = [list(one.sample) if one else [np.nan] * 2 for one in pressures]
        summary |= entries("wound_pressure_mean", "pa", [one.mean if one else None for one in pressures])
        data |= variables("wound_pressure", "setting", [one.mandrel if one else None for one in pressures])
        data |= variables("wound_pressure_mean", "setting", [one.mean if one else None for one in pressures])
        data["wound_pressure_slope"] = ("setting", [one.slope if one else np.nan for one in pressures])
    return LabResult(summary, xr.Dataset(data), {"tension.csv": table(found, pressures)})


def _trials(files: Sequence[Path], settings: TensionSettings, progress: Progress) -> list[Trial]:
    columns, units = settings.columns, settings.units
    given = {key: per_file(getattr(settings, key), len(files), key) for key in ("voltage", "current")}
    for key, values in given.items():
        column = getattr(columns, key)
        if (values is None) == (column is None):
            problem = "is missing" if values is None else f"and columns.{key} are both given"
            raise InputError(
                problem, key=key, remedy=f"give {key}, one number or one per file, or columns.{key}"
            )  # fmt: skip
    wanted = [Channel("time", columns.time, units.time, "s"), Channel("tension", columns.tension, units.tension, "N")]
    for key, si in (("voltage", "V"), ("current", "A")):
        if getattr(columns, key) is not None:
            wanted.append(Channel(key, getattr(columns, key), getattr(units, key), si))
    trials = []
    with progress.stage("trials", len(files)) as stage:
        for k, path in enumerate(files):
            data = read_channels(path, wanted)
            for text in clipped(data["tension"], path, "tension"):
                progress.warning(text)
            levels = []
            for key, values in given.items():
                if values is not None:
                    levels.append(values[k])
                    continue
                levels.append(float(np.mean(data[key])))
                if np.std(data[key]) > STEADY * abs(levels[-1]):
                    progress.warning(f"{path}: the {key} is not constant; its mean, {levels[-1]:.4g}, is used")
            trials.append(measure_trial(data["time"], data["tension"], *levels, skip=settings.skip, source=str(path)))
            stage.update(k + 1)
    return trials


def _pressures(found: Sequence[Setting], settings: TensionSettings, progress: Progress) -> list[Pressure | None]:
    """Pressure of each setting; None where the tension is not positive; empty without a case."""
    if settings.case is None:
        if settings.uncertain:
            raise InputError("uncertain needs a case file", key="uncertain", remedy="give case, or leave it out")
        return []
    model = WindingModel(settings.case, settings.uncertain)
    pressures: list[Pressure | None] = []
    with progress.stage("pressures", len(found)) as stage:
        for k, one in enumerate(found, start=1):
            where = f"{one.voltage:g} V and {one.current:g} A"
            if one.mean.value <= 0.0:
                progress.warning(f"at {where} the mean tension, {one.mean.value:.3g} N, is not positive: no pressure")
                pressures.append(None)
                continue
            pressures.append(model.at(one.mean, draws=settings.draws, seed=settings.seed))
            last = pressures[-1]
            if last is not None and last.nonlinear:
                low, high = last.mandrel.interval()
                progress.warning(
                    f"at {where} the pressure is not linear within the error: linear interval {low:.3g} to "
                    f"{high:.3g} Pa, sample {last.sample[0]:.3g} to {last.sample[1]:.3g} Pa; use the sample"
                )
            stage.update(k)
    return pressures


def _setting_variables(found: Sequence[Setting]) -> dict[str, tuple[Any, Any]]:
    data: dict[str, tuple[Any, Any]] = {
        "motor_voltage": ("setting", [one.voltage for one in found]),
        "roller_current": ("setting", [one.current for one in found]),
        "trial_count": ("setting", [one.trials for one in found]),
    }
    data |= variables("winding_tension", "setting", [one.mean for one in found])
    for name in ("within", "between", "scatter"):
        data[f"tension_{name}"] = ("setting", [getattr(one, name) for one in found])
    return data


def _trial_variables(trials: Sequence[Trial], found: Sequence[Setting]) -> dict[str, tuple[Any, Any]]:
    def place(trial: Trial) -> int:
        return min(
            range(len(found)),
            key=lambda k: abs(found[k].voltage - trial.voltage) + abs(found[k].current - trial.current),
        )

    data: dict[str, tuple[Any, Any]] = {"trial_setting": ("trial", [place(trial) for trial in trials])}
    data |= variables("trial_tension", "trial", [trial.mean for trial in trials])
    data["trial_drift"] = ("trial", [trial.drift.value for trial in trials])
    return data


def table(found: Sequence[Setting], pressures: Sequence[Pressure | None]) -> str:
    """Table of all settings as CSV: tension with error and scatters, and pressure, with units in the second line."""
    names = ["voltage", "current", "trials", "tension", "tension_low", "tension_high", "within", "between"]
    units = ["V", "A", "1", "N", "N", "N", "N", "N"]
    if pressures:
        names, units = [*names, "pressure", "pressure_low", "pressure_high"], [*units, "Pa", "Pa", "Pa"]
    lines = [",".join(names), ",".join(units)]
    for k, one in enumerate(found):
        row: list[float] = [
            one.voltage, one.current, one.trials, one.mean.value, *one.mean.interval(), one.within, one.between
        ]  # fmt: skip
        if pressures:
            own = pressures[k]
            row += [own.mandrel.value, *own.mandrel.interval()] if own is not None else [np.nan] * 3
        lines.append(",".join(f"{value:.6g}" for value in row))
    return "\n".join(lines) + "\n"


CASE = """\
# The roll of the laboratory as wound (thesis, section 3.2): 25 wraps of 2 mil Kapton on the polycarbonate tube.
analysis: winding
winding:
  tension_newton: 40 # N; replaced by the measured tension
  web_width: 0.300 # m
  wraps: 25
  wrap_thickness: 5.0e-5 # m
  mandrel: {outer_radius: 0.040, wall: 1.5e-3, E: 2.7e+9, nu: 0.35} # m, m, Pa, -
  web:
    E_theta: 2.8e+9 # Pa
    nu_theta: 0.35
    radial_modulus: {law: pfeiffer, K1: 1.0e+3, K2: 40} # Pa, -
  mu: 0.25
"""
"""Case of the example."""


def example(folder: Path) -> list[Path]:
    """Write three trials at each of two voltages and three currents.

    Truth: tensions of 20, 40 and 60 N at 0.2, 0.5 and 1 A, standard deviation 1 N between trials and 1.5 N within.
    """
    rng = np.random.default_rng(3)
    time = np.arange(0.0, 40.0, 0.05)
    files, voltages, currents = [], [], []
    for voltage in (4.0, 6.0):
        for current, level in ((0.2, 20.0), (0.5, 40.0), (1.0, 60.0)):
            for trial in range(1, 4):
                noise = np.convolve(rng.standard_normal(len(time) + 9), np.ones(10) / np.sqrt(10.0), mode="valid")
                values = level + rng.standard_normal() + 1.5 * noise
                path = folder / f"{voltage:.0f}V_{1e3 * current:.0f}mA_{trial}.csv"
                np.savetxt(path, np.column_stack([time, values]), delimiter=",", header="time,tension", comments="")
                files.append(path)
                voltages.append(voltage)
                currents.append(current)
    (folder / "winding.yaml").write_text(CASE, encoding="utf-8")
    text = f"units: {{tension: N}}\nvoltage: {voltages} # V\ncurrent: {currents} # A\nskip: 2 # s\ncase: winding.yaml\n"
    (folder / "settings.yaml").write_text(text, encoding="utf-8")
    return files


KIND = Kind(
    settings=TensionSettings,
    evaluate=tension,
    files="One trial per file (CSV, .npz, .mat, UFF 58) with columns of time and tension.",
    figures={
        "tension": Figure(f"{DRAW}:plot_tension", "winding_tension"),
        "pressure": Figure(f"{DRAW}:plot_pressure", "wound_pressure"),
    },
    variables={
        "setting": ("motor_voltage", "roller_current", "winding_tension", "tension_scatter", "wound_pressure"),
        "trial": ("trial_setting", "trial_tension", "trial_drift"),
    },
    example=example,
)
