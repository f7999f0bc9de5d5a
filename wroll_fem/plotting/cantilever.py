"""Figure of the cantilevered mandrel: shear force and bending moment versus height, stresses around the root."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from wroll_fem.bodies.beam import Cantilever
from wroll_fem.plotting import style


def plot_cantilever(beam: Cantilever) -> Axes:
    """Plot bending moment and shear force versus height, and their stresses around the root (thesis, Figs 2.8 and 2.9).

    Each curve is divided by its largest value. The title gives the largest bending stress and the largest shear stress.

    Returns
    -------
    Axes
        The upper axes.
    """
    _, (upper, lower) = plt.subplots(2, 1, figsize=(style.WIDTH, 6.2), dpi=style.DPI, layout="constrained")
    style.axes(upper)
    style.axes(lower)
    z = np.linspace(0.0, beam.length, 200)
    for values, colour, text in (
        (beam.moment(z), style.BLUE, "moment M"), (beam.shear_force(z), style.RED, "shear force V"),
    ):  # fmt: skip
        upper.plot(z / beam.length, values / values[0], color=colour, lw=1.8, label=text)
    upper.set_xlabel("Height / length (–)")
    upper.set_ylabel("Value / value at the root (–)")
    upper.set_xlim(0.0, 1.0)
    upper.set_ylim(0.0, 1.05)
    upper.legend(fontsize=8)
    theta = np.linspace(-np.pi, np.pi, 361)
    bending, shear = np.abs(beam.bending_stress(theta, 0.0)), np.abs(beam.shear_stress(theta, 0.0))
    lower.plot(np.degrees(theta), bending / bending.max(), color=style.BLUE, lw=1.8, label="bending stress, outer face")
    lower.plot(np.degrees(theta), shear / shear.max(), color=style.RED, lw=1.8, label="transverse shear stress")
    lower.set_xlabel("Angle from the direction of the load (°); neutral axis at ±90°")
    lower.set_ylabel("Stress at the root / largest value (–)")
    lower.set_xlim(-180.0, 180.0)
    lower.set_xticks(np.arange(-180, 181, 45))
    lower.set_ylim(0.0, 1.2)
    lower.legend(fontsize=8, loc="upper center", ncols=2, framealpha=0.95)
    force, couple = float(beam.shear_force(0.0)), float(beam.moment(0.0))
    style.title(
        upper,
        f"Root, M = {couple:.3g} N m, V = {force:.3g} N: bending stress {style.engineering(bending.max(), 'Pa')} "
        f"at 0° and ±180°, transverse shear stress {style.engineering(shear.max(), 'Pa')} at the neutral axis",
    )
    return upper
