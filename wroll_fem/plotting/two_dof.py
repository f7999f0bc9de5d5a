"""Figures of the two-mass model: response versus frequency, damping versus friction capacity, design space."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label
from wroll_fem.results.design_space import tuned_stiffness
from wroll_fem.typing import FloatArray

_RESPONSE = ("transmissibility", "omega_peak", "peak_transmissibility", "omega_low", "omega_high", "zeta")


def _line(dataset: xr.Dataset, k: int) -> tuple[FloatArray, FloatArray]:
    """Frequencies (rad/s) and transmissibility at friction capacity k; refined peak and half-power points are added."""
    one = dataset.isel(friction_capacity=k)
    x, y = dataset["omega"].values, one["transmissibility"].values
    peak = float(one["peak_transmissibility"])
    more = [(float(one[name]), value) for name, value in (
        ("omega_low", peak / np.sqrt(2.0)), ("omega_peak", peak), ("omega_high", peak / np.sqrt(2.0))
    ) if np.isfinite(one[name])]  # fmt: skip
    x, y = np.append(x, [at for at, _ in more]), np.append(y, [value for _, value in more])
    order = np.argsort(x, kind="stable")
    return x[order], y[order]


def _colours(count: int) -> np.ndarray:
    """Colours from blue (low capacity) to red (high) as in the thesis, without the pale middle of the colour map."""
    share = np.linspace(0.0, 1.0, count)
    return colormaps["coolwarm"](np.where(share < 0.5, 0.42 * share / 0.5, 0.58 + 0.42 * (share - 0.5) / 0.5))


def _plain(value: float, _: object = None) -> str:
    return f"{value:g}"


def plot_two_dof(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the transmissibility versus frequency, one curve per friction capacity (thesis, Fig. 5.6c).

    The colours go from blue (low capacity) to red (high capacity).

    Parameters
    ----------
    dataset
        Result of the analysis two_dof.

    Raises
    ------
    InputError
        If the Dataset contains no response of the two masses.
    """
    style.require(dataset, _RESPONSE, "response of the two masses")
    ax = style.axes(ax, 4.6)
    capacities = dataset["friction_capacity"].values
    for k, colour in enumerate(_colours(len(capacities))):
        # low capacities on top: where the masses stick, all curves coincide
        ax.plot(*_line(dataset, k), color=colour, lw=1.6, label=f"{capacities[k]:g} N", zorder=3.0 - 0.01 * k)
        peak = dataset.isel(friction_capacity=k)
        ax.plot(float(peak["omega_peak"]), float(peak["peak_transmissibility"]), "o", color=colour, ms=4, zorder=4.0)
    ax.set_yscale("log")
    ax.yaxis.set_major_formatter(FuncFormatter(_plain))
    ax.set_xlim(float(dataset["omega"][0]), float(dataset["omega"][-1]))
    ax.set_xlabel(label("omega", "rad/s"))
    ax.set_ylabel("Transmissibility, largest |x₁| / Y₀ (–)")
    if len(capacities) <= 16:
        legend_title = "Friction capacity"
        ax.legend(title=legend_title, fontsize=8, title_fontsize=8, framealpha=0.9, ncols=1 + len(capacities) // 9)
    style.title(ax, _sentence(dataset))
    return ax


def _sentence(dataset: xr.Dataset) -> str:
    peaks, at = dataset["peak_transmissibility"], dataset["omega_peak"].values
    if not np.isfinite(at).all():
        return "Response at each friction capacity; some bands hold no peak"
    lowest = peaks.isel(friction_capacity=int(peaks.values.argmin()))
    said = f"Peaks move from {at[0]:.3f} to {at[-1]:.3f} rad/s with the friction capacity"
    if peaks.size < 3:
        return said
    force = float(lowest["friction_capacity"])
    return f"{said}; the lowest, {style.three_digits(float(lowest))}, at {force:g} N"


def plot_two_dof_readings(dataset: xr.Dataset) -> Axes:
    """Plot damping, peak, peak frequency and skewness versus friction capacity; return the first axes.

    Raises
    ------
    InputError
        If the Dataset contains no response of the two masses.
    """
    style.require(dataset, (*_RESPONSE, "skewness", "omega_stuck"), "damping figure of the two masses")
    _, panels = plt.subplots(2, 2, figsize=(style.WIDTH, 5.8), dpi=style.DPI, layout="constrained", sharex=True)
    capacity = dataset["friction_capacity"].values
    zeta = 100.0 * dataset["zeta"].values
    rows = (
        (zeta, f"Damping, {_methods(dataset)} (%)", style.RED, True),
        (dataset["peak_transmissibility"].values, "Peak transmissibility (–)", style.BLUE, True),
        (dataset["omega_peak"].values, "Frequency of the peak (rad/s)", style.GREEN, False),
        (dataset["skewness"].values, "Skewness (–)", style.PURPLE, False),
    )
    for ax, (values, text, colour, logarithmic) in zip(panels.ravel(), rows, strict=True):
        style.axes(ax)
        ax.plot(capacity, values, "o-", color=colour, ms=4, lw=1.6)
        ax.set_xscale("log")
        if logarithmic and np.isfinite(values).any():
            ax.set_yscale("log")
            ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            ax.yaxis.set_major_formatter(FuncFormatter(_plain))
            ax.yaxis.set_minor_formatter(NullFormatter())
        ax.xaxis.set_major_formatter(FuncFormatter(_plain))
        ax.set_ylabel(text)
    panels[1, 0].plot(capacity, dataset["omega_stuck"], ls=":", color="black", lw=1.2, label="masses stuck together")
    panels[1, 0].legend(fontsize=8, framealpha=0.9)
    panels[1, 1].axhline(0.0, color="black", lw=0.8)
    for ax in panels[1]:
        ax.set_xlabel("Friction capacity (N)")
    first: Axes = panels[0, 0]
    if np.isfinite(zeta).any():
        k = int(np.nanargmax(zeta))
        style.title(first, f"Damping is largest, {zeta[k]:.1f} %, at a capacity of {capacity[k]:.3g} N", 46)
    return first


def _methods(dataset: xr.Dataset) -> str:
    """Names of the damping estimators that were used, joined by "or", without repetition."""
    named = dataset["zeta_method"].values.tolist() if "zeta_method" in dataset else ["half power"]
    return " or ".join(dict.fromkeys(map(str, named)))


def plot_two_dof_design_space(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the damping of each design (secondary mass, stiffness) at its optimal friction capacity (thesis, Fig. 5.7).

    On the dashed line the two uncoupled masses have equal natural frequencies. The line holds for the friction capacity
    that is optimal for most designs.

    Raises
    ------
    InputError
        When the Dataset holds no design space.
    """
    style.require(dataset, ("zeta_max", "m2", "k2"), "design space of the two masses")
    zeta = 100.0 * dataset["zeta_max"].transpose("k2", "m2")
    ax = style.axes(ax, 5.0)
    filled = ax.contourf(zeta["m2"], zeta["k2"], zeta.values, levels=14, cmap="viridis")
    lines = ax.contour(
        zeta["m2"], zeta["k2"], zeta.values, levels=np.asarray(filled.levels)[::2], colors="white", linewidths=0.7
    )
    ax.clabel(lines, fmt="%.3g", fontsize=7)
    bar = style.figure_of(ax).colorbar(filled, ax=ax)
    bar.set_label("Largest half-power damping of all capacities (%)")
    _draw_tuned(dataset, ax)
    ax.grid(False)
    ax.set_xlabel(label("m2", "kg"))
    ax.set_ylabel(label("k2", "N/m"))
    count = dataset.sizes["friction_capacity"]
    rises = np.diff(zeta.values, axis=0) > 0.0
    share = 100.0 * float(np.mean(rises))
    trend = (
        "grows with the secondary's stiffness everywhere"
        if share == 100.0
        else (f"grows with the secondary's stiffness in {share:.0f} % of the steps")
    )
    style.title(
        ax, f"Largest damping of {count} capacities: {np.nanmin(zeta):.1f} to {np.nanmax(zeta):.1f} %; it {trend}", 76
    )
    return ax


def _draw_tuned(dataset: xr.Dataset, ax: Axes) -> None:
    """Draw the line on which the two uncoupled masses have equal natural frequencies."""
    found = tuned_stiffness(dataset)
    if found is None:
        return
    capacity, k2 = found
    m2 = dataset["m2"].values
    shown = (k2 >= float(dataset["k2"].min())) & (k2 <= float(dataset["k2"].max()))
    text = f"equal uncoupled frequencies (at {capacity:g} N)"
    ax.plot(m2[shown], k2[shown], color="white", ls="--", lw=1.6, label=text)
    ax.legend(fontsize=8, facecolor="#777777", labelcolor="white", loc="upper right")


def plot_two_dof_arrangements(datasets: Mapping[str, xr.Dataset]) -> Axes:
    """Plot the responses of the arrangements in Fig. 5.1 of the thesis side by side (Fig. 5.2); return the first axes.

    Parameters
    ----------
    datasets
        Panel title -> result of the analysis two_dof.

    Raises
    ------
    InputError
        If one of the Datasets contains no response of the two masses.
    """
    for dataset in datasets.values():
        style.require(dataset, _RESPONSE, "comparison of arrangements")
    _, panels = plt.subplots(
        1, len(datasets), figsize=(1.4 * style.WIDTH, 4.0), dpi=style.DPI, layout="constrained", sharey=True,
        squeeze=False,
    )  # fmt: skip
    for ax, (words, dataset) in zip(panels[0], datasets.items(), strict=True):
        style.axes(ax)
        capacities = dataset["friction_capacity"].values
        for k, colour in enumerate(_colours(len(capacities))):
            one = dataset.isel(friction_capacity=k)
            skew = float(one["skewness"])
            read = f"skewness {round(skew, 2) + 0.0:+.2f}" if np.isfinite(skew) else "no skewness"
            text = f"{capacities[k]:g} N, {read}".replace("-", "−")
            ax.plot(*_line(dataset, k), color=colour, lw=1.6, label=text, zorder=3.0 - 0.01 * k)
        ax.axvline(1.0, color="black", lw=1.0, ls=":")
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter(FuncFormatter(_plain))
        ax.set_xlabel(label("omega", "rad/s"))
        ax.set_xlim(float(dataset["omega"][0]), float(dataset["omega"][-1]))
        ax.legend(fontsize=7, framealpha=0.9)
        ax.set_title(words, loc="left", fontsize=9)
    first: Axes = panels[0, 0]
    first.set_ylabel("Transmissibility, largest |x₁| / Y₀ (–)")
    return first
