r"""Frequency and damping of a mode over its amplitude, from cycles that are followed load by load.

Where the pressure varies with the motion, the branches of a cycle are not the initial curve enlarged by two (Masing).
After each load of the initial curve the loads :math:`\alpha \cos\vartheta` follow at equal steps of the angle, until a
cycle closes; the initial curve then goes on from where it was. With the branches :math:`\alpha_\pm(q)` between the ends
:math:`q_m \pm q_0` the frequency is that of the first harmonic,

.. math:: \omega^2 = \frac{1}{\pi q_0} \int_0^{\pi} \left[\alpha_-(q_m + q_0 \cos\vartheta)
          + \alpha_+(q_m + q_0 \cos\vartheta)\right] \cos\vartheta \, d\vartheta .

The slip work of a step is the slip times the mean friction limit from where the point starts to slide; traction and
limit are linear in the step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from scipy.interpolate import PchipInterpolator

from wroll_fem.contact.kernels import SLIP, STICK
from wroll_fem.contact.point import EVERY, normals, stick_stiffness, tangentials
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import ANGLES, ModalPath, modal_path
from wroll_fem.typing import FloatArray

STEPS = 16
"""Default number of loads of a half cycle."""

CLOSED, MOST_CYCLES = 2e-3, 4
"""Difference of the ends of a cycle, relative to its amplitude, up to which it is closed; most of the cycles."""


def _none() -> FloatArray:
    return np.zeros(0)


@dataclass(frozen=True)
class CyclePath(ModalPath):
    """Mode over its amplitude, from cycles; the slip work of the base class is that of the initial curve.

    Attributes
    ----------
    cycle_frequency : (k,) frequency of the first harmonic of a cycle, rad/s
    cycle_work : (k, 2) energy dissipated in a cycle by slip in the hoop and axial direction, J
    cycle_point_work : (n_points, 2) the same at each point, at the largest amplitude, J
    cycle_area : (k,) area of the loop in force over amplitude, J
    closure : (k,) difference of the ends of a cycle, relative to its amplitude

    The amplitude is half the range of a cycle. The states are those at its upper end, with half of the range of the
    displacements; the status is `SLIP` where a point slid or opened at any load of the cycle.
    """

    PER_LOAD: ClassVar[tuple[str, ...]] = (
        *ModalPath.PER_LOAD, "cycle_frequency", "cycle_work", "cycle_area", "closure",
    )  # fmt: skip

    cycle_frequency: FloatArray = field(default_factory=_none)
    cycle_work: FloatArray = field(default_factory=_none)
    cycle_point_work: FloatArray = field(default_factory=_none)
    cycle_area: FloatArray = field(default_factory=_none)
    closure: FloatArray = field(default_factory=_none)

    @property
    def dissipation(self) -> FloatArray:
        """(k,) energy dissipated in a cycle, J."""
        return np.asarray(self.cycle_work.sum(axis=1))

    @property
    def dissipation_by_component(self) -> FloatArray:
        """(k, 2) energy dissipated in a cycle by slip in the hoop and axial direction, J."""
        return self.cycle_work

    @property
    def dissipation_by_point(self) -> FloatArray:
        """(n_points, 2) energy dissipated in a cycle of the largest amplitude, by point and direction, J."""
        return self.cycle_point_work

    @property
    def loop_area(self) -> FloatArray:
        """(k,) area of the cycle's loop in force over amplitude, J."""
        return self.cycle_area

    @property
    def frequency(self) -> FloatArray:
        """(k,) frequency of the first harmonic of a cycle, rad/s."""
        return self.cycle_frequency


def cycle_path(
    path: LoadPath,
    shape: FloatArray,
    levels: Sequence[float],
    *,
    keep: bool = False,
    after: CyclePath | None = None,
    steps: int = STEPS,
) -> CyclePath:
    """Follow the mode ``shape`` as `modal_path` does, with a cycle at each level.

    Parameters
    ----------
    steps
        Number of loads of a half cycle.

    Raises
    ------
    ConvergenceError
        If a load has no equilibrium.
    """
    found, before = None, after
    for level in levels:
        initial = modal_path(path, shape, [level], after=before)
        at = path.state
        cycle = _closed_cycle(path, path.system.mass @ shape, float(initial.force[0]), steps)
        path.state = at
        numbers = {name: getattr(initial, name) for name in ModalPath.PER_LOAD} | cycle.per_load
        before = CyclePath(
            **numbers, first_slip=initial.first_slip, point_work=initial.point_work, cycle_point_work=cycle.point_work,
            states=(cycle.state,) if keep else (),
        )  # fmt: skip
        found = before if found is None else found.joined(before)
    if found is None:
        raise ValueError("cycle_path needs at least one level")
    return found


