"""Maps of the two masses: response versus frequency, with refined peaks; damping versus secondary mass and stiffness.

Curves are distributed over processes; each process follows one curve along the frequency.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TypeVar

import numpy as np

from wroll_fem.blas import one_thread
from wroll_fem.errors import InputError
from wroll_fem.signals.damping import HalfPower, half_power
from wroll_fem.two_dof.model import TwoMasses
from wroll_fem.two_dof.periodic import PeriodicMotion, PeriodicSolver
from wroll_fem.two_dof.time import integrate_to_steady_state
from wroll_fem.typing import FloatArray

T = TypeVar("T")
Report = Callable[[int], None]

ACROSS = 12
"""Number of frequencies across the half-power width of the highest peak."""
BRACKET = 1e-4
"""Relative change of a maximum below which the search for it has converged."""
SMALL = 0.01
"""Height of a local maximum, relative to the largest value, below which it is not refined."""
MAP_ACCURACY = 1e-3
"""Relative accuracy of the amplitudes of a design map."""
BAND = (0.6, 1.6)
"""Frequency band of a design map: lower limit divided by the lowest natural frequency, upper limit divided by the
highest."""


@dataclass(frozen=True)
class Response:
    """Response of the two masses at one friction capacity.

    Attributes
    ----------
    transmissibility : (n,) largest abs(x_1) divided by Y_0, at the given frequencies
    half_power : half-power damping of the highest peak on a refined grid; its frequencies are in rad/s
    refined : frequencies (m,) in rad/s and transmissibilities (m,) of the refined grid
    input, primary, secondary, friction : (n,) work per cycle, J; nan for motions found by time integration
    harmonics : (n,) highest harmonic used; 0 for motions found by time integration
    """

    transmissibility: FloatArray
    half_power: HalfPower
    refined: tuple[FloatArray, FloatArray]
    input: FloatArray
    primary: FloatArray
    secondary: FloatArray
    friction: FloatArray
    harmonics: np.ndarray


class _Curve:
    """Periodic motions at one friction capacity, computed on demand; the initial guess is the nearest known motion."""

    def __init__(self, solver: PeriodicSolver):
        self.solver = solver
        self.motions: dict[float, PeriodicMotion] = {}

    def add(self, omegas: FloatArray) -> None:
        """Compute the motions at the frequencies (rad/s); the initial guess of each is the nearest known motion."""
        known = np.array(sorted(self.motions))
        last: PeriodicMotion | None = None
        for omega in np.sort(omegas):
            start = last
            if len(known):
                near = known[np.argmin(np.abs(known - omega))]
                if last is None or abs(near - omega) < abs(last.omega - omega):
                    start = self.motions[near]
            last = self.solver.motion(float(omega), start)
            self.motions[float(omega)] = last

    @property
    def line(self) -> tuple[FloatArray, FloatArray]:
        """Frequencies (rad/s, ascending) and transmissibilities of all known motions."""
        omegas = np.array(sorted(self.motions))
        return omegas, np.array([self.motions[w].transmissibility for w in omegas])


def peak_half_power(solver: PeriodicSolver, omegas: FloatArray, known: Sequence[PeriodicMotion] = ()) -> HalfPower:
    """Half-power damping of the highest peak of a transmissibility curve, on the frequency grid of `refined_curve`.

    Parameters
    ----------
    solver
        Solver at one friction capacity.
    omegas
        (n,) initial frequencies, rad/s, ascending.
    known
        Motions already computed at these frequencies.

    Returns
    -------
    HalfPower
        Its frequencies are in rad/s.

    Raises
    ------
    ConvergenceError
        If a motion is not found.
    """
    return half_power(*refined_curve(solver, omegas, known))


def refined_curve(
    solver: PeriodicSolver, omegas: FloatArray, known: Sequence[PeriodicMotion] = ()
) -> tuple[FloatArray, FloatArray]:
    """Transmissibility curve on a frequency grid that is refined at the peaks.

    A lightly damped peak is much narrower than the steps of the initial grid, but its flanks are resolved. Every local
    maximum is therefore bracketed and refined. The highest one is then resolved across its half-power width.

    Parameters
    ----------
    solver
        Solver at one friction capacity.
    omegas
        (n,) initial frequencies, rad/s, ascending.
    known
        Motions already computed at these frequencies.

    Returns
    -------
    omega : (m,) frequencies, rad/s, ascending.
    transmissibility : (m,)

    Raises
    ------
    ConvergenceError
        If a motion is not found.
    """
    curve = _Curve(solver)
    if known:
        curve.motions = {float(m.omega): m for m in known}
    else:
        curve.add(omegas)
    grid, values = curve.line
    inner = (values[1:-1] >= values[:-2]) & (values[1:-1] > values[2:])
    for k in np.flatnonzero(inner) + 1:
        if values[k] > SMALL * values.max():
            _refine_peak(curve, float(grid[k - 1]), float(grid[k]), float(grid[k + 1]))
    for _ in range(40):
        line = curve.line
        read = half_power(*line)
        if not read.complete:
            break
        width = read.f_high - read.f_low
        ends = read.f_low - 0.3 * width, read.f_high + 0.3 * width
        wanted = [0.5 * (a + b) for a, b in pairwise(line[0]) if b - a > width / ACROSS and b > ends[0] and a < ends[1]]
        if not wanted:
            break
        curve.add(np.array(wanted))
    return curve.line


def _refine_peak(curve: _Curve, low: float, top: float, high: float) -> None:
    """Bisect the intervals around a local maximum until its value has converged."""
    best = 0.0
    for _ in range(30):
        wanted = np.array([0.5 * (low + top), 0.5 * (top + high)])
        curve.add(wanted)
        five = [low, wanted[0], top, wanted[1], high]
        values = [curve.motions[w].transmissibility if w in curve.motions else 0.0 for w in map(float, five)]
        k = 1 + int(np.argmax(values[1:4]))
        low, top, high = five[k - 1], five[k], five[k + 1]
        drop = max(values[k] - values[k - 1], values[k] - values[k + 1]) / values[k]
        if drop < 0.05 and abs(values[k] / max(best, 1e-300) - 1.0) < BRACKET:
            return
        best = values[k]


def response(model: TwoMasses, omegas: FloatArray, method: str, capacity: float) -> Response:
    """Compute the response of the two masses at one friction capacity.

    Parameters
    ----------
    model
        Parameters of the two masses.
    omegas
        (n,) frequencies, rad/s, ascending.
    method
        "periodic" (harmonic balance) or "time" (time integration from rest).
    capacity
        Friction capacity, N.

    Raises
    ------
    ConvergenceError
        If a motion is not found.
    """
    if method == "time":
        preloaded = model.preloaded(capacity)
        values = np.array([integrate_to_steady_state(preloaded, float(w)).transmissibility for w in omegas])
        unknown = np.full(len(omegas), np.nan)
        none = np.zeros(len(omegas), int)
        return Response(values, half_power(omegas, values), (omegas, values), unknown, unknown, unknown, unknown, none)
    solver = PeriodicSolver(model.preloaded(capacity))
    with one_thread():
        motions = solver.curve(omegas)
        refined = refined_curve(solver, omegas, motions)
    energies = [motion.energy() for motion in motions]
    return Response(
        np.array([m.transmissibility for m in motions]),
        half_power(*refined),
        refined,
        input=np.array([e.input for e in energies]),
        primary=np.array([e.primary for e in energies]),
        secondary=np.array([e.secondary for e in energies]),
        friction=np.array([e.friction for e in energies]),
        harmonics=np.array([m.harmonics for m in motions]),
    )


def response_map(
    model: TwoMasses,
    capacities: Sequence[float],
    omegas: FloatArray,
    *,
    method: str = "periodic",
    workers: int | None = None,
    on_done: Report | None = None,
) -> list[Response]:
    """Responses at several friction capacities, in the order of the capacities.

    Parameters
    ----------
    model
        Parameters of the two masses.
    capacities
        Friction capacities, N.
    omegas
        (n,) frequencies, rad/s, ascending, n >= 5.
    method
        "periodic" (harmonic balance) or "time" (time integration from rest).
    workers
        Number of processes; None for the number of cores.
    on_done
        Function called with the number of finished curves.

    Raises
    ------
    InputError
        If the frequencies are not positive and increasing, or fewer than 5.
    ConvergenceError
        If a motion is not found.
    """
    omegas = np.asarray(omegas, dtype=np.float64)
    if omegas.ndim != 1 or omegas.size < 5 or omegas[0] <= 0.0 or np.any(np.diff(omegas) <= 0.0):
        raise InputError(
            "the frequencies must be positive and increasing", key="two_dof.omega", remedy="give 5 or more of them"
        )
    return list(_spread(partial(response, model, omegas, method), list(capacities), workers, on_done))


@dataclass(frozen=True)
class DesignSpace:
    """Damping as a function of secondary mass, secondary stiffness and friction capacity.

    Attributes
    ----------
    m2, k2 : (n,) secondary masses, kg, and (m,) secondary stiffnesses, N/m
    capacity : (c,) friction capacities, N
    zeta : (n, m, c) half-power damping of the highest peak; nan if a half-power point is missing
    omega_peak : (n, m, c) frequency of the highest peak, rad/s
    transmissibility : (n, m, c) height of the highest peak
    """

    m2: FloatArray
    k2: FloatArray
    capacity: FloatArray
    zeta: FloatArray
    omega_peak: FloatArray
    transmissibility: FloatArray


def _peak_of_design(
    model: TwoMasses, points: int, capacity: float, design: tuple[float, float]
) -> tuple[float, float, float]:
    changed = replace(model, m2=design[0], k2=design[1])
    solver = PeriodicSolver(changed.preloaded(capacity), accuracy=MAP_ACCURACY)
    free = solver.preloaded.free_frequencies
    band = np.geomspace(BAND[0] * free[0], BAND[1] * free[1], points)
    with one_thread():
        read = peak_half_power(solver, band)
    return (read.zeta, read.f_n, read.peak) if read.resonant else (np.nan, np.nan, np.nan)


def design_space(
    model: TwoMasses,
    m2: Sequence[float],
    k2: Sequence[float],
    capacities: Sequence[float],
    *,
    points: int = 48,
    workers: int | None = None,
    on_done: Report | None = None,
) -> DesignSpace:
    """Damping of the highest peak for each secondary mass, secondary stiffness and capacity (thesis, Fig. 5.7).

    Parameters
    ----------
    model
        Parameters of the two masses; m2 and k2 are replaced.
    m2, k2, capacities
        Secondary masses (kg) and stiffnesses (N/m), friction capacities (N).
    points
        Number of frequencies per curve before refinement, from 0.6 of the lowest to 1.6 of the highest natural
        frequency without friction.
    workers
        Number of processes; None for the number of cores.
    on_done
        Function called with the number of finished curves.

    Raises
    ------
    ConvergenceError
        If a motion is not found.
    """
    tasks = [(c, (m, k)) for m in m2 for k in k2 for c in capacities]
    found = np.array(list(_spread(partial(_task, model, points), tasks, workers, on_done)))
    shape = len(m2), len(k2), len(capacities)
    zeta, omega, peak = (found[:, i].reshape(shape) for i in range(3))
    return DesignSpace(np.array(m2, float), np.array(k2, float), np.array(capacities, float), zeta, omega, peak)


def _task(model: TwoMasses, points: int, task: tuple[float, tuple[float, float]]) -> tuple[float, float, float]:
    return _peak_of_design(model, points, *task)


def _spread(work: Callable[[object], T], tasks: Sequence, workers: int | None, on_done: Report | None) -> Iterator[T]:
    """Apply a function to tasks in several processes; the results keep the order of the tasks."""
    count = min(len(os.sched_getaffinity(0)) if workers is None else workers, len(tasks))
    if count < 2 or multiprocessing.current_process().daemon:
        for done, task in enumerate(tasks):
            yield work(task)
            if on_done is not None:
                on_done(done + 1)
        return
    chunk = max(1, len(tasks) // (16 * count))
    with ProcessPoolExecutor(count) as pool:
        for done, result in enumerate(pool.map(work, tasks, chunksize=chunk)):
            yield result
            if on_done is not None:
                on_done(done + 1)
