"""Band-limited interpolation of a record by an integer factor."""

from __future__ import annotations

import numpy as np
from scipy.signal import firwin, upfirdn

from wroll_fem.typing import FloatArray

HALF_LENGTH = 32
"""Half-length of the interpolation filter, samples of the record; a sine below 0.9 of half the sampling rate is
interpolated to 1e-3."""


def upsampled(record: FloatArray, factor: int) -> FloatArray:
    """Record with ``factor`` times the sampling rate, from its first to its last sample.

    Parameters
    ----------
    record
        (n,) samples; zero outside.
    factor
        Whole number of new steps per step of the record.

    Returns
    -------
    numpy.ndarray
        (factor (n - 1) + 1,) samples, by a linear-phase filter of windowed sinc type (Kaiser).
    """
    if factor == 1:
        return record
    half = HALF_LENGTH * factor
    taps = factor * firwin(2 * half + 1, 1.0 / factor, window=("kaiser", 8.0))
    found = upfirdn(taps, record, up=factor)
    return np.ascontiguousarray(found[half : half + factor * (record.size - 1) + 1])
