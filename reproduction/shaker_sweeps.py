"""Claims on the sine sweeps of the shaker tests, by simulation: C43, C45 to C48 (Fig 3.11).

The rolls go through the sweep of the experiment, 5 to 300 Hz in 45 s at 5 m/s^2, with the damping of the mandrel alone
as material damping. As there, frequency and damping are read by half power from the ratio of the spectra of tip and
base over the whole record (section 3.3). The laboratory evaluation `transmissibility`, which demodulates the records,
stands beside.
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
from reproduction.lab_studies import bound
from reproduction.shaker_records import hashes, measured, sampled, with_reference
from reproduction.verdict import Verdict
from reproduction.words import monotone, numbers
from wroll_fem.plotting import style
from wroll_fem.plotting.study import PRESSURE
from wroll_fem.results.dataset import label
from wroll_fem.signals.estimators import estimate_damping
from wroll_fem.signals.transmissibility import spectrum_ratio

STUDY = "shaker_sweep"
BAND, STEP = (80.0, 250.0), 0.02
"""Frequencies that are read, and distance of the lines of the ratio of the spectra, Hz."""


class Reading(NamedTuple):
    """What is read from a sweep.

    `pressure` is the external pressure, kPa, 0 for the mandrel alone; `f_n` in Hz, `zeta`, `peak` and the skew ratio
    `skew` are from the ratio of the spectra; `f_lab` in Hz, `zeta_lab` and `skew_lab` from the demodulated record;
    `zeta_lab` is nan where the laboratory evaluation refuses it because the sweep is too fast for the peak.
    """

    pressure: float
    f_n: float
    zeta: float
    peak: float
    skew: float
    f_lab: float
    zeta_lab: float
    skew_lab: float


def curves(evidence: Evidence) -> xr.Dataset:
    """Curves by the ratio of the spectra (`ratio_*`) and by demodulation (`family_*`); mandrel alone first."""
    members = with_reference(evidence, STUDY, PRESSURE)

    def compute() -> xr.Dataset:
        grid = np.arange(BAND[0], BAND[1], STEP)
        ratios = []
        for member in members:
            time, base, tip = sampled(member.data)
            found = spectrum_ratio(time, tip, base, frequency=grid)
            real, imaginary = (found[f"transmissibility_spectrum_{part}"].values for part in ("real", "imag"))
            ratios.append(real + 1j * imaginary)
        read = [estimate_damping(grid, np.abs(ratio), "half_power", noise=0.0) for ratio in ratios]
        pressure = [float(m.values.get(PRESSURE, 0.0)) for m in members]
        names = {f"{1e-3 * p:g} kPa": m.data for p, m in zip(pressure, members, strict=True)}
        data = measured(names, method="sweep", band=list(BAND))
        data["ratio_real"] = ("condition", "line"), np.real(ratios)
        data["ratio_imag"] = ("condition", "line"), np.imag(ratios)
        for name in ("f_n", "peak", "skewness"):
            data[f"ratio_{name}"] = "condition", [float(getattr(one.shape, name)) for one in read]
        data["ratio_zeta"] = "condition", [float(one.damping.zeta) for one in read]
        data["pressure"] = "condition", pressure
        return data.assign_coords(line=grid)

    return evidence.kept(STUDY, compute, cases=hashes(members), band=BAND, step=STEP)


def readings(evidence: Evidence) -> list[Reading]:
    """Readings of the mandrel alone, then of the rolls in order of growing preload."""
    data = curves(evidence)
    ratio = np.transpose([data[f"ratio_{name}"].values for name in ("f_n", "zeta", "peak", "skewness")])
    lab = np.transpose([data[name].values for name in ("condition_f_n", "condition_zeta", "skewness")])
    return [
        Reading(1e-3 * pressure, f_n, zeta, peak, skewness + 1.0, f_lab, zeta_lab, skew_lab + 1.0)
        for pressure, (f_n, zeta, peak, skewness), (f_lab, zeta_lab, skew_lab) in zip(
            data["pressure"].values.tolist(), ratio.tolist(), lab.tolist(), strict=True
        )
    ]


def pressures(rolls: list[Reading]) -> str:
    """Preloads as text."""
    return f"{numbers((r.pressure for r in rolls), '.3g')} kPa"


def demodulated(rolls: list[Reading]) -> str:
    """Damping of the demodulated records as text, per cent."""
    return ", ".join(f"{100 * r.zeta_lab:.2f}" if np.isfinite(r.zeta_lab) else "none" for r in rolls)


def c43(evidence: Evidence) -> Verdict:
    _, *rolls = readings(evidence)
    skew = [r.skew for r in rolls]
    value = (
        f"SK {numbers(skew, '.2f')} at {pressures(rolls)} (7.9 oct/min, 5 m/s^2, ratio of the spectra); demodulated "
        f"{numbers((r.skew_lab for r in rolls), '.2f')}"
    )
    return Verdict(value, skew[0] > 1.05 and monotone(skew, -1) and abs(skew[-1] - 1.0) < abs(skew[0] - 1.0))


def c45(evidence: Evidence) -> Verdict:
    alone, *rolls = readings(evidence)
    lowest = min(rolls, key=lambda r: r.f_n)
    ratio = lowest.f_n / alone.f_n
    value = (
        f"{lowest.f_n:.1f} Hz at {lowest.pressure:.3g} kPa, {ratio:.3f} of the mandrel alone ({alone.f_n:.1f} Hz); "
        f"base free; demodulated {lowest.f_lab:.1f} Hz"
    )
    return Verdict(value, abs(ratio - 0.9) <= 0.05)


def c46(evidence: Evidence) -> Verdict:
    alone, *rolls = readings(evidence)
    highest = max(r.f_n for r in rolls) / alone.f_n
    bonded = bound(evidence, "bonded", "free") / alone.f_n
    value = f"largest f_n/f_m {highest:.3f}, f_b/f_m {bonded:.3f} (base free)"
    return Verdict(value, all(1.02 <= ratio <= 1.13 for ratio in (highest, bonded)))


def c47(evidence: Evidence) -> Verdict:
    alone, *rolls = readings(evidence)
    zeta = np.array([r.zeta for r in rolls])
    inside = np.count_nonzero((zeta >= 0.01) & (zeta <= 0.05))
    value = (
        f"zeta {numbers(100 * zeta, '.2f')} % at {pressures(rolls)}, of which 0.5 % is material damping, an input; the "
        f"mandrel alone {100 * alone.zeta:.2f} %; demodulated records {demodulated(rolls)} %"
    )
    return Verdict(value, bool(2 * inside >= zeta.size and np.nanmax(zeta) <= 0.1))


def c48(evidence: Evidence) -> Verdict:
    alone, *rolls = readings(evidence)
    least = min(rolls, key=lambda r: r.zeta)
    value = (
        f"least {100 * least.zeta:.2f} % at {least.pressure:.3g} kPa, the mandrel alone {100 * alone.zeta:.2f} %, both "
        "with 0.5 % of material damping"
    )
    return Verdict(value, bool(least.zeta > alone.zeta))


def shades(count: int) -> list[tuple[float, ...]]:
    """Colours of the preloads, from loose to tight."""
    return [tuple(colour) for colour in colormaps["viridis"](np.linspace(0.0, 0.85, count))]


def figure(evidence: Evidence) -> Axes:
    """Draw Fig. 3.11: transmissibility over frequency, and damping over resonance."""
    data, found = curves(evidence), readings(evidence)
    alone, *rolls = found
    _, rows = plt.subplots(2, 1, figsize=(style.WIDTH, 7.6), dpi=style.DPI, layout="constrained", height_ratios=[3, 2])
    top, low = (style.axes(ax) for ax in rows)
    colours = ["black", *shades(len(rolls))]
    for k, (one, colour) in enumerate(zip(found, colours, strict=True)):
        name = f"{one.pressure:.3g} kPa" if one.pressure else "mandrel alone"
        ratio, lab = (np.hypot(data[f"{x}_real"].values[k], data[f"{x}_imag"].values[k]) for x in ("ratio", "family"))
        top.plot(data["line"], ratio, color=colour, lw=1.6, label=f"{name}: {one.f_n:.1f} Hz, {100 * one.zeta:.2f} %")
        if one.pressure:
            top.plot(data["frequency"], lab, color=colour, lw=1.0, ls=":")
        low.plot(one.f_n, 100 * one.zeta, "o" if one.pressure else "D", color=colour, ms=6)
        low.annotate(name, (one.f_n, 100 * one.zeta), (7, 3), textcoords="offset points", fontsize=8)
    top.plot([], [], color=style.GREY, lw=1.0, ls=":", label="demodulated record")
    top.set_xlim(100.0, 200.0)
    top.set_ylim(0.0, 1.25 * max(r.peak for r in rolls))
    top.set_xlabel(label("frequency"))
    top.set_ylabel("Transmissibility |T| (–)")
    top.legend(fontsize=8, framealpha=0.9, title="external pressure", title_fontsize=8)
    low.margins(0.12)
    low.set_ylim(bottom=0.0)
    low.set_xlabel("Resonance $f_n$ (Hz)")
    low.set_ylabel("Damping ratio ζ,\nhalf power (%)")
    said = f"from {100 * min(r.zeta for r in rolls):.1f} to {100 * max(r.zeta for r in rolls):.1f} %"
    style.title(
        top, f"Simulated sweep of the shaker tests: rolls are damped {said}, the mandrel {100 * alone.zeta:.1f} %"
    )
    return top


GROUP = ClaimGroup(
    {"C43": c43, "C45": c45, "C46": c46, "C47": c47, "C48": c48},
    figures={
        "ch3_shaker_sweep": ("Fig 3.11 by simulation: sweep of 5 to 300 Hz in 45 s, 5 m/s^2, over the preload", figure)
    },
    studies=(STUDY, "bounds"),
)
