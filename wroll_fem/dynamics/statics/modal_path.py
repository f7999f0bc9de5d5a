r"""Frequency and damping of a mode over its amplitude, from one quasi-static path of loads with the mode's shape.

The loads :math:`f = \alpha M \phi`, with the mass-normalised mode :math:`\phi` of the sticking structure, grow from
rest; :math:`q = \phi^T M v` is the modal amplitude. By Masing's rule, which holds at constant contact pressure, the
unloading branch of a cycle of amplitude q is the initial curve :math:`\alpha(q)` enlarged by two,

.. math:: \alpha_u(q_0 \cos\vartheta) = \alpha(q_0) - 2\, \alpha\!\left(\tfrac12 q_0 (1 - \cos\vartheta)\right) .

Its first harmonic gives the frequency. The dissipated energy is four times the slip work of the initial curve, because
every point slides twice as far at the same friction limit on each of two branches. Where the pressure varies,
`cycle_path` follows the cycle itself.

References
----------
Lacayo, Allen (2019), Mech. Syst. Signal Process. 118, 133, doi:10.1016/j.ymssp.2018.08.034.
Masing (1926), Proc. 2nd Int. Congress of Applied Mechanics, 332.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from scipy.interpolate import PchipInterpolator

from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.typing import FloatArray

ANGLES = 200
"""Number of Gauss points of the first harmonic of a cycle."""

NO_WORK = 1e-9
"""Slip work at the first load, relative to force times amplitude, up to which the initial curve is straight there."""


@dataclass(frozen=True)
class ModalPath:
    """Mode over its amplitude; each array (k,) has one entry per load.

    Attributes
    ----------
    amplitude : (k,) modal amplitude q, kg^(1/2) m
    force : (k,) modal force alpha, N / kg^(1/2)
    slip_work : (k,) slip work from rest, J
    error : (k,) error of the state, see `LoadPath`
    first_slip : modal amplitude at which the first point slides, kg^(1/2) m
    component_work : (k, 2) slip work from rest in the hoop and axial direction, J
    point_work : (n_points, 2) slip work from rest to the last load, by point and direction, J
    states : (k,) contact states; empty if they were not kept
    """

    PER_LOAD: ClassVar[tuple[str, ...]] = ("amplitude", "force", "slip_work", "error", "component_work")

    amplitude: FloatArray
    force: FloatArray
    slip_work: FloatArray
    error: FloatArray
    first_slip: float
    component_work: FloatArray
    point_work: FloatArray
    states: tuple[ContactState, ...] = ()

    @property
    def dissipation(self) -> FloatArray:
        """(k,) energy dissipated in a cycle, J."""
        return 4.0 * self.slip_work

    @property
    def dissipation_by_component(self) -> FloatArray:
        """(k, 2) energy dissipated in a cycle by slip in the hoop and axial direction, J."""
        return 4.0 * self.component_work

    @property
    def dissipation_by_point(self) -> FloatArray:
        """(n_points, 2) energy dissipated in a cycle of the largest amplitude, by point and direction, J."""
        return 4.0 * self.point_work

    @property
    def loop_area(self) -> FloatArray:
        """(k,) area of the cycle's loop in force over amplitude, J: the dissipation, from the curve alone."""
        curve = self.curve().antiderivative()
        return np.array([8.0 * float(curve(q)) - 4.0 * f * q for q, f in zip(self.amplitude, self.force, strict=True)])

    @property
    def frequency(self) -> FloatArray:
        """(k,) frequency of the first harmonic of a cycle, rad/s."""
        points, weights = np.polynomial.legendre.leggauss(ANGLES)
        angle, weights = 0.5 * np.pi * (points + 1.0), 0.5 * np.pi * weights
        curve, found = self.curve(), []
        for q, f in zip(self.amplitude, self.force, strict=True):
            unloading = f - 2.0 * curve(0.5 * q * (1.0 - np.cos(angle)))
            found.append(np.sqrt(2.0 / np.pi * float(weights @ (unloading * np.cos(angle))) / q))
        return np.array(found)

    @property
    def damping(self) -> FloatArray:
        """(k,) damping ratio: dissipation divided by 4 pi times the energy 1/2 w^2 q^2."""
        return self.dissipation / (2.0 * np.pi * (self.frequency * self.amplitude) ** 2)

    def joined(self, other: Self) -> Self:
        """Path with the levels of ``other``, which followed ``self``, after its own."""
        parts = {name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in self.PER_LOAD}
        return replace(other, **parts, states=self.states + other.states)

    def curve(self) -> PchipInterpolator:
        """Modal force over amplitude, from rest; up to the first load without slip it is a straight line."""
        straight = self.slip_work[0] <= NO_WORK * abs(self.force[0] * self.amplitude[0])
        start = [0.0, 0.5] if straight else [0.0]
        amplitude = np.append(np.multiply(start, self.amplitude[0]), self.amplitude)
        return PchipInterpolator(amplitude, np.append(np.multiply(start, self.force[0]), self.force))


def first_slip(path: LoadPath, load: FloatArray) -> float:
    """Factor on a ``load`` (n_dofs,), N, of either sign at which the first point slides, at the pressure at rest.

    Tractions at rest are left out: the preload leaves some points of a layered roll at their limit. The pressure
    changes with the load if the path has a stress for it.
    """
    mu, moved = path.system.laws.mu, path.stuck(load)
    limit = mu * path.start.pressure
    rate = np.linalg.norm(tangentials(path.springs * (path.system.jump @ moved)), axis=1)
    if path.stress is not None:
        rate = rate + mu * np.abs(path.stress @ moved)
    moves = rate > 0.0
    return float(np.min(limit[moves] / rate[moves], initial=np.inf))


def modal_path(
    path: LoadPath, shape: FloatArray, levels: Sequence[float], *, keep: bool = False, after: ModalPath | None = None
) -> ModalPath:  # fmt: skip
    """Follow the mode ``shape`` (n_dofs,) of the sticking structure, normalised to unit modal mass.

    Parameters
    ----------
    levels
        Increasing factors on the load at which the first point slides.
    keep
        Keep the contact state of every level.
    after
        Levels computed before on the same path, which these follow; None at rest.

    Raises
    ------
    ConvergenceError
        If a level has no equilibrium.
    """
    system, laws = path.system, path.system.laws
    inertia = system.mass @ shape
    square = float(shape @ (path.stiffness @ shape))
    first = first_slip(path, square * inertia) if after is None else after.first_slip
    amplitude, force, work, error, states = [], [], [], [], []
    done, before = (0.0, path.start) if after is None else (float(after.slip_work[-1]), path.state)
    at_points = np.zeros((system.n_points, 2)) if after is None else after.point_work.copy()
    components = []
    for level in levels:
        alpha = level * first * square
        state = path.to(alpha * inertia)
        moved = tangentials(state.jump) - tangentials(before.jump)
        slipped = moved - (state.elastic_slip - before.elastic_slip).reshape(-1, 2)
        worked = tangentials(state.traction) * slipped
        done += float(laws.area @ worked.sum(axis=1))
        at_points += laws.area[:, None] * worked
        components.append(at_points.sum(axis=0))
        amplitude.append(float(inertia @ (state.displacement - path.start.displacement)))
        force.append(alpha)
        work.append(done)
        error.append(path.error)
        if keep:
            states.append(state)
        before = state
    return ModalPath(
        np.array(amplitude), np.array(force), np.array(work), np.array(error), first, np.array(components), at_points,
        tuple(states),
    )  # fmt: skip
