"""Figures of mesh studies: convergence of the response with friction, and of the first bending frequency."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.plotting.study import (
    MARKERS,
    StudyCase,
    axis_label,
    friction_work,
    grid_cases,
    lines_of,
    read,
    shown,
    values_of,
)

AXIAL, AROUND, GRADING = "mesh.axial", "mesh.circumferential", "mesh.grading"


def plot_friction_convergence(members: Sequence[StudyCase]) -> Axes:
    """Plot resonance, peak, damping and friction work versus the number of axial elements, one line per mesh grading.

    Raises
    ------
    InputError
        If no case has a value of `mesh.axial`.
    """
    key = AXIAL
    grid = grid_cases(members, "mesh_friction", key)
    line = GRADING if len(values_of(grid, GRADING)) > 1 else None
    figure, panels = plt.subplots(2, 2, figsize=(style.WIDTH, 6.0), dpi=style.DPI, layout="constrained", sharex=True)
    readings: list[tuple[str, Callable[[StudyCase], float]]] = [
        ("Resonance $f_n$ (Hz)", lambda m: read(m).f_n),
        ("Peak transmissibility (–)", lambda m: read(m).peak),
        ("Damping ratio ζ (%)", lambda m: 100 * read(m).zeta),
        ("Friction work (mJ)", lambda m: 1e3 * friction_work(m)),
    ]
    groups = {text: sorted(g, key=lambda m: m.values[key]) for text, g in lines_of(grid, line).items()}
    for ax, (name, value) in zip(panels.ravel(), readings, strict=True):
        style.axes(ax)
        for k, (text, group) in enumerate(groups.items()):
            x = [m.values[key] for m in group]
            y = [value(m) for m in group]
            ax.plot(x, y, marker=MARKERS[k], color=style.LINES[k], ms=4.5, lw=1.3, label=text or None)
        ax.set_ylabel(name)
    for ax in panels[1]:
        ax.set_xlabel(axis_label(key))
    if line is not None:
        panels[0, 0].legend(fontsize=8)
    finest = groups[list(groups)[-1]][-1]
    coarsest = max(grid, key=lambda m: abs(read(m).peak / read(finest).peak - 1))
    off = 100 * (read(coarsest).peak / read(finest).peak - 1)
    off_f = 100 * (read(coarsest).f_n / read(finest).f_n - 1)
    which = f"{coarsest.values[key]} elements along the axis"
    which += f", {shown(line, coarsest.values[line])}" if line is not None else ""
    said = f"Largest deviation from the finest mesh: peak {off:+.1f} %, resonance {off_f:+.2f} % ({which})"
    figure.suptitle(textwrap.fill(said.replace("-", "−"), 95), x=0.01, ha="left", fontsize=10)
    return panels[0, 0]


def first_bending(member: StudyCase) -> float:
    """Frequency (Hz) of the first bending mode in the results of a modal analysis.

    Raises
    ------
    InputError
        If the Dataset holds no modes.
    """
    style.require(member.data, ("mode_frequency", "mode_kind"), "figure of frequencies")
    bending = [str(kind) == "bending" for kind in member.data["mode_kind"].values]
    return float(member.data["mode_frequency"].values[bending][0])


def plot_frequency_convergence(members: Sequence[StudyCase], ax: Axes | None = None) -> Axes:
    """Plot the first bending frequency versus number of axial elements, for each number of circumferential elements.

    The shaded band is the criterion of the thesis: within 1 % of the frequency of the finest mesh.

    Raises
    ------
    InputError
        If no case has values of `mesh.axial` and `mesh.circumferential`.
    """
    grid = grid_cases(members, "mesh_frequency", AXIAL, AROUND)
    ax = style.axes(ax, 4.2)
    finest = max(grid, key=lambda m: (m.values[AXIAL] * m.values[AROUND], m.values[AXIAL]))
    limit = first_bending(finest)
    ax.axhspan(0.99 * limit, 1.01 * limit, color="#E4EEF5", label="within 1 % of the finest mesh")
    for k, around in enumerate(values_of(grid, AROUND)):
        group = sorted((m for m in grid if m.values[AROUND] == around), key=lambda m: m.values[AXIAL])
        ax.plot(
            [m.values[AXIAL] for m in group], [first_bending(m) for m in group], marker=MARKERS[k], ms=5, lw=1.3,
            color=style.LINES[k], label=shown(AROUND, around),
        )  # fmt: skip
    ax.set_xlabel(axis_label(AXIAL))
    ax.set_ylabel("First bending frequency (Hz)")
    ax.legend(fontsize=8, framealpha=0.9)
    worst = max(grid, key=lambda m: abs(first_bending(m) - limit))
    off = 100 * (first_bending(worst) / limit - 1)
    style.title(
        ax,
        f"Largest deviation from the finest mesh ({limit:.2f} Hz): {off:+.3f} % with {worst.values[AROUND]} elements "
        f"around and {worst.values[AXIAL]} along the axis",
    )
    return ax
