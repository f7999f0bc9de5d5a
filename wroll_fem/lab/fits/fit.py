"""Evaluation `fit`: a model fitted to a family of measured resonances, with confidence and what it does not tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite, nan
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import xarray as xr
from pydantic import Field

from wroll_fem.errors import InputError
from wroll_fem.lab.fits.backbone_fit import BackboneSettings, fit_backbones, read_backbones
from wroll_fem.lab.fits.family_file import Resonance, read_families
from wroll_fem.lab.fits.synthetic_roll import roll_example
from wroll_fem.lab.fits.two_mass_fit import TwoMassSettings, fit_two_masses
from wroll_fem.lab.kinds import Figure, Kind
from wroll_fem.lab.result import LabResult
from wroll_fem.lab.settings import LabSettings
from wroll_fem.numerics.identifiability import Uncertainty
from wroll_fem.progress import Progress
from wroll_fem.two_dof.model import TwoMasses
from wroll_fem.two_dof.periodic import PeriodicSolver
from wroll_fem.typing import FloatArray

LARGE_MISFIT = 2.0
"""Misfit in standard errors above which the backbones do not describe the roll."""

LOOSE_CURVES = 0.1
"""Root mean square of ln(model / measured) above which two masses do not describe the curves."""


class FitSettings(LabSettings):
    """Model of the evaluation `fit`."""

    PATHS: ClassVar[tuple[str, ...]] = ("model.grid",)

    model: TwoMassSettings | BackboneSettings = Field(
        discriminator="kind", description="model to fit, with its parameters: two_masses, or backbones of a roll"
    )


class _Rows(NamedTuple):
    """Measured and computed values."""

    condition: list[Any]
    frequency: list[Any]
    level: list[Any]
    quantity: list[Any]
    measured: list[Any]
    computed: list[Any]


class _Table(NamedTuple):
    """Fitted parameters: names with units, values, intervals; correlation and remarks."""

    names: list[str]
    values: FloatArray
    low: FloatArray
    high: FloatArray
    sure: Uncertainty
    at_bound: list[str]
    misfit: float


def evaluate(files: Sequence[Path], settings: FitSettings, progress: Progress) -> LabResult:
    """Fit the model of the settings to the families of the files.

    Raises
    ------
    InputError
        If a file has no family, or the grid of backbones is unusable.
    """
    family = read_families(files)
    if any(one.motion == "random" for one in family):
        progress.warning(
            "curves of a random motion are those of an equivalent linear roll at its rms amplitude, but the model "
            "moves periodically: use sweeps for amplitudes, friction and elastic slip"
        )
    if isinstance(settings.model, TwoMassSettings):
        table, rows = _two_masses(family, settings.model, progress)
    else:
        table, rows = _backbones(family, settings.model, progress)
    for text in table.sure.undetermined:
        progress.warning(text)
    if table.at_bound:
        progress.warning(f"at a bound, so doubtful: {', '.join(table.at_bound)}; widen the bounds, or the grid")
    for name, value, low, high in zip(table.names, table.values, table.low, table.high, strict=True):
        progress.info(f"{name} = {value:.4g}, 95 % interval {low:.4g} to {high:.4g}")
    return LabResult(_summary(table, settings.model.kind), _dataset(table, rows, family))


def _two_masses(family: Sequence[Resonance], settings: TwoMassSettings, progress: Progress) -> tuple[_Table, _Rows]:
    with progress.stage("fit of two masses", 1):
        found = fit_two_masses(family, settings)
    fit, sure = found.fit, found.fit.uncertainty
    if fit.error > LOOSE_CURVES:
        progress.warning(
            f"the two masses differ from the curves by {100 * fit.error:.0f} % (rms): free more parameters, add "
            "starts, or narrow the family"
        )
    public = {"m2": "mass_ratio", "k2": "stiffness_ratio", "c1": "zeta_primary", "c2": "zeta_secondary"}
    factors = {"c1": 0.5, "c2": 0.5}
    names, scale = [], []
    for name in sure.names:
        if name in public:
            names.append(public[name])
            scale.append(factors.get(name, 1.0))
        else:
            roll = int(name.split()[-1]) - 1
            force = found.force if isfinite(found.force) else 1.0
            names.append(f"capacity_{_label(family, found.rolls, roll)}{'_n' if isfinite(found.force) else ''}")
            scale.append(force)
    size = np.array(scale)
    values = size * np.sqrt(sure.low * sure.high)  # the middle of the logarithms is the estimate
    bound = [names[sure.names.index(name)] for name in fit.at_bound]
    table = _Table(names, values, size * sure.low, size * sure.high, sure, bound, fit.error)
    rows = _Rows([], [], [], [], [], [])
    for k, (one, points) in enumerate(zip(family, found.curves, strict=True)):
        computed = _curve(fit.model, points.base_amplitude or 1.0, float(fit.capacities[k]), points.omega)
        for omega, size_measured, size_computed in zip(points.omega, points.transmissibility, computed, strict=True):
            _add(rows, k, omega * settings.primary_hz, one.base_level, "transmissibility", size_measured, size_computed)
    return table, rows


def _curve(model: TwoMasses, amplitude: float, capacity: float, omega: FloatArray) -> FloatArray:
    own = replace(model, base_amplitude=amplitude).preloaded(capacity)
    return np.array([motion.transmissibility for motion in PeriodicSolver(own, accuracy=1e-4).curve(omega)])


def _backbones(family: Sequence[Resonance], settings: BackboneSettings, progress: Progress) -> tuple[_Table, _Rows]:
    grid = read_backbones(Path(settings.grid))
    with progress.stage("fit of backbones", 1):
        found = fit_backbones(family, grid, settings)
    labels = [_label(family, found.rolls, k) for k in range(len(found.tensions))]
    names = [f"mu_p_{label}_pa" for label in labels]
    values, low, high = list(found.friction), list(found.friction_low), list(found.friction_high)
    if settings.pressure is not None:
        if len(settings.pressure) != len(labels):
            raise InputError(
                f"{len(settings.pressure)} pressures for {len(labels)} rolls", key="model.pressure",
                remedy="give one pressure per tension, in the order of the conditions",
            )  # fmt: skip
        for k, pressure in enumerate(settings.pressure):
            names.append(f"mu_{labels[k]}")
            values.append(found.friction[k] / pressure)
            low.append(found.friction_low[k] / pressure)
            high.append(found.friction_high[k] / pressure)
    sure = found.uncertainty
    names += ["elastic_slip_m", *(["frequency_factor"] if settings.frequency_factor else [])]
    count = len(labels)
    values += [found.slip, *([found.factor] if settings.frequency_factor else [])]
    low, high = [*low, *sure.low[count:]], [*high, *sure.high[count:]]
    if found.misfit > LARGE_MISFIT:
        progress.warning(
            f"the misfit of the backbones is {found.misfit:.1f} standard errors: the grid is of another roll, or its "
            "material damping differs; check geometry, damping and the errors in the settings"
        )
    bound = ["mu_p"] if found.outside else []
    table = _Table(names, np.array(values), np.array(low), np.array(high), sure, bound, found.misfit)
    rows = _Rows([], [], [], [], [], [])
    for k, one in enumerate(family):
        _add(rows, k, one.f_n, one.base_level, "f_n in Hz", one.f_n, found.fitted_f[k])
        _add(rows, k, one.f_n, one.base_level, "level in m/s^2", one.base_level, found.fitted_base[k])
    return table, rows


def _label(family: Sequence[Resonance], rolls: Sequence[int], roll: int) -> str:
    """Label of a roll for the names of its parameters: its tension, or its number."""
    tension = next((one.tension for one, own in zip(family, rolls, strict=True) if own == roll), nan)
    return f"{tension:g}_newton" if isfinite(tension) else f"roll_{roll + 1}"


def _add(rows: _Rows, *values: Any) -> None:
    columns: Sequence[list[Any]] = tuple(rows)
    for column, value in zip(columns, values, strict=True):
        column.append(value)


def _summary(table: _Table, kind: str) -> dict[str, Any]:
    return {
        "fit_model": kind,
        "parameters": dict(zip(table.names, map(float, table.values), strict=True)),
        "parameters_low": dict(zip(table.names, map(float, table.low), strict=True)),
        "parameters_high": dict(zip(table.names, map(float, table.high), strict=True)),
        "fit_misfit": table.misfit,
        "undetermined": list(table.sure.undetermined),
        "at_bound": table.at_bound,
    }


def _dataset(table: _Table, rows: _Rows, family: Sequence[Resonance]) -> xr.Dataset:
    size = len(table.sure.names)
    data: dict[str, Any] = {
        "condition_name": ("condition", np.array([one.name for one in family])),
        "parameter_name": ("parameter", np.array(table.names)),
        "parameter_value": ("parameter", table.values),
        "parameter_low": ("parameter", table.low),
        "parameter_high": ("parameter", table.high),
        "parameter_correlation": (("fitted", "other_fitted"), table.sure.correlation),
        "datum_condition": ("datum", np.array(rows.condition)),
        "datum_frequency": ("datum", np.array(rows.frequency)),
        "datum_level": ("datum", np.array(rows.level)),
        "datum_quantity": ("datum", np.array(rows.quantity)),
        "fit_measured": ("datum", np.array(rows.measured)),
        "fit_computed": ("datum", np.array(rows.computed)),
    }
    coordinates = {
        "parameter": np.arange(len(table.names)), "fitted": np.arange(size), "other_fitted": np.arange(size),
        "datum": np.arange(len(rows.measured)), "condition": np.arange(len(family)),
    }  # fmt: skip
    return xr.Dataset(data, coords=coordinates)


KIND = Kind(
    settings=FitSettings,
    evaluate=evaluate,
    files="Result folders of `wroll lab transmissibility` (or their results.nc): conditions of several levels and "
    "tensions.",
    figures={"fit": Figure("wroll_fem.plotting.laboratory.fit:plot_fit", "fit_computed")},
    variables={
        "parameter": ("parameter_name", "parameter_value", "parameter_low", "parameter_high"),
        "datum": ("datum_quantity", "fit_measured", "fit_computed"),
    },
    example=roll_example,
    folders=True,
)
