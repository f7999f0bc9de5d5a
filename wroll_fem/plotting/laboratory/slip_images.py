"""Figures of the laboratory evaluation `slip`: targets, slip over groups and time, spectrum, noise floor."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label
from wroll_fem.typing import FloatArray

_MARKS = "osD^v<>P*X"
_CYCLES = 4.0


def plot_targets(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot the first frame with number, outline and magnified path of each target."""
    style.require(dataset, ("first_frame", "target_position", "target_diameter"), "figure of the targets")
    image = dataset["first_frame"].values
    if ax is None:
        height = float(np.clip(5.2 * image.shape[0] / image.shape[1], 3.6, 8.5))
        _, ax = plt.subplots(figsize=(style.WIDTH, height), dpi=style.DPI, layout="constrained")
    low, high = np.percentile(image, (0.5, 99.8))
    ax.imshow(image, cmap="gray", vmin=low, vmax=high + 0.35 * (high - low), interpolation="nearest")
    position, diameter = dataset["target_position"].values, dataset["target_diameter"].values
    mean = np.nanmean(position, axis=0)
    moved = position - mean
    largest = float(np.nanmax(np.abs(moved)))
    factor = _round_down(0.15 * float(np.median(diameter)) / largest) if largest > 0.0 else 1.0
    angle = np.linspace(0.0, 2.0 * np.pi, 100)
    for k, (x, y) in enumerate(mean):
        colour = style.LINES[k % len(style.LINES)]
        radius = 0.5 * diameter[k]
        ax.plot(x + radius * np.cos(angle), y + radius * np.sin(angle), color=colour, lw=0.8)
        # concentric targets have one centre: paths and numbers stand on the outlines
        at = np.array([x, y]) + radius * np.array([np.cos(-0.6), np.sin(-0.6)])
        ax.plot(*(at + factor * moved[:, k]).T, color=colour, lw=0.9)
        ax.annotate(
            str(int(dataset["target"].values[k])), at, (4, 4), textcoords="offset points", fontsize=7, color=colour,
            bbox={"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.75},
        )  # fmt: skip
    ax.set_xlabel("Column x (px)")
    ax.set_ylabel("Row y (px)")
    ax.grid(False)
    style.title(
        ax, f"{len(mean)} targets in {len(position)} frames, paths magnified {factor:g} times",
        width=92 if image.shape[1] > image.shape[0] else 50,
    )  # fmt: skip
    return ax


def plot_slip_groups(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot slip amplitudes over the groups, to the mandrel and between layers (thesis, Figs. 3.20 to 3.22)."""
    style.require(dataset, ("slip_amplitude_px", "slip_group", "slip_layer"), "figure of the slip over groups")
    between = bool((dataset["slip_relative_to"].values > 0).any())
    panels = [style.axes(ax)] if ax is not None else _row(2 if between else 1)
    axis, factor, unit = _axis(dataset), *_unit(dataset)
    floor = factor * float(dataset["slip_noise_floor"])
    for n, panel in enumerate(panels):
        chosen = dataset.isel(pair=np.flatnonzero((dataset["slip_relative_to"].values > 0) == (n == 1)), axis=axis)
        size = factor * chosen["slip_amplitude_px"].values
        error = _errors(chosen, floor)
        names = _names(chosen)
        for k, name in enumerate(dict.fromkeys(names)):
            own = np.flatnonzero(np.array(names) == name)
            colour, mark = style.LINES[k % len(style.LINES)], _MARKS[k % len(_MARKS)]
            x = chosen["slip_group"].values[own] + 0.06 * (k - 1)
            panel.errorbar(x, size[own], error[own], color=colour, marker=mark, ms=5, lw=1.2, capsize=2, label=name)
        panel.axhline(floor, color=style.RED, ls="--", lw=1.0, label="noise floor")
        panel.set_xticks(np.unique(chosen["slip_group"].values))
        panel.set_xlabel("Group")
        panel.set_ylim(bottom=0.0)
        panel.legend(fontsize=8, framealpha=0.9)
    panels[0].set_ylabel(f"Slip amplitude along {'xy'[axis]}, 0-peak ({unit})")
    if len(panels) > 1:
        top = max(panel.get_ylim()[1] for panel in panels)
        for panel in panels:
            panel.set_ylim(top=top)
        style.title(panels[1], "Slip between layers", 46)
    style.title(panels[0], f"Slip to the mandrel at {dataset.attrs['frequency_hz']:g} Hz", 46)
    return panels[0]


def plot_slip_history(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot the first cycles of the slip to the mandrel, with the sine at the excitation frequency."""
    style.require(dataset, ("slip_history", "slip_amplitude_px", "slip_phase"), "figure of the slip history")
    chosen = dataset.isel(pair=np.flatnonzero(dataset["slip_relative_to"].values == 0))
    axis, factor, unit = _axis(dataset), *_unit(dataset)
    groups = list(np.unique(chosen["slip_group"].values)) if ax is None else [int(chosen["slip_group"].values[0])]
    panels = [style.axes(ax)] if ax is not None else _column(len(groups))
    frequency = float(dataset.attrs["frequency_hz"])
    time = dataset["time"].values - dataset["time"].values[0]
    first = time <= _CYCLES / frequency
    fine = np.linspace(0.0, _CYCLES / frequency, 400)
    for panel, group in zip(panels, groups, strict=True):
        own = chosen.isel(pair=np.flatnonzero(chosen["slip_group"].values == group), axis=axis)
        for k, name in enumerate(_names(own)):
            one = own.isel(pair=k)
            value = factor * (one["slip_history"].values - np.nanmean(one["slip_history"].values))
            sine = (
                factor
                * float(one["slip_amplitude_px"])
                * np.cos(2.0 * np.pi * frequency * fine + float(one["slip_phase"]))
            )
            colour = style.LINES[k % len(style.LINES)]
            panel.plot(1e3 * time[first], value[first], color=colour, ls="", marker=_MARKS[k % len(_MARKS)], ms=2.5)
            panel.plot(1e3 * fine, sine, color=colour, lw=1.3, label=name)
        panel.set_ylabel(f"Group {group}:\nslip along {'xy'[axis]} ({unit})")
    panels[0].legend(fontsize=8, framealpha=0.9, loc="upper right", ncols=len(_names(own)))
    panels[-1].set_xlabel("Time from the first frame (ms)")
    style.title(panels[0], f"Slip to the mandrel: frames, and the sine at {frequency:g} Hz fitted to all frames")
    return panels[0]


def plot_slip_spectrum(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot the spectra of the slip around the excitation with the noise floor."""
    style.require(dataset, ("slip_spectrum", "frequency"), "figure of the slip spectrum")
    axis, factor, unit = _axis(dataset), *_unit(dataset)
    between = bool((dataset["slip_relative_to"].values > 0).any())
    panels = [style.axes(ax)] if ax is not None else _row(2 if between else 1, sharey=True)
    for n, panel in enumerate(panels):
        chosen = dataset.isel(pair=np.flatnonzero((dataset["slip_relative_to"].values > 0) == (n == 1)), axis=axis)
        names = _names(chosen)
        for k, name in enumerate(dict.fromkeys(names)):
            colour = style.LINES[k % len(style.LINES)]
            for m, pair in enumerate(np.flatnonzero(np.array(names) == name)):
                values = factor * chosen["slip_spectrum"].values[:, pair]
                panel.semilogy(dataset["frequency"], values, color=colour, lw=1.0, label=name if m == 0 else None)
        panel.axhline(
            factor * float(dataset["slip_noise_floor"]), color=style.RED, ls="--", lw=1.2, label="noise floor"
        )
        panel.set_xlabel(label("frequency"))
        panel.legend(fontsize=8, framealpha=0.9)
    panels[0].set_ylabel(f"Slip amplitude along {'xy'[axis]}, 0-peak ({unit})")
    style.title(panels[0], "Slip to the mandrel, one line per group", 46)
    if len(panels) > 1:
        style.title(panels[1], "Slip between layers, one line per group", 46)
    return panels[0]


def plot_noise(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot the positions at rest over time, and their spectra around the excitation (thesis, Fig. 3.19)."""
    style.require(dataset, ("rest_position", "noise_spectrum", "noise_floor"), "figure of the noise")
    panels = _row(2) if ax is None else [style.axes(ax)]
    rest = dataset["rest_position"].values
    moved = (rest - np.nanmean(rest, axis=0)).reshape(len(rest), -1)
    time = dataset["rest_time"].values
    few = slice(0, 400)
    panels[0].plot(time[few], moved[few], color=style.BLUE, lw=0.4, alpha=0.5)
    panels[0].set_xlabel(label("rest_time"))
    panels[0].set_ylabel("Position minus mean (px)")
    floor = float(dataset["noise_floor"])
    ratio = float(np.nanmax(np.abs(moved))) / floor
    style.title(panels[0], f"{rest.shape[1]} targets at rest along x and y", 46)
    if len(panels) > 1:
        values = dataset["noise_spectrum"].values.reshape(len(dataset["frequency"]), -1)
        panels[1].plot(dataset["frequency"], values, color=style.BLUE, lw=0.6, alpha=0.6)
        panels[1].axhline(floor, color=style.RED, ls="--", lw=1.2)
        panels[1].set_ylim(bottom=0.0)
        panels[1].set_xlabel(label("frequency"))
        panels[1].set_ylabel("Amplitude, 0-peak (px)")
        style.title(panels[1], f"Noise floor {floor:.2g} px, {ratio:.0f} times below the largest deviation in time", 46)
    return panels[0]


def _axis(dataset: xr.Dataset) -> int:
    """Axis along which the slip is larger: 0 for x, 1 for y."""
    largest = np.nan_to_num(dataset["slip_amplitude_px"].values).max(axis=0)
    return int(np.argmax(largest))


def _unit(dataset: xr.Dataset) -> tuple[float, str]:
    """Factor from pixels to the unit of the figure, and the unit."""
    length = dataset.attrs.get("pixel_length_m")
    return (1.0, "px") if length is None else (1e6 * float(length), "µm")


def _errors(chosen: xr.Dataset, floor: float) -> FloatArray:
    if "slip_error" in chosen:
        return 1e6 * chosen["slip_error"].values
    return np.full(chosen.sizes["pair"], floor)


def _names(chosen: xr.Dataset) -> list[str]:
    """Layer of each pair, or both layers."""
    pairs = zip(chosen["slip_layer"].values, chosen["slip_relative_to"].values, strict=True)
    return [f"layer {a}" if b == 0 else f"layers {a} and {b}" for a, b in pairs]


def _row(count: int, *, sharey: bool = False) -> list[Axes]:
    size = (style.WIDTH * (1.15 if count > 1 else 1.0), 3.8)
    _, panels = plt.subplots(1, count, figsize=size, dpi=style.DPI, layout="constrained", sharey=sharey, squeeze=False)
    return [style.axes(panel) for panel in panels[0]]


def _column(count: int) -> list[Axes]:
    size = (style.WIDTH, min(1.0 + 1.9 * count, 9.0))
    _, panels = plt.subplots(
        count, 1, figsize=size, dpi=style.DPI, layout="constrained", sharex=True, sharey=True, squeeze=False
    )
    return [style.axes(panel) for panel in panels[:, 0]]


def _round_down(value: float) -> float:
    """Largest of 1, 2, 5, 10, 20, ... that does not exceed the value; at least 1."""
    if value < 1.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(m for m in (1.0, 2.0, 5.0) if m * power <= value))
