"""Limits of stochastic averaging: conditions under which the random response of a backbone is not to be trusted."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from scipy.integrate import trapezoid

from wroll_fem.signals.averaging.amplitude_process import AmplitudeDensity, Density
from wroll_fem.signals.averaging.averaged_spectrum import LinearModes, ResponseSpectra
from wroll_fem.typing import FloatArray

BROAD, TOO_BROAD = 0.10, 0.15
"""Effective damping ratio from which the averaging is doubtful, and invalid: the amplitude is not slow any more."""
VARIES = 0.15
"""Mean relative difference between the PSD and its average over the resonance from which the result is doubtful."""
BEYOND, FAR_BEYOND = 0.01, 0.2
"""Share of the mean square beyond the end of the backbone from which the result is doubtful, and invalid."""
BELOW, FLAT = 0.05, 0.05
"""Share of the mean square below the first point of the backbone, and change of the damping ratio per factor e of the
amplitude there relative to it, above which the linear extrapolation is doubtful."""
OTHERS = 0.05
"""Share of the mean square of displacement or acceleration in other modes from which the result is doubtful."""
DRIFT, REACH = 0.02, 3.0
"""Mean square of the slow drift relative to the mean square of the tip from which the result is doubtful; multiple of
the amplitude whose secant stiffness resists the drift. For a Jenkins element the error of the rms is about one to two
times this ratio."""
OUTSIDE = 0.05
"""Share of the time with the resonance outside the band of the PSD, or nearer to its end than half of its half-power
width, from which the result is doubtful."""


class Doubt(NamedTuple):
    """Reason to doubt a random response, with the remedy; ``severe`` if the numbers are not usable."""

    text: str
    severe: bool = False


def averaging_doubts(
    law: AmplitudeDensity, psd: Density, band: tuple[float, float], spectra: ResponseSpectra, others: LinearModes
) -> list[Doubt]:
    """Reasons to doubt the response of a backbone to a random base acceleration, worst first; empty without any.

    Parameters
    ----------
    law
        Stationary density of the amplitude.
    psd, band
        PSD of the base acceleration and its lowest and highest frequency, Hz.
    spectra, others
        Spectra of the tip, and the linear modes in them.
    """
    found = [
        *_outside(law, band), *_ends(law), *_broad(law), *_drifts(law, psd, band), *_varies(law, psd),
        *_start(law), *_shared(spectra, band, others),
    ]  # fmt: skip
    return sorted(found, key=lambda doubt: not doubt.severe)


def quality(doubts: list[Doubt]) -> Literal["ok", "doubtful", "invalid"]:
    """`invalid` with a severe doubt, `doubtful` with any other."""
    if any(doubt.severe for doubt in doubts):
        return "invalid"
    return "doubtful" if doubts else "ok"


def _outside(law: AmplitudeDensity, band: tuple[float, float]) -> list[Doubt]:
    hertz, zeta = law.frequency / (2.0 * np.pi), law.damping
    outside = float(law.share[(hertz * (1.0 - zeta) < band[0]) | (hertz * (1.0 + zeta) > band[1])].sum())
    if outside <= OUTSIDE:
        return []
    return [
        Doubt(
            f"the resonance lies at an end or outside the band of the PSD, {band[0]:g} to {band[1]:g} Hz, during "
            f"{outside:.0%} of the time: the base then does not drive it as white noise does; extend excitation.psd, "
            "or use analysis: random",
            severe=outside > 0.5,
        )
    ]


def _ends(law: AmplitudeDensity) -> list[Doubt]:
    beyond, end = law.beyond(), abs(float(law.mode.tip[-1]))
    if beyond <= BEYOND:
        return []
    return [
        Doubt(
            f"{beyond:.2g} of the mean square of the tip lies beyond the end of the backbone, {end:.2g} m: frequency "
            f"and damping are taken as constant there; raise backbone.tip_largest to {law.tip_exceeded(1e-4):.2g} m",
            severe=beyond > FAR_BEYOND,
        )
    ]


def _start(law: AmplitudeDensity) -> list[Doubt]:
    mode, below = law.mode, law.below()
    if below <= BELOW or len(mode.root) < 2:
        return []
    slope = (mode.damping[1] - mode.damping[0]) / np.log(mode.root[1] / mode.root[0])
    if abs(slope) <= FLAT * max(float(mode.damping[0]), 1e-12):
        return []
    return [
        Doubt(
            f"{below:.2g} of the mean square of the tip lies below the start of the backbone, at "
            f"{abs(float(mode.tip[0])):.2g} m, where the damping still changes: lower backbone.tip_smallest"
        )
    ]


def _broad(law: AmplitudeDensity) -> list[Doubt]:
    zeta = law.mean_damping
    if zeta <= BROAD:
        return []
    return [
        Doubt(
            f"the effective damping ratio is {zeta:.2g}, above {BROAD:g}: amplitude and phase do not vary slowly; use "
            "analysis: random",
            severe=zeta > TOO_BROAD,
        )
    ]


def _drifts(law: AmplitudeDensity, psd: Density, band: tuple[float, float]) -> list[Doubt]:
    ratio = drift(law, psd, band)
    if ratio <= DRIFT:
        return []
    return [
        Doubt(
            "the base moves the sliding layers slowly to and fro, because the structure is much softer while they "
            f"slide: this drift, which is neglected, adds about {ratio:.2g} of the mean square of the tip; use "
            "analysis: random",
            severe=ratio > 5.0 * DRIFT,
        )
    ]


def drift(law: AmplitudeDensity, psd: Density, band: tuple[float, float]) -> float:
    """Estimate of the mean square of the slow motion of the centre of oscillation, relative to that of the tip.

    The base acceleration below half of the mean frequency deflects the structure statically. The deflection grows by
    the loss of secant stiffness at `REACH` times the amplitude relative to the smallest amplitude.
    """
    mode, middle = law.mode, 0.5 * law.mean_frequency
    if middle <= band[0]:
        return 0.0
    axis = np.geomspace(band[0], middle, 200)
    level = float(trapezoid(psd(axis), axis))
    participation = law.tip * law.base * law.frequency**2 / (2.0 * law.energy)
    softer = mode.at(REACH * law.root, mode.frequency) ** -2.0 - mode.frequency[0] ** -2.0
    return float(law.mean((participation * softer) ** 2) * level / law.tip_rms**2)


def _varies(law: AmplitudeDensity, psd: Density) -> list[Doubt]:
    change = variation(law, psd)
    if change <= VARIES:
        return []
    return [
        Doubt(
            f"the PSD differs by {change:.0%} on average from its mean over the half-power width of the resonance: it "
            "is not white there; compare with analysis: random"
        )
    ]


def variation(law: AmplitudeDensity, psd: Density) -> float:
    """Mean relative difference between the PSD at the resonance and its average over the resonance line."""
    weight = law.share * law.energy
    cells = np.linspace(0, len(law.root) - 1, 60).astype(int)
    w, zeta, level, share = (a[cells, 1] for a in (law.frequency, law.damping, law.psd, weight))
    quantiles = np.tan(np.pi * (np.arange(1, 64) / 64.0 - 0.5))
    line = np.abs(w[:, None] * (1.0 + zeta[:, None] * quantiles)) / (2.0 * np.pi)
    return float(np.sum(share * np.abs(psd(line).mean(axis=1) / level - 1.0)) / share.sum())


def _shared(spectra: ResponseSpectra, band: tuple[float, float], others: LinearModes) -> list[Doubt]:
    if not len(others.frequency):
        return []
    hertz = others.frequency / (2.0 * np.pi)
    loose = others.loose((2.0 * np.pi * band[0], 2.0 * np.pi * band[1])) & (np.abs(others.participation) > 1e-3)
    if loose.any():
        return [
            Doubt(
                f"the mode at {hertz[loose][0]:.4g} Hz lies in the band and has no material damping: its response, "
                "which friction alone limits, is left out; add section damping",
                severe=True,
            )
        ]
    share = max(other_share(spectra, others))
    if share <= OTHERS:
        return []
    return [
        Doubt(
            f"modes beside the main one carry {share:.0%} of the mean square of the tip: their interfaces are taken to "
            "stick, without friction; compare with analysis: random"
        )
    ]


def other_share(spectra: ResponseSpectra, others: LinearModes) -> tuple[float, float]:
    """Share of other modes in the mean squares of displacement and absolute acceleration of the tip."""
    omega = 2.0 * np.pi * spectra.frequency
    size: FloatArray = spectra.base * np.abs(others.displacement(omega)) ** 2
    parts = (
        trapezoid(size, spectra.frequency) / spectra.rms("displacement") ** 2,
        trapezoid(size * omega**4, spectra.frequency) / spectra.rms("acceleration") ** 2,
    )
    return float(parts[0]), float(parts[1])
