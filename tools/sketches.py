"""Sketch of the roll and picture of the rooms: `.venv/bin/python tools/sketches.py` (seconds, nothing is computed)."""

from __future__ import annotations

import os
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "Agg")

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch, Polygon, Rectangle

from wroll_fem.plotting.style import BLUE, DPI, GREEN, GREY, ORANGE, PURPLE, RED, SKY

FIGURES = Path(__file__).resolve().parents[1] / "docs" / "figures"
INK, TUBE, WEB, PALE = "#222222", "#B8BEC6", "#F3C98B", "#ECEFF2"
SMALL = 8.0

ROOMS = (
    (("errors", "typing", "progress", "blas"), GREY, "what every room may use"),
    (("bodies", "results"), SKY, "bodies, materials; names, units and files of results"),
    (("contact", "signals", "numerics"), GREEN, "friction law at a point; spectra, damping; solvers"),
    (("case",), ORANGE, "the YAML file as typed, frozen sections"),
    (("dynamics",), GREEN, "system, reduction, statics, time stepping, harmonic balance"),
    (("winding", "mesh", "two_dof", "tribology"), SKY, "wound-roll stress; gmsh; small models"),
    (("fem", "plotting", "lab"), PURPLE, "dolfinx (here alone); figures of a Dataset; evaluation of measurements"),
    (("coiled_stiff",), GREEN, "the solid coil: stress of its modes, slip criterion"),
    (("analyses",), ORANGE, "case in, Dataset out; one file per analysis"),
    (("jobs",), BLUE, "run folder, batch, executors, console"),
    (("report", "api"), BLUE, "HTML report; functions of the Python interface"),
    (("result",), BLUE, "result of a run in Python"),
    (("runs",), BLUE, "a method per analysis"),
    (("roll", "own_structure"), BLUE, "roll, and structure with joints, in Python"),
    (("cli",), RED, "the command wroll"),
)
"""Layers of the package, lowest first: rooms, colour, what they hold."""


def arrow(ax: Axes, start: tuple[float, float], end: tuple[float, float], **style: object) -> None:
    """Draw an arrow; `style` overrides a thin black one."""
    words = {"arrowstyle": "-|>", "mutation_scale": 9, "color": INK, "lw": 1.1, "shrinkA": 0, "shrinkB": 0, "zorder": 6}
    ax.add_patch(FancyArrowPatch(start, end, **(words | style)))


def note(ax: Axes, text: str, at: tuple[float, float], to: tuple[float, float] | None = None, **style: object) -> None:
    """Write a label, with a thin leader to the part that it names."""
    words = {"fontsize": SMALL, "color": INK, "va": "center", "zorder": 7} | style
    if to is None:
        ax.text(*at, text, **words)
    else:
        leader = {"arrowstyle": "-", "lw": 0.6, "color": "#555555", "shrinkA": 1, "shrinkB": 0}
        ax.annotate(text, xy=to, xytext=at, arrowprops=leader, **words)


def bare(ax: Axes, x: tuple[float, float], y: tuple[float, float], title: str) -> None:
    """Axes without frame, in equal scale."""
    ax.set(xlim=x, ylim=y, aspect="equal")
    ax.axis("off")
    ax.set_title(title, fontsize=9, loc="left", color=INK)


