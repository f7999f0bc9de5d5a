"""The claims of the source: the checklist, what is computed for each, and the verdicts (`wroll reproduce`)."""

from __future__ import annotations

from wroll_fem.claims.checklist import CHAPTERS, Claim, checklist
from wroll_fem.claims.evidence import Evidence
from wroll_fem.claims.family import Family
from wroll_fem.claims.verdict import Verdict

__all__ = ["CHAPTERS", "Claim", "Evidence", "Family", "Verdict", "checklist"]
