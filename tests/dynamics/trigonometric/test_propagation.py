"""Exact propagation of damped modes against matrix exponentials, closed forms and quadrature."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la

from wroll_fem.dynamics.trigonometric.propagation import (
    IMPLICIT,
    INSIDE,
    NODES,
    OUTPUTS,
    RESOLVED,
    WEIGHTS,
    force_answer,
    phi_functions,
    propagation,
)

DT = 1e-3


@pytest.mark.parametrize("size", [0.0, 1e-6, 0.3, 30.0, 3000.0])
def test_phi_functions_are_those_of_the_exponential(size: float) -> None:
    """A large A: exp(A), and phi_k(A) A = phi_{k-1}(A) - I/(k-1)!; seed 3."""
    rng = np.random.default_rng(3)
    skew = rng.standard_normal((4, 4))
    matrix = size * (skew - skew.T - 0.01 * np.eye(4))
    phi = phi_functions(matrix[None], 5)
    np.testing.assert_allclose(phi[0][0], la.expm(matrix), atol=1e-12 * max(size, 1.0))
    factorial = 1.0
    for k in range(1, 6):
        right = phi[k - 1][0] - np.eye(4) / factorial
        np.testing.assert_allclose(phi[k][0] @ matrix, right, atol=1e-12 * max(size, 1.0))
        factorial *= k


def test_a_stiff_matrix_beside_it_changes_no_digit() -> None:
    """Each matrix is doubled as often as its own norm asks for: a doubling doubles the rounding error."""
    soft, stiff = np.array([[0.0, 0.3], [-0.3, -0.01]]), np.array([[0.0, 3000.0], [-3000.0, -30.0]])
    together, alone = (
        phi_functions(np.array([soft, stiff]), 5),
        (phi_functions(soft[None], 5), phi_functions(stiff[None], 5)),
    )
    for k in range(6):
        np.testing.assert_array_equal(together[k], np.concatenate([alone[0][k], alone[1][k]]))
    np.testing.assert_allclose(together[0][0], la.expm(soft), rtol=1e-14)


def test_free_motion_is_exact_for_any_damping() -> None:
    """No stiffness, light, critical and strong damping, and modes of 1.6 and 32 cycles per step."""
    values = np.array([0.0, 1e4, 1e4, 1e4, 1e8, 4e10])
    rates = np.array([0.0, 2.0, 200.0, 2e3, 100.0, 10.0])
    steps = propagation(values, [rates], np.zeros(6), DT)
    for i, (value, rate) in enumerate(zip(values, rates, strict=True)):
        right = la.expm(DT * np.array([[0.0, 1.0], [-value, -rate]]))
        found = steps.state.reshape(6, OUTPUTS, 4)[i, :2, :2]
        np.testing.assert_allclose(found, right, atol=1e-11 * np.abs(right).max())


def test_coupled_modes_are_those_of_their_coordinates() -> None:
    """Two modes turned by an angle: the coupled damping matrix gives the turned motion; forces and base too."""
    damping = np.array([[8.0, 5.0], [5.0, 30.0]])
    values, base = np.array([4e4, 9e5]), np.array([1.0, -0.4])
    steps = propagation(values, [damping], base, DT)
    system = np.zeros((4, 4))
    system[:2, 2:] = np.eye(2)
    system[2:, :2], system[2:, 2:] = -np.diag(values), -damping
    np.testing.assert_allclose(steps.state.reshape(OUTPUTS * 2, 8)[:4, :4], la.expm(DT * system), rtol=1e-10, atol=1e-9)
    # constant force f: static answer minus its free motion; ends and base together
    force = np.array([2.0, 3.0])
    rest = np.concatenate([force / values, np.zeros(2)])
    right = rest - la.expm(DT * system) @ rest
    found = steps.state.reshape(OUTPUTS * 2, 8)[:4, 4:] @ np.tile(force / steps.gain, 2)
    np.testing.assert_allclose(found, right, rtol=1e-9, atol=1e-13)
    np.testing.assert_allclose(
        steps.base[:2].sum(axis=2).ravel(),
        -(steps.state.reshape(OUTPUTS * 2, 8)[:4, 4:] @ np.tile(base / steps.gain, 2)),
        rtol=1e-10,
    )


def test_velocities_inside_and_the_mean_belong_to_the_same_motion() -> None:
    """Mean of d by a fine quadrature, and v at Lobatto's nodes, with linear force and quartic base; seed 5."""
    rng = np.random.default_rng(5)
    value, rate = 6e5, 40.0
    steps = propagation(np.array([value]), [np.array([rate])], np.array([1.3]), DT)
    start, forces, nodes = rng.standard_normal(2), rng.standard_normal(2), rng.standard_normal(len(NODES))
    found = steps.state.reshape(OUTPUTS, 4) @ [*start, *forces / steps.gain] + steps.base[:, 0] @ nodes
    poly = np.polyfit(NODES, nodes, len(NODES) - 1)
    from scipy.integrate import solve_ivp

    def rates(t: float, y: np.ndarray) -> list[float]:
        load = forces[0] + (forces[1] - forces[0]) * t / DT - 1.3 * np.polyval(poly, t / DT)
        return [y[1], load - rate * y[1] - value * y[0], y[0]]

    right = solve_ivp(rates, (0.0, DT), [*start, 0.0], t_eval=DT * NODES, rtol=1e-12, atol=1e-14).y
    assert found[0] == pytest.approx(right[0, -1], rel=1e-9)
    assert found[1] == pytest.approx(right[1, -1], rel=1e-9)
    assert found[2] == pytest.approx(right[2, -1] / DT, rel=1e-9)
    np.testing.assert_allclose(found[3:], right[1, 1 : 1 + INSIDE], rtol=1e-9)
    assert pytest.approx(1.0 / 8.0, rel=1e-14) == WEIGHTS @ NODES**7


def test_the_implicit_part_is_the_filter_of_the_page() -> None:
    """Gautschi's filter for resolved modes, the implicit midpoint rule for the others."""
    angles = np.array([0.003, 0.2, 0.99, 1.01, 50.0])
    values = (angles / DT) ** 2
    found = np.ravel(force_answer(propagation(values, [], np.zeros(5), DT))) * values
    half = np.sinc(0.5 * angles / np.pi)
    mobile = (IMPLICIT * angles) ** 2
    right = np.where(angles < RESOLVED, 1.0 - half**2, mobile / (1.0 + mobile))
    np.testing.assert_allclose(found, right, atol=1e-11)
    coupled = force_answer(propagation(values, [np.zeros((5, 5))], np.zeros(5), DT))[0]
    np.testing.assert_allclose(np.diag(coupled) * values, right, atol=1e-11)
