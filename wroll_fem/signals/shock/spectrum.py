r"""Shock response spectra: largest responses of single-degree-of-freedom systems to a base acceleration.

A system of natural frequency :math:`\omega = 2\pi f` and damping ratio :math:`\zeta = 1/(2Q)` on the base follows

.. math:: \ddot z + 2\zeta\omega \dot z + \omega^2 z = -a_g(t), \qquad \ddot x = -(2\zeta\omega \dot z + \omega^2 z)

with the displacement z relative to the base and the absolute acceleration of its mass. Between two samples the base
acceleration is a straight line (ramp-invariant, [1]_, [2]_). In the dimensionless time :math:`\theta = \omega t` the
state :math:`(\omega^2 z, \omega \dot z)` of one step is a linear function of its start and of the line. Its
coefficients are a matrix exponential, so the states are exact. The record starts with its first sample, from rest:
a first sample that is not zero is a jump. The base acceleration is zero after the last sample; the free vibration that
follows has its extremes in closed form.

References
----------
.. [1] D. O. Smallwood, An improved recursive formula for calculating shock response spectra, Shock and Vibration
   Bulletin 51(2), 1981, 211-217.
.. [2] ISO 18431-4:2007, Signal processing, Part 4: shock-response spectrum analysis.
"""

from __future__ import annotations

import warnings
from math import ceil, inf, isfinite, pi
from typing import Literal, get_args

import numba
import numpy as np
import numpy.typing as npt
from scipy.linalg import expm

from wroll_fem.errors import InputError
from wroll_fem.signals.shock.upsampling import upsampled
from wroll_fem.typing import FloatArray

Quantity = Literal["absolute_acceleration", "relative_displacement", "pseudo_velocity"]
Interval = Literal["maximax", "primary", "residual"]
INTERVALS: tuple[Interval, ...] = get_args(Interval)

FEWEST_SAMPLES = 10
"""Samples of the record per cycle of a natural frequency below which the spectrum is doubtful."""

GOOD_SAMPLES = 20
"""Samples per cycle to which a step is divided, and to which a coarse record is resampled on request."""


def shock_spectrum(
    acceleration: npt.ArrayLike,
    dt: float,
    natural_frequencies: npt.ArrayLike,
    q: float = 10.0,
    *,
    quantity: Quantity = "absolute_acceleration",
    interval: Interval = "maximax",
    resample: bool = False,
) -> FloatArray:
    r"""Shock response spectrum of a base acceleration.

    Parameters
    ----------
    acceleration
        (n,) base acceleration, m/s^2, n >= 2.
    dt
        Time between two samples, s.
    natural_frequencies
        (m,) natural frequencies, Hz.
    q
        Quality factor Q = 1 / (2 zeta), above 0.5; `inf` for systems without damping.
    quantity
        "absolute_acceleration" of the mass (m/s^2), "relative_displacement" to the base (m), or "pseudo_velocity",
        :math:`\omega` times the relative displacement (m/s).
    interval
        "primary": during the record; "residual": after its last sample; "maximax": the larger of both.
    resample
        Whether a record with fewer than 20 samples per cycle of the highest natural frequency is resampled by
        band-limited interpolation. It is right for measured records below half their sampling rate, and wrong for
        records with jumps.

    Returns
    -------
    numpy.ndarray
        (m,) largest absolute values.

    Raises
    ------
    InputError
        If the record, the time step, a frequency or Q is out of range.

    Warns
    -----
    UserWarning
        If the record has fewer than 10 samples per cycle of the highest natural frequency.

    Notes
    -----
    The states are exact for a record of straight lines. A step of more than a twentieth of a cycle is divided, and the
    extreme between two states is that of the cubic with the values and slopes of both, with an error below 3e-5. What
    remains is that a record is no series of straight lines: the line through the samples of a sine at resonance lowers
    its amplitude by

    =================  =====  =====  =====  =====  =====
    samples per cycle  5      10     20     40     100
    =================  =====  =====  =====  =====  =====
    error              12 %   3.3 %  0.8 %  0.2 %  0.03 %
    =================  =====  =====  =====  =====  =====
    """
    if quantity not in get_args(Quantity):
        raise InputError(f"quantity = {quantity!r}", remedy=f"use one of: {', '.join(get_args(Quantity))}")
    if interval not in INTERVALS:
        raise InputError(f"interval = {interval!r}", remedy=f"use one of: {', '.join(INTERVALS)}")
    record, frequencies = _checked(acceleration, dt, natural_frequencies, q)
    record, dt = _sampled(record, dt, float(frequencies.max()), resample=resample)
    return _spectra(record, dt, frequencies, q, quantity)[INTERVALS.index(interval)]


