"""Checks of finished results: each limit that is exceeded gives one warning with a remedy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from wroll_fem.analyses.margins.stress import stress_doubts
from wroll_fem.analyses.shared.small_displacement import displacement_doubts

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.case import Case

ENERGY_ERROR = 0.005
"""Energy balance error, relative to the largest input work, above which the results of a run are doubtful."""


def doubts(dataset: xr.Dataset, summary: Mapping[str, Any], case: Case) -> list[str]:
    """Warnings about the results of a finished run.

    Parameters
    ----------
    dataset
        Results.
    summary
        Entries of summary.json.
    case
        Case of the run.
    """
    return [text for check in CHECKS for text in check(dataset, summary, case)]


def _energy(dataset: xr.Dataset, summary: Mapping[str, Any], case: Case) -> list[str]:
    gap = summary.get("energy_balance_error")
    if gap is None or gap <= ENERGY_ERROR:
        return []
    remedy = (
        "raise harmonic.samples and harmonic.max_periods"
        if case.analysis in ("harmonic", "backbone")
        else "raise integrator.steps_per_cycle or use solver.method: condensed"
    )
    return [f"the energy balance error is {100 * gap:.2g} % of the input: the numbers are doubtful; {remedy}"]


CHECKS = (_energy, displacement_doubts, stress_doubts)
"""Checks of a finished run; each takes results, summary and case, and returns warnings."""
