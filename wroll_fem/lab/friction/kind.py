"""Friction laws fitted to shear tests: mu over slip rate, rate and state, elastic slip."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
import xarray as xr

from wroll_fem.errors import InputError
from wroll_fem.lab.friction.elastic_slip import ElasticSlip, fit_elastic_slip
from wroll_fem.lab.friction.output import (
    friction_text,
    rate_results,
    slip_results,
    state_results,
)
from wroll_fem.lab.friction.rate_law import RateFits, fit_rate_laws
from wroll_fem.lab.friction.settings import FrictionSettings, Wanted
from wroll_fem.lab.friction.state_law import StateFits, fit_state_laws, step_data
from wroll_fem.lab.kinds import Figure, Kind
from wroll_fem.lab.result import LabResult
from wroll_fem.lab.shear.dataset import point_variables
from wroll_fem.lab.shear.evaluation import Measured, measured
from wroll_fem.lab.shear.reading import read_all
from wroll_fem.progress import Progress

DRAW = "wroll_fem.plotting.laboratory.friction"

Result = TypeVar("Result")


@dataclass(frozen=True)
class Fits:
    """Fits that the records allow; None or empty for the others."""

    rate: RateFits | None
    state: list[StateFits]
    slip: ElasticSlip | None


def friction(files: Sequence[Path], settings: FrictionSettings, progress: Progress) -> LabResult:
    """Fit friction laws to records of shear tests.

    Raises
    ------
    InputError
        If the records allow no fit, or not one that is asked for.
    """
    reads, fixture = read_all(files, settings, progress)
    found = []
    with progress.stage("evaluation", len(reads)) as stage:
        for k, read in enumerate(reads, start=1):
            found.append(measured(read, fixture, settings))
            for text in found[-1].doubts:
                progress.warning(text)
            stage.update(k)
    fits = _fits(found, settings, progress)
    summary, data = rate_results(fits.rate, settings.rate_model)
    for more, variables in (state_results(fits.state), slip_results(fits.slip, found, settings.interfaces)):
        summary, data = summary | more, data | variables
    data |= point_variables(found)
    text = friction_text(fits.rate, fits.slip, settings, progress)
    names = [Path(one.read.record.source).name for one in found]
    whole = xr.Dataset(data, coords={"test_record": names})
    return LabResult(summary, whole, {"friction.yaml": text} if text else {})


def _fits(found: Sequence[Measured], settings: FrictionSettings, progress: Progress) -> Fits:
    points = [point for one in found for point in one.points]
    ramps = [one for one in found if one.capacity is not None and one.stiffness is not None]
    slides = [one for one in found if one.read.profile == "sliding" and _has_steps(one, settings)]
    possible: dict[Wanted, bool] = {"rate": len(points) > 1, "state": bool(slides), "elastic_slip": len(ramps) > 1}
    needs = {"rate": "two points of slip rate", "state": "a record with velocity steps", "elastic_slip": "two ramps"}
    for name in settings.fits or ():
        if not possible[name]:
            raise InputError(f"{name} needs {needs[name]}", key="fits", remedy="give such records, or leave it out")
    wanted = [name for name, can in possible.items() if can and (settings.fits is None or name in settings.fits)]
    if not wanted:
        raise InputError(
            "the records allow no fit", key="fits", remedy="give ramps at several preloads, sliding records or loops"
        )

    def tried(name: Wanted, make: Callable[[], Result]) -> Result | None:
        if name not in wanted:
            return None
        try:
            return make()
        except InputError as error:
            if settings.fits is not None:
                raise
            progress.warning(f"{name} is not fitted: {error}")
            return None

    rate = tried("rate", lambda: fit_rate_laws(points, knots=settings.knots))
    state = tried("state", lambda: [_state(one, settings) for one in slides]) or []
    slip = tried("elastic_slip", lambda: _slip(ramps, settings))
    for text in (*(rate.doubts if rate else ()), *(slip.doubts if slip else ())):
        progress.warning(text)
    for one, fitted in zip(slides, state, strict=False):
        for text in fitted.doubts:
            progress.warning(f"{one.read.record.source}: {text}")
    return Fits(rate, state, slip)


def _has_steps(one: Measured, settings: FrictionSettings) -> bool:
    try:
        step_data(one.read.specimen, skip=settings.skip)
    except InputError:
        return False
    return True


def _state(one: Measured, settings: FrictionSettings) -> StateFits:
    return fit_state_laws(
        [one.read.specimen], skip=settings.skip, rate=settings.reference_rate,
        fixture_stiffness=settings.fixture_stiffness,
    )  # fmt: skip


def _slip(ramps: Sequence[Measured], settings: FrictionSettings) -> ElasticSlip:
    return fit_elastic_slip(
        np.array([one.read.record.known_normal_force for one in ramps]),
        [one.stiffness for one in ramps if one.stiffness is not None],
        [one.capacity.force for one in ramps if one.capacity is not None],
        interfaces=settings.interfaces, series=settings.series_compliance,
    )  # fmt: skip


def example(folder: Path) -> list[Path]:
    """Write ramps at four preloads, velocity steps, constant rates and sines.

    Truth: gamma* = 2 um; rate and state with the ageing law, a = b = 0.01, D_R = 20 um; the coefficient 0.25 in steady
    sliding up to 8 mm/s, and 0.25 + 0.01 ln(V/8 mm/s) above, as far as the sines reach.
    """
    from wroll_fem.lab.shear.kind import write_csv
    from wroll_fem.lab.shear.simulated import ramp, sine_loops, velocity_steps
    from wroll_fem.tribology import RateAndState, ShearTest

    rng = np.random.default_rng(2)
    files, forces = [], [50.0, 100.0, 150.0, 200.0]
    for force in forces:
        test = ShearTest(interfaces=1, normal_force=force, elastic_slip=2e-6)
        files.append(write_csv(folder / f"ramp_{force:.0f}N.csv", ramp(test, rng)))
    files.append(write_csv(folder / "steps.csv", velocity_steps(RateAndState(b=0.01), rng)))
    for speed in (1e-4, 1e-3, 8e-3):
        record = velocity_steps(RateAndState(a=0.0, b=0.0), rng, rates=(speed,) * 2, every=1e-3)
        files.append(write_csv(folder / f"rate_{1e3 * speed:g}mms.csv", record))
    fast = sine_loops(
        lambda v: 0.25 + 0.01 * np.log(np.maximum(v, 8e-3) / 8e-3), rng, amplitude=2e-4, frequency=25.0, noise=1.0
    )
    files.append(write_csv(folder / "sine_25Hz.csv", fast))
    text = (
        "units: {displacement: um, force: N}\n"
        f"normal_force: {[*forces, 200.0, 200.0, 200.0, 200.0, 200.0]} # N\n"
        "interfaces: 1\n"
        "skip: 0.5e-3 # m\n"
    )
    (folder / "settings.yaml").write_text(text, encoding="utf-8")
    return files


KIND = Kind(
    settings=FrictionSettings,
    evaluate=friction,
    files="Records as for `shear`: ramps at several preloads, sliding at constant rates and in steps, loops.",
    figures={
        "rate": Figure(f"{DRAW}:plot_rate", "rate_table_coefficient"),
        "state": Figure(f"{DRAW}:plot_state", "step_coefficient"),
        "elastic_slip": Figure(f"{DRAW}:plot_elastic_slip", "preload_compliance"),
    },
    variables={
        "point": ("point_slip_rate", "point_coefficient"),
        "rate_row": ("rate_table_slip_rate", "rate_table_coefficient"),
        "step_sample": ("step_slip", "step_coefficient", "step_ageing", "step_slip_law"),
        "ramp": ("preload_force", "preload_compliance", "preload_capacity"),
    },
    example=example,
)
