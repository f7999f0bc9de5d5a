"""Base-excited oscillator with one degree of freedom: exact steady transmissibility and exact sweep response."""

import numpy as np
from scipy.signal import cont2discrete, lfilter, ss2tf


def steady(frequency, f_n, zeta):
    """Closed-form absolute transmissibility of a base-excited oscillator, complex."""
    r = np.asarray(frequency) / f_n
    return (1.0 + 2j * zeta * r) / (1.0 - r**2 + 2j * zeta * r)


def swept_oscillator(motion, f_n, zeta, per_cycle=60, tail=0.0):
    """(time, base, absolute tip) by the exact recurrence for piecewise linear input (first-order hold)."""
    dt = 1.0 / (per_cycle * f_n)
    time, base = motion.samples(dt)
    if tail:
        extra = time[-1] + dt * np.arange(1, round(tail / dt))
        time, base = np.append(time, extra), np.append(base, np.zeros_like(extra))
    w = 2.0 * np.pi * f_n
    system = ([[0.0, 1.0], [-(w**2), -2 * zeta * w]], [[0.0], [-1.0]], [[-(w**2), -2 * zeta * w]], [[0.0]])
    a, b, c, d, _ = cont2discrete(tuple(map(np.array, system)), dt, method="foh")
    numerator, denominator = ss2tf(a, b, c, d)
    return time, base, lfilter(numerator[0], denominator, base)
