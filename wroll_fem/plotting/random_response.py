"""Figure of the random response of a backbone: rms, frequency and damping over level, and PSDs."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label
from wroll_fem.signals.random.psd import STANDARD_GRAVITY

_NEEDS = (
    "frequency", "base_psd", "tip_psd", "level_db", "base_rms_at_level", "tip_displacement_rms_at_level",
    "f_effective_at_level", "zeta_effective_at_level",
)  # fmt: skip
DECADES = 6.0
"""Decades of the axis of the PSDs."""


def plot_random_response(dataset: xr.Dataset) -> Axes:
    """Plot rms of the tip, effective damping and mean frequency versus base rms, and the PSDs of base and tip.

    Parameters
    ----------
    dataset
        Results of `random_response`.

    Returns
    -------
    Axes
        The axes of the rms, the uppermost of three.

    Raises
    ------
    InputError
        If the Dataset has no random response.
    """
    style.require(dataset, _NEEDS, "figure of the random response")
    _, (top, middle, bottom) = plt.subplots(
        3, 1, figsize=(style.WIDTH, 8.4), dpi=style.DPI, layout="constrained", height_ratios=(3, 2.6, 3)
    )
    base = dataset["base_rms_at_level"].values / STANDARD_GRAVITY
    _draw_rms(style.axes(top), base, dataset)
    _draw_effective(style.axes(middle), base, dataset)
    middle.sharex(top)
    _draw_spectra(style.axes(bottom), dataset)
    return top


def _draw_rms(ax: Axes, base: np.ndarray, dataset: xr.Dataset) -> None:
    attrs, rms = dataset.attrs, 1e6 * dataset["tip_displacement_rms_at_level"].values
    ax.loglog(base, rms, "o-", color=style.BLUE, lw=1.6, ms=4, label="random response")
    ax.loglog(base, rms[0] * base / base[0], "--", color=style.GREY, lw=1.2, label="proportional to the lowest level")
    here = attrs["base_rms_m_s2"] / STANDARD_GRAVITY
    ax.plot(
        here, 1e6 * attrs["tip_displacement_rms_m"], "s", color=style.RED, ms=6, zorder=5, label="level of the case"
    )
    doubtful = dataset["backbone_exceeded_at_level"].values > 0.01
    if doubtful.any():
        ax.plot(
            base[doubtful], rms[doubtful], "o", mfc="white", mec=style.BLUE, ms=5, zorder=4, label="beyond backbone"
        )
    if "allowed_base_rms_m_s2" in attrs:
        at = attrs["allowed_base_rms_m_s2"] / STANDARD_GRAVITY
        words = attrs["limiting_response"].replace("_", " ")
        ax.axvline(at, color=style.ORANGE, lw=1.4, label=f"limit of the {words}: {at:.2g} g")
    ax.set_ylabel(label("tip_displacement_rms_at_level", "µm"))
    ax.legend(fontsize=8, framealpha=0.9, loc="upper left")
    _round_ticks(ax.xaxis)
    _round_ticks(ax.yaxis)
    grown, driven = rms[-1] / rms[0], base[-1] / base[0]
    style.title(
        ax,
        f"From {base[0]:.2g} to {base[-1]:.2g} g rms ({style.three_digits(driven)} times) the rms of the tip grows "
        f"{style.three_digits(grown)} times",
    )


def _round_ticks(axis: Axis) -> None:
    """Labels at 1, 2 and 5 times powers of ten on a logarithmic axis."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _draw_effective(ax: Axes, base: np.ndarray, dataset: xr.Dataset) -> None:
    damping, hertz = 100.0 * dataset["zeta_effective_at_level"].values, dataset["f_effective_at_level"].values
    handles = ax.semilogx(base, damping, "o-", color=style.RED, lw=1.6, ms=4, label="damping (left)")
    ax.set_ylim(0.0, 1.15 * damping.max())
    _round_ticks(ax.xaxis)
    ax.set_ylabel("Effective damping ratio (%)", color=style.RED)
    ax.set_xlabel("Base acceleration (g rms)")
    other = ax.twinx()
    handles += other.plot(base, hertz, "s-", color=style.BLUE, lw=1.6, ms=4, label="frequency (right)")
    other.set_ylabel("Mean frequency (Hz)", color=style.BLUE)
    other.spines["top"].set_visible(False)
    ax.legend(handles=handles, fontsize=8, framealpha=0.9, loc="center left")
    change = hertz[-1] / hertz[0] - 1.0
    words = f"{'falls' if change < 0.0 else 'rises'} from {hertz[0]:.1f} to {hertz[-1]:.1f} Hz"
    most = int(damping.argmax())
    style.title(
        ax,
        f"The mean frequency {words if abs(change) > 1e-3 else f'stays at {hertz[0]:.1f} Hz'}; largest effective "
        f"damping {damping[most]:.2g} % at {base[most]:.2g} g rms",
    )


def _draw_spectra(ax: Axes, dataset: xr.Dataset) -> None:
    attrs, f = dataset.attrs, dataset["frequency"].values
    for name, colour, words in (("tip_psd", style.RED, "tip"), ("base_psd", style.BLUE, "base")):
        ax.semilogy(f, dataset[name].values / STANDARD_GRAVITY**2, color=colour, lw=1.4, label=words)
    most = float(dataset["tip_psd"].max()) / STANDARD_GRAVITY**2
    low = min(float(dataset["base_psd"].min()), float(dataset["tip_psd"].min())) / STANDARD_GRAVITY**2
    ax.set_ylim(max(0.5 * low, most * 10.0**-DECADES), 3.0 * most)
    ax.margins(x=0.0)
    ax.set_xlabel(label("frequency"))
    ax.set_ylabel("PSD of the acceleration (g²/Hz)")
    ax.legend(fontsize=8, framealpha=0.9)
    tip, base = (attrs[f"{name}_rms_m_s2"] / STANDARD_GRAVITY for name in ("tip", "base"))
    style.title(
        ax,
        f"At {base:.3g} g rms the tip has {tip:.3g} g rms and {3e3 * attrs['tip_displacement_rms_m']:.2g} mm "
        f"(3 sigma); effective damping {100.0 * attrs['zeta_effective']:.2g} % at {attrs['f_effective_hz']:.1f} Hz",
    )
