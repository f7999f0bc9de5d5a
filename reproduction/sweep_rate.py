"""Claims on the sweep rate of the experiments: C35 and C36 (section 3.3, Fig 3.8)."""

from __future__ import annotations

from functools import cache

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.verdict import EXPERIMENT, Verdict
from reproduction.words import numbers
from wroll_fem.plotting import style
from wroll_fem.signals.base_motion import sweep_rate_limit
from wroll_fem.signals.estimators import peak_transmissibility

ZETAS = (0.005, 0.01, 0.02, 0.05)
FREQUENCY, RATE = 150.0, float(np.log2(300 / 5) / 0.75)
"""Resonance of the mandrel alone (Hz), and rate of the sweep of the experiments (oct/min)."""
WANTED = 0.9
REACH = 15.0
"""Half width of the part of the sweep that is integrated, in zeta f_n, or a half at most."""


@cache
def attainment(zeta: float, rate: float, direction: int = 1) -> float:
    """Largest absolute acceleration of a single degree of freedom in an exponential sweep over its steady peak.

    Parameters
    ----------
    zeta
        Damping ratio.
    rate
        Octaves per minute over the natural frequency in Hz, R/f_n.
    direction
        1 for a sweep up, -1 for one down.

    Notes
    -----
    With time in radians of the natural vibration, base acceleration e^(i phi), phi' = w(t) = w_0 e^(g t) and relative
    displacement z = Z e^(i phi): Z'' + 2 (i w + zeta) Z' + (1 - w^2 + i w' + 2 i zeta w) Z = -1, from the steady value
    of Z. The absolute acceleration is that of spring and dashpot.
    """
    growth = direction * rate * np.log(2.0) / 60.0 / (2.0 * np.pi)
    width = min(0.5, REACH * zeta + 12.0 * np.sqrt(abs(growth)))
    start, end = 1.0 - direction * width, 1.0 + direction * width

    def matrix(t: float, y: np.ndarray) -> np.ndarray:
        w = start * np.exp(growth * t)
        factor, rate = 1.0 - w**2 + 1j * (growth * w + 2.0 * zeta * w), 2.0 * (zeta + 1j * w)
        return np.array([
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-factor.real, factor.imag, -rate.real, rate.imag],
            [-factor.imag, -factor.real, -rate.imag, -rate.real],
        ])  # fmt: skip

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        return matrix(t, y) @ y + (0.0, 0.0, -1.0, 0.0)

    steady = -1.0 / (1.0 - start**2 + 2j * zeta * start)
    time = np.log(end / start) / growth
    grid = np.linspace(0.0, time, 4001)
    # Z changes with the sweep, not with the vibration: implicit steps are far longer than the cycles
    found = solve_ivp(
        slope, (0.0, time), [steady.real, steady.imag, 0.0, 0.0], "Radau", grid,
        rtol=1e-7, atol=1e-8 * abs(steady), jac=matrix,
    )  # fmt: skip
    w, size = start * np.exp(growth * grid), found.y[0] + 1j * found.y[1]
    size = np.abs(2.0 * zeta * (found.y[2] + 1j * found.y[3] + 1j * w * size) + size)
    return float(size.max() / peak_transmissibility(zeta)[1])


@cache
def limit(zeta: float, direction: int = 1) -> float:
    """Highest R/f_n (oct/min per Hz) at which the response still reaches `WANTED` of its steady peak."""
    scale = np.log(100.0 * zeta**2)

    def missing(x: float) -> float:
        return attainment(zeta, float(np.exp(scale + x)), direction) - WANTED

    return float(np.exp(scale + brentq(missing, 0.5, 2.8, xtol=2e-3)))


def limits(evidence: Evidence, direction: int = 1) -> list[float]:
    """Highest R/f_n (oct/min per Hz) for every damping ratio of `ZETAS`."""

    def compute() -> xr.Dataset:
        return xr.Dataset({"rate": ("zeta", [limit(zeta, direction) for zeta in ZETAS])}, {"zeta": list(ZETAS)})

    found = evidence.kept("sweep_rate", compute, zetas=ZETAS, direction=direction, wanted=WANTED)
    return [float(rate) for rate in found["rate"]]


def c35(evidence: Evidence) -> Verdict:
    said, holds = [], True
    for direction, words in ((1, "up"), (-1, "down")):
        rates = limits(evidence, direction)
        slope = float(np.polyfit(np.log(ZETAS), np.log(rates), 1)[0])
        holds = holds and abs(slope - 2.0) <= 0.1
        factors = [rate / zeta**2 for rate, zeta in zip(rates, ZETAS, strict=True)]
        said.append(f"{words}: slope {slope:.3f}, R = {numbers(factors, '.0f')} zeta^2 f_n")
    value = f"R for 90 % at zeta {numbers((100 * z for z in ZETAS), 'g')} %, oct/min and Hz; {'; '.join(said)}"
    return Verdict(value, holds)


def c36(evidence: Evidence) -> Verdict:
    reached = [100 * attainment(zeta, RATE / FREQUENCY) for zeta in ZETAS]
    rates = [FREQUENCY * rate for rate in limits(evidence)]
    value = (
        f"150 Hz, {RATE:.2f} oct/min, zeta {numbers((100 * z for z in ZETAS), 'g')} %: the running peak reaches "
        f"{numbers(reached, '.0f')} %; 90 % up to {numbers(rates, '.2g')} oct/min; the ratio of spectra of a linear "
        "system has no such loss"
    )
    return Verdict(value, True, EXPERIMENT)


def plot(evidence: Evidence) -> Axes:
    """Draw Fig. 3.8."""
    ax = style.axes(None)
    for direction, words, colour in ((1, "sweep up", style.BLUE), (-1, "sweep down", style.RED)):
        rates = limits(evidence, direction)
        ax.loglog(100 * np.array(ZETAS), rates, "o-", color=colour, label=f"90 % of the steady peak, {words}")
    iso = [sweep_rate_limit(1.0, zeta) for zeta in ZETAS]
    ax.loglog(100 * np.array(ZETAS), iso, color="black", lw=1.0, ls="--", label="ISO 7626-2")
    ax.axhline(RATE / FREQUENCY, color=style.GREY, lw=1.0, label="experiment, 150 Hz")
    ax.set_xlabel("Damping ratio (%)")
    ax.set_ylabel("Sweep rate over resonance (oct/min per Hz)")
    ax.legend(fontsize=8)
    style.title(ax, "The admissible sweep rate grows with the square of the damping")
    return ax


GROUP = ClaimGroup(
    {"C35": c35, "C36": c36},
    figures={"ch3_sweep_rate": ("Fig 3.8: highest sweep rate for 90 % of the steady peak", plot)},
)
