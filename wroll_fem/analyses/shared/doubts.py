"""Checks of finished results: each limit that is exceeded gives one warning with a remedy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from wroll_fem.analyses.margins.stress import stress_doubts
from wroll_fem.analyses.shared.small_displacement import displacement_doubts
from wroll_fem.case.kinds_history import HistoryCase

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.case import Case

ENERGY_ERROR = 0.005
"""Energy balance error, relative to the largest input work, above which the results of a run are doubtful."""

WIDELY_OPEN = 0.2
"""Share of the area of an interface that opens at some time, above which a time history warns. Half-sines of 3 ms open
0, 1.4 and 24 % of the lab roll at 20, 120 and 500 g."""


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
    remedy = "raise integrator.steps_per_cycle or use solver.method: condensed"
    if case.analysis in ("harmonic", "backbone"):
        remedy = "raise harmonic.samples and harmonic.max_periods"
    elif case.analysis == "two_dof":
        remedy = "compare with two_dof.method: time"
    return [f"the energy balance error is {100 * gap:.2g} % of the input: the numbers are doubtful; {remedy}"]


def _opening(dataset: xr.Dataset, summary: Mapping[str, Any], case: Case) -> list[str]:
    """Warn about interfaces that open widely; of several levels, the lowest one is named.

    Points that the preload leaves open do not count.
    """
    needed = {"open_time_fraction", "pressure", "area"}
    if not isinstance(case, HistoryCase) or not needed <= set(dataset.variables):
        return []
    area = dataset["area"].where(dataset["pressure"] > 0.0, 0.0)
    share = (area.where(dataset["open_time_fraction"] > 0.0, 0.0).sum("point") / area.sum("point")).fillna(0.0)
    at = ""
    if "level" in share.dims:
        wide = (share > WIDELY_OPEN).any("interface").values
        first = int(wide.argmax())
        at, share = f"from {float(dataset['level_db'][first]):.3g} dB on ", share.isel(level=first)
    worst = int(share.values.argmax())
    if not share.values[worst] > WIDELY_OPEN:
        return []
    return [
        f"{at}interface {worst} (0: innermost) opens over {100 * share.values[worst]:.0f} % of its area: such a motion "
        "has impacts, which depend on the time step and the normal stiffness of the contact, and no tension of the "
        "wraps closes them; lower the excitation, raise the preload, or compare with twice integrator.steps_per_cycle"
    ]


CHECKS = (_energy, _opening, displacement_doubts, stress_doubts)
"""Checks of a finished run; each takes results, summary and case, and returns warnings."""
