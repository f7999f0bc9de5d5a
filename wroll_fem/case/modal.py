"""Section `modal`: the eigenvalue analysis."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from wroll_fem.case.base import Section, Whole


class Modal(Section):
    """Which modes, and what the interface does in them."""

    count: Whole = Field(default=12, ge=1, le=500, description="number of modes (count)")
    interface: Literal["stuck", "bonded", "frictionless"] = Field(
        default="bonded",
        description="stuck: normal and elastic-slip stiffness of the preloaded interface; bonded: no relative motion; "
        "frictionless: normal contact only",
    )
