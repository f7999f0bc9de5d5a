"""Exact stress of a roll whose radial modulus does not depend on the pressure."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import quad

from wroll_fem.typing import FloatArray


def increment(radius: FloatArray, inner: float, outer: float, *, ratio: float, core: float) -> FloatArray:
    """Pressure at ``radius`` per pressure at the outer radius: a r^(q - 1) + b r^(-q - 1), q^2 = E_theta/E_r.

    Solves equation 2.5 with the core condition r s' = (core - 1) s at ``inner``, core = E_theta/K_m + nu_theta.
    """
    q = np.sqrt(ratio)

    def scaled(r: FloatArray) -> FloatArray:  # r s, divided by exp(q x)
        fading = np.exp(-2.0 * q * np.log(r / inner))
        return 0.5 * ((1.0 + fading) + core / q * (1.0 - fading))

    r, end = np.asarray(radius, float), np.asarray(outer, float)
    return end / r * np.exp(q * np.log(r / end)) * scaled(r) / scaled(end)


def pressure(
    radius: FloatArray, inner: float, outer: float, *, ratio: float, core: float, tension: Callable[[float], float]
) -> FloatArray:
    """Pressure at ``radius`` (k,) in m of a roll grown to ``outer``, Pa: integral of T/a times the increment.

    Parameters
    ----------
    ratio
        E_theta/E_r.
    core
        E_theta/K_m + nu_theta.
    tension
        Tension stress in Pa over the radius in m.
    """

    def one(r: float) -> float:
        def rate(a: float) -> float:
            return tension(a) / a * float(increment(np.array(r), inner, a, ratio=ratio, core=core))

        near = min(outer, r * (1.0 + 20.0 / np.sqrt(ratio)))  # later wraps hardly reach a soft roll's inside
        return sum(
            quad(rate, a, b, epsabs=0.0, epsrel=1e-12, limit=200)[0] for a, b in ((r, near), (near, outer)) if b > a
        )

    return np.array([one(float(r)) for r in np.atleast_1d(radius)])


def pressure_of_wraps(
    radius: FloatArray, inner: float, thickness: float, tension: FloatArray, *, ratio: float, core: float
) -> FloatArray:
    """Pressure at ``radius`` (k,) in m of a roll of wraps, Pa: sum of T h/r times the increment over the wraps outside.

    Parameters
    ----------
    thickness, tension
        Thickness of a wrap, m; (wraps,) tension stress of each, Pa.
    ratio, core
        As `pressure`.

    Notes
    -----
    Inside a wrap its own pull counts with the part of its thickness that lies outside.
    """
    under = inner + thickness * np.arange(len(tension))
    total = np.zeros(len(radius))
    for k, r in enumerate(np.asarray(radius, float)):
        outside = under >= r * (1.0 - 1e-12)
        for a, pull in zip(under[outside], tension[outside], strict=True):
            total[k] += pull * thickness / a * float(increment(np.array(r), inner, a, ratio=ratio, core=core))
        own = int(np.sum(~outside)) - 1
        if own >= 0 and not outside[own]:
            total[k] += tension[own] * max(0.0, under[own] + thickness - r) / r
    return total
