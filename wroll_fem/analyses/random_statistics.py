"""Numbers of a random motion: quality of its readings, statistics of its steady part, accuracy of its spectra."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from scipy.stats import kurtosis

from wroll_fem.analyses.random_reading import FEWEST_AVERAGES, LARGEST_BIAS, LARGEST_SHARE, SETTLED, Reading
from wroll_fem.analyses.shared.time_step import random_step_error
from wroll_fem.analyses.shared.zeta_parts import parts_of_random
from wroll_fem.analyses.sweep import numerical_remark
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.quality import Circumstances, judge
from wroll_fem.signals.random.welch import Spectra, rms_error, wanted_resolution
from wroll_fem.signals.tip import absolute_tip, rigid_tip

if TYPE_CHECKING:
    from wroll_fem.case import RandomCase
    from wroll_fem.case.excitation import RandomExcitation
    from wroll_fem.typing import FloatArray


DISSIPATED = ("material_damping", "friction_energy", "pressure_modulation_work", "impact_dissipation")
"""Energies along time that share the damping ratio."""


def graded(case: RandomCase, histories: Sequence[xr.Dataset], found: Reading) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Attributes of the resonance of one or several records of one level, and the reasons for doubts."""
    history, frequency, h1 = histories[0], found.spectra.frequency, found.spectra.h1_corrected
    error, coarse = random_step_error(case, (frequency, np.abs(h1)), *(found.resonance or (np.nan, np.nan)))
    short = _shortness(found, history, case.excitation)
    remarks = (*short, coarse, numerical_remark(history))
    known = Circumstances(None, history.attrs.get("tip_participation"), remarks=remarks, rigid=rigid_tip(history))
    quality = judge(found.read, frequency, np.abs(h1), known)
    if not found.read.damping.found:
        quality = replace(quality, reasons=(*quality.reasons, *short))
    attrs = quality.as_attrs(found.read.as_attrs("H1"))
    energies = [name for name in DISSIPATED if name in history]
    mean = sum((one[energies] for one in histories[1:]), history[energies]) / len(histories)
    attrs |= parts_of_random(mean, attrs["zeta"], found.start)
    return attrs | {"time_step_error": error}, quality.reasons


def _shortness(found: Reading, history: xr.Dataset, excitation: RandomExcitation) -> tuple[str, ...]:
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


def spectra_variables(spectra: Spectra) -> xr.Dataset:
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


def statistics(steady: xr.Dataset, spectra: Spectra) -> dict[str, Any]:
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


def accuracy(found: Reading) -> dict[str, Any]:
    """Entries of the summary: how far the spectra can be trusted."""
    return {
        "steady_start_s": found.start, "psd_resolution_hz": found.spectra.resolution,
        "psd_averages": found.spectra.averages, "psd_random_error": found.spectra.psd_error,
        "psd_peak_bias": found.bias,
    }  # fmt: skip
