r"""Harmonic balance: equations for the periodic motions of a preloaded structure with friction.

With :math:`q = Q_0 + \sum_k Q^c_k \cos k\omega t + Q^s_k \sin k\omega t` in the coordinates of a `ReducedModel`, every
harmonic of the residual of the equation of motion has to vanish,

.. math::
    [-(k\omega)^2 + i k \omega C + \Lambda]\, Q_k + (G\Phi)^T W s_k = -b\, a_g\, \delta_{k1}, \qquad
    s = t - t_0 - D_0 (g - g_0)

with s from the alternating frequency/time method (room `aft`). Arc-length continuation follows response curves past
their folds. The unknowns are scaled by sqrt(lambda + omega^2): the norm of a scaled motion is its energy norm.

References
----------
Krack, Gross (2019), Harmonic Balance for Nonlinear Vibration Problems, doi:10.1007/978-3-030-14023-6.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wroll_fem.dynamics.aft import kernel
from wroll_fem.dynamics.aft.harmonic_contact import PRESSURE_CHANGE, HarmonicContact
from wroll_fem.dynamics.aft.periodic_contact import PeriodicContact
from wroll_fem.dynamics.aft.tangent_map import TangentMap
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.bordered import fill_scaled
from wroll_fem.numerics.continuation import StepControl, solve_at
from wroll_fem.typing import FloatArray

BAND_SCALE = 3.0
"""Length of the frequency band in scaled unknowns. It sets the weight of the frequency in the arc length of a curve. In
the same scale, the Nyquist circle of a resonance with 1 % damping has a circumference of about 2 pi."""

LARGEST_GROWTH, HIGHER, HIGHEST_GROWTH = 500.0, 2.0, 2000.0
"""Transmissibility up to which a resonance is followed. It corresponds to a damping ratio of 0.1 %. With less material
damping, a resonance is followed up to `HIGHER` times the peak of the structure with sticking interfaces, at most up to
`HIGHEST_GROWTH`."""

LEAST_SHARE = 0.02
"""Tip participation of a coordinate, relative to the largest one, below which it does not count as a resonance."""

LARGEST_OVERTONES = 0.5
"""Energy norm of the higher harmonics, relative to the whole motion, above which an internal resonance is assumed."""

LARGEST_DRIFT = 30.0
"""Energy norm of the mean displacement, relative to the larger of the norm of the oscillation and the size by which
motions are scaled, above which the mean counts as undetermined. Layers that slide at all points within each period keep
any offset: the curve then leaves along the offset at nearly the same oscillation."""


class HarmonicBalance:
    """Residual of the harmonic balance for Fourier coefficients (R, m), and its derivatives."""

    def __init__(self, contact: HarmonicContact, acceleration: float):
        self.contact, self.model = contact, contact.model
        self.acceleration = acceleration
        self.orders = contact.sampling.orders
        self.largest_growth = _largest_growth(self.model)

    def linear(self, coefficients: FloatArray, frequency: float) -> FloatArray:
        """(R, m) forces of inertia, damping and stiffness with the interface stuck, at ``frequency`` (rad/s)."""
        w = self.orders[:, None] * frequency
        out = (self.model.eigenvalues - w**2) * coefficients
        if self.model.damping is not None:
            out += self.velocity(coefficients, frequency) @ self.model.damping.T
        return np.asarray(out)

    def velocity(self, coefficients: FloatArray, frequency: float) -> FloatArray:
        """(R, m) Fourier coefficients of the velocity at ``frequency`` (rad/s)."""
        out = np.zeros_like(coefficients)
        w = self.orders[1::2, None] * frequency
        out[1::2], out[2::2] = w * coefficients[2::2], -w * coefficients[1::2]
        return out

    def load(self) -> FloatArray:
        """(R, m) external force due to the base acceleration A cos(wt) and the harmonic forces."""
        out = np.zeros((len(self.orders), self.model.size))
        out[1] = -self.acceleration * self.model.base
        if self.model.condensation.forces:
            out += self.further_load() @ self.model.vectors
        return out

    def further_load(self) -> FloatArray:
        """(R, r) harmonic forces on the coordinates of all modes; harmonics that the motion lacks are left out."""
        c = self.model.condensation
        out = np.zeros((len(self.orders), len(c.eigenvalues)))
        for force in c.forces:
            rows = np.flatnonzero(self.orders == force.order)
            if len(rows):
                out[rows[0]] += self.acceleration * force.cosine
                out[rows[1]] += self.acceleration * force.sine
        return out

    def residual(self, coefficients: FloatArray, frequency: float) -> tuple[FloatArray, PeriodicContact]:
        """(R, m) residual force, and the periodic contact from which it was computed."""
        contact = self.contact.evaluate(self.contact.motion(coefficients), frequency)
        return self.linear(coefficients, frequency) + self.contact.force(contact) - self.load(), contact

    def jacobian(
        self,
        coefficients: FloatArray,
        frequency: float,
        contact: PeriodicContact,
        *,
        threshold: float = PRESSURE_CHANGE,
    ) -> tuple[np.ndarray, FloatArray]:
        """Derivatives of the residual with respect to the k unknowns (k, k), and with respect to the frequency (k,).

        The derivative with respect to the frequency is per rad/s. Unknowns and equations are in the order of
        `HarmonicContact.active`.
        """
        active = self.contact.active
        matrix, by_log = self.contact.jacobian(contact, threshold=threshold)
        self.contact.add_shift(matrix, coefficients, contact)
        w = self.orders[:, None] * frequency
        matrix.ravel()[:: len(active) + 1] += (self.model.eigenvalues - w**2).ravel()[active]
        if self.model.damping is not None:
            for k, forward, backward, modes in self.contact.harmonic_blocks:
                coupling = w[k, 0] * self.model.damping[modes]
                matrix[forward] += coupling
                matrix[backward] -= coupling.T
        return matrix, self._by_frequency(coefficients, frequency, by_log).ravel()[active]

    def derivative(
        self,
        coefficients: FloatArray,
        frequency: float,
        contact: PeriodicContact,
        *,
        threshold: float = PRESSURE_CHANGE,
    ) -> tuple[Callable[[FloatArray], FloatArray], FloatArray]:
        """As `jacobian`, without a matrix.

        Returns
        -------
        product : function that returns the change (R, m) of the residual due to a change (R, m) of the coefficients
        by_frequency : (R, m) derivative with respect to the frequency, per rad/s
        """
        tangent = TangentMap(self.contact, coefficients, contact, threshold)
        by_frequency = self._by_frequency(coefficients, frequency, tangent.by_log)
        return lambda change: self.linear(change, frequency) + tangent.product(change), by_frequency

    def _by_frequency(self, coefficients: FloatArray, frequency: float, by_log: FloatArray) -> FloatArray:
        """(R, m) derivative of the residual, per rad/s; ``by_log`` is that of the contact force by ln(frequency)."""
        out = by_log / frequency - 2.0 * frequency * self.orders[:, None] ** 2 * coefficients
        if self.model.damping is not None:
            out += self.velocity(coefficients, 1.0) @ self.model.damping.T
        return out

    def cycle_work(self, coefficients: FloatArray, frequency: float) -> CycleWork:
        """Work of the base excitation, the interfaces and the dashpots during one period, J.

        The identity input = interface + viscous holds as exactly as the harmonic balance itself.
        """
        contact = self.contact.evaluate(self.contact.motion(coefficients), frequency)
        n, laws, area = self.contact.n, self.contact.laws, self.contact.laws.area
        friction, modulation, path, peak = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((n, 3))
        kernel.cycle_work(
            contact.sampled.motion, contact.hysteresis.slip, self.contact.reference.jump, laws,
            friction, modulation, path, peak,
        )  # fmt: skip
        # s lacks the stuck preload springs and the preload tractions, whose work over a closed cycle is zero
        interface = float(np.einsum("i,ij,ij->", self.contact.weights, contact.correction, contact.rate))
        speed = self.velocity(coefficients, frequency)
        period = 2.0 * np.pi / frequency
        half = np.where(self.orders == 0.0, 1.0, 0.5)[:, None] * period
        viscous = 0.0
        if self.model.damping is not None:
            viscous = float(np.sum(half * speed * (speed @ self.model.damping.T)))
        return CycleWork(
            input=float(np.sum(half * speed * self.load())),
            friction=float(friction @ area),
            modulation=float(modulation @ area),
            viscous=viscous,
            interface=interface,
        )


@dataclass(frozen=True)
class CycleWork:
    """Work of the base excitation, the interfaces and the dashpots during one period, J.

    Attributes
    ----------
    input : work of the base excitation
    friction : friction work, the sum of traction times slip from sample to sample
    modulation : energy exchanged between the elastic slip and the varying pressure
    viscous : work dissipated by the dashpots
    interface : work of all interface tractions, from their values at the samples
    """

    input: float
    friction: float
    modulation: float
    viscous: float
    interface: float


class ScaledMotions(ABC):
    """Periodic motions as vectors of scaled unknowns: the active Fourier coefficients, then the unknowns of a curve.

    Attributes
    ----------
    balance : equations of the harmonic balance
    shape : shape (R, m) of the Fourier coefficients
    active : (k,) indices of the unknowns in the flattened coefficients, see `HarmonicContact.active`
    zero : see `CurveProblem`
    """

    zero = -np.inf

    def __init__(self, balance: HarmonicBalance):
        self.balance = balance
        self.shape, self.active = (len(balance.orders), balance.model.size), balance.contact.active
        self._seen: tuple[FloatArray, PeriodicContact] | None = None

    def placed(self, y: FloatArray) -> FloatArray:
        """(R, m) array with the values ``y`` (k,) of the active coefficients."""
        out = np.zeros(self.shape)
        out.ravel()[self.active] = y
        return out

    @abstractmethod
    def residual(self, z: FloatArray) -> FloatArray:
        """See `CurveProblem`; the contact during the period is kept."""

    def contact(self, z: FloatArray) -> PeriodicContact:
        """Contact during a period of the motion ``z`` (n + 1,)."""
        if self._seen is None or not np.array_equal(self._seen[0], z):
            self.residual(z)
        assert self._seen is not None
        return self._seen[1]


class FrequencyCurve(ScaledMotions):
    """Harmonic balance as a `CurveProblem`: the unknowns are the scaled coefficients, then the scaled frequency."""

    def __init__(self, balance: HarmonicBalance, band: tuple[float, float], size: float):
        super().__init__(balance)
        self.band = band  # rad/s
        self.root = np.sqrt(np.maximum(balance.model.eigenvalues, 0.0) + band[0] * band[1])
        self.size = size  # J^(1/2)
        self.per_unit = (band[1] - band[0]) / BAND_SCALE
        self.zero = -band[0] / self.per_unit

    def scaled(self, coefficients: FloatArray, frequency: float) -> FloatArray:
        """(n + 1,) scaled unknowns of a motion (R, m) at ``frequency`` (rad/s)."""
        y = (coefficients * self.root / self.size).ravel()[self.active]
        return np.append(y, (frequency - self.band[0]) / self.per_unit)

    def unpacked(self, y: FloatArray) -> FloatArray:
        """(R, m) Fourier coefficients, divided by the reference energy norm ``size``, from scaled unknowns (n,)."""
        return self.placed(y) / self.root

    def motion(self, z: FloatArray) -> tuple[FloatArray, float]:
        """Coefficients (R, m) and frequency (rad/s) from scaled unknowns ``z`` (n + 1,)."""
        return self.unpacked(z[:-1]) * self.size, self.band[0] + z[-1] * self.per_unit

    def residual(self, z: FloatArray) -> FloatArray:
        """See `CurveProblem`."""
        residual, contact = self.balance.residual(*self.motion(z))
        self._seen = z, contact
        return np.asarray((residual / (self.root * self.size)).ravel()[self.active])

    def jacobian(self, z: FloatArray) -> np.ndarray:
        """See `CurveProblem`."""
        matrix, by_frequency = self.balance.jacobian(*self.motion(z), self.contact(z))
        scale = 1.0 / np.tile(self.root, self.shape[0])[self.active]
        out = np.empty((len(scale), len(scale) + 1), matrix.dtype)
        fill_scaled(out[:, :-1], matrix, scale)
        out[:, -1] = by_frequency * (self.per_unit / self.size) * scale
        return out

    def derivative(self, z: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """See `CurveProblem`."""
        product, by_frequency = self.balance.derivative(*self.motion(z), self.contact(z))
        by_place = by_frequency * (self.per_unit / self.size)

        def applied(v: FloatArray) -> FloatArray:
            change = product(self.unpacked(v[:-1])) + by_place * v[-1]
            return np.asarray((change / self.root).ravel()[self.active])

        return applied

    def solve(self, z: FloatArray, control: StepControl) -> FloatArray:
        """Solution (n + 1,) at the frequency of the initial guess ``z``.

        Raises
        ------
        ConvergenceError
            If the iteration does not converge. Its ``opening`` is the share of contact points that open in the motion
            of the last iteration.
        """
        try:
            return solve_at(self, z, control)
        except ConvergenceError as error:
            if self.balance.contact.n and np.isfinite(error.last).all():
                error.opening = float(self.contact(error.last).open.any(axis=1).mean())
            raise

    def overtones(self, z: FloatArray) -> float:
        """Energy norm of the harmonics above the fundamental, divided by the energy norm of the motion."""
        if self.balance.model.condensation.forces:  # forces of their own drive the overtones
            return 0.0
        y = self.placed(z[:-1])
        return float(np.linalg.norm(y[3:])) / max(float(np.linalg.norm(y)), 1e-300)

    def drifted(self, z: FloatArray) -> bool:
        """Whether the mean displacement exceeds `LARGEST_DRIFT`."""
        y = self.placed(z[:-1])
        return float(np.linalg.norm(y[0])) > LARGEST_DRIFT * max(1.0, float(np.linalg.norm(y[1:])))

    def growth(self, z: FloatArray) -> float:
        """Tip acceleration relative to the base, divided by the base acceleration, relative to `LARGEST_GROWTH`.

        See there for small material damping.
        """
        q, frequency = self.motion(z)
        tip = frequency**2 * float(np.hypot(*(q[1:3] @ self.balance.model.tip)))
        return tip / (self.balance.largest_growth * self.balance.acceleration)

    def ended(self, z: FloatArray) -> bool:
        """Whether the curve ends at ``z``: too large a response, an internal resonance, or an undetermined mean."""
        return self.growth(z) > 1.0 or self.overtones(z) > LARGEST_OVERTONES or self.drifted(z)

    def describe(self, z: FloatArray) -> str:
        """See `CurveProblem`."""
        frequency = self.motion(z)[1] / (2.0 * np.pi)
        return f"harmonic balance at {frequency:.4g} Hz, base {self.balance.acceleration:.3g} m/s^2"


def _largest_growth(model: ReducedModel) -> float:
    """Transmissibility up to which a resonance is followed; of a force, relative to its largest participation."""
    if not model.condensation.rigid_tip:
        further = [part @ model.vectors for force in model.condensation.forces for part in (force.cosine, force.sine)]
        unit = float(np.abs(np.array([model.base, *further]) * model.tip).max(initial=0.0)) or 1.0
        return unit * HIGHEST_GROWTH
    if model.damping is None:
        return LARGEST_GROWTH
    rates = np.diag(model.damping)
    moving = (rates > 0.0) & (model.eigenvalues > 0.0)
    share = np.abs(model.base * model.tip)[moving]
    peaks = share * np.sqrt(model.eigenvalues[moving]) / rates[moving]
    highest = float(peaks[share > LEAST_SHARE * share.max(initial=0.0)].max(initial=0.0))
    return min(max(LARGEST_GROWTH, HIGHER * highest), HIGHEST_GROWTH)


def _linear_start(balance: HarmonicBalance, frequency: float) -> FloatArray:
    """(R, m) undamped response with stuck interfaces; near a resonance its amplitude is limited to a finite value."""
    model = balance.model
    out = np.zeros((len(balance.orders), model.size))
    stiffness = model.eigenvalues - frequency**2
    least = 0.02 * frequency**2
    out[1] = -balance.acceleration * model.base / np.where(np.abs(stiffness) < least, least, stiffness)
    return out


def solve_motion(
    balance: HarmonicBalance,
    frequency: float,
    start: FloatArray | None = None,
    *,
    control: StepControl | None = None,
) -> FloatArray:
    """Coefficients (R, m) of the periodic motion at one ``frequency`` (rad/s).

    Parameters
    ----------
    start
        (R, m) first guess; when None, the response of the structure with its interfaces stuck.

    Raises
    ------
    ConvergenceError
        If Newton's method fails both at the full base acceleration and when the acceleration is raised in steps.
    """
    control = control or StepControl()
    first = _linear_start(balance, frequency) if start is None else start
    band = (0.9 * frequency, frequency / 0.9)
    root = np.sqrt(np.maximum(balance.model.eigenvalues, 0.0) + frequency**2)
    size = float(np.linalg.norm(first * root))
    problem = FrequencyCurve(balance, band, size if size > 0.0 else 1.0)
    try:
        return problem.motion(problem.solve(problem.scaled(first, frequency), control))[0]
    except ConvergenceError:
        if balance.acceleration == 0.0:
            raise
    found = np.zeros_like(first)
    for share in np.linspace(0.05, 1.0, 20):  # from a small amplitude, where most points stick
        part = HarmonicBalance(balance.contact, share * balance.acceleration)
        guess = _linear_start(part, frequency) if share < 0.06 else found * share / (share - 0.05)
        grown = FrequencyCurve(part, band, problem.size)
        found = grown.motion(grown.solve(grown.scaled(guess, frequency), control))[0]
    return found
