"""Claims on the rolls at realistic scale that rub on their mandrels: C96 to C102, C105 and C106.

C104 and C107 are not computed yet. Judged on steady curves (harmonic balance) with the base of the coil free. Where
harmonic balance does not converge, mostly because the coil opens widely, there is no curve; the verdicts name these
preloads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from scipy.integrate import trapezoid

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.verdict import NOT_YET, Verdict
from reproduction.words import monotone, numbers
from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.study import PRESSURE, StudyCase, read
from wroll_fem.signals.transmissibility import magnitude

NAMES = {"irosa_friction": "iROSA", "sspp_friction": "SSPP", "habex_friction": "HabEx"}
"""Case file -> structure."""
BASELINE = "flight_preload"
FRICTION = {0.125: "flight_friction_half", 0.25: BASELINE, 0.5: "flight_friction_double"}
"""Friction coefficient -> study."""
OCTAVES_PER_SECOND = math.log2(160.0 / 5.0) / 20.0
"""Rate of the thesis's chirp, 5 to 160 Hz in 20 s."""


@dataclass(frozen=True)
class Point:
    """Steady curve of one roll at one preload.

    Attributes
    ----------
    pressure, f_n, peak, zeta
        External pressure (Pa), resonance (Hz), largest transmissibility, damping ratio (half power).
    tip
        Largest amplitude of the tip, m.
    cycle_work
        Energy dissipated by friction in one cycle at the peak, J.
    sweep_work
        Estimate of the energy dissipated by friction in the thesis's chirp of 20 s, J.
    """

    pressure: float
    f_n: float
    peak: float
    zeta: float
    tip: float
    cycle_work: float
    sweep_work: float

    @property
    def norm(self) -> float:
        """Equation 6.7 with the energy of the chirp, J s/m^2."""
        return self.sweep_work / self.tip**2 / self.f_n


Series = list[Point]


def point(member: StudyCase) -> Point:
    """Readings of a steady curve.

    A chirp of R octaves per second spends df/(R ln 2) cycles in the band df. Its friction work is therefore about the
    integral of the work per cycle over the frequency, divided by R ln 2, if it passes through steady states.
    """
    data, found = member.data, read(member)
    frequency, work = data["frequency"].values, data["friction_work_per_cycle"].values
    order = np.argsort(frequency, kind="stable")
    total = float(trapezoid(work[order], frequency[order])) / (OCTAVES_PER_SECOND * math.log(2.0))
    top = int(np.argmax(magnitude(data).values))
    tip = float(data["tip_amplitude"].values.max())
    return Point(float(member.values[PRESSURE]), found.f_n, found.peak, found.zeta, tip, float(work[top]), total)


def baseline(evidence: Evidence) -> dict[str, Series]:
    """Structure -> points in order of increasing preload.

    Raises
    ------
    InputError
        If a structure has fewer than three curves.
    """
    return _grouped(evidence.finished(BASELINE)[0])


def over_friction(evidence: Evidence) -> dict[str, dict[float, Series]]:
    """Structure -> friction coefficient -> points in order of increasing preload."""
    found: dict[str, dict[float, Series]] = {name: {} for name in NAMES.values()}
    for mu, study in FRICTION.items():
        for name, series in _grouped(evidence.finished(study)[0]).items():
            found[name][mu] = series
    return found


def _grouped(members: Sequence[StudyCase]) -> dict[str, Series]:
    found = {}
    for case, name in NAMES.items():
        points = [point(m) for m in members if m.values["case"] == case]
        found[name] = sorted((p for p in points if math.isfinite(p.zeta)), key=lambda p: p.pressure)
        if len(found[name]) < 3:
            raise InputError(f"{name} has fewer than three curves", remedy="see the run folders of the study")
    return found


def missing(evidence: Evidence, study: str = BASELINE) -> str:
    """The cases that have no curve, as text; empty if all have one."""
    failed = evidence.finished(study)[1]
    parts = []
    for case, name in NAMES.items():
        own = sorted(float(m.values[PRESSURE]) for m in failed if m.values["case"] == case)
        if own:
            parts.append(f"{name} {numbers((1e-3 * p for p in own), 'g')} kPa")
    return f"; no curve (harmonic balance does not converge): {', '.join(parts)}" if parts else ""


def missing_over_friction(evidence: Evidence) -> str:
    """The cases of all friction coefficients that have no curve, as text."""
    said = [(mu, missing(evidence, study)) for mu, study in FRICTION.items()]
    return "".join(f"{text} at mu = {mu:g}" for mu, text in said if text)


def best(series: Series) -> Point:
    """Point of the largest damping."""
    return max(series, key=lambda p: p.zeta)


def inside(series: Series) -> bool:
    """Whether the largest damping is at neither end of the series."""
    return series[0].zeta < best(series).zeta > series[-1].zeta


def table_of(found: dict[str, Series], value: Callable[[Point], float], form: str) -> str:
    """One value of every point, as text."""
    return "; ".join(f"{name} {numbers(map(value, series), form)}" for name, series in found.items())


