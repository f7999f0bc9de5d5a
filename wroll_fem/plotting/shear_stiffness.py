"""Figures of the bending frequency of a solid coil versus shear stiffness between wraps (thesis, Figs. 2.13, 2.17)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from wroll_fem.bodies.mode_shapes import main_bending
from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.study import StudyCase, grid_cases, having, shown, values_of
from wroll_fem.typing import FloatArray

SHEAR, MODULUS = "coil.material.G_r_theta", "coil.material.E_theta"


def bending_mode(member: StudyCase) -> tuple[float, int]:
    """Frequency (Hz) and mode number of the bending mode with the largest effective mass.

    The lowest mode has the number 1; a degenerate pair counts once.

    Raises
    ------
    InputError
        If the computed modes include no bending mode.
    """
    style.require(member.data, ("mode_frequency", "mode_kind", "effective_mass_fraction"), "figure of frequencies")
    frequency = member.data["mode_frequency"].values
    index = main_bending(member.data["mode_kind"].values.tolist(), member.data["effective_mass_fraction"].values)
    if index is None:
        raise InputError(f"the modes of {member.name} include no bending mode", key="modal.count", remedy="increase it")
    below = frequency[:index][frequency[:index] < (1 - 1e-5) * frequency[index]]
    return float(frequency[index]), 1 + int(np.count_nonzero(np.diff(below, prepend=0.0) > 1e-5 * below))


def _curve(group: Sequence[StudyCase]) -> tuple[FloatArray, FloatArray, list[int]]:
    """Shear stiffness (Pa, ascending), bending frequency (Hz) and mode number of each case."""
    ordered = sorted(group, key=lambda m: m.values[SHEAR])
    found = [bending_mode(m) for m in ordered]
    return np.array([m.values[SHEAR] for m in ordered]), np.array([f for f, _ in found]), [n for _, n in found]


def _reference(members: Sequence[StudyCase], figure: str, what: str) -> float:
    found = [bending_mode(m)[0] for m in members if m.reference]
    if not found:
        raise InputError(
            f"the figure {figure} needs the reference case of {what}", key="reference", remedy="add this case"
        )
    return found[0]


def _log_axis(ax: Axes) -> None:
    ax.set_xscale("log")
    ax.set_xlabel("Shear stiffness between wraps $G_{rz} = G_{r\\theta}$ (Pa)")


def crossing(x: FloatArray, y: FloatArray, level: float) -> float:
    """First x at which the ascending y crosses a level, interpolated in log x; nan if it does not cross the level."""
    above = np.flatnonzero(y >= level)
    if above.size == 0 or above[0] == 0:
        return np.nan
    k = int(above[0])
    share = (level - y[k - 1]) / (y[k] - y[k - 1])
    return float(np.exp(np.log(x[k - 1]) + share * np.log(x[k] / x[k - 1])))


def plot_shear_stiffness(members: Sequence[StudyCase], ax: Axes | None = None) -> Axes:
    """Plot the bending frequency versus the shear stiffness between wraps (thesis, Fig. 2.13).

    The frequency is divided by that for a coil with mass but without stiffness. Open symbols mark cases in which other
    modes are lower than the bending mode.

    Raises
    ------
    InputError
        If there are fewer than two finished cases, or no reference.
    """
    grid = grid_cases(members, "shear_stiffness", SHEAR)
    mass_alone = _reference(members, "shear_stiffness", "the coil as mass without stiffness")
    ax = style.axes(ax, 4.2)
    x, f, number = _curve(grid)
    if x.size < 2:
        problem, remedy = "a curve needs at least two finished cases", "give two or more values of the key"
        raise InputError(problem, key=f"grid.{SHEAR}", remedy=remedy)
    ax.plot(x, f / mass_alone, color=style.BLUE, lw=1.4, zorder=2)
    lowest = np.array(number) == 1
    for mask, face, text in (
        (lowest, style.BLUE, "bending is the lowest mode"),
        (~lowest, "white", "other modes are lower"),
    ):
        if mask.any():
            ax.plot(
                x[mask], f[mask] / mass_alone, "o", ms=5.5, color=style.BLUE, markerfacecolor=face, label=text, zorder=3
            )
    ax.axhline(1.0, color=style.RED, lw=1.3, label=f"coil as mass alone, {mass_alone:.1f} Hz")
    _log_axis(ax)
    ax.set_ylabel("Bending frequency / mass alone (–)")
    ax.legend(fontsize=8, loc="upper left")
    slope = np.gradient(np.log(f), np.log(x))
    style.title(
        ax,
        f"Bending at {f[0]:.1f} Hz with the softest and {f[-1]:.1f} Hz with the stiffest coil, {f[0] / mass_alone:.2f} "
        f"and {f[-1] / mass_alone:.2f} times mass alone; steepest near {style.engineering(x[slope.argmax()], 'Pa')}",
    )
    return ax


def plot_shear_stiffness_band(members: Sequence[StudyCase], ax: Axes | None = None) -> Axes:
    """Plot the bending frequency versus shear stiffness, one curve per in-plane modulus (thesis, Fig. 2.17).

    A horizontal line shows the frequency of the mandrel alone. Open symbols mark cases in which other modes are lower
    than the bending mode.

    Raises
    ------
    InputError
        If there is no finished case, or no reference.
    """
    grid = grid_cases(members, "shear_stiffness_band", SHEAR, MODULUS)
    mandrel = _reference(members, "shear_stiffness_band", "the mandrel alone")
    ax = style.axes(ax, 4.2)
    curves = {shown(MODULUS, value): _curve(having(grid, MODULUS, value)) for value in values_of(grid, MODULUS)}
    low, high = (next(iter(curves.values())), list(curves.values())[-1])
    if len(curves) > 1 and np.array_equal(low[0], high[0]):
        ax.fill_between(low[0], low[1], high[1], color="#DCE9F3", zorder=1)
    for k, (text, (x, f, number)) in enumerate(curves.items()):
        colour, lowest = style.LINES[2 * k % len(style.LINES)], np.array(number) == 1
        ax.plot(x, f, color=colour, lw=1.4, label=f"$E$ = {text}")
        ax.plot(x[lowest], f[lowest], "o", ms=4.5, color=colour)
        ax.plot(x[~lowest], f[~lowest], "o", ms=4.5, color=colour, markerfacecolor="white")
    if any(n > 1 for _, _, number in curves.values() for n in number):
        ax.plot([], [], "o", ms=4.5, color=style.GREY, markerfacecolor="white", label="other modes are lower")
    ax.axhline(mandrel, color=style.RED, lw=1.3, label=f"mandrel alone, {mandrel:.1f} Hz")
    _log_axis(ax)
    ax.set_ylabel("Bending frequency (Hz)")
    ax.legend(fontsize=8, loc="upper left")
    meets = [crossing(x, f, mandrel) for x, f, _ in curves.values()]
    spans = [f"{f[-1] - f[0]:.0f} Hz" for _, f, _ in curves.values()]
    where = " and ".join(style.engineering(x, "Pa") for x in meets if np.isfinite(x)) or "no shear stiffness"
    style.title(
        ax,
        f"With $E$ = {' and '.join(curves)} the roll reaches the mandrel's frequency at {where}; from the softest to "
        f"the stiffest coil it gains {' and '.join(spans)}",
    )
    return ax
