"""Figures of the bench experiments: shear tests of stacked layers, and rate-and-state friction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label


def plot_shear_tests(tests: Sequence[xr.Dataset]) -> Axes:
    """Plot force versus displacement, and capacity, stiffness and modulus versus pressure (thesis, Figs. E.6 to E.9).

    Parameters
    ----------
    tests
        Results of `lab.run_shear_test`; one line per number of interfaces.

    Returns
    -------
    Axes
        The first of four panels.

    Raises
    ------
    InputError
        If a Dataset holds no shear test.
    """
    for data in tests:
        style.require(data, ("platen_displacement", "shear_force"), "shear tests")
    size = (1.15 * style.WIDTH, 6.2)
    _, panels = plt.subplots(2, 2, figsize=size, dpi=style.DPI, layout="constrained")
    curves, *rest = (style.axes(ax) for ax in panels.ravel())
    counts = sorted({int(data.attrs["interfaces"]) for data in tests})
    pressures = sorted({float(data.attrs["pressure_pa"]) for data in tests})
    shades_of = dict(zip(counts, style.LINES, strict=False))
    shades = plt.get_cmap("coolwarm")(np.linspace(0.0, 1.0, len(pressures)))
    for count, dash in zip(counts, ("-", "--", ":", "-."), strict=False):
        own = sorted((d for d in tests if d.attrs["interfaces"] == count), key=lambda d: float(d.attrs["pressure_pa"]))
        for data in own:
            shade = shades[pressures.index(float(data.attrs["pressure_pa"]))]
            x, y = 1e3 * data["platen_displacement"].values, data["shear_force"].values
            curves.plot(x, y, color=shade, ls=dash, lw=1.3)
        pressure = [1e-3 * data.attrs["pressure_pa"] for data in own]
        for ax, (name, scale) in zip(rest, _READINGS, strict=True):
            values = [scale * data.attrs[name] for data in own]
            text = f"{count - 1} layers, {count} interfaces"
            ax.plot(pressure, values, color=shades_of[count], marker="o", ls=dash, ms=4, lw=1.3, label=text)
    curves.set_xlabel("Displacement of the platen (mm)")
    curves.set_ylabel("Shear force (N)")
    for ax, text in zip(
        rest, ("Shear capacity $F_c$ (N)", "Stiffness $K$ (N/mm)", "Modulus $Kt/2A$ (MPa)"), strict=True
    ):
        ax.set_xlabel("Pressure $F_N/A$ (kPa)")
        ax.set_ylabel(text)
        ax.set_xlim(left=0.0)
        ax.set_ylim(bottom=0.0)
    rest[0].legend(fontsize=8, framealpha=0.9)
    worst = max(abs(d.attrs["shear_capacity_n"] / _first(tests, d).attrs["shear_capacity_n"] - 1.0) for d in tests)
    style.title(curves, "Stick, then sliding at the platen (blue to red: rising pressure)", 46)
    share = f"{100 * worst:.2g} %" if worst > 1e-5 else "rounding"
    style.title(rest[0], f"Capacity is independent of the layer count (to {share})", 46)
    return curves


_READINGS = (("shear_capacity_n", 1.0), ("shear_stiffness_n_m", 1e-3), ("shear_modulus_pa", 1e-6))


def _first(tests: Sequence[xr.Dataset], one: xr.Dataset) -> xr.Dataset:
    """First test in ``tests`` that has the same pressure as the test ``one``."""
    return next(d for d in tests if np.isclose(d.attrs["pressure_pa"], one.attrs["pressure_pa"]))


def plot_velocity_steps(histories: Mapping[str, xr.Dataset]) -> Axes:
    """Plot the friction coefficient versus slip for several laws and one slip-rate history (thesis, Fig. E.15).

    Parameters
    ----------
    histories
        Panel title -> result of `lab.shear_history`.

    Returns
    -------
    Axes
        The first panel.

    Raises
    ------
    InputError
        If a Dataset holds no friction history.
    """
    for data in histories.values():
        style.require(data, ("friction_coefficient", "slip_distance", "slip_rate"), "friction under velocity steps")
    count = len(histories)
    size = (1.15 * style.WIDTH, 1.9 * ((count + 1) // 2) + 0.6)
    _, panels = plt.subplots(
        (count + 1) // 2, 2, figsize=size, dpi=style.DPI, layout="constrained", sharex=True, sharey=True, squeeze=False
    )
    for ax, (words, data) in zip(panels.ravel(), histories.items(), strict=False):
        style.axes(ax)
        slip, rate = 1e3 * data["slip_distance"].values, data["slip_rate"].values
        ax.fill_between(
            slip, 0.0, 1.0, where=rate > rate.min(), color="#EEEEEE", transform=ax.get_xaxis_transform(), step="pre"
        )
        ax.plot(slip, data["friction_coefficient"].values, color=style.BLUE, lw=1.5)
        ax.set_title(words, loc="left", fontsize=9)
    for ax in panels.ravel()[count:]:
        ax.set_visible(False)
    for ax in panels[-1]:
        ax.set_xlabel("Slip (mm)")
    for ax in panels[:, 0]:
        ax.set_ylabel(label("friction_coefficient", "1"))
    first: Axes = panels[0, 0]
    rate = next(iter(histories.values()))["slip_rate"].values
    style.figure_of(first).suptitle(
        f"Slip rate {1e6 * rate.min():g} µm/s, on grey {1e6 * rate.max():g} µm/s: the direct effect (a) is immediate, "
        "the state effect (b) evolves over the slip distance $D_R$", x=0.01, ha="left", fontsize=10,
    )  # fmt: skip
    return first
