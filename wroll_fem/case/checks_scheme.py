"""Checks of the integration scheme and of hyper-reduction against the method of the solver."""

from __future__ import annotations

from wroll_fem.case.base import validation_error
from wroll_fem.case.excitation import HistoryExcitation
from wroll_fem.case.integrator import Integrator
from wroll_fem.case.solver import Solver


def check_scheme(integrator: Integrator, solver: Solver) -> None:
    """Refuse the trigonometric scheme for methods other than reduced, which alone propagates modes.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if integrator.scheme == "trigonometric" and solver.method != "reduced":
        raise validation_error(
            f"solver.method {solver.method} does not propagate modes", key="integrator.scheme", value="trigonometric",
            remedy="use solver.method: reduced, or integrator.scheme: hht",
        )  # fmt: skip


def check_hyper_reduction(solver: Solver, excitation: HistoryExcitation, *, inside: bool) -> None:
    """Refuse hyper-reduction without a reduced model, or without periodic motions to train on.

    ``inside`` tells whether friction acts inside a coil.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if not solver.hyper_reduction:
        return
    if solver.method != "reduced":
        problem = f"solver.method {solver.method} evaluates friction at all contact points"
    elif excitation.kind not in ("chirp", "dwell"):
        problem = f"its training needs periodic motions of the base, and excitation.kind is {excitation.kind}"
    elif inside:
        problem = "it is not available for coil.inside: slipping"
    else:
        return
    raise validation_error(
        problem, key="solver.hyper_reduction", value=True,
        remedy="leave it out, or use it for a sweep or dwell with solver.method: reduced",
    )  # fmt: skip
