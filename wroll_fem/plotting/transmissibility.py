"""Transmissibility curves: one run with its half-power reading, or several runs together."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes

from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.results.dataset import label
from wroll_fem.signals.damping import HalfPower, half_power
from wroll_fem.typing import FloatArray

_PARTS = ("frequency", "transmissibility_real", "transmissibility_imag")


def magnitude(dataset: xr.Dataset, stem: str = "transmissibility") -> FloatArray:
    """|T| of a curve, (n_frequency,)."""
    return np.hypot(dataset[f"{stem}_real"].values, dataset[f"{stem}_imag"].values)


def reading(dataset: xr.Dataset) -> HalfPower:
    """Half-power reading of the demodulated curve."""
    style.require(dataset, _PARTS, "transmissibility curve")
    return half_power(dataset["frequency"].values, magnitude(dataset))


def _box(read: HalfPower, dataset: xr.Dataset) -> str:
    lines = [f"$f_n$ = {read.f_n:.2f} Hz", f"$T_{{pk}}$ = {read.peak:.2f}"]
    if read.complete:
        lines += [rf"$\zeta$ = {100 * read.zeta:.2f} % (half power)", f"skewness = {read.skewness:+.2f}"]
    else:
        lines += [r"$\zeta$: not readable"]
    method, zeta = str(dataset.attrs.get("zeta_method", "")).split(",")[0], dataset.attrs.get("zeta")
    if method not in ("", "half power") and zeta is not None and np.isfinite(zeta):  # what the summary holds
        lines.append(rf"$\zeta$ = {100 * zeta:.2f} % ({method})")
    return "\n".join(lines)


def plot_transmissibility(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot |T| over frequency with peak, half-power points and what they read.

    Parameters
    ----------
    dataset
        Has `transmissibility_real/_imag` over `frequency`; `transmissibility_spectrum_real/_imag` is drawn if there.
    ax
        Axes to draw in; a new figure without.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        When the Dataset holds no transmissibility.
    """
    read = reading(dataset)
    ax = style.axes(ax)
    frequency, size = dataset["frequency"].values, magnitude(dataset)
    top = float(size.max())
    if "transmissibility_spectrum_real" in dataset:
        spectrum = magnitude(dataset, "transmissibility_spectrum")
        top = max(top, min(float(np.nanmax(spectrum)), 1.6 * top))
        ax.plot(frequency, spectrum, color=style.GREY, lw=1.0, ls=":", label="spectrum ratio (FFT)")
    ax.plot(frequency, size, color=style.BLUE, lw=1.8, label="demodulated envelope")
    ax.plot(read.f_n, read.peak, "o", color=style.RED, ms=5, zorder=5)
    ax.axvline(read.f_n, color=style.RED, lw=0.8, ls="--", zorder=1)
    level = read.peak / np.sqrt(2.0)
    ends = [f for f in (read.f_low, read.f_high) if np.isfinite(f)]
    if ends:
        ax.plot(ends, [level] * len(ends), "s-", color=style.RED, ms=4, lw=0.9, zorder=5, label="half power")
    right = read.f_n < 0.5 * (frequency[0] + frequency[-1])
    side, x = ("right", 0.985) if right else ("left", 0.015)
    frame = {"fc": "white", "ec": "#BBBBBB", "boxstyle": "round,pad=0.4"}
    ax.text(
        x,
        0.97,
        _box(read, dataset),
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
    ax.set_ylabel("Transmissibility |T|, tip over base (–)")
    ax.legend(loc=f"center {side}", fontsize=8, framealpha=0.9)
    if read.complete:
        lean = "leaning right" if read.skewness > 0.1 else "leaning left" if read.skewness < -0.1 else "symmetric"
        found = f"half power reads {100 * read.zeta:.2f} % damping, the peak is {lean}"
    else:
        found = f"damping cannot be read: {read.reason}"
    style.title(ax, f"Tip moves {read.peak:.1f} times the base at {read.f_n:.1f} Hz; {found}")
    return ax


def plot_comparison(runs: Mapping[str, xr.Dataset], ax: Axes | None = None) -> Axes:
    """Plot the transmissibility curves of several runs, each with its peak marked.

    Parameters
    ----------
    runs
        Label -> Dataset with `transmissibility_real/_imag`, in the order of a parameter (its colours
        run from dark to light) or up to three unordered runs.
    ax
        Axes to draw in; a new figure without.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        For no runs, or one without transmissibility.
    """
    if not runs:
        raise InputError("no runs to compare", remedy="pass at least one labelled Dataset")
    ax = style.axes(ax, 4.6)
    count = len(runs)
    shades = colormaps["viridis"](np.linspace(0.0, 0.88, count)) if count > 3 else np.array(style.LINES)[:count]
    reads: dict[str, HalfPower] = {}
    for (name, dataset), colour, dash in zip(
        runs.items(), shades, ("-", "--", "-.", (0, (5, 1))) * count, strict=False
    ):
        read = reads[name] = reading(dataset)
        damping = rf"$\zeta$ = {100 * read.zeta:.1f} %" if read.complete else r"$\zeta$ not readable"
        text = f"{name}: {read.f_n:.1f} Hz, {damping}"
        ax.plot(dataset["frequency"].values, magnitude(dataset), color=colour, lw=1.6, ls=dash, label=text)
        ax.plot(read.f_n, read.peak, "o", color=colour, ms=4.5, mec="black", mew=0.5)
    ax.set_ylim(bottom=0.0)
    ax.margins(x=0.0)
    ax.set_xlabel(label("frequency"))
    ax.set_ylabel("Transmissibility |T|, tip over base (–)")
    ax.legend(fontsize=8, framealpha=0.9)
    low, high = min(reads, key=lambda n: reads[n].f_n), max(reads, key=lambda n: reads[n].f_n)
    text = f"Resonance at {reads[low].f_n:.1f} Hz ({low})"
    if low != high:
        text += f" to {reads[high].f_n:.1f} Hz ({high})"
    tall = max(reads, key=lambda n: reads[n].peak)
    style.title(ax, f"{text}; largest amplification {reads[tall].peak:.1f} ({tall})")
    return ax
