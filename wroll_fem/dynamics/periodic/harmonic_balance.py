r"""Harmonic balance: periodic motions of a preloaded structure with friction, and curves of them over frequency.

With :math:`q = Q_0 + \sum_k Q^c_k \cos k\omega t + Q^s_k \sin k\omega t` in the coordinates of a `ReducedModel`, every
harmonic of the equation of motion has to vanish,

.. math::
    [-(k\omega)^2 + i k \omega C + \Lambda]\, Q_k + (G\Phi)^T W s_k = -b\, a_g\, \delta_{k1}, \qquad
    s = t - t_0 - D_0 (g - g_0)

with s from the alternating frequency-time evaluation (`aft`). The curve over frequency is followed by arc length
(`continuation`), so that it may lean over. Unknowns are scaled by sqrt(lambda + omega^2), which makes the
norm of a motion its energy.

References
----------
Krack, Gross (2019), Harmonic Balance for Nonlinear Vibration Problems, doi:10.1007/978-3-030-14023-6.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from wroll_fem.contact.laws import PointLaws
from wroll_fem.dynamics.periodic import aft_kernel as kernel
from wroll_fem.dynamics.periodic.aft import MAX_PERIODS, PRESSURE_CHANGE, HarmonicContact, PeriodicContact, Sampling
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.numerics.continuation import CurvePoint, StepControl, follow, solve_at
from wroll_fem.typing import FloatArray

BAND_SCALE = 3.0
"""Scaled length of the whole band; a resonance circle of the response has a length of about pi."""


class HarmonicBalance:
    """Residual of the balance for coefficients (R, m), and its derivatives."""

    def __init__(self, contact: HarmonicContact, acceleration: float):
        self.contact, self.model = contact, contact.model
        self.acceleration = acceleration
        self.orders = contact.sampling.orders

    def linear(self, coefficients: FloatArray, frequency: float) -> FloatArray:
        """(R, m) inertia, damping and stiffness (interface stuck) of the motion at ``frequency`` (rad/s)."""
        w = self.orders[:, None] * frequency
        out = (self.model.eigenvalues - w**2) * coefficients
        if self.model.damping is not None:
            out += self.velocity(coefficients, frequency) @ self.model.damping.T
        return np.asarray(out)

    def velocity(self, coefficients: FloatArray, frequency: float) -> FloatArray:
        """(R, m) coefficients of the time derivative."""
        out = np.zeros_like(coefficients)
        w = self.orders[1::2, None] * frequency
        out[1::2], out[2::2] = w * coefficients[2::2], -w * coefficients[1::2]
        return out

    def load(self) -> FloatArray:
        """(R, m) external force: base acceleration A cos(wt)."""
        out = np.zeros((len(self.orders), self.model.size))
        out[1] = -self.acceleration * self.model.base
        return out

    def residual(self, coefficients: FloatArray, frequency: float) -> tuple[FloatArray, PeriodicContact]:
        """(R, m) residual force and the contact that belongs to it."""
        contact = self.contact.evaluate(self.contact.motion(coefficients), frequency)
        return self.linear(coefficients, frequency) + self.contact.force(contact) - self.load(), contact

    def jacobian(
        self,
        coefficients: FloatArray,
        frequency: float,
        contact: PeriodicContact,
        *,
        threshold: float = PRESSURE_CHANGE,
    ) -> tuple[FloatArray, FloatArray]:
        """d(residual)/d(coefficients) (R m, R m) and d(residual)/d(frequency) (R m,), per rad/s."""
        size, m = coefficients.shape
        matrix, by_log = self.contact.jacobian(contact, threshold=threshold)
        w = self.orders[:, None] * frequency
        matrix[np.diag_indices(size * m)] += (self.model.eigenvalues - w**2).ravel()
        by_frequency = by_log / frequency - 2.0 * w * self.orders[:, None] * coefficients
        if self.model.damping is not None:
            view = matrix.reshape(size, m, size, m)
            for k in range(1, size, 2):
                coupling = w[k, 0] * self.model.damping
                view[k, :, k + 1, :] += coupling
                view[k + 1, :, k, :] -= coupling
            by_frequency += self.velocity(coefficients, 1.0) @ self.model.damping.T
        return matrix, by_frequency.ravel()

    def cycle_work(self, coefficients: FloatArray, frequency: float) -> CycleWork:
        """Energy of one period, J; the identity input = interface + viscous holds as exactly as the balance itself."""
        contact = self.contact.evaluate(self.contact.motion(coefficients), frequency)
        n, laws, area = self.contact.n, self.contact.laws, self.contact.laws.area
        friction, modulation, path, peak = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((n, 3))
        kernel.cycle_work(
            contact.sampled.motion, contact.hysteresis.slip, self.contact.preload.jump, laws,
            friction, modulation, path, peak,
        )  # fmt: skip
        # s lacks the stuck preload springs and the preload tractions, whose work over a closed cycle is zero
        interface = float(np.einsum("i,ij,ij->", self.contact.weights, contact.correction, contact.sampled.rate))
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
    """Work of one period, J.

    Attributes
    ----------
    input : of the base
    friction : traction times plastic slip, from sample to sample
    modulation : what elastic slip exchanges with the varying pressure
    viscous : of the dashpots
    interface : of all tractions, at the samples
    """

    input: float
    friction: float
    modulation: float
    viscous: float
    interface: float


class FrequencyCurve:
    """Harmonic balance as a `CurveProblem`: scaled coefficients, then scaled frequency."""

    def __init__(self, balance: HarmonicBalance, band: tuple[float, float], size: float):
        self.balance = balance
        self.band = band  # rad/s
        self.shape = (len(balance.orders), balance.model.size)
        self.root = np.sqrt(np.maximum(balance.model.eigenvalues, 0.0) + band[0] * band[1])
        self.size = size  # J^(1/2)
        self.per_unit = (band[1] - band[0]) / BAND_SCALE
        self._seen: tuple[FloatArray, PeriodicContact] | None = None

    def scaled(self, coefficients: FloatArray, frequency: float) -> FloatArray:
        """(n + 1,) unknowns."""
        y = coefficients * self.root / self.size
        return np.append(y.ravel(), (frequency - self.band[0]) / self.per_unit)

    def motion(self, z: FloatArray) -> tuple[FloatArray, float]:
        """Coefficients (R, m) and frequency, rad/s."""
        return z[:-1].reshape(self.shape) * self.size / self.root, self.band[0] + z[-1] * self.per_unit

    def residual(self, z: FloatArray) -> FloatArray:
        """See `CurveProblem`."""
        residual, contact = self.balance.residual(*self.motion(z))
        self._seen = z, contact
        return np.asarray((residual / (self.root * self.size)).ravel())

    def contact(self, z: FloatArray) -> PeriodicContact:
        """Contact at ``z``."""
        if self._seen is None or not np.array_equal(self._seen[0], z):
            self.residual(z)
        assert self._seen is not None
        return self._seen[1]

    def jacobian(self, z: FloatArray) -> FloatArray:
        """See `CurveProblem`."""
        matrix, by_frequency = self.balance.jacobian(*self.motion(z), self.contact(z))
        root = np.tile(self.root, self.shape[0])
        matrix /= root[:, None]
        matrix /= root
        return np.column_stack([matrix, by_frequency * self.per_unit / (root * self.size)])

    def describe(self, z: FloatArray) -> str:
        """See `CurveProblem`."""
        frequency = self.motion(z)[1] / (2.0 * np.pi)
        return f"harmonic balance at {frequency:.4g} Hz, base {self.balance.acceleration:.3g} m/s^2"


@dataclass(frozen=True)
class HarmonicCurve:
    """Periodic motions along a branch.

    Attributes
    ----------
    frequencies : (p,) rad/s, in the order of the branch (not rising through folds)
    coefficients : (p, R, m) Fourier coefficients of q
    tangents : (p, R m + 1) scaled unit tangents, for interpolation along the branch
    iterations : (p,) Newton iterations
    stable : (p,) False between folds (one real Floquet multiplier above 1 there; other instabilities are not seen)
    balance : the equations
    arc : (p,) scaled arc length
    """

    frequencies: FloatArray
    coefficients: FloatArray
    tangents: FloatArray
    iterations: np.ndarray
    stable: np.ndarray
    balance: HarmonicBalance
    problem: FrequencyCurve = field(repr=False)

    @classmethod
    def of_points(cls, problem: FrequencyCurve, points: list[CurvePoint]) -> HarmonicCurve:
        """Curve from what `continuation.follow` found."""
        motions = [problem.motion(p.z) for p in points]
        return cls(
            frequencies=np.array([w for _, w in motions]),
            coefficients=np.array([q for q, _ in motions]),
            tangents=np.array([p.tangent for p in points]),
            iterations=np.array([p.iterations for p in points]),
            stable=np.array([p.tangent[-1] > 0.0 and p.regular for p in points]),
            balance=problem.balance,
            problem=problem,
        )

    @property
    def folds(self) -> int:
        """Number of turning points."""
        return int(np.count_nonzero(np.diff(np.sign(self.tangents[:, -1]))))

    def direction(self, k: int) -> FloatArray:
        """(R, m) change of the coefficients along the branch at point k, to a scale."""
        return np.asarray(self.tangents[k, :-1].reshape(self.problem.shape) / self.problem.root)

    def fundamental(self, row: FloatArray) -> np.ndarray:
        """(p,) complex amplitude of the fundamental of row . q, base acceleration being A cos(wt)."""
        return np.asarray(self.coefficients[:, 1] @ row - 1j * (self.coefficients[:, 2] @ row))

    @property
    def transmissibility(self) -> np.ndarray:
        """(p,) complex: fundamental of the absolute tip acceleration over the base acceleration."""
        tip = self.fundamental(self.balance.model.tip)
        return 1.0 - self.frequencies**2 * tip / self.balance.acceleration


def _linear_start(balance: HarmonicBalance, frequency: float) -> FloatArray:
    """(R, m) response of the stuck structure, without damping bounded near its resonances."""
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
        (R, m) first guess; the response of the stuck structure when None.

    Raises
    ------
    ConvergenceError
        If Newton's method finds none, neither directly nor while the amplitude grows.
    """
    control = control or StepControl()
    first = _linear_start(balance, frequency) if start is None else start
    band = (0.9 * frequency, frequency / 0.9)
    root = np.sqrt(np.maximum(balance.model.eigenvalues, 0.0) + frequency**2)
    size = float(np.linalg.norm(first * root))
    problem = FrequencyCurve(balance, band, size if size > 0.0 else 1.0)
    try:
        return problem.motion(solve_at(problem, problem.scaled(first, frequency), control))[0]
    except ConvergenceError:
        if balance.acceleration == 0.0:
            raise
    found = np.zeros_like(first)
    for share in np.linspace(0.05, 1.0, 20):  # from a small amplitude, where most points stick
        part = HarmonicBalance(balance.contact, share * balance.acceleration)
        guess = _linear_start(part, frequency) if share < 0.06 else found * share / (share - 0.05)
        grown = FrequencyCurve(part, band, problem.size)
        found = grown.motion(solve_at(grown, grown.scaled(guess, frequency), control))[0]
    return found


