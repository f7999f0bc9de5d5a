"""Random motion at several levels: frequency, damping and rms of the tip versus rms of the base."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.signals.random.psd import STANDARD_GRAVITY

_NEEDS = (
    "level", "base_rms_at_level", "tip_displacement_rms_at_level", "frequency_at_level", "damping_at_level",
    "frequency_error_at_level", "damping_error_at_level",
)  # fmt: skip


def plot_random_levels(dataset: xr.Dataset) -> Axes:
    """Plot f_n, damping ratio and rms of the tip displacement versus the rms of the base acceleration.

    Parameters
    ----------
    dataset
        Results of `random` with several levels or records.

    Returns
    -------
    Axes
        The axes of the frequency, the uppermost of three.

    Raises
    ------
    InputError
        If the Dataset has no levels.
    """
    style.require(dataset, _NEEDS, "figure of the levels")
    _, rows = plt.subplots(3, 1, figsize=(style.WIDTH, 7.4), dpi=style.DPI, layout="constrained", sharex=True)
    top, middle, bottom = (style.axes(ax) for ax in rows)
    base = dataset["base_rms_at_level"].values / STANDARD_GRAVITY
    frequency, zeta = dataset["frequency_at_level"].values, 100.0 * dataset["damping_at_level"].values
    _with_error(top, base, frequency, dataset["frequency_error_at_level"].values, style.BLUE)
    _with_error(middle, base, zeta, 100.0 * dataset["damping_error_at_level"].values, style.RED)
    rms = 1e6 * dataset["tip_displacement_rms_at_level"].values
    error = rms * dataset["tip_rms_error_at_level"].values
    _with_error(bottom, base, rms, error, style.GREEN)
    bottom.plot(base, rms[0] * base / base[0], "--", color=style.GREY, lw=1.2, label="proportional to the lowest level")
    bottom.legend(fontsize=8, framealpha=0.9)
    for ax, text in (
        (top, "Resonance\nfrequency $f_n$ (Hz)"), (middle, "Damping ratio (%)"),
        (bottom, "Tip displacement,\nrms (µm)"),
    ):  # fmt: skip
        ax.set_ylabel(text)
    middle.set_ylim(bottom=0.0)
    bottom.set_ylim(bottom=0.0)
    bottom.set_xlim(left=0.0)
    bottom.set_xlabel("Base acceleration (g rms)")
    style.title(top, _sentence(base, frequency, zeta, dataset.sizes.get("record", 1)))
    return top


def _with_error(ax: Axes, x: np.ndarray, y: np.ndarray, error: np.ndarray, colour: str) -> None:
    ax.errorbar(x, y, yerr=2.0 * np.nan_to_num(error), fmt="o-", color=colour, lw=1.6, ms=5, capsize=3)


def _sentence(base: np.ndarray, frequency: np.ndarray, zeta: np.ndarray, records: int) -> str:
    of = f"{records} records per level" if records > 1 else "one record per level"
    if len(base) == 1:
        return f"At {base[0]:.2g} g rms: {frequency[0]:.2f} Hz, damping ratio {zeta[0]:.2g} %; {of}; bars: two errors"
    return (
        f"From {base[0]:.2g} to {base[-1]:.2g} g rms: {frequency[0]:.1f} to {frequency[-1]:.1f} Hz, damping ratio "
        f"{zeta[0]:.2g} to {zeta[-1]:.2g} %; {of}; bars: two errors"
    )
