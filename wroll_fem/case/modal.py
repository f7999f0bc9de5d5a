"""Case section `modal`: the eigenvalue analysis."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from wroll_fem.case.base import Section, Whole


class Modal(Section):
    """Number of modes, and whether the interfaces are stuck, bonded or frictionless."""

    count: Whole = Field(default=12, ge=1, le=500, description="number of modes (count)")
    interface: Literal["stuck", "bonded", "frictionless"] = Field(
        default="bonded",
        description="stuck: normal and stick stiffness of the preloaded interface; bonded: no relative motion; "
        "frictionless: normal contact only; default for matrices from a file: stuck",
    )
