"""The claims of the source: the checklist, what is computed for each, and the verdicts (`wroll reproduce`)."""

from __future__ import annotations

from .checklist import CHAPTERS, Claim, checklist
from .evidence import Evidence
from .family import Family
from .verdict import Verdict

__all__ = ["CHAPTERS", "Claim", "Evidence", "Family", "Verdict", "checklist"]
