"""Oscillator with a spring and a Jenkins element in parallel: averaged time integration under a random base motion.

x'' + 2 zeta w0 x' + (1 - share) w0^2 x + share w0^2 e = -a_g, e' = x' while |e| < slip. Unit mass; w0 is the frequency
with the element stuck.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit

from wroll_fem.typing import FloatArray


def backbone(amplitude: FloatArray, w0: float, share: float, slip: float, zeta: float) -> tuple[FloatArray, FloatArray]:
    """Frequency (rad/s) and damping ratio at each amplitude, from the first harmonic of the loop (Caughey 1960)."""
    a = np.maximum(amplitude, slip * (1.0 + 1e-15))
    angle = np.arccos(1.0 - 2.0 * slip / a)
    in_phase = np.where(amplitude <= slip, 1.0, (angle - 0.5 * np.sin(2.0 * angle)) / np.pi)
    frequency = w0 * np.sqrt(1.0 - share + share * in_phase)
    work = np.where(amplitude <= slip, 0.0, 4.0 * share * w0**2 * slip * (a - slip))
    work += np.pi * 2.0 * zeta * w0 * frequency * amplitude**2
    return frequency, work / (2.0 * np.pi * (frequency * amplitude) ** 2)


@njit(cache=True)
def _run(force, dt, w0, share, slip, zeta, skip):  # type: ignore[no-untyped-def]
    """Central differences; sums of x^2, (x'' + a_g)^2, input and dissipated work, and the number of upcrossings."""
    x, v, e = 0.0, 0.0, 0.0
    sums = np.zeros(5)
    record = np.empty(force.shape[0])
    k1, k2, c = (1.0 - share) * w0 * w0, share * w0 * w0, 2.0 * zeta * w0
    for n in range(force.shape[0]):
        # velocity at the half step, implicit in the dashpot; the element follows the displacement of the step
        acc = force[n] - k1 * x - k2 * e
        new = ((1.0 - 0.5 * c * dt) * v + dt * acc) / (1.0 + 0.5 * c * dt)
        dx = dt * new
        mean = 0.5 * (v + new)
        if n >= skip:
            sums[0] += x * x
            total = -c * mean - k1 * x - k2 * e
            sums[1] += total * total
            sums[2] += force[n] * mean * dt
            sums[3] += c * mean * mean * dt
            if x < 0.0 and x + dx >= 0.0:
                sums[4] += 1.0
        trial = e + dx
        old = e
        e = min(max(trial, -slip), slip)
        if n >= skip:
            sums[3] += 0.5 * k2 * (old + e) * (trial - e)
        record[n] = x
        x += dx
        v = new
    return sums, record


@njit(cache=True)
def _records(forces, dt, w0, share, slip, zeta, skip):  # type: ignore[no-untyped-def]
    sums = np.zeros((forces.shape[0], 5))
    motion = np.empty(forces.shape)
    for k in range(forces.shape[0]):
        sums[k], motion[k] = _run(forces[k], dt, w0, share, slip, zeta, skip)
    return sums, motion


def random_records(
    psd: Callable[[FloatArray], FloatArray], dt: float, steps: int, records: int, rng: np.random.Generator
) -> FloatArray:
    """(records, steps) Gaussian records of a base acceleration with the one-sided ``psd`` of the frequency in Hz."""
    frequency = np.fft.rfftfreq(steps, dt)
    size = np.zeros_like(frequency)
    size[1:] = np.sqrt(psd(frequency[1:]) * steps / (4.0 * dt))
    parts = rng.standard_normal((2, records, len(frequency)))
    return np.asarray(np.fft.irfft(size * (parts[0] + 1j * parts[1]), steps, axis=1))


@dataclass(frozen=True)
class Averages:
    """Averages of integrated records: rms of displacement (m) and absolute acceleration (m/s^2), powers (W).

    ``error`` is the standard error of the rms of the displacement relative to it, ``crossings`` the upward crossings of
    zero per second, ``motion`` (records, steps) the displacements.
    """

    displacement: float
    acceleration: float
    input_power: float
    dissipated_power: float
    crossings: float
    error: float
    motion: FloatArray


def integrate(base: FloatArray, dt: float, w0: float, share: float, slip: float, zeta: float, skip: int) -> Averages:
    """Averages over the records ``base`` (records, steps) of a base acceleration, without the first ``skip`` steps."""
    sums, motion = _records(np.ascontiguousarray(-base), dt, w0, share, slip, zeta, skip)
    count = base.shape[1] - skip
    mean = sums / np.array([count, count, count * dt, count * dt, count * dt])
    error = 0.5 * mean[:, 0].std(ddof=1) / np.sqrt(len(mean)) / mean[:, 0].mean()
    both = mean.mean(axis=0)
    return Averages(
        float(np.sqrt(both[0])), float(np.sqrt(both[1])), float(both[2]), float(both[3]), float(both[4]), float(error),
        motion,
    )  # fmt: skip
