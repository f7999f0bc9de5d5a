"""Random: time history under a random motion of the base, its spectra, damping and statistics.

All statistics are those of the steady part. It starts when the transient of the start has decayed: after `SETTLED` time
constants of the resonance, whose damping is read from the spectra of a first pass.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from scipy.stats import kurtosis

from wroll_fem.analyses.forecasts.computing_time import estimate_history
from wroll_fem.analyses.history import FIELDS, FIGURES, PLOTS, SUMMARY, VARIABLES, time_history
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import preflight
from wroll_fem.analyses.shared.figures import figure
from wroll_fem.analyses.shared.time_step import random_step_error
from wroll_fem.analyses.shared.zeta_parts import parts_of_random
from wroll_fem.analyses.sweep import numerical_remark
from wroll_fem.case.excitation.random import FEWEST_AVERAGED_LINES
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.estimators import CurveDamping
from wroll_fem.signals.quality import Circumstances, judge
from wroll_fem.signals.random.h1_damping import damping_of_h1
from wroll_fem.signals.random.welch import (
    Spectra,
    averaged_spectra,
    peak_bias,
    rms_error,
    wanted_resolution,
)
from wroll_fem.signals.tip import absolute_tip, rigid_tip
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import RandomCase
    from wroll_fem.case.excitation import RandomExcitation
    from wroll_fem.progress import Progress

SETTLED = 5.0
"""Time constants 1 / (2 pi f_n zeta) of the resonance that the steady part leaves out: 0.7 % of a transient remain."""

FIRST_GUESS, LARGEST_SHARE = 0.1, 0.25
"""Part of the record that the first pass leaves out, and the largest part that is ever left out."""

WANTED_BIAS, LARGEST_BIAS = 0.0133, 0.027
"""Part of the peak of a PSD that the resolution may take: wanted by `auto`, and the largest without a warning."""

FEWEST_AVERAGES, FIRST_SEGMENTS = 8, 16
"""Smallest number of segments with which `auto` still refines the resolution, and number of those of the first pass."""

HANN_REACH = 1.5
"""Lines next to the ends of the band that are left out: there the Hann window averages over frequencies outside."""

PASSES = 3
"""Number of times that steady part and resolution are chosen; they change little after the second."""


@dataclass(frozen=True)
class _Reading:
    """Spectra of the steady part, and the resonance read from them.

    Attributes
    ----------
    start
        Time at which the steady part starts, s.
    spectra
        Averaged spectra of base and tip acceleration.
    read
        Frequency and damping from H1.
    """

    start: float
    spectra: Spectra
    read: CurveDamping

    @property
    def resonance(self) -> tuple[float, float] | None:
        """Frequency (Hz) and damping ratio; None without."""
        f_n, zeta = self.read.damping.f_n, self.read.damping.zeta
        if not np.isfinite(zeta):
            f_n, zeta = self.read.shape.f_n, self.read.shape.zeta
        return (f_n, zeta) if np.isfinite(f_n) and np.isfinite(zeta) and zeta > 0.0 else None

    @property
    def bias(self) -> float:
        """Part of the peak of the PSD that the resolution takes; nan without a resonance."""
        return np.nan if self.resonance is None else peak_bias(self.spectra.resolution, *self.resonance)


def run_random(
    case: RandomCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False
) -> xr.Dataset:
    """Compute the time history with energy ledger and slip fields, spectra, damping from H1, and rms values.

    Parameters
    ----------
    checkpoint
        Checkpoint file; None writes none.
    resume
        Continue from the checkpoint.

    Raises
    ------
    ConvergenceError
        If a step does not converge; ``partial`` has the history up to that step.
    """
    history = time_history(case, progress=progress, checkpoint=checkpoint, resume=resume)
    found = read_spectra(history, case.excitation, case.output.damping)
    frequency, h1 = found.spectra.frequency, found.spectra.h1_corrected
    error, coarse = random_step_error(case, (frequency, np.abs(h1)), *(found.resonance or (np.nan, np.nan)))
    short = _shortness(found, history, case.excitation)
    remarks = (*short, coarse, numerical_remark(history))
    participation = history.attrs.get("tip_participation")
    known = Circumstances(None, participation, remarks=remarks, rigid=rigid_tip(history))
    quality = judge(found.read, frequency, np.abs(h1), known)
    if not found.read.damping.found:
        quality = replace(quality, reasons=(*quality.reasons, *short))
    for text in quality.reasons:
        progress.warning(text)
    attrs = quality.as_attrs(found.read.as_attrs("H1"))
    attrs |= parts_of_random(history, attrs["zeta"], found.start)
    dataset = xr.merge([history, _variables(found.spectra)], combine_attrs="drop_conflicts")
    steady = history.isel(time=history["time"].values >= found.start)
    attrs |= _statistics(steady, found.spectra) | _accuracy(found)
    return dataset.assign_attrs(history.attrs | attrs | {"time_step_error": error})


def read_spectra(history: xr.Dataset, excitation: RandomExcitation, method: str) -> _Reading:
    """Spectra of the steady part of a history, with the resolution of the case or one that suits the resonance."""
    time, base, tip = history["time"].values, history["base_acceleration"].values, absolute_tip(history)
    dt, end = float(time[1] - time[0]), float(time[-1])
    given = excitation.resolution
    low, high = excitation.psd.table.band
    start, resolution = FIRST_GUESS * end, 0.0

    def read(start: float, resolution: float) -> _Reading:
        keep = time >= start
        spectra = _inside(averaged_spectra(base[keep], tip[keep], dt, resolution), *excitation.psd.table.band)
        return _Reading(start, spectra, damping_of_h1(spectra, method))

    for _ in range(PASSES):
        coarsest = (high - low) / FEWEST_AVERAGED_LINES
        first = 0.5 * (FIRST_SEGMENTS + 1) / (end - start)
        resolution = (resolution or first) if isinstance(given, str) else given
        found = read(start, resolution)
        if found.resonance is None:
            break
        f_n, zeta = found.resonance
        start = min(LARGEST_SHARE * end, SETTLED / (2.0 * np.pi * f_n * zeta))
        finest = 0.5 * (FEWEST_AVERAGES + 1) / (end - start)
        resolution = max(min(wanted_resolution(f_n, zeta, WANTED_BIAS), coarsest), finest)
    return found


def _inside(spectra: Spectra, low: float, high: float) -> Spectra:
    """Lines of the band without those at its ends, to which the Hann window carries no full energy."""
    edge = HANN_REACH * spectra.resolution
    return spectra.within(low + edge, high - edge)


def _shortness(found: _Reading, history: xr.Dataset, excitation: RandomExcitation) -> tuple[str, ...]:
    """Warnings about a record that is too short for the resonance."""
    if found.resonance is None:
        return ()
    (f_n, zeta), end = found.resonance, float(history["time"].values[-1])
    texts = []
    settling = SETTLED / (2.0 * np.pi * f_n * zeta)
    if settling > 1.001 * LARGEST_SHARE * end:
        texts.append(
            f"the transient of the start takes about {settling:.3g} s to decay, but only {found.start:.3g} s of the "
            f"record are left out; set excitation.duration to {settling / LARGEST_SHARE:.3g} s or more"
        )
    if found.bias > LARGEST_BIAS:
        finer = wanted_resolution(f_n, zeta, LARGEST_BIAS)
        remedy = (
            f"set excitation.duration to {found.start + 0.5 * (FEWEST_AVERAGES + 1) / finer:.3g} s or more"
            if excitation.resolution == "auto"
            else f"set excitation.resolution to {finer:.2g} Hz or less"
        )
        texts.append(
            f"the spectra have lines at {found.spectra.resolution:.3g} Hz, coarse for a half-power width of "
            f"{2.0 * zeta * f_n:.3g} Hz: the peak of the PSD is {100 * found.bias:.2g} % too low, and the correction "
            f"of H1 is uncertain; {remedy}"
        )
    return tuple(texts)


def _variables(spectra: Spectra) -> xr.Dataset:
    """Variables along `frequency`."""
    h1, hv = spectra.h1_corrected, spectra.hv
    columns = {
        "base_psd": spectra.base, "tip_psd": spectra.response, "transmissibility_real": h1.real,
        "transmissibility_imag": h1.imag, "hv_real": hv.real, "hv_imag": hv.imag, "coherence": spectra.coherence,
        "h1_error": spectra.h1_error,
    }  # fmt: skip
    data = {name: ("frequency", np.array(values)) for name, values in columns.items()}
    found = annotate(xr.Dataset(data, coords={"frequency": spectra.frequency}))
    for part, words in (("real", "real part"), ("imag", "imaginary part")):
        found[f"transmissibility_{part}"].attrs["long_name"] = f"transmissibility H1, {words}"
    return found


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _statistics(steady: xr.Dataset, spectra: Spectra) -> dict[str, Any]:
    """Entries of the summary: rms and 3 sigma values of the steady part."""
    tip, displacement = absolute_tip(steady), steady["tip_displacement"].values
    found = {
        "base_rms_m_s2": _rms(steady["base_acceleration"].values),
        "tip_rms_m_s2": _rms(tip), "tip_3sigma_m_s2": 3.0 * _rms(tip),
        "tip_displacement_rms_m": _rms(displacement), "tip_displacement_3sigma_m": 3.0 * _rms(displacement),
        "tip_kurtosis": float(kurtosis(tip, fisher=False)),
        "tip_rms_error": rms_error(spectra.frequency, spectra.response, float(np.ptp(steady["time"].values))),
    }  # fmt: skip
    for name, unit in (("base_shear", "n"), ("base_moment", "nm")):
        if name in steady:
            size = _rms(steady[name].values)
            found |= {f"{name}_rms_{unit}": size, f"{name}_3sigma_{unit}": 3.0 * size}
    return found


def _accuracy(found: _Reading) -> dict[str, Any]:
    """Entries of the summary: how far the spectra can be trusted."""
    return {
        "steady_start_s": found.start, "psd_resolution_hz": found.spectra.resolution,
        "psd_averages": found.spectra.averages, "psd_random_error": found.spectra.psd_error,
        "psd_peak_bias": found.bias,
    }  # fmt: skip


ANALYSIS = Analysis(
    name="random",
    sentence="Time history under a random motion of the base: spectra, transmissibility, damping, rms values, slip.",
    sections=("geometry", "mandrel", "coil", "contact", "preload", "excitation"),
    run=run_random,
    summary=SUMMARY,
    figures=(figure("spectra", "spectra", needs="coherence"), *FIGURES),
    fields=FIELDS,
    variables=VARIABLES
    | {
        "frequency": (
            "base_psd", "tip_psd", "transmissibility_real", "transmissibility_imag", "coherence", "h1_error",
            "hv_real", "hv_imag",
        )
    },
    plots=("spectra", "transmissibility", "comparison", *PLOTS),
    preflight=preflight.CHECKS["random"],
    estimate=estimate_history,
    resumable=True,
)  # fmt: skip
