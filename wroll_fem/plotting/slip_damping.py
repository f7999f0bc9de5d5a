"""Figure of a coil whose wraps slide: tip displacement, damping and frequency at resonance versus base acceleration."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from scipy.constants import g as GRAVITY

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label


def plot_slip_damping(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot tip displacement with and without slip, and below it damping and frequency, versus base acceleration.

    Parameters
    ----------
    dataset
        Result of the analysis slip_damping.
    ax
        Axes of damping and frequency alone; None draws both panels in a new figure.

    Returns
    -------
    Axes
        The axes of the damping (the frequency is on its twin).

    Raises
    ------
    InputError
        If the Dataset holds no response of a slipping coil.
    """
    names = ("tip_amplitude", "resonant_base_acceleration", "tip_at_level_without_slip", "friction_modal_damping")
    style.require(dataset, names, "response of a slipping coil")
    g = dataset["resonant_base_acceleration"].values / GRAVITY
    levels = dataset["amplitude_g"].values
    if ax is None:
        _, (top, ax) = plt.subplots(2, 1, figsize=(style.WIDTH, 6.4), dpi=style.DPI, layout="constrained", sharex=True)
        style.axes(top)
        tip, linear = 1e3 * dataset["tip_amplitude"].values, 1e3 * dataset["tip_at_level_without_slip"].values
        far = float(max(g[-1], levels[-1]))
        top.plot([0.0, far], [0.0, far * linear[-1] / levels[-1]], "--", color=style.GREY, lw=1.4, label="without slip")
        top.plot(np.append(0.0, g), np.append(0.0, tip), "-", color=style.BLUE, lw=1.8, label="with slip")
        top.plot(levels, 1e3 * dataset["tip_at_level"].values, "o", color=style.BLUE, ms=4)
        top.set_ylim(0.0)
        top.set_ylabel("Tip at resonance (mm, 0-peak)")
        top.legend(fontsize=8, framealpha=0.9)
        last = dataset.isel(amplitude_g=-1)
        share = float(last["tip_at_level"] / last["tip_at_level_without_slip"])
        style.title(top, f"At {levels[-1]:g} g slip between the wraps leaves {100 * share:.0f} % of the tip motion")
    else:
        style.axes(ax)
    damping = 100.0 * dataset["modal_damping"].values
    handles = ax.plot(g, damping, "-", color=style.RED, lw=1.8, label="damping (left)")
    given = 100.0 * dataset["material_modal_damping"].values
    handles += ax.plot(g, given, "--", color=style.ORANGE, lw=1.4, label="of it, damping without slip (left)")
    ax.set_ylim(0.0, 1.15 * damping.max())
    ax.set_xlim(0.0, g[-1])
    ax.set_ylabel("Damping ratio (%)", color=style.RED)
    ax.set_xlabel("Base acceleration (g, 0-peak)")
    other = ax.twinx()
    handles += other.plot(
        g, dataset["resonance_frequency"].values, "-", color=style.BLUE, lw=1.8, label="frequency (right)"
    )
    stuck = float(dataset.attrs["f_stuck_hz"])
    handles += other.plot(
        [0.0, g[-1]], [stuck, stuck], "--", color=style.BLUE, lw=1.2, alpha=0.7, label="frequency without slip (right)"
    )
    other.set_ylabel(label("resonance_frequency"), color=style.BLUE)
    other.spines["top"].set_visible(False)
    ax.legend(handles=handles, fontsize=8, framealpha=0.9, loc="center right")
    hertz = dataset["resonance_frequency"].values
    verb = "falls" if hertz[-1] < hertz[0] else "rises"
    style.title(ax, f"The resonance {verb} from {dataset.attrs['f_stuck_hz']:.1f} to {hertz[-1]:.1f} Hz")
    return ax
