r"""Basis of a reduced model by harmonic balance itself: adds what the balance of the whole structure finds missing.

A curve is computed in a small basis. At a few of its points the balance of the *whole* structure is evaluated (all
modes of `condensation`), and linearised there, exactly as in Newton's method but with every point of the
interface and every mode:

.. math:: (I + F D)\, z = -G L^{-1} r, \qquad \delta = -L^{-1} (r + G^T W D z), \qquad F = G L^{-1} G^T W

for the jump z of the correction :math:`\delta`; L is the dynamic stiffness of each harmonic, D the exact derivative
of the contact law. GMRES needs some ten products with F. The principal shapes of the corrections join the basis
until the corrections are small; what is left is the error estimate.

The first basis holds the modes that the base excites, static responses, and such corrections of imposed motions in
the main mode, from the onset of slip to gross slip: it contains the shapes of sliding before the first curve.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
import scipy.linalg as la

from wroll_fem.contact.laws import PointLaws
from wroll_fem.dynamics.periodic.aft import MAX_PERIODS, HarmonicContact, Sampling
from wroll_fem.dynamics.periodic.backbone import BackboneCurve, main_mode, solve_backbone
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance, HarmonicCurve, solve_response
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel, contact_jump, modal_force
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.continuation import StepControl
from wroll_fem.numerics.krylov import gmres
from wroll_fem.typing import FloatArray

NEAR_RESONANCE = 0.02
"""The dynamic stiffness of a mode is kept above this share of the larger of eigenvalue and frequency squared."""

Curve = TypeVar("Curve", HarmonicCurve, BackboneCurve)

KRYLOV, KRYLOV_TOLERANCE = 80, 1e-3
"""Maximum number of GMRES iterations, and the relative residual at which they end."""

SMALL = 40
"""Structures with fewer modes are not reduced."""

COMPRESSION = 0.3
"""Between two curves, shapes of the last curve below this share of the tolerance leave the basis."""

START_MODES = 12
SLIP_LEVELS = (1.2, 1.6, 2.5, 5.0, 12.0, 40.0)
"""Imposed motions of the first basis: largest relative displacement over gamma*."""


@dataclass(frozen=True)
class Correction:
    """What the whole structure adds to a motion of a reduced model.

    Attributes
    ----------
    modal : (r, R) first-order correction in modes of the condensation
    shapes : (r, R) the same for unit energy norm of the motion
    energy : its energy norm over that of the motion
    tip : change of the fundamental of the tip over that of the motion
    """

    modal: FloatArray
    shapes: FloatArray
    energy: float
    tip: float


def correction(
    balance: HarmonicBalance,
    coefficients: FloatArray,
    frequency: float,
    along: FloatArray | None = None,
    damping: float = 0.0,
) -> Correction:
    """First-order correction of a motion (R, m) at ``frequency`` (rad/s) by the balance of the whole structure.

    ``along`` (k, R, m) are directions in which a change does not count: that of the curve, since on a steep flank any
    small change of the frequency looks large; of a mode also its amplitude and its phase, in which it is free.
    ``damping`` is the negative modal damping of a nonlinear mode.
    """
    contact, model = balance.contact, balance.model
    c, orders = model.condensation, balance.orders
    modal = model.vectors @ coefficients.T  # (r, R)
    state = contact.evaluate(contact.motion(coefficients), frequency)
    squares = (orders * frequency) ** 2
    force = modal_force(c, contact.weights[:, None] * state.coefficients)
    residual = (c.eigenvalues[:, None] - squares) * modal + force
    residual[:, 1] += balance.acceleration * c.base
    if c.damping is not None:
        w = orders[1::2] * frequency
        residual[:, 1::2] += w * (c.damping @ modal[:, 2::2])
        residual[:, 2::2] -= w * (c.damping @ modal[:, 1::2])
    if damping:
        w = orders[1::2] * frequency
        residual[:, 1::2] -= 2.0 * damping * frequency * w * modal[:, 2::2]
        residual[:, 2::2] += 2.0 * damping * frequency * w * modal[:, 1::2]
    each = (np.unique(orders) * frequency) ** 2
    stiffness = c.eigenvalues - each[:, None]  # (H + 1, r)
    least = NEAR_RESONANCE * np.maximum(c.eigenvalues, each[:, None])
    stiffness = np.where(np.abs(stiffness) < least, np.where(stiffness < 0.0, -least, least), stiffness)
    inverse = 1.0 / stiffness[orders.astype(int)].T  # (r, R)
    points, blocks, _ = contact.point_blocks(state, threshold=0.0)
    dofs = contact.dofs[points]

    def changed(z: FloatArray) -> FloatArray:
        """D z: traction (3 n, R) of a jump (3 n, R)."""
        out = np.zeros_like(z)
        out[dofs] = np.einsum("airjq,ajq->air", blocks, z[dofs], optimize=True)
        return out

    def answer(z: FloatArray) -> FloatArray:
        """L^{-1} G^T W D z: modal displacement (r, R)."""
        return np.asarray(inverse * modal_force(c, contact.weights[:, None] * changed(z)))

    direct = -inverse * residual
    z = gmres(
        lambda v: v + contact_jump(c, answer(v)), contact_jump(c, direct), tolerance=KRYLOV_TOLERANCE, iterations=KRYLOV
    )
    delta = direct - answer(z)
    root = np.sqrt(np.maximum(c.eigenvalues, 0.0) + frequency**2)[:, None]
    if along is not None:
        shapes = root * np.einsum("ri,kqi->krq", model.vectors, along)
        directions = la.qr(shapes.reshape(len(along), -1).T, mode="economic")[0]
        scaled = (root * delta).ravel()
        delta = (scaled - directions @ (directions.T @ scaled)).reshape(delta.shape) / root
    tip, moved = c.tip @ delta[:, 1:3], c.tip @ modal[:, 1:3]
    size = float(np.linalg.norm(root * modal))
    return Correction(
        delta,
        delta / size,
        float(np.linalg.norm(root * delta)) / size,
        float(np.linalg.norm(tip) / np.linalg.norm(moved)),
    )


def first_model(condensation: Condensation, preload: ContactState, laws: PointLaws, sampling: Sampling) -> ReducedModel:
    """Span to start from: modes and static responses, and the shapes of slip under imposed motions."""
    c = condensation
    count = len(c.eigenvalues)
    if count <= SMALL:
        return ReducedModel.complete(c)
    values = np.maximum(c.eigenvalues, 1e-6 * c.eigenvalues[c.eigenvalues > 0].min())
    leading = np.argsort(-np.abs(c.base * c.tip))[:START_MODES]
    modes = np.zeros((count, len(leading)))
    modes[leading, np.arange(len(leading))] = 1.0
    model = ReducedModel.of_vectors(c, np.column_stack([modes, c.base / values, c.tip / values]))
    if not len(laws.area):
        return model
    rest = HarmonicBalance(HarmonicContact(model, preload, laws, sampling), 0.0)
    main = main_mode(model)
    frequency = 0.95 * float(np.sqrt(model.eigenvalues[main]))
    reach = float(np.max(np.abs(model.jump[: 2 * len(laws.area), main]) / np.repeat(laws.gamma, 2)))
    shapes = []
    for level in SLIP_LEVELS:
        q = np.zeros((sampling.size, model.size))
        q[1, main] = level / max(reach, 1e-300)
        scale = float(np.sqrt(model.eigenvalues[main]) * q[1, main])
        shapes.append(correction(rest, q, frequency).modal / scale)
    return _with_shapes(model, np.column_stack(shapes), 3e-3)


def _with_shapes(model: ReducedModel, shapes: FloatArray, least: float) -> ReducedModel:
    """Model whose basis also has the principal ``shapes`` (r, k), scaled to unit motion, above ``least`` in energy."""
    root = np.sqrt(np.maximum(model.condensation.eigenvalues, 1e-12 * model.condensation.eigenvalues.max()))[:, None]
    left, size, _ = la.svd(root * shapes, full_matrices=False)
    kept = left[:, size > least] / root
    return model.enriched(kept) if kept.shape[1] else model


def _principal(model: ReducedModel, coefficients: FloatArray, least: float) -> ReducedModel:
    """Span of the principal shapes of motions (p, R, m), above ``least`` of a motion's energy norm."""
    root = np.sqrt(np.maximum(model.eigenvalues, 1e-12 * model.eigenvalues.max()))
    scaled = coefficients * root
    scaled = scaled / np.linalg.norm(scaled, axis=(1, 2), keepdims=True)
    left, size, _ = la.svd(scaled.reshape(-1, model.size).T, full_matrices=False)
    shapes = model.vectors @ (left[:, size > least] / root[:, None])
    return ReducedModel.of_vectors(model.condensation, shapes)


