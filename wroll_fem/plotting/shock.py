"""Figure of a shock: history of base and tip, frequency and damping of the decay, shock response spectra."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label
from wroll_fem.signals.tip import absolute_tip


def plot_shock(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot base and tip acceleration, decay frequency and damping versus amplitude, and the spectra of base and tip.

    Parameters
    ----------
    dataset
        Result of the analysis shock.
    ax
        Axes of the spectra alone; None draws all three panels in a new figure.

    Returns
    -------
    Axes
        The axes of the spectra.

    Raises
    ------
    InputError
        If the Dataset holds no spectra of a shock.
    """
    style.require(dataset, ("natural_frequency", "srs_base", "srs_tip"), "figure of a shock")
    if ax is None:
        decays = "decay_amplitude" in dataset
        panels = 3 if decays else 2
        _, axes = plt.subplots(
            panels, 1, figsize=(style.WIDTH, 2.9 * panels + 0.4), dpi=style.DPI, layout="constrained"
        )
        _history(dataset, style.axes(axes[0]))
        if decays:
            _decay(dataset, style.axes(axes[1]))
        ax = axes[-1]
    style.axes(ax)
    f = dataset["natural_frequency"].values
    ax.loglog(f, dataset["srs_tip"].values, "-", color=style.BLUE, lw=1.8, label="tip")
    ax.loglog(f, dataset["srs_base"].values, "--", color=style.RED, lw=1.6, label="base")
    ax.set_xlim(f[0], f[-1])
    _plain(ax)
    ax.set_xlabel("Natural frequency (Hz)")
    ax.set_ylabel("Absolute acceleration\n(m/s², maximax)")
    ax.legend(fontsize=8, framealpha=0.9)
    q = dataset.attrs.get("srs_q")
    words = f", Q = {q:g}" if q is not None else ""
    at = int(np.argmax(dataset["srs_tip"].values))
    style.title(ax, f"Shock response spectra{words}: the tip's is largest at {f[at]:.0f} Hz")
    return ax


def _plain(ax: Axes) -> None:
    """Label the logarithmic horizontal axis with plain numbers at 1, 2 and 5 times the powers of ten."""
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())


def _history(dataset: xr.Dataset, ax: Axes) -> None:
    time, tip = 1e3 * dataset["time"].values, absolute_tip(dataset)
    x, low, high = style.line_envelope(time, tip)
    if low is high:
        ax.plot(x, low, color=style.BLUE, lw=0.9, label="tip, absolute")
    else:
        ax.fill_between(x, low, high, color=style.SKY, lw=0.3, edgecolor=style.BLUE, label="tip, absolute")
    ax.plot(*style.thinned(time, dataset["base_acceleration"].values), color=style.RED, lw=1.4, label="base")
    ax.set_xlim(time[0], time[-1])
    ax.set_xlabel("Time (ms)")
    ax.set_ylabel("Acceleration (m/s²)")
    ax.legend(fontsize=8, framealpha=0.9, loc="upper right")
    tip_peak, base_peak = np.abs(tip).max(), np.abs(dataset["base_acceleration"].values).max()
    style.title(ax, f"The tip reaches {tip_peak:.3g} m/s², {tip_peak / base_peak:.2g} times the base")


def _decay(dataset: xr.Dataset, ax: Axes) -> None:
    amplitude = 1e6 * dataset["decay_amplitude"].values
    zeta, f = 100.0 * dataset["decay_damping"].values, dataset["decay_frequency"].values
    handles = ax.semilogx(amplitude, zeta, "-", color=style.RED, lw=1.8, label="damping (left)")
    ax.set_ylim(min(0.0, 1.1 * float(zeta.min())), 1.15 * max(float(zeta.max()), 1e-6))
    ax.set_xlim(amplitude[-1], amplitude[0])
    ax.set_xlabel("Amplitude of the tip displacement in the decay (µm, 0-peak)")
    ax.set_ylabel(f"{label('decay_damping').split(' of ')[0].capitalize()} (%)", color=style.RED)
    other = ax.twinx()
    other.spines["top"].set_visible(False)
    handles += other.plot(amplitude, f, "--", color=style.BLUE, lw=1.6, label="frequency (right)")
    other.set_ylabel("Frequency (Hz)", color=style.BLUE)
    _plain(ax)
    ax.legend(handles=handles, fontsize=8, framealpha=0.9, loc="center left")
    style.title(ax, f"Decay: {f.min():.4g} to {f.max():.4g} Hz, damping ratio {zeta.min():.2g} to {zeta.max():.2g} %")
