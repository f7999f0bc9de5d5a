"""Pictures of appendix C; made by tools/appendix_c.py."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from appendix_c import BAND, CAPACITIES, DWELLS, SCALES

from wroll_fem.plotting import style


def figures(found: dict[str, np.ndarray], folder: Path) -> None:
    """Figures C.1 and C.2, and the difference that s makes where the masses stick."""
    sign(folder / "appendix_c_sign.png")
    responses(found, folder / "appendix_c_response.png")
    differences(found, folder / "appendix_c_scale.png")


def sign(path: Path) -> None:
    """Figure C.1."""
    ax = style.axes(None)
    x = np.linspace(-6.0, 6.0, 1201)
    for scale, colour in zip(SCALES, style.LINES, strict=False):
        ax.plot(x, np.tanh(0.5 * scale * x), color=colour, lw=1.6, label=f"S({scale:g} x)")
    ax.plot([-6, 0, 0, 6], [-1, -1, 1, 1], color="black", lw=1.0, ls="--", label="sgn(x)")
    ax.set_xlabel("Relative velocity x (–)")
    ax.set_ylabel("Smoothed sign S(s x) (–)")
    ax.legend(fontsize=8)
    style.title(ax, "The smoothed sign is a viscous damper of slope s/2 below |x| = 1/s and reaches 0.987 at |x| = 5/s")
    style.save_figure(ax, path)


def responses(found: dict[str, np.ndarray], path: Path) -> None:
    """Figure C.2."""
    size = (style.WIDTH, 6.4)
    figure, panels = plt.subplots(2, 2, figsize=size, dpi=style.DPI, layout="constrained", sharex=True, sharey=True)
    shades = plt.get_cmap("coolwarm")(np.linspace(0.0, 1.0, len(CAPACITIES)))
    runs = len(CAPACITIES) * len(DWELLS)
    for ax, scale in zip(panels.flat, SCALES, strict=True):
        style.axes(ax)
        wrong = 0
        for capacity, colour in zip(CAPACITIES, shades, strict=True):
            key = f"{capacity:g}_{scale:g}"
            ax.semilogy(found[f"grid_{key}"], found[f"orbit_{key}"], color=colour, lw=1.2, label=f"{capacity:g}")
            ax.semilogy(DWELLS, found[f"loose_{key}"], ".", color=colour, ms=3.5, mec="black", mew=0.25)
            wrong += int(np.sum(np.abs(found[f"loose_{key}"] / found[f"tight_{key}"] - 1.0) > 0.01))
        ax.set_title(f"s = {scale:g}: {wrong} of {runs} runs are off by more than 1 %", loc="left", fontsize=9)
    panels[0, 0].set_xlim(0.75, 1.4)
    panels[0, 0].set_ylim(0.8, 600.0)
    panels[0, 1].legend(title="$F_c$", fontsize=7, title_fontsize=8, ncols=2)
    figure.supxlabel(r"Frequency $\omega$ (–)", fontsize=10)
    figure.supylabel("Transmissibility max|x$_1$| / Y$_0$ (–)", fontsize=10)
    text = (
        "Converged orbits (lines) are smooth at every s; the spikes are runs over 6 $\\tau$ with ode45's default\n"
        "tolerance (dots), more of them with preload and with s"
    )
    figure.suptitle(text, x=0.01, ha="left", fontsize=10)
    style.save_figure(panels[0, 0], path)


def differences(found: dict[str, np.ndarray], path: Path) -> None:
    """How far s = 1, 2, 5 are from s = 10."""
    ax = style.axes(None)
    for capacity, dash in ((50.0, "-"), (100.0, "--")):
        best = found[f"band_{capacity:g}_10"]
        for scale, colour in zip(SCALES[:-1], style.LINES, strict=False):
            difference = np.abs(found[f"band_{capacity:g}_{scale:g}"] / best - 1.0)
            text = f"$F_c$ = {capacity:g}, s = {scale:g}"
            ax.semilogy(BAND, np.maximum(difference, 1e-7), color=colour, ls=dash, lw=1.3, label=text)
    ax.axhline(1e-3, color="black", lw=0.8)
    ax.set_xlabel(r"Frequency $\omega$ (–)")
    ax.set_ylabel("Difference of the amplitude from s = 10 (–)")
    ax.legend(fontsize=8)
    style.title(
        ax,
        "Away from the resonance of the stuck masses the scale s changes the response by less than 0.1 %, "
        "at its peak by per cents",
    )
    style.save_figure(ax, path)
