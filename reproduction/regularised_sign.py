"""Claims on the scale s of the regularised sign function: C114 and C115 (appendix C).

Periodic orbits by shooting (`wroll_fem.two_dof.shooting`) are compared with explicit runs as in the thesis
(`explicit`).
"""

from __future__ import annotations

from itertools import product

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.explicit import run_from_rest
from reproduction.verdict import Verdict
from reproduction.words import numbers, table
from wroll_fem.plotting import style
from wroll_fem.two_dof import PreloadedTwoMasses, TwoMasses, regularised_sign
from wroll_fem.two_dof.shooting import adapted_curve, off_neighbours, orbit_curve
from wroll_fem.typing import FloatArray

SCALES = (1.0, 2.0, 5.0, 10.0)
STUCK = (50.0, 100.0)
"""Capacities of C114, N."""
CAPACITIES = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0)
TOLERANCES = {"loose": (1e-3, 1e-6), "tight": (1e-8, 1e-8)}
"""Name -> rtol (the default of ode45, and a tight one) and atol."""


def pressed(capacity: float, scale: float) -> PreloadedTwoMasses:
    """Parameters of Table 5.2 at a capacity (N) with the scale s."""
    return TwoMasses(smoothing=scale).preloaded(capacity)


def capacities(evidence: Evidence) -> tuple[float, ...]:
    """Capacities of C115, N."""
    return (1.0, 3.0, 10.0, 20.0) if evidence.fast else CAPACITIES


def band(evidence: Evidence) -> FloatArray:
    """Frequencies of C114, rad/s, dense around the natural frequency of the stuck masses."""
    count, fine = (51, 21) if evidence.fast else (251, 401)
    return np.unique(np.concatenate([np.linspace(0.9, 1.15, count), np.linspace(1.07, 1.09, fine)]))


def runs_per_curve(evidence: Evidence) -> int:
    """Number of runs from rest between 0.4 and 2 rad/s."""
    return 21 if evidence.fast else 81


def in_band(evidence: Evidence) -> xr.Dataset:
    """Transmissibility of the orbits over (capacity, scale, omega) of C114."""
    omegas = band(evidence)

    def compute() -> xr.Dataset:
        tasks = [(c, s, omegas) for c, s in product(STUCK, SCALES)]
        values = np.reshape(evidence.map(_orbits, tasks, what="orbits"), (len(STUCK), len(SCALES), omegas.size))
        return xr.Dataset(
            {"transmissibility": (("capacity", "scale", "omega"), values)},
            {"capacity": list(STUCK), "scale": list(SCALES), "omega": omegas},
        )

    return evidence.kept("smoothed_sign_band", compute, capacities=STUCK, scales=SCALES, points=omegas.size)


def curves(evidence: Evidence) -> dict[tuple[float, float], xr.Dataset]:
    """(capacity, scale) -> orbits on an adapted grid (omega) and at the runs (dwell), and runs from rest."""
    wanted, points = list(product(capacities(evidence), SCALES)), runs_per_curve(evidence)
    inputs = [{"capacity": c, "scale": s, "points": points} for c, s in wanted]
    return dict(zip(wanted, evidence.kept_each("smoothed_sign", orbits_and_runs, inputs), strict=True))


def c114(evidence: Evidence) -> Verdict:
    data = in_band(evidence)
    omegas, said, holds = data["omega"].values, [], True
    for capacity in STUCK:
        spread = spread_of(data.sel(capacity=capacity))
        within = 100 * np.mean(np.interp(np.linspace(omegas[0], omegas[-1], 5001), omegas, spread) < 1e-3)
        worst = int(np.argmax(spread))
        said.append(
            f"F_c = {capacity:g}: within 1e-3 on {within:.0f} % of the band, up to {100 * spread[worst]:.1f} % at "
            f"{omegas[worst]:.4f}"
        )
        holds = holds and bool(spread.max() < 1e-3)
    return Verdict("; ".join(said), holds)


def spread_of(data: xr.Dataset) -> FloatArray:
    """Largest difference between the scales, relative to the value at the last scale."""
    values = data["transmissibility"].values
    return np.asarray(np.ptp(values, axis=0) / values[-1])


def wrong_runs(data: xr.Dataset) -> FloatArray:
    """Relative difference between runs with loose and tight tolerances."""
    return np.abs(data["loose"].values / data["tight"].values - 1.0)


