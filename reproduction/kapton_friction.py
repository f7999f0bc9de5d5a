"""Claims on the friction between Kapton films: C122 to C124, C126 (appendix E.4)."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.verdict import EXPERIMENT, THESIS_ERROR, Verdict
from wroll_fem.plotting.lab import plot_velocity_steps
from wroll_fem.tribology import RateAndState, VelocitySteps, shear_history
from wroll_fem.tribology.rate_and_state import LAWS

STEPS = VelocitySteps(1.0e-6, 1.0e-5)
"""Velocity steps of the thesis: 1 and 10 um/s, changed every 0.5 mm, up to 3 mm."""
CONSTANTS = RateAndState()
"""Assumed friction law, since the thesis states no parameters: mu_R of the lab roll, a and b typical of rock."""


def c122(evidence: Evidence) -> Verdict:
    steady, jump, vanishes = 0.0, 0.0, 0.0
    for law, (low, high) in product(LAWS, ((1e-7, 1e-6), (1e-6, 1e-5), (1e-5, 1e-4))):
        # read where the state has been renewed 25 times at each rate, and right after a change
        model = replace(CONSTANTS, law=law)
        rates, durations = VelocitySteps(low, high).history(points=50)
        data = shear_history(model, rates, durations)
        found = data["friction_coefficient"].values
        ends = np.flatnonzero(np.diff(rates) != 0.0)
        steady = max(steady, float(np.abs(found[ends] - model.steady_coefficient(rates[ends])).max()))
        states = data["state_variable"].values[ends]
        jumps = model.coefficient(rates[ends + 1], states) - model.coefficient(rates[ends], states)
        jump = max(jump, float(np.abs(jumps - model.a * np.log(rates[ends + 1] / rates[ends])).max()))
        third = model.b * np.log(model.rate * model.steady_state(np.array([low, high])) / model.distance)
        vanishes = max(vanishes, float(np.abs(third).max()))
    holds = steady < 1e-8 and jump < 1e-8
    value = (
        f"both laws, 0.1 to 100 um/s: steady mu = mu_R + (a - b) ln(V/V_R) to {steady:.0e}, jump a ln(V2/V1) to "
        f"{jump:.0e}; the state term is -b ln(V/V_R) at steady sliding, up to {vanishes:.3f}, and vanishes at V_R "
        f"alone (mu_R = {CONSTANTS.mu:g}, a = {CONSTANTS.a:g}, b = {CONSTANTS.b:g}, V_R = "
        f"{1e6 * CONSTANTS.rate:g} um/s, D_R = {1e6 * CONSTANTS.distance:g} um)"
    )
    return Verdict(value, holds, THESIS_ERROR if holds else "")


def c123(evidence: Evidence) -> Verdict:
    friction = evidence.roll("lab_sweep").friction
    value = f"default mu = {friction.mu:g}; a table of mu over the slip rate can be given (C125)"
    return Verdict(value, friction.mu == 0.25, EXPERIMENT)


def c124(evidence: Evidence) -> Verdict:
    speed = 2.0 * np.pi * 140.0 * 0.02e-3
    value = f"2 pi x 140 Hz x 0.02 mm = {1e3 * speed:.1f} mm/s (0-peak)"
    return Verdict(value, abs(speed / 17.6e-3 - 1.0) < 1e-3)


def c126(evidence: Evidence) -> Verdict:
    value = "8 mm/s (E.2, and the tests of Fig E.19 end there); E.4's 'approximately 8 m/s' is a misprint"
    return Verdict(value, True, THESIS_ERROR)


def plot(evidence: Evidence) -> Axes:
    """Draw Fig. E.15."""
    a, b = CONSTANTS.a, CONSTANTS.b
    cases = {"a and b": (a, b), "b = 0: direct effect alone": (a, 0.0), "a = 0: state alone": (0.0, b)}
    rates, durations = STEPS.history(points=400)
    found = {}
    for words, (one, other) in cases.items():
        for law in LAWS if other > 0.0 else LAWS[:1]:
            name = f"{words}, {law} law" if other > 0.0 else words
            found[name] = shear_history(replace(CONSTANTS, a=one, b=other, law=law), rates, durations)
    found["a = b = 0: Coulomb"] = shear_history(replace(CONSTANTS, a=0.0, b=0.0), rates, durations)
    return plot_velocity_steps(found)


GROUP = ClaimGroup(
    {"C122": c122, "C123": c123, "C124": c124, "C126": c126},
    figures={
        "rate_and_state": (
            "Fig E.15: rate-and-state friction under velocity steps, constants set to zero in turn",
            plot,
        )
    },
)
