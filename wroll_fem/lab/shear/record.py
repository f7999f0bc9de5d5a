"""Record of a shear test: time, displacement of the platen and force, with the normal force of one piston."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

FEWEST = 40
"""Samples that a record has at least."""

WIDTH = 9
"""Samples of the moving mean that finds events and windows; no result is computed from smoothed data."""


@dataclass(frozen=True, eq=False)
class ShearRecord:
    """Record of a double shear test.

    Attributes
    ----------
    time, displacement, force
        (n,) time, s, rising; displacement of the platen, m; force of the machine on both stacks, N.
    normal_force
        Force F_N of one piston, N; NaN if it is unknown.
    source
        File, for messages.

    Raises
    ------
    InputError
        If the record is too short, its columns differ in length or are not finite, or its time does not rise.
    """

    time: FloatArray
    displacement: FloatArray
    force: FloatArray
    normal_force: float = float("nan")
    source: str = "record"

    def __post_init__(self) -> None:
        lengths = {len(values) for values in (self.time, self.displacement, self.force)}
        if len(lengths) != 1:
            raise InputError("columns of different length", file=self.source, remedy="give one value per sample")
        if min(lengths) < FEWEST:
            raise InputError(
                f"{min(lengths)} samples", file=self.source, remedy=f"give a record of {FEWEST} samples or more"
            )
        if not self.normal_force > 0.0 and not np.isnan(self.normal_force):
            raise InputError(
                f"the normal force is {self.normal_force:g} N", file=self.source, key="normal_force",
                remedy="give the force of one piston, above 0",
            )  # fmt: skip
        falls = np.flatnonzero(np.diff(self.time) <= 0.0)
        if falls.size:
            k = int(falls[0])
            raise InputError(
                f"time does not rise: sample {k + 2} is at {self.time[k + 1]:g} s, the one before at "
                f"{self.time[k]:g} s", file=self.source, remedy="sort the record, or write the time with more digits",
            )  # fmt: skip

    @property
    def smooth_force(self) -> FloatArray:
        """(n,) moving mean of the force, N."""
        return np.asarray(uniform_filter1d(self.force, WIDTH, mode="nearest"))

    @property
    def smooth_noise(self) -> float:
        """Standard deviation of the noise of the smoothed force, N (robust: the median of its second differences)."""
        smooth = self.smooth_force
        bent = smooth[2 * WIDTH :] - 2.0 * smooth[WIDTH:-WIDTH] + smooth[: -2 * WIDTH]
        return float(np.median(np.abs(bent)) / 0.6745 / np.sqrt(6.0))

    @property
    def coefficient(self) -> FloatArray:
        """(n,) coefficient of friction F/(2 F_N) while both stacks slide (thesis, equation E.5)."""
        return self.force / (2.0 * self.known_normal_force)

    @property
    def known_normal_force(self) -> float:
        """Normal force, N.

        Raises
        ------
        InputError
            If it is unknown.
        """
        if np.isnan(self.normal_force):
            raise InputError(
                "the normal force is missing", key="normal_force", file=self.source,
                remedy="add it (force of one piston, N; a list has one value per file)",
            )  # fmt: skip
        return self.normal_force

    def part(self, start: int, stop: int) -> ShearRecord:
        """Samples from ``start`` to ``stop`` - 1."""
        own = slice(start, stop)
        return replace(self, time=self.time[own], displacement=self.displacement[own], force=self.force[own])

    def slope(self, start: int, stop: int) -> float:
        """Force over displacement, N/m, of samples from ``start`` to ``stop`` - 1, without confidence."""
        return self.line(start, stop)[0]

    def line(self, start: int, stop: int) -> tuple[float, float]:
        """Slope, N/m, and offset, N, of the force over the displacement, of samples from ``start`` to ``stop`` - 1.

        Raises
        ------
        InputError
            If the displacement stands still.
        """
        x, force = self.displacement[start:stop], self.force[start:stop]
        if len(x) < 2 or not np.ptp(x) > 0.0:
            raise InputError(
                "the displacement stands still while the force changes", file=self.source,
                remedy="check the columns, and the resolution of the displacement",
            )  # fmt: skip
        slope, offset = np.polyfit(x, force, 1)
        return float(slope), float(offset)
