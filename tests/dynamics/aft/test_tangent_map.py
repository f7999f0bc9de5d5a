"""Derivatives of periodic motions as maps against their matrices, and curves that are followed with them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.sparse as sp
from support.exact_systems import slipping_pair
from support.periodic import balance, small_roll, trained_roll

from wroll_fem.dynamics.periodic.backbone import ModalMotion
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.dynamics.training.enrichment import trained_response
from wroll_fem.numerics import bordered


def test_map_of_a_symmetric_roll_is_its_matrix() -> None:
    """With the shift of the samples, harmonics in two groups, single precision, and points that slide."""
    curve = trained_roll(12, 4).curve
    problem, rng = curve.problem, np.random.default_rng(2)
    peak = int(np.abs(curve.transmissibility).argmax())
    z = problem.scaled(curve.coefficients[peak], curve.frequencies[peak])
    contact = problem.contact(z)
    assert contact.shift != 0.0
    assert contact.hysteresis.moved.any()
    assert curve.balance.contact.symmetry is not None
    matrix, applied = problem.jacobian(z).astype(float), problem.derivative(z)
    for _ in range(5):
        v = rng.standard_normal(len(z))
        expected = matrix @ v
        np.testing.assert_allclose(applied(v), expected, atol=1e-5 * np.abs(expected).max())


def test_map_of_a_nonlinear_mode_is_its_matrix() -> None:
    system = dataclasses.replace(slipping_pair(gamma=2e-4), damping=sp.csr_matrix(np.diag([3.0, 1.0, 2.0])))
    contact = balance(system, 0.0).contact
    problem = ModalMotion(HarmonicBalance(contact, 0.0), contact.model.main_mode, (1e-4, 1e-3))
    z = problem.start() + 0.02 * np.random.default_rng(2).standard_normal(len(problem.start()))
    matrix, applied = problem.jacobian(z), problem.derivative(z)
    columns = np.column_stack([applied(v) for v in np.eye(len(z))])
    np.testing.assert_allclose(columns, matrix, atol=1e-12 * np.abs(matrix).max())


def test_curve_of_a_roll_is_the_same_with_maps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its points lie elsewhere; both curves have points at the peak and at half power."""
    system, preload, condensation = small_roll(12, 4)
    peaks, widths = [], []
    monkeypatch.setattr(bordered, "UNKNOWNS_PER_ITERATION", 8)
    for fewest in (0, 10**6):
        monkeypatch.setattr(bordered, "FEWEST", fewest)
        curve = trained_response(
            condensation, preload, system.laws, amplitude=5.0, frequencies=(140.0, 165.0), tolerance=2e-4
        ).curve  # fmt: skip
        sizes = np.abs(curve.transmissibility)
        high = curve.frequencies[sizes > 0.7 * sizes.max()]
        peaks.append((curve.frequencies[sizes.argmax()], sizes.max()))
        widths.append(high.max() - high.min())
        np.testing.assert_array_equal(curve.stable, curve.tangents[:, -1] > 0.0)  # no bifurcation beside the folds
    np.testing.assert_allclose(peaks[0], peaks[1], rtol=1e-4)
    assert widths[0] == pytest.approx(widths[1], rel=0.01)