def section(ax: Axes) -> None:
    """Roll on its base, cut along the axis, with the slip zone at the root."""
    bare(ax, (-5.6, 6.4), (-2.6, 12.6), "(a) Roll on a shaken base")
    radius, wall, layer, pitch, wraps, height = 1.9, 0.22, 0.18, 0.25, 4, 9.4
    ax.add_patch(Rectangle((-4.2, -0.7), 8.4, 0.7, facecolor="#8F969E", edgecolor=INK, lw=0.9, hatch="////", zorder=3))
    for side in (-1, 1):
        low = side * radius if side > 0 else -radius - wall
        ax.add_patch(Rectangle((low, 0), wall, height, facecolor=TUBE, edgecolor=INK, lw=0.8, zorder=4))
        for k in range(wraps):
            inner = radius + wall + 0.07 + k * pitch
            low = inner if side > 0 else -inner - layer
            ax.add_patch(Rectangle((low, 0.12), layer, height - 1.2, facecolor=WEB, edgecolor=INK, lw=0.5, zorder=4))
        for k in range(wraps):  # slip zones shrink outwards
            edge = side * (radius + wall + 0.035 + k * pitch)
            top = 2.9 - 0.55 * k
            wedge = [(edge - 0.075, 0.12), (edge + 0.075, 0.12), (edge, top)]
            ax.add_patch(Polygon(wedge, closed=True, facecolor=RED, lw=0, zorder=5))
    ax.add_patch(Rectangle((-radius - wall, height), 2 * (radius + wall), 0.75, facecolor="#5E666F", edgecolor=INK,
                           lw=0.9, zorder=5))  # fmt: skip
    z = np.linspace(0, height + 0.7, 60)
    shape = 1.9 * (z / z[-1]) ** 2 * (1.5 - 0.5 * z / z[-1])
    ax.plot(shape, z, color=BLUE, lw=1.3, ls=(0, (5, 3)), zorder=6)
    arrow(ax, (0.1, height + 1.55), (2.3, height + 1.55), color=BLUE, arrowstyle="<|-|>")
    note(ax, "tip response", (1.2, height + 2.15), color=BLUE, ha="center")
    arrow(ax, (-3.0, -1.35), (3.0, -1.35), color=RED, arrowstyle="<|-|>", lw=1.8, mutation_scale=13)
    note(ax, "base acceleration $a_g(t)$", (0, -2.1), color=RED, ha="center")
    note(ax, "tip mass", (-5.5, 10.9), (-1.5, height + 0.45))
    note(ax, "mandrel", (-5.5, 8.2), (-radius - 0.5 * wall, 7.2))
    note(ax, "wraps", (-5.5, 5.4), (-2.65, 4.6))
    note(ax, "base", (-5.5, 0.9), (-4.0, -0.25))
    note(ax, "slip near\nthe root", (3.9, 3.6), (2.45, 1.5), color=RED)
    note(ax, "bending\nmode", (3.9, 7.3), (float(np.interp(7.0, z, shape)), 7.0), color=BLUE)
    arrow(ax, (4.9, 0.15), (4.9, 1.5), lw=0.9, mutation_scale=7)
    arrow(ax, (4.9, 0.15), (6.2, 0.15), lw=0.9, mutation_scale=7)
    note(ax, "$z$", (4.5, 1.55))
    note(ax, "$x$", (6.0, 0.6))


def winding(ax: Axes) -> None:
    """Web wound on the mandrel under tension, seen along the axis, with the pressure between wraps."""
    bare(ax, (-4.3, 5.4), (-4.3, 4.9), "(b) Winding tension presses the wraps together")
    inner, wall, pitch, turns = 1.55, 0.28, 0.24, 5
    ax.add_patch(Circle((0, 0), inner + wall, facecolor=TUBE, edgecolor=INK, lw=0.9, zorder=3))
    ax.add_patch(Circle((0, 0), inner, facecolor="white", edgecolor=INK, lw=0.9, zorder=4))
    angle = np.linspace(0, 2 * np.pi * turns, 900)
    r = inner + wall + 0.06 + pitch * angle / (2 * np.pi)
    end = r[-1] + 0.02
    x, y = r * np.cos(angle - np.pi / 2), r * np.sin(angle - np.pi / 2)
    x, y = np.append(x, 4.3), np.append(y, -end)
    ax.plot(x, y, color=INK, lw=3.4, zorder=4, solid_joinstyle="round")
    ax.plot(x, y, color=WEB, lw=2.3, zorder=5)
    arrow(ax, (4.3, -end), (5.4, -end), color=GREEN, lw=1.8, mutation_scale=13)
    note(ax, "tension $T$", (3.05, -end - 0.75), color=GREEN)
    for at in np.deg2rad((28, 62, 118, 152)):
        outer, inner_end = 3.95 * np.array([np.cos(at), np.sin(at)]), 3.25 * np.array([np.cos(at), np.sin(at)])
        arrow(ax, tuple(outer), tuple(inner_end), color=GREEN)
    note(ax, "pressure $p(r)$ between wraps", (0.0, 4.5), color=GREEN, ha="center")
    arrow(ax, (0.85, 0), (0.6, 0.6), connectionstyle="arc3,rad=0.25", lw=0.9, mutation_scale=7)
    ax.plot([0, 1.25], [0, 0], color=INK, lw=0.6, ls=":", zorder=6)
    note(ax, r"$\theta$", (0.95, 0.5))


