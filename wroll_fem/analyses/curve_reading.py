"""Readings of response curves by harmonic balance, and warnings about them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.signals.damping import HalfPower
from wroll_fem.signals.estimators import CurveDamping, estimate_damping, without_half_power_points
from wroll_fem.signals.estimators.estimate import DampingEstimate

if TYPE_CHECKING:
    from wroll_fem.case.harmonic import Harmonic

HIGHEST_ORDER, NEAR_MULTIPLE, LEAST_SHARE = 7, 0.04, 0.02
"""Criteria of the warning about a mode near a neglected harmonic: highest odd order of the harmonic; largest relative
difference between the natural frequency of the mode and the frequency of the harmonic; least tip participation of the
mode, relative to the main mode."""

SAME_MODE = 0.01
"""Relative difference of two natural frequencies up to which they count as one mode."""

DRIFT = 10.0
"""Mean relative displacement of the interfaces, divided by its oscillating part, above which the run warns."""

SPAN_WARNING = 0.01
"""Energy norm of what motions lack in the span of a path, relative to the motion, above which the run warns. At 0.35 %
the peak of `slipping_coil` at 15 g is off by 0.05 %."""

MEMORY_WARNING = 0.02
"""Change of the elastic slip per period, relative to its largest value gamma*, above which the run warns."""


def missed_harmonic(condensation: Condensation, frequency: float, harmonics: int) -> str:
    """Warning if a mode lies near a neglected harmonic of the resonance frequency; empty otherwise.

    Parameters
    ----------
    condensation
        Modes of the structure.
    frequency
        Resonance frequency, rad/s.
    harmonics
        Highest harmonic in the analysis.

    Notes
    -----
    The friction force is odd in the motion, so its odd harmonics dominate; they decrease with the order.
    """
    c = condensation
    share = np.abs(c.base * c.tip)
    share = share / max(float(share.max(initial=0.0)), 1e-300)
    natural = np.sqrt(np.maximum(c.eigenvalues, 0.0))
    for order in range(harmonics + 1 + harmonics % 2, HIGHEST_ORDER + 1, 2):
        near = (np.abs(natural / (order * frequency) - 1.0) < NEAR_MULTIPLE) & (share > LEAST_SHARE)
        if near.any():
            return (
                f"a mode at {natural[near][0] / (2.0 * np.pi):.0f} Hz lies near {order} times the resonance frequency, "
                f"and this harmonic is neglected; set harmonic.harmonics to {order}"
            )
    return ""


def other_mode_remark(condensation: Condensation, band: tuple[float, float]) -> str:
    """Warning if the base excites another mode more than the one with the largest tip motion; empty otherwise.

    This is so for a coil that is soft between its wraps: most of its mass moves in a mode of its own. A curve in a
    ``band`` (Hz) follows the mode with the largest tip motion there.
    """
    mass = condensation.base**2
    if not mass.any():
        return ""
    most, (main, _) = int(np.argmax(mass)), condensation.main_mode
    hertz = float(np.sqrt(max(condensation.eigenvalues[most], 0.0)) / (2.0 * np.pi))
    if abs(hertz - main) <= SAME_MODE * main:
        return ""
    followed = condensation.main_mode_between(*band)[0]
    return (
        f"the base excites a mode at {hertz:.4g} Hz most ({100.0 * mass[most] / mass.sum():.0f} % of the mass that it "
        f"moves), but the tip moves most in the mode at {main:.4g} Hz (interfaces stuck): the coil is soft between its "
        f"wraps; f_n and zeta follow the mode at {followed:.4g} Hz; give the band of the mode that is wanted"
    )


def read_response(dataset: xr.Dataset, method: str = "half_power", *, error: float | None = None) -> CurveDamping:
    """Estimate damping from the response curve, or from the upper envelope of a folded curve.

    ``method`` is a key of `ESTIMATORS`. ``error`` is the relative error of the curve, for the error bars. Between the
    folds of a curve that leans over, several motions have the same frequency. The largest of them is used at every
    frequency. The resulting envelope has no phase. Where a broad peak has no half-power points, a curve without folds
    is read by `rational_fraction`.
    """
    T = dataset["transmissibility_real"].values + 1j * dataset["transmissibility_imag"].values
    frequency = dataset["frequency"].values
    size = np.abs(T)
    noise = None if error is None else error * float(size.max())
    if np.all(np.diff(frequency) > 0.0):
        read = estimate_damping(frequency, T, method, noise=noise)
        return read if method != "half_power" else without_half_power_points(read, frequency, T)
    grid = np.unique(np.concatenate([np.linspace(frequency[0], frequency[-1], 20 * len(frequency)), frequency]))
    best = np.zeros_like(grid)
    for i in range(len(frequency) - 1):
        low, high = sorted((frequency[i], frequency[i + 1]))
        inside = (grid >= low) & (grid <= high)
        if high > low:
            share = (grid[inside] - frequency[i]) / (frequency[i + 1] - frequency[i])
            best[inside] = np.maximum(best[inside], size[i] + share * (size[i + 1] - size[i]))
    return estimate_damping(grid, best, method, noise=noise)


def unbounded_reading(curve: HarmonicCurve) -> CurveDamping | None:
    """Estimate with f_n, but without peak and damping, if the resonance is practically undamped; None otherwise."""
    if curve.gap is None:
        return None
    low, high = (w / (2.0 * np.pi) for w in curve.gap)
    middle = 0.5 * (low + high)
    edges = np.abs(curve.transmissibility[np.isin(curve.frequencies, curve.gap)])
    height = min(float(edges.min(initial=np.inf)), curve.balance.largest_growth)
    remedy = "" if curve.balance.model.damping is not None else "; give the material damping in section damping"
    reason = (
        f"the resonance near {middle:.5g} Hz grows beyond {height:.0f} times the base motion: its damping "
        f"ratio due to friction is below {50.0 / height:.2g} %, or friction does not limit it; the curve is "
        f"omitted between {low:.6g} and {high:.6g} Hz{remedy}"
    )
    shape = HalfPower(middle, np.nan, np.nan, np.nan, np.nan, np.nan, complete=False, reason=reason)
    return CurveDamping(shape, DampingEstimate(middle, np.nan, np.nan, np.nan, "half power", reason))


def several_motions(curve: HarmonicCurve) -> tuple[float, float] | None:
    """Lowest and highest frequency (Hz) of the widest fold of a curve; None without folds."""
    turns = np.flatnonzero(np.diff(np.sign(np.diff(curve.frequencies)))) + 1
    ends = np.concatenate([[0], turns, [len(curve.frequencies) - 1]])
    hertz = curve.frequencies[ends] / (2.0 * np.pi)
    folds = [(high, low) for high, low in zip(hertz[1:], hertz[:-1], strict=True) if high < low]
    return max(folds, key=lambda fold: fold[1] - fold[0], default=None)


def skipped_remark(curve: HarmonicCurve) -> str:
    """Warning about internal resonances that were stepped over along the curve; empty otherwise."""
    if not curve.skipped:
        return ""
    places = ", ".join(f"{w / (2.0 * np.pi):.5g}" for w in curve.skipped)
    return (
        f"undamped internal resonances just below {places} Hz are stepped over: a harmonic of the motion coincides "
        "with a mode there; compare with a sweep, or raise harmonic.harmonics"
    )


def drift_remark(curve: HarmonicCurve) -> str:
    """Warning about a mean relative displacement that the friction law does not limit; empty otherwise.

    A friction law without memory transmits no traction at zero slip rate. A layer that is not held otherwise drifts.
    """
    contact = curve.balance.contact
    if contact.laws.sticks.all():
        return ""
    jump = contact.jump[: 2 * contact.n]
    mean = float(np.abs(jump @ curve.coefficients[:, 0].T).max(initial=0.0))
    motion = float(np.abs(jump @ curve.coefficients[:, 1:].reshape(-1, jump.shape[1]).T).max(initial=0.0))
    if mean <= DRIFT * motion:
        return ""
    return (
        f"the mean relative displacement of the layers is {mean:.2g} m, {mean / max(motion, 1e-300):.2g} times its "
        "amplitude: the friction law transmits no traction at rest and does not hold them; displacements and slip of "
        "the interfaces are meaningless; use penalty_coulomb"
    )


def reduction_remark(error: float, settings: Harmonic) -> str:
    """Warning if the error estimate of the reduced model exceeds its tolerance; empty otherwise."""
    if error <= settings.reduction_tolerance:
        return ""
    return (
        f"the estimated error of the reduced model is {100 * error:.2g} % of the motion, above "
        "harmonic.reduction_tolerance, and its basis is not enlarged further"
    )


def span_remark(error: float) -> str:
    """Warning if motions of a coil whose wraps slide lack more than `SPAN_WARNING` in its modes; empty otherwise."""
    if error <= SPAN_WARNING:
        return ""
    return (
        f"the modes of the coil, those of its quasi-static path, miss {100.0 * error:.2g} % of the motion (energy "
        "norm): frequency and peak can be off by about as much; compare with slip_damping, or lower the excitation"
    )


def memory_remark(dataset: xr.Dataset) -> str:
    """Warning if the friction hysteresis is not yet periodic; empty otherwise."""
    change = float(dataset.attrs["memory_change"])
    if change <= MEMORY_WARNING:
        return ""
    return (
        f"the friction hysteresis is not periodic: the elastic slip at some point still changes by "
        f"{100 * change:.2g} % of elastic_slip per period; "
        "raise harmonic.max_periods"
    )