def pressures(found: dict[str, Series]) -> str:
    """The preloads of every structure, as text."""
    return f"external pressure in kPa {table_of(found, lambda p: 1e-3 * p.pressure, 'g')}"


# ---- baseline ------------------------------------------------------------------------------------


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
    return Verdict(f"lowest preload with a curve: {'; '.join(parts)}{missing(evidence)}", holds)


def c97(evidence: Evidence) -> Verdict:
    found = baseline(evidence)
    zeta = [p.zeta for p in found["SSPP"]]
    last = abs(zeta[-1] - zeta[-2]) / float(np.ptp(zeta))
    holds = inside(found["iROSA"]) and inside(found["HabEx"]) and not inside(found["SSPP"]) and last < 0.2
    value = (
        f"{pressures(found)}; zeta in % {table_of(found, lambda p: 100 * p.zeta, '.2f')}; last step of SSPP "
        f"{100 * last:.0f} % of its range{missing(evidence)}"
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
    found = baseline(evidence)
    top = max(p.sweep_work for series in found.values() for p in series)
    value = (
        f"at most {top:.3g} J; {table_of(found, lambda p: p.sweep_work, '.3g')} J (estimate: steady states in the band "
        f"of the curves, passed by a chirp of 20 s){missing(evidence)}"
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


def correlation(series: Series, value: Callable[[Point], float]) -> float:
    """Correlation of a value with the damping ratio."""
    return float(np.corrcoef([value(p) for p in series], [p.zeta for p in series])[0, 1])


def c102(evidence: Evidence) -> Verdict:
    parts, holds = [], True
    for name, series in baseline(evidence).items():
        raw, norm = correlation(series, lambda p: p.sweep_work), correlation(series, lambda p: p.norm)
        per_cycle = correlation(series, lambda p: p.cycle_work / p.tip**2 / p.f_n)
        holds = holds and norm > 0.8 and norm > raw
        parts.append(f"{name} r = {norm:.2f} normalised ({per_cycle:.2f} from a cycle at the peak), {raw:.2f} raw")
    return Verdict(f"{'; '.join(parts)}{missing(evidence)}", holds)


# ---- friction ------------------------------------------------------------------------------------


def at_capacity(lines: dict[float, Series]) -> dict[float, list[float]]:
    """Product of friction coefficient and external pressure (Pa) -> damping ratios, for products met twice or more."""
    found: dict[float, list[float]] = {}
    for mu, series in lines.items():
        for p in series:
            found.setdefault(round(mu * p.pressure, 3), []).append(p.zeta)
    return {key: values for key, values in sorted(found.items()) if len(values) > 1}


def offset(lines: dict[float, Series]) -> float:
    """Mean over the products of the range of the damping ratio over its mean."""
    return float(np.mean([np.ptp(values) / np.mean(values) for values in at_capacity(lines).values()]))


def c105(evidence: Evidence) -> Verdict:
    found = over_friction(evidence)
    off = {name: offset(lines) for name, lines in found.items()}
    worst = {name: max(np.ptp(v) / np.mean(v) for v in at_capacity(lines).values()) for name, lines in found.items()}
    said = "; ".join(f"{name} {100 * off[name]:.1f} % (largest {100 * worst[name]:.1f} %)" for name in found)
    return Verdict(
        f"spread of zeta at equal mu sigma_r, mean over the products: {said}{missing_over_friction(evidence)}",
        off["iROSA"] < 0.1 and min(off["SSPP"], off["HabEx"]) > off["iROSA"],
    )


def c106(evidence: Evidence) -> Verdict:
    parts, holds = [], True
    for name, lines in over_friction(evidence).items():
        tops = {mu: best(series) for mu, series in lines.items()}
        zeta = [p.zeta for p in tops.values()]
        apart = max(zeta) / min(zeta) - 1.0
        if name == "SSPP":
            last = max(p.pressure for p in lines[0.5])
            holds = holds and tops[0.5].zeta > tops[0.25].zeta and tops[0.5].pressure == last
        else:
            holds = holds and apart < 0.15
        at = numbers((1e-3 * p.pressure for p in tops.values()), "g")
        parts.append(f"{name} {numbers((100 * z for z in zeta), '.2f')} % at {at} kPa ({100 * apart:.0f} % apart)")
    return Verdict(f"largest zeta for mu 0.125, 0.25, 0.5: {'; '.join(parts)}{missing_over_friction(evidence)}", holds)


def not_yet(missing_study: str) -> Callable[[Evidence], Verdict]:
    """Judge of a claim whose study has not been computed."""
    return lambda _: Verdict(f"not computed: {missing_study}", False, NOT_YET)


# ---- figures -------------------------------------------------------------------------------------


def _panels(height: float = 3.0) -> list[Axes]:
    _, panels = plt.subplots(3, 1, figsize=(style.WIDTH, 3 * height), dpi=style.DPI, layout="constrained")
    return [style.axes(ax) for ax in panels]


def plot_curves(evidence: Evidence) -> Axes:
    """Draw Fig. 6.2: one panel per structure, one curve per preload."""
    panels = _panels()
    members = evidence.finished(BASELINE)[0]
    loads = sorted({float(m.values[PRESSURE]) for m in members})
    shades = dict(zip(loads, plt.get_cmap("viridis")(np.linspace(0.0, 0.9, len(loads))), strict=True))
    for ax, (case, name) in zip(panels, NAMES.items(), strict=True):
        for m in (m for m in members if m.values["case"] == case):
            pressure = float(m.values[PRESSURE])
            label = f"{1e-3 * pressure:g} kPa"
            ax.plot(m.data["frequency"], magnitude(m.data), color=shades[pressure], lw=1.4, label=label)
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter("{x:g}")
        ax.set_ylabel("Transmissibility |T| (–)")
        ax.legend(fontsize=7.5, title=name, title_fontsize=8)
    panels[-1].set_xlabel("Frequency (Hz)")
    style.title(panels[0], "Steady response at 0.5 g: the peak is lowest at 100 to 200 kPa; 10 kPa has no curve")
    return panels[0]


def plot_damping(evidence: Evidence) -> Axes:
    """Draw Fig. 6.3: damping over resonance, one curve per structure."""
    ax = style.axes(None)
    for (name, series), colour in zip(baseline(evidence).items(), style.LINES, strict=False):
        zeta = [100 * p.zeta for p in series]
        ax.plot([p.f_n for p in series], zeta, "o-", color=colour, label=name)
        for p, z in zip(series, zeta, strict=True):
            ax.annotate(f"{1e-3 * p.pressure:g}", (p.f_n, z), (4, 4), textcoords="offset points", fontsize=7)
    ax.set_xlabel("Resonance $f_n$ (Hz)")
    ax.set_ylabel("Damping ratio ζ, half power (%)")
    ax.set_ylim(bottom=0.0)
    ax.legend(fontsize=8)
    style.title(ax, "All three rolls have a preload of largest damping (numbers: external pressure in kPa)")
    return ax


def plot_energy(evidence: Evidence) -> Axes:
    """Draw Figs. 6.4 and 6.5: damping over friction work, and over the normalised friction work."""
    _, (left, right) = plt.subplots(1, 2, figsize=(style.WIDTH, 3.6), dpi=style.DPI, layout="constrained", sharey=True)
    for (name, series), colour in zip(baseline(evidence).items(), style.LINES, strict=False):
        zeta = [100 * p.zeta for p in series]
        left.semilogx([p.sweep_work for p in series], zeta, "o-", color=colour, label=name)
        right.semilogx([p.norm for p in series], zeta, "o-", color=colour)
    for ax, words in ((left, "Friction work of a 20 s chirp $E_F$ (J)"), (right, "$E_F/x^2/f_n$ (J s/m²)")):
        style.axes(ax)
        ax.set_xlabel(words)
    left.set_ylabel("Damping ratio ζ, half power (%)")
    left.legend(fontsize=8)
    style.title(left, "Friction work does not order the damping;", 44)
    style.title(right, "normalised by eq. 6.7 it does", 44)
    return left


def plot_capacity(evidence: Evidence) -> Axes:
    """Draw Fig. 6.10: damping over mu times the external pressure, one curve per friction coefficient."""
    panels = _panels(2.6)
    for ax, (name, lines) in zip(panels, over_friction(evidence).items(), strict=True):
        for (mu, series), form, colour in zip(lines.items(), ("s", "o-", "^"), style.LINES, strict=False):
            x = [1e-3 * mu * p.pressure for p in series]
            zeta = [100 * p.zeta for p in series]
            ax.semilogx(
                x, zeta, form, color=colour, mfc="none", ms=4 + 12 * (mu != 0.25) * mu**0.5, label=f"µ = {mu:g}"
            )
        ax.set_ylabel("ζ, half power (%)")
        ax.set_ylim(bottom=0.0)
        ax.xaxis.set_major_formatter("{x:g}")
        ax.legend(fontsize=8, title=name, title_fontsize=8)
    panels[-1].set_xlabel("µ times external pressure (kPa)")
    style.title(panels[0], "Damping depends on the friction capacity; SSPP is offset at low capacity")
    return panels[0]


GROUP = ClaimGroup(
    {
        "C96": c96, "C97": c97, "C98": c98, "C99": c99, "C100": c100, "C101": c101, "C102": c102,
        "C105": c105, "C106": c106,
        "C104": not_yet("coils of 1 and 10 GPa (study flight_modulus)"),
        "C107": not_yet("coils of 0.25, 0.5 and 0.75 times the thickness"),
    },
    figures={
        "ch6_curves": ("Fig 6.2: transmissibility over preload, base of the coil free", plot_curves),
        "ch6_damping": ("Fig 6.3: damping over resonance, one point per preload", plot_damping),
        "ch6_energy": ("Figs 6.4 and 6.5: damping over friction work", plot_energy),
        "ch6_capacity": ("Fig 6.10: damping over mu times the preload", plot_capacity),
    },
)  # fmt: skip
