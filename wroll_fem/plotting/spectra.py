"""Spectra of a random motion: PSD of base and tip, |H1| and coherence."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.plotting.transmissibility import damping_words
from wroll_fem.results.resonance import resonance
from wroll_fem.signals.random.psd import STANDARD_GRAVITY
from wroll_fem.signals.transmissibility import magnitude

_NEEDS = ("frequency", "base_psd", "tip_psd", "transmissibility_real", "transmissibility_imag", "coherence", "h1_error")


def plot_spectra(dataset: xr.Dataset) -> Axes:
    """Plot the PSDs of base and tip acceleration, |H1| with its error, and the coherence, versus frequency.

    Parameters
    ----------
    dataset
        Results of `random`.

    Returns
    -------
    Axes
        The axes of the PSDs, the uppermost of three.

    Raises
    ------
    InputError
        If the Dataset has no spectra.
    """
    style.require(dataset, _NEEDS, "figure of the spectra")
    _, rows = plt.subplots(
        3, 1, figsize=(style.WIDTH, 7.0), dpi=style.DPI, layout="constrained", sharex=True, height_ratios=(3, 3, 1.3)
    )
    psd, ratio, part = (style.axes(ax) for ax in rows)
    f, h1 = dataset["frequency"].values, magnitude(dataset).values
    for name, colour, words in (("tip_psd", style.RED, "tip"), ("base_psd", style.BLUE, "base")):
        psd.semilogy(f, dataset[name].values / STANDARD_GRAVITY**2, color=colour, lw=1.2, label=words)
    psd.set_ylabel("PSD of the\nacceleration (g²/Hz)")
    psd.legend(loc="upper right", fontsize=8, framealpha=0.9)
    error = 2.0 * dataset["h1_error"].values * h1
    ratio.fill_between(f, np.maximum(h1 - error, 1e-3 * h1.max()), h1 + error, color=style.SKY, alpha=0.5, lw=0)
    ratio.semilogy(f, h1, color=style.BLUE, lw=1.2)
    ratio.set_ylim(0.5 * max(h1.min(), 1e-3 * h1.max()), 2.0 * h1.max())
    ratio.set_ylabel("Transmissibility |H1|,\ntip over base (–)")
    part.plot(f, dataset["coherence"].values, color=style.GREEN, lw=1.2)
    part.set_ylim(0.0, 1.05)
    part.set_ylabel("Coherence (–)")
    part.set_xlabel("Frequency (Hz)")
    part.margins(x=0.0)
    style.title(psd, _sentence(dataset))
    style.title(ratio, _of_ratio(dataset))
    return psd


def _sentence(dataset: xr.Dataset) -> str:
    attrs = dataset.attrs
    base, tip = (attrs.get(f"{name}_rms_m_s2", np.nan) / STANDARD_GRAVITY for name in ("base", "tip"))
    return (
        f"A base acceleration of {base:.3g} g rms moves the tip with {tip:.3g} g rms, "
        f"{3.0 * 1e3 * attrs.get('tip_displacement_rms_m', np.nan):.2g} mm (3 sigma) relative to the base"
    )


def _of_ratio(dataset: xr.Dataset) -> str:
    read, attrs = resonance(dataset), dataset.attrs
    averages = (
        f"{attrs.get('psd_averages', np.nan):.0f} averages, lines at {attrs.get('psd_resolution_hz', 0.0):.2g} Hz"
    )
    if not np.isfinite(read.f_n):
        return f"No resonance in the band; {averages}"
    damping = f"damping ratio {damping_words(read)}" if read.stated else f"damping {damping_words(read)}"
    return f"Resonance at {read.f_n:.1f} Hz, {damping}; band: two standard deviations; {averages}"
