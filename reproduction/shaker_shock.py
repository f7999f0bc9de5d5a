"""Claim on the shocks of the shaker tests, by simulation: C51 (Figs 3.15, 3.16).

The record of the tests is not in the thesis; the shock here is a half-sine of 20 g and 3 ms, that of lab_shock.yaml.
"""

from __future__ import annotations

from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.shaker_records import RATE, sampled, with_reference
from reproduction.shaker_sweeps import shades
from reproduction.verdict import Verdict
from reproduction.words import monotone, numbers
from wroll_fem.plotting import style
from wroll_fem.plotting.study import PRESSURE, StudyCase
from wroll_fem.results.dataset import label
from wroll_fem.typing import FloatArray

STUDY = "shaker_shock"
STEP, BAND = 0.1, (80.0, 250.0)
"""Distance of the lines of the spectra (the record is padded with zeros), and frequencies that are read, Hz."""


class Shocked(NamedTuple):
    """Response to the shock.

    `pressure` is the external pressure, kPa, 0 for the mandrel alone; `tip` the absolute tip acceleration, m/s^2, over
    `time`, s; `spectrum` its Fourier transform, m/s, at `frequency`, Hz; `fade` the time from which the tip stays
    below a tenth of its largest value, s.
    """

    pressure: float
    time: FloatArray
    tip: FloatArray
    frequency: FloatArray
    spectrum: FloatArray
    fade: float

    @property
    def f_peak(self) -> float:
        """Frequency of the largest value of the spectrum, Hz."""
        return float(self.frequency[int(self.spectrum.argmax())])


def shocked(member: StudyCase) -> Shocked:
    """Response of a case."""
    time, _, tip = sampled(member.data)
    count = round(RATE / STEP)
    frequency = np.fft.rfftfreq(count, 1.0 / RATE)
    spectrum = np.abs(np.fft.rfft(tip, count)) / RATE
    inside = (frequency >= BAND[0]) & (frequency <= BAND[1])
    late = np.flatnonzero(np.abs(tip) > 0.1 * np.abs(tip).max())[-1]
    pressure = 1e-3 * float(member.values.get(PRESSURE, 0.0))
    return Shocked(pressure, time, tip, frequency[inside], spectrum[inside], float(time[late]))


def responses(evidence: Evidence) -> list[Shocked]:
    """Responses of the mandrel alone, then of the rolls in order of growing preload."""
    return [shocked(member) for member in with_reference(evidence, STUDY, PRESSURE)]


def c51(evidence: Evidence) -> Verdict:
    alone, *rolls = responses(evidence)
    peaks = [float(r.spectrum.max()) for r in rolls]
    at = [r.f_peak for r in rolls]
    least = rolls[int(np.argmin(peaks))]
    value = (
        f"half-sine of 20 g and 3 ms; {numbers((r.pressure for r in rolls), '.3g')} kPa: peak of the spectrum of the "
        f"tip {numbers(peaks, '.2f')} m/s at {numbers(at, '.1f')} Hz, the mandrel alone {alone.spectrum.max():.2f} m/s "
        f"at {alone.f_peak:.1f} Hz; lowest at {least.pressure:.3g} kPa; a tenth of the peak after "
        f"{numbers((r.fade for r in rolls), '.2f')} s, mandrel {alone.fade:.2f} s"
    )
    below = max(peaks) < float(alone.spectrum.max())
    return Verdict(value, below and monotone(at, 1) and max(r.fade for r in rolls) < alone.fade)


def time_figure(evidence: Evidence) -> Axes:
    """Draw Fig. 3.15: tip acceleration over time, mandrel alone and two rolls."""
    alone, *rolls = responses(evidence)
    chosen = (alone, rolls[0], rolls[-1])
    _, rows = plt.subplots(
        3, 1, figsize=(style.WIDTH, 6.6), dpi=style.DPI, layout="constrained", sharex=True, sharey=True
    )
    for ax, one, colour in zip(rows, chosen, ("black", style.BLUE, style.RED), strict=True):
        style.axes(ax)
        name = f"{one.pressure:.3g} kPa" if one.pressure else "mandrel alone"
        ax.plot(1e3 * one.time, one.tip, color=colour, lw=0.7, label=f"{name}: a tenth after {1e3 * one.fade:.0f} ms")
        ax.set_ylabel("Tip acceleration\n(m/s²)")
        ax.legend(fontsize=8, framealpha=0.9, loc="upper right")
    rows[-1].set_xlabel("Time (ms)")
    rows[-1].set_xlim(0.0, 600.0)
    top: Axes = rows[0]
    fades = [1e3 * r.fade for r in rolls]
    style.title(
        top, f"Simulated half-sine shock of 20 g and 3 ms: rolls fade to a tenth within {min(fades):.0f} to "
        f"{max(fades):.0f} ms, the mandrel alone within {1e3 * alone.fade:.0f} ms",
    )  # fmt: skip
    return top


def spectrum_figure(evidence: Evidence) -> Axes:
    """Draw Fig. 3.16: spectrum of the tip acceleration, one curve per preload."""
    alone, *rolls = responses(evidence)
    ax = style.axes(None)
    for one, colour in zip(rolls, shades(len(rolls)), strict=True):
        ax.plot(one.frequency, one.spectrum, color=colour, lw=1.5, label=f"{one.pressure:.3g} kPa: {one.f_peak:.1f} Hz")
    text = f"mandrel alone: {alone.f_peak:.1f} Hz"
    ax.plot(alone.frequency, alone.spectrum, color="black", lw=1.2, ls=(0, (5, 2)), label=text)
    ax.set_xlim(100.0, 200.0)
    ax.set_ylim(0.0, 1.05 * float(alone.spectrum.max()))
    ax.set_xlabel(label("frequency"))
    ax.set_ylabel("Spectrum of the tip acceleration (m/s)")
    ax.legend(fontsize=8, framealpha=0.9, title="external pressure", title_fontsize=8)
    least = min(rolls, key=lambda r: float(r.spectrum.max()))
    share = max(float(r.spectrum.max()) for r in rolls) / float(alone.spectrum.max())
    style.title(
        ax, f"Simulated shock: peaks of the rolls reach at most {100 * share:.0f} % of that of the mandrel; the lowest "
        f"is that at {least.pressure:.3g} kPa",
    )  # fmt: skip
    return ax


GROUP = ClaimGroup(
    {"C51": c51},
    figures={
        "ch3_shaker_shock": (
            "Fig 3.15 by simulation: tip acceleration after a half-sine shock of 20 g and 3 ms",
            time_figure,
        ),
        "ch3_shaker_shock_spectrum": ("Fig 3.16 by simulation: spectrum of the tip acceleration", spectrum_figure),
    },
    studies=(STUDY,),
)
