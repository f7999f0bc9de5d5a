"""Motions in time, as vectors for the basis of a reduced model.

A basis for periodic motions grows by corrections, each of which is one Newton step from a motion of a reduced model.
If most of an interface opens, this motion can be so far from the true one that the step leads nowhere. A chirp through
the resonance, integrated with all modes, needs no basis; its snapshots contain the shapes of the opening interface.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wroll_fem.contact.point import normals
from wroll_fem.dynamics.periodic.causes import UNDETERMINED_MEAN
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.errors import ConvergenceError
from wroll_fem.signals.sweeps import Chirp
from wroll_fem.typing import FloatArray

BAND = 0.5, 1.15
"""Lowest and highest frequency of the chirp, relative to that of the main mode with stuck interfaces. Slip and opening
lower the resonance."""

RATE = 60.0
"""Rate of the chirp, octaves per minute: a resonance with 2 % damping reaches most of its height."""

STEPS_PER_CYCLE, EVERY = 40, 4
"""Steps per cycle of the highest frequency, and number of steps between two snapshots."""

TOLERANCE = 1e-3
"""Residual of a converged step, relative to the elastic slip: shapes need less than motions."""

QUIET = 0.1
"""Energy norm, relative to that of the largest snapshot, below which a snapshot is left out."""

FREE_PATH, FREE_CYCLES = 1.0, 2
"""A layer slides as a whole if each of its loaded points slips by more than `FREE_PATH` times its elastic slip in each
of `FREE_CYCLES` successive cycles. In chirps through rolls with a periodic motion a quarter of the points stays."""


class WholeSlip(ConvergenceError):
    """A layer slides as a whole, so that it has no periodic motion."""

    def __init__(self, frequency: float) -> None:
        super().__init__(
            f"a layer slides as a whole (chirp in time at {frequency:.4g} Hz)",
            time_s=None, iterations=0, residual_history=[], advice=UNDETERMINED_MEAN,
        )  # fmt: skip


def snapshots_of_chirp(
    system: System,
    preload: ContactState,
    condensation: Condensation,
    *,
    amplitude: float,
    frequencies: tuple[float, float],
    on_part: Callable[[float], None] | None = None,
) -> FloatArray:
    """Motions (r, k), in modal coordinates of ``condensation``, during a chirp through its main mode.

    Parameters
    ----------
    amplitude
        Base acceleration, 0-peak, m/s^2.
    frequencies
        First and last frequency of the response curve, Hz; the chirp stays between them.
    on_part
        Called with the fraction of the chirp that is computed.

    Raises
    ------
    WholeSlip
        If a layer slides as a whole.
    ConvergenceError
        If a step does not converge.
    """
    main = condensation.main_mode[0]
    low, high = max(frequencies[0], BAND[0] * main), min(frequencies[1], BAND[1] * main)
    low, high = (low, high) if low < high else frequencies
    chirp, dt = Chirp(amplitude, low, high, RATE, 2.0), 1.0 / (STEPS_PER_CYCLE * high)
    stepper = CondensedStepper(
        system, preload, Scheme.named("transient_fidelity"), NewtonOptions(tolerance=TOLERANCE), dt=dt,
        condensation=condensation, keep_factors=True,
    )  # fmt: skip
    times = dt * np.arange(int(chirp.duration / dt) + 1)
    base, cycles = chirp.acceleration(times), chirp.phase(times) / (2.0 * np.pi)
    sliding = _WholeSlipCheck(system, preload)
    found = []
    for start in range(0, len(times) - EVERY, EVERY):
        stepper.advance(base[start : start + EVERY + 1], dt, times[start])
        if on_part is not None:
            on_part(start / len(times))
        found.append(stepper.state.motion.q.copy())
        if int(cycles[start + EVERY]) > int(cycles[start]) and sliding.after_cycle(stepper.slip.path):
            raise WholeSlip(float(chirp.frequency(times[start])))
    motions = np.column_stack(found)
    size = _energy_norm(condensation, motions)
    return motions[:, size > QUIET * size.max()]


class _WholeSlipCheck:
    """Counts the successive cycles in which all loaded points of an interface slip (`FREE_PATH`)."""

    def __init__(self, system: System, preload: ContactState) -> None:
        ends = np.cumsum([interface.n_points for interface in system.interfaces])[:-1]
        loaded = normals(preload.traction) < 0.0
        self._points = [part for part in np.split(np.arange(len(loaded)), ends) if loaded[part].any()]
        self._points = [part[loaded[part]] for part in self._points]
        self._gamma, self._path = system.laws.gamma, np.zeros(len(loaded))
        self._counts = np.zeros(len(self._points), dtype=int)

    def after_cycle(self, path: FloatArray) -> bool:
        """Whether an interface slides as a whole; ``path`` (n,) is the accumulated slip of the points, m."""
        free = path - self._path > FREE_PATH * self._gamma
        self._path = path.copy()
        self._counts = np.where([free[part].all() for part in self._points], self._counts + 1, 0)
        return bool((self._counts >= FREE_CYCLES).any())


def _energy_norm(condensation: Condensation, motions: FloatArray) -> FloatArray:
    values = np.maximum(condensation.eigenvalues, 0.0)
    return np.asarray(np.sqrt(np.einsum("ij,i,ij->j", motions, values, motions)))
