"""One noisy laboratory each: whether the 95 % interval of every result holds the truth that made the data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from support.coverage import holds
from support.paths import CONFIGS
from wroll_fem.lab.friction.elastic_slip import fit_elastic_slip
from wroll_fem.lab.friction.rate_law import fit_rate_laws
from wroll_fem.lab.friction.state_law import fit_state_laws
from wroll_fem.lab.shear.capacity import capacity
from wroll_fem.lab.shear.events import find_event
from wroll_fem.lab.shear.fixture import Fixture
from wroll_fem.lab.shear.rates import at_constant_rates, in_sine
from wroll_fem.lab.shear.simulated import correlated, ramp, rigid, sine_loops, velocity_steps
from wroll_fem.lab.shear.stiffness import moduli, stiffness
from wroll_fem.lab.tension.pressure import WindingModel
from wroll_fem.lab.tension.trials import measure_trial, settings_of
from wroll_fem.numerics.inference import Estimate
from wroll_fem.tribology import RateAndState, ShearTest
from wroll_fem.tribology.rate_and_state import StateLaw
from wroll_fem.tribology.shear_test import modulus_of

Found = dict[str, bool]

TEST = ShearTest(interfaces=5, normal_force=200.0)
FIXTURE = 4e7


def ramps(rng: np.random.Generator) -> Found:
    """Capacity by both rules; stiffness and modulus without a measured fixture."""
    found = {}
    measured = Fixture.measured(rigid(FIXTURE, rng))
    for name, drop in (("drop", 5.0), ("jump", 0.0)):
        record = ramp(TEST, rng, drop=drop, fixture=FIXTURE)
        own = measured.corrected(record)
        level = capacity(own, find_event(own))
        assert level.rule == {"drop": "force_drop", "jump": "displacement_jump"}[name]
        found[f"capacity, {name}"] = holds(level.force, TEST.capacity)
    slope, _ = stiffness(record, level.force.value, level.onset, fixture=measured)
    found["modulus"] = holds(
        moduli(slope, TEST.area, TEST.thickness)[0], modulus_of(TEST.stiffness, TEST.area, TEST.thickness)
    )
    return found


def state(law: StateLaw) -> Callable[[np.random.Generator], Found]:
    """Constants of a law of the state, from velocity steps."""
    truth = RateAndState(law=law)

    def found(rng: np.random.Generator) -> Found:
        fits = fit_state_laws([velocity_steps(truth, rng)], skip=0.5e-3, rate=truth.rate)
        own = fits.fits[law]
        inside = {f"{law} {name}": holds(own[name], getattr(truth, name)) for name in ("mu", "a", "b", "distance")}
        inside[f"{law} a - b"] = holds(own.steady_slope, truth.a - truth.b)
        inside[f"{law} preferred"] = fits.preferred == law
        return inside

    return found


RATES = (1e-5, 1e-4, 1e-3, 8e-3)
COEFFICIENTS = (0.21, 0.23, 0.25, 0.29)
MOUNTING = 0.004
"""Standard deviation of the coefficient from mounting to mounting."""


def rate_table(rng: np.random.Generator) -> Found:
    """Table of mu(V): three mountings at each rate, each with its own coefficient, one record each."""
    points = []
    for rate, mu in zip(RATES, COEFFICIENTS, strict=True):
        for _ in range(3):
            law = RateAndState(mu=mu + MOUNTING * rng.standard_normal(), a=0.0, b=0.0, rate=rate)
            points += at_constant_rates(velocity_steps(law, rng, rates=(rate,), points=400)).points
    table = fit_rate_laws(points).fits["table"]
    assert len(table.coefficients) == 1 + len(RATES)
    pairs = zip(RATES, table.coefficients[1:], COEFFICIENTS, strict=True)
    return {f"mu at {rate:g} m/s": holds(one, mu) for rate, one, mu in pairs}


def sine(rng: np.random.Generator) -> Found:
    """Coefficient at the largest slip rates of a sine, with an offset of the force and inertia."""

    def law(speed: np.ndarray) -> np.ndarray:
        return np.asarray(0.25 + 2.0 * np.minimum(speed, 0.02))

    points = in_sine(sine_loops(law, rng, cycles=20, frequency=10.0, mass=0.5), moving_mass=0.5).points
    return {f"sine, class {k}": holds(p.coefficient, float(law(np.array(p.rate)))) for k, p in enumerate(points)}


def elastic_slip(rng: np.random.Generator) -> Found:
    """Elastic slip from two ramps at each of four preloads, with an unknown compliance in series."""
    forces, slopes, levels = [], [], []
    for force in (50.0, 100.0, 200.0, 400.0):
        for _ in range(2):
            record = ramp(replace(TEST, normal_force=force), rng, fixture=FIXTURE)
            level = capacity(record, find_event(record))
            forces.append(force)
            levels.append(level.force)
            slopes.append(stiffness(record, level.force.value, level.onset)[0])
    fitted = fit_elastic_slip(np.array(forces), slopes, levels, interfaces=TEST.interfaces)
    layers = TEST.layers * TEST.layer_thickness / (2.0 * TEST.layer_shear_modulus * TEST.area)
    return {
        "elastic slip": holds(fitted.elastic_slip, TEST.elastic_slip),
        "mu of capacities": holds(fitted.mu, TEST.mu),
        "series compliance": holds(fitted.series, layers + 1.0 / FIXTURE),
    }


@cache
def winding() -> WindingModel:
    return WindingModel(CONFIGS / "winding_lab.yaml")


def trials(rng: np.random.Generator) -> Found:
    """Mean tension and pressure of two settings with four trials each, scatter 0.8 N between and 1.5 N within."""
    time = np.arange(0.0, 30.0, 0.05)
    records = [
        measure_trial(time, level + 0.8 * rng.standard_normal() + correlated(rng, 1.5, len(time), 0.9), 6.0, current)
        for level, current in ((20.0, 0.2), (60.0, 1.0))
        for _ in range(4)
    ]
    found = {}
    for level, setting in zip((20.0, 60.0), settings_of(records), strict=True):
        found[f"tension {level:g} N"] = holds(setting.mean, level)
        exact = winding().pressures(level, fine=False)
        step = 0.01 * setting.mean.value
        near = [winding().pressures(setting.mean.value + sign * step, fine=False)[0] for sign in (1.0, -1.0)]
        slope = (near[0] - near[1]) / (2.0 * step)
        value = winding().pressures(setting.mean.value, fine=False)[0]
        pressure = Estimate(value, slope * setting.mean.error, setting.mean.freedom)
        found[f"pressure {level:g} N"] = holds(pressure, exact[0])
    return found


EXPERIMENTS: dict[str, Callable[[np.random.Generator], Found]] = {
    "ramps": ramps,
    "ageing": state("ageing"),
    "slip": state("slip"),
    "rate_table": rate_table,
    "sine": sine,
    "elastic_slip": elastic_slip,
    "trials": trials,
}
"""Name -> experiment."""


def repeated(name: str, count: int, seed: int) -> dict[str, list[bool]]:
    """Results of repetitions of an experiment."""
    rng = np.random.default_rng(seed)
    rows = [EXPERIMENTS[name](rng) for _ in range(count)]
    return {key: [row[key] for row in rows if key in row] for key in rows[0]}
