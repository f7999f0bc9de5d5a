"""Figures of the wound roll: stress versus radius, soft and hard rolls, pressure versus winding tension."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from wroll_fem.plotting import style
from wroll_fem.plotting.study import MARKERS, StudyCase, axis_label, grid_cases, shown, values_of
from wroll_fem.results.pressure_profile import middle_slope

TENSION, MODULUS = "winding.tension_newton", "winding.web.radial_modulus"
SIMULATED = (10e3, 300e3)
"""Lowest and highest preload simulated in the thesis (section 4.2), Pa."""

_STRESS = ("pressure_pa", "capacity_pa", "hoop_stress_pa", "winding_tension_pa", "wrap_radius", "wrap_pressure_pa")


def plot_winding(dataset: xr.Dataset) -> Axes:
    """Plot pressure and friction capacity versus radius, and hoop stress in a second panel (thesis, Fig 2.12).

    Parameters
    ----------
    dataset
        Result of the analysis winding.

    Returns
    -------
    Axes
        The upper axes.

    Raises
    ------
    InputError
        When the Dataset holds no wound roll.
    """
    style.require(dataset, _STRESS, "figure of the wound roll")
    _, (upper, lower) = plt.subplots(
        2, 1, figsize=(style.WIDTH, 6.4), dpi=style.DPI, layout="constrained", sharex=True, height_ratios=(3, 2)
    )
    style.axes(upper)
    style.axes(lower)
    radius, ends = dataset["r"].values, dataset["r"].values[[0, -1]]
    scale, unit = _scaled(float(dataset["pressure_pa"].max()))
    under = np.append(dataset["wrap_radius"].values, ends[1]) / ends[0]
    for name, colour, text in (("pressure", style.BLUE, "pressure"), ("capacity", style.RED, "capacity, µ × pressure")):
        upper.plot(radius / ends[0], scale * dataset[f"{name}_pa"], color=colour, lw=1.8, label=text)
        coarse = np.append(dataset[f"wrap_{name}_pa"].values, 0.0)
        upper.plot(under, scale * coarse, color=colour, lw=1.2, ls=(0, (4, 2)), label=f"{text}, thesis's grid")
    upper.set_ylabel(f"Interlayer stress ({unit})")
    upper.set_ylim(0.0, None)
    upper.legend(fontsize=8, framealpha=0.9)
    scale, unit = _scaled(float(dataset["winding_tension_pa"].max()))
    middle = 0.5 * (under[1:] + under[:-1])
    lower.plot(
        radius / ends[0], scale * dataset["winding_tension_pa"], color=style.GREY, lw=1.2, ls=":", label="as wound"
    )
    lower.plot(radius / ends[0], scale * dataset["hoop_stress_pa"], color=style.GREEN, lw=1.8, label="in the roll")
    lower.plot(
        middle, scale * dataset["wrap_hoop_stress_pa"], color=style.GREEN, lw=1.2, ls=(0, (4, 2)),
        label="in the roll, thesis's grid",
    )  # fmt: skip
    lower.axhline(0.0, color="black", lw=0.8)
    lower.set_ylabel(f"Hoop stress ({unit})")
    lower.set_xlabel("Radius / mandrel radius (–)")
    lower.set_xlim(1.0, ends[1] / ends[0])
    lower.legend(fontsize=8, framealpha=0.9)
    attrs = dataset.attrs
    fine, coarse = attrs["pressure_mandrel_pa"], attrs["pressure_mandrel_wrap_grid_pa"]
    capacity = style.engineering(attrs["capacity_mandrel_pa"], "Pa")
    style.title(
        upper,
        f"{style.engineering(fine, 'Pa')} at the mandrel, capacity {capacity}; "
        f"the thesis's grid (one row per wrap) gives {abs(100 * (coarse / fine - 1)):.1f} % "
        f"{'more' if coarse > fine else 'less'}",
    )
    return upper


def plot_soft_and_hard(members: Sequence[StudyCase], ax: Axes | None = None) -> Axes:
    """Plot pressure divided by winding tension versus radius, one line per radial modulus (thesis, Fig 2.4).

    Raises
    ------
    InputError
        If no case has a radial modulus in the grid, or a Dataset holds no wound roll.
    """
    grid = grid_cases(members, "winding_hardness", MODULUS)
    for m in grid:
        style.require(m.data, (*_STRESS, "radial_modulus_pa"), "figure of soft and hard rolls")
    grid.sort(key=lambda m: -float(m.data["radial_modulus_pa"].mean()))
    ax = style.axes(ax)
    for m, colour in zip(grid, (style.RED, style.BLUE, style.GREEN, style.ORANGE, style.PURPLE), strict=False):
        r, tension = m.data["r"].values, m.data.attrs["tension_stress_pa"]
        ax.plot(r / r[0], m.data["pressure_pa"] / tension, color=colour, lw=1.8, label=_law(m))
        ax.plot(1.0, m.data["pressure_pa"].values[0] / tension, "o", color=colour, ms=5, clip_on=False, zorder=5)
    ax.set_xlim(1.0, max(float(m.data["r"][-1] / m.data["r"][0]) for m in grid))
    ax.set_ylim(0.0, None)
    ax.set_xlabel("Radius / mandrel radius (–)")
    ax.set_ylabel("Pressure / winding tension (–)")
    ax.legend(fontsize=8, title="Radial modulus of the stack", title_fontsize=8)
    at_core = [float(m.data["pressure_pa"].values[0]) for m in grid]
    slopes = [middle_slope(m.data) for m in grid]
    style.title(
        ax,
        f"The softest roll has {100 * at_core[-1] / at_core[0]:.0f} % of the hardest one's pressure at the mandrel, "
        f"and {100 * slopes[-1] / slopes[0]:.0f} % of its pressure gradient over the middle half",
    )
    return ax


def _law(member: StudyCase) -> str:
    """Radial modulus of a case as text."""
    modulus: Mapping[str, Any] = member.values[MODULUS]
    if modulus["law"] == "constant":
        ratio = member.data.attrs["web_modulus_pa"] / modulus["E_r"]
        return f"{1e-9 * modulus['E_r']:g} GPa ($E_θ/E_r$ = {ratio:g})"
    if modulus["law"] == "pfeiffer":
        return f"{modulus['K2']:g} ({1e-3 * modulus['K1']:g} kPa + P)"
    return "measured table"


def plot_pressure_over_tension(members: Sequence[StudyCase], ax: Axes | None = None) -> Axes:
    """Plot the pressure at the mandrel and the upper bound of this pressure versus winding tension (thesis, Fig 4.3).

    The upper bound is the pressure at the mandrel if no wrap lost any of its tension (hoop equilibrium).

    Raises
    ------
    InputError
        If no case has a winding tension in the grid, or a Dataset holds no wound roll.
    """
    grid = sorted(grid_cases(members, "winding_tension", TENSION), key=lambda m: float(m.values[TENSION]))
    for m in grid:
        style.require(m.data, _STRESS, "figure of pressure versus tension")
    lines: list[Any] = [key for key in _varied(grid) if key != TENSION]
    ax = style.axes(ax, 4.4)
    ax.axhspan(*(1e-3 * p for p in SIMULATED), color="#E4EEF5", label="preloads simulated in the thesis")
    groups = (
        [(None, grid)]
        if not lines
        else [(v, [m for m in grid if m.values[lines[0]] == v]) for v in values_of(grid, lines[0])]
    )
    for k, (value, group) in enumerate(groups):
        tension = [float(m.values[TENSION]) for m in group]
        text = "pressure at the mandrel" + ("" if value is None else f", {shown(lines[0], value)}")
        read = [1e-3 * m.data.attrs["pressure_mandrel_pa"] for m in group]
        ax.plot(tension, read, color=style.LINES[k], marker=MARKERS[k], ms=5, lw=1.8, label=text)
        if k == 0:
            coarse = [1e-3 * m.data.attrs["pressure_mandrel_wrap_grid_pa"] for m in group]
            bound = [1e-3 * m.data.attrs["hoop_bound_pa"] for m in group]
            ax.plot(tension, coarse, "x", color=style.RED, ms=8, mew=1.4, zorder=4, label="the same, thesis's grid")
            ax.plot(tension, bound, color="black", ls=":", lw=1.4, label="hoop bound: no wrap relaxes")
    ax.set_yscale("log")
    ends = [m.data.attrs["pressure_mandrel_pa"] for m in grid] + [m.data.attrs["hoop_bound_pa"] for m in grid]
    ax.set_ylim(0.5e-3 * min(*ends, SIMULATED[0]), 1.7e-3 * max(*ends, SIMULATED[1]))
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel(axis_label(TENSION))
    ax.set_ylabel("Pressure (kPa)")
    ax.legend(fontsize=8, framealpha=0.9, loc="lower right")
    low, high = grid[0].data.attrs, grid[-1].data.attrs
    style.title(
        ax,
        f"Winding tension {grid[0].values[TENSION]:g} to {grid[-1].values[TENSION]:g} N: pressure on the mandrel "
        f"{low['pressure_mandrel_pa'] / 1e3:.0f} to {high['pressure_mandrel_pa'] / 1e3:.0f} kPa, hoop bound "
        f"{low['hoop_bound_pa'] / 1e3:.0f} to {high['hoop_bound_pa'] / 1e3:.0f} kPa",
    )
    return ax


def _varied(grid: Sequence[StudyCase]) -> list[str]:
    return [key for key in grid[0].values if len(values_of(grid, key)) > 1]


def _scaled(largest: float) -> tuple[float, str]:
    """Scale factor and unit (MPa or kPa) for a stress, given its largest value (Pa)."""
    return (1e-6, "MPa") if largest >= 1e6 else (1e-3, "kPa")
