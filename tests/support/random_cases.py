"""Cases of analysis random: a linear oscillator, and one with a friction joint."""

from __future__ import annotations

from math import pi

import numpy as np

import wroll_fem as wf

PSD = {"frequency": [5.0, 40.0], "g2_per_hz": [0.001, 0.001]}
STEPS = 40
"""Steps per cycle of 40 Hz: 80 per cycle of the resonance."""

MASS, SPRING, DASHPOT = 1.0, 1.0e4, 4.0
STIFFNESS, LIMIT = 5.0e3, 4.0
"""Mass kg, spring N/m and dashpot N s/m of the friction oscillator; stiffness N/m and limit N of its joint."""


def linear_case(f_n: float, zeta: float, **motion: object) -> wf.Case:
    """Mass on a spring and a dashpot; half of the spring is a joint that never slips."""
    omega = 2.0 * pi * f_n
    stiffness = np.array([[0.5 * omega**2]])
    stuck = wf.joints.Jenkins(at=0, stiffness=0.5 * omega**2, limit=1.0e6)
    made = wf.structure(stiffness, np.eye(1), [stuck], damping=np.array([[2.0 * zeta * omega]]))
    return of(made, **motion)


def rubbing_case(limit: float = LIMIT, **motion: object) -> wf.Case:
    joint = wf.joints.Jenkins(at=0, stiffness=STIFFNESS, limit=limit)
    return of(wf.structure(SPRING * np.eye(1), MASS * np.eye(1), [joint], damping=DASHPOT * np.eye(1)), **motion)


def of(made: wf.OwnStructure, **motion: object) -> wf.Case:
    excitation = wf.Random(**({"psd": PSD, "duration": 60.0, "seed": 1} | motion))
    return made.case("random", excitation=excitation, integrator=wf.Integrator(steps_per_cycle=STEPS))
