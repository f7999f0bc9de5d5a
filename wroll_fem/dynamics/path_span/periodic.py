"""Periodic motions of harmonic balance as motions in the modes of a path."""

from __future__ import annotations

import numpy as np

from wroll_fem.dynamics.path_span.span import ModalMotion
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.typing import FloatArray


def periodic_motion(
    balance: HarmonicBalance, coefficients: FloatArray, frequency: float, damping: float = 0.0
) -> ModalMotion:
    """Fourier coefficients of a periodic motion (R, m) at ``frequency``, rad/s, in the modes of its structure.

    ``damping`` is the damping ratio of a nonlinear mode, whose negative damping counts as an acceleration here.
    """
    contact, vectors = balance.contact, balance.model.vectors
    state = contact.evaluate(contact.motion(coefficients), frequency)
    displacement, velocity = vectors @ coefficients.T, vectors @ balance.velocity(coefficients, frequency).T
    acceleration = -displacement * (balance.orders * frequency) ** 2 - 2.0 * damping * frequency * velocity
    base = np.zeros(len(balance.orders))
    base[1] = balance.acceleration
    return ModalMotion(displacement, velocity, acceleration, contact.spread(state.coefficients), base)
