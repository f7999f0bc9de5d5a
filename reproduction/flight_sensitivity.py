"""Claims on the rolls at realistic scale over friction, modulus and size of the coil: C104 to C107.

Judged on steady curves (harmonic balance) with the base of the coil free.
"""

from __future__ import annotations

from collections.abc import Callable

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.flight_curves import (
    BASELINE,
    NAMES,
    SENSITIVITY,
    Point,
    Series,
    best,
    inside,
    missing_over,
    over,
    panels,
)
from reproduction.verdict import Verdict
from reproduction.words import monotone, numbers
from wroll_fem.plotting import style


def tops(lines: dict[float, Series]) -> dict[float, Point]:
    """Value of a parameter -> point of the largest damping."""
    return {value: best(series) for value, series in lines.items()}


def said_of(found: dict[float, Point], form: str) -> str:
    """Largest damping with its resonance and preload, as text."""
    return ", ".join(
        f"{value:{form}}: {100 * p.zeta:.2f} % at {p.f_n:.1f} Hz and {1e-3 * p.pressure:g} kPa"
        for value, p in found.items()
    )


def c104(evidence: Evidence) -> Verdict:
    parts, holds = [], True
    for name, lines in over("E", evidence).items():
        top = tops(lines)
        zeta, f_n = [p.zeta for p in top.values()], [p.f_n for p in top.values()]
        holds = holds and monotone(zeta, -1) and max(zeta) < 10.0 * min(zeta) and monotone(f_n, 1)
        if name == "SSPP":
            holds = holds and not any(inside(series) for series in lines.values())
        parts.append(f"{name} {said_of({1e-9 * E: p for E, p in top.items()}, 'g')}")
    return Verdict(f"largest zeta for E in GPa: {'; '.join(parts)}{missing_over('E', evidence)}", holds)


def c107(evidence: Evidence) -> Verdict:
    found = {name: tops(lines) for name, lines in over("s", evidence).items()}
    change = {name: _change(top, lambda p: p.zeta) for name, top in found.items()}
    moved = {name: _change(top, lambda p: p.f_n) for name, top in found.items()}
    lines = over("s", evidence)["SSPP"]
    falling = [found["SSPP"][s].zeta for s in sorted(found["SSPP"])]
    holds = change["iROSA"] < 0.2 and moved["iROSA"] < 0.2
    holds = holds and monotone(falling, -1) and inside(lines[0.25]) and inside(lines[0.5])
    rising = [found["HabEx"][s].f_n for s in sorted(found["HabEx"])]
    holds = holds and monotone(rising, -1) and change["HabEx"] < 0.3
    said = "; ".join(
        f"{name} {said_of(top, 'g')} (zeta {100 * change[name]:.0f} %, f_n {100 * moved[name]:.0f} % apart)"
        for name, top in found.items()
    )
    return Verdict(f"largest zeta for s: {said}{missing_over('s', evidence)}", holds)


def _change(top: dict[float, Point], value: Callable[[Point], float]) -> float:
    """Range of a value over its smallest."""
    found = [value(p) for p in top.values()]
    return max(found) / min(found) - 1.0


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
    found = over("mu", evidence)
    off = {name: offset(lines) for name, lines in found.items()}
    worst = {name: max(np.ptp(v) / np.mean(v) for v in at_capacity(lines).values()) for name, lines in found.items()}
    said = "; ".join(f"{name} {100 * off[name]:.1f} % (largest {100 * worst[name]:.1f} %)" for name in found)
    return Verdict(
        f"spread of zeta at equal mu sigma_r, mean over the products: {said}{missing_over('mu', evidence)}",
        off["iROSA"] < 0.1 and min(off["SSPP"], off["HabEx"]) > off["iROSA"],
    )


def c106(evidence: Evidence) -> Verdict:
    parts, holds = [], True
    for name, lines in over("mu", evidence).items():
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
    return Verdict(f"largest zeta for mu 0.125, 0.25, 0.5: {'; '.join(parts)}{missing_over('mu', evidence)}", holds)


# ---- figures -------------------------------------------------------------------------------------


