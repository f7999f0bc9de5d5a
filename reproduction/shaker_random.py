"""Claims on the random motion of the shaker tests, by simulation: C49, C50 (Figs 3.12, 3.13).

One record at growing levels shakes the mandrel alone and rolls with the pressure of windings of 20 and 60 N. The
records are read by the laboratory evaluation `transmissibility`: H1, rational fraction.
"""

from __future__ import annotations

from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.shaker_records import hashes, measured, with_reference
from reproduction.verdict import Verdict
from reproduction.words import monotone, numbers
from wroll_fem.plotting import style
from wroll_fem.plotting.study import StudyCase
from wroll_fem.plotting.winding import TENSION
from wroll_fem.results.dataset import label, load_dataset
from wroll_fem.typing import FloatArray

STUDY = "shaker_random"
BAND = (80.0, 260.0)
"""Frequencies that are read, Hz."""


class Series(NamedTuple):
    """Readings of one structure over the level.

    `tension` is in N, 0 for the mandrel alone; `level` is the factor of the largest motion; `base` and `tip` are rms
    accelerations, m/s^2; `f_n` in Hz with its standard error; `zeta` with its standard error.
    """

    tension: float
    level: FloatArray
    base: FloatArray
    tip: FloatArray
    f_n: FloatArray
    f_error: FloatArray
    zeta: FloatArray
    zeta_error: FloatArray

    @property
    def name(self) -> str:
        """Name of the structure in figures."""
        return f"{self.tension:g} N" if self.tension else "mandrel alone"


def histories(evidence: Evidence, member: StudyCase) -> dict[str, xr.Dataset]:
    """Time history of each level, "0.1" -> Dataset, from the run folder of a case."""
    folder, data = evidence.run_folder(STUDY, member) / "levels", member.data
    (seed,) = data["seed"].values
    files = [folder / f"level_{db:+.9g}_dB_seed_{seed}.nc" for db in data["level_db"].values]
    return {f"{level:.3g}": load_dataset(file) for level, file in zip(data["level"].values, files, strict=True)}


def curves(evidence: Evidence) -> list[xr.Dataset]:
    """Curves and readings over the level: mandrel alone, then the rolls in order of growing tension."""
    found = []
    for member in with_reference(evidence, STUDY, TENSION):

        def compute(member: StudyCase = member) -> xr.Dataset:
            data = measured(histories(evidence, member), method="random", band=list(BAND))
            data["level"] = "condition", member.data["level"].values
            return data

        found.append(evidence.kept(STUDY, compute, cases=hashes([member]), band=BAND))
    return found


def readings(evidence: Evidence) -> list[Series]:
    """Readings of the mandrel alone, then of the rolls in order of growing tension."""
    members = with_reference(evidence, STUDY, TENSION)
    names = ("level", "base_level", "tip_level", "condition_f_n", "condition_f_n_error", "condition_zeta")
    return [
        Series(float(m.values.get(TENSION, 0.0)), *(data[name].values for name in (*names, "condition_zeta_error")))
        for m, data in zip(members, curves(evidence), strict=True)
    ]


def said(one: Series) -> str:
    """Readings of one structure as text."""
    return f"{one.name}: f_n {numbers(one.f_n, '.1f')} Hz, zeta {numbers(100 * one.zeta, '.2f')} %"


def c49(evidence: Evidence) -> Verdict:
    alone, loose, *_ = readings(evidence)
    fall = 1.0 - float(loose.f_n[-1] / loose.f_n[0])
    apart = float(np.ptp(alone.f_n) / alone.f_n[0])
    value = (
        f"levels {numbers(loose.base, '.2f')} m/s^2 rms; {said(loose)}; f_n falls by {100 * fall:.1f} %; the mandrel "
        f"alone changes by {100 * apart:.2g} % (zeta {numbers(100 * alone.zeta, '.2f')} %)"
    )
    return Verdict(value, 0.02 <= fall <= 0.1 and monotone(loose.zeta.tolist(), 1) and apart < 0.01)


def c50(evidence: Evidence) -> Verdict:
    _, loose, *_, tight = readings(evidence)
    value = f"levels {numbers(tight.base, '.2f')} m/s^2 rms; {said(loose)}; {said(tight)}"
    return Verdict(value, bool(np.all(tight.zeta < loose.zeta) and np.all(tight.f_n > loose.f_n)))


def curves_figure(evidence: Evidence) -> Axes:
    """Draw Fig. 3.12: transmissibility over frequency, one panel per structure, one curve per level."""
    found, series = curves(evidence), readings(evidence)
    _, rows = plt.subplots(
        len(series), 1, figsize=(style.WIDTH, 2.4 * len(series) + 0.6), dpi=style.DPI, layout="constrained", sharex=True
    )
    for ax, data, one in zip(rows, found, series, strict=True):
        style.axes(ax)
        for k, colour in enumerate(colormaps["viridis"](np.linspace(0.0, 0.85, one.level.size))):
            size = np.hypot(data["family_real"].values[k], data["family_imag"].values[k])
            ax.semilogy(data["frequency"], size, color=colour, lw=1.4, label=f"{one.level[k]:.3g}")
        ax.set_ylabel("|T| (–)")
        ax.legend(fontsize=8, framealpha=0.9, title=f"{one.name}, level", title_fontsize=8)
        ax.set_xlim(110.0, 200.0)
        ax.set_ylim(1.0, 200.0)
    rows[-1].set_xlabel(label("frequency"))
    falls = ", ".join(f"{s.name} {100 * abs(1 - s.f_n[-1] / s.f_n[0]):.1f} %" for s in series)
    top: Axes = rows[0]
    style.title(top, f"Simulated random motion up to {series[0].base[-1]:.2g} m/s² rms; change of $f_n$: {falls}")
    return top


def levels_figure(evidence: Evidence) -> Axes:
    """Draw Fig. 3.13: damping over the level."""
    ax = style.axes(None)
    series = readings(evidence)
    for one, colour, mark in zip(series, ("black", style.BLUE, style.RED), "Dos", strict=False):
        error = 196.0 * np.nan_to_num(one.zeta_error)
        ax.errorbar(
            one.level, 100 * one.zeta, error, color=colour, marker=mark, lw=1.5, ms=5, capsize=3, label=one.name
        )
    ax.set_xlim(0.0, 1.05)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel(f"Level of the base, relative to the largest ({series[0].base[-1]:.3g} m/s² rms)")
    ax.set_ylabel("Damping ratio (%), bars: 95 %")
    ax.legend(fontsize=8, framealpha=0.9)
    _, loose, *_, tight = series
    style.title(
        ax, f"Simulated random motion: damping grows with the level, {loose.name} to {100 * loose.zeta[-1]:.1f} %, "
        f"{tight.name} to {100 * tight.zeta[-1]:.1f} %; that of the mandrel stays",
    )  # fmt: skip
    return ax


GROUP = ClaimGroup(
    {"C49": c49, "C50": c50},
    figures={
        "ch3_shaker_random": (
            "Fig 3.12 by simulation: random motion, mandrel alone and rolls of 20 and 60 N",
            curves_figure,
        ),
        "ch3_shaker_random_levels": (
            "Fig 3.13 by simulation: damping over the level of the random motion",
            levels_figure,
        ),
    },
    studies=(STUDY,),
)
