r"""Alternating frequency/time method: harmonics of the contact tractions from the harmonics of the motion.

Periodic motions are Fourier series in the phase :math:`\varphi = \omega t` with R = 2 H + 1 coefficients in the order
(constant, cos 1, sin 1, ..., cos H, sin H). The constant term and the even harmonics matter because the pressure, and
with it the friction limit, varies. The laws are evaluated at N samples of the period with dt = T/N, and the samples are
projected back by the trapezoidal rule. The friction law, the penalty and the split of the work are the functions of the
time integration (`contact.point`, `contact.laws`), with two deliberate differences. A point that opens has no release
traction: that traction makes the trapezoidal work of a time step exact, and samples are not time steps. Slip rates are
the derivatives of the Fourier series at the samples, not differences between samples.

The elastic slip starts from the preload state; periods are computed until it repeats (periodic hysteresis). The
derivatives of all these periods are computed too (`derivatives`), so that Newton's method has the exact Jacobian.

References
----------
Cameron, Griffin (1989), J. Appl. Mech. 56, 149, doi:10.1115/1.3176036 (AFT).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from wroll_fem.contact.kernels import PointLaws
from wroll_fem.contact.point import contact_dofs, per_dof
from wroll_fem.dynamics.aft import kernel
from wroll_fem.dynamics.aft.coulomb import COULOMB
from wroll_fem.dynamics.aft.derivatives import derivatives
from wroll_fem.dynamics.aft.every_mode import EveryMode, ModeMaps
from wroll_fem.dynamics.aft.half_period import HalfPeriod
from wroll_fem.dynamics.aft.matrix import Unknowns, fill_matrix
from wroll_fem.dynamics.aft.periodic_contact import PeriodicContact
from wroll_fem.dynamics.aft.sampling import Sampling, mean_phase, phase_slope
from wroll_fem.dynamics.reduction.evaluated_points import EvaluatedPoints, PointSample
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.typing import FloatArray, IntArray

Places = tuple[np.ndarray, ...]
"""Index of a block of a matrix, from `numpy.ix_`."""

PERIODIC = 1e-8
"""Change of the elastic slip during a period, relative to gamma*, below which the hysteresis counts as periodic."""

MAX_PERIODS = 8
"""Largest number of whole periods computed after the ramp until the hysteresis is periodic. Just above the friction
limit, slip in both tangential directions approaches its periodic path very slowly."""

PRESSURE_CHANGE = 0.005
"""Change of the pressure, relative to the preload pressure, below which a sticking point is omitted from the Jacobian
of Newton's method. The residual always includes every point. Where a harmonic meets a mode without damping, the
dynamic stiffness is small, and that of the omitted points is a large part of it: with 0.02, Newton's method took up to
47 iterations, or did not converge."""

SINGLE = 100
"""Number of unknowns from which Newton's matrix is formed and factored in single precision. The residual is always in
double precision, so only the number of iterations could change."""


class HarmonicContact:
    """Contact forces of a reduced model under periodic motion.

    The laws are evaluated at n contact points: at all points or, with half-period symmetry, at one of each pair of
    symmetric points. Arrays refer to these evaluated points. An array (R, m) contains R Fourier coefficients for each
    of the m reduced coordinates q.

    Attributes
    ----------
    n, laws, weights, reference, dofs : data of the evaluated points: all points, or one of each pair (`half_period`)
    own : (3 n,) indices of the evaluated points among the contact degrees of freedom of all points
    all_weights : area per contact degree of freedom of all points, m^2
    complete : whether the forces are those of all points, not of a subset

    Parameters
    ----------
    model, preload, laws
        Reduced structure, state to which motions are relative, and friction laws of all contact points.
    sampling
        Harmonics and samples.
    max_periods
        Largest number of whole periods, after the ramp, until the hysteresis is periodic.
    symmetry
        Half-period symmetry of the motions; None without symmetry. Each vector of the model has to be of one kind:
        reversed by half a period, or unchanged.
    sample
        Subset of the evaluated points whose forces replace those of all; None: all points.
    tangent
        Subset whose derivatives replace those of all points in the Jacobian, while forces are those of all points.
    maps
        Maps of all modes of the structure, if other contacts of it share them.
    """

    def __init__(
        self,
        model: ReducedModel,
        preload: ContactState,
        laws: PointLaws,
        sampling: Sampling,
        *,
        max_periods: int = MAX_PERIODS,
        symmetry: HalfPeriod | None = None,
        sample: PointSample | None = None,
        tangent: PointSample | None = None,
        maps: ModeMaps | None = None,
    ):
        self._maps = maps or ModeMaps(model.condensation, symmetry)
        self.model, self.preload, self.sampling = model, preload, sampling
        self.max_periods, self.symmetry, self._all_laws = max_periods, symmetry, laws
        points = np.arange(laws.n) if symmetry is None else symmetry.first
        share = np.ones(laws.n) if symmetry is None else symmetry.weight
        self.complete, self.tangent = sample is None, tangent
        if sample is not None:
            points, share = points[sample.points], share[sample.points] * sample.factors
        evaluated = EvaluatedPoints.of(laws, preload, model.springs, PointSample(points, share))
        self.laws, self.weights, self.reference = evaluated.laws, evaluated.weights, evaluated.reference
        self.own, self.all_weights, self.n = evaluated.dofs, per_dof(laws.area, laws.area), evaluated.n
        self.jump = np.ascontiguousarray(model.jump[self.own])
        self.force_operator = np.ascontiguousarray((self.jump * self.weights[:, None]).T)
        self.dofs = contact_dofs(self.n)
        self._rated = bool((self.laws.kind != COULOMB).any())
        self.groups = self._groups()
        self._last: tuple[PeriodicContact, FloatArray] | None = None

    def _groups(self) -> list[tuple[IntArray, IntArray]]:
        """Row indices and column indices of each group of nonzero entries in the Fourier coefficients (R, m)."""
        rows, columns = np.arange(self.sampling.size), np.arange(self.model.size)
        if self.symmetry is None:
            return [(rows, columns)]
        odd_orders = self.sampling.orders % 2 == 1
        odd = self.symmetry.reversed_ones(self.model.vectors)
        return [(rows[odd_orders], columns[odd]), (rows[~odd_orders], columns[~odd])]

    @cached_property
    def active(self) -> IntArray:
        """(k,) indices of the k unknowns in the flattened Fourier coefficients (R, m), one group after the other."""
        return np.concatenate([(rows[:, None] * self.model.size + columns).ravel() for rows, columns in self.groups])

    @cached_property
    def harmonic_blocks(self) -> list[tuple[int, Places, Places, Places]]:
        """Places of the damping of each harmonic: its order, two blocks of a Jacobian (k, k), and one of the damping.

        The first block of the Jacobian maps the sine of the harmonic to its cosine, the second maps back. Both have the
        same modes.
        """
        order, mode = np.divmod(self.active, self.model.size)
        found = []
        for k in range(1, len(self.sampling.orders), 2):
            cosine, sine = np.flatnonzero(order == k), np.flatnonzero(order == k + 1)
            found.append((k, np.ix_(cosine, sine), np.ix_(sine, cosine), np.ix_(mode[cosine], mode[sine])))
        return found

    @cached_property
    def with_all_modes(self) -> HarmonicContact:
        """The same contact with every mode of the structure; for structures of few modes."""
        complete = ReducedModel.complete(self.model.condensation)
        return HarmonicContact(complete, self.preload, self._all_laws, self.sampling, max_periods=self.max_periods)

    @property
    def every_mode(self) -> EveryMode:
        """Maps between the evaluated contact points and all modes of the structure."""
        return self._maps.of(self.sampling.orders)

    def spread(self, coefficients: FloatArray) -> FloatArray:
        """(3 n_points, R) Fourier coefficients of a traction or relative displacement at all contact points.

        ``coefficients`` (3 n, R) belong to the n evaluated points.
        """
        return coefficients if self.symmetry is None else self.symmetry.spread(coefficients, self.sampling.orders)

    def of_every_point(self, values: np.ndarray) -> np.ndarray:
        """(n_points, ...) values at all contact points, from ``values`` (n, ...) at the evaluated points.

        A point that is not evaluated takes the value of the point that represents it.
        """
        return values if self.symmetry is None else values[self.symmetry.source]

    def motion(self, coefficients: FloatArray) -> FloatArray:
        """(3 n, R) Fourier coefficients, in metres, of the relative displacement at the evaluated points.

        ``coefficients`` (R, m) are the Fourier coefficients of the reduced coordinates q.
        """
        if len(self.groups) == 1:
            return np.asarray(self.jump @ coefficients.T)
        out = np.empty((3 * self.n, self.sampling.size))
        for (rows, _), place, jump in zip(self.groups, self._places, self._group_jumps, strict=True):
            out[:, rows] = jump @ coefficients[place].T
        return out

    @cached_property
    def _places(self) -> list[tuple[np.ndarray, ...]]:
        """Index arrays that select each group of entries in the Fourier coefficients (R, m)."""
        return [np.ix_(rows, columns) for rows, columns in self.groups]

    @cached_property
    def _group_jumps(self) -> list[FloatArray]:
        return [np.ascontiguousarray(self.jump[:, columns]) for _, columns in self.groups]

    @cached_property
    def _group_forces(self) -> list[FloatArray]:
        return [self.force_operator[columns] for _, columns in self.groups]

    @cached_property
    def newton_operators(self) -> tuple[np.ndarray, np.ndarray]:
        """`force_operator` and `jump` in the precision of Newton's matrix."""
        precision = np.float32 if len(self.active) >= SINGLE else np.float64
        return self.force_operator.astype(precision, copy=False), self.jump.astype(precision, copy=False)

    @cached_property
    def _unknowns(self) -> Unknowns:
        operator, jump = self.newton_operators
        return Unknowns.of(self.groups, jump, operator)

    def evaluate(self, jump_coefficients: FloatArray, frequency: float) -> PeriodicContact:
        """Contact during a period at ``frequency`` (rad/s) for Fourier coefficients (3 n, R) of the jump, m."""
        n, s = self.n, self.sampling
        shift = self.shift(jump_coefficients)
        series, ramp, ramp_rate = s.shifted(shift)
        motion = jump_coefficients @ series.values.T
        rate = jump_coefficients @ series.velocities.T if self._rated else np.zeros((0, 0))
        path = kernel.SampledMotion(motion, rate, ramp, ramp_rate, 2.0 * np.pi / (frequency * s.samples))
        hysteresis = kernel.Hysteresis(
            slip=np.empty((2 * n, s.samples)), sliding=np.empty((n, s.samples), np.bool_),
            moved=np.zeros(n, np.bool_), periods=np.zeros(n, np.int64), change=np.zeros(n),
        )  # fmt: skip
        kernel.iterate_to_periodic(path, self.reference, self.laws, self.max_periods, PERIODIC, hysteresis)
        correction, is_open = np.empty((3 * n, s.samples)), np.empty((n, s.samples), np.bool_)
        change = np.empty(n)
        kernel.correction(path, hysteresis.slip, self.reference, self.laws, correction, is_open, change)
        harmonics = correction @ series.project.T
        return PeriodicContact(
            jump_coefficients, shift, series, path, hysteresis, correction, harmonics, is_open, change
        )

    def shift(self, jump_coefficients: FloatArray) -> float:
        """Shift of the samples, -1/2 to 1/2 sample, that places one of them where the slip of a roll turns back.

        Without it, all points turn sometimes at a sample and sometimes between two, as the phase of the motion changes
        along a curve: a ripple of up to (pi / N)^2 / 2 of the largest slip. The phase is that of the fundamental, as a
        mean over all points (`mean_phase`). The points of a roll move nearly in phase; those of other structures
        need not, and their samples are not shifted. ``jump_coefficients`` (3 n, R), m.
        """
        if self.model.condensation.n_theta < 2:
            return 0.0
        samples = mean_phase(*self._fundamental(jump_coefficients)) * self.sampling.samples / (2.0 * np.pi)
        return samples - round(samples)

    def _fundamental(self, jump_coefficients: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Area, cosine and sine of the tangential fundamental, (2 n,) each."""
        along = slice(0, 2 * self.n)
        return self.weights[along], jump_coefficients[along, 1], jump_coefficients[along, 2]

    def force(self, contact: PeriodicContact) -> FloatArray:
        """(R, m) Fourier coefficients of the contact forces on the reduced coordinates.

        They are (G Phi)^T W s. G Phi is the relative displacement per unit coordinate, W contains the areas of the
        contact points, and s is the traction correction in ``contact``. The last one is kept: Newton's matrix asks for
        the force of the motion that the residual was computed for.
        """
        if self._last is None or self._last[0] is not contact:
            self._last = contact, self._force(contact)
        return self._last[1]

    def _force(self, contact: PeriodicContact) -> FloatArray:
        if len(self.groups) == 1:
            return np.asarray((self.force_operator @ contact.coefficients).T)
        out = np.zeros((self.sampling.size, self.model.size))
        for (rows, _), place, force in zip(self.groups, self._places, self._group_forces, strict=True):
            out[place] = (force @ contact.coefficients[:, rows]).T
        return out

    def point_blocks(
        self, contact: PeriodicContact, *, threshold: float = PRESSURE_CHANGE, among: IntArray | None = None,
        precision: type = np.float64, mean: bool = False,
    ) -> tuple[IntArray, np.ndarray, FloatArray]:  # fmt: skip
        """Derivatives of s (see `PeriodicContact`) at the points that slide or open, or whose pressure varies.

        A pressure counts as varying if its largest change, relative to the preload pressure, exceeds ``threshold``.
        Only the points ``among`` those with given indices are taken; None: all. With ``mean``, the derivatives are
        those of the mean traction by the mean displacement, R = 1. ``precision`` is that of the blocks.

        Returns
        -------
        points : (a,) indices of these points
        blocks : (a, 3, R, 3, R) d(s coefficients)/d(jump coefficients), Pa/m
        by_frequency : (a, 2, R) d(tangential s)/d(ln frequency), Pa
        """
        moved = contact.hysteresis.moved
        wanted = moved | (contact.pressure_change > threshold) | contact.open.any(axis=1)
        if among is not None:
            wanted = np.isin(np.arange(self.n), among) & wanted
        points, series, products = np.flatnonzero(wanted), contact.series, self.sampling.products(contact.shift)
        if mean:
            series, products = series.of_mean(), products._replace(orders=products.orders[:1])
        size = len(series.project)
        blocks: np.ndarray = np.zeros((len(points), 3, size, 3, size), precision)
        by_frequency = np.zeros((len(points), 2, size))
        derivatives(
            points, contact.sampled, contact.hysteresis, self.reference, self.laws, series, products, blocks,
            by_frequency,
        )  # fmt: skip
        return points, blocks, by_frequency

    def weighted_blocks(self, contact: PeriodicContact, threshold: float) -> tuple[IntArray, np.ndarray, FloatArray]:
        """`point_blocks` for Newton's matrix, in its precision: of the subset `tangent`, multiplied by its factors.

        Without a subset, they are those of all points.
        """
        precision = self.newton_operators[0].dtype.type
        if self.tangent is None:
            return self.point_blocks(contact, threshold=threshold, precision=precision)
        points, blocks, by_frequency = self.point_blocks(
            contact, threshold=threshold, among=self.tangent.points, precision=precision
        )
        factors = np.zeros(self.n, precision)
        factors[self.tangent.points] = self.tangent.factors
        blocks *= factors[points, None, None, None, None]
        by_frequency *= factors[points, None, None]
        return points, blocks, by_frequency

    def jacobian(
        self, contact: PeriodicContact, *, threshold: float = PRESSURE_CHANGE
    ) -> tuple[np.ndarray, FloatArray]:
        """Derivatives of `force`: (k, k) with respect to the k unknowns, and (R, m) with respect to ln(frequency).

        Unknowns and equations are in the order of `active`. From `SINGLE` unknowns on the matrix has single precision.
        """
        count = len(self.active)
        points, blocks, by_frequency = self.weighted_blocks(contact, threshold)
        matrix, by_log = np.zeros((count, count), blocks.dtype), np.zeros((self.sampling.size, self.model.size))
        if len(points) == 0:
            return matrix, by_log
        dofs = self.dofs[points]
        fill_matrix(dofs, blocks, self._unknowns, matrix)
        if by_frequency.any():  # laws that depend on the slip rate
            along = dofs[:, :2].ravel()
            forces = self.force_operator[:, along] @ by_frequency.reshape(len(along), -1)
            for place in self._places:
                by_log[place] = forces.T[place]
        return matrix, by_log

    def add_shift(self, matrix: np.ndarray, coefficients: FloatArray, contact: PeriodicContact) -> None:
        """Add to the Jacobian ``matrix`` (k, k) what is due to the change of the `shift` with the motion.

        A shift of the samples by an angle a is a turn S(a) of the coefficients: the force is S(-a) F(S(a) c). Its
        derivative with respect to a is J c' - f', with the Jacobian J at constant shift, and the derivatives c' and f'
        of S(a) c and S(a) f. ``coefficients`` (R, m) are those of the motion of ``contact``.
        """
        if contact.shift == 0.0:
            return
        turned = self._active_turn(coefficients).astype(matrix.dtype)
        by_angle = matrix @ turned - self._active_turn(self.force(contact))
        by_motion = self.shift_slope(contact).ravel()[self.active]
        matrix += np.outer(by_angle.astype(matrix.dtype), by_motion.astype(matrix.dtype))

    def shift_slope(self, contact: PeriodicContact) -> FloatArray:
        """(R, m) derivative of the angle of the `shift` with respect to the coefficients (R, m) of the motion."""
        out = np.zeros((self.sampling.size, self.model.size))
        out[1:3] = phase_slope(*self._fundamental(contact.jump_coefficients)) @ self.jump[: 2 * self.n]
        return out

    def turn(self, coefficients: FloatArray) -> FloatArray:
        """(R, m) derivative of coefficients (R, m) with respect to the angle by which the samples are shifted."""
        out, orders = np.zeros_like(coefficients), self.sampling.orders[1::2, None]
        out[1::2], out[2::2] = orders * coefficients[2::2], -orders * coefficients[1::2]
        return out

    def _active_turn(self, coefficients: FloatArray) -> FloatArray:
        """(k,) `turn` in the order of `active`."""
        return np.asarray(self.turn(coefficients).ravel()[self.active])
