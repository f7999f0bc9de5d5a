r"""Periodic motions of the two masses by harmonic balance.

The model is a `System` with the displacements of both masses relative to the base and a third degree of freedom, normal
to the interface, for the constant normal force. The interface is one contact point of unit area with regularised
Coulomb friction, a friction coefficient of 1 and the normal force F_c. `HarmonicBalance` solves it with odd harmonics
only (see `model`).

The highest harmonic is raised, H = 7, 15, 31, ..., until the last two harmonics are negligible or the amplitude has
converged.
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
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.periodic_contact import PeriodicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.harmonic_balance import FrequencyCurve, HarmonicBalance
from wroll_fem.dynamics.reduction.condensation import condense
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.continuation import StepControl, solve_at
from wroll_fem.two_dof.model import RELATIVE_VELOCITY, PreloadedTwoMasses
from wroll_fem.typing import FloatArray

HARMONICS = (7, 15, 31, 63, 127, 255, 511, 1023)
"""Orders of the highest harmonic, tried in turn."""
ACCURACY = 1e-5
"""Relative change of the amplitude, between two successive entries of `HARMONICS`, below which it has converged."""
NEGLIGIBLE = 1e-2
"""Factor on `accuracy`. A motion has converged if the last two harmonics of the relative velocity, divided by its
largest harmonic, are smaller than this product."""
MORE_THAN_ENOUGH = 1e-13
"""Rounding level. If the last two harmonics of the relative velocity, divided by its largest harmonic, do not exceed
it, the next motion is first tried with half the number of harmonics."""
CONTROL = StepControl(tolerance=1e-9)
"""Settings of Newton's method."""
LEAST_SLOPE = 1e-6
"""Smallest slope F_c s of the friction law at zero velocity in the search for a starting motion, N s/m; at smaller
slopes the search stops with an error."""


def two_mass_system(preloaded: PreloadedTwoMasses) -> System:
    """The model as a `System` of three displacements: two relative to the base, and one normal to the contact."""
    point = Interface(
        "primary/secondary",
        sp.csr_matrix(np.array([[0.0, 0.0, 1.0], [*RELATIVE_VELOCITY, 0.0], [0.0, 0.0, 0.0]])),  # normal, hoop, axial
        np.ones(1),
        np.zeros((1, 3)),
        SmoothedCoulomb(mu=1.0, reference_speed=1.0 / preloaded.smoothing),
        NormalPenalty(preloaded.capacity, separation=False),
    )

    def padded(matrix: FloatArray, normal: float) -> sp.csr_matrix:
        return sp.block_diag([matrix, [[normal]]], format="csr")

    return System(
        stiffness=padded(preloaded.stiffness, 0.0),
        mass=padded(preloaded.mass, 1.0),
        damping=padded(preloaded.damping, 0.0),
        influence=np.array([1.0, 1.0, 0.0]),
        interfaces=(point,),
        probes={"tip": np.array([1.0, 0.0, 0.0]), "secondary": np.array([0.0, 1.0, 0.0])},
        loads={"preload": np.array([0.0, 0.0, -preloaded.capacity])},
    )


