"""Figure of natural frequencies, coloured by kind of mode."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label
from wroll_fem.typing import FloatArray


def _mass_fraction(dataset: xr.Dataset) -> tuple[FloatArray, list[str]] | None:
    """Largest effective mass fraction of each mode, and its direction; None if the results contain no fractions."""
    if "effective_mass_fraction" not in dataset:
        return None
    fraction = dataset["effective_mass_fraction"]
    others = [dim for dim in fraction.dims if dim != "mode"]
    if not others:
        return fraction.values, [""] * fraction.size
    table = fraction.transpose("mode", others[0]).values
    names = [str(n) for n in dataset[others[0]].values] if others[0] in dataset.coords else list("xyz")
    best = table.argmax(axis=1)
    return table[np.arange(len(best)), best], [f" along {names[k]}" for k in best]


def plot_modes(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot natural frequencies as horizontal stems, one row per mode, coloured and labelled by kind of mode.

    Parameters
    ----------
    dataset
        Has `mode_frequency` (Hz) and, where known, `mode_kind` along `mode`; `effective_mass_fraction` along `mode` or
        (`mode`, direction) is written next to the stems when it exceeds 0.5 %.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        When the Dataset holds no modes.
    """
    style.require(dataset, ("mode_frequency",), "mode figure")
    frequency = dataset["mode_frequency"].values
    named = "mode_kind" in dataset  # modes of a structure from a file are not classified
    kinds = [str(kind) for kind in dataset["mode_kind"].values] if named else ["mode"] * frequency.size
    main_kinds = list(dict.fromkeys(kind.split("-")[0] for kind in kinds))
    colours = {main_kind: style.LINES[i % len(style.LINES)] for i, main_kind in enumerate(main_kinds)}
    ax = style.axes(ax, 1.4 + 0.27 * len(kinds))
    rows = np.arange(1, len(kinds) + 1)
    masses = _mass_fraction(dataset)
    for row, f, kind in zip(rows, frequency, kinds, strict=True):
        colour = colours[kind.split("-")[0]]
        ax.plot([0.0, f], [row, row], color=colour, lw=2.0, alpha=0.6, solid_capstyle="butt")
        ax.plot(f, row, "o", color=colour, ms=6)
        text = f"{f:.1f} Hz"
        if masses is not None and masses[0][row - 1] > 0.005:
            text += f", {100 * masses[0][row - 1]:.0f} % of the mass{masses[1][row - 1]}"
        ax.annotate(text, (f, row), xytext=(7, 0), textcoords="offset points", va="center", fontsize=8)
    ax.set_yticks(rows, [f"{row}  {kind}" for row, kind in zip(rows, kinds, strict=True)])
    ax.set_ylim(len(kinds) + 0.6, 0.4)
    ax.set_xlim(0.0, 1.62 * float(frequency.max()))
    ax.grid(False, axis="y")
    ax.set_xlabel(label("mode_frequency", "Hz"))
    bending = [f for f, kind in zip(frequency, kinds, strict=True) if kind.startswith("bending")]
    first = f"first bending at {bending[0]:.1f} Hz, " if bending else ""
    counts = ", ".join(
        f"{sum(kind.split('-')[0] == main_kind for kind in kinds)} {main_kind}" for main_kind in main_kinds
    )
    found = f": {first}{counts}" if named else ""
    style.title(ax, f"{len(kinds)} modes from {frequency.min():.1f} to {frequency.max():.1f} Hz{found}")
    return ax
