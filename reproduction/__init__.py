"""The claims of the thesis: the checklist, what is computed for each, and the verdicts (`wroll reproduce`)."""

from __future__ import annotations

from reproduction.checklist import CHAPTERS, Claim, checklist
from reproduction.evidence import Evidence
from reproduction.family import Family
from reproduction.verdict import Verdict

__all__ = ["CHAPTERS", "Claim", "Evidence", "Family", "Verdict", "checklist"]
