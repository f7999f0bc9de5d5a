"""State of a time integration as named tuples of arrays, which are passed to compiled code."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, Self

import numpy as np

from wroll_fem.contact.kernels import Reference
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.typing import FloatArray, IntArray

__all__ = [
    "Accumulated", "ContactMemory", "Dashpots", "Modal", "Motion", "Newton", "OpeningRecord", "Reference", "SlipRecord",
    "Step",
    "named_arrays",
]  # fmt: skip


class Step(NamedTuple):
    """Time step (s) and parameters of the integration scheme (see `hht`)."""

    dt: float
    alpha: float
    beta: float
    gamma: float


class Dashpots(NamedTuple):
    """Viscous damping of a structure in coordinates with unit mass, block after block.

    Either ``rates`` or the matrices are given; all are empty without damping. The matrices are flat arrays of the
    (m_b, m_b) matrices of the blocks.

    Attributes
    ----------
    rates : (m,) damping of uncoupled coordinates, 1/s
    starts : (n_blocks + 1,) index of the first coordinate of each block, then m
    coupling : damping matrices C, 1/s
    matrix : matrices of a step, 1 / (beta dt^2) + (1 + alpha) (eigenvalues + gamma / (beta dt) C), 1/s^2
    solution : inverse of ``matrix``, s^2
    """

    rates: FloatArray
    starts: IntArray
    coupling: FloatArray
    matrix: FloatArray
    solution: FloatArray


class Modal(NamedTuple):
    """Linear structure in coordinates with unit mass and diagonal stiffness.

    Attributes
    ----------
    eigenvalues : (m,) rad^2/s^2
    base : (m,) participation factors; the load is -base per unit base acceleration, kg^(1/2)
    tip : (m,) tip displacement per unit coordinate
    probes : (p, m) displacement of the other probes per unit coordinate
    inverse : (m,) 1 / (1 / (beta dt^2) + (1 + alpha) (eigenvalue + gamma / (beta dt) rate)), s^2; empty if damping
        couples the coordinates
    dashpots : viscous damping
    """

    eigenvalues: FloatArray
    base: FloatArray
    tip: FloatArray
    probes: FloatArray
    inverse: FloatArray
    dashpots: Dashpots


class Motion(NamedTuple):
    """Motion of the structure relative to base and preload state, in the coordinates of the stepper.

    Attributes
    ----------
    q, v, a : (m,) displacement, velocity, acceleration
    residual : (m,) r = K u + C v + G^T W t - f
    residual_change : (m,) change of the residual during the last step
    """

    q: FloatArray
    v: FloatArray
    a: FloatArray
    residual: FloatArray
    residual_change: FloatArray

    @classmethod
    def zeros(cls, m: int) -> Self:
        """State of rest in ``m`` coordinates."""
        return cls(*np.zeros((5, m)))


class ContactMemory(NamedTuple):
    """Committed state of all contact points, with the preload included.

    Attributes
    ----------
    jump : (3 n,) relative displacement, m
    elastic_slip : (2 n,) m
    traction : (3 n,) Pa
    """

    jump: FloatArray
    elastic_slip: FloatArray
    traction: FloatArray

    @classmethod
    def of(cls, state: ContactState) -> Self:
        """Copy of the jump, elastic slip and traction of a static state."""
        return cls(state.jump.copy(), state.elastic_slip.copy(), state.traction.copy())


class SlipRecord(NamedTuple):
    """Slip of every contact point since the start of the run.

    Attributes
    ----------
    path : (n,) accumulated slip (length of the slip path), m
    peak : (n,) largest tangential displacement relative to the preload state, m
    peak_vector : (2 n,) hoop and axial components of this displacement, m
    """

    path: FloatArray
    peak: FloatArray
    peak_vector: FloatArray


class OpeningRecord(NamedTuple):
    """Opening of every contact point since the start of the run.

    Attributes
    ----------
    gap : (n,) largest normal relative displacement, m, negative at a point that stays pressed
    open_time : (n,) time during which the point was open, s
    """

    gap: FloatArray
    open_time: FloatArray


class Accumulated(NamedTuple):
    """Work, slip and opening accumulated since the start of the run.

    Attributes
    ----------
    work : (5,) work of the interfaces, J; entries as in `contact.kernels.interface_work`
    flows : (3,) work of base, scheme and dashpots, J; indices in `records`
    slip : slip of the contact points
    opening : opening of the contact points
    """

    work: FloatArray
    flows: FloatArray
    slip: SlipRecord
    opening: OpeningRecord

    @classmethod
    def zeros(cls, n: int) -> Self:
        """Zero totals for ``n`` contact points."""
        slip = SlipRecord(np.zeros(n), np.zeros(n), np.zeros(2 * n))
        return cls(np.zeros(5), np.zeros(3), slip, OpeningRecord(np.full(n, -np.inf), np.zeros(n)))


class Newton(NamedTuple):
    """Controls of the nonlinear solution of a step, and its residuals.

    Attributes
    ----------
    limit : largest residual of a converged step, m
    max_iterations : largest number of iterations; a step that needs more fails
    history : (max_iterations + 1,) residuals of the last step, m
    """

    limit: float
    max_iterations: int
    history: FloatArray


def named_arrays(state: NamedTuple, prefix: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """Arrays of a named tuple and of the named tuples in it, with the names of their fields."""
    for name, value in state._asdict().items():
        if isinstance(value, tuple):
            yield from named_arrays(value, f"{prefix}{name}_")  # type: ignore[arg-type]  # a named tuple
        else:
            yield f"{prefix}{name}", value
