r"""Shear capacity: largest force before macroscopic slip (thesis, equation E.1), with its error.

The largest sample exceeds the capacity by the noise. After a force drop, the capacity is therefore the value, at the
drop, of a line through the force before it. After a displacement jump it is the force F_c at the knee of

.. math:: F = F_c + K \min(x - x_c, 0) + s \max(x - x_c, 0)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.events import Event, Rule
from wroll_fem.lab.shear.record import WIDTH, ShearRecord
from wroll_fem.numerics.inference import Estimate, Fit, fit, linear_fit
from wroll_fem.typing import FloatArray

BEFORE = 0.15
"""Share of the samples before a drop through which the line is fitted."""

FROM = 0.5
"""Fraction of the largest force from which the knee is fitted."""

CURVED = 3.5
"""Ratio of a quadratic term to its error from which the force before a drop is called curved."""


class Capacity(NamedTuple):
    """Shear capacity.

    Attributes
    ----------
    force
        Capacity F_c, N.
    rule
        Rule that found the onset of slip.
    onset
        Index of the first sample after the onset.
    largest
        Largest force sample up to then, N: above the capacity by the noise.
    doubts
        Doubts about the number, one sentence each.
    """

    force: Estimate
    rule: Rule
    onset: int
    largest: float
    doubts: tuple[str, ...] = ()


def capacity(record: ShearRecord, event: Event) -> Capacity:
    """Shear capacity of a record with a known event.

    Raises
    ------
    InputError
        If too few samples lie before or after the event.
    """
    return _before_drop(record, event) if event.rule == "force_drop" else _at_knee(record, event)


def _before_drop(record: ShearRecord, event: Event) -> Capacity:
    count = max(24, round(BEFORE * event.onset))
    stop = event.onset - WIDTH
    start = stop - count
    if start < 0:
        raise InputError(
            f"{event.onset} samples before the force drop", file=record.source,
            remedy=f"sample faster: {count + WIDTH} are needed",
        )  # fmt: skip
    first = _line(record, start, stop, 1)
    onset = _first_below(record, first, start, stop, min(event.onset + WIDTH, len(record.time) - 1))
    line = _line(record, start, onset, 1)
    curve = _line(record, start, onset, 2)
    doubts = []
    if abs(curve["c2"].value) > CURVED * curve["c2"].error:
        line = curve
        doubts.append("the force before the drop is curved; a parabola is extrapolated to the drop")
    at = _scaled_time(record, start, onset, 0.5 * (record.time[onset - 1] + record.time[onset]))
    powers = at ** np.arange(len(line.names))
    value = line.predicted(powers, float(powers @ line.x))
    rise = float(line.x[1]) * (record.time[onset] - record.time[onset - 1]) / (record.time[onset] - record.time[start])
    error = float(np.hypot(value.error, rise / np.sqrt(12.0)))  # the drop starts anywhere between two samples
    if line.correlated:
        doubts.append("the force before the drop follows no line; the interval may be too narrow")
    largest = float(record.force[:onset].max())
    return Capacity(Estimate(value.value, error, value.freedom), event.rule, onset, largest, tuple(doubts))


def _scaled_time(record: ShearRecord, start: int, onset: int, time: FloatArray | float) -> FloatArray:
    """Time relative to the window from ``start`` to ``onset``: 0 at its start, 1 at the first sample after it."""
    return np.asarray((time - record.time[start]) / (record.time[onset] - record.time[start]))


def _line(record: ShearRecord, start: int, onset: int, degree: int) -> Fit:
    s = _scaled_time(record, start, onset, record.time[start:onset])
    return linear_fit({f"c{k}": s**k for k in range(degree + 1)}, record.force[start:onset])


def _first_below(record: ShearRecord, line: Fit, start: int, stop: int, found: int) -> int:
    """First sample after ``stop`` that lies clearly below the line, and stays there up to ``found``."""
    s = _scaled_time(record, start, stop, record.time[stop : found + 1])
    below = line.x[0] + line.x[1] * s - record.force[stop : found + 1]
    last_above = np.flatnonzero(below < 4.0 * line.noise_level)
    return stop + (int(last_above[-1]) + 1 if last_above.size else 0) if below[-1] >= 0.0 else found


def _at_knee(record: ShearRecord, event: Event) -> Capacity:
    smooth, x = record.smooth_force, record.displacement
    top = float(smooth[: event.onset + 1].max())
    start = int(np.flatnonzero(smooth[: event.onset] <= FROM * top)[-1]) + 1 if smooth[0] <= FROM * top else 0
    slope = record.slope(start, max(start + 10, int(np.argmax(smooth > 0.9 * top))))
    elastic = top / slope
    stop = int(np.argmax(x > x[event.onset] + elastic)) or len(x)
    if stop - event.onset < 10:
        raise InputError(
            f"{stop - event.onset} samples after the onset of slip", file=record.source,
            remedy="record longer or sample faster: 10 are needed",
        )  # fmt: skip
    own, y = x[start:stop], record.force[start:stop]
    knee = float(own[0] + (top - smooth[start]) / slope)

    def model(p: FloatArray) -> FloatArray:
        away = own - knee - p[1] * elastic
        return np.asarray(p[0] + p[2] * slope * np.minimum(away, 0.0) + p[3] * slope * np.maximum(away, 0.0))

    start_at = {"force": top, "knee": 0.0, "before": 1.0, "after": 0.0}
    found = fit(model, y, start_at, scales={"knee": 0.1, "after": 0.1})
    doubts = []
    if found.correlated:
        doubts.append("the force turns gradually and not at a knee; the interval may be too narrow")
    if found["after"].value > 0.2 * found["before"].value:
        doubts.append("the force rises on after the onset of slip; the capacity is the force at the knee")
    at = knee + found["knee"].value * elastic
    onset = start + int(np.argmax(own > at))
    return Capacity(found["force"], event.rule, onset, float(record.force[: onset + 1].max()), tuple(doubts))
