"""Readings of a response curve depend on the equations, not on the steps along the curve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.exact_systems import lifting_mass, oscillator
from support.periodic import TURN, complete, small_roll

from wroll_fem.dynamics.periodic.reading_points import with_reading_points
from wroll_fem.dynamics.periodic.response import HarmonicCurve, response_curve, solve_response
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.training.enrichment import trained_response
from wroll_fem.numerics.continuation import StepControl
from wroll_fem.signals.damping import HalfPower, half_power


def solved(system: System, amplitude: float, band: tuple[float, float], control: StepControl) -> HarmonicCurve:
    model, preload = complete(system)
    return solve_response(
        model, preload, system.laws, amplitude=amplitude, frequencies=band, samples=256, control=control
    )


def reading(curve: HarmonicCurve) -> HalfPower:
    return half_power(curve.frequencies / TURN, np.abs(curve.transmissibility))


def values(found: HalfPower) -> np.ndarray:
    return np.array([found.f_n, found.f_low, found.f_high, found.peak])


@pytest.mark.parametrize("longer", [0.7, 1.0, 1.4])
@pytest.mark.parametrize("zeta", [0.003, 0.02, 0.08])
def test_readings_of_a_damped_oscillator_are_exact(zeta: float, longer: float) -> None:
    """T = 1 + w^2 / (w_n^2 - w^2 + 2 i zeta w_n w); its curve between the points of the continuation misses 1e-3."""
    plain = oscillator(10.0, 2.0)
    system = replace(plain, damping=2.0 * zeta * TURN * 10.0 * plain.mass)
    control = StepControl().longer(longer)
    curve = with_reading_points(solved(system, 1.0, (5.0, 20.0), control), control)
    f = np.linspace(5.0, 20.0, 3_000_001)
    exact = values(half_power(f, np.abs(1.0 + f**2 / (10.0**2 - f**2 + 2j * zeta * 10.0 * f))))
    np.testing.assert_allclose(values(reading(curve)), exact, rtol=5e-6)


def test_readings_of_a_roll_do_not_depend_on_the_steps() -> None:
    """Between the samples of a period all points turn at once, which leaves ripples on the curve; 512 make them small.

    The frequency of the flat top is the least certain reading.
    """
    system, preload, condensation = small_roll(8, 3)
    band = {"amplitude": 5.0, "frequencies": (140.0, 165.0)}
    contact = trained_response(condensation, preload, system.laws, **band, samples=512).curve.balance.contact
    found: dict[bool, list[np.ndarray]] = {True: [], False: []}
    for longer in (0.7, 1.0, 1.3):
        control = replace(StepControl().longer(longer), tolerance=1e-8)
        plain = response_curve(contact, **band, control=control)
        found[False].append(values(reading(plain)))
        found[True].append(values(reading(with_reading_points(plain, control))))
    spread = {key: np.ptp(rows, axis=0) / np.mean(rows, axis=0) for key, rows in found.items()}
    assert np.all(spread[True] < [3e-4, 2e-6, 5e-6, 2e-5])
    assert np.all(spread[False][[1, 3]] > 3.0 * spread[True][[1, 3]])


def test_the_points_lie_on_the_curve_and_in_its_order() -> None:
    """A curve that leans over keeps its folds; the points come between its own, in the order of the curve."""
    system, control = lifting_mass(), StepControl()
    plain = solved(system, 2.0, (14.0, 30.0), control)
    curve = with_reading_points(plain, control)
    assert 3 <= len(curve.frequencies) - len(plain.frequencies) <= 8
    assert curve.folds == plain.folds == 2
    assert np.all(np.isin(plain.frequencies, curve.frequencies))
    where = np.flatnonzero(np.isin(curve.frequencies, plain.frequencies))
    np.testing.assert_array_equal(curve.frequencies[where], plain.frequencies)
    for q, w in zip(curve.coefficients, curve.frequencies, strict=True):
        residual, _ = curve.balance.residual(q, w)
        assert np.linalg.norm(residual) < 1e-4 * np.linalg.norm(curve.balance.load())
    assert np.abs(curve.transmissibility).max() >= np.abs(plain.transmissibility).max()


def test_a_curve_without_a_peak_stays_as_it_is() -> None:
    plain = solved(oscillator(10.0, 2.0), 1.0, (2.0, 5.0), StepControl())
    curve = with_reading_points(plain, StepControl())
    np.testing.assert_array_equal(curve.frequencies, plain.frequencies)
