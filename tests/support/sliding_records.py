"""Sliding records with known truth: velocity steps and sines under the program's own friction laws, seeded noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from support.shear_records import correlated

from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.tribology import RateAndState, shear_history
from wroll_fem.typing import FloatArray

NORMAL_FORCE = 200.0


def steps(
    law: RateAndState, rng: np.random.Generator | None = None, *, rates: Sequence[float] = (1e-6, 1e-5) * 3,
    every: float = 0.5e-3, points: int = 300, noise: float = 0.3, length_noise: float = 1e-8,
) -> ShearRecord:  # fmt: skip
    """Velocity steps: each rate (m/s) over the distance ``every`` (m), with equal numbers of samples per stretch."""
    speeds = np.repeat(np.asarray(rates, dtype=float), points)
    data = shear_history(law, speeds, every / points / speeds)
    force = 2.0 * NORMAL_FORCE * data["friction_coefficient"].values
    slip = data["slip_distance"].values
    if rng is not None:
        force = force + correlated(rng, noise, len(force))
        slip = slip + length_noise * rng.standard_normal(len(slip))
    return ShearRecord(data["time"].values, slip, force, NORMAL_FORCE)


def sine(
    coefficient: Callable[[FloatArray], FloatArray], rng: np.random.Generator | None = None, *, amplitude: float = 1e-4,
    frequency: float = 5.0, cycles: int = 8, points: int = 400, elastic_slip: float = 2e-6, noise: float = 0.5,
    offset: float = 3.0, mass: float = 0.0,
) -> ShearRecord:  # fmt: skip
    """Sine of the displacement with the law rate_coulomb of the finite-element model in one point."""
    time = np.arange(cycles * points + 1) / (points * frequency)
    omega = 2.0 * np.pi * frequency
    x = amplitude * np.sin(omega * time)
    speed = amplitude * omega * np.cos(omega * time)
    mu, at_rest = coefficient(np.abs(speed)), float(coefficient(np.zeros(1))[0])
    elastic = np.zeros(len(x))
    for k in range(1, len(x)):
        radius = elastic_slip * mu[k] / at_rest
        elastic[k] = np.clip(elastic[k - 1] + x[k] - x[k - 1], -radius, radius)
    force = 2.0 * NORMAL_FORCE * at_rest * elastic / elastic_slip + offset - mass * omega**2 * x
    if rng is not None:
        force = force + correlated(rng, noise, len(force))
        x = x + 1e-8 * rng.standard_normal(len(x))
    return ShearRecord(time, x, force, NORMAL_FORCE)