def solve_response(
    model: ReducedModel,
    preload: ContactState,
    laws: PointLaws,
    *,
    amplitude: float,
    frequencies: tuple[float, float],
    harmonics: int = 3,
    samples: int = 64,
    max_periods: int = MAX_PERIODS,
    control: StepControl | None = None,
    on_point: Callable[[float, int], None] | None = None,
) -> HarmonicCurve:
    """Steady response to a base acceleration A cos(wt) over a band of frequencies, through folds.

    Parameters
    ----------
    amplitude
        A in m/s^2, 0-peak.
    frequencies
        First and last frequency, Hz; the curve is followed from the first.
    harmonics, samples
        H and samples per period.
    max_periods
        Periods that the hysteresis may take to become periodic.
    on_point
        Called with the frequency in Hz and the number of points so far.

    Raises
    ------
    InputError
        For an empty band or no amplitude.
    ConvergenceError
        With the curve until then in ``partial`` (HarmonicCurve).
    """
    low, high = (2.0 * np.pi * f for f in frequencies)
    if not 0.0 < low < high:
        raise InputError(f"band of {frequencies[0]:g} to {frequencies[1]:g} Hz", remedy="give two rising frequencies")
    if not amplitude > 0.0:
        raise InputError(f"base acceleration {amplitude:g} m/s^2", key="excitation.amplitude", remedy="use more than 0")
    control = control or StepControl()
    contact = HarmonicContact(model, preload, laws, Sampling(harmonics, samples), max_periods=max_periods)
    balance = HarmonicBalance(contact, amplitude)
    start = solve_motion(balance, low, control=control)
    problem = FrequencyCurve(balance, (low, high), _response_size(balance, start, low, high))

    def report(points: list[CurvePoint]) -> None:
        if on_point is not None:
            on_point(problem.motion(points[-1].z)[1] / (2.0 * np.pi), len(points))

    first = solve_at(problem, problem.scaled(start, low), control)
    try:
        points = follow(problem, first, BAND_SCALE, control, on_point=report)
    except ConvergenceError as error:
        points = error.partial or []
        error.partial = HarmonicCurve.of_points(problem, points)
        raise
    return HarmonicCurve.of_points(problem, points)


def _response_size(balance: HarmonicBalance, start: FloatArray, low: float, high: float) -> float:
    """Scale of the motion in the band, J^(1/2): the larger of the start's and a tenth of a resonance at 1 % damping."""
    model = balance.model
    root = np.sqrt(np.maximum(model.eigenvalues, 0.0) + low * high)
    here = float(np.linalg.norm(start * root))
    inside = (model.eigenvalues > (0.8 * low) ** 2) & (model.eigenvalues < (1.2 * high) ** 2)
    resonant = balance.acceleration * np.abs(model.base[inside]) / (0.02 * model.eigenvalues[inside])
    return max(here, float((0.5 * resonant * root[inside]).max(initial=0.0)), 1e-300)
