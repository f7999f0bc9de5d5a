r"""Shock response spectrum as a table, as test specifications have it, and whether any shock can have it.

Notes
-----
The absolute accelerations :math:`y_1, y_2` of two systems on the same base are related by a linear system,
:math:`y_2 = (H_2/H_1)\, y_1` with the transmissibility :math:`H = (2\zeta\omega s + \omega^2)/(s^2 + 2\zeta\omega s +
\omega^2)`. It is stable, and it has as many zeros as poles, so that :math:`\sup|y_2| \le g_{12} \sup|y_1|` with
:math:`g_{12}` the integral of the absolute value of its impulse response. A table whose values at two frequencies have
a larger ratio is the spectrum of no base motion. :math:`g_{12}` depends on Q and on the ratio of the frequencies.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import inf, log2, pi, sqrt

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

TOLERANCE_DB = 1.5
"""Tolerance of a synthesised spectrum, dB."""

LARGEST_Q = 1000.0
"""Largest quality factor of a table: systems with a higher one need more than a thousand cycles to respond."""


@dataclass(frozen=True)
class SpectrumTable:
    """Shock response spectrum (absolute acceleration, maximax), with straight lines in log-log between its rows.

    Attributes
    ----------
    frequency
        Natural frequencies, Hz, ascending, two or more.
    acceleration
        Absolute accelerations, m/s^2.
    q
        Quality factor Q = 1 / (2 zeta), above 0.5.

    Raises
    ------
    InputError
        If the table is no spectrum.
    """

    frequency: tuple[float, ...]
    acceleration: tuple[float, ...]
    q: float = 10.0

    def __post_init__(self) -> None:
        f, a = self.frequency, self.acceleration
        key = "excitation.srs"
        if len(f) != len(a) or len(f) < 2:
            raise InputError(
                f"{len(f)} frequencies and {len(a)} accelerations", key=key, remedy="give two rows or more, in pairs"
            )
        for name, values in (("frequency", f), ("acceleration", a)):
            if not all(0.0 < value < inf for value in values):
                raise InputError(
                    f"{name} = {list(values)}", key=f"{key}.{name}", remedy="give positive numbers"
                )  # fmt: skip
        if any(y <= x for x, y in pairwise(f)):
            raise InputError(
                f"frequency = {list(f)} does not ascend", key=f"{key}.frequency", remedy="sort the rows by frequency"
            )
        if not 0.5 < self.q <= LARGEST_Q:
            raise InputError(f"q = {self.q:g}", key=f"{key}.q", remedy=f"give Q above 0.5, at most {LARGEST_Q:g}")

    def lines(self, per_octave: int = 6) -> FloatArray:
        """(m,) frequencies from the first to the last row, at least `per_octave` per octave, equal ratios, Hz."""
        octaves = log2(self.frequency[-1] / self.frequency[0])
        return np.geomspace(
            self.frequency[0], self.frequency[-1], max(2, int(np.ceil(per_octave * octaves - 1e-9)) + 1)
        )

    def at(self, frequency: FloatArray) -> FloatArray:
        """Absolute acceleration of the table at `frequency` (Hz), m/s^2."""
        return np.exp(np.interp(np.log(frequency), np.log(self.frequency), np.log(self.acceleration)))

    def refuse_impossible(self) -> None:
        """Raise an error if no base motion has this spectrum, even with the tolerance of 1.5 dB used up.

        Raises
        ------
        InputError
            With the two frequencies at which the table is steepest beyond the limit.
        """
        lines = self.lines()
        level = 20.0 * np.log10(self.at(lines))
        n = len(lines)
        ratio = (lines[-1] / lines[0]) ** (1.0 / (n - 1))
        worst, where = 0.0, (0, 0)
        for apart in range(1, n):
            for sign in (1, -1):
                limit = 20.0 * np.log10(largest_ratio(round(ratio ** (sign * apart), 12), self.q)) + 2.0 * TOLERANCE_DB
                rise = sign * (level[apart:] - level[:-apart]) - limit
                k = int(np.argmax(rise))
                if rise[k] > worst:
                    worst, where = float(rise[k]), (k, k + apart)[::sign]  # type: ignore[assignment]
        if worst > 0.0:
            low, high = where
            raise InputError(
                f"no shock has this spectrum: from {lines[low]:.4g} to {lines[high]:.4g} Hz it rises by "
                f"{level[high] - level[low]:.1f} dB, and {level[high] - level[low] - worst:.1f} dB is the most that "
                f"any motion reaches with Q = {self.q:g} and the tolerance",
                key="excitation.srs", remedy=f"flatten the table by {worst:.1f} dB or more between them",
            )  # fmt: skip


@lru_cache(maxsize=4096)
def largest_ratio(ratio: float, q: float) -> float:
    """Largest ratio of the responses of a system of `ratio` times the natural frequency of another, for any motion.

    Parameters
    ----------
    ratio
        Natural frequency of the system divided by that of the other.
    q
        Quality factor of both.
    """
    zeta, r = 0.5 / q, ratio
    if r == 1.0:
        return 1.0
    # H2/H1 = r [(2 zeta s + r)(s^2 + 2 zeta s + 1)] / [(s^2 + 2 zeta r s + r^2)(2 zeta s + 1)], in units of omega_1
    damped = sqrt(1.0 - zeta * zeta)
    pole = r * complex(-zeta, damped)
    real = -0.5 / zeta

    def top(s: complex) -> complex:
        return r * (2.0 * zeta * s + r) * (s * s + 2.0 * zeta * s + 1.0)

    of_pair = top(pole) / ((2.0 * zeta * pole + 1.0) * (2.0j * r * damped))
    of_real = top(real) / (2.0 * zeta * (real * real + 2.0 * zeta * r * real + r * r))
    period = 2.0 * pi / (r * damped)
    cycles = max(1, int(np.ceil(4.0 * q)))  # what is left decays by exp(-4 pi) or more, with its sum added below
    points = 64
    t = np.arange(cycles * points) * (period / points) + 0.5 * period / points
    slow = 2.0 * np.real(of_pair * np.exp(pole * t))
    fast = abs(of_real) / abs(real)  # integral of the real pole's part alone: an upper bound, added to the other's
    oscillating = float(np.abs(slow).sum() * period / points) / (1.0 - np.exp(-zeta * r * period * cycles))
    return r + oscillating + float(fast)
