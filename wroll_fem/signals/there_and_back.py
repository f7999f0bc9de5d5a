"""Sweep up and back down in one motion, and its two branches."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.signals.base_motion import samples_of
from wroll_fem.signals.sweeps import Sweep
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class ThereAndBack:
    """Upward sweep, followed without a pause by the same sweep downward.

    The phase is continuous at the turn, and so is the frequency. Each branch takes the same time.

    Attributes
    ----------
    up
        First branch.

    Raises
    ------
    InputError
        If the first branch is downward.
    """

    up: Sweep

    def __post_init__(self) -> None:
        if self.up.downward:
            raise InputError(
                "a sweep up and down starts at its lowest frequency", key="excitation.f_end",
                remedy="give f_end > f_start, in Hz",
            )  # fmt: skip

    @property
    def turn(self) -> float:
        """Time at which the frequency is highest, s."""
        return self.up.duration

    @property
    def duration(self) -> float:
        """Time of both branches, s."""
        return 2.0 * self.turn

    @cached_property
    def down(self) -> Sweep:
        """Second branch, whose time starts at the turn."""
        up = self.up
        phase = up.start_phase + float(up.phase(self.turn))
        return replace(up, f_start=up.f_end, f_end=up.f_start, ramp_cycles=0.0, start_phase=phase)  # type: ignore[type-var]

    @property
    def amplitude(self) -> float:
        """Amplitude of the base acceleration, 0-peak, m/s^2."""
        return self.up.amplitude

    @property
    def ramp_cycles(self) -> float:
        """Duration of the start ramp, cycles."""
        return self.up.ramp_cycles

    def _joined(self, of: str, time: npt.ArrayLike) -> FloatArray:
        t = np.asarray(time, dtype=np.float64)
        first = getattr(self.up, of)(np.minimum(t, self.turn))
        second = getattr(self.down, of)(np.maximum(t - self.turn, 0.0))
        return np.asarray(np.where(t < self.turn, first, second))

    def frequency(self, time: npt.ArrayLike) -> FloatArray:
        """Instantaneous frequency at `time` (s), Hz."""
        return self._joined("frequency", time)

    def phase(self, time: npt.ArrayLike) -> FloatArray:
        """Phase at `time` (s), rad: the exact integral of 2 pi f, zero at t = 0."""
        t = np.asarray(time, dtype=np.float64)
        return np.asarray(self._joined("phase", t) + np.where(t < self.turn, 0.0, self.up.phase(self.turn)))

    def acceleration(self, time: npt.ArrayLike) -> FloatArray:
        """Base acceleration at `time` (s), m/s^2."""
        return self._joined("acceleration", time)

    def samples(self, dt: float) -> tuple[FloatArray, FloatArray]:
        """Times 0, dt, ... (s) up to or just beyond `duration`, and base accelerations (m/s^2) at these times, (n,).

        Raises
        ------
        InputError
            If `dt` is not positive.
        """
        return samples_of(self, dt)

    def branches(self, history: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
        """Upward and downward part of a time history; the time of the second one starts at the turn."""
        time = history["time"].values
        at = int(np.searchsorted(time, self.turn))
        down = history.isel(time=slice(at, None))
        return history.isel(time=slice(None, at)), down.assign_coords(time=down["time"] - self.turn)
