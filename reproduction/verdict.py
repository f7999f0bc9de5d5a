"""Verdict on one claim of the thesis."""

from __future__ import annotations

from dataclasses import dataclass

MET, NOT_MET = "met", "not met"
THESIS_ERROR = "thesis error: explained"
EXPERIMENT = "out of scope: experiment"
NOT_YET = "not yet"
NOT_COMPUTED = "not computed"
VERDICTS = (MET, NOT_MET, THESIS_ERROR, EXPERIMENT, NOT_YET, NOT_COMPUTED)
"""All verdicts in the order of the summary; the last one means that a run failed."""


@dataclass(frozen=True)
class Verdict:
    """Computed value of a claim, and whether it meets the criterion.

    Attributes
    ----------
    value
        Computed value as text, with units.
    holds
        Whether the criterion of the checklist holds.
    instead
        Verdict that replaces met and not met, one of `VERDICTS`.
    """

    value: str
    holds: bool
    instead: str = ""

    def __post_init__(self) -> None:
        if self.instead and self.instead not in VERDICTS:
            raise ValueError(f"no such verdict: {self.instead}")

    @property
    def word(self) -> str:
        """Verdict in the spelling of the checklist."""
        return self.instead or (MET if self.holds else NOT_MET)
