"""Figures of periodic motions: frequency response from harmonic balance, and backbone curve."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from wroll_fem.plotting import style
from wroll_fem.plotting.transmissibility import damping_words, peak_words, ratio_label
from wroll_fem.results.dataset import label
from wroll_fem.results.resonance import resonance
from wroll_fem.signals.transmissibility import magnitude

SAME = 1e-3
"""Relative change of the resonance frequency along a backbone below which it is said to stay."""

NO_DAMPING = 1e-9
"""Damping ratio below which that of a backbone is rounding error."""


def plot_harmonic_response(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the transmissibility |T| versus frequency from harmonic balance; unstable parts between folds are dashed.

    Parameters
    ----------
    dataset
        Result of the analysis harmonic, with the damping estimate in its attributes.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        If the Dataset holds no response curve.
    """
    style.require(dataset, ("frequency", "transmissibility_real", "transmissibility_imag", "stable"), "response curve")
    ax = style.axes(ax)
    frequency, stable = dataset["frequency"].values, dataset["stable"].values.astype(bool)
    size = magnitude(dataset).values
    ax.plot(frequency, np.where(stable, size, np.nan), ".-", color=style.BLUE, lw=1.6, ms=4, label="harmonic balance")
    if not stable.all():
        between = ~stable | np.append(~stable[1:], False) | np.insert(~stable[:-1], 0, False)
        ax.plot(frequency, np.where(between, size, np.nan), "--", color=style.GREY, lw=1.2, label="unstable (folds)")
    attrs = dataset.attrs
    peak = int(size.argmax())
    ax.plot(frequency[peak], size[peak], "o", color=style.RED, ms=5, zorder=5)
    ends = [attrs[name] for name in ("half_power_low_hz", "half_power_high_hz") if np.isfinite(attrs.get(name, np.nan))]
    if ends:
        level = size[peak] / np.sqrt(2.0)
        ax.plot(ends, [level] * len(ends), "s-", color=style.RED, ms=4, lw=0.9, zorder=5, label="half power")
    if "slipping_fraction" in dataset:
        other = ax.twinx()
        other.fill_between(frequency, 100.0 * dataset["slipping_fraction"].values, color=style.ORANGE, alpha=0.25, lw=0)
        other.set_ylim(0.0, 100.0)
        other.set_ylabel("Contact points that slip (%)", color=style.ORANGE)
        other.spines["top"].set_visible(False)
    ax.set_xlim(frequency.min(), frequency.max())
    ax.set_ylim(0.0, 1.12 * size.max())
    ax.set_xlabel(label("frequency"))
    ax.set_ylabel(ratio_label(dataset))
    ax.legend(fontsize=8, framealpha=0.9, loc="upper right")
    read = resonance(dataset)
    damping = f"damping ratio {damping_words(read)}" if read.damped else "no damping estimate"
    friction = float(dataset["friction_work_per_cycle"].values[peak])
    dissipates = friction > 1e-12 * float(np.abs(dataset["input_work_per_cycle"].values).max())
    work = (
        f"friction work {style.engineering(friction, 'J')} per cycle" if dissipates else "friction dissipates nothing"
    )
    style.title(ax, f"{peak_words(dataset, size[peak])} at {frequency[peak]:.1f} Hz; {damping}; {work}")
    return ax


def plot_backbone(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot resonance frequency and modal damping versus tip amplitude, with dots at round values of base acceleration.

    Parameters
    ----------
    dataset
        Result of the analysis backbone.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in (damping; the frequency is on its twin).

    Raises
    ------
    InputError
        If the Dataset holds no backbone.
    """
    names = ("tip_amplitude", "resonance_frequency", "modal_damping", "resonant_base_acceleration")
    style.require(dataset, names, "backbone")
    ax = style.axes(ax, 4.6)
    tip, damping = 1e6 * dataset["tip_amplitude"].values, 100.0 * dataset["modal_damping"].values
    hertz, base = dataset["resonance_frequency"].values, dataset["resonant_base_acceleration"].values
    handles = ax.plot(tip, damping, "-", color=style.RED, lw=1.8, label="damping (left)")
    if "material_modal_damping" in dataset:
        part = 100.0 * dataset["material_modal_damping"].values
        handles += ax.plot(tip, part, "--", color=style.ORANGE, lw=1.6, label="of it, material damping (left)")
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlim(tip[0], tip[-1])
    ax.set_ylim(0.0, 1.15 * max(damping.max(), 1e-6))
    ax.set_xlabel(label("tip_amplitude", "µm"))
    ax.set_ylabel("Modal damping ratio (%)", color=style.RED)
    other = ax.twinx()
    handles += other.plot(tip, hertz, "-", color=style.BLUE, lw=1.8, label="frequency (right)")
    other.set_ylabel(label("resonance_frequency"), color=style.BLUE)
    other.spines["top"].set_visible(False)
    slipping = damping > 1e-3 * damping.max()
    for level in (0.3, 1.0, 3.0, 10.0, 30.0, 100.0):
        if base[slipping].size and base[slipping].min() < level < base.max() and np.all(np.diff(base[slipping]) > 0):
            at = float(np.exp(np.interp(np.log(level), np.log(base[slipping]), np.log(tip[slipping]))))
            there = float(np.interp(at, tip, damping))
            ax.plot(at, there, "o", color="black", ms=4, zorder=5)
            ax.annotate(
                f"{level:g} m/s²", (at, there), textcoords="offset points", xytext=(-6, 6), fontsize=8, ha="right"
            )
    ax.legend(handles=handles, fontsize=8, framealpha=0.9, loc="center left")
    dots = "; dots: base acceleration at resonance" if len(ax.texts) else ""
    style.title(ax, "; ".join(backbone_facts(dataset)) + dots)
    return ax


def backbone_facts(dataset: xr.Dataset) -> list[str]:
    """What a backbone shows, in words: change of the resonance, start of slip, and largest damping.

    Each statement is tested. A frequency that moves by less than `SAME` stays; a damping ratio below `NO_DAMPING` is
    rounding error; slip starts between two points of the curve only if the first of them has none.
    """
    tip, damping = 1e6 * dataset["tip_amplitude"].values, dataset["modal_damping"].values
    hertz = dataset["resonance_frequency"].values
    change = hertz[-1] / hertz[0] - 1.0
    if abs(change) < SAME:
        facts = [f"Resonance stays at {hertz[0]:.1f} Hz from {tip[0]:.3g} to {tip[-1]:.3g} µm"]
    else:
        verb = "falls" if change < 0.0 else "rises"
        facts = [f"Resonance {verb} from {hertz[0]:.1f} to {hertz[-1]:.1f} Hz with rising amplitude"]
    if "slipping_fraction" in dataset:
        share = dataset["slipping_fraction"].values
        slips = share > 0.0
        first = int(slips.argmax())
        if not slips.any():
            facts.append("no point slips")
        elif first == 0:
            facts.append(f"points slip from the smallest amplitude on ({100 * share[0]:.2g} %)")
        else:
            facts.append(f"slip starts at {tip[first]:.3g} µm")
    most = int(damping.argmax())
    if damping[most] < NO_DAMPING:
        facts.append("friction dissipates nothing")
    else:
        end = ", the largest amplitude" if most == len(tip) - 1 else ""
        facts.append(f"largest damping ratio {100 * damping[most]:.2g} % at {tip[most]:.3g} µm{end}")
        if "friction_modal_damping" in dataset and not np.any(dataset["friction_modal_damping"].values > NO_DAMPING):
            facts[-1] = f"material damping {100 * damping[most]:.2g} %; friction dissipates nothing"
    return facts