def shock_spectra(
    acceleration: npt.ArrayLike, dt: float, natural_frequencies: npt.ArrayLike, q: float = 10.0
) -> dict[Quantity, FloatArray]:
    """All shock response spectra of a base acceleration: each quantity, in each interval.

    Parameters, errors and warnings are those of `shock_spectrum`.

    Returns
    -------
    dict
        Quantity -> (3, m) largest absolute values, in the order of `INTERVALS`.
    """
    record, frequencies = _checked(acceleration, dt, natural_frequencies, q)
    record, dt = _sampled(record, dt, float(frequencies.max()), resample=False)
    found: dict[Quantity, FloatArray] = {
        name: _spectra(record, dt, frequencies, q, name) for name in ("absolute_acceleration", "relative_displacement")
    }
    found["pseudo_velocity"] = 2.0 * pi * frequencies * found["relative_displacement"]
    return found


def _sampled(record: FloatArray, dt: float, highest: float, *, resample: bool) -> tuple[FloatArray, float]:
    """Record and time step for natural frequencies up to ``highest``, Hz."""
    samples = 1.0 / (highest * dt)
    if resample and samples < GOOD_SAMPLES:
        factor = ceil(GOOD_SAMPLES / samples - 1e-9)
        return upsampled(record, factor), dt / factor
    if samples < FEWEST_SAMPLES:
        warnings.warn(
            f"the record has {samples:.3g} samples per cycle at {highest:g} Hz, fewer than {FEWEST_SAMPLES}: straight "
            f"lines between them lower a sine of this frequency by {100 * (1 - np.sinc(1 / samples) ** 2):.2g} %; "
            "sample faster, or set resample=True for a record without jumps",
            UserWarning, stacklevel=3,
        )  # fmt: skip
    return record, dt


def _spectra(record: FloatArray, dt: float, frequencies: FloatArray, q: float, quantity: Quantity) -> FloatArray:
    """Largest responses (3, m) in the intervals."""
    zeta = 0.0 if q == inf else 0.5 / q
    of_displacement = quantity != "absolute_acceleration"
    extremes = np.array([_extremes(record, dt, f, zeta, of_displacement) for f in frequencies])
    found = np.array([extremes.max(axis=1), extremes[:, 0], extremes[:, 1]])
    omega = 2.0 * pi * frequencies
    if quantity == "relative_displacement":
        found = found / omega**2
    elif quantity == "pseudo_velocity":
        found = found / omega
    return np.asarray(found, dtype=np.float64)


