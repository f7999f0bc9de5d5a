"""Figures of a study, drawn from many cases of one grid.

Every function takes the finished cases of the study and returns an axes, whose title states the result in one
sentence. `FIGURES` lists the values of the grid-file key `figure`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap

from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.convergence import plot_frequency_convergence, plot_friction_convergence
from wroll_fem.plotting.history import plot_response
from wroll_fem.plotting.level_series import plot_damping_over_level
from wroll_fem.plotting.preload_grid import plot_damping_over_preload
from wroll_fem.plotting.shear_stiffness import plot_shear_stiffness, plot_shear_stiffness_band
from wroll_fem.plotting.slip_series import plot_slip_extent, plot_slip_vectors
from wroll_fem.plotting.study import (
    LAYER_BASE,
    MARKERS,
    PRESSURE,
    StudyCase,
    axis_label,
    friction_work,
    grid_cases,
    having,
    is_sweep,
    lines_of,
    natural_frequency,
    percent,
    read,
    scaled,
    shown,
    trend,
    undamped_curve,
    values_of,
)  # fmt: skip
from wroll_fem.plotting.winding import TENSION, plot_pressure_over_tension, plot_soft_and_hard
from wroll_fem.results.dataset import label
from wroll_fem.signals.transmissibility import magnitude

_BLUE_TO_RED = LinearSegmentedColormap.from_list("preload", ["#0072B2", "#3E9CC4", "#9A86A8", "#E08A4A", "#B3380F"])


def _colours(count: int) -> list[Any]:
    return list(_BLUE_TO_RED(np.linspace(0.0, 1.0, count))) if count > 1 else [style.BLUE]


def _base_key(members: Sequence[StudyCase]) -> str | None:
    """Case-file key of the end condition of the layers at the base; None if the study does not vary this condition."""
    return LAYER_BASE if any(LAYER_BASE in m.values for m in members) else None


def _panels(count: int, height: float) -> list[Axes]:
    """Axes of the panels of a new figure, stacked vertically."""
    _, panels = plt.subplots(
        count, 1, figsize=(style.WIDTH, 0.4 + height * count), dpi=style.DPI, layout="constrained", squeeze=False
    )
    return [style.axes(ax) for ax in panels[:, 0]]


def plot_curves(
    members: Sequence[StudyCase],
    *,
    colour: str,
    panel: str | None = None,
    sentence: Callable[[Sequence[StudyCase]], str] | None = None,
    figure: str = "curves",
) -> Axes:
    """Plot transmissibility curves of a study: one colour per value of one key, one panel per value of another key.

    Parameters
    ----------
    members
        Finished cases. Sweeps are solid lines, steady-state curves of the same case are dashed in the same colour. The
        reference (a modal analysis) is a black dashed line.
    colour, panel
        Dotted keys that select the colour and the panel.
    sentence
        Function that returns the title; by default the title gives the range of the resonance frequencies.
    figure
        Name of the figure in error messages.

    Raises
    ------
    InputError
        If no case has the keys, or a case has no curve.
    """
    keys = [colour] + ([panel] if panel is not None else [])
    grid = grid_cases(members, figure, *keys)
    values = values_of(grid, colour)
    panel_values = values_of(grid, panel) if panel is not None else [None]
    panels = _panels(len(panel_values), 3.9 if len(panel_values) == 1 else 3.1)
    references = [m for m in members if m.reference]
    for ax, panel_value in zip(panels, panel_values, strict=True):
        here = having(grid, panel, panel_value) if panel is not None else grid
        top = _draw_curves(ax, here, colour, values)
        ends = ax.get_xlim()
        for m in references:
            frequency = np.linspace(*ends, 2000)
            text = f"mandrel alone, undamped: {natural_frequency(m):.1f} Hz"
            ax.plot(frequency, undamped_curve(m, frequency), color="black", lw=1.2, ls=(0, (5, 2)), label=text)
        ax.set_xlim(ends)
        ax.set_ylim(0.0, 1.1 * top)
        ax.set_ylabel("Transmissibility |T| (–)")
        ax.legend(fontsize=7.5, framealpha=0.9, title=shown(panel, panel_value) if panel else None, title_fontsize=8)
    panels[-1].set_xlabel(label("frequency"))
    said = sentence(grid) if sentence is not None else _range_of_resonance(grid, colour, panel)
    style.title(panels[0], said)
    return panels[0]


def _draw_curves(ax: Axes, members: Sequence[StudyCase], key: str, values: Sequence[Any]) -> float:
    """Draw one panel of `plot_curves`; return the largest value of its curves."""
    top = 0.0
    swept = any(is_sweep(m) for m in members)
    dash = (0, (3, 1.5))
    for value, shade in zip(values, _colours(len(values)), strict=True):
        for m in having(members, key, value):
            found, size = read(m), magnitude(m.data).values
            damping = "rings" if found.rings else f"ζ = {percent(found.zeta)}"
            text = f"{shown(key, value)}: {found.f_n:.1f} Hz, {damping}"
            if is_sweep(m) or not swept:
                ax.plot(m.data["frequency"], size, color=shade, lw=1.6, label=text)
                ax.plot(found.f_n, found.peak, "o", color=shade, ms=4, mec="black", mew=0.5)
            else:
                ax.plot(m.data["frequency"], size, color=shade, lw=1.1, ls=dash)
            top = max(top, float(np.nanmax(size)))
    if swept and not all(is_sweep(m) for m in members):
        ax.plot([], [], color=style.GREY, lw=1.1, ls=dash, label="steady state, harmonic balance")
    ax.margins(x=0.0)
    ax.autoscale_view()
    return top


def _range_of_resonance(grid: Sequence[StudyCase], key: str, panel: str | None) -> str:
    """Title, one clause per panel: "Free base: resonance rises from 133.6 Hz (10 kPa) to 158.5 Hz (300 kPa)"."""
    parts = []
    for panel_value in values_of(grid, panel) if panel is not None else [None]:
        here = [m for m in (having(grid, panel, panel_value) if panel else grid) if is_sweep(m)]
        here = sorted(here, key=lambda m: values_of(grid, key).index(m.values[key]))
        if not here:
            continue
        f = [read(m).f_n for m in here]
        first, last = (shown(key, here[k].values[key]) for k in (0, -1))
        word = {"rises": "rises", "falls": "falls"}.get(trend(f), "changes")
        where = f"{shown(panel, panel_value)}: " if panel is not None else ""
        parts.append(f"{where}resonance {word} from {f[0]:.1f} Hz ({first}) to {f[-1]:.1f} Hz ({last})")
    text = "; ".join([*parts, *_agreement(grid)])
    return text[:1].upper() + text[1:]


def _by_pressure(members: Sequence[StudyCase]) -> list[StudyCase]:
    return sorted(members, key=lambda m: m.values[PRESSURE])


def _agreement(grid: Sequence[StudyCase]) -> list[str]:
    """Clause of the title on the difference between sweep and steady-state peaks; empty if no case has both."""
    peaks: dict[str, list[float]] = {}
    for m in grid:
        same = {key: value for key, value in m.values.items() if key != "analysis"}
        peaks.setdefault(json.dumps(same, sort_keys=True), []).append(read(m).peak)
    pairs = [pair for pair in peaks.values() if len(pair) == 2]
    if not pairs:
        return []
    worst = max(max(pair) / min(pair) - 1.0 for pair in pairs)
    return [f"peaks of sweep and harmonic balance agree to {100 * worst:.1f} %"]


def plot_damping_over_frequency(
    members: Sequence[StudyCase], ax: Axes | None = None, *, line: str | None = None
) -> Axes:
    """Plot damping versus resonance frequency, one point per preload and one line per value of a key.

    The figure corresponds to Figs 4.5 and 5.8 of the thesis.

    Parameters
    ----------
    members
        Finished cases of a study that varies `preload.pressure`.
    ax
        Axes to draw in; a new figure if None.
    line
        Dotted key with one line per value; by default `coil.base` if the study varies it.

    Raises
    ------
    InputError
        If no case has the keys.
    """
    grid = grid_cases(members, "damping_over_frequency", PRESSURE, *([line] if line is not None else []))
    line = line if line is not None else _base_key(grid)
    ax = style.axes(ax, 4.4)
    said = []
    for k, (text, group) in enumerate(lines_of(grid, line).items()):
        group = [m for m in _by_pressure(group) if np.isfinite(read(m).zeta)]
        found = [read(m) for m in group]
        f, zeta = [r.f_n for r in found], [100 * r.zeta for r in found]
        shade = style.LINES[k % len(style.LINES)]
        ax.plot(f, zeta, marker=MARKERS[k % 6], color=shade, ms=5, lw=1.2, label=text or None)
        for m, x, y in zip(group, f, zeta, strict=True):
            if k == 0:
                ax.annotate(
                    shown(PRESSURE, m.values[PRESSURE]), (x, y), (5, 4), textcoords="offset points", fontsize=7.5
                )
        ringing = np.array([r.rings for r in found], dtype=bool)
        if ringing.any():
            ax.plot(
                np.array(f)[ringing], np.array(zeta)[ringing], MARKERS[k % 6], color=shade, mfc="white", ms=5, zorder=3,
                label=f"{text}{', ' if text else ''}rings: no damping",
            )  # fmt: skip
        if not ringing.all():
            best = int(np.argmax(np.where(ringing, -np.inf, zeta)))
            at = shown(PRESSURE, group[best].values[PRESSURE])
            where = f"{text}: " if text else ""
            said.append(f"{where}largest damping {zeta[best]:.2f} % at {at} and {f[best]:.1f} Hz")
    for m in members:
        if m.reference:
            f_m = natural_frequency(m)
            ax.axvline(f_m, color="black", lw=1.0, ls=(0, (5, 2)), label=f"mandrel alone, {f_m:.1f} Hz")
    ax.margins(0.08)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel("Resonance $f_n$ (Hz)")
    ax.set_ylabel("Damping ratio ζ, half power (%)")
    if ax.get_legend_handles_labels()[1]:
        ax.legend(fontsize=8, framealpha=0.9)
    text = "; ".join(said)
    style.title(ax, text[:1].upper() + text[1:])
    return ax


def plot_friction_over_preload(members: Sequence[StudyCase], ax: Axes | None = None) -> Axes:
    """Plot the friction work of each sweep versus preload, one line per end condition of the layers (thesis, Fig 4.7).

    Raises
    ------
    InputError
        If no case has a value of `preload.pressure`.
    """
    grid = [m for m in grid_cases(members, "friction_over_preload", PRESSURE) if is_sweep(m)]
    ax = style.axes(ax, 4.2)
    said = []
    line = _base_key(grid)
    for k, (text, group) in enumerate(lines_of(grid, line).items()):
        group = _by_pressure(group)
        work = [1e3 * friction_work(m) for m in group]
        x = [scaled(PRESSURE, m.values[PRESSURE]) for m in group]
        ax.plot(x, work, marker=MARKERS[k], color=style.LINES[k], ms=5, lw=1.4, label=text or None)
        first, last = (shown(PRESSURE, group[j].values[PRESSURE]) for j in (0, -1))
        word = {"rises": "rises", "falls": "falls"}.get(trend(work), "changes both ways")
        where = f"{text}: " if text else ""
        said.append(f"{where}friction work {word} from {work[0]:.3g} mJ at {first} to {work[-1]:.3g} mJ at {last}")
    ax.set_xscale("log")
    ticks = [scaled(PRESSURE, value) for value in values_of(grid, PRESSURE)]
    ax.set_xticks(ticks, [f"{tick:.4g}" for tick in ticks])
    ax.minorticks_off()
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel(axis_label(PRESSURE))
    ax.set_ylabel("Friction work of the sweep $E_F$ (mJ)")
    if line is not None:
        ax.legend(fontsize=8, framealpha=0.9)
    text = "; ".join(said)
    style.title(ax, text[:1].upper() + text[1:])
    return ax


def plot_friction_over_damping(members: Sequence[StudyCase], ax: Axes | None = None) -> Axes:
    """Plot the friction work of each sweep versus damping ratio, one point per preload (thesis, Fig 4.8).

    If the study varies the end condition of the layers at the base, only cases with a free end are drawn.

    Raises
    ------
    InputError
        If fewer than two sweeps have a damping estimate.
    """
    grid = [m for m in grid_cases(members, "friction_over_damping", PRESSURE) if is_sweep(m)]
    grid = _by_pressure([m for m in having(grid, LAYER_BASE, "free") if np.isfinite(read(m).zeta)])
    if len(grid) < 2:
        problem = "the figure friction_over_damping needs at least two sweeps with a damping estimate"
        raise InputError(problem, remedy="add cases with other preloads")
    ax = style.axes(ax, 4.2)
    zeta, work = [100 * read(m).zeta for m in grid], [1e3 * friction_work(m) for m in grid]
    ax.plot(zeta, work, color="#BBBBBB", lw=1.0, zorder=1)
    ax.scatter(zeta, work, c=_colours(len(grid)), s=40, edgecolors="black", linewidths=0.6, zorder=3)
    names = [shown(PRESSURE, m.values[PRESSURE]) for m in grid]
    for name, x, y in zip(names, zeta, work, strict=True):
        ax.annotate(name, (x, y), (6, 5), textcoords="offset points", fontsize=8)
    ax.set_xlabel("Damping ratio ζ, half power (%)")
    ax.set_ylabel("Friction work of the sweep $E_F$ (mJ)")
    ax.margins(0.12)
    r = float(np.corrcoef(work, zeta)[0, 1])
    style.title(
        ax,
        f"Friction work and damping correlate with r = {r:.2f}; most damping at {names[int(np.argmax(zeta))]}, "
        f"most friction work at {names[int(np.argmax(work))]}",
    )
    return ax


def plot_friction_along_sweep(members: Sequence[StudyCase]) -> Axes:
    """Plot tip acceleration and friction work during the sweep for the lowest and highest preload (thesis, Fig 4.6).

    Raises
    ------
    InputError
        If no case has a value of `preload.pressure`.
    """
    grid = [m for m in grid_cases(members, "friction_along_sweep", PRESSURE) if is_sweep(m)]
    grid = _by_pressure(having(grid, LAYER_BASE, "free"))
    drawing = plt.figure(figsize=(style.WIDTH, 7.2), dpi=style.DPI, layout="constrained")
    pair = [grid[0], grid[-1]]
    first: list[Axes] = []
    for part, m in zip(np.ravel(drawing.subfigures(2, 1)), pair, strict=True):
        ax = plot_response(m.data, style.axes(part.subplots()))
        said = ax.get_title(loc="left").replace("\n", " ")
        style.title(ax, f"{shown(PRESSURE, m.values[PRESSURE])}: {said[:1].lower()}{said[1:]}")
        first.append(ax)
    limit = max(ax.get_ylim()[1] for ax in first)
    for ax in first:
        ax.set_ylim(-limit, limit)
    return first[0]


def plot_integrators(members: Sequence[StudyCase]) -> Axes:
    """Plot the transmissibility of one case, one curve per time integration scheme (thesis, Fig B.3)."""
    key = "integrator.scheme"

    def sentence(grid: Sequence[StudyCase]) -> str:
        peaks = {m.values[key]: read(m).peak for m in grid}
        hht = {name: peak for name, peak in peaks.items() if name != "quasi_static"}
        text = f"Peaks of the HHT schemes lie within {100 * (max(hht.values()) / min(hht.values()) - 1):.1f} %"
        if "quasi_static" in peaks:
            text += f"; backward Euler (quasi-static) reaches {100 * peaks['quasi_static'] / max(hht.values()):.0f} %"
        return text + " of the highest" if "quasi_static" in peaks else text

    return plot_curves(members, colour=key, sentence=sentence, figure="integrators")


def plot_friction_laws(members: Sequence[StudyCase]) -> Axes:
    """Plot one transmissibility curve per preload, in one panel per friction law (thesis, Fig E.25)."""

    def sentence(grid: Sequence[StudyCase]) -> str:
        files = values_of(grid, "case")
        worst = 0.0
        for value in values_of(grid, PRESSURE):
            peaks = [read(m).peak for m in grid if m.values[PRESSURE] == value and is_sweep(m)]
            worst = max(worst, max(peaks) / min(peaks) - 1) if peaks else worst
        names = " and ".join(str(name).replace("_", " ") for name in files)
        return f"The peaks of {names} differ by at most {100 * worst:.1f} % at any preload"

    return plot_curves(members, colour=PRESSURE, panel="case", sentence=sentence, figure="friction_laws")


def _preload(members: Sequence[StudyCase]) -> Axes:
    return plot_curves(members, colour=PRESSURE, panel=_base_key(members), figure="transmissibility_over_preload")


FIGURES: dict[str, Callable[[Sequence[StudyCase]], Axes]] = {
    "transmissibility_over_preload": _preload,
    "damping_over_frequency": plot_damping_over_frequency,
    "damping_over_preload": plot_damping_over_preload,
    "friction_along_sweep": plot_friction_along_sweep,
    "friction_over_preload": plot_friction_over_preload,
    "friction_over_damping": plot_friction_over_damping,
    "slip_extent": plot_slip_extent,
    "slip_vectors": plot_slip_vectors,
    "layer_count": partial(plot_damping_over_frequency, line="coil.layers"),
    "layer_modulus": partial(plot_damping_over_frequency, line="coil.material.E"),
    "elastic_slip": partial(plot_curves, colour="contact.friction.elastic_slip", panel=PRESSURE, figure="elastic_slip"),
    "integrators": plot_integrators,
    "mesh_friction": plot_friction_convergence,
    "mesh_frequency": plot_frequency_convergence,
    "friction_laws": plot_friction_laws,
    "transmissibility_over_tension": partial(plot_curves, colour=TENSION, figure="transmissibility_over_tension"),
    "shear_stiffness": plot_shear_stiffness,
    "shear_stiffness_band": plot_shear_stiffness_band,
    "winding_hardness": plot_soft_and_hard,
    "winding_tension": plot_pressure_over_tension,
    "damping_over_level": plot_damping_over_level,
}
"""Value of the key `figure` of a grid file -> function that draws this figure from the finished cases."""
