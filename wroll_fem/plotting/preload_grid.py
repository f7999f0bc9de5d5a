"""Figure of a study of preload, friction and excitation level: damping ratio and resonance frequency of each case."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.plotting.study import (
    MARKERS,
    PRESSURE,
    StudyCase,
    axis_label,
    grid_cases,
    having,
    percent,
    read,
    scaled,
    shown,
    values_of,
)

FRICTION, LEVEL = "contact.friction.mu", "excitation.amplitude"


def plot_damping_over_preload(members: Sequence[StudyCase]) -> Axes:
    """Plot damping and frequency versus preload: one line per friction coefficient, one column per excitation level.

    Parameters
    ----------
    members
        Finished cases with `preload.pressure` and `contact.friction.mu`; `excitation.amplitude` where it varies.

    Returns
    -------
    Axes
        The first panel.

    Raises
    ------
    InputError
        When no case has these keys.
    """
    grid = grid_cases(members, "damping_over_preload", PRESSURE, FRICTION)
    levels = values_of(grid, LEVEL) or [None]
    size = (max(style.WIDTH, 1.2 + 3.4 * len(levels)), 5.6)
    _, panels = plt.subplots(
        2, len(levels), figsize=size, dpi=style.DPI, layout="constrained", squeeze=False, sharex=True, sharey="row"
    )
    coefficients = values_of(grid, FRICTION)
    shades = colormaps["viridis"](np.linspace(0.0, 0.85, len(coefficients)))
    ticks = [scaled(PRESSURE, value) for value in values_of(grid, PRESSURE)]
    for column, level in zip(panels.T, levels, strict=True):
        here = grid if level is None else having(grid, LEVEL, level)
        for k, (mu, shade) in enumerate(zip(coefficients, shades, strict=True)):
            line = sorted(having(here, FRICTION, mu), key=lambda m: float(m.values[PRESSURE]))
            x, found = [scaled(PRESSURE, m.values[PRESSURE]) for m in line], [read(m) for m in line]
            rows = ([100.0 * r.zeta for r in found], [r.f_n for r in found])
            for ax, y in zip(column, rows, strict=True):
                ax.plot(x, y, marker=MARKERS[k % 6], color=shade, ms=4.5, lw=1.3, label=f"{mu:g}")
        for ax in column:
            style.axes(ax)
            ax.set_xscale("log")
            ax.set_xticks(ticks, [f"{tick:.4g}" for tick in ticks])
            ax.minorticks_off()
        column[1].set_xlabel(axis_label(PRESSURE))
        if level is not None:
            column[0].set_title(f"base at {level:g} m/s² (0-peak)", fontsize=9, loc="left")
    first: Axes = panels[0, 0]
    first.set_ylim(bottom=0.0)  # of the row: after all lines
    first.set_ylabel("Damping ratio ζ (%)")
    panels[1, 0].set_ylabel("Resonance $f_n$ (Hz)")
    panels[1, 0].legend(title="friction coefficient", fontsize=8, title_fontsize=8, framealpha=0.9)
    readable = [m for m in grid if np.isfinite(read(m).zeta)]
    if readable:
        top = max(readable, key=lambda m: read(m).zeta)
        at = [shown(PRESSURE, top.values[PRESSURE]), f"a friction coefficient of {top.values[FRICTION]:g}"]
        at += [f"{top.values[LEVEL]:g} m/s²"] if LEVEL in top.values else []
        sentence = f"Largest damping, {percent(read(top).zeta)}, at {', '.join(at)}"
        first.figure.suptitle(sentence, fontsize=11, x=0.01, ha="left")
    return first