@dataclass(frozen=True)
class Trained(Generic[Curve]):
    """Response curve or backbone with the basis that was enriched for it.

    Attributes
    ----------
    curve : response or backbone
    energy_error : largest energy norm of what the whole structure still adds at the checked points, over the motion's
    tip_error : largest change of the tip's fundamental that it makes
    rounds : curves computed
    """

    curve: Curve
    energy_error: float
    tip_error: float
    rounds: int


def checked_points(curve: HarmonicCurve) -> list[int]:
    """Points of a curve to compare with the whole structure: both ends, the peak, and its flanks."""
    size = np.abs(curve.transmissibility)
    peak = int(size.argmax())
    points = {0, peak, len(size) - 1}
    for level in (0.85, 0.6, 0.35):
        points.add(int(np.argmin(np.abs(size[: peak + 1] - level * size[peak]))))
        points.add(peak + int(np.argmin(np.abs(size[peak:] - level * size[peak]))))
    return sorted(points)


def _trained(
    model: ReducedModel,
    solve: Callable[[ReducedModel], Curve],
    check: Callable[[Curve], list[Correction]],
    tolerance: float,
    max_rounds: int,
    on_round: Callable[[int, ReducedModel, float], None] | None,
) -> Trained[Curve]:
    """Curves in bases that grow until the corrections are below ``tolerance``."""
    before, compress = np.inf, len(model.condensation.eigenvalues) > SMALL
    for number in range(1, max_rounds + 1):
        stopped: ConvergenceError | None = None
        try:
            curve = solve(model)
        except ConvergenceError as stop:
            if len(getattr(stop.partial, "frequencies", ())) < 3:
                raise
            curve, stopped = stop.partial, stop
        found = check(curve)
        error = max(f.energy for f in found)
        if on_round is not None:
            on_round(number, model, error)
        if error <= tolerance:
            if stopped is not None:
                raise stopped
            return Trained(curve, error, max(f.tip for f in found), number)
        if number > 1 and error > 0.7 * before:
            compress = False  # what was left out is missed
        kept = _principal(model, curve.coefficients, COMPRESSION * tolerance) if compress else model
        model, before = _with_shapes(kept, np.column_stack([f.shapes for f in found]), 0.2 * tolerance), error
    failure = ConvergenceError(
        "the reduced model does not reach harmonic.reduction_tolerance",
        time_s=None,
        iterations=max_rounds,
        residual_history=[error],
        advice="use a larger harmonic.reduction_tolerance, or check whether the surfaces open widely",
    )
    failure.partial = curve
    raise failure


