"""Case section `output`: files of a run, and damping estimator."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from wroll_fem.case.base import Section, Switch, Whole


class Output(Section):
    """Fields and figures that are written to the run folder, and damping estimator."""

    fields: Literal["none", "slip_map", "all"] = Field(
        default="slip_map",
        description="fields written as .vtu: none, slip_map, or all (also mode shapes and displacements)",
    )
    every: Whole = Field(
        default=0, ge=0, le=10**9, description="number of steps between written fields (count); 0: only at the end"
    )
    figures: Switch = Field(default=True, description="draw figures at the end of the run")
    damping: Literal["half_power", "gaussian_fit", "rational_fraction", "choose"] = Field(
        default="half_power",
        description="estimator of f_n and zeta from a transmissibility (sweep, harmonic, two_dof); choose: "
        "selects the estimator by the shape of the peak",
    )