def c115(evidence: Evidence) -> Verdict:
    found = curves(evidence)
    rough = max(off_neighbours(d["omega"].values, d["orbit"].values).max() for d in found.values())
    wrong = {s: np.concatenate([wrong_runs(d) for (_, t), d in found.items() if t == s]) for s in SCALES}
    counts = [int(np.sum(wrong[s] > 0.01)) for s in SCALES]
    value = (
        f"orbits: no point more than {100 * rough:.2f} % off its neighbours, all F_c and s; runs at rtol 1e-3: "
        f"{numbers(counts, 'd')} of {wrong[1.0].size} points off by > 1 % at s = {numbers(SCALES, 'g')}, worst "
        f"{numbers((100 * wrong[s].max() for s in SCALES), '.2g')} %"
    )
    return Verdict(value, bool(rough < 0.01))


def band_table(evidence: Evidence) -> str:
    """C114: difference between the curves of the scales."""
    head = (
        "F_c", "largest spread", "at omega", "part of the band within 1e-3", "largest spread beyond 2 % of the peak",
        *(f"peak at s = {s:g}" for s in SCALES),
    )  # fmt: skip
    data, rows = in_band(evidence), []
    omegas = data["omega"].values
    for capacity in STUCK:
        one = data.sel(capacity=capacity)
        spread, values = spread_of(one), one["transmissibility"].values
        within = np.mean(np.interp(np.linspace(omegas[0], omegas[-1], 5001), omegas, spread) < 1e-3)
        worst, top = int(np.argmax(spread)), omegas[int(np.argmax(values[-1]))]
        far = spread[np.abs(omegas / top - 1.0) > 0.02].max()
        peaks = [f"{v.max():.2f} at {omegas[v.argmax()]:.4f}" for v in values]
        cells = (f"{100 * spread[worst]:.2f} %", f"{omegas[worst]:.4f}", f"{100 * within:.0f} %", f"{far:.1e}")
        rows.append((f"{capacity:g}", *cells, *peaks))
    return table(head, rows)


def spikes_table(evidence: Evidence) -> str:
    """C115: the orbits are smooth; effect of loose tolerances."""
    head = (
        "F_c", "s", "peak", "points", "off its neighbours", "loose against tight", "loose points off by > 1 %",
        "steps of the loose run", "tight 6 tau against orbit", "tight points off by > 1 %",
    )  # fmt: skip
    rows = []
    for (capacity, scale), data in curves(evidence).items():
        grid, orbit = data["omega"].values, data["orbit"].values
        wrong, late = wrong_runs(data), np.abs(data["tight"].values / data["dwell_orbit"].values - 1.0)
        rows.append((
            f"{capacity:g}", f"{scale:g}", f"{orbit.max():.2f} at {grid[orbit.argmax()]:.4f}", f"{len(grid)}",
            f"{100 * off_neighbours(grid, orbit).max():.2f} %", f"{100 * wrong.max():.2g} %", f"{np.sum(wrong > 0.01)}",
            f"{float(data['loose_steps'].mean()):.0f}", f"{100 * late.max():.2g} %", f"{np.sum(late > 0.01)}",
        ))  # fmt: skip
    return table(head, rows)


def plot_sign(evidence: Evidence) -> Axes:
    """Draw Figs. 5.5 and C.1."""
    ax = style.axes(None)
    x = np.linspace(-6.0, 6.0, 1201)
    for scale, colour in zip(SCALES, style.LINES, strict=False):
        ax.plot(x, regularised_sign(scale * x), color=colour, lw=1.6, label=f"S({scale:g} x)")
    ax.plot([-6, 0, 0, 6], [-1, -1, 1, 1], color="black", lw=1.0, ls="--", label="sgn(x)")
    ax.set_xlabel("Relative velocity x (–)")
    ax.set_ylabel("Regularised sign S(s x) (–)")
    ax.legend(fontsize=8)
    style.title(ax, "The regularised sign is viscous with slope s/2 below |x| = 1/s and reaches 0.987 at |x| = 5/s")
    return ax


