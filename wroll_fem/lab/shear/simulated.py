"""Simulated records with known truth: the program's own shear test and friction laws, sampled, with seeded noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from scipy.signal import lfilter

from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.tribology import RateAndState, ShearTest, run_shear_test, shear_history
from wroll_fem.typing import FloatArray

PULL = 1.5
"""Largest displacement of the actuator in a ramp, relative to the onset of slip."""

STEPS = 45
"""Steps of the simulated ramp: the onset of slip is step 30, and the curve is straight between the steps."""


def correlated(rng: np.random.Generator, size: float, count: int, phi: float = 0.6) -> FloatArray:
    """Noise (count,) of standard deviation ``size``, with the correlation ``phi`` from sample to sample."""
    driving = size * np.sqrt(1.0 - phi**2) * rng.standard_normal(count + 100)
    return np.asarray(lfilter([1.0], [1.0, -phi], driving))[100:]


@lru_cache(maxsize=64)
def _curve(test: ShearTest) -> tuple[FloatArray, FloatArray]:
    data = run_shear_test(test, steps=STEPS, travel=PULL)
    return data["platen_displacement"].values, data["shear_force"].values


def ramp(
    test: ShearTest, rng: np.random.Generator | None = None, *, count: int = 900, drop: float = 0.0,
    force_noise: float = 0.3, length_noise: float = 2e-8, duration: float = 60.0, fixture: float = np.inf,
) -> ShearRecord:  # fmt: skip
    """Loading of a shear test beyond its onset of slip.

    Parameters
    ----------
    test
        Test.
    rng
        Generator of the noise; None for none.
    count
        Number of samples.
    drop
        Force by which the sliding friction is lower, N.
    force_noise, length_noise
        Standard deviations of the noise of force, N (correlated), and displacement, m.
    duration
        s.
    fixture
        Stiffness of the fixture between the measured displacement and the stacks, N/m.
    """
    x, force = _curve(test)
    at, steps = np.linspace(0.0, STEPS, count), np.arange(STEPS + 1)
    platen, measured = np.interp(at, steps, x), np.interp(at, steps, force)
    measured = measured - drop * (at > STEPS / PULL)
    platen = platen + measured / fixture
    if rng is not None:
        measured = measured + correlated(rng, force_noise, count)
        platen = platen + length_noise * rng.standard_normal(count)
    return ShearRecord(np.linspace(0.0, duration, count), platen, measured, test.normal_force)


def rigid(
    stiffness: float, rng: np.random.Generator | None = None, *, span: tuple[float, float] = (-150.0, 250.0),
    count: int = 600, force_noise: float = 0.3, length_noise: float = 2e-8,
) -> ShearRecord:  # fmt: skip
    """Loading of a rigid specimen: the fixture of a stiffness (N/m) alone, over a span of forces (N)."""
    force = np.linspace(*span, count)
    x = force / stiffness
    if rng is not None:
        force = force + correlated(rng, force_noise, count)
        x = x + length_noise * rng.standard_normal(count)
    return ShearRecord(np.linspace(0.0, 60.0, count), x, force)


def velocity_steps(
    law: RateAndState, rng: np.random.Generator | None = None, *, rates: Sequence[float] = (1e-6, 1e-5) * 3,
    every: float = 0.5e-3, points: int = 300, noise: float = 0.3, length_noise: float = 1e-8,
    normal_force: float = 200.0, fixture: float = np.inf,
) -> ShearRecord:  # fmt: skip
    """Velocity steps: each rate (m/s) over the distance ``every`` (m), with ``points`` samples per stretch.

    The slip has these rates; a ``fixture`` (N/m) adds its own displacement.
    """
    speeds = np.repeat(np.asarray(rates, dtype=float), points)
    data = shear_history(law, speeds, every / points / speeds)
    force = 2.0 * normal_force * data["friction_coefficient"].values
    slip = data["slip_distance"].values + force / fixture
    if rng is not None:
        force = force + correlated(rng, noise, len(force))
        slip = slip + length_noise * rng.standard_normal(len(slip))
    return ShearRecord(data["time"].values, slip, force, normal_force)


def sine_loops(
    coefficient: Callable[[FloatArray], FloatArray], rng: np.random.Generator | None = None, *, amplitude: float = 1e-4,
    frequency: float = 5.0, cycles: int = 8, points: int = 400, elastic_slip: float = 2e-6, noise: float = 0.5,
    offset: float = 3.0, mass: float = 0.0, normal_force: float = 200.0, fixture: float = np.inf,
) -> ShearRecord:  # fmt: skip
    """Loops of a sinusoidal displacement under the law `rate_coulomb` of the finite-element model, in one point.

    Parameters
    ----------
    coefficient
        Coefficient of friction over slip rate (m/s).
    rng
        Generator of the noise; None for none.
    amplitude, frequency
        Displacement, m, 0-peak; Hz.
    cycles, points
        Number of cycles, and of samples per cycle.
    elastic_slip
        gamma* at rest, m.
    noise
        Standard deviation of the force noise, N; that of the displacement is 0.01 um.
    offset
        Offset of the force, N.
    mass
        Mass that moves with the displacement, kg; the force contains its inertia.
    normal_force
        Normal force of one piston, N.
    fixture
        Stiffness of the fixture between the measured displacement and the specimen, N/m.
    """
    time = np.arange(cycles * points + 1) / (points * frequency)
    omega = 2.0 * np.pi * frequency
    x = amplitude * np.sin(omega * time)
    speed = amplitude * omega * np.cos(omega * time)
    mu, at_rest = coefficient(np.abs(speed)), float(coefficient(np.zeros(1))[0])
    values, step, radius = [0.0], np.diff(x).tolist(), (elastic_slip * mu / at_rest).tolist()
    for k, length in enumerate(step, start=1):
        values.append(max(-radius[k], min(radius[k], values[-1] + length)))
    elastic = np.array(values)
    force = 2.0 * normal_force * at_rest * elastic / elastic_slip + offset - mass * omega**2 * x
    x = x + force / fixture
    if rng is not None:
        force = force + correlated(rng, noise, len(force))
        x = x + 1e-8 * rng.standard_normal(len(x))
    return ShearRecord(time, x, force, normal_force)
