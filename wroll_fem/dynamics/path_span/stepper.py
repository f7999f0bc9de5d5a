"""Reduced time stepping in the span of a quasi-static path, which also looks at what the motion lacks in this span."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wroll_fem.dynamics.path_span.span import ModalMotion, PathSpan
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.dynamics.trigonometric.stepper import TrigonometricStepper
from wroll_fem.typing import FloatArray

LARGER = 1.1
"""Growth of the energy norm of the motion after which the whole structure is evaluated again."""


class PathStepper(ReducedStepper):
    """`ReducedStepper` in the modes of a `PathSpan`; whenever the motion has grown, it is checked in all unknowns.

    With `TrigonometricStepper` as second base class (`path_stepper`) these modes are propagated exactly.

    Parameters
    ----------
    span
        Modes in the span of a path.

    Attributes
    ----------
    outside : (2,) largest energy norm of what a motion lacked in the span, relative to it, and the squared energy norm
        of the largest motion that was checked, J
    """

    def __init__(
        self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions, *, dt: float,
        span: PathSpan, tolerance: float = 2e-3,
    ):  # fmt: skip
        self.span, self.outside = span, np.zeros(2)
        super().__init__(system, preload, scheme, options, dt=dt, tolerance=tolerance, condensation=span.modes)

    def _arrays(self) -> Iterator[tuple[str, np.ndarray]]:
        yield from super()._arrays()
        yield "outside", self.outside

    def _advance_block(self, acceleration: FloatArray, dt: float, time: float) -> FloatArray:
        records = super()._advance_block(acceleration, dt, time)
        rows = np.vstack(self._checked)
        m, n = self.model.size, self.system.n_points
        square = rows[:, :m] ** 2 @ self.model.eigenvalues
        at = int(np.argmax(square))
        if square[at] > LARGER**2 * self.outside[1]:
            q, a, v = (self.vectors @ rows[at, k * m : (k + 1) * m][:, None] for k in range(3))
            _, share = self.span.lacking(ModalMotion(q, v, a, rows[at, 3 * m : 3 * m + 3 * n, None], rows[at, -1:]))
            self.outside[:] = max(share, float(self.outside[0])), square[at]
        return records

    def report(self) -> dict[str, float]:
        """Numbers of `ReducedStepper`, and the largest part of the motion that its modes lacked."""
        return super().report() | {"span_error_estimate": float(self.outside[0])}


class TrigonometricPathStepper(PathStepper, TrigonometricStepper):
    """`PathStepper` whose modes are propagated exactly."""


def path_stepper(
    system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions, *, dt: float, span: PathSpan,
    tolerance: float,
) -> PathStepper:  # fmt: skip
    """Stepper in the modes of ``span`` for the ``scheme``."""
    kind = TrigonometricPathStepper if scheme.exact_modes else PathStepper
    return kind(system, preload, scheme, options, dt=dt, span=span, tolerance=tolerance)
