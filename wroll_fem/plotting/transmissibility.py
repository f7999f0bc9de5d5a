"""Transmissibility curves: one run with its damping estimate, or several runs together."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes

from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.results.dataset import label
from wroll_fem.results.resonance import Resonance, resonance
from wroll_fem.signals.tip import rigid_tip
from wroll_fem.signals.transmissibility import magnitude

_BASE = "Transmissibility |T|, tip over base (–)"
_PARTS = ("frequency", "transmissibility_real", "transmissibility_imag")


def _box(read: Resonance) -> str:
    if not np.isfinite(read.f_n):
        return "no resonance in the band"
    lines = [f"$f_n$ = {read.f_n:.2f} Hz", f"$T_{{pk}}$ = {read.peak:.2f}"]
    lines.append(rf"$\zeta$ = {damping_words(read)}" if read.stated else rf"$\zeta$: {damping_words(read)}")
    if np.isfinite(read.skewness):
        lines.append(f"skewness = {read.skewness:+.2f}")
    return "\n".join(lines)


def _line(read: Resonance) -> str:
    """Reading of one branch, in one line."""
    if not np.isfinite(read.f_n):
        return "no resonance in the band"
    return rf"{read.f_n:.2f} Hz, $T_{{pk}}$ = {read.peak:.2f}, $\zeta$ = {damping_words(read)}"


def ratio_label(dataset: xr.Dataset) -> str:
    """Label of the axis of |T|: transmissibility, or accelerance if a force excites the structure."""
    return _BASE if rigid_tip(dataset) else "Accelerance, tip over force factor (1/kg)"


def peak_words(dataset: xr.Dataset, peak: float) -> str:
    """Words about the largest |T|."""
    return f"Peak transmissibility {peak:.1f}" if rigid_tip(dataset) else f"Peak accelerance {peak:.3g} per kg"


def damping_words(read: Resonance) -> str:
    """Damping ratio with its estimator and its quality, or that there is none."""
    if not read.damped:
        return "no estimate"
    if not read.stated:
        return f"not stated (apparent {100 * read.zeta:.2f} %)"
    return f"{100 * read.zeta:.2f} % ({read.method}{', doubtful' if read.quality == 'doubtful' else ''})"


def plot_transmissibility(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the transmissibility |T| versus frequency with its peak, its half-power points and the damping estimate.

    Parameters
    ----------
    dataset
        Has `transmissibility_real/_imag` along `frequency`, and the estimate in its attributes (`results.resonance`);
        `transmissibility_spectrum_real/_imag` is drawn if present.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        When the Dataset holds no transmissibility or no estimate.
    """
    style.require(dataset, _PARTS, "transmissibility curve")
    read = resonance(dataset)
    ax = style.axes(ax)
    frequency, size = dataset["frequency"].values, magnitude(dataset).values
    top = float(size.max())
    if "transmissibility_spectrum_real" in dataset:
        spectrum = magnitude(dataset, "transmissibility_spectrum").values
        top = max(top, min(float(np.nanmax(spectrum)), 1.6 * top))
        ax.plot(frequency, spectrum, color=style.GREY, lw=1.0, ls=":", label="spectrum ratio (FFT)")
    down = resonance(dataset, "down_") if "down_transmissibility_real" in dataset else None
    text = "demodulated envelope" if down is None else f"upward: {_line(read)}"
    ax.plot(frequency, size, color=style.BLUE, lw=1.8, label=text)
    if down is not None:
        back = magnitude(dataset, "down_transmissibility").values
        top = max(top, float(back.max()))
        ax.plot(frequency, back, color=style.ORANGE, lw=1.6, ls="--", label=f"downward: {_line(down)}")
        ax.plot(down.f_n, down.peak, "o", color=style.ORANGE, ms=5, mec="black", mew=0.5, zorder=5)
    resonant = bool(np.isfinite(read.f_n))
    if resonant:
        ax.plot(read.f_n, read.peak, "o", color=style.RED, ms=5, zorder=5)
        ax.axvline(read.f_n, color=style.RED, lw=0.8, ls="--", zorder=1)
    level = read.peak / np.sqrt(2.0)
    ends = [f for f in (read.f_low, read.f_high) if np.isfinite(f)]
    if ends:
        ax.plot(ends, [level] * len(ends), "s-", color=style.RED, ms=4, lw=0.9, zorder=5, label="half power")
    right = read.f_n < 0.5 * (frequency[0] + frequency[-1])
    side, x = ("right", 0.985) if right else ("left", 0.015)
    frame = {"fc": "white", "ec": "#BBBBBB", "boxstyle": "round,pad=0.4"}
    if down is None:
        ax.text(
            x,
            0.97,
            _box(read),
            transform=ax.transAxes,
            va="top",
            ha=side,
            fontsize=9,
            linespacing=1.4,
            bbox=frame,
            zorder=6,
        )
    ax.set_xlim(frequency[0], frequency[-1])
    ax.set_ylim(0.0, 1.12 * top)
    ax.set_xlabel(label("frequency"))
    ax.set_ylabel(ratio_label(dataset))
    ax.legend(loc=f"{'center' if down is None else 'upper'} {side}", fontsize=8, framealpha=0.9)
    found = f"no damping estimate: {read.reason}"
    if read.damped:
        found = f"damping ratio {damping_words(read)}"
        if np.isfinite(read.skewness):
            lean = "leans right" if read.skewness > 0.1 else "leans left" if read.skewness < -0.1 else "is symmetric"
            found += f"; the peak {lean}"
    head = f"{peak_words(dataset, read.peak)} at {read.f_n:.1f} Hz; {found}"
    if down is not None and np.isfinite(down.f_n):
        head = f"Upward: peak {read.peak:.3g} at {read.f_n:.2f} Hz; downward: {down.peak:.3g} at {down.f_n:.2f} Hz"
    style.title(ax, head if resonant else f"No resonance: {read.reason}")
    return ax


