"""Case section `solver`: solution of the equations of a time step."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from wroll_fem.case.base import Real, Section, Switch, Whole


class Solver(Section):
    """Nonlinear solver and its safeguards."""

    method: Literal["reduced", "condensed", "full"] = Field(
        default="reduced",
        description="reduced: adaptive basis, with residual checks against the full model; "
        "condensed: exact condensation on the interface; full: sparse Newton on all DOFs (reference)",
    )
    reduction_tolerance: Real = Field(
        default=2e-3,
        gt=0,
        le=0.1,
        description="tolerance of method reduced: energy norm of the projection error divided by the largest "
        "energy norm of the motion, dimensionless",
    )
    hyper_reduction: Switch = Field(
        default=False,
        description="evaluate friction of a sweep or dwell by method reduced at a weighted subset of the contact "
        "points, which is trained on a response curve; all points follow, and show its errors",
    )
    tolerance: Real = Field(
        default=1e-8, gt=0, le=1e-3, description="relative residual of a converged step, dimensionless"
    )
    max_iterations: Whole = Field(
        default=30, ge=1, le=10000, description="largest number of Newton iterations before a step is halved (count)"
    )
    max_cuts: Whole = Field(default=6, ge=0, le=30, description="largest number of halvings of a step (count)")
    symmetry: Switch = Field(
        default=True, description="solve half the circumference if case and mesh are symmetric about the x-z plane"
    )
    checkpoint_seconds: Real = Field(default=60.0, gt=0, description="wall time between checkpoints, s")
    allow_coarse: Switch = Field(default=False, description="accept fewer than 20 steps per cycle")
