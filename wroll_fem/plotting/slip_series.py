"""Figures of the slip on every interface at every excitation level of a study."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize

from wroll_fem.plotting import style
from wroll_fem.plotting.slip import in_small_unit, interface_name, over_wraps
from wroll_fem.plotting.study import StudyCase, grid_cases, shown
from wroll_fem.results.dataset import label
from wroll_fem.results.interface_slip import interface_radius, raster, slipping_area_fraction, surface
from wroll_fem.typing import FloatArray

AMPLITUDE = "excitation.amplitude"


def _levels(members: Sequence[StudyCase], figure: str) -> list[StudyCase]:
    """Cases in order of increasing excitation amplitude."""
    return sorted(grid_cases(members, figure, AMPLITUDE), key=lambda m: m.values[AMPLITUDE])


def _unrolled(ax: Axes, *, left: bool, bottom: bool) -> None:
    ax.set_xlim(-180.0, 180.0)
    ax.set_xticks([-180, -90, 0, 90, 180], ["−180", "", "0", "", "180"] if bottom else [""] * 5)
    ax.tick_params(labelsize=8, labelleft=left)
    ax.grid(False)
    for side in ("top", "right"):
        ax.spines[side].set_visible(True)


def plot_slip_extent(members: Sequence[StudyCase]) -> Axes:
    """Plot where interfaces slipped: one row per excitation level, one column per interface (thesis, Fig 4.10).

    Parameters
    ----------
    members
        Finished cases of a study that varies `excitation.amplitude`, with `slipped`, `area`, `theta_rad`, `z_m`.

    Returns
    -------
    Axes
        The first panel.

    Raises
    ------
    InputError
        If no case has a value of `excitation.amplitude`, or a Dataset lacks a field.
    """
    rows = _levels(members, "slip_extent")
    count = rows[0].data.sizes["interface"]
    figure, panels = plt.subplots(
        len(rows), count, figsize=(style.WIDTH, 0.9 + 1.45 * len(rows)), dpi=style.DPI, layout="constrained",
        squeeze=False, sharey=True,
    )  # fmt: skip
    colours = ListedColormap([style.GREEN, style.RED])
    fractions = []
    for r, m in enumerate(rows):
        fraction = slipping_area_fraction(m.data).values
        fractions.append(fraction)
        for k in range(count):
            ax = style.axes(panels[r, k])
            points = surface(m.data, k, "slipped")
            theta, z, values = raster(points, "slipped", radius=interface_radius(m.data, k))
            picture = np.where(np.isnan(values), np.nan, (values >= 0.5).astype(float))
            ax.pcolormesh(
                np.degrees(theta),
                1e3 * z,
                picture,
                cmap=colours,
                vmin=0.0,
                vmax=1.0,
                shading="nearest",
                rasterized=True,
            )
            _unrolled(ax, left=k == 0, bottom=r == len(rows) - 1)
            frame = {"fc": "white", "ec": "none", "alpha": 0.85, "pad": 1.5}
            ax.text(
                0.97, 0.95, _share(fraction[k]), transform=ax.transAxes, ha="right", va="top", fontsize=8, bbox=frame
            )
            if r == 0:
                ax.set_title(interface_name(k).replace(" and ", "\n"), fontsize=8.5)
        panels[r, 0].set_ylabel(f"{shown(AMPLITUDE, m.values[AMPLITUDE])}\nz (mm)", fontsize=9)
    figure.supxlabel(
        "Angle around the roll from x (°); 0° and ±180° face the excitation\n"
        "red: slipped at any time; green: stuck throughout; number: part of the area that slipped",
        fontsize=9,
    )
    figure.suptitle(_extent_sentence(rows, np.array(fractions)), fontsize=10, x=0.01, ha="left")
    return panels[0, 0]


def _share(fraction: float) -> str:
    return "0 %" if fraction == 0.0 else f"{100 * fraction:.0f} %" if fraction >= 0.01 else "< 1 %"


def _extent_sentence(rows: Sequence[StudyCase], fractions: FloatArray) -> str:
    parts = []
    for m, fraction in zip(rows, fractions, strict=True):
        slipping = int(np.count_nonzero(fraction))
        level = shown(AMPLITUDE, m.values[AMPLITUDE]).replace(" ", "\u00a0")
        parts.append(f"{slipping} of {fraction.size} at {level} ({_share(fraction.mean())} of all area)")
    text = "Interfaces that slip: " + ", ".join(parts)
    most = {int(np.argmax(fraction)) for fraction in fractions if fraction.any()}
    if len(most) == 1:
        text += f"; largest area: {interface_name(most.pop())}"
    return textwrap.fill(text, 100)


def plot_slip_vectors(members: Sequence[StudyCase], max_arrows: int = 330) -> Axes:
    """Plot the largest relative displacements at the lowest excitation level as arrows (thesis, Fig 4.11).

    There is one panel per interface. All panels have the same scale.

    Parameters
    ----------
    members
        Finished cases of a study that varies `excitation.amplitude`, with `peak_slip_hoop`, `peak_slip_axial`,
        `theta_rad`, `z_m`.
    max_arrows
        Approximate largest number of arrows per panel; the longest arrow is always drawn.

    Returns
    -------
    Axes
        The first panel.

    Raises
    ------
    InputError
        If no case has a value of `excitation.amplitude`, or a Dataset lacks a field.
    """
    m = _levels(members, "slip_vectors")[0]
    count = m.data.sizes["interface"]
    columns = min(count, 3)
    lines = -(-count // columns)
    figure, panels = plt.subplots(
        lines, columns, figsize=(style.WIDTH, 0.9 + 2.5 * lines), dpi=style.DPI, layout="constrained", squeeze=False,
        sharey=True,
    )  # fmt: skip
    points = [surface(m.data, k, "peak_slip_hoop", "peak_slip_axial") for k in range(count)]
    hoop = [p.values["peak_slip_hoop"] for p in points]
    axial = [p.values["peak_slip_axial"] for p in points]
    largest = max(float(np.hypot(h, a).max()) for h, a in zip(hoop, axial, strict=True)) or 1.0
    shown_top, unit = in_small_unit(np.array([largest]))
    top, factor = float(shown_top[0]), float(shown_top[0]) / largest
    arrows = None
    for k, ax in enumerate(panels.ravel()):
        if k >= count:
            ax.set_visible(False)
            continue
        style.axes(ax)
        x, y = np.degrees(points[k].theta), 1e3 * points[k].z
        size = np.hypot(hoop[k], axial[k])
        angles, column = np.unique(np.round(points[k].theta, 6), return_inverse=True)
        every = max(1, int(np.ceil(size.size / max_arrows)))  # columns are thinned from 0 degrees, a face of the roll
        keep = np.flatnonzero((column - np.abs(angles).argmin()) % every == 0)
        keep = np.unique(np.append(keep, np.argmax(size)))
        arrows = ax.quiver(
            x[keep], y[keep], factor * hoop[k][keep], factor * axial[k][keep], factor * size[keep],
            cmap=style.SLIP_ARROWS, norm=Normalize(0.0, top), angles="uv", scale_units="inches", scale=top / 0.35,
            width=0.005, minlength=0.3,
        )  # fmt: skip
        _unrolled(ax, left=k % columns == 0, bottom=k + columns >= count)
        ax.set_xlim(-195.0, 195.0)
        pad = 0.12 * float(np.ptp(y))
        ax.set_ylim(y.min() - pad, y.max() + pad)
        largest_here, unit_here = in_small_unit(np.array([size.max()]))
        ax.set_title(
            f"{interface_name(k)}: {style.three_digits(float(largest_here[0]))} {unit_here}{over_wraps(m.data, k)}",
            fontsize=8.5,
        )
    assert arrows is not None  # `surface` raises an error without an interface
    bar = figure.colorbar(arrows, ax=list(panels.ravel()), shrink=0.8, pad=0.02)
    bar.set_label(f"Largest relative displacement ({unit})", fontsize=9)
    figure.supxlabel("Angle around the roll from x (°); 0° and ±180° face the excitation", fontsize=9)
    for row in panels:
        row[0].set_ylabel(label("z_m", "mm"), fontsize=9)
    figure.suptitle(_vector_sentence(m, hoop, axial, [p.theta for p in points]), fontsize=10, x=0.01, ha="left")
    return panels[0, 0]


def _vector_sentence(
    m: StudyCase,
    hoop: Sequence[FloatArray],
    axial: Sequence[FloatArray],
    theta: Sequence[FloatArray],
) -> str:
    sizes = [np.hypot(h, a) for h, a in zip(hoop, axial, strict=True)]
    k = int(np.argmax([size.max() for size in sizes]))
    i = int(np.argmax(sizes[k]))
    value, unit = in_small_unit(np.array([sizes[k][i]]))
    share = "axial" if abs(axial[k][i]) >= abs(hoop[k][i]) else "hoop"
    angle = abs(np.degrees(theta[k][i]))
    side = f"±{angle:.0f}°" if 0.5 < angle < 179.5 else f"{angle:.0f}°"
    return (
        f"At {shown(AMPLITUDE, m.values[AMPLITUDE])} the largest relative displacement, "
        f"{style.three_digits(float(value[0]))} {unit}, mostly {share},\nis between {interface_name(k)} at {side}"
    )
