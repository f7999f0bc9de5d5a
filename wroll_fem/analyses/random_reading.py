"""Averaged spectra of the steady part of random motions, and the resonance read from them.

The steady part starts when the transient of the start has decayed: after `SETTLED` time constants of the resonance,
whose damping is read from the spectra of a first pass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from wroll_fem.case.excitation.random import FEWEST_AVERAGED_LINES
from wroll_fem.signals.estimators import CurveDamping
from wroll_fem.signals.random.h1_damping import damping_of_h1
from wroll_fem.signals.random.welch import (
    Spectra,
    averaged_spectra,
    peak_bias,
    pooled,
    wanted_resolution,
)
from wroll_fem.signals.tip import absolute_tip

if TYPE_CHECKING:
    from wroll_fem.case.excitation import RandomExcitation

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

FEWEST_OF_RECORDS = 6
"""Smallest number of segments of each of several records: four are left where the steady part starts latest."""

PASSES = 3
"""Number of times that steady part and resolution are chosen; they change little after the second."""


@dataclass(frozen=True)
class Reading:
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


def read_spectra(history: xr.Dataset, excitation: RandomExcitation, method: str) -> Reading:
    """Spectra of the steady part of a history, with the resolution of the case or one that suits the resonance."""
    return read_records([history], excitation, method)


def read_records(
    histories: Sequence[xr.Dataset], excitation: RandomExcitation, method: str, resolution: float | None = None
) -> Reading:
    """Spectra of the steady parts of several records of one PSD and one length, averaged over the records.

    ``resolution`` (Hz) replaces the resolution of the case.
    """
    time = histories[0]["time"].values
    records = [(one["base_acceleration"].values, absolute_tip(one)) for one in histories]
    dt, end, count = float(time[1] - time[0]), float(time[-1]), len(records)
    given = excitation.resolution if resolution is None else resolution
    low, high = excitation.psd.table.band
    bias = WANTED_BIAS if excitation.accuracy is None else excitation.accuracy.bias
    start, chosen = FIRST_GUESS * end, 0.0

    def read(start: float, resolution: float) -> Reading:
        keep = time >= start
        spectra = pooled([averaged_spectra(base[keep], tip[keep], dt, resolution) for base, tip in records])
        inside = _inside(spectra, low, high)
        return Reading(start, inside, damping_of_h1(inside, method))

    for _ in range(PASSES):
        coarsest = (high - low) / FEWEST_AVERAGED_LINES
        first = 0.5 * (FIRST_SEGMENTS + 1) / (end - start)
        chosen = (chosen or first) if isinstance(given, str) else given
        found = read(start, chosen)
        if found.resonance is None:
            break
        f_n, zeta = found.resonance
        start = min(LARGEST_SHARE * end, SETTLED / (2.0 * np.pi * f_n * zeta))
        fewest = max(FEWEST_AVERAGES / count, FEWEST_OF_RECORDS)
        finest = 0.5 * (fewest + 1) / (end - start)
        chosen = max(min(wanted_resolution(f_n, zeta, bias), coarsest), finest)
    return found


def _inside(spectra: Spectra, low: float, high: float) -> Spectra:
    """Lines of the band without those at its ends, to which the Hann window carries no full energy."""
    edge = HANN_REACH * spectra.resolution
    return spectra.within(low + edge, high - edge)
