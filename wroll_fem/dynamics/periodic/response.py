"""Steady response versus frequency: curves of periodic motions with folds, gaps and internal resonances."""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from wroll_fem.contact.laws import PointLaws
from wroll_fem.dynamics.aft.harmonic_contact import MAX_PERIODS, HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.branches import STEEP, Branches
from wroll_fem.dynamics.periodic.first_guesses import carried_along, corrected_from, first_guesses
from wroll_fem.dynamics.periodic.harmonic_balance import (
    BAND_SCALE,
    FrequencyCurve,
    HarmonicBalance,
    solve_motion,
)
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.numerics.bordered import Bordered
from wroll_fem.numerics.continuation import CurvePoint, StepControl
from wroll_fem.typing import FloatArray

BESIDE = 0.3
"""Distance from its place, relative to the step before, at which a point is sought in another model if it is not found
there."""


@dataclass(frozen=True)
class HarmonicCurve:
    """Response curve: periodic motions along a branch of solutions.

    Attributes
    ----------
    frequencies : (p,) rad/s, in the order along the branch; between two folds they decrease
    coefficients : (p, R, m) Fourier coefficients of q
    tangents : (p, n + 1) unit tangents in scaled unknowns, for interpolation along the branch
    iterations : (p,) number of Newton iterations
    stable : (p,) False between folds, where one real Floquet multiplier exceeds 1; other instabilities are not detected
    balance : equations of the harmonic balance
    problem : scaling of the unknowns
    gap : frequencies (rad/s) between which the response exceeds `LARGEST_GROWTH` and is not computed; None without a
        gap
    skipped : frequencies (rad/s) just past the internal resonances that were stepped over
    factors : LU factors at the points, or None; empty if none were kept
    """

    frequencies: FloatArray
    coefficients: FloatArray
    tangents: FloatArray
    iterations: np.ndarray
    stable: np.ndarray
    balance: HarmonicBalance
    problem: FrequencyCurve = field(repr=False)
    gap: tuple[float, float] | None = None
    skipped: tuple[float, ...] = ()
    factors: tuple[Bordered | None, ...] = field(default=(), repr=False)

    @classmethod
    def of_points(
        cls,
        problem: FrequencyCurve,
        points: list[CurvePoint],
        gap: tuple[float, float] | None = None,
        skipped: Sequence[float] = (),
    ) -> HarmonicCurve:
        """Response curve with the points that `continuation.follow` returns."""
        motions = [problem.motion(p.z) for p in points]
        return cls(
            frequencies=np.array([w for _, w in motions]),
            coefficients=np.array([q for q, _ in motions]),
            tangents=np.array([p.tangent for p in points]),
            iterations=np.array([p.iterations for p in points]),
            stable=np.array([p.tangent[-1] > 0.0 and p.regular for p in points]),
            balance=problem.balance,
            problem=problem,
            gap=gap,
            skipped=tuple(skipped),
            factors=tuple(p.factors for p in points) if any(p.factors for p in points) else (),
        )

    def take(self, points: list[int]) -> HarmonicCurve:
        """Curve with the points of the given indices only."""
        names = ("frequencies", "coefficients", "tangents", "iterations", "stable")
        return replace(self, **{name: getattr(self, name)[points] for name in names}, factors=())

    @property
    def beyond(self) -> int:
        """Number of points beyond the end of the curve: always zero; see `BackboneCurve`."""
        return 0

    def without_beyond(self) -> HarmonicCurve:
        """The curve itself; see `BackboneCurve`."""
        return self

    def problem_of(self, contact: HarmonicContact) -> FrequencyCurve:
        """Equations of the curve with another ``contact``, in the scale of its own."""
        return FrequencyCurve(HarmonicBalance(contact, self.balance.acceleration), self.problem.band, self.problem.size)

    def with_gap(self, low: float, high: float) -> HarmonicCurve | None:
        """Curve without the points between ``low`` and ``high``, rad/s; None if the response there is too small.

        The middle of this gap is used as the resonance frequency, which requires steep edges (`STEEP`).
        """
        kept = np.flatnonzero((self.frequencies <= low) | (self.frequencies >= high))
        part = replace(self.take(kept.tolist()), gap=(low, high))
        edges = np.abs(part.transmissibility[np.isin(part.frequencies, (low, high))])
        return part if len(edges) and edges.min() > STEEP * self.balance.largest_growth else None

    def moved_to(
        self, contact: HarmonicContact, control: StepControl, starts: FloatArray | None = None,
        only: Container[int] | None = None, exact: HarmonicContact | None = None,
    ) -> HarmonicCurve:  # fmt: skip
        """Curve whose points are recomputed in another model; points that fail to converge are left out.

        Each point is sought in the plane normal to the curve. ``starts`` (p, R, m) are first guesses in the
        other model. By default, the first guesses are the motions of this curve. Points that are not in ``only`` are
        shifted like their neighbours, no solutions; by default, all are recomputed. ``exact`` is the same contact with
        an exact Jacobian, for points that do not converge with that of ``contact``. In the same model, the kept LU
        factors of the points are used first.
        """
        shift = self.balance.model.vectors.T @ contact.model.vectors
        problems = [self.problem_of(one) for one in (contact, exact) if one is not None]
        problem, factor = problems[-1], None
        found, before = list[CurvePoint](), list[FloatArray]()
        for k, (q, w) in enumerate(zip(self.coefficients, self.frequencies, strict=True)):
            along = (self.direction(k) @ shift * problem.root).ravel()[problem.active]
            row = np.append(along, self.tangents[k, -1])
            row /= np.linalg.norm(row)
            guesses = first_guesses(q, shift, starts, k)
            places = [problem.scaled(guess, w) for guess in guesses]
            before.append(places[-1])
            if only is not None and k not in only:
                found.append(CurvePoint(places[-1], row, 0, bool(self.stable[k])))
                continue
            if k > 0 and starts is None:  # the iteration may alternate between both sides of a kink
                last = problem.scaled(self.coefficients[k - 1] @ shift, self.frequencies[k - 1])
                aside = BESIDE * float(np.linalg.norm(places[0] - last)) * row
                places += [places[0] - aside, places[0] + aside]
            steps = control.suited_to(len(row))
            own = self.factors[k] if self.factors and contact.model is self.balance.model else None
            z, history, _, factor = corrected_from(
                problems, places, row, steps, kept=own or factor, chord=starts is None or own is not None
            )
            if z is not None:
                found.append(CurvePoint(z, row, len(history), bool(self.stable[k])))
        found = found if only is None else carried_along(found, np.array(before), only)
        return HarmonicCurve.of_points(problem, found, self.gap, self.skipped)

    def extended(self, contact: HarmonicContact) -> HarmonicCurve:
        """Curve of the same motions with at least as many harmonics as ``contact``; those added have zero amplitude."""
        more = contact.sampling.size - self.coefficients.shape[1]
        if more <= 0 and self.balance.contact.complete:
            return self
        problem = self.problem_of(contact)
        changes = np.array([self.direction(k) for k in range(len(self.frequencies))])
        changes = (np.pad(changes, ((0, 0), (0, more), (0, 0))) * problem.root).reshape(len(changes), -1)
        return replace(
            self, coefficients=np.pad(self.coefficients, ((0, 0), (0, more), (0, 0))), balance=problem.balance,
            tangents=np.column_stack([changes[:, problem.active], self.tangents[:, -1]]), problem=problem, factors=(),
        )  # fmt: skip

    def overtones(self, k: int) -> float:
        """Energy norm of the harmonics above the fundamental at point ``k``, relative to that of the motion."""
        return self.problem.overtones(self.problem.scaled(self.coefficients[k], self.frequencies[k]))

    @property
    def drifts(self) -> bool:
        """Whether the mean displacement at the last point of the curve is undetermined (`FrequencyCurve.drifted`)."""
        return self.problem.drifted(self.problem.scaled(self.coefficients[-1], self.frequencies[-1]))

    @property
    def folds(self) -> int:
        """Number of folds of the curve."""
        return int(np.count_nonzero(np.diff(np.sign(self.tangents[:, -1]))))

    def direction(self, k: int) -> FloatArray:
        """(R, m) derivative of the Fourier coefficients along the curve at its point ``k``, up to a positive factor."""
        return self.problem.unpacked(self.tangents[k, :-1])

    def fundamental(self, row: FloatArray) -> np.ndarray:
        """(p,) complex amplitude of the fundamental of the output ``row`` . q (q: reduced coordinates) at each point.

        The base acceleration is A cos(wt); its complex amplitude is A.
        """
        return np.asarray(self.coefficients[:, 1] @ row - 1j * (self.coefficients[:, 2] @ row))

    @property
    def transmissibility(self) -> np.ndarray:
        """(p,) complex fundamental of the absolute tip acceleration, divided by the base acceleration.

        If a force excites the structure, it is the tip acceleration divided by the factor of the force.
        """
        tip = self.fundamental(self.balance.model.tip)
        return self.balance.model.condensation.rigid_tip - self.frequencies**2 * tip / self.balance.acceleration


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
    """Steady response of a reduced model to a base acceleration A cos(wt) in a frequency band; see `response_curve`.

    Parameters
    ----------
    harmonics, samples
        Number of harmonics H and number of samples per period.
    max_periods
        Largest number of periods until the hysteresis is periodic.
    """
    contact = HarmonicContact(model, preload, laws, Sampling(harmonics, samples), max_periods=max_periods)
    return response_curve(contact, amplitude=amplitude, frequencies=frequencies, control=control, on_point=on_point)


