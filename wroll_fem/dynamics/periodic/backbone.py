r"""Nonlinear modes: frequency and damping of a resonance as functions of its amplitude.

Extended periodic motion concept: a nonlinear mode is a periodic motion of the unforced structure. A negative damping
proportional to the mass compensates its dissipation,

.. math:: q'' + C q' + \Lambda q + (G\Phi)^T W s - 2 \zeta \omega\, q' = 0 .

:math:`\zeta(a)` is the modal damping ratio and :math:`\omega(a)` the frequency at the modal amplitude a of the
fundamental, :math:`|Q_1| = a`. Near an isolated resonance the forced response passes through the same motions. At
resonance the work of the base per cycle, :math:`\pi A |b^T Q_1|`, equals the dissipation,
:math:`2 \pi \zeta \omega^2 \sum_k k^2 |Q_k|^2`. One curve therefore gives the damping at every base acceleration A.

References
----------
Krack (2015), Computers & Structures 154, 59, doi:10.1016/j.compstruc.2015.03.008.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass, field, replace

import numpy as np

from wroll_fem.contact.laws import PointLaws
from wroll_fem.contact.point import normals
from wroll_fem.dynamics.aft.harmonic_contact import MAX_PERIODS, HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.first_guesses import carried_along, corrected_from, first_guesses
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance, ScaledMotions
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState, contact_energy_limit
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.numerics.bordered import fill_scaled
from wroll_fem.numerics.continuation import Corrected, CurvePoint, StepControl, follow, solve_at
from wroll_fem.typing import FloatArray

LENGTH = 10.0
"""Scaled curve parameter at the largest amplitude; it is 0 at the smallest amplitude."""
FREQUENCY_UNIT, DAMPING_UNIT = 0.2, 0.05
"""Units of two scaled unknowns: change of the frequency relative to the natural frequency, and damping ratio."""

BACKBONE_STEPS = StepControl(largest=0.15, usual=5.0, max_points=300)
"""Step control along a backbone; steps are short, because its end is found to within a step. A smooth backbone has
about 80 points. ``max_points`` stops a curve that would pass from one internal resonance to the next without end."""

LARGEST_STRAY = 0.5
"""Limit for the norms of the mean displacement and of the higher harmonics, each relative to the norm of the motion.
Beyond it the motion no longer belongs to the mode. A mean displacement is ignored if its energy does not exceed the
energy stored in the contact when every point is about to slip: points that the preload leaves at the slip limit slip
once, by about the amplitude, and then stick."""

NEAR_END = float(np.log(0.95))
"""Logarithm of 0.95: a backbone that cannot be followed to its end keeps this share of its largest amplitude."""


class ModalMotion(ScaledMotions):
    """Nonlinear mode as a `CurveProblem`; unknowns: scaled shape (R, m), frequency, damping ratio, ln(amplitude)."""

    def __init__(self, balance: HarmonicBalance, mode: int, amplitudes: tuple[float, float]):
        super().__init__(balance)
        self.mode, model = mode, balance.model
        self.natural = float(np.sqrt(model.eigenvalues[mode]))
        self.root = np.sqrt(np.maximum(model.eigenvalues, 0.0) + self.natural**2)
        self.unit = float(self.root[mode])
        self.first = float(np.log(amplitudes[0]))
        self.per_unit = float(np.log(amplitudes[1] / amplitudes[0])) / LENGTH
        contact = balance.contact
        pressure = np.maximum(-normals(contact.reference.traction), 0.0)
        self.held = float(np.sqrt(2.0 * contact_energy_limit(contact.laws, pressure)))

    def motion(self, z: FloatArray) -> tuple[FloatArray, float, float, float]:
        """Shape (R, m), frequency (rad/s), damping ratio and amplitude (kg^(1/2) m) from scaled unknowns (n + 1,)."""
        shape = self.unpacked(z[:-3])
        frequency = self.natural * (1.0 + FREQUENCY_UNIT * z[-3])
        return shape, frequency, DAMPING_UNIT * z[-2], float(np.exp(self.first + self.per_unit * z[-1]))

    @property
    def amplitudes(self) -> tuple[float, float]:
        """Smallest and largest amplitude, kg^(1/2) m."""
        return float(np.exp(self.first)), float(np.exp(self.first + self.per_unit * LENGTH))

    def unpacked(self, y: FloatArray) -> FloatArray:
        """(R, m) shape from its scaled unknowns."""
        return self.placed(y) * self.unit / self.root

    def scaled(self, shape: FloatArray, frequency: float, damping: float, amplitude: float) -> FloatArray:
        """(n + 1,) scaled unknowns; ``frequency`` in rad/s, ``amplitude`` in kg^(1/2) m."""
        y = (shape * self.root / self.unit).ravel()[self.active]
        place = (np.log(amplitude) - self.first) / self.per_unit
        return np.append(y, [(frequency / self.natural - 1.0) / FREQUENCY_UNIT, damping / DAMPING_UNIT, place])

    def start(self) -> FloatArray:
        """(n + 1,) scaled unknowns of the linear mode with sticking interfaces, at the smallest amplitude."""
        shape, damping = np.zeros(self.shape), self.balance.model.damping
        shape[1, self.mode] = 1.0
        zeta = 0.0 if damping is None else 0.5 * damping[self.mode, self.mode] / self.natural
        ends = [0.0, zeta / DAMPING_UNIT, 0.0]
        return np.concatenate([(shape * self.root / self.unit).ravel()[self.active], ends])

    def residual(self, z: FloatArray) -> FloatArray:
        """See `CurveProblem`."""
        shape, frequency, damping, amplitude = self.motion(z)
        contact = self.balance.contact.evaluate(self.balance.contact.motion(amplitude * shape), frequency)
        self._seen = z, contact
        out = self.balance.linear(shape, frequency) + self.balance.contact.force(contact) / amplitude
        out -= 2.0 * damping * frequency * self.balance.velocity(shape, frequency)
        ends = [float(np.sum(shape[1:3] ** 2)) - 1.0, shape[2, self.mode]]
        return np.append((out / (self.root * self.unit)).ravel()[self.active], ends)

    def jacobian(self, z: FloatArray) -> np.ndarray:
        """See `CurveProblem`."""
        (shape, frequency, damping, amplitude), (size, m) = self.motion(z), self.shape
        balance, active = self.balance, self.active
        matrix, by_frequency = balance.jacobian(amplitude * shape, frequency, self.contact(z))
        last = self._last_columns(z, matrix @ shape.ravel()[active].astype(matrix.dtype), by_frequency)
        for k in range(1, size, 2):
            gain = 2.0 * damping * frequency * balance.orders[k] * frequency
            cos, sin = np.flatnonzero(active // m == k), np.flatnonzero(active // m == k + 1)
            matrix[cos, sin] -= gain
            matrix[sin, cos] += gain
        out = np.zeros((len(active) + 2, len(active) + 3), matrix.dtype)
        fill_scaled(out[:-2, :-3], matrix, 1.0 / np.tile(self.root, size)[active])
        out[:-2, -3:] = last
        ends = np.zeros((2, size, m))
        ends[0, 1:3] = 2.0 * shape[1:3] * self.unit / self.root
        ends[1, 2, self.mode] = self.unit / self.root[self.mode]
        out[-2:, :-3] = ends.reshape(2, -1)[:, active]
        return out

    def derivative(self, z: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """See `CurveProblem`."""
        (shape, frequency, damping, amplitude), balance, active = self.motion(z), self.balance, self.active
        product, by_frequency = balance.derivative(amplitude * shape, frequency, self.contact(z))
        last = self._last_columns(z, product(shape).ravel()[active], by_frequency.ravel()[active])

        def applied(v: FloatArray) -> FloatArray:
            change = self.unpacked(v[:-3])
            out = product(change) - 2.0 * damping * frequency * balance.velocity(change, frequency)
            ends = [2.0 * float(np.vdot(shape[1:3], change[1:3])), change[2, self.mode]]
            return np.append((out / (self.root * self.unit)).ravel()[active] + last @ v[-3:], ends)

        return applied

    def _last_columns(self, z: FloatArray, product: FloatArray, by_frequency: FloatArray) -> FloatArray:
        """(k, 3) scaled derivatives with respect to the last three unknowns: frequency, damping ratio and amplitude.

        ``product`` (k,) is the Jacobian of the forces times the shape, ``by_frequency`` (k,) their derivative.
        """
        shape, frequency, damping, amplitude = self.motion(z)
        speed = self.balance.velocity(shape, frequency).ravel()[self.active]
        force = self.balance.linear(shape, frequency) + self.balance.contact.force(self.contact(z)) / amplitude
        columns = np.column_stack([
            (by_frequency / amplitude - 4.0 * damping * speed) * self.natural * FREQUENCY_UNIT,
            -2.0 * frequency * speed * DAMPING_UNIT,
            (product - force.ravel()[self.active]) * self.per_unit,
        ])  # fmt: skip
        return columns / (np.tile(self.root, self.shape[0])[self.active] * self.unit)[:, None]

    def strays(self, z: FloatArray) -> tuple[float, float]:
        """Norms of the mean displacement and of the higher harmonics, each divided by the norm of the motion.

        The first is zero if the energy of the mean displacement does not exceed the energy stored in the contact when
        every point is about to slip.
        """
        y = self.placed(z[:-3])
        size, mean = max(float(np.linalg.norm(y)), 1e-300), float(np.linalg.norm(y[0]))
        held = self.motion(z)[3] * self.unit * mean <= self.held
        return 0.0 if held else mean / size, float(np.linalg.norm(y[3:])) / size

    def strayed(self, z: FloatArray) -> bool:
        """Whether a motion no longer belongs to the mode; the backbone ends there."""
        return max(self.strays(z)) > LARGEST_STRAY

    def describe(self, z: FloatArray) -> str:
        """See `CurveProblem`."""
        shape, frequency, damping, amplitude = self.motion(z)
        tip = amplitude * float(np.hypot(*(shape[1:3] @ self.balance.model.tip)))
        return f"nonlinear mode at {frequency / (2 * np.pi):.4g} Hz, tip {tip:.3g} m, damping {100 * damping:.3g} %"


@dataclass(frozen=True)
class BackboneCurve:
    """Backbone curve: frequency, damping and periodic motion of a resonance for a range of amplitudes.

    Attributes
    ----------
    frequencies : (p,) rad/s
    damping : (p,) modal damping ratio
    coefficients : (p, R, m) Fourier coefficients of q
    iterations : (p,) number of Newton iterations
    tangents : (p, n + 1) tangents in scaled unknowns
    balance : equations of the harmonic balance
    problem : scaling of the unknowns
    cut : reason for an end before the largest requested amplitude; empty if that amplitude is reached
    beyond : number of last points that lie beyond the end of the curve; they serve the training of a basis
    """

    frequencies: FloatArray
    damping: FloatArray
    coefficients: FloatArray
    iterations: np.ndarray
    tangents: FloatArray
    balance: HarmonicBalance
    problem: ModalMotion = field(repr=False)
    cut: str = ""
    beyond: int = 0

    @classmethod
    def of_points(cls, problem: ModalMotion, points: list[CurvePoint]) -> BackboneCurve:
        """Backbone with the points that `continuation.follow` returns."""
        found = [problem.motion(p.z) for p in points]
        return cls(
            frequencies=np.array([f for _, f, _, _ in found]),
            damping=np.array([d for _, _, d, _ in found]),
            coefficients=np.array([a * q for q, _, _, a in found]),
            iterations=np.array([p.iterations for p in points]),
            tangents=np.array([p.tangent for p in points]),
            balance=problem.balance,
            problem=problem,
        )

    def take(self, points: list[int]) -> BackboneCurve:
        """Curve with the points of the given indices only."""
        names = ("frequencies", "damping", "coefficients", "iterations", "tangents")
        return replace(self, **{name: getattr(self, name)[points] for name in names})

    @property
    def places(self) -> FloatArray:
        """(p,) curve parameter, 0 at the smallest amplitude and `LENGTH` at the largest."""
        amplitude = np.linalg.norm(self.coefficients[:, 1:3], axis=(1, 2))
        return np.asarray((np.log(amplitude) - self.problem.first) / self.problem.per_unit)

    def cut_off(self, reason: str) -> BackboneCurve:
        """Copy that ends at an amplitude just below the largest one computed; the points after it count as `beyond`."""
        past = np.flatnonzero(self.places > self.places.max(initial=0.0) + NEAR_END / self.problem.per_unit)
        return replace(self, cut=self.cut or reason, beyond=len(self.places) - int(past[0]))

    def without_beyond(self) -> BackboneCurve:
        """Curve without the points beyond its end."""
        return replace(self.take(list(range(len(self.frequencies) - self.beyond))), beyond=0)

    def up_to(self, place: float, reason: str) -> BackboneCurve:
        """Part of the curve before its parameter first exceeds ``place``; ``reason`` becomes its `cut`."""
        beyond = np.flatnonzero(self.places > place + 1e-9)
        count = int(beyond[0]) if len(beyond) else len(self.frequencies)
        return replace(self.take(list(range(count))), cut=reason, beyond=0)

    def moved_to(
        self, contact: HarmonicContact, control: StepControl, starts: FloatArray | None = None,
        only: Container[int] | None = None, exact: HarmonicContact | None = None,
    ) -> BackboneCurve:  # fmt: skip
        """Curve at the same amplitudes in another model; for the arguments see `HarmonicCurve.moved_to`."""
        shift = self.balance.model.vectors.T @ contact.model.vectors
        old = self.problem
        mode = int(np.argmax(np.abs(shift[old.mode])))
        contacts = [contact] if exact is None else [contact, exact]
        problems = [ModalMotion(HarmonicBalance(one, 0.0), mode, old.amplitudes) for one in contacts]
        problem, factor = problems[-1], None
        found, before = list[CurvePoint](), list[FloatArray]()
        row = np.append(np.zeros(len(problem.active) + 2), 1.0)
        for k, q in enumerate(self.coefficients):
            size, guesses = float(np.linalg.norm(q[1:3])), first_guesses(q, shift, starts, k)
            places = [problem.scaled(g / size, self.frequencies[k], self.damping[k], size) for g in guesses]
            before.append(places[-1])
            at = Corrected(places[-1], [], places[-1], factor)
            if only is None or k in only:
                at = corrected_from(problems, places, row, control, kept=factor, chord=starts is None)
            factor = at.factor
            if at.z is not None:
                along = self.tangents[k]
                moved = (old.unpacked(along[:-3]) @ shift * problem.root / problem.unit).ravel()[problem.active]
                found.append(CurvePoint(at.z, np.append(moved, along[-3:]), len(at.history), True))
        found = found if only is None else carried_along(found, np.array(before), only)
        return replace(BackboneCurve.of_points(problem, found), cut=self.cut)

    def extended(self, contact: HarmonicContact) -> BackboneCurve:
        """Curve of the same motions with the number of harmonics of ``contact``; the added harmonics are zero."""
        more = contact.sampling.size - self.coefficients.shape[1]
        if more <= 0 and self.balance.contact.complete:
            return self
        balance = HarmonicBalance(contact, 0.0)
        problem = ModalMotion(balance, self.problem.mode, self.problem.amplitudes)
        changes = np.array([self.problem.unpacked(along[:-3]) for along in self.tangents])
        changes = np.pad(changes, ((0, 0), (0, more), (0, 0))) * problem.root / problem.unit
        changes = changes.reshape(len(changes), -1)[:, problem.active]
        return replace(
            self, coefficients=np.pad(self.coefficients, ((0, 0), (0, more), (0, 0))), balance=balance,
            tangents=np.column_stack([changes, self.tangents[:, -3:]]), problem=problem,
        )  # fmt: skip

    def fundamental(self, row: FloatArray) -> FloatArray:
        """(p,) amplitude of the fundamental harmonic of ``row`` . q, a linear function of the reduced coordinates q."""
        return np.asarray(np.hypot(self.coefficients[:, 1] @ row, self.coefficients[:, 2] @ row))

    @property
    def tip(self) -> FloatArray:
        """(p,) amplitude of the tip's displacement, m."""
        return self.fundamental(self.balance.model.tip)

    @property
    def dissipation(self) -> FloatArray:
        """(p,) energy dissipated per cycle, J."""
        squares = np.sum(self.balance.orders[:, None] ** 2 * self.coefficients**2, axis=(1, 2))
        return np.asarray(2.0 * np.pi * self.damping * self.frequencies**2 * squares)

    @property
    def base_acceleration(self) -> FloatArray:
        """(p,) amplitude of the base acceleration that drives the mode at resonance, m/s^2."""
        return np.asarray(self.dissipation / (np.pi * self.fundamental(self.balance.model.base)))

    def direction(self, k: int) -> FloatArray:
        """(R, m) derivative of the Fourier coefficients along the curve at its point ``k``, up to a positive factor."""
        shape = self.coefficients[k] / np.linalg.norm(self.coefficients[k, 1:3])
        change = self.problem.unpacked(self.tangents[k, :-3])
        return np.asarray(change + shape * self.problem.per_unit * self.tangents[k, -1])


