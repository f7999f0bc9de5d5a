"""Claims on the rolls at realistic scale that rub on their mandrels, baseline: C96 to C102.

Judged on steady curves (harmonic balance) with the base of the coil free. The thesis's chirp of 20 s and the coil whose
inner edge is clamped stand beside them. The verdicts name the preloads without a curve.
"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.flight_curves import (
    BASELINE,
    CHIRPS,
    INNER_EDGE,
    NAMES,
    Point,
    Series,
    Swept,
    baseline,
    best,
    chirps,
    inside,
    missing,
    panels,
    points,
    table_of,
)
from reproduction.verdict import Verdict
from reproduction.words import monotone, numbers
from wroll_fem.plotting import style
from wroll_fem.plotting.study import PRESSURE, StudyCase
from wroll_fem.signals.transmissibility import magnitude


def pressures(found: dict[str, Series]) -> str:
    """The preloads of every structure, as text."""
    return f"external pressure in kPa {table_of(found, lambda p: 1e-3 * p.pressure, 'g')}"


def c96(evidence: Evidence) -> Verdict:
    found = baseline(evidence)
    parts, holds = [], True
    for name, series in found.items():
        low = series[0]
        damped = best(series) is not low
        high = low.peak >= max(p.peak for p in series)
        soft = low.f_n <= min(p.f_n for p in series)
        holds = holds and low.pressure == 1e4 and damped and high and soft
        parts.append(
            f"{name} at {1e-3 * low.pressure:g} kPa: largest zeta {'no' if damped else 'yes'}, largest peak "
            f"{'yes' if high else 'no'} ({low.peak:.1f} of {max(p.peak for p in series):.1f}), lowest f_n "
            f"{'yes' if soft else 'no'}"
        )
    return Verdict(f"lowest preload with a curve: {'; '.join(parts)}{missing(evidence)}; {attained(evidence)}", holds)


def c97(evidence: Evidence) -> Verdict:
    found = baseline(evidence)
    zeta = [p.zeta for p in found["SSPP"]]
    last = abs(zeta[-1] - zeta[-2]) / float(np.ptp(zeta))
    holds = inside(found["iROSA"]) and inside(found["HabEx"]) and not inside(found["SSPP"]) and last < 0.2
    value = (
        f"{pressures(found)}; zeta in % {table_of(found, lambda p: 100 * p.zeta, '.2f')}; last step of SSPP "
        f"{100 * last:.0f} % of its range{missing(evidence)}; inner edge clamped: "
        f"{table_of(edged(evidence), lambda p: 100 * p.zeta, '.2f')}"
    )
    return Verdict(value, holds)


def spread(series: Series) -> float:
    """Range of the resonance over its lowest value."""
    f = [p.f_n for p in series]
    return max(f) / min(f) - 1.0


def c98(evidence: Evidence) -> Verdict:
    """Judged at preloads at which all three have a curve: the missing curves have the lowest frequencies."""
    found = baseline(evidence)
    shared = set.intersection(*({p.pressure for p in series} for series in found.values()))
    same = {name: [p for p in series if p.pressure in shared] for name, series in found.items()}
    narrow = {name: spread(series) for name, series in same.items()}
    others = min(narrow["iROSA"], narrow["HabEx"])
    value = (
        f"range of f_n over its lowest value at the shared preloads ({numbers(sorted(1e-3 * p for p in shared), 'g')} "
        f"kPa): {'; '.join(f'{name} {100 * v:.1f} %' for name, v in narrow.items())}; over all curves: "
        f"{'; '.join(f'{name} {100 * spread(series):.1f} %' for name, series in found.items())}{missing(evidence)}"
    )
    return Verdict(value, others >= 2.0 * narrow["SSPP"])


def c99(evidence: Evidence) -> Verdict:
    parts, holds = [], True
    for name, series in baseline(evidence).items():
        if name == "SSPP":
            continue
        above = [p for p in series if p.pressure >= best(series).pressure]
        f, zeta = [p.f_n for p in above], [p.zeta for p in above]
        holds = holds and len(above) > 2 and monotone(f, 1) and monotone(zeta, -1)
        said = f"f_n {numbers(f, '.1f')} Hz, zeta {numbers((100 * z for z in zeta), '.2f')} %"
        parts.append(f"{name} from {1e-3 * above[0].pressure:g} kPa: {said}")
    return Verdict("; ".join(parts), holds)


def c100(evidence: Evidence) -> Verdict:
    found = chirps(evidence)
    top = max(p.work for line in found.values() for p in line)
    said = "; ".join(f"{name} {numbers((p.work for p in line), '.3g')}" for name, line in found.items())
    steady = max(p.sweep_work for line in baseline(evidence).values() for p in line)
    value = (
        f"friction work of the chirp at 10 to 2000 kPa, J: {said}; the steady curves, passed at the rate of the chirp, "
        f"give at most {steady:.3g} J{missing(evidence, CHIRPS)}"
    )
    return Verdict(value, top < 1000.0)


def c101(evidence: Evidence) -> Verdict:
    found = baseline(evidence)
    least = {name: min(series, key=lambda p: p.zeta) for name, series in found.items()}
    said = "; ".join(f"{name} {100 * p.zeta:.2f} % at {1e-3 * p.pressure:g} kPa" for name, p in least.items())
    return Verdict(
        f"half power of the steady curves, baseline: {said}{missing(evidence)}",
        min(p.zeta for p in least.values()) >= 0.008,
    )


def correlation(x: list[float], y: list[float]) -> float:
    """Correlation of two lists."""
    return float(np.corrcoef(x, y)[0, 1])


def with_chirps(evidence: Evidence) -> dict[str, list[tuple[Point, Swept]]]:
    """Structure -> steady curve and chirp of every preload that has both."""
    swept = {name: {p.pressure: p for p in line} for name, line in chirps(evidence).items()}
    return {
        name: [(p, swept[name][p.pressure]) for p in series if p.pressure in swept[name]]
        for name, series in baseline(evidence).items()
    }


def c102(evidence: Evidence) -> Verdict:
    parts, holds = [], True
    for name, pairs in with_chirps(evidence).items():
        zeta = [p.zeta for p, _ in pairs]
        raw, norm = correlation([c.work for _, c in pairs], zeta), correlation([c.norm for _, c in pairs], zeta)
        per_cycle = correlation([p.cycle_work / p.tip**2 / p.f_n for p, _ in pairs], zeta)
        holds = holds and norm > 0.8 and norm > raw
        parts.append(
            f"{name} r = {norm:.2f} normalised ({per_cycle:.2f} with the work of a steady cycle at the peak), "
            f"{raw:.2f} raw"
        )
    return Verdict(f"work of the chirp against zeta of the steady curve: {'; '.join(parts)}{missing(evidence)}", holds)


def edged(evidence: Evidence) -> dict[str, Series]:
    """Structure -> points with the inner edge of the coil clamped; empty for structures without a curve."""
    members = evidence.finished(INNER_EDGE)[0]
    return {name: points([m for m in members if m.values["case"] == case]) for case, name in NAMES.items()}


def attained(evidence: Evidence) -> str:
    """Peaks of the chirp relative to those of the steady curves, as text."""
    parts = [
        f"{name} {numbers((100.0 * c.peak / p.peak for p, c in pairs), '.0f')}"
        for name, pairs in with_chirps(evidence).items()
    ]
    return f"peak of the chirp in % of the steady one: {'; '.join(parts)}"


# ---- figures -------------------------------------------------------------------------------------


def _drawn_over_preload(members: list[StudyCase], title: str) -> Axes:
    """One panel per structure, one curve per preload."""
    axes = panels()
    loads = sorted({float(m.values[PRESSURE]) for m in members})
    shades = dict(zip(loads, plt.get_cmap("viridis")(np.linspace(0.0, 0.9, len(loads))), strict=True))
    for ax, (case, name) in zip(axes, NAMES.items(), strict=True):
        for m in sorted((m for m in members if m.values["case"] == case), key=lambda m: float(m.values[PRESSURE])):
            pressure = float(m.values[PRESSURE])
            label = f"{1e-3 * pressure:g} kPa"
            ax.plot(m.data["frequency"], magnitude(m.data), color=shades[pressure], lw=1.4, label=label)
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter("{x:g}")
        ax.set_ylabel("Transmissibility |T| (–)")
        ax.legend(fontsize=7.5, title=name, title_fontsize=8)
    axes[-1].set_xlabel("Frequency (Hz)")
    style.title(axes[0], title)
    return axes[0]


def plot_curves(evidence: Evidence) -> Axes:
    """Draw Fig. 6.2: one panel per structure, one curve per preload."""
    lowest = {name: min(line, key=lambda p: p.peak) for name, line in baseline(evidence).items()}
    said = ", ".join(f"{name} {1e-3 * point.pressure:g} kPa" for name, point in lowest.items())
    title = f"Steady response at 0.5 g, base of the coil free. Preload with the lowest peak: {said}"
    return _drawn_over_preload(evidence.finished(BASELINE)[0], title)


def plot_inner_edge(evidence: Evidence) -> Axes:
    """Draw Fig. 6.2 for the coil whose inner edge is clamped at the base."""
    title = "Steady response at 0.5 g, inner edge of the coil clamped at the base (as wide as the wall)"
    return _drawn_over_preload(evidence.finished(INNER_EDGE)[0], title)


def plot_chirps(evidence: Evidence) -> Axes:
    """Draw Fig. 6.2 by the chirp of the thesis: demodulated envelopes."""
    title = "Chirp from 5 to 160 Hz in 20 s at 0.5 g: sharp peaks stay below the steady ones, and ring"
    return _drawn_over_preload(evidence.finished(CHIRPS)[0], title)


def plot_damping(evidence: Evidence) -> Axes:
    """Draw Fig. 6.3: damping over resonance, free base beside the clamped inner edge."""
    _, axes = plt.subplots(1, 2, figsize=(style.WIDTH, 3.8), dpi=style.DPI, layout="constrained", sharey=True)
    edge = {name: line for name, line in edged(evidence).items() if line}
    for ax, found, words in zip(axes, (baseline(evidence), edge), ("base free", "inner edge clamped"), strict=True):
        style.axes(ax)
        for name, colour in zip(NAMES.values(), style.LINES, strict=False):
            line = found.get(name, [])
            zeta = [100 * p.zeta for p in line]
            ax.plot([p.f_n for p in line], zeta, "o-", color=colour, label=name)
            for p, z in zip(line, zeta, strict=True):
                ax.annotate(f"{1e-3 * p.pressure:g}", (p.f_n, z), (4, 4), textcoords="offset points", fontsize=6.5)
        ax.set_xlabel("Resonance $f_n$ (Hz)")
        style.title(ax, f"{words}; numbers: external pressure in kPa", 44)
    axes[0].set_ylabel("Damping ratio ζ, half power (%)")
    axes[0].set_ylim(bottom=0.0)
    axes[0].legend(fontsize=8)
    return axes[0]


def plot_energy(evidence: Evidence) -> Axes:
    """Draw Figs. 6.4 and 6.5: damping over friction work, and over the normalised friction work."""
    _, (left, right) = plt.subplots(1, 2, figsize=(style.WIDTH, 3.6), dpi=style.DPI, layout="constrained", sharey=True)
    for (name, pairs), colour in zip(with_chirps(evidence).items(), style.LINES, strict=False):
        zeta = [100 * p.zeta for p, _ in pairs]
        left.semilogx([c.work for _, c in pairs], zeta, "o-", color=colour, label=name)
        right.semilogx([c.norm for _, c in pairs], zeta, "o-", color=colour)
    for ax, words in ((left, "Friction work of the 20 s chirp $E_F$ (J)"), (right, "$E_F/x^2/f_n$ (J s/m²)")):
        style.axes(ax)
        ax.set_xlabel(words)
    left.set_ylabel("Damping ratio ζ, half power (%)")
    left.legend(fontsize=8)
    style.title(left, "Friction work does not order the damping;", 44)
    style.title(right, "normalised by eq. 6.7 it does", 44)
    return left


GROUP = ClaimGroup(
    {"C96": c96, "C97": c97, "C98": c98, "C99": c99, "C100": c100, "C101": c101, "C102": c102},
    figures={
        "ch6_curves": ("Fig 6.2: transmissibility over preload, base of the coil free", plot_curves),
        "ch6_inner_edge": ("Fig 6.2 with the inner edge of the coil's base clamped", plot_inner_edge),
        "ch6_chirps": ("Fig 6.2 by the chirp of 20 s", plot_chirps),
        "ch6_damping": ("Fig 6.3: damping over resonance, one point per preload", plot_damping),
        "ch6_energy": ("Figs 6.4 and 6.5: damping over friction work of the chirp", plot_energy),
    },
    partial_studies=(BASELINE, CHIRPS, INNER_EDGE),
)
