"""Exact pressure in a wound roll whose radial modulus does not depend on the pressure."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import quad

from wroll_fem.typing import FloatArray


def increment(radius: FloatArray, inner: float, outer: float, *, ratio: float, core: float) -> FloatArray:
    """Pressure increment in the roll per unit pressure increment at its outer radius (solution of equation 2.5).

    The solution is s = a r^(q - 1) + b r^(-q - 1) with q^2 = E_theta/E_r and the core condition r s' = (core - 1) s at
    the inner radius.

    Parameters
    ----------
    radius
        Radii at which the increment is evaluated, m.
    inner, outer
        Inner radius (surface of the mandrel) and current outer radius of the roll, m.
    ratio
        E_theta/E_r.
    core
        E_theta/K_m + nu_theta, with the mandrel stiffness K_m.
    """
    q = np.sqrt(ratio)

    def scaled(r: FloatArray) -> FloatArray:  # r s exp(-q x) with x = ln(r / inner)
        fading = np.exp(-2.0 * q * np.log(r / inner))
        return 0.5 * ((1.0 + fading) + core / q * (1.0 - fading))

    r, end = np.asarray(radius, float), np.asarray(outer, float)
    return end / r * np.exp(q * np.log(r / end)) * scaled(r) / scaled(end)


def pressure(
    radius: FloatArray, inner: float, outer: float, *, ratio: float, core: float, tension: Callable[[float], float]
) -> FloatArray:
    """Pressure in a continuously growing roll: integral of T/a times `increment` over the radius a (T: tension stress).

    Parameters
    ----------
    radius
        (k,) radii at which the pressure is evaluated, m.
    inner, outer
        Inner and outer radius of the roll, m.
    ratio
        E_theta/E_r.
    core
        E_theta/K_m + nu_theta.
    tension
        Function from the radius (m) to the tension stress T (Pa).

    Returns
    -------
    (k,) pressure, Pa
    """

    def one(r: float) -> float:
        def rate(a: float) -> float:
            return tension(a) / a * float(increment(np.array(r), inner, a, ratio=ratio, core=core))

        near = min(outer, r * (1.0 + 20.0 / np.sqrt(ratio)))  # outer wraps hardly affect the inside of a soft roll
        return sum(
            quad(rate, a, b, epsabs=0.0, epsrel=1e-12, limit=200)[0] for a, b in ((r, near), (near, outer)) if b > a
        )

    return np.array([one(float(r)) for r in np.atleast_1d(radius)])


def pressure_of_wraps(
    radius: FloatArray, inner: float, thickness: float, tension: FloatArray, *, ratio: float, core: float
) -> FloatArray:
    """Pressure in a roll of wraps of finite thickness: sum of `increment` times T h/r over all wraps farther out.

    T h/r is the pressure that a wrap exerts: T is its tension stress, h its thickness and r its inner radius.

    Parameters
    ----------
    radius
        (k,) radii at which the pressure is evaluated, m.
    inner
        Inner radius of the roll, m.
    thickness
        Thickness h of a wrap, m.
    tension
        (wraps,) tension stress T of each wrap, Pa.
    ratio, core
        As for `pressure`.

    Returns
    -------
    (k,) pressure, Pa

    Notes
    -----
    At a radius inside a wrap, the tension of this wrap contributes in proportion to its thickness outside the radius.
    """
    under = inner + thickness * np.arange(len(tension))
    total = np.zeros(len(radius))
    for k, r in enumerate(np.asarray(radius, float)):
        outside = under >= r * (1.0 - 1e-12)
        for a, pull in zip(under[outside], tension[outside], strict=True):
            total[k] += pull * thickness / a * float(increment(np.array(r), inner, a, ratio=ratio, core=core))
        own = int(np.sum(~outside)) - 1
        if own >= 0:
            total[k] += tension[own] * max(0.0, under[own] + thickness - r) / r
    return total
