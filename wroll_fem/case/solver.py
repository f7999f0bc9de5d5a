"""Section `solver`: how the equations of a step are solved."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from wroll_fem.case.base import Real, Section, Switch, Whole


class Solver(Section):
    """Nonlinear solver and its safeguards."""

    method: Literal["reduced", "condensed", "full"] = Field(
        default="reduced",
        description="reduced: a few shapes that grow with the motion, checked against the whole structure; "
        "condensed: exact condensation on the interface; full: sparse Newton on everything (reference)",
    )
    reduction_tolerance: Real = Field(
        default=2e-3,
        gt=0,
        le=0.1,
        description="reduced: energy norm that the shapes may miss, over the largest of the motion, dimensionless",
    )
    tolerance: Real = Field(
        default=1e-8, gt=0, le=1e-3, description="relative residual of a converged step, dimensionless"
    )
    max_iterations: Whole = Field(default=30, ge=1, description="Newton iterations of a step before it is cut (count)")
    max_cuts: Whole = Field(default=6, ge=0, description="halvings of a step before the run stops (count)")
    symmetry: Switch = Field(
        default=True, description="solve half the circumference when case and mesh share the x-z plane"
    )
    checkpoint_seconds: Real = Field(default=60.0, gt=0, description="wall time between checkpoints, s")
    allow_coarse: Switch = Field(default=False, description="accept fewer than 20 steps per cycle")
