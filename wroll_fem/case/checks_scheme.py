"""Check of the integration scheme against the method of the solver."""

from __future__ import annotations

from wroll_fem.case.base import validation_error
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
