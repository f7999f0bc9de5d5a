r"""Periodic motions of the two masses by the harmonic balance of `dynamics`, which needs no settling time.

The model is one more `System`: two masses relative to the base and a third degree of freedom, normal to the rubbing
surface, that carries the fixed normal force; one contact point of unit area with the logistic law, coefficient 1 and
normal force F_c. `HarmonicBalance` and its compiled contact do the rest, on odd harmonics alone (see `model`).

Harmonics are added, H = 7, 15, 31, ..., until the last ones are negligible or the amplitude has stopped changing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
import scipy.sparse as sp

from wroll_fem.contact.interface import Interface, NormalPenalty
from wroll_fem.contact.kernels import regularised_signs
from wroll_fem.contact.point import NORMAL
from wroll_fem.contact.smoothed_coulomb import REFERENCE_SPEED, SmoothedCoulomb, regularised_sign_slope
from wroll_fem.dynamics.periodic.aft import HarmonicContact, PeriodicContact, Sampling
from wroll_fem.dynamics.periodic.harmonic_balance import FrequencyCurve, HarmonicBalance
from wroll_fem.dynamics.reduction.condensation import condense
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.continuation import StepControl, solve_at
from wroll_fem.two_dof.model import SLIDES, Pressed
from wroll_fem.typing import FloatArray

HARMONICS = (7, 15, 31, 63, 127, 255, 511, 1023)
ACCURACY = 1e-5
"""Relative change of the amplitude with twice the harmonics below which no more are needed."""
NEGLIGIBLE = 1e-2
"""Share of the last two harmonics in the rubbing velocity, over the accuracy, below which no more are needed either."""
MORE_THAN_ENOUGH = 1e-13
"""Share below which half of them would have done: their parts fall off geometrically, down to rounding."""
CONTROL = StepControl(tolerance=1e-9)
LEAST_SLOPE = 1e-6
"""Slope F_c s (N s/m) below which a smoother law is no help any more."""


def two_mass_system(pressed: Pressed) -> System:
    """The model as a `System`: relative displacements of both masses, and one normal to the rubbing surface."""
    point = Interface(
        "primary/secondary",
        sp.csr_matrix(np.array([[0.0, 0.0, 1.0], [*SLIDES, 0.0], [0.0, 0.0, 0.0]])),  # normal, hoop, axial
        np.ones(1),
        np.zeros((1, 3)),
        SmoothedCoulomb(mu=1.0, reference_speed=1.0 / pressed.smoothing),
        NormalPenalty(pressed.capacity, separation=False),
    )

    def padded(matrix: FloatArray, normal: float) -> sp.csr_matrix:
        return sp.block_diag([matrix, [[normal]]], format="csr")

    return System(
        stiffness=padded(pressed.stiffness, 0.0),
        mass=padded(pressed.mass, 1.0),
        damping=padded(pressed.damping, 0.0),
        influence=np.array([1.0, 1.0, 0.0]),
        interfaces=(point,),
        probes={"tip": np.array([1.0, 0.0, 0.0]), "secondary": np.array([0.0, 1.0, 0.0])},
        loads={"preload": np.array([0.0, 0.0, -pressed.capacity])},
    )


class _OneLine(HarmonicContact):
    """Contact whose one point moves along a line under a fixed normal force: its derivative is one product.

    The compiled derivative for points that slide in a plane under varying pressure takes some ten times as long here.
    """

    def jacobian(self, contact: PeriodicContact, *, threshold: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """As `HarmonicContact.jacobian`; every point is taken, whatever the ``threshold``."""
        laws, s, jump = self.laws, self.sampling, self.model.jump[0]
        reach = laws.own[0, REFERENCE_SPEED] * contact.sampled.dt
        sign = regularised_signs(contact.sampled.rate[0] / reach)
        limit = laws.mu[0] * -self.preload.traction[NORMAL]
        slope = limit * regularised_sign_slope(sign) / reach  # Pa per m and sample
        block = s.project @ (slope[:, None] * s.velocities) - self.model.springs[0] * np.eye(s.size)
        by_log = s.project @ (slope * contact.sampled.rate[0])
        return np.kron(block, laws.area[0] * np.outer(jump, jump)), np.outer(by_log, laws.area[0] * jump)


class _ShakenBase(HarmonicBalance):
    """Harmonic balance under a displacement of the base that may act through springs to a wall at rest (Fig 5.1b)."""

    def __init__(self, contact: HarmonicContact, pressed: Pressed, omega: float, shapes: FloatArray):
        super().__init__(contact, pressed.base_amplitude * omega**2)
        wall = pressed.base_amplitude * (shapes.T @ pressed.unshaken)
        self._wall = -pressed.k2 * wall, pressed.c2 * omega * wall

    def load(self) -> FloatArray:
        """(R, m) force for y = -Y_0 cos(wt), whose acceleration is A cos(wt)."""
        out = super().load()
        out[1] += self._wall[0]
        out[2] += self._wall[1]
        return out


@cache
def _sampling(harmonics: int) -> Sampling:
    return Sampling(harmonics, 4 * (harmonics + 1), odd=True)


@cache
def _half_period(size: int, count: int) -> tuple[FloatArray, FloatArray]:
    """(count, size) values of odd harmonics, the constant first, over half a period, and their slopes."""
    phase = np.pi * np.arange(count) / count
    values, slopes = np.zeros((count, size)), np.zeros((count, size))
    for column in range(1, size, 2):
        values[:, column], values[:, column + 1] = np.cos(column * phase), np.sin(column * phase)
        slopes[:, column], slopes[:, column + 1] = -column * np.sin(column * phase), column * np.cos(column * phase)
    return values, slopes


@dataclass(frozen=True)
class CycleEnergy:
    """Energy of one period, J.

    Attributes
    ----------
    input : work of the base through springs and dashpots
    primary, secondary : lost in the dashpots c1 and c2
    friction : lost where the masses rub
    """

    input: float
    primary: float
    secondary: float
    friction: float

    @property
    def balance_error(self) -> float:
        """|input - losses| / input."""
        return abs(self.input - self.primary - self.secondary - self.friction) / abs(self.input)


@dataclass(frozen=True)
class PeriodicMotion:
    """One periodic motion; the base moves as y = -Y_0 cos(omega t).

    Attributes
    ----------
    omega : rad/s
    relative : (R, 2) coefficients of x_1 - y and x_2 - y, m, order (constant, cos 1, sin 1, cos 3, sin 3, ...)
    reduced : (R, 2) the same in the coordinates of the harmonic balance
    pressed : the model
    """

    omega: float
    relative: FloatArray
    reduced: FloatArray
    pressed: Pressed

    @property
    def harmonics(self) -> int:
        """Highest harmonic kept."""
        return len(self.relative) - 2

    @cached_property
    def absolute(self) -> FloatArray:
        """(R, 2) coefficients of x_1 and x_2, m."""
        out = self.relative.copy()
        out[1] -= self.pressed.base_amplitude
        return out

    @cached_property
    def transmissibility(self) -> float:
        """Largest abs(x_1) over Y_0 (the source's output; of the whole motion, not of its fundamental)."""
        count = max(128, 4 * self.harmonics)
        path = np.abs(_half_period(len(self.relative), count)[0] @ self.absolute[:, 0])
        k = int(path.argmax())
        before, here, after = path[k - 1], path[k], path[(k + 1) % count]
        curvature = before - 2.0 * here + after
        rise = (after - before) ** 2 / (8.0 * -curvature) if curvature < 0.0 else 0.0
        return float((here + rise) / self.pressed.base_amplitude)

    def energy(self, *, finer: int = 4) -> CycleEnergy:
        """Energy of a period from the equations in absolute displacements, at ``finer`` times the samples."""
        p, w = self.pressed, self.omega
        values, slopes = _half_period(len(self.relative), finer * 2 * (self.harmonics + 1))
        x, v = values @ self.absolute, w * (slopes @ self.absolute)
        y, y_dot = -p.base_amplitude * values[:, 1], p.base_amplitude * w * values[:, 2]
        a, b = p.hold
        speed_1, speed_2 = v[:, 0] - y_dot, v[:, 1] - a * v[:, 0] - b * y_dot
        pull_1 = p.k1 * (x[:, 0] - y) + p.c1 * speed_1
        pull_2 = p.k2 * (x[:, 1] - a * x[:, 0] - b * y) + p.c2 * speed_2
        rubbing = v @ SLIDES
        step = 2.0 * np.pi / w / len(values)  # both halves of the period are alike
        return CycleEnergy(
            input=-float((pull_1 + b * pull_2) @ y_dot) * step,
            primary=p.c1 * float(speed_1 @ speed_1) * step,
            secondary=p.c2 * float(speed_2 @ speed_2) * step,
            friction=p.capacity * float(regularised_signs(p.smoothing * rubbing) @ rubbing) * step,
        )


class PeriodicSolver:
    """Periodic motions of the two masses under one friction capacity.

    Parameters
    ----------
    pressed
        The model under that capacity, `TwoMasses.pressed`.
    accuracy
        Relative accuracy of the amplitude, by which harmonics are added.
    """

    def __init__(self, pressed: Pressed, *, accuracy: float = ACCURACY):
        self.pressed, self.accuracy = pressed, accuracy
        system = two_mass_system(self.pressed)
        preload = solve_preload(system, steps=1)  # nothing rubs at rest: the path does not matter
        condensation = condense(system, stick_springs(system, preload), Scheme.hht(0.0), 1.0)
        # the normal force is fixed: no motion reaches the third coordinate, which is left out
        whole = ReducedModel.complete(condensation)
        sliding = np.abs(whole.jump[2]) < 0.5
        self.reduced = ReducedModel.of_vectors(condensation, np.eye(len(sliding))[:, sliding])
        self.shapes = np.column_stack([condensation.displacement(v)[:2] for v in self.reduced.vectors.T])
        self._preload, self._laws = preload, system.laws
        self._contacts: dict[int, _OneLine] = {}

    def motion(self, omega: float, start: PeriodicMotion | None = None) -> PeriodicMotion:
        """Periodic motion at ``omega`` (rad/s).

        Parameters
        ----------
        start
            Motion at a frequency nearby, a first guess; without one the motion of the masses on their own.

        Raises
        ------
        ConvergenceError
            When Newton's method finds none.
        """
        found: PeriodicMotion | None = None
        guess = self._linear(omega) if start is None else start.reduced
        for harmonics in HARMONICS[0 if start is None else self._first_level(start) :]:
            motion = self._solve(omega, harmonics, guess)
            if _tail(motion) < NEGLIGIBLE * self.accuracy:
                return motion
            if found is not None and abs(motion.transmissibility / found.transmissibility - 1.0) < self.accuracy:
                return motion
            found, guess = motion, motion.reduced
        assert found is not None
        raise ConvergenceError(
            f"{HARMONICS[-1]} harmonics do not resolve the motion at omega = {omega:.6g} rad/s, capacity "
            f"{self.pressed.capacity:g} N",
            time_s=None, iterations=0, residual_history=[_tail(found)],
            advice="use a smaller two_dof.smoothing",
        )  # fmt: skip

    def curve(self, omegas: FloatArray) -> list[PeriodicMotion]:
        """Motions at ``omegas`` (n,), each started from the one before."""
        motions: list[PeriodicMotion] = []
        for omega in omegas:
            motions.append(self.motion(float(omega), motions[-1] if motions else None))
        return motions

    def _balance(self, omega: float, harmonics: int) -> _ShakenBase:
        if harmonics not in self._contacts:
            self._contacts[harmonics] = _OneLine(
                self.reduced, self._preload, self._laws, _sampling(harmonics), max_periods=1
            )
        return _ShakenBase(self._contacts[harmonics], self.pressed, omega, self.shapes)

    def _problem(self, omega: float, harmonics: int, guess: FloatArray) -> tuple[FrequencyCurve, FloatArray]:
        """Equations at ``omega``, and the unknowns of a guess (any R, 2)."""
        balance = self._balance(omega, harmonics)
        first = np.zeros((len(balance.orders), self.reduced.size))
        kept = min(len(first), len(guess))
        first[:kept] = guess[:kept]
        root = np.sqrt(np.maximum(self.reduced.eigenvalues, 0.0) + omega**2)
        problem = FrequencyCurve(balance, (0.9 * omega, omega / 0.9), float(np.linalg.norm(first * root)))
        return problem, problem.scaled(first, omega)

    def _solve(self, omega: float, harmonics: int, guess: FloatArray) -> PeriodicMotion:
        """Motion with ``harmonics`` from coefficients of any length."""
        problem, z = self._problem(omega, harmonics, guess)
        try:
            solution = problem.motion(solve_at(problem, z, CONTROL))[0]
        except ConvergenceError:
            solution = self._from_smoother(omega, harmonics)
        return PeriodicMotion(omega, solution @ self.shapes.T, solution, self.pressed)

    def _first_level(self, near: PeriodicMotion) -> int:
        """Where to start looking for the harmonics needed next to ``near``."""
        level, tail = HARMONICS.index(near.harmonics), _tail(near)
        return level if MORE_THAN_ENOUGH < tail < NEGLIGIBLE * self.accuracy else max(0, level - 1)

    def _from_smoother(self, omega: float, harmonics: int) -> FloatArray:
        """Coefficients (R, 2) from the motion with a law half as steep, itself found that way if need be."""
        if self.pressed.smoothing * self.pressed.capacity < LEAST_SLOPE:
            raise ConvergenceError(
                f"no periodic motion found at omega = {omega:.6g} rad/s, capacity {self.pressed.capacity:g} N",
                time_s=None, iterations=0, residual_history=[], advice="use a smaller two_dof.smoothing",
            )  # fmt: skip
        smoother = PeriodicSolver(replace(self.pressed, smoothing=0.5 * self.pressed.smoothing))
        start = smoother._solve(omega, harmonics, smoother._linear(omega)).reduced
        problem, z = self._problem(omega, harmonics, start)
        return problem.motion(solve_at(problem, z, CONTROL))[0]

    def _linear(self, omega: float) -> FloatArray:
        """(3, 2) motion with the friction force left out, its resonances blunted."""
        balance = self._balance(omega, HARMONICS[0])
        stiffness = self.reduced.eigenvalues - omega**2
        least = 0.02 * omega**2
        return np.asarray(balance.load()[:3] / np.where(np.abs(stiffness) < least, least, stiffness))


def _tail(motion: PeriodicMotion) -> float:
    """Share of the last two harmonics in the rubbing velocity."""
    order = np.arange(1.0, len(motion.relative), 2)
    parts = (motion.relative @ SLIDES)[1:].reshape(-1, 2)
    size = order * np.hypot(parts[:, 0], parts[:, 1])
    return float(size[-2:].max() / size.max())
