"""Fit of the two-mass model: parameters of computed curves are recovered."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.errors import InputError
from wroll_fem.two_dof import Measured, PeriodicSolver, TwoMasses, fit_curves

OMEGA = np.linspace(0.7, 1.4, 12)
FEW = np.linspace(0.7, 1.4, 8)  # enough without noise


def curves(
    model: TwoMasses, capacities: tuple[float, ...], noise: float = 0.0, omega: np.ndarray = OMEGA
) -> list[Measured]:
    rng = np.random.default_rng(2)
    out = []
    for capacity in capacities:
        curve = PeriodicSolver(model.preloaded(capacity)).curve(omega)
        values = np.array([m.transmissibility for m in curve]) * np.exp(noise * rng.standard_normal(len(omega)))
        out.append(Measured(omega, values, capacity))
    return out


def test_mass_and_stiffness_of_the_secondary_are_found_from_afar() -> None:
    truth = TwoMasses(m2=0.6, k2=0.9)
    found = fit_curves(curves(truth, (3.0,), omega=FEW), {"m2": (0.2, 2.0), "k2": (0.2, 3.0)}, starts=2, workers=1)
    assert (found.model.m2, found.model.k2) == pytest.approx((0.6, 0.9), rel=2e-4)
    assert found.error < 1e-4
    assert found.errors[0] == found.error
    assert len(found.errors) == 2
    assert found.at_bound == ()


def test_capacities_are_found_with_noise() -> None:
    measured = curves(TwoMasses(), (2.0, 6.0), noise=0.01)
    guessed = [Measured(m.omega, m.transmissibility, 4.0) for m in measured]
    found = fit_curves(guessed, {"k2": (0.5, 3.0)}, capacity_bounds=(0.5, 50.0), starts=1, workers=1)
    assert found.capacities == pytest.approx([2.0, 6.0], rel=0.02)
    assert found.model.k2 == pytest.approx(1.15, rel=0.02)
    assert found.error == pytest.approx(0.01, rel=0.3)


def test_a_parameter_on_its_bound_is_named() -> None:
    found = fit_curves(curves(TwoMasses(m2=0.6), (3.0,), omega=FEW), {"m2": (0.8, 1.5)}, starts=1, workers=1)
    assert found.at_bound == ("m2",)
    assert found.model.m2 == pytest.approx(0.8, rel=1e-2)


def test_fits_without_a_meaning_are_refused() -> None:
    measured = [Measured(OMEGA, np.ones(len(OMEGA)), 2.0)]
    for arguments, words in (
        (([], {"m2": (0.1, 1.0)}), "there is no curve to fit"),
        ((measured, {}), "there is nothing to fit"),
        ((measured, {"m3": (0.1, 1.0)}), "unknown parameter 'm3'; use m1, k1"),
        ((measured, {"m2": (1.0, 0.1)}), "m2: bounds must be positive and increasing, got 1 and 0.1; give the lower"),
    ):
        with pytest.raises(InputError, match=words):
            fit_curves(*arguments)
    with pytest.raises(InputError, match="must be positive and finite and its frequencies must increase"):
        Measured(OMEGA, np.zeros(len(OMEGA)), 2.0)
