"""Reproduction of the claims of the thesis: checklist, computed values and verdicts (`wroll reproduce`)."""

from __future__ import annotations

from reproduction.checklist import CHAPTERS, Claim, checklist
from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.verdict import Verdict

__all__ = ["CHAPTERS", "Claim", "ClaimGroup", "Evidence", "Verdict", "checklist"]
