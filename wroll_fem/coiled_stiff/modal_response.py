"""Exact response of a linear structure to a sinusoidal base acceleration, by modal superposition.

With mass-normalised modes, participation Gamma_k = phi_k^T M i and displacements relative to the base,

    q_k'' + 2 zeta w_k q_k' + w_k^2 q_k = -Gamma_k a_g(t),        a_g = A sin W t,        q_k(0) = q_k'(0) = 0

has the solution (complex amplitude Q_k, damped frequency w_d = w_k sqrt(1 - zeta^2))

    q_k(t) = Im(Q_k e^(i W t)) + e^(-zeta w_k t) (a_k cos w_d t + b_k sin w_d t),
    Q_k = -Gamma_k A / (w_k^2 - W^2 + 2 i zeta w_k W),    a_k = -Im Q_k,    b_k = (zeta w_k a_k - W Re Q_k) / w_d

so there is no time step: histories are evaluated at any given times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.typing import ComplexArray, FloatArray

STEADY_CHANGE = 1e-4
"""Change of the tip motion per cycle, relative to its amplitude, below which the motion counts as steady.

The transient decays at least as fast as e^(-zeta w_1 t), where w_1 is the lowest natural frequency. If the excitation
frequency is w_1, all later cycles together change the motion by about STEADY_CHANGE / (2 pi zeta), relative to its
amplitude: by 0.08 % at zeta = 2 %.
"""

SAMPLES_PER_CYCLE = 64
"""Number of samples per cycle in the stored history."""
MOST_CYCLES = 20_000
"""Largest number of cycles; if the motion is not steady by then, the computation stops with an error."""


class ModalState(NamedTuple):
    """Modal coordinates (m sqrt(kg)) and their first and second time derivatives, (n_modes, n_times) each."""

    coordinate: FloatArray
    velocity: FloatArray
    acceleration: FloatArray


@dataclass(frozen=True)
class Oscillators:
    """Modes as independent oscillators under a sinusoidal base acceleration.

    Attributes
    ----------
    frequencies_hz
        (n_modes,) undamped natural frequencies, Hz, above 0.
    participation
        (n_modes,) modal participation phi^T M i of mass-normalised modes, sqrt(kg).
    damping_ratio
        Damping ratio of every mode, 0 < zeta < 1.

    Raises
    ------
    InputError
        If the damping ratio or a frequency is out of range.
    """

    frequencies_hz: FloatArray
    participation: FloatArray
    damping_ratio: float

    def __post_init__(self) -> None:
        if not 0.0 < self.damping_ratio < 1.0:
            raise InputError(
                f"must lie between 0 and 1, got {self.damping_ratio:g}", key="damping_ratio", remedy="use 0.02 for 2 %"
            )
        if not np.all(np.asarray(self.frequencies_hz) > 0.0):
            raise InputError(
                f"the lowest frequency is {np.min(self.frequencies_hz):g} Hz: a rigid-body motion has no steady state",
                remedy="clamp the structure at its base",
            )  # fmt: skip

    @property
    def _omega(self) -> FloatArray:
        return np.asarray(2.0 * np.pi * np.asarray(self.frequencies_hz))

    def steady(self, frequency_hz: float, amplitude: float = 1.0) -> ComplexArray:
        """Steady-state modal amplitudes under the base acceleration A sin W t.

        Parameters
        ----------
        frequency_hz
            Frequency of the base acceleration, Hz.
        amplitude
            Amplitude A of the base acceleration, 0-peak, m/s^2.

        Returns
        -------
        (n_modes,) complex amplitudes Q of q = Im(Q e^(i W t)), m sqrt(kg)
        """
        omega, driven = self._omega, 2.0 * np.pi * frequency_hz
        stiffness = omega**2 - driven**2 + 2j * self.damping_ratio * omega * driven
        return np.asarray(-amplitude * np.asarray(self.participation) / stiffness)

    def from_rest(self, times: FloatArray, frequency_hz: float, amplitude: float = 1.0) -> ModalState:
        """Modal motion that starts from rest at t = 0, from the equations of the module docstring.

        Parameters
        ----------
        times
            (n_times,) times at which the motion is evaluated, s.
        frequency_hz, amplitude
            Frequency (Hz) and amplitude (0-peak, m/s^2) of the base acceleration.
        """
        driven = 2.0 * np.pi * frequency_hz
        omega = self._omega[:, None]
        decay, damped = self.damping_ratio * omega, omega * math.sqrt(1.0 - self.damping_ratio**2)
        forced = self.steady(frequency_hz, amplitude)[:, None]
        a = -forced.imag
        b = (decay * a - driven * forced.real) / damped
        # a cos + b sin is the imaginary part of one complex exponential, so derivatives are products
        rate = -decay + 1j * damped
        free = (b + 1j * a) * np.exp(rate * times)
        steady = forced * np.exp(1j * driven * times)
        return ModalState(
            (steady + free).imag,
            (1j * driven * steady + rate * free).imag,
            (-(driven**2) * steady + rate**2 * free).imag,
        )

    def change_per_cycle(
        self, cycles: npt.NDArray[np.int64], frequency_hz: float, amplitude: float = 1.0
    ) -> FloatArray:
        """Change of the motion of each mode from the beginning to the end of each given cycle.

        It is the amplitude of q(t) - q(t - T), where t is the end of the cycle and T its duration, computed from
        displacement and velocity. It decays by e^(-zeta w T) per cycle and has no zeros, whatever the phase of the
        transient.

        Parameters
        ----------
        cycles
            (n_cycles,) numbers of the cycles, counted from 1.
        frequency_hz, amplitude
            Frequency (Hz) and amplitude (0-peak, m/s^2) of the base acceleration.

        Returns
        -------
        (n_modes, n_cycles) change during each of the cycles, m sqrt(kg)
        """
        ends = np.asarray(cycles) / frequency_hz
        now = self.from_rest(ends, frequency_hz, amplitude)
        before = self.from_rest(ends - 1.0 / frequency_hz, frequency_hz, amplitude)
        moved, rate = now.coordinate - before.coordinate, now.velocity - before.velocity
        omega = self._omega[:, None]
        decay, damped = self.damping_ratio * omega, omega * math.sqrt(1.0 - self.damping_ratio**2)
        return np.asarray(np.hypot(moved, (rate + decay * moved) / damped))


class SteadyRun(NamedTuple):
    """Response history from rest to the steady state.

    Attributes
    ----------
    time
        (n,) times, s, `SAMPLES_PER_CYCLE` per cycle from 0; the last cycle is the first one in the steady state.
    state
        Modal coordinates and their time derivatives at these times.
    change
        (n_cycles,) change of the tip motion during each cycle, relative to the steady-state amplitude of the tip.
    """

    time: FloatArray
    state: ModalState
    change: FloatArray

    @property
    def last_cycle(self) -> slice:
        """Indices of the samples of the last cycle, both ends included."""
        return slice(-SAMPLES_PER_CYCLE - 1, None)


def run_to_steady_state(
    oscillators: Oscillators,
    tip: FloatArray,
    frequency_hz: float,
    amplitude: float,
    *,
    tolerance: float = STEADY_CHANGE,
) -> SteadyRun:
    """Compute the motion from rest until the tip motion is periodic.

    Parameters
    ----------
    oscillators
        Modes of the structure.
    tip
        (n_modes,) tip displacement per modal coordinate, 1/sqrt(kg).
    frequency_hz, amplitude
        Frequency (Hz) and amplitude (0-peak, m/s^2) of the base acceleration.
    tolerance
        Largest change from one cycle to the next: the sum over the modes of the change of the tip displacement,
        relative to the steady amplitude of the tip.

    Raises
    ------
    InputError
        If no mode moves the tip.
    ConvergenceError
        If the motion is not periodic after `MOST_CYCLES` cycles.
    """
    largest = abs(np.asarray(tip) @ oscillators.steady(frequency_hz, amplitude))
    if not largest > 0.0:
        raise InputError(
            "no mode moves the tip along the excitation", key="modal.count",
            remedy="increase modal.count, or change excitation.direction",
        )  # fmt: skip
    change = np.zeros(0)
    while not np.any(change < tolerance):
        if change.size >= MOST_CYCLES:
            raise ConvergenceError(
                "no steady state reached", time_s=change.size / frequency_hz, iterations=change.size,
                residual_history=[float(c) for c in change[-5:]],
                advice="raise damping_ratio, or lower excitation.frequency",
            )  # fmt: skip
        cycles = np.arange(change.size + 1, change.size + 257)
        more = np.abs(tip) @ oscillators.change_per_cycle(cycles, frequency_hz, amplitude) / largest
        change = np.concatenate([change, more])
    change = change[: int(np.argmax(change < tolerance)) + 1]
    time = np.arange(change.size * SAMPLES_PER_CYCLE + 1) / (SAMPLES_PER_CYCLE * frequency_hz)
    return SteadyRun(time, oscillators.from_rest(time, frequency_hz, amplitude), change)


def steady_transmissibility(oscillators: Oscillators, tip: FloatArray, frequency_hz: float) -> complex:
    """Steady-state absolute tip acceleration divided by base acceleration (complex).

    It is 1 - W^2 sum_k tip_k Q_k / A, with the symbols of the module docstring.

    Parameters
    ----------
    oscillators
        Modes of the structure.
    tip
        (n_modes,) tip displacement per modal coordinate, 1/sqrt(kg).
    frequency_hz
        Frequency of the base acceleration, Hz.
    """
    driven = 2.0 * np.pi * frequency_hz
    return complex(1.0 - driven**2 * (np.asarray(tip) @ oscillators.steady(frequency_hz)))
