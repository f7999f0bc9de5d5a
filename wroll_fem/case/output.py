"""Section `output`: what a run writes besides its results; it never changes numbers."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from .base import Section, Switch, Whole


class Output(Section):
    """Fields and figures of a run folder."""

    fields: Literal["none", "slip_map", "all"] = Field(
        default="slip_map",
        description="fields written as .vtu: none, slip_map, or all (also mode shapes and displacements)",
    )
    every: Whole = Field(default=0, ge=0, description="write fields every this many steps (count); 0: only at the end")
    figures: Switch = Field(default=True, description="draw figures at the end of the run")
