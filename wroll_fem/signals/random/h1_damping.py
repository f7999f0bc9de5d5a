"""Frequency and damping from the transmissibility H1 of averaged spectra, with the noise of the spectra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wroll_fem.signals.estimators import CurveDamping, estimate_damping
from wroll_fem.signals.random.welch import CORRELATED_LINES, Spectra


def noise_of_peak(spectra: Spectra) -> tuple[float, float]:
    """Standard deviation of |H1| at its peak, and the same relative to the peak."""
    peak = int(np.argmax(np.abs(spectra.h1)))
    relative = float(spectra.h1_error[peak])
    return float(np.abs(spectra.h1[peak])) * relative, relative


def damping_of_h1(spectra: Spectra, method: str) -> CurveDamping:
    """Estimate from H1, corrected for the resolution.

    Its standard errors include the correlation of neighbouring lines, its `noise` is that of the spectra.

    Parameters
    ----------
    spectra
        Averaged spectra.
    method
        Estimator, a key of `ESTIMATORS`.

    Raises
    ------
    InputError
        If the spectra are no curve, or the method is unknown.
    """
    noise, relative = noise_of_peak(spectra)
    read = estimate_damping(spectra.frequency, spectra.h1_corrected, method, noise=noise)
    errors = {name: CORRELATED_LINES * getattr(read.damping, name) for name in ("f_n_error", "zeta_error")}
    return replace(read, damping=replace(read.damping, **errors), noise=relative)
