"""Random vibration of a case from its backbone, by stochastic averaging: response at levels, and levels at limits."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wroll_fem.analyses.backbone import end_remark, followed_backbone, trained_dataset
from wroll_fem.analyses.curve_reading import memory_remark, reduction_remark, span_remark
from wroll_fem.analyses.forecasts.computing_time import estimate_curve
from wroll_fem.analyses.margins.stress import stress_of_backbone
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.resonant_response import Resonance, Response, at_level, scaled
from wroll_fem.analyses.shared import figures, preflight, summary
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.errors import InputError
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.averaging.averaging_limits import averaging_doubts, quality
from wroll_fem.signals.averaging.notching import factor_at_limit
from wroll_fem.signals.estimators import CurveDamping, estimate_damping, without_half_power_points
from wroll_fem.signals.quality import Circumstances, judge
from wroll_fem.signals.random.psd import PsdTable
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import RandomResponseCase
    from wroll_fem.progress import Progress

CREST = float(np.exp(-4.5))
"""Share of the peaks of a narrow-band Gaussian process that exceed three times its rms."""


def run_random_response(
    case: RandomResponseCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False
) -> xr.Dataset:
    """Follow the backbone of the main mode, then average its response to the PSD of the base acceleration.

    Parameters
    ----------
    checkpoint
        Checkpoint file of the backbone; None writes none.
    resume
        Continue from the checkpoint.

    Raises
    ------
    ConvergenceError
        If a periodic motion of the backbone is not found; ``partial`` contains the curve up to that point.
    InputError
        If the resonance lies outside the PSD, has no damping, or a limit cannot be evaluated.
    """
    system, state = prepare(case, progress)
    started = time.process_time()
    trained = followed_backbone(case, system, state, progress, checkpoint, resume=resume)
    backbone = trained_dataset(system, trained).merge(stress_of_backbone(system, progress, trained.curve))
    for remark in (
        memory_remark(backbone), end_remark(trained.curve, case.backbone.tip_largest),
        reduction_remark(trained.energy_error, case.harmonic),
        span_remark(trained.span_error),
    ):  # fmt: skip
        if remark:
            progress.warning(remark)
    table = at_level(case.excitation.psd.table, case.excitation.factor)
    resonance = Resonance.of_curve(trained.curve, table.band[1])
    averaged = time.process_time()
    dataset = response_dataset(resonance.stored(backbone), resonance, table, case, progress)
    now = time.process_time()
    dataset.attrs |= {
        "solver_time_s": now - started, "averaging_time_s": now - averaged, "excitation_direction": case.direction,
    }  # fmt: skip
    return annotate(dataset)


def response_dataset(
    backbone: xr.Dataset, resonance: Resonance, table: PsdTable, case: RandomResponseCase, progress: Progress
) -> xr.Dataset:
    """Dataset of a backbone with its random response: at the PSD of the case, at its levels, and at its limits."""
    here = Response.of(resonance, table)
    doubts = averaging_doubts(here.law, scaled(table, 1.0), table.band, here.spectra, resonance.others)
    read = read_curve(here, case.output.damping)
    grade = judge(
        read, here.spectra.frequency, np.abs(here.spectra.transmissibility),
        Circumstances(remarks=tuple(doubt.text for doubt in doubts), rigid=resonance.rigid),
    )  # fmt: skip
    for text in dict.fromkeys((*(doubt.text for doubt in doubts), *grade.reasons)):
        progress.warning(text)
    found = grade.as_attrs(read.as_attrs("H1 of the averaged response"))
    data = spectra_variables(here) | level_variables(resonance, table, case)
    data["amplitude_density"] = ("tip_amplitude", tip_density(here, backbone["tip_amplitude"].values))
    attrs = backbone.attrs | found | response_attrs(here, backbone, found["zeta"]) | limit_attrs(
        resonance, table, backbone, case
    )  # fmt: skip
    attrs |= {
        "averaging_quality": quality(doubts),
        "averaging_doubts": "\n".join(doubt.text for doubt in doubts),
        "method": "stochastic averaging of the backbone",
    }
    return backbone.assign(data).assign_coords(frequency=here.spectra.frequency).assign_attrs(attrs)


def read_curve(response: Response, method: str) -> CurveDamping:
    """Resonance frequency and damping ratio from H1, as they are read from a measured one."""
    frequency, T = response.spectra.frequency, response.spectra.transmissibility
    read = estimate_damping(frequency, T, method, noise=0.0)
    return read if method != "half_power" else without_half_power_points(read, frequency, T)


def spectra_variables(response: Response) -> dict[str, tuple[str, FloatArray]]:
    """Spectra of base and tip along `frequency`."""
    spectra = response.spectra
    return {
        "base_psd": ("frequency", spectra.base),
        "tip_psd": ("frequency", spectra.acceleration),
        "tip_displacement_psd": ("frequency", spectra.displacement),
        "transmissibility_real": ("frequency", spectra.transmissibility.real.copy()),
        "transmissibility_imag": ("frequency", spectra.transmissibility.imag.copy()),
    }


def level_variables(
    resonance: Resonance, table: PsdTable, case: RandomResponseCase
) -> dict[str, tuple[str, FloatArray]]:
    """Response along `level_db`, the level of the PSD relative to the case."""
    levels = np.array(case.random_response.levels_db)
    found = [Response.of(resonance, table, 10.0 ** (level / 10.0)) for level in levels]
    read = [read_curve(response, case.output.damping) for response in found]
    rows = {
        "base_rms_at_level": [response.base_rms for response in found],
        "tip_displacement_rms_at_level": [response.displacement_rms for response in found],
        "tip_rms_at_level": [response.acceleration_rms for response in found],
        "frequency_at_level": [one.damping.f_n for one in read],
        "damping_at_level": [one.damping.zeta for one in read],
        "f_effective_at_level": [response.law.mean_frequency for response in found],
        "zeta_effective_at_level": [response.law.mean_damping for response in found],
        "dissipated_power_at_level": [float(response.law.mean(response.law.power)) for response in found],
        "backbone_exceeded_at_level": [response.law.beyond() for response in found],
    }
    data = {name: ("level_db", np.array(values)) for name, values in rows.items()}
    return data | {"level_db": ("level_db", levels)}


def tip_density(response: Response, tip: FloatArray) -> FloatArray:
    """Probability per metre of tip amplitude at the amplitudes ``tip`` (p,) of the backbone."""
    law = response.law
    per_root = np.interp(law.mode.root, law.root.ravel(), law.density.ravel(), right=0.0)
    return np.asarray(per_root / np.gradient(tip, law.mode.root))


def response_attrs(response: Response, backbone: xr.Dataset, zeta: float) -> dict[str, Any]:
    """Attributes of the response at the PSD of the case, named as in summary.json."""
    law = response.law
    power, given = float(law.mean(law.power)), law.input_power
    friction = law.mean_power(backbone["friction_work_per_cycle"].values)
    found: dict[str, Any] = {
        "base_rms_m_s2": response.base_rms,
        "tip_rms_m_s2": response.acceleration_rms,
        "tip_3sigma_m_s2": 3.0 * response.acceleration_rms,
        "tip_displacement_rms_m": response.displacement_rms,
        "tip_displacement_3sigma_m": 3.0 * response.displacement_rms,
        "tip_amplitude_exceeded_m": law.tip_exceeded(CREST),
        "f_effective_hz": law.mean_frequency,
        "zeta_effective": law.mean_damping,
        "dissipated_power_w": power,
        "friction_power_w": friction,
        "power_balance_error": abs(given / power - 1.0),
        "backbone_exceeded": law.beyond(),
    }
    if "slip_amplitude" in backbone:
        found["slip_rms_m"] = law.rms(largest_slip(backbone)).tolist()
    if "vibration_von_mises" in backbone:
        found["von_mises_rms_pa"] = law.rms(backbone["vibration_von_mises"].values).tolist()
    if "material_damping_work_per_cycle" in backbone and power > 0.0:
        share = law.mean_power(backbone["material_damping_work_per_cycle"].values) / power
        found |= {"zeta_material": share * zeta, "zeta_friction": (1.0 - share) * zeta}
    return found


def largest_slip(backbone: xr.Dataset) -> FloatArray:
    """(p, i) amplitude of the relative displacement at the point of each interface where it is largest, m."""
    return np.asarray(backbone["slip_amplitude"].max("point").values)


def limit_attrs(
    resonance: Resonance, table: PsdTable, backbone: xr.Dataset, case: RandomResponseCase
) -> dict[str, Any]:
    """Level at which ``sigma`` times each rms reaches its limit: dB to the PSD of the case, and rms of the base."""
    settings = case.random_response
    if not settings.limits.given:
        return {}
    levels: dict[str, float] = {}
    beyond: dict[str, float] = {}
    for name, limit in settings.limits.given.items():
        measure = _measure(name, resonance, table, backbone)
        try:
            factor = factor_at_limit(lambda factor: settings.sigma * measure(factor), limit)  # noqa: B023
        except InputError as error:
            raise InputError(str(error), key=f"random_response.limits.{name}") from error
        levels[name] = 10.0 * float(np.log10(factor))
        beyond[name] = resonance.law(table, factor).beyond()
    least = min(levels, key=lambda name: levels[name])
    return {
        "level_at_limit_db": levels,
        "backbone_exceeded_at_limit": beyond,
        "allowed_level_db": levels[least],
        "allowed_base_rms_m_s2": table.rms * 10.0 ** (levels[least] / 20.0),
        "limiting_response": least,
    }


def _measure(name: str, resonance: Resonance, table: PsdTable, backbone: xr.Dataset) -> Callable[[float], float]:
    """Rms of a response as a function of the factor on the PSD."""
    if name == "tip_displacement":
        return lambda factor: Response.of(resonance, table, factor).displacement_rms
    if name == "tip_acceleration":
        return lambda factor: Response.of(resonance, table, factor).acceleration_rms
    variable = {"slip": "slip_amplitude", "stress": "vibration_von_mises"}[name]
    if variable not in backbone:
        raise InputError(
            "the structure has no " + {"slip": "interfaces", "stress": "shells whose stress is known"}[name],
            key=f"random_response.limits.{name}", remedy="leave it out",
        )  # fmt: skip
    amplitude = largest_slip(backbone) if name == "slip" else backbone[variable].values
    return lambda factor: float(resonance.law(table, factor).rms(amplitude).max())


def random_response_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """Response per level for summary.json."""
    return {
        "levels_db": dataset["level_db"].values.tolist(),
        "tip_displacement_rms_at_level_m": dataset["tip_displacement_rms_at_level"].values.tolist(),
        "tip_rms_at_level_m_s2": dataset["tip_rms_at_level"].values.tolist(),
        "f_effective_at_level_hz": dataset["f_effective_at_level"].values.tolist(),
        "zeta_effective_at_level": dataset["zeta_effective_at_level"].values.tolist(),
    }


ANALYSIS = Analysis(
    name="random_response",
    sentence="Random vibration from a backbone, without time histories: response at levels, and levels at limits.",
    sections=("geometry", "mandrel", "coil", "contact", "preload", "excitation"),
    run=run_random_response,
    summary=(random_response_summary, summary.interfaces),
    figures=(figures.figure("random_response", "random_response"), figures.figure("backbone", "backbone")),
    variables={
        "frequency": ("base_psd", "tip_psd", "tip_displacement_psd", "transmissibility_real"),
        "level_db": (
            "tip_displacement_rms_at_level", "tip_rms_at_level", "f_effective_at_level",
            "zeta_effective_at_level", "dissipated_power_at_level",
        ),
        "tip_amplitude": ("resonance_frequency", "modal_damping", "amplitude_density"),
    },
    plots=("random_response", "backbone", "transmissibility", "pressure_map"),
    preflight=preflight.CHECKS["random_response"],
    estimate=estimate_curve,
    resumable=True,
)  # fmt: skip
