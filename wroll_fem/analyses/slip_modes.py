"""Modes of a coil whose wraps slide, for its periodic motions and histories: the span of its quasi-static path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from wroll_fem.analyses.followed_mode import main_mode
from wroll_fem.analyses.shared.resolution import frequency_remark
from wroll_fem.analyses.slip_path import followed_path
from wroll_fem.analyses.slip_results import base_acceleration
from wroll_fem.blas import one_thread
from wroll_fem.case.structural import OnRoll
from wroll_fem.dynamics.path_span.periodic import periodic_motion
from wroll_fem.dynamics.path_span.span import PathSpan
from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.training.training import Trained

if TYPE_CHECKING:
    from wroll_fem.case import StructuralCase
    from wroll_fem.dynamics.statics.contact_state import ContactState
    from wroll_fem.dynamics.statics.modal_path import ModalPath
    from wroll_fem.dynamics.system.system import System
    from wroll_fem.progress import Progress
    from wroll_fem.typing import FloatArray

Curve = TypeVar("Curve", HarmonicCurve, BackboneCurve)

BEYOND = 1.2
"""The path ends where its amplitude or its base acceleration exceeds that of the analysis by this factor."""

SPAN_TOLERANCE, ROUNDS = 5e-3, 3
"""Energy norm of what the motions of a curve lack in the span, relative to the motion, above which the span is
enlarged, and the largest number of curves."""


def slips_inside(case: StructuralCase) -> bool:
    """Whether the case describes a coil whose wraps slide."""
    return isinstance(case, OnRoll) and case.coil.slips


def path_span(case: StructuralCase, system: System, state: ContactState, progress: Progress) -> PathSpan:
    """Span of the path of a coil up to the amplitude, or the base acceleration, of its analysis.

    Raises
    ------
    ConvergenceError
        If the first load of the path has no equilibrium.
    """
    with one_thread():
        path = LoadPath(system, state)
        mode = main_mode(system, path)
        ratio = damping_ratio(system, path, mode)
        stuck = float(np.sqrt(mode @ (path.stiffness @ mode))) / (2.0 * np.pi)
        if isinstance(case, OnRoll) and (remark := frequency_remark(case, ["bending"], [stuck], pairs=False)):
            progress.warning(remark)
        tip, level = _wanted(case)

        def reached(found: ModalPath) -> bool:
            moved = abs(float(system.probes["tip"] @ (path.state.displacement - path.start.displacement)))
            return moved > BEYOND * tip or base_acceleration(path, found, mode, ratio)[-1] > BEYOND * level

        followed_path(path, mode, reached, progress, ends=progress.info)
        return PathSpan(path)


def _wanted(case: StructuralCase) -> tuple[float, float]:
    """Largest tip amplitude (m) and base acceleration (m/s^2) of an analysis; infinite where it does not say."""
    if case.backbone is not None and case.analysis in ("backbone", "random_response"):
        return case.backbone.tip_largest, np.inf
    return np.inf, float(getattr(case.excitation, "amplitude", np.inf))


def damping_ratio(system: System, path: LoadPath, mode: FloatArray) -> float:
    """Damping ratio of a ``mode`` (n_dofs,) of unit modal mass of the sticking structure, without friction."""
    square, found = float(mode @ (path.stiffness @ mode)), 0.0
    if system.modal_damping is not None:
        found += float(system.modal_damping.of_modes(np.array([square]))[0])
    if system.damping is not None:
        found += 0.5 * float(mode @ (system.damping @ mode)) / np.sqrt(square)
    return found


def in_span(
    span: PathSpan, solve: Callable[[], Trained[Curve]], checked: Callable[[Curve], list[int]], progress: Progress
) -> Trained[Curve]:
    """Curve in a span that is enlarged until it holds the motions of the curve.

    Parameters
    ----------
    solve
        Computes the curve in the modes of the present span.
    checked
        Indices of the points of a curve at which the whole structure is evaluated.
    """
    for number in range(1, ROUNDS + 1):
        trained = solve()
        curve = trained.curve
        ratios = curve.damping if isinstance(curve, BackboneCurve) else np.zeros(len(curve.frequencies))
        motions = [
            periodic_motion(curve.balance, curve.coefficients[k], float(curve.frequencies[k]), float(ratios[k]))
            for k in checked(curve)
        ]
        found = [span.lacking(motion) for motion in motions]
        error = max(share for _, share in found)
        if error <= SPAN_TOLERANCE or number == ROUNDS:
            break
        progress.info(f"motions lack {100 * error:.2g} % in the span of the path, which is enlarged")
        sizes = [np.sqrt(np.sum(span.modes.eigenvalues[:, None] * m.displacement**2)) for m in motions]
        shapes = [shapes / size for (shapes, _), size in zip(found, sizes, strict=True)]  # small motions count as much
        span.enlarge(np.column_stack(shapes), 0.2 * SPAN_TOLERANCE)
    return replace(trained, span_error=error)
