"""Figure of a study of coils whose wraps slide: damping and frequency at resonance versus base acceleration."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from scipy.constants import g as GRAVITY

from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.study import MARKERS, StudyCase, grid_cases, shown, values_of
from wroll_fem.results.dataset import label

_DESCRIBED = ("coil", "excitation", "mandrel")
"""Sections whose keys name lines with values that are no numbers too."""

_NEEDED = ("resonant_base_acceleration", "modal_damping", "material_modal_damping", "damping_at_level")


def plot_damping_over_level(members: Sequence[StudyCase]) -> Axes:
    """Plot damping ratio and frequency versus base acceleration: one line per case of the grid.

    Parameters
    ----------
    members
        Finished cases of slip_damping; the key of the grid with most values names the lines.

    Returns
    -------
    Axes
        The panel of the damping.

    Notes
    -----
    The linear prediction, the damping without slip at the frequency without slip, is dashed in the same colour.

    Raises
    ------
    InputError
        If the grid has no quantity, or a case no damping versus base acceleration.
    """
    keys = {key: None for member in members for key, value in member.values.items() if _is_quantity(key, value)}
    if not keys:
        raise InputError(
            "the figure damping_over_level needs cases with values of a quantity of the roll", key="figure",
            remedy="add one to the grid, such as winding.mu, or choose another figure",
        )  # fmt: skip
    axis = max(keys, key=lambda key: len(values_of(members, key)))
    grid = grid_cases(members, "damping_over_level", axis)
    for member in grid:
        style.require(member.data, _NEEDED, "figure of damping over level")
    order = values_of(grid, axis)
    grid = sorted(grid, key=lambda member: order.index(member.values[axis]))
    _, (top, low) = plt.subplots(2, 1, figsize=(style.WIDTH, 6.4), dpi=style.DPI, layout="constrained", sharex=True)
    shades = colormaps["viridis"](np.linspace(0.0, 0.85, len(grid)))
    far = max(float(member.data["amplitude_g"][-1]) for member in grid)
    for k, (member, shade) in enumerate(zip(grid, shades, strict=True)):
        data, levels = member.data, member.data["amplitude_g"].values
        g = np.append(0.0, data["resonant_base_acceleration"].values / GRAVITY)
        without = 100.0 * float(data["material_modal_damping"][0])
        text = shown(axis, member.values[axis])
        stuck = float(data.attrs["f_stuck_hz"])
        for ax, curve, dots, linear in (
            (top, 100.0 * data["modal_damping"].values, 100.0 * data["damping_at_level"].values, without),
            (low, data["resonance_frequency"].values, data["frequency_at_level"].values, stuck),
        ):
            ax.plot(g, np.append(linear, curve), "-", color=shade, lw=1.6, label=text)
            ax.plot(levels, dots, MARKERS[k % 6], color=shade, ms=4)
            ax.plot([0.0, far], [linear, linear], "--", color=shade, lw=0.9)
    for ax, unit in ((top, "Damping ratio (%)"), (low, label("resonance_frequency"))):
        style.axes(ax)
        ax.set_ylabel(unit)
        ax.set_xlim(0.0, 1.03 * far)
    top.set_ylim(0.0)
    low.set_xlabel("Base acceleration (g, 0-peak)")
    top.plot([], [], "--", color=style.GREY, lw=0.9, label="without slip")
    top.legend(fontsize=8, framealpha=0.9)
    style.title(top, _sentence(grid, axis, far))
    first: Axes = top
    return first


def _is_quantity(key: str, value: Any) -> bool:
    """Whether a key of a grid describes the roll or its motion: a number, or a choice such as the base of the coil."""
    return (isinstance(value, int | float) and not isinstance(value, bool)) or key.split(".")[0] in _DESCRIBED


def _sentence(grid: Sequence[StudyCase], axis: str, far: float) -> str:
    """Range of the damping at the highest level of all cases."""
    at = [100.0 * float(member.data["damping_at_level"][-1]) for member in grid]
    known = [k for k, value in enumerate(at) if np.isfinite(value)]
    if not known:
        return f"No case has a result at {far:g} g"
    low, high = (pick(known, key=lambda k: at[k]) for pick in (min, max))
    names = [shown(axis, grid[k].values[axis]) for k in (low, high)]
    if low == high:
        return f"At {far:g} g the damping ratio is {at[low]:.2g} % ({names[0]})"
    return f"At {far:g} g the damping ratio is {at[low]:.2g} % ({names[0]}) to {at[high]:.2g} % ({names[1]})"