@dataclass(frozen=True)
class _Cycle:
    """Numbers of a closed cycle, each (1, ...), slip work at the points (n, 2), and the state at its upper end."""

    per_load: dict[str, FloatArray]
    point_work: FloatArray
    state: ContactState


def _closed_cycle(path: LoadPath, inertia: FloatArray, force: float, steps: int) -> _Cycle:
    """Cycle between the loads ``force`` and -``force``, N / kg^(1/2), from the state at the upper end."""
    rest, loads = path.start.displacement, force * np.cos(np.linspace(0.0, 2.0 * np.pi, 2 * steps + 1))
    for _ in range(MOST_CYCLES):
        upper, before = path.state, path.state
        q, work = [float(inertia @ (upper.displacement - rest))], np.zeros((path.system.n_points, 2))
        slid, low, error = np.zeros(path.system.n_points, bool), upper, 0.0
        for number, load in enumerate(loads[1:], start=1):
            state = path.to(load * inertia)
            work += _slip_work(path, before, state)
            q.append(float(inertia @ (state.displacement - rest)))
            slid |= state.status != STICK
            error = max(error, path.error)
            low = state if number == steps else low
            before = state
        amplitude = 0.5 * (q[0] - q[steps])
        closure = abs(q[-1] - q[0]) / abs(amplitude)
        if closure <= CLOSED:
            break
    moved = 0.5 * (path.state.displacement - low.displacement)
    kept = replace(path.state, displacement=rest + moved, status=np.where(slid, SLIP, STICK))
    area, frequency = _loop(np.array(q), loads, steps)
    numbers = {
        "amplitude": [amplitude], "error": [error], "closure": [closure], "cycle_area": [area],
        "cycle_frequency": [frequency], "cycle_work": [work.sum(axis=0)],
    }  # fmt: skip
    return _Cycle({name: np.array(values) for name, values in numbers.items()}, work, kept)


def _slip_work(path: LoadPath, before: ContactState, state: ContactState) -> FloatArray:
    """(n_points, 2) slip work of a step in the hoop and axial direction, J."""
    laws, tiny = path.system.laws, np.finfo(float).tiny
    moved = tangentials(state.jump) - tangentials(before.jump)
    slip = moved - (state.elastic_slip - before.elastic_slip).reshape(-1, 2)
    size = np.linalg.norm(slip, axis=1)
    along = slip / np.maximum(size, tiny)[:, None]
    first, last = (-laws.kn * normals(at.jump) for at in (before, state))  # below zero where a point is open
    limits = [laws.mu * np.maximum(0.0, pressure) for pressure in (first, last)]
    spare = limits[0] - (tangentials(before.traction) * along).sum(axis=1)
    growth = stick_stiffness(EVERY, path.start.pressure, laws) * (moved * along).sum(axis=1) - (limits[1] - limits[0])
    part = np.divide(spare, growth, out=np.zeros_like(spare), where=growth > spare)
    sticks = np.clip(part, 0.0, 1.0)  # part of the step
    mean = laws.mu * _mean_positive(first + sticks * (last - first), last)
    slid = state.status != STICK  # at a point that sticks, slip would be rounding error
    return np.asarray((slid * laws.area * mean * size)[:, None] * along**2)


def _mean_positive(first: FloatArray, last: FloatArray) -> FloatArray:
    """Mean of the positive part of a number that changes linearly from ``first`` to ``last``."""
    low, high = np.minimum(first, last), np.maximum(first, last)
    crosses = (low < 0.0) & (high > 0.0)
    part = np.where(crosses, high / np.where(crosses, high - low, 1.0), 1.0)
    return np.asarray(0.5 * part * (np.maximum(low, 0.0) + np.maximum(high, 0.0)))


def _loop(q: FloatArray, loads: FloatArray, steps: int) -> tuple[float, float]:
    """Area of a loop, J, and frequency of its first harmonic, rad/s."""
    nodes, weights = np.polynomial.legendre.leggauss(ANGLES)
    angle, weights = 0.5 * np.pi * (nodes + 1.0), 0.5 * np.pi * weights
    middle, amplitude = 0.5 * (q[0] + q[steps]), 0.5 * (q[0] - q[steps])
    down = PchipInterpolator(q[: steps + 1][::-1], loads[: steps + 1][::-1])
    up = PchipInterpolator(q[steps:], loads[steps:])
    at = middle + amplitude * np.cos(angle)
    low, high = max(q[steps], up.x[0]), min(q[0], q[-1])
    area = float(up.integrate(low, high) - down.integrate(low, high))
    harmonic = float(weights @ ((down(at) + up(np.clip(at, up.x[0], up.x[-1]))) * np.cos(angle)))
    return area, float(np.sqrt(harmonic / (np.pi * amplitude)))
