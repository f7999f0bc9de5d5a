"""Section `output`: what a run writes. Only `damping` changes numbers, the readings of a finished curve."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import Field

from wroll_fem.case.base import Section, Switch, Whole, wrong

if TYPE_CHECKING:
    from wroll_fem.case.case import Case

_READ = ("sweep", "harmonic", "two_dof")  # analyses with a curve over frequency


class Output(Section):
    """Fields and figures of a run folder."""

    fields: Literal["none", "slip_map", "all"] = Field(
        default="slip_map",
        description="fields written as .vtu: none, slip_map, or all (also mode shapes and displacements)",
    )
    every: Whole = Field(default=0, ge=0, description="write fields every this many steps (count); 0: only at the end")
    figures: Switch = Field(default=True, description="draw figures at the end of the run")
    damping: Literal["half_power", "gaussian_fit", "rational_fraction", "choose"] = Field(
        default="half_power",
        description="what reads f_n and zeta from a transmissibility (sweep, harmonic, two_dof); choose: by its shape",
    )


def damping_fits(case: Case) -> None:
    """Only a curve over frequency can be read."""
    method = case.output.damping
    if method == "half_power":
        return
    if case.analysis not in _READ:
        raise wrong(
            f"analysis {case.analysis} has no curve over frequency to read", key="output.damping", value=method,
            remedy=f"leave it out, or use one of the analyses {', '.join(_READ)}",
        )  # fmt: skip
    if case.two_dof is not None and case.two_dof.design_space is not None:
        raise wrong(
            "the map of the design space is read by half power", key="output.damping", value=method,
            remedy="leave it out, or leave two_dof.design_space out",
        )  # fmt: skip