def friction(ax: Axes) -> None:
    """Friction stress at one contact point over a cycle: stiffness up to mu p, then slip."""
    bare(ax, (-4.3, 5.4), (-2.2, 2.1), "(c) Slip between layers dissipates")
    arrow(ax, (-3.1, 0), (3.1, 0), lw=0.8, mutation_scale=7)
    arrow(ax, (0, -1.6), (0, 1.75), lw=0.8, mutation_scale=7)
    high, reach, stick = 1.0, 2.2, 0.8
    loop = [(reach, high), (reach - stick, -high), (-reach, -high), (-reach + stick, high)]
    ax.add_patch(Polygon(loop, closed=True, facecolor=RED, alpha=0.16, zorder=2))
    ax.add_patch(Polygon(loop, closed=True, fill=False, edgecolor=RED, lw=1.4, zorder=5))
    note(ax, r"$\mu p$", (-0.15, high + 0.32), ha="right", color=RED)
    note(ax, r"friction stress $\tau$", (0.2, 1.65))
    note(ax, "relative\ndisplacement", (3.2, 0.0))
    note(ax, "work per\ncycle", (-4.2, -1.55), (-1.0, -0.55), color=RED)


def roll_sketch() -> Path:
    """Draw the object that the program models."""
    figure, axes = plt.subplot_mosaic(
        [["roll", "winding"], ["roll", "friction"]], figsize=(7.2, 4.5), dpi=DPI, layout="constrained",
        width_ratios=(1.1, 1.0), height_ratios=(2.15, 1.0),
    )  # fmt: skip
    section(axes["roll"])
    winding(axes["winding"])
    friction(axes["friction"])
    return save(figure, "roll_sketch.png")


def rooms_picture() -> Path:
    """Draw the layers of the package; a room imports from its own row or from rows below."""
    figure, ax = plt.subplots(figsize=(7.2, 6.8), dpi=DPI, layout="constrained")
    step, high, left, width = 1.0, 0.74, 0.0, 6.4
    for row, (rooms, colour, words) in enumerate(ROOMS):
        gap = 0.12
        each = (width - gap * (len(rooms) - 1)) / len(rooms)
        for place, room in enumerate(rooms):
            x = left + place * (each + gap)
            shape = "round,pad=0,rounding_size=0.12"
            box = FancyBboxPatch((x, row * step), each, high, boxstyle=shape, facecolor=colour, alpha=0.22, lw=0)
            ax.add_patch(box)
            ax.add_patch(
                FancyBboxPatch((x, row * step), each, high, boxstyle=shape, fill=False, edgecolor=colour, lw=1.2)
            )
            ax.text(
                x + 0.5 * each, row * step + 0.5 * high, room, ha="center", va="center", fontsize=9, family="monospace"
            )
        ax.text(left + width + 0.25, row * step + 0.5 * high, words, va="center", fontsize=8, color=INK)
    top = len(ROOMS) * step
    arrow(ax, (-0.45, top - 0.3), (-0.45, 0.1), color=GREY, lw=1.6, mutation_scale=14)
    ax.text(-0.75, 0.5 * top, "imports point down", rotation=90, ha="center", va="center", fontsize=8, color="#555555")
    outside = FancyBboxPatch((left, top + 0.25), width, high, boxstyle="round,pad=0,rounding_size=0.12", fill=False,
                             edgecolor=GREY, lw=1.0, ls="--")  # fmt: skip
    ax.add_patch(outside)
    ax.text(left + 0.5 * width, top + 0.25 + 0.5 * high, "reproduction  tools  benchmarks  tests", ha="center",
            va="center", fontsize=8, family="monospace", color="#555555")  # fmt: skip
    ax.text(left + width + 0.25, top + 0.25 + 0.5 * high, "outside the package: may use all of it", va="center",
            fontsize=8, color=INK)  # fmt: skip
    ax.set(xlim=(-1.1, 13.4), ylim=(-0.2, top + 1.2))
    ax.axis("off")
    return save(figure, "rooms.png")


def save(figure: plt.Figure, name: str) -> Path:
    """Write a figure into docs/figures."""
    FIGURES.mkdir(parents=True, exist_ok=True)
    path = FIGURES / name
    figure.savefig(path, dpi=DPI)
    plt.close(figure)
    return path


if __name__ == "__main__":
    print(roll_sketch())
    print(rooms_picture())
