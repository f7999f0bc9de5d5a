"""Maps of the two masses: response over frequency and capacity, its readings, largest damping over mass and stiffness.

Work is spread over processes by capacity or design; each follows its curve along the frequency.
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
from threadpoolctl import threadpool_limits

from wroll_fem.errors import InputError
from wroll_fem.signals.damping import HalfPower, half_power
from wroll_fem.two_dof.model import TwoMasses
from wroll_fem.two_dof.periodic import PeriodicMotion, PeriodicSolver
from wroll_fem.two_dof.time import settle
from wroll_fem.typing import FloatArray

T = TypeVar("T")
Report = Callable[[int], None]

ACROSS = 12
"""Points across the half-power width of a peak that is read."""
BRACKET = 1e-4
"""Relative change of the peak below which it counts as found."""
SMALL = 0.01
"""Local maxima of the grid below this share of its largest value are not followed."""
MAP_ACCURACY = 1e-3
"""Relative accuracy of the amplitudes of a design map."""
BAND = (0.6, 1.6)
"""Frequencies over the lowest and the highest resonance of the model between which a design is searched."""


@dataclass(frozen=True)
class Response:
    """Response under one capacity.

    Attributes
    ----------
    transmissibility : (n,) largest abs(x_1) over Y_0 at the frequencies asked for
    reading : half power of the highest peak in the band, on a grid refined around it; frequencies in rad/s (!)
    refined : frequencies (m,) in rad/s and transmissibilities (m,) of that grid
    input, primary, secondary, friction : (n,) work per cycle, J; nan where the motion was found in time
    harmonics : (n,) highest harmonic kept; 0 where the motion was found in time
    """

    transmissibility: FloatArray
    reading: HalfPower
    refined: tuple[FloatArray, FloatArray]
    input: FloatArray
    primary: FloatArray
    secondary: FloatArray
    friction: FloatArray
    harmonics: np.ndarray


class _Curve:
    """Motions under one capacity, found where they are asked for, each from its nearest neighbour."""

    def __init__(self, solver: PeriodicSolver):
        self.solver = solver
        self.motions: dict[float, PeriodicMotion] = {}

    def add(self, omegas: FloatArray) -> None:
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
        """Rising frequencies and transmissibilities."""
        omegas = np.array(sorted(self.motions))
        return omegas, np.array([self.motions[w].transmissibility for w in omegas])


def peak_readings(solver: PeriodicSolver, omegas: FloatArray, known: Sequence[PeriodicMotion] = ()) -> HalfPower:
    """Half-power reading of the highest peak of `refined_curve`; its frequencies are in rad/s."""
    return half_power(*refined_curve(solver, omegas, known))


def refined_curve(
    solver: PeriodicSolver, omegas: FloatArray, known: Sequence[PeriodicMotion] = ()
) -> tuple[FloatArray, FloatArray]:
    """Rising frequencies (m,) in rad/s and transmissibilities (m,): those of ``omegas`` (n,), and more at the peak.

    Every local maximum of the grid is followed to its top, since a lightly damped peak is far narrower than any grid
    (its flanks show on it all the same); the highest is then resolved across its half-power width.

    Parameters
    ----------
    known
        Motions already computed at ``omegas``.
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
            _climb(curve, float(grid[k - 1]), float(grid[k]), float(grid[k + 1]))
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


def _climb(curve: _Curve, low: float, top: float, high: float) -> None:
    """Bisect around a local maximum until the parabola through the three points changes no more."""
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
    """Response at ``omegas`` (n,) rad/s under one ``capacity`` (N), by method "periodic" or "time".

    Raises
    ------
    ConvergenceError
        When a motion is not found.
    """
    if method == "time":
        pressed = model.pressed(capacity)
        values = np.array([settle(pressed, float(w)).transmissibility for w in omegas])
        unknown = np.full(len(omegas), np.nan)
        none = np.zeros(len(omegas), int)
        return Response(values, half_power(omegas, values), (omegas, values), unknown, unknown, unknown, unknown, none)
    solver = PeriodicSolver(model.pressed(capacity))
    with threadpool_limits(1, "blas"):
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
    """Responses under every capacity, in their order.

    Parameters
    ----------
    capacities
        Friction capacities, N.
    omegas
        (n,) rising frequencies, rad/s, n >= 5.
    workers
        Processes; the cores of this machine when None.
    on_done
        Called with the number of curves finished.

    Raises
    ------
    InputError
        For frequencies that do not rise from above 0.
    ConvergenceError
        When a motion is not found.
    """
    omegas = np.asarray(omegas, dtype=np.float64)
    if omegas.ndim != 1 or omegas.size < 5 or omegas[0] <= 0.0 or np.any(np.diff(omegas) <= 0.0):
        raise InputError("frequencies that do not rise from above 0", key="two_dof.omega", remedy="give 5 or more")
    return list(_spread(partial(response, model, omegas, method), list(capacities), workers, on_done))


@dataclass(frozen=True)
class DesignSpace:
    """Damping over mass and stiffness of the secondary.

    Attributes
    ----------
    m2, k2 : (n,), (m,) kg, N/m
    capacity : (c,) N
    zeta : (n, m, c) half-power damping of the highest peak; nan where it cannot be read
    omega_peak : (n, m, c) rad/s
    transmissibility : (n, m, c) of the peak
    """

    m2: FloatArray
    k2: FloatArray
    capacity: FloatArray
    zeta: FloatArray
    omega_peak: FloatArray
    transmissibility: FloatArray


def _reading(model: TwoMasses, points: int, capacity: float, design: tuple[float, float]) -> tuple[float, float, float]:
    changed = replace(model, m2=design[0], k2=design[1])
    solver = PeriodicSolver(changed.pressed(capacity), accuracy=MAP_ACCURACY)
    free = solver.pressed.free_frequencies
    band = np.geomspace(BAND[0] * free[0], BAND[1] * free[1], points)
    with threadpool_limits(1, "blas"):
        read = peak_readings(solver, band)
    return read.zeta, read.f_n, read.peak


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
    """Readings of the highest peak over secondary mass and stiffness and capacity (thesis, Fig. 5.7).

    Parameters
    ----------
    m2, k2, capacities
        kg, N/m, N.
    points
        Frequencies per curve before the peaks are refined, from 0.6 of the lowest to 1.6 of the highest resonance
        without friction.

    Raises
    ------
    ConvergenceError
        When a motion is not found.
    """
    tasks = [(c, (m, k)) for m in m2 for k in k2 for c in capacities]
    found = np.array(list(_spread(partial(_task, model, points), tasks, workers, on_done)))
    shape = len(m2), len(k2), len(capacities)
    zeta, omega, peak = (found[:, i].reshape(shape) for i in range(3))
    return DesignSpace(np.array(m2, float), np.array(k2, float), np.array(capacities, float), zeta, omega, peak)


def _task(model: TwoMasses, points: int, task: tuple[float, tuple[float, float]]) -> tuple[float, float, float]:
    return _reading(model, points, *task)


def _spread(work: Callable[[object], T], tasks: Sequence, workers: int | None, on_done: Report | None) -> Iterator[T]:
    """Results in the order of the tasks, from as many processes as there are cores."""
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