def plot_responses(evidence: Evidence) -> Axes:
    """Draw Fig. C.2: orbits, and runs from rest with ode45's default tolerance."""
    size = (style.WIDTH, 6.4)
    figure, panels = plt.subplots(2, 2, figsize=size, dpi=style.DPI, layout="constrained", sharex=True, sharey=True)
    found, forces = curves(evidence), capacities(evidence)
    shades = plt.get_cmap("coolwarm")(np.linspace(0.0, 1.0, len(forces)))
    for ax, scale in zip(panels.flat, SCALES, strict=True):
        style.axes(ax)
        wrong = 0
        for capacity, colour in zip(forces, shades, strict=True):
            data = found[capacity, scale]
            ax.semilogy(data["omega"], data["orbit"], color=colour, lw=1.2, label=f"{capacity:g}")
            ax.semilogy(data["dwell"], data["loose"], ".", color=colour, ms=3.5, mec="black", mew=0.25)
            wrong += int(np.sum(wrong_runs(data) > 0.01))
        runs = len(forces) * runs_per_curve(evidence)
        ax.set_title(f"s = {scale:g}: {wrong} of {runs} runs are off by more than 1 %", loc="left", fontsize=9)
    panels[0, 0].set_xlim(0.75, 1.4)
    panels[0, 0].set_ylim(0.8, 600.0)
    panels[0, 1].legend(title="$F_c$", fontsize=7, title_fontsize=8, ncols=2)
    figure.supxlabel(r"Frequency $\omega$ (–)", fontsize=10)
    figure.supylabel("Transmissibility max|x$_1$| / Y$_0$ (–)", fontsize=10)
    text = (
        "Converged orbits (lines) are smooth at every s; the spikes are runs over 6 $\\tau$ with ode45's default\n"
        "tolerance (dots), more of them with preload and with s"
    )
    figure.suptitle(text, x=0.01, ha="left", fontsize=10)
    first: Axes = panels[0, 0]
    return first


def plot_differences(evidence: Evidence) -> Axes:
    """Table of the differences of s = 1, 2, 5 from s = 10 where the masses stick."""
    ax = style.axes(None)
    data = in_band(evidence)
    for capacity, dash in zip(STUCK, ("-", "--"), strict=True):
        values = data["transmissibility"].sel(capacity=capacity).values
        for scale, line, colour in zip(SCALES[:-1], values, style.LINES, strict=False):
            difference = np.maximum(np.abs(line / values[-1] - 1.0), 1e-7)
            text = f"$F_c$ = {capacity:g}, s = {scale:g}"
            ax.semilogy(data["omega"], difference, color=colour, ls=dash, lw=1.3, label=text)
    ax.axhline(1e-3, color="black", lw=0.8)
    ax.set_xlabel(r"Frequency $\omega$ (–)")
    ax.set_ylabel("Difference of the amplitude from s = 10 (–)")
    ax.legend(fontsize=8)
    style.title(
        ax,
        "Away from the resonance of the stuck masses the scale s changes the response by less than 0.1 %, "
        "at its peak by per cents",
    )
    return ax


def _orbits(task: tuple[float, float, FloatArray]) -> FloatArray:
    capacity, scale, omegas = task
    return orbit_curve(pressed(capacity, scale), omegas)


def orbits_and_runs(capacity: float, scale: float, points: int) -> xr.Dataset:
    """Curves at one capacity (N) with one scale, and ``points`` runs from rest with each tolerance."""
    model, at = pressed(capacity, scale), np.linspace(0.4, 2.0, points)
    grid, orbit = adapted_curve(model, np.linspace(0.4, 2.0, 161))
    data = {"orbit": ("omega", orbit), "dwell_orbit": ("dwell", orbit_curve(model, at))}
    for name, (rtol, atol) in TOLERANCES.items():
        runs = [run_from_rest(model, float(omega), rtol=rtol, atol=atol) for omega in at]
        data[name] = "dwell", np.array([run.transmissibility for run in runs])
        data[f"{name}_steps"] = "dwell", np.array([float(run.steps) for run in runs])
    return xr.Dataset(data, {"omega": grid, "dwell": at})


GROUP = ClaimGroup(
    {"C114": c114, "C115": c115},
    figures={
        "appendix_c_sign": ("Figs 5.5 and C.1: the regularised sign", plot_sign),
        "appendix_c_response": ("Fig C.2: orbits, and runs with a loose tolerance", plot_responses),
        "appendix_c_scale": ("What the scale s changes where the masses stick (C114)", plot_differences),
    },
    tables={
        "Spread of the amplitude between s = 1, 2, 5, 10, over that at s = 10; omega 0.9 to 1.15, orbits": band_table,
        "Orbits on adapted grids, 0.4 to 2 rad/s, and runs from rest over 6 tau at rtol 1e-3 (loose) and 1e-8 (tight), "
        "largest abs(x1) of the last 20 periods": spikes_table,
    },
)