def solve_backbone(
    model: ReducedModel,
    preload: ContactState,
    laws: PointLaws,
    *,
    tip_amplitudes: tuple[float, float],
    mode: int | None = None,
    harmonics: int = 3,
    samples: int = 64,
    max_periods: int = MAX_PERIODS,
    control: StepControl | None = None,
) -> BackboneCurve:
    """Frequency and damping of a mode from its smallest to its largest amplitude.

    Parameters
    ----------
    tip_amplitudes
        Smallest and largest tip amplitude in m. They are converted to modal amplitudes with the linear mode (interface
        stuck).
    mode
        Index of the linear mode to start from; when None, `ReducedModel.main_mode`.

    Raises
    ------
    InputError
        If the amplitudes are not increasing, or the mode does not move the tip.
    ConvergenceError
        If the curve cannot be followed; ``partial`` holds the points so far (BackboneCurve).
    """
    contact = HarmonicContact(model, preload, laws, Sampling(harmonics, samples), max_periods=max_periods)
    return backbone_curve(contact, tip_amplitudes=tip_amplitudes, mode=mode, control=control)


def backbone_curve(
    contact: HarmonicContact,
    *,
    tip_amplitudes: tuple[float, float],
    mode: int | None = None,
    control: StepControl | None = None,
    on_point: Callable[[float, int], None] | None = None,
) -> BackboneCurve:
    """As `solve_backbone`, for a reduced model with its contact; on_point (share of the range, number of points)."""
    model = contact.model
    if not 0.0 < tip_amplitudes[0] < tip_amplitudes[1]:
        raise InputError(
            f"tip amplitudes {tip_amplitudes} m are not positive and increasing", key="backbone",
            remedy="give a smaller, then a larger one",
        )  # fmt: skip
    number = model.main_mode if mode is None else mode
    reach = float(abs(model.tip[number]))
    if reach == 0.0 or model.eigenvalues[number] <= 0.0:
        raise InputError(
            f"mode {number} does not move the tip or has no positive stiffness", remedy="choose another mode"
        )
    control = control or BACKBONE_STEPS
    problem = ModalMotion(HarmonicBalance(contact, 0.0), number, (tip_amplitudes[0] / reach, tip_amplitudes[1] / reach))
    first = solve_at(problem, problem.start(), control)
    told = on_point or (lambda share, count: None)
    place: Callable[[list[CurvePoint]], None] = lambda found: told(float(found[-1].z[-1]) / LENGTH, len(found))  # noqa: E731
    try:
        points = follow(problem, first, LENGTH, control, ends=problem.strayed, on_point=place)
    except ConvergenceError as error:
        error.partial = BackboneCurve.of_points(problem, error.partial or [])
        raise
    if problem.strayed(points[-1].z):
        raise _strayed(problem, points)
    return BackboneCurve.of_points(problem, points)


def _strayed(problem: ModalMotion, points: list[CurvePoint]) -> ConvergenceError:
    mean, overtones = problem.strays(points[-1].z)
    what = (
        "some layer then has no sticking point at any time of the period, so that its mean displacement is undetermined"
        if mean > overtones
        else "a harmonic of the motion is then in resonance with another mode (internal resonance)"
    )
    error = ConvergenceError(
        f"the backbone no longer follows its mode ({problem.describe(points[-1].z)})", time_s=None,
        iterations=points[-1].iterations, residual_history=[max(mean, overtones)], advice=what,
    )  # fmt: skip
    error.partial = replace(BackboneCurve.of_points(problem, points), cut=what)
    return error
