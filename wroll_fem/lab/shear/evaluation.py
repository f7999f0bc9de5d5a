"""Evaluation of one record of a shear test by its profile."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.capacity import Capacity, capacity
from wroll_fem.lab.shear.events import find_event
from wroll_fem.lab.shear.fixture import Fixture
from wroll_fem.lab.shear.loops import Loops, loops
from wroll_fem.lab.shear.rates import RatePoint, at_constant_rates, in_sine
from wroll_fem.lab.shear.reading import Read
from wroll_fem.lab.shear.settings import ShearRecordSettings
from wroll_fem.lab.shear.stiffness import stiffness
from wroll_fem.numerics.inference import Estimate


@dataclass(frozen=True)
class Measured:
    """Results of one record; those that its profile does not give are None or empty.

    Attributes
    ----------
    read
        Record and profile.
    capacity
        Shear capacity of a ramp.
    stiffness
        Shear stiffness K of both stacks in a ramp, N/m.
    loops
        Hysteresis loops.
    points
        Coefficient over slip rate.
    doubts
        Doubts, one sentence each.
    """

    read: Read
    capacity: Capacity | None = None
    stiffness: Estimate | None = None
    loops: Loops | None = None
    points: list[RatePoint] = field(default_factory=list)
    doubts: tuple[str, ...] = ()

    @property
    def loop_means(self) -> tuple[Estimate, Estimate, Estimate] | None:
        """Means of energy, J, displacement, m, and force, N, over the loops (amplitudes); None if there are none."""
        return None if self.loops is None else self.loops.means


def measured(read: Read, fixture: Fixture | None, settings: ShearRecordSettings) -> Measured:
    """Evaluate a record.

    Raises
    ------
    InputError
        If the record has not what its profile promises.
    """
    if read.profile == "ramp":
        return _ramp(read, fixture, settings)
    return _loops(read, settings) if read.profile == "loops" else _sliding(read, settings)


def _ramp(read: Read, fixture: Fixture | None, settings: ShearRecordSettings) -> Measured:
    low, high = settings.window
    if not 0.0 <= low < high <= 1.0:
        raise InputError(f"[{low:g}, {high:g}] is no window", key="window", remedy="give two fractions, rising, 0 to 1")
    record, source = read.record, read.record.source
    rule = settings.event_rule
    found = None
    if rule == "none":
        top, stop = float(record.smooth_force.max()), len(record.time)
    else:
        event = find_event(read.specimen, rule=rule, drop=settings.event_drop, jump=settings.event_jump)
        found = capacity(read.specimen, event)
        top, stop = found.force.value, found.onset
    slope, curved = stiffness(record, top, stop, window=(low, high), fixture=fixture)
    doubts = [f"{source}: {text}" for text in (found.doubts if found is not None else ())]
    if curved:
        doubts.append(f"{source}: the force over displacement is curved within window; the interval may be too narrow")
    return Measured(read, found, slope, doubts=tuple(doubts))


def _loops(read: Read, settings: ShearRecordSettings) -> Measured:
    found = loops(read.specimen)
    skip = settings.skip_cycles
    count = len(found.energy)
    if count <= skip:
        raise InputError(
            f"{count} complete cycles, of which skip_cycles leaves out {skip}", file=read.record.source,
            key="skip_cycles", remedy="record more cycles, or lower it",
        )  # fmt: skip
    kept = found.after(skip)
    doubts = [f"{read.record.source}: {text}" for text in found.doubts]
    points: list[RatePoint] = []
    if not np.isnan(read.record.normal_force):
        own = read.specimen.part(int(kept.start[0]), int(kept.stop[-1]))
        try:
            slides = in_sine(own, moving_mass=settings.moving_mass)
        except InputError as error:  # loops without full slip have an energy, but no coefficient
            doubts.append(f"{read.record.source}: no coefficient over slip rate: {error.problem}")
        else:
            points, doubts = slides.points, [*doubts, *slides.doubts]
    return Measured(read, loops=kept, points=points, doubts=tuple(doubts))


def _sliding(read: Read, settings: ShearRecordSettings) -> Measured:
    found = at_constant_rates(read.specimen, skip=settings.skip, steady=settings.steady)
    return Measured(read, points=found.points, doubts=tuple(found.doubts))
