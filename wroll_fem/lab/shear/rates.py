r"""Coefficient of friction over slip rate, from tests at constant rates, velocity steps, and sines.

.. math:: \mu = \frac{F}{2 F_N}

while both stacks slide (thesis, equation E.5). At constant rates the last part of each stretch is averaged, when the
state of the surfaces has settled; under a sine, the parts of the cycle that slide, in classes of the slip rate, with
both directions averaged, so that an offset of the force cancels.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.loops import crossings
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.lab.shear.segments import FEWEST, constant_rates
from wroll_fem.numerics.inference import Estimate, fit, linear_fit, mean_estimate
from wroll_fem.typing import BoolArray, FloatArray

STEADY = 0.5
"""Last part of a stretch that is averaged."""

DRIFT = 0.02
"""Relative change of the coefficient over this part from which the stretch is called unsteady."""

SLOWEST = 0.1
"""Smallest slip rate under a sine, relative to the largest."""

CLASSES = 6
"""Classes of the slip rate under a sine."""

REACH = 1.3
"""Travel after a reversal that is left out, relative to the travel from full slip to full slip, 2 F/K."""

IMPURE = 0.05
"""Share of a displacement that departs from a sine above which the slip rates are doubtful."""


class RatePoint(NamedTuple):
    """Coefficient of friction at a slip rate (m/s), and the profile of its test."""

    rate: float
    coefficient: Estimate
    profile: str


class RatePoints(NamedTuple):
    """Points of one record, and doubts about them, one sentence each."""

    points: list[RatePoint]
    doubts: list[str]


def at_constant_rates(record: ShearRecord, *, skip: float = 0.0, steady: float = STEADY) -> RatePoints:
    """Coefficient at each constant rate of a record.

    Parameters
    ----------
    record
        Sliding record, displacement of the specimen.
    skip
        Displacement from the start that is left out, m; 0.5 mm in the thesis.
    steady
        Last part of each stretch that is averaged.

    Raises
    ------
    InputError
        If no stretch lies beyond ``skip``.
    """
    x, mu = record.displacement - record.displacement[0], record.coefficient
    parts = [part for part in constant_rates(record) if part.rate > 0.0]
    profile = "steps" if sum(x[part.stop - 1] > skip for part in parts) > 1 else "constant"
    points, doubts = [], []
    for part in parts:
        own = np.arange(part.start, part.stop)
        own = own[x[own] > max(skip, x[part.stop - 1] - steady * (x[part.stop - 1] - x[part.start]))]
        if len(own) < FEWEST:
            continue
        constant = linear_fit({"mean": np.ones(len(own))}, mu[own])["mean"]
        trend = linear_fit({"mean": np.ones(len(own)), "drift": np.linspace(-0.5, 0.5, len(own))}, mu[own])["drift"]
        if abs(trend.value) > max(DRIFT * constant.value, 3.0 * trend.error):
            doubts.append(
                f"{record.source}: at {part.rate:.3g} m/s the coefficient still changes by {trend.value:+.2g} in the "
                "averaged part; slide longer at this rate, or lower steady"
            )
        points.append(RatePoint(part.rate, constant, profile))
    if not points:
        raise InputError(
            f"no stretch of constant rate beyond the first {1e3 * skip:g} mm", file=record.source, key="skip",
            remedy="lower skip, or sample faster",
        )  # fmt: skip
    return RatePoints(points, doubts)


def in_sine(record: ShearRecord, *, moving_mass: float = 0.0) -> RatePoints:
    """Coefficient over slip rate during sinusoidal sliding.

    Parameters
    ----------
    record
        Record of several cycles, displacement of the specimen.
    moving_mass
        Mass between load cell and specimen, kg; its inertia is subtracted.

    Raises
    ------
    InputError
        If there are fewer than three cycles, or the motion is too small to slide.
    """
    ends = crossings(record.displacement)
    if len(ends) < 4:
        raise InputError(
            f"{max(0, len(ends) - 1)} complete cycles", file=record.source, remedy="record three cycles or more"
        )
    motion, speed, rate, impure = _sine(record, ends)
    mu = (record.force + moving_mass * rate**2 * motion) / (2.0 * record.known_normal_force)
    forward = speed > 0.0
    slides = _sliding(record, motion, forward)
    largest = float(np.abs(speed).max())
    edges = largest * np.geomspace(SLOWEST, 1.0 + 1e-9, CLASSES + 1)
    cycle = np.searchsorted(ends, np.arange(len(mu)), side="right")
    points = []
    for low, high in pairwise(edges):
        inside = slides & (np.abs(speed) >= low) & (np.abs(speed) < high)
        values = []
        for k in range(1, len(ends)):
            there, back = (inside & (cycle == k) & way for way in (forward, ~forward))
            if there.any() and back.any():
                values.append(0.5 * (mu[there].mean() - mu[back].mean()))
        if len(values) >= 3:
            points.append(RatePoint(float(np.abs(speed[inside]).mean()), mean_estimate(np.array(values)), "sine"))
    if not points:
        raise InputError("no part of the cycles slides", file=record.source, remedy="raise the amplitude")
    doubts = []
    if impure > IMPURE:
        doubts.append(
            f"{record.source}: {100 * impure:.0f} % of the displacement depart from a sine; the slip rates, those of "
            "the sine, are doubtful"
        )
    return RatePoints(points, doubts)


def _sine(record: ShearRecord, ends: FloatArray) -> tuple[FloatArray, FloatArray, float, float]:
    """Sine through the displacement: its values about the middle (m), slip rates (m/s), angular frequency, misfit."""
    t, x = record.time - record.time[0], record.displacement
    at = np.interp(ends[[0, -1]], np.arange(len(t)), t)
    omega, size = 2.0 * np.pi * (len(ends) - 1) / float(at[1] - at[0]), 0.5 * float(np.ptp(x))
    middle = 0.5 * float(x.max() + x.min())

    def model(p: FloatArray) -> FloatArray:
        phase = omega * p[3] * (t - at[0])
        return np.asarray(middle + size * (p[0] + p[1] * np.sin(phase) + p[2] * np.cos(phase)))

    start = {"middle": 0.0, "sine": 1.0, "cosine": 0.0, "frequency": 1.0}
    found = fit(model, x, start, scales={"middle": 0.1, "cosine": 0.1}, correlated=False)
    _, sine, cosine, factor = found.x
    phase = omega * factor * (t - at[0])
    motion = size * (sine * np.sin(phase) + cosine * np.cos(phase))
    speed = omega * factor * size * (sine * np.cos(phase) - cosine * np.sin(phase))
    return motion, speed, float(omega * factor), found.noise_level / (size * np.hypot(sine, cosine))


def _sliding(record: ShearRecord, motion: FloatArray, forward: BoolArray) -> BoolArray:
    """Samples at which the travel since the last reversal exceeds the elastic one, 2 F/K."""
    turns = np.flatnonzero(np.diff(forward.astype(int))) + 1
    bounds = [0, *turns.tolist(), len(motion)]
    middle = 0.5 * (np.quantile(record.force, 0.98) + np.quantile(record.force, 0.02))
    top = 0.5 * float(np.quantile(record.force, 0.98) - np.quantile(record.force, 0.02))
    inner = np.abs(record.force - middle) < 0.6 * top
    slopes, travel = [], np.zeros(len(motion))
    for start, stop in pairwise(bounds):
        own = np.arange(start, stop)
        travel[own] = np.abs(motion[own] - motion[start]) if start else 0.0
        early = own[inner[own]]
        if start and len(early) >= 3 and np.ptp(record.displacement[early]) > 0.0:
            slopes.append(float(np.polyfit(record.displacement[early], record.force[early], 1)[0]))
    stiffness = float(np.median(slopes)) if slopes else np.inf
    reach = REACH * 2.0 * top / stiffness if stiffness > 0.0 else np.inf
    if not reach < 0.8 * np.ptp(motion):
        raise InputError(
            f"the amplitude {0.5 * np.ptp(motion):.3g} m is too small: full slip takes {reach:.3g} m after a reversal",
            file=record.source, remedy="raise the amplitude, or evaluate the loops with wroll lab shear",
        )  # fmt: skip
    return np.asarray(travel > reach)