def ramp_coefficients(theta: float, zeta: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    r"""Coefficients of one step of the dimensionless length :math:`\theta = \omega h` for a linear base acceleration.

    Returns
    -------
    transition, first, last
        (2, 2), (2,) and (2,): the new state :math:`(\omega^2 z, \omega \dot z)` is ``transition @ state + first * a_0 +
        last * a_1`` with the base accelerations at both ends.
    """
    generator = np.zeros((4, 4))
    generator[0, 1] = theta
    generator[1, :3] = -theta, -2.0 * zeta * theta, -theta
    generator[2, 3] = 1.0  # slope of the base acceleration, per step
    steps = expm(generator)
    return steps[:2, :2].copy(), steps[:2, 2] - steps[:2, 3], steps[:2, 3].copy()


def _extremes(record: FloatArray, dt: float, f: float, zeta: float, of_displacement: bool) -> tuple[float, float]:
    """Largest responses during and after the record, m/s^2; the displacement is multiplied by omega^2."""
    theta = 2.0 * pi * f * dt
    parts = max(1, ceil(GOOD_SAMPLES * f * dt - 1e-9))
    theta /= parts
    primary, z, v = _primary(record, parts, theta, zeta, *ramp_coefficients(theta, zeta), of_displacement)
    return primary, _residual(z, v, zeta, of_displacement)


@numba.njit(cache=True)
def _primary(record, parts, theta, zeta, transition, first, last, of_displacement):  # type: ignore[no-untyped-def]
    """Largest response during the record, with the state at its end."""
    z = v = 0.0
    value = slope = 0.0
    if not of_displacement:  # the slope of the acceleration jumps with the base acceleration
        slope = 2.0 * zeta * record[0]
    largest = 0.0
    for k in range(record.size - 1):
        rise = (record[k + 1] - record[k]) / parts
        for j in range(parts):
            a0 = record[k] + j * rise
            a1 = a0 + rise
            z, v = (
                transition[0, 0] * z + transition[0, 1] * v + first[0] * a0 + last[0] * a1,
                transition[1, 0] * z + transition[1, 1] * v + first[1] * a0 + last[1] * a1,
            )
            if of_displacement:
                new, new_slope = z, v
            else:
                new = -(2.0 * zeta * v + z)
                new_slope = -(2.0 * zeta * (new - a1) + v)
            largest = max(largest, abs(new))
            if slope * new_slope < 0.0:
                largest = max(largest, _cubic_extreme(value, slope * theta, new, new_slope * theta))
            value, slope = new, new_slope
    return largest, z, v


@numba.njit(cache=True)
def _cubic_extreme(y0, m0, y1, m1):  # type: ignore[no-untyped-def]
    """Largest absolute value at the stationary points in (0, 1) of the cubic with these values and slopes."""
    c2 = 3.0 * (y1 - y0) - 2.0 * m0 - m1
    c3 = 2.0 * (y0 - y1) + m0 + m1
    root = np.sqrt(max(c2 * c2 - 3.0 * c3 * m0, 0.0))
    largest = 0.0
    q = -(c2 + root) if c2 >= 0.0 else -c2 + root  # no cancellation
    for top, bottom in ((q, 3.0 * c3), (m0, q)):
        if bottom != 0.0:
            s = top / bottom
            if 0.0 < s < 1.0:
                largest = max(largest, abs(y0 + s * (m0 + s * (c2 + s * c3))))
    return largest


def _residual(z: float, v: float, zeta: float, of_displacement: bool) -> float:
    """Largest absolute value of the free vibration from a state (omega^2 z, omega v), m/s^2."""
    damped = np.sqrt(1.0 - zeta * zeta)
    if not of_displacement:  # the absolute acceleration of a free vibration is itself a free vibration
        y = -(2.0 * zeta * v + z)
        z, v = y, -(2.0 * zeta * y + v)
    # y = exp(-zeta theta) (z cos + s sin)(damped theta) is stationary where tan(damped theta) = v / r
    s = (v + zeta * z) / damped
    rate = damped * z + zeta * s
    phase = np.arctan2(v, rate) % pi
    top = np.exp(-zeta * phase / damped) * (z * np.cos(phase) + s * np.sin(phase))
    return float(max(abs(z), abs(top)))


def _checked(
    acceleration: npt.ArrayLike, dt: float, natural_frequencies: npt.ArrayLike, q: float
) -> tuple[FloatArray, FloatArray]:
    record = np.ascontiguousarray(acceleration, dtype=np.float64)
    frequencies = np.asarray(natural_frequencies, dtype=np.float64)
    if record.ndim != 1 or record.size < 2:
        raise InputError(f"acceleration has the shape {record.shape}", remedy="give a series of two samples or more")
    if not np.isfinite(record).all():
        where = int(np.flatnonzero(~np.isfinite(record))[0])
        raise InputError(f"acceleration[{where}] = {record[where]} is not finite", remedy="repair the record")
    if not (isfinite(dt) and dt > 0.0):
        raise InputError(f"dt = {dt:g} s is not a positive number", remedy="give the time between two samples in s")
    if frequencies.ndim != 1 or frequencies.size == 0 or not np.all((frequencies > 0.0) & (frequencies < inf)):
        raise InputError("natural_frequencies must be a series of positive numbers", remedy="give frequencies in Hz")
    if not q > 0.5:
        raise InputError(f"q = {q:g}", remedy="give Q = 1 / (2 zeta) above 0.5, for example 10 for zeta = 5 %")
    return record, frequencies
