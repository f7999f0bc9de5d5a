"""Claims of chapter 3 on definitions, and on frequencies over preload and level: C33, C34, C37 to C42, C44, C56.

The other shaker tests are judged in `shaker_sweeps`, `shaker_random` and `shaker_shock`, slip in `camera_slip`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from scipy.constants import g as GRAVITY

from reproduction import shaker_random, shaker_sweeps
from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.lab_studies import bound
from reproduction.shaker_sweeps import shades
from reproduction.verdict import Verdict
from reproduction.words import kpa, monotone, numbers
from wroll_fem.plotting import style
from wroll_fem.plotting.study import PRESSURE, StudyCase, natural_frequency, read, values_of
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.estimators import single_dof_transmissibility
from wroll_fem.typing import FloatArray

LEVELS_STUDY, MU, MU_GIVEN = "levels", "contact.friction.mu", 0.25
LEVELS = (0.5, 1.0, 2.0, 5.0)
"""Base accelerations of C39 to C42, m/s^2, 0-peak; the thesis has 5 and prints no others."""


# ---- arithmetic ----------------------------------------------------------------------------------


def c33(evidence: Evidence) -> Verdict:
    rate = math.log2(300 / 5) / 0.75
    return Verdict(f"log2(300/5)/0.75 min = {rate:.3f} oct/min", abs(rate / 7.88 - 1) < 1e-3)


def c34(evidence: Evidence) -> Verdict:
    level = 5.0 / GRAVITY
    return Verdict(f"5/9.80665 = {level:.3f} g", abs(level - 0.51) < 5e-3)


def c37(evidence: Evidence) -> Verdict:
    f = np.linspace(0.9, 1.1, 20001)
    found = half_power(f, np.abs(single_dof_transmissibility(f, 1.0, 0.01)))
    exact = abs((found.f_high - found.f_low) / (2.0 * found.f_n) / found.zeta - 1.0) < 1e-12
    value = f"(f2 - f1)/(2 f_n); the curve of a single degree of freedom with 1 % returns {100 * found.zeta:.4f} %"
    return Verdict(value, exact and abs(found.zeta / 0.01 - 1.0) < 0.01)


def c56(evidence: Evidence) -> Verdict:
    spread = math.sqrt(2.0) * 0.01
    return Verdict(f"sqrt(2) x 0.01 px = {spread:.4f} px, 1.4 um at 0.1 mm/px", abs(spread - 0.014) < 5e-4)


# ---- resonance over preload and level ------------------------------------------------------------


def at_level(data: xr.Dataset, level: float) -> float:
    """Resonance (Hz) of a backbone at a base acceleration (m/s^2): the first motion that needs so much; nan if none."""
    base, f = data["resonant_base_acceleration"].values, data["resonance_frequency"].values
    above = np.flatnonzero(base >= level)
    if not above.size or above[0] == 0:
        return math.nan
    k = int(above[0])
    return float(np.interp(np.log(level), np.log(base[k - 1 : k + 1]), f[k - 1 : k + 1]))


def reached_levels(evidence: Evidence, mu: float) -> dict[float, FloatArray]:
    """Preload (Pa) -> resonances (Hz) at `LEVELS`, from backbones with a friction coefficient.

    A level that a backbone does not reach has the resonance nan.
    """
    own = [m for m in evidence.study(LEVELS_STUDY) if float(m.values[MU]) == mu]
    own.sort(key=lambda m: float(m.values[PRESSURE]))
    return {float(m.values[PRESSURE]): np.array([at_level(m.data, a) for a in LEVELS]) for m in own}


def over_levels(evidence: Evidence, mu: float) -> dict[float, FloatArray]:
    """Preload (Pa) -> resonances (Hz) at `LEVELS`; see `reached_levels`.

    A roll that sticks up to the largest amplitude has no resonance of finite height at a level, and is left out.
    """
    return {p: line for p, line in reached_levels(evidence, mu).items() if np.isfinite(line).all()}


def levels_text(found: Mapping[float, FloatArray]) -> str:
    """Resonances over the preload as text, one series per level."""
    lines = np.array(list(found.values())).T
    said = (f"{numbers(line, '.1f')} Hz at {a:g} m/s^2" for a, line in zip(LEVELS, lines, strict=True))
    return f"{numbers((1e-3 * p for p in found), 'g')} kPa: {'; '.join(said)}"


def mandrel(evidence: Evidence) -> float:
    """Resonance of the mandrel alone, Hz."""
    return natural_frequency(evidence.reference("bounds"))


def c38(evidence: Evidence) -> Verdict:
    value = f"the mandrel alone has no contact and is linear: {mandrel(evidence):.2f} Hz at every level"
    return Verdict(value, True)


def c39(evidence: Evidence) -> Verdict:
    found = over_levels(evidence, 0.25)
    table = np.array(list(found.values()))
    change = np.abs(table[:, 0] - table[:, -1])
    up = all(monotone(column.tolist(), 1) for column in table.T)
    down = all(monotone(row.tolist(), -1) for row in table)
    value = f"{levels_text(found)}; change over the levels {numbers(change, '.1f')} Hz"
    return Verdict(value, up and down and bool(change[-1] < change[0]))


def c40(evidence: Evidence) -> Verdict:
    found, f_m = over_levels(evidence, 0.25), mandrel(evidence)
    alone, wound, *_ = shaker_random.readings(evidence)
    pressure, f = min(found.items())
    value = (
        f"{1e-3 * pressure:g} kPa: {f[0]:.1f} Hz at {LEVELS[0]:g} m/s^2, {f[-1]:.1f} Hz at {LEVELS[-1]:g} m/s^2; "
        f"mandrel alone {f_m:.1f} Hz; the loosest winding of the experiment, random motion: "
        f"{shaker_random.said(wound)}, mandrel alone {alone.f_n[0]:.1f} Hz"
    )
    return Verdict(value, bool(f[0] > f_m > f[-1]))


def c41(evidence: Evidence) -> Verdict:
    given, doubled = over_levels(evidence, 0.25), over_levels(evidence, 0.5)
    pressures = [p for p in given if p in doubled]
    low, high = (np.array([found[p][-1] for p in pressures]) for found in (given, doubled))
    third = pressures[-1] ** (2 / 3) * pressures[0] ** (1 / 3)
    top = float(np.interp(np.log(third), np.log(pressures), high))
    last = abs(float(high[-1]) / top - 1.0)
    value = (
        f"{numbers((1e-3 * p for p in pressures), 'g')} kPa, 5 m/s^2: mu 0.25 {numbers(low, '.1f')} Hz, mu 0.5 "
        f"{numbers(high, '.1f')} Hz; range {np.ptp(low):.1f} and {np.ptp(high):.1f} Hz; change over the top third "
        f"(logarithmic) {100 * last:.1f} %"
    )
    return Verdict(value, bool(np.all(high >= low) and np.ptp(high) < np.ptp(low) and last < 0.01))


def c42(evidence: Evidence) -> Verdict:
    f_b = bound(evidence, "bonded", "free")
    highest = max(float(np.nanmax(line)) for line in over_levels(evidence, 0.25).values())
    swept = max(r.f_n for r in shaker_sweeps.readings(evidence))
    value = (
        f"largest f_n {highest:.1f} Hz (backbones, {LEVELS[0]:g} to {LEVELS[-1]:g} m/s^2) and {swept:.1f} Hz "
        f"(sweeps of 7.9 oct/min), f_b = {f_b:.1f} Hz"
    )
    return Verdict(value, max(highest, swept) <= 1.005 * f_b)


def c44(evidence: Evidence) -> Verdict:
    low = sorted((m for m in evidence.study("preload_low")), key=lambda m: float(m.values[PRESSURE]))[:2]
    (p, before), (top, after) = list(reached_levels(evidence, 0.25).items())[-2:]
    both = max(np.flatnonzero(np.isfinite(before) & np.isfinite(after)), default=0)  # the largest level of both
    changes = read(low[1]).f_n / read(low[0]).f_n - 1.0, float(after[both] / before[both]) - 1.0
    value = (
        f"{kpa(low[0])} to {kpa(low[1])}: {100 * changes[0]:+.2f} % (sweeps, 5 m/s^2); {1e-3 * p:g} to {1e-3 * top:g} "
        f"kPa: {100 * changes[1]:+.2f} % (backbones, {LEVELS[both]:g} m/s^2, the largest level that both reach)"
    )
    return Verdict(value, max(map(abs, changes)) < 0.02)


# ---- figure --------------------------------------------------------------------------------------


def levels_figure(evidence: Evidence) -> Axes:
    """Draw Fig. 3.10: resonance over the tip acceleration; backbones above, random motion below."""
    _, rows = plt.subplots(2, 1, figsize=(style.WIDTH, 7.6), dpi=style.DPI, layout="constrained", height_ratios=[3, 2])
    top, low = (style.axes(ax) for ax in rows)
    members = sorted(evidence.study(LEVELS_STUDY), key=lambda m: (float(m.values[PRESSURE]), float(m.values[MU])))
    colours = dict(zip(values_of(members, PRESSURE), shades(len(values_of(members, PRESSURE))), strict=True))
    for m in members:
        f, tip = m.data["resonance_frequency"].values, m.data["tip_amplitude"].values
        given = float(m.values[MU]) == MU_GIVEN
        text = f"{1e-3 * float(m.values[PRESSURE]):g} kPa" if given else None
        colour = colours[m.values[PRESSURE]]
        top.semilogx((2.0 * np.pi * f) ** 2 * tip, f, color=colour, lw=1.6, ls="-" if given else "--", label=text)
    top.plot([], [], color=style.GREY, ls="--", label="µ doubled (treated film)")
    for series, colour, mark in zip(
        shaker_random.readings(evidence), ("black", style.BLUE, style.RED), "Dos", strict=False
    ):
        low.semilogx(series.tip, series.f_n, color=colour, marker=mark, ms=5, lw=1.3, label=series.name)
    f_m, f_b = mandrel(evidence), bound(evidence, "bonded", "free")
    for ax in (top, low):
        ax.axhline(f_b, color=style.GREEN, lw=1.0, ls=(0, (5, 2)))
        ax.set_ylim(top=f_b + 4.0)
        ax.set_ylabel("Resonance $f_n$ (Hz)")
    top.axhline(f_m, color="black", lw=1.0, ls=(0, (5, 2)))
    ticks = [20.0, 50.0, 100.0, 200.0]
    low.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    low.minorticks_off()
    top.annotate(f"bonded, {f_b:.1f} Hz", (0.01, f_b), (0, 3), xycoords=("axes fraction", "data"), **_SMALL)
    top.annotate(f"mandrel alone, {f_m:.1f} Hz", (0.01, f_m), (0, 3), xycoords=("axes fraction", "data"), **_SMALL)
    top.set_xlabel("Tip acceleration relative to the base at resonance, 0-peak (m/s²)")
    low.set_xlabel("Tip acceleration under random motion, rms (m/s²)")
    top.legend(fontsize=8, framealpha=0.9, title="sine, external pressure", title_fontsize=8)
    low.legend(fontsize=8, framealpha=0.9, title="random, winding tension", title_fontsize=8)
    ends = [lowest.data["resonance_frequency"].values[[0, -1]] for lowest in members if _is_loosest(lowest, members)]
    said = " and ".join(f"from {f[0]:.1f} to {f[1]:.1f} Hz" for f in ends)
    style.title(top, f"Simulation: with the level, $f_n$ of the loosest roll falls {said} with doubled friction")
    return top


def _is_loosest(member: StudyCase, members: Sequence[StudyCase]) -> bool:
    return bool(member.values[PRESSURE] == min(m.values[PRESSURE] for m in members))


_SMALL: dict[str, Any] = {"textcoords": "offset points", "fontsize": 8}

GROUP = ClaimGroup(
    {
        "C33": c33, "C34": c34, "C37": c37, "C38": c38, "C39": c39, "C40": c40, "C41": c41, "C42": c42, "C44": c44,
        "C56": c56,
    },
    figures={
        "ch3_levels": (
            "Fig 3.10 by simulation: resonance over the tip acceleration, film as given and with doubled friction",
            levels_figure,
        ),
    },
    studies=("bounds", "levels", "preload_low", "shaker_sweep", "shaker_random"),
)  # fmt: skip