def trained_response(
    condensation: Condensation,
    preload: ContactState,
    laws: PointLaws,
    *,
    amplitude: float,
    frequencies: tuple[float, float],
    harmonics: int = 3,
    samples: int = 64,
    max_periods: int = MAX_PERIODS,
    tolerance: float = 1e-3,
    max_rounds: int = 8,
    control: StepControl | None = None,
    on_round: Callable[[int, ReducedModel, float], None] | None = None,
) -> Trained[HarmonicCurve]:
    """Response curve (`harmonic_balance.solve_response`) of the whole structure to ``tolerance`` in the energy norm.

    Parameters
    ----------
    tolerance
        Largest correction at the checked points, relative to the motion in the energy norm; the tip's is smaller.
    on_round
        Called with the number of the curve, its model and its error.

    Raises
    ------
    ConvergenceError
        When the curve cannot be followed in a good basis, or the basis does not become good; ``partial`` holds the
        last curve.
    """

    def solve(model: ReducedModel) -> HarmonicCurve:
        return solve_response(
            model, preload, laws, amplitude=amplitude, frequencies=frequencies, harmonics=harmonics, samples=samples,
            max_periods=max_periods, control=control,
        )  # fmt: skip

    def check(curve: HarmonicCurve) -> list[Correction]:
        points = checked_points(curve)
        return [
            correction(curve.balance, curve.coefficients[k], curve.frequencies[k], curve.direction(k)[None])
            for k in points
        ]

    model = first_model(condensation, preload, laws, Sampling(harmonics, samples))
    return _trained(model, solve, check, tolerance, max_rounds, on_round)


def trained_backbone(
    condensation: Condensation,
    preload: ContactState,
    laws: PointLaws,
    *,
    tip_amplitudes: tuple[float, float],
    harmonics: int = 3,
    samples: int = 64,
    max_periods: int = MAX_PERIODS,
    tolerance: float = 1e-3,
    max_rounds: int = 8,
    control: StepControl | None = None,
    on_round: Callable[[int, ReducedModel, float], None] | None = None,
) -> Trained[BackboneCurve]:
    """Backbone (see `backbone.solve_backbone`) of the whole structure; arguments and errors as `trained_response`."""

    def solve(model: ReducedModel) -> BackboneCurve:
        return solve_backbone(
            model, preload, laws, tip_amplitudes=tip_amplitudes, harmonics=harmonics, samples=samples,
            max_periods=max_periods, control=control,
        )  # fmt: skip

    def free_of(curve: BackboneCurve, k: int) -> FloatArray:
        q = curve.coefficients[k]
        size = np.linalg.norm(q)
        return np.array([curve.direction(k), q / size, curve.balance.velocity(q, 1.0) / size])

    def check(curve: BackboneCurve) -> list[Correction]:
        points = np.unique(np.linspace(0, len(curve.frequencies) - 1, 9).astype(int))
        return [
            correction(curve.balance, curve.coefficients[k], curve.frequencies[k], free_of(curve, k), curve.damping[k])
            for k in points
        ]

    model = first_model(condensation, preload, laws, Sampling(harmonics, samples))
    return _trained(model, solve, check, tolerance, max_rounds, on_round)