def _over_frequency(parameter: str, label: Callable[[float], str], title: str, evidence: Evidence) -> Axes:
    """Damping over resonance: one panel per structure, one line per value of a parameter, one point per preload."""
    axes, found = panels(2.6), over(parameter, evidence)
    values = sorted({value for lines in found.values() for value in lines})
    colours = dict(zip(values, style.LINES, strict=False))
    for ax, (name, lines) in zip(axes, found.items(), strict=True):
        for value, series in lines.items():
            x, zeta = [p.f_n for p in series], [100 * p.zeta for p in series]
            ax.plot(x, zeta, "o-", color=colours[value], ms=4, label=label(value))
        ax.set_ylabel("ζ, half power (%)")
        ax.set_ylim(bottom=0.0)
        ax.legend(fontsize=8, title=name, title_fontsize=8)
    axes[-1].set_xlabel("Resonance $f_n$ (Hz)")
    style.title(axes[0], title)
    return axes[0]


def plot_modulus(evidence: Evidence) -> Axes:
    """Draw Fig. 6.7."""
    title = "Damping over resonance for coils of 1, 5 and 10 GPa, one point per preload"
    return _over_frequency("E", lambda E: f"E = {1e-9 * E:g} GPa", title, evidence)


def plot_shear(evidence: Evidence) -> Axes:
    """Draw the effect of soft shear between the wraps, which the isotropic solid of the thesis leaves out."""
    title = "Soft shear between the wraps takes the coil out of the bending: lower resonance, less damping"
    return _over_frequency("G", lambda G: f"G = {1e-6 * G:.4g} MPa", title, evidence)


def plot_size(evidence: Evidence) -> Axes:
    """Draw Fig. 6.8."""
    title = "Damping over resonance for coils of 0.25 to 1 times the thickness, one point per preload"
    return _over_frequency("s", lambda s: f"s = {s:g}", title, evidence)


def plot_friction(evidence: Evidence) -> Axes:
    """Draw Fig. 6.9."""
    title = "Damping over resonance for three friction coefficients, one point per preload"
    return _over_frequency("mu", lambda mu: f"µ = {mu:g}", title, evidence)


def plot_capacity(evidence: Evidence) -> Axes:
    """Draw Fig. 6.10: damping over mu times the external pressure, one curve per friction coefficient."""
    axes = panels(2.6)
    for ax, (name, lines) in zip(axes, over("mu", evidence).items(), strict=True):
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
    axes[-1].set_xlabel("µ times external pressure (kPa)")
    style.title(axes[0], "Damping depends on the friction capacity; SSPP is offset at low capacity")
    return axes[0]


def plot_tops(evidence: Evidence) -> Axes:
    """Draw Fig. 6.11: largest damping and its resonance over the modulus and over the size of the coil."""
    _, axes = plt.subplots(2, 2, figsize=(style.WIDTH, 5.4), dpi=style.DPI, layout="constrained", sharex="col")
    columns = (("E", 1e-9, "Modulus of the coil (GPa)"), ("s", 1.0, "Thickness of the coil, relative (–)"))
    for (parameter, scale, words), column in zip(columns, axes.T, strict=True):
        found = over(parameter, evidence)
        for name, colour in zip(NAMES.values(), style.LINES, strict=False):
            top = tops(found[name])
            x = [scale * value for value in top]
            column[0].plot(x, [100 * p.zeta for p in top.values()], "o-", color=colour, label=name)
            column[1].plot(x, [p.f_n for p in top.values()], "o-", color=colour)
        for ax in column:
            style.axes(ax)
            ax.set_ylim(bottom=0.0)
        column[1].set_xlabel(words)
    axes[0, 0].set_ylabel("Largest ζ (%)")
    axes[1, 0].set_ylabel("Its resonance $f_n$ (Hz)")
    axes[0, 0].legend(fontsize=8)
    style.title(axes[0, 0], "Largest damping over modulus", 44)
    style.title(axes[0, 1], "and over size", 44)
    return axes[0, 0]


GROUP = ClaimGroup(
    {"C104": c104, "C105": c105, "C106": c106, "C107": c107},
    figures={
        "ch6_modulus": ("Fig 6.7: damping over resonance, modulus of the coil", plot_modulus),
        "ch6_shear": ("Damping over resonance, shear modulus between the wraps", plot_shear),
        "ch6_size": ("Fig 6.8: damping over resonance, size of the coil", plot_size),
        "ch6_friction": ("Fig 6.9: damping over resonance, friction coefficient", plot_friction),
        "ch6_capacity": ("Fig 6.10: damping over mu times the preload", plot_capacity),
        "ch6_tops": ("Fig 6.11: largest damping over modulus and size", plot_tops),
    },
    partial_studies=(BASELINE, *(study for _, _, studies in SENSITIVITY.values() for study in studies)),
)