class _LineContact(HarmonicContact):
    """Contact of one point that slides along a line under a constant normal force.

    Its Jacobian needs one matrix product. It is about ten times faster than the general Jacobian, which holds for
    points that slide in a plane under varying pressure.
    """

    def jacobian(self, contact: PeriodicContact, *, threshold: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Derivatives as in `HarmonicContact.jacobian`; ``threshold`` is ignored because there is only one point."""
        laws, s, jump = self.laws, self.sampling, self.model.jump[0]
        reach = laws.own[0, REFERENCE_SPEED] * contact.sampled.dt
        sign = regularised_signs(contact.sampled.rate[0] / reach)
        limit = laws.mu[0] * -self.preload.traction[NORMAL]
        slope = limit * regularised_sign_slope(sign) / reach  # Pa per m and sample
        block = s.project @ (slope[:, None] * s.velocities) - self.model.springs[0] * np.eye(s.size)
        by_log = s.project @ (slope * contact.sampled.rate[0])
        return np.kron(block, laws.area[0] * np.outer(jump, jump)), np.outer(by_log, laws.area[0] * jump)


class _BaseDisplacementBalance(HarmonicBalance):
    """Harmonic balance under a base displacement. The secondary may be mounted on fixed ground (thesis, Fig. 5.1b)."""

    def __init__(self, contact: HarmonicContact, preloaded: PreloadedTwoMasses, omega: float, shapes: FloatArray):
        super().__init__(contact, preloaded.base_amplitude * omega**2)
        wall = preloaded.base_amplitude * (shapes.T @ preloaded.ground_coupling)
        self._wall = -preloaded.k2 * wall, preloaded.c2 * omega * wall

    def load(self) -> FloatArray:
        """Fourier coefficients (R, m) of the external force due to the base displacement y = -Y_0 cos(wt).

        R is the number of Fourier coefficients, m the number of reduced coordinates. The acceleration of the base is
        A cos(wt).
        """
        out = super().load()
        out[1] += self._wall[0]
        out[2] += self._wall[1]
        return out


@cache
def _sampling(harmonics: int) -> Sampling:
    return Sampling(harmonics, 4 * (harmonics + 1), odd=True)


@cache
def _half_period(size: int, count: int) -> tuple[FloatArray, FloatArray]:
    """Cosines and sines of odd order at phases of half a period, and their phase derivatives; both (count, size).

    The rows are ``count`` phases, the columns ``size`` Fourier coefficients: constant, cos 1, sin 1, cos 3, sin 3, ...
    Column 0, for the constant, is zero: the second half period is the first one with the opposite sign.
    """
    phase = np.pi * np.arange(count) / count
    values, slopes = np.zeros((count, size)), np.zeros((count, size))
    for column in range(1, size, 2):
        values[:, column], values[:, column + 1] = np.cos(column * phase), np.sin(column * phase)
        slopes[:, column], slopes[:, column + 1] = -column * np.sin(column * phase), column * np.cos(column * phase)
    return values, slopes


@dataclass(frozen=True)
class CycleEnergy:
    """Work during one period, J.

    Attributes
    ----------
    input : work of the base through springs and dashpots
    primary, secondary : energy dissipated in the dashpots c1 and c2
    friction : energy dissipated by friction between the masses
    """

    input: float
    primary: float
    secondary: float
    friction: float

    @property
    def balance_error(self) -> float:
        """Relative error of the energy balance, |input - dissipated energy| / |input|."""
        return abs(self.input - self.primary - self.secondary - self.friction) / abs(self.input)


@dataclass(frozen=True)
class PeriodicMotion:
    """Periodic motion under the base displacement y = -Y_0 cos(omega t).

    Attributes
    ----------
    omega : frequency of the base motion, rad/s
    relative : (R, 2) Fourier coefficients of x_1 - y and x_2 - y, m: constant, cos 1, sin 1, cos 3, sin 3, ...
    reduced : (R, 2) Fourier coefficients of the reduced coordinates of the harmonic balance
    preloaded : parameters of the model
    """

    omega: float
    relative: FloatArray
    reduced: FloatArray
    preloaded: PreloadedTwoMasses

    @property
    def harmonics(self) -> int:
        """Order of the highest harmonic."""
        return len(self.relative) - 2

    @cached_property
    def absolute(self) -> FloatArray:
        """(R, 2) Fourier coefficients of the absolute displacements x_1 and x_2, m, in the order of `relative`."""
        out = self.relative.copy()
        out[1] -= self.preloaded.base_amplitude
        return out

    @cached_property
    def transmissibility(self) -> float:
        """Largest abs(x_1) divided by Y_0, from all harmonics of the motion, as in the thesis."""
        count = max(128, 4 * self.harmonics)
        path = np.abs(_half_period(len(self.relative), count)[0] @ self.absolute[:, 0])
        k = int(path.argmax())
        before, here, after = path[k - 1], path[k], path[(k + 1) % count]
        curvature = before - 2.0 * here + after
        rise = (after - before) ** 2 / (8.0 * -curvature) if curvature < 0.0 else 0.0
        return float((here + rise) / self.preloaded.base_amplitude)

    def energy(self, *, finer: int = 4) -> CycleEnergy:
        """Work during one period, from the equations in absolute displacements.

        Parameters
        ----------
        finer
            Factor on the number of samples of the harmonic balance.
        """
        p, w = self.preloaded, self.omega
        values, slopes = _half_period(len(self.relative), finer * 2 * (self.harmonics + 1))
        x, v = values @ self.absolute, w * (slopes @ self.absolute)
        y, y_dot = -p.base_amplitude * values[:, 1], p.base_amplitude * w * values[:, 2]
        a, b = p.support_coupling
        speed_1, speed_2 = v[:, 0] - y_dot, v[:, 1] - a * v[:, 0] - b * y_dot
        pull_1 = p.k1 * (x[:, 0] - y) + p.c1 * speed_1
        pull_2 = p.k2 * (x[:, 1] - a * x[:, 0] - b * y) + p.c2 * speed_2
        sliding_velocity = v @ RELATIVE_VELOCITY
        step = 2.0 * np.pi / w / len(values)  # both halves of the period are alike
        return CycleEnergy(
            input=-float((pull_1 + b * pull_2) @ y_dot) * step,
            primary=p.c1 * float(speed_1 @ speed_1) * step,
            secondary=p.c2 * float(speed_2 @ speed_2) * step,
            friction=p.capacity * float(regularised_signs(p.smoothing * sliding_velocity) @ sliding_velocity) * step,
        )


class PeriodicSolver:
    """Solver for the periodic motions of the two masses at one friction capacity.

    Parameters
    ----------
    preloaded
        Parameters at this capacity, from `TwoMasses.preloaded`.
    accuracy
        Relative accuracy of the amplitude; it determines the number of harmonics.
    """

    def __init__(self, preloaded: PreloadedTwoMasses, *, accuracy: float = ACCURACY):
        self.preloaded, self.accuracy = preloaded, accuracy
        system = two_mass_system(self.preloaded)
        preload = solve_preload(system, steps=1)  # one step: without sliding, the load path does not matter
        condensation = condense(system, stick_springs(system, preload), Scheme.hht(0.0), 1.0)
        # the normal force is constant, so the third coordinate never moves and is left out
        whole = ReducedModel.complete(condensation)
        sliding = np.abs(whole.jump[2]) < 0.5
        self.reduced = ReducedModel.of_vectors(condensation, np.eye(len(sliding))[:, sliding])
        self.shapes = np.column_stack([condensation.displacement(v)[:2] for v in self.reduced.vectors.T])
        self._preload, self._laws = preload, system.laws
        self._contacts: dict[int, _LineContact] = {}

    def motion(self, omega: float, start: PeriodicMotion | None = None) -> PeriodicMotion:
        """Periodic motion at one frequency.

        Parameters
        ----------
        omega
            Frequency of the base motion, rad/s.
        start
            Motion at a nearby frequency as the initial guess; None for the motion without friction.

        Raises
        ------
        ConvergenceError
            If Newton's method does not converge, or the harmonics do not resolve the motion.
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
            f"harmonics do not resolve the motion at omega = {omega:.6g} rad/s, capacity {self.preloaded.capacity:g} N "
            f"(highest order tried: {HARMONICS[-1]})",
            time_s=None, iterations=0, residual_history=[_tail(found)],
            advice="reduce two_dof.smoothing",
        )  # fmt: skip

    def curve(self, omegas: FloatArray) -> list[PeriodicMotion]:
        """Periodic motions at frequencies (n,), rad/s; each motion is the initial guess of the next.

        Raises
        ------
        ConvergenceError
            If a motion is not found.
        """
        motions: list[PeriodicMotion] = []
        for omega in omegas:
            motions.append(self.motion(float(omega), motions[-1] if motions else None))
        return motions

    def _balance(self, omega: float, harmonics: int) -> _BaseDisplacementBalance:
        if harmonics not in self._contacts:
            self._contacts[harmonics] = _LineContact(
                self.reduced, self._preload, self._laws, _sampling(harmonics), max_periods=1
            )
        return _BaseDisplacementBalance(self._contacts[harmonics], self.preloaded, omega, self.shapes)

    def _problem(self, omega: float, harmonics: int, guess: FloatArray) -> tuple[FrequencyCurve, FloatArray]:
        """Equations at ``omega`` (rad/s), and the scaled unknowns of the initial guess.

        The ``guess`` (R, 2) may have any number R of Fourier coefficients.
        """
        balance = self._balance(omega, harmonics)
        first = np.zeros((len(balance.orders), self.reduced.size))
        kept = min(len(first), len(guess))
        first[:kept] = guess[:kept]
        root = np.sqrt(np.maximum(self.reduced.eigenvalues, 0.0) + omega**2)
        problem = FrequencyCurve(balance, (0.9 * omega, omega / 0.9), float(np.linalg.norm(first * root)))
        return problem, problem.scaled(first, omega)

    def _solve(self, omega: float, harmonics: int, guess: FloatArray) -> PeriodicMotion:
        """Motion with harmonics up to a given order; the initial guess may have any number of Fourier coefficients."""
        problem, z = self._problem(omega, harmonics, guess)
        try:
            solution = problem.motion(solve_at(problem, z, CONTROL))[0]
        except ConvergenceError:
            solution = self._from_smoother(omega, harmonics)
        return PeriodicMotion(omega, solution @ self.shapes.T, solution, self.preloaded)

    def _first_level(self, near: PeriodicMotion) -> int:
        """Index in `HARMONICS` at which the search starts, given a motion at a nearby frequency."""
        level, tail = HARMONICS.index(near.harmonics), _tail(near)
        return level if MORE_THAN_ENOUGH < tail < NEGLIGIBLE * self.accuracy else max(0, level - 1)

    def _from_smoother(self, omega: float, harmonics: int) -> FloatArray:
        """Fourier coefficients (R, 2) of the motion; the initial guess is the motion for half the friction-law slope.

        If that motion is not found either, the slope is halved again.
        """
        if self.preloaded.smoothing * self.preloaded.capacity < LEAST_SLOPE:
            raise ConvergenceError(
                f"no periodic motion found at omega = {omega:.6g} rad/s, capacity {self.preloaded.capacity:g} N",
                time_s=None, iterations=0, residual_history=[], advice="reduce two_dof.smoothing",
            )  # fmt: skip
        smoother = PeriodicSolver(replace(self.preloaded, smoothing=0.5 * self.preloaded.smoothing))
        start = smoother._solve(omega, harmonics, smoother._linear(omega)).reduced
        problem, z = self._problem(omega, harmonics, start)
        return problem.motion(solve_at(problem, z, CONTROL))[0]

    def _linear(self, omega: float) -> FloatArray:
        """(3, 2) Fourier coefficients of the motion without friction, with limited amplitudes at its resonances."""
        balance = self._balance(omega, HARMONICS[0])
        stiffness = self.reduced.eigenvalues - omega**2
        least = 0.02 * omega**2
        return np.asarray(balance.load()[:3] / np.where(np.abs(stiffness) < least, least, stiffness))


def _tail(motion: PeriodicMotion) -> float:
    """Larger of the last two harmonics of the relative velocity, divided by its largest harmonic."""
    order = np.arange(1.0, len(motion.relative), 2)
    parts = (motion.relative @ RELATIVE_VELOCITY)[1:].reshape(-1, 2)
    size = order * np.hypot(parts[:, 0], parts[:, 1])
    return float(size[-2:].max() / size.max())
