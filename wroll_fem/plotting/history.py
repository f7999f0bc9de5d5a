"""Figures of time histories: tip response with friction work, and energy ledger."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, MaxNLocator

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label
from wroll_fem.results.energy import energy_ledger
from wroll_fem.signals.sweeps import sweep_of
from wroll_fem.signals.tip import absolute_tip

_STORED = ("kinetic_energy", "strain_energy", "contact_energy")
_LEDGER = ("time", "input_work", "friction_energy", "numerical_dissipation", *_STORED)


def _frequency_axis(ax: Axes, dataset: xr.Dataset) -> None:
    """Add a frequency axis on top if the base motion is a sweep; do nothing for other motions."""
    sweep = sweep_of(dataset)
    if sweep is None:
        return

    def time(frequency: npt.ArrayLike) -> npt.ArrayLike:
        return sweep.time_of_frequency(np.maximum(np.asarray(frequency, dtype=np.float64), 1e-9))

    top = ax.secondary_xaxis("top", functions=(sweep.frequency, time))
    last = float(sweep.frequency(dataset["time"].values[-1]))
    low, high = sorted((sweep.f_start, last))
    ticks = MaxNLocator(nbins=7, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    top.xaxis.set_major_locator(FixedLocator([t for t in ticks if low * (1 - 1e-9) <= t <= high * (1 + 1e-9)]))
    top.set_xlabel("Frequency of the base (Hz)")


def _second_y(ax: Axes) -> Axes:
    other = ax.twinx()
    other.spines["top"].set_visible(False)
    return other


def plot_response(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the absolute tip acceleration and the cumulative friction work versus time.

    Parameters
    ----------
    dataset
        Has `tip_acceleration` (relative to the base), `base_acceleration` and `friction_energy` along `time`. The
        attributes `excitation_kind`, `f_start_hz`, `rate_oct_per_min` (or `f_end_hz`) give the frequency axis of a
        chirp.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes of the acceleration (friction work is on a twin).

    Raises
    ------
    InputError
        When the Dataset lacks one of the histories.
    """
    style.require(dataset, ("time", "tip_acceleration", "base_acceleration", "friction_energy"), "response figure")
    ax = style.axes(ax)
    time = dataset["time"].values
    tip = absolute_tip(dataset)
    work = dataset["friction_energy"].values
    x, low, high = style.line_envelope(time, tip)
    if low is high:
        ax.plot(x, low, color=style.BLUE, lw=0.8)
    else:
        ax.fill_between(x, low, high, color=style.SKY, lw=0.3, edgecolor=style.BLUE)
    other = _second_y(ax)
    other.plot(*style.thinned(time, 1e3 * work), color=style.RED, lw=1.8)
    _frequency_axis(ax, dataset)
    size = 1.05 * float(np.abs(tip).max())
    ax.set_ylim(-size, size)
    ax.set_xlim(time[0], time[-1])
    other.set_ylim(0.0, 1.05e3 * max(float(work.max()), 1e-15))
    ax.set_xlabel(label("time"))
    ax.set_ylabel("Absolute tip acceleration (m/s²)", color=style.BLUE)
    other.set_ylabel("Cumulative friction work (mJ)", color=style.RED)
    peak = int(np.abs(tip).argmax())
    sweep = sweep_of(dataset)
    where = f"t = {time[peak]:.3g} s" if sweep is None else f"{float(sweep.frequency(time[peak])):.1f} Hz"
    most, taken = f"{style.three_digits(abs(tip[peak]))} m/s²", style.engineering(work[-1], "J")
    text = f"Largest tip acceleration {most} at {where}; friction work {taken}"
    if sweep is not None and work[-1] > 0.0:
        places = time[np.searchsorted(work, np.array([0.25, 0.75]) * work[-1])]
        first, last = sorted(sweep.frequency(places))
        text += f", half of it between {first:.1f} and {last:.1f} Hz"
    style.title(ax, text)
    return ax


def plot_energy_ledger(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the energy balance versus time: input work of the base, friction work, stored energy, numerical dissipation.

    Parameters
    ----------
    dataset
        Has the ledger (`input_work`, `friction_energy`, `numerical_dissipation`, `kinetic_energy`, `strain_energy`,
        `contact_energy`) along `time`.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        When the Dataset lacks a term of the ledger.
    """
    style.require(dataset, _LEDGER, "energy ledger")
    ax = style.axes(ax, 4.6)
    time = dataset["time"].values
    ledger = energy_ledger(dataset)
    given = ledger.input_work
    biggest = max(float(np.abs(given).max()), 1e-30)
    scale, unit = (1.0, "J") if biggest >= 1.0 else (1e3, "mJ") if biggest >= 1e-3 else (1e6, "µJ")
    series = [
        ("input work of the base", given, style.BLUE, "-"),
        ("friction", ledger.friction, style.RED, "-"),
        ("stored: kinetic + strain + contact", ledger.stored, style.GREEN, "-"),
        ("numerical: dissipation of the scheme, impacts", ledger.numerical, style.GREY, "--"),
    ]
    if ledger.material.any():
        series.insert(2, ("material damping", ledger.material, style.ORANGE, "-"))
    for name, values, colour, dash in series:
        x, low, high = style.line_envelope(time, scale * values)
        if low is not high:
            ax.fill_between(x, low, high, color=colour, alpha=0.35, lw=0)
        ax.plot(x, high, color=colour, lw=1.6, ls=dash, label=name)
    _frequency_axis(ax, dataset)
    ax.set_xlim(time[0], time[-1])
    ax.set_xlabel(label("time"))
    ax.set_ylabel(f"Energy since the start ({unit})")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, fontsize=8, frameon=False)
    total = given[-1] if given[-1] != 0.0 else np.inf
    error = ledger.gap[-1] / total
    closes = (
        "the balance closes to rounding" if abs(error) < 1e-9 else f"the balance is off by {100 * abs(error):.1g} %"
    )
    shares = {"friction": ledger.friction, "stored": ledger.stored, "numerical": ledger.numerical}
    if ledger.material.any():
        shares["material damping"] = ledger.material
    parts = ", ".join(f"{name} {100 * values[-1] / total:.1f} %" for name, values in shares.items())
    style.title(ax, f"Input work {style.engineering(given[-1], 'J')}: {parts}; {closes}")
    return ax
