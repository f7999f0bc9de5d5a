"""Length of a random record from the wanted accuracy of its spectra."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, TypeVar

from wroll_fem.analyses.forecasts.closed_forms import beam_frequency
from wroll_fem.analyses.random_reading import LARGEST_SHARE, SETTLED
from wroll_fem.case.excitation.random import FEWEST_LINES, Accuracy
from wroll_fem.case.structural import OnRoll
from wroll_fem.signals.random.welch import wanted_duration, wanted_resolution

if TYPE_CHECKING:
    from wroll_fem.case import HistoryCase

    C = TypeVar("C", bound=HistoryCase)


def planned(case: C) -> C:
    """Case whose `excitation.duration` is a number; other analyses unchanged.

    The half-power width 2 zeta f_n and the wanted bias give the resolution, the wanted random error the number of
    averages (`signals.random.welch`). Several records share the averages. The transient of the start is added.
    """
    excitation = case.excitation
    if excitation.kind != "random" or excitation.duration != "auto":
        return case
    wanted = excitation.accuracy or Accuracy()
    f_n = wanted.frequency or (beam_frequency(case, bonded=False) if isinstance(case, OnRoll) else 0.0)
    resolution = wanted_resolution(f_n, wanted.zeta, wanted.bias)
    steady = wanted_duration(resolution, min(0.5, wanted.random_error * (excitation.records or 1) ** 0.5))
    settling = SETTLED / (2.0 * pi * f_n * wanted.zeta)
    low, high = excitation.psd.table.band
    duration = max(steady + settling, settling / LARGEST_SHARE, 1.01 * FEWEST_LINES / (high - low))
    changed = excitation.model_copy(update={"duration": float(f"{duration:.4g}"), "accuracy": wanted})
    return case.model_copy(update={"excitation": changed})
