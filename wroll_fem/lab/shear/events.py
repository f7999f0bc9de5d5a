r"""Onset of macroscopic slip in a record: the force drops, or the displacement runs away from the elastic line.

The thesis (section E.3) names both and stops its tests at a drop of 1 N or a displacement of 1 mm.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.record import WIDTH, ShearRecord

Rule = Literal["force_drop", "displacement_jump"]

DROP = 1.0
"""Force drop of the thesis, N."""

EARLY = (0.1, 0.5)
"""Fractions of the largest force between which the elastic line of the displacement jump is fitted."""

OFFSET = 0.2
"""Distance from the elastic line at which the displacement jumps, relative to the elastic displacement at the largest
force, unless a length is given."""

CLEAR = 6.0
"""Smallest drop, in standard deviations of the noise of the smoothed force."""


class Event(NamedTuple):
    """Onset of slip: the rule that found it, and the number of the first sample beyond its threshold."""

    rule: Rule
    onset: int


def find_event(
    record: ShearRecord, *, rule: Rule | Literal["auto"] = "auto", drop: float = DROP, jump: float | None = None
) -> Event:
    """Find the onset of slip.

    Parameters
    ----------
    record
        Record of one loading.
    rule
        Rule to use; `auto` takes the drop if it comes first or together with the jump.
    drop
        Fall of the force below its largest value until then, N. Drops that the noise explains are ignored.
    jump
        Distance of the displacement from the elastic line, m; by default `OFFSET` of the elastic displacement at the
        largest force.

    Raises
    ------
    InputError
        If no slip is reached.
    """
    fallen = _drop(record, drop) if rule != "displacement_jump" else None
    away = _jump(record, jump) if rule != "force_drop" else None
    if fallen is not None and (away is None or fallen <= away + 2 * WIDTH):
        return Event("force_drop", fallen)
    if away is not None:
        return Event("displacement_jump", away)
    wanted = {
        "force_drop": f"the force never falls by {drop:g} N",
        "displacement_jump": "the displacement stays on the elastic line",
        "auto": f"the force never falls by {drop:g} N and the displacement stays on the elastic line",
    }[rule]
    raise InputError(
        f"no slip is reached: {wanted} up to {record.smooth_force.max():.4g} N", file=record.source,
        remedy="load further, lower event_drop or event_jump, or use event_rule: none for the stiffness alone",
    )  # fmt: skip


def rises_between(record: ShearRecord, low: float, high: float, stop: int) -> tuple[int, int]:
    """First samples, before ``stop``, at which the smoothed force exceeds ``low`` and ``high``, N.

    Raises
    ------
    InputError
        If fewer than ten samples lie between them.
    """
    smooth = record.smooth_force[:stop]
    above = np.flatnonzero(smooth > high)
    end = int(above[0]) if above.size else len(smooth)
    below = np.flatnonzero(smooth[:end] <= low)
    start = int(below[-1]) + 1 if below.size else 0
    if end - start < 10:
        raise InputError(
            f"{max(0, end - start)} samples between {low:.4g} N and {high:.4g} N", file=record.source,
            remedy="sample faster, load more slowly, or widen window",
        )  # fmt: skip
    return start, end


def _drop(record: ShearRecord, drop: float) -> int | None:
    smooth = record.smooth_force
    threshold = max(drop, CLEAR * record.smooth_noise)
    found = np.flatnonzero(np.maximum.accumulate(smooth) - smooth > threshold)
    return int(found[0]) if found.size else None


def _jump(record: ShearRecord, jump: float | None) -> int | None:
    smooth = record.smooth_force
    top = float(smooth.max())
    start, end = rises_between(record, EARLY[0] * top, EARLY[1] * top, len(smooth))
    stiffness, offset = record.line(start, end)
    if not stiffness > 0.0:
        raise InputError(
            "the force does not rise with the displacement", file=record.source,
            remedy="check the columns and their signs",
        )  # fmt: skip
    away = record.displacement - (smooth - offset) / stiffness
    limit = jump if jump is not None else OFFSET * top / stiffness
    found = np.flatnonzero(away > limit)
    found = found[found >= end]
    return int(found[0]) if found.size else None