def plot_comparison(runs: Mapping[str, xr.Dataset], ax: Axes | None = None) -> Axes:
    """Plot the transmissibility curves of several runs, each with its peak marked.

    Parameters
    ----------
    runs
        Label -> Dataset with `transmissibility_real/_imag`. Up to three runs have distinct colours. The colours of
        more runs go from dark to light, so the runs should be in the order of a parameter.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        If there are no runs, or one of them has no transmissibility.
    """
    if not runs:
        raise InputError("no runs to compare", remedy="pass at least one labelled Dataset")
    ax = style.axes(ax, 4.6)
    count = len(runs)
    shades = colormaps["viridis"](np.linspace(0.0, 0.88, count)) if count > 3 else np.array(style.LINES)[:count]
    reads: dict[str, Resonance] = {}
    for (name, dataset), colour, dash in zip(
        runs.items(), shades, ("-", "--", "-.", (0, (5, 1))) * count, strict=False
    ):
        style.require(dataset, _PARTS, "transmissibility curve")
        read = reads[name] = resonance(dataset)
        damping = rf"$\zeta$ = {100 * read.zeta:.1f} %" if read.stated else r"no $\zeta$"
        text = f"{name}: {read.f_n:.1f} Hz, {damping}" if np.isfinite(read.f_n) else f"{name}: no resonance"
        ax.plot(dataset["frequency"].values, magnitude(dataset).values, color=colour, lw=1.6, ls=dash, label=text)
        ax.plot(read.f_n, read.peak, "o", color=colour, ms=4.5, mec="black", mew=0.5)
    ax.set_ylim(bottom=0.0)
    ax.margins(x=0.0)
    ax.set_xlabel(label("frequency"))
    ax.set_ylabel(_BASE)
    ax.legend(fontsize=8, framealpha=0.9)
    reads = {name: read for name, read in reads.items() if np.isfinite(read.f_n)}
    if not reads:
        style.title(ax, "No resonance in any band")
        return ax
    low, high = min(reads, key=lambda n: reads[n].f_n), max(reads, key=lambda n: reads[n].f_n)
    text = f"Resonance at {reads[low].f_n:.1f} Hz ({low})"
    if low != high:
        text += f" to {reads[high].f_n:.1f} Hz ({high})"
    tall = max(reads, key=lambda n: reads[n].peak)
    style.title(ax, f"{text}; largest peak {reads[tall].peak:.1f} ({tall})")
    return ax
