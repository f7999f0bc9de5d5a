"""How often intervals hold the truth: the count that a confidence of 95 % allows."""

from __future__ import annotations

from collections.abc import Sequence

from scipy.stats import binom

from wroll_fem.numerics.inference import Estimate

CHANCE = 2e-3
"""Probability that right intervals fail on one side; seeds are fixed, so a test never changes its mind."""


def holds(estimate: Estimate, truth: float) -> bool:
    """Whether the 95 % interval of an estimate holds the truth."""
    low, high = estimate.interval()
    return low <= truth <= high


def misses(found: Sequence[bool]) -> str:
    """What is wrong with the count of intervals that hold the truth; empty if 95 % explains it.

    Of 100 repetitions 88 to 100 are allowed at this chance; the slow tests ask for 90 to 99.
    """
    count, hits = len(found), sum(found)
    low, high = binom.ppf(CHANCE, count, 0.95), binom.ppf(1.0 - CHANCE, count, 0.95)
    return "" if low <= hits <= high else f"{hits} of {count} intervals hold the truth, not {low:g} to {high:g}"