def response_curve(
    contact: HarmonicContact,
    *,
    amplitude: float,
    frequencies: tuple[float, float],
    control: StepControl | None = None,
    on_point: Callable[[float, int], None] | None = None,
) -> HarmonicCurve:
    """Steady response to a base acceleration A cos(wt) in a frequency band; the curve may have folds.

    The curve is followed upwards from the first frequency. A response beyond `LARGEST_GROWTH` shows a resonance whose
    damping is practically zero or too small to bound it. The curve then ends there, is also followed downwards from the
    last frequency, and has a gap between the two parts. So it does where it cannot be followed further and the response
    is already a large part of this limit (`STEEP`). A narrow internal resonance, where a harmonic of the motion
    coincides with an undamped mode, is stepped over.

    Parameters
    ----------
    amplitude
        Amplitude A of the base acceleration, m/s^2, 0-peak.
    frequencies
        First and last frequency, Hz.
    on_point
        Called with the frequency in Hz and the number of points so far.

    Raises
    ------
    InputError
        If the band is empty or the amplitude is not positive.
    ConvergenceError
        If the curve cannot be followed; ``partial`` holds the points so far (HarmonicCurve).
    """
    low, high = (2.0 * np.pi * f for f in frequencies)
    if not 0.0 < low < high:
        raise InputError(
            f"the frequencies {frequencies[0]:g} and {frequencies[1]:g} Hz of the band are not positive and increasing",
            remedy="give a lower, then a higher frequency",
        )
    if not amplitude > 0.0:
        raise InputError(
            f"the base acceleration is {amplitude:g} m/s^2", key="excitation.amplitude", remedy="use more than 0"
        )
    control = control or StepControl()
    balance = HarmonicBalance(contact, amplitude)
    start = solve_motion(balance, low, control=control)
    problem = FrequencyCurve(balance, (low, high), _response_size(balance, start, low, high))

    def report(points: list[CurvePoint]) -> None:
        if on_point is not None:
            on_point(problem.motion(points[-1].z)[1] / (2.0 * np.pi), len(points))

    branches = Branches(problem, control, report)
    points: list[CurvePoint] = []
    try:
        points = branches.follow(start, low, BAND_SCALE)
        if points[-1].z[-1] > BAND_SCALE - 1e-9:
            return HarmonicCurve.of_points(problem, points, skipped=branches.skipped)
        down = branches.follow(solve_motion(balance, high, control=control), high, 0.0)
    except ConvergenceError as error:
        found = points or error.partial
        if found:
            error.partial = HarmonicCurve.of_points(problem, found)
        raise
    last = problem.motion(points[-1].z)[1]
    upwards = [CurvePoint(p.z, -p.tangent, p.iterations, p.regular) for p in reversed(down)]
    first = problem.motion(upwards[0].z)[1]
    return HarmonicCurve.of_points(problem, points + upwards, (min(last, first), max(last, first)), branches.skipped)


def _response_size(balance: HarmonicBalance, start: FloatArray, low: float, high: float) -> float:
    """Energy norm, J^(1/2), by which the motions in the band are scaled.

    It is the larger of the norm of the first motion and half of the largest resonance at 1 % damping.
    """
    model = balance.model
    root = np.sqrt(np.maximum(model.eigenvalues, 0.0) + low * high)
    here = float(np.linalg.norm(start * root))
    inside = (model.eigenvalues > (0.8 * low) ** 2) & (model.eigenvalues < (1.2 * high) ** 2)
    resonant = balance.acceleration * np.abs(model.base[inside]) / (0.02 * model.eigenvalues[inside])
    return max(here, float((0.5 * resonant * root[inside]).max(initial=0.0)), 1e-300)
