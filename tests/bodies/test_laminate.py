"""Laminates: stiffness against tables and closed forms, transverse shear against Pagano's cylindrical bending."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.bodies.laminate import Lamina, Laminate, Ply, laminate
from wroll_fem.bodies.wall import COLUMNS, LayeredSection, WallTable

CARBON = Lamina(181e9, 10.3e9, 0.28, 7.17e9, 7.17e9, 3.5e9, 1600.0)
"""T300/5208 of Tsai and Hahn 1980, table 1.7; their G_23 is not given."""

ALUMINIUM = Lamina.isotropic(70e9, 0.33, 2700.0)


def test_stiffness_of_a_ply_is_that_of_tsai_and_hahn() -> None:
    """Tables 2.3 and 3.5: plane-stress stiffness of T300/5208 at 0 and 45 degrees, GPa."""
    straight, turned = (CARBON.plane_stress(np.radians(angle)) / 1e9 for angle in (0, 45))
    np.testing.assert_allclose(straight[[0, 1, 0, 2], [0, 1, 1, 2]], [181.8, 10.35, 2.897, 7.17], rtol=5e-4)
    np.testing.assert_allclose(turned[[0, 1, 0, 2, 0], [0, 1, 1, 2, 2]], [56.66, 56.66, 42.32, 46.59, 42.87], rtol=5e-4)


def test_isotropic_plies_are_a_homogeneous_wall() -> None:
    t, G = 3e-3, 70e9 / 2.66
    wall = Laminate((Ply(ALUMINIUM, 1e-3), Ply(ALUMINIUM, 0.5e-3, 0.3), Ply(ALUMINIUM, 1.5e-3)))
    plane = 70e9 / (1 - 0.33**2) * np.array([[1, 0.33, 0], [0.33, 1, 0], [0, 0, 0.335]])
    np.testing.assert_allclose(wall.abd[:3, :3], plane * t, atol=1e-9 * plane[0, 0] * t)
    np.testing.assert_allclose(wall.abd[3:, 3:], plane * t**3 / 12, atol=1e-9 * plane[0, 0] * t**3)
    np.testing.assert_allclose(wall.abd[:3, 3:], 0.0, atol=1e-12 * plane[0, 0] * t**2)
    np.testing.assert_allclose(wall.transverse_shear, 5 / 6 * G * t * np.eye(2), atol=1e-9 * G * t)
    np.testing.assert_allclose(wall.mass_moments_about(0.0), [2700 * t, 0.0, 2700 * t**3 / 12], atol=1e-15)
    assert wall.is_mirrored
    assert wall.engineering_constants() == pytest.approx((70e9, 70e9, 0.33, G))


@pytest.mark.parametrize(
    ("angles", "mirrored"),
    [([0], True), ([0, 90, 90, 0], True), ([0, 90], True), ([45, -45, -45, 45], False), ([30], False)],
)
def test_couplings_of_shear_and_stretch_are_found(angles: list[float], mirrored: bool) -> None:
    assert laminate(CARBON, 1e-3, angles).is_mirrored is mirrored


def test_moduli_of_a_quasi_isotropic_wall_do_not_depend_on_the_direction() -> None:
    """[0/45/-45/90]s: moduli of the invariants U1 and U4 of the ply (Tsai and Hahn 1980, chapter 4)."""
    Q = CARBON.plane_stress()
    U1 = (3 * Q[0, 0] + 3 * Q[1, 1] + 2 * Q[0, 1] + 4 * Q[2, 2]) / 8
    U4 = (Q[0, 0] + Q[1, 1] + 6 * Q[0, 1] - 4 * Q[2, 2]) / 8
    wall = laminate(CARBON, 1e-4, [0, 45, -45, 90, 90, -45, 45, 0])
    nu = U4 / U1
    expected = ((1 - nu**2) * U1, (1 - nu**2) * U1, nu, (U1 - U4) / 2)
    assert wall.engineering_constants() == pytest.approx(expected, rel=1e-12)


def _pagano(wall: Laminate, length: float) -> float:
    """Mid-plane deflection over load, m/Pa, of a simply supported laminate in cylindrical bending, sin(pi x / length).

    Exact plane-strain elasticity by a transfer matrix through the plies (Pagano 1969): the state (u, w, tau_xz,
    sigma_z) obeys a linear differential equation in the height. Plies at 0 or 90 degrees.
    """
    from scipy.linalg import expm

    p = np.pi / length
    upper = np.eye(4)
    half = None
    total = wall.thickness
    for ply, low, high in zip(wall.plies, wall.heights, wall.heights[1:], strict=False):
        m, along = ply.material, abs(np.cos(ply.angle)) > 0.5
        # transversely isotropic about the fibre: E_3 = E_2, nu_13 = nu_12, nu_23 from G_23
        nu23 = m.E_2 / (2 * m.G_23) - 1
        S = np.array([
            [1 / m.E_1, -m.nu_12 / m.E_1, -m.nu_12 / m.E_1],
            [-m.nu_12 / m.E_1, 1 / m.E_2, -nu23 / m.E_2],
            [-m.nu_12 / m.E_1, -nu23 / m.E_2, 1 / m.E_2],
        ])  # fmt: skip
        C = np.linalg.inv(S)
        x, z, G = (0, 2, m.G_13) if along else (1, 2, m.G_23)
        cxx, cxz, czz = C[x, x], C[x, z], C[z, z]
        # u = U cos px, w = W sin px, tau = T cos px, sigma = N sin px
        A = np.array([
            [0, -p, 1 / G, 0],
            [p * cxz / czz, 0, 0, 1 / czz],
            [p**2 * (cxx - cxz**2 / czz), 0, 0, -p * cxz / czz],
            [0, 0, p, 0],
        ])  # fmt: skip
        if half is None and high >= -1e-12 * total:
            half = expm(A * -low) @ upper if low < 0 else upper
        upper = expm(A * (high - low)) @ upper
    assert half is not None
    start = np.zeros((4, 2))
    start[:2] = np.eye(2)
    end = (upper @ start)[2:]
    below = np.linalg.solve(end, [0.0, 1.0])
    return float((half @ start @ below)[1])


@pytest.mark.parametrize("angles", [[0], [0, 90, 0], [0, 90, 90, 0], [90, 0, 90, 0, 90], [0, 90]])
def test_transverse_shear_gives_the_deflection_of_exact_elasticity(angles: list[float]) -> None:
    """Cylindrical bending of a plate ten times as long as thick: first-order theory against elasticity, 2 %."""
    material = Lamina(25e9, 1e9, 0.25, 0.5e9, 0.5e9, 0.2e9 * 2, 1.0)
    wall = laminate(material, 1e-2 / len(angles), angles)
    length = 0.1
    p = np.pi / length
    A, B, D = wall.abd[0, 0], wall.abd[0, 3], wall.abd[3, 3]
    theory = 1 / ((D - B**2 / A) * p**4) + 1 / (wall.transverse_shear[0, 0] * p**2)
    constant = 5 / 6 * sum(0.5e9 if angle == 0 else 0.4e9 for angle in angles) * 1e-2 / len(angles)
    exact = _pagano(wall, length)
    assert theory == pytest.approx(exact, rel=0.02)
    if len(angles) > 1:  # with the factor 5/6 of a homogeneous plate the error is larger
        naive = 1 / ((D - B**2 / A) * p**4) + 1 / (constant * p**2)
        assert abs(naive / exact - 1) > abs(theory / exact - 1)


def test_stresses_of_plies_are_those_of_stretching_and_bending() -> None:
    wall = laminate(CARBON, 0.5e-3, [0, 90])
    free = np.linalg.solve(wall.abd, [1000.0, 0, 0, 0, 0, 0])
    stress = wall.ply_stresses(free)
    assert stress.shape == (2, 2, 3)
    forces = 0.5e-3 * stress.mean(axis=1)  # linear in each ply
    np.testing.assert_allclose(
        forces[0, 0] + forces[1, 1], 1000.0, rtol=1e-12
    )  # along z: 1 of the first, 2 of the other
    np.testing.assert_allclose(forces[0, 1] + forces[1, 0], 0.0, atol=1e-9)
    turned = laminate(CARBON, 1e-3, [30])
    pure = turned.ply_stresses(np.linalg.solve(turned.abd, [1000.0, 0, 0, 0, 0, 0]))[0, 0]
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    np.testing.assert_allclose(pure, 1e6 * np.array([c * c, s * s, -c * s]), rtol=1e-10)


def test_a_wall_table_keeps_the_outer_surface_and_the_mass() -> None:
    radius, nominal = 0.04, 2e-3
    section = LayeredSection((Ply(ALUMINIUM, nominal),), radius, WallTable((0.1, 0.2), (1e-3, 3e-3)))
    heights = np.array([0.0, 0.1, 0.15, 0.2, 0.3])
    np.testing.assert_allclose(section.thickness_at(heights), [1e-3, 1e-3, 2e-3, 3e-3, 3e-3])
    columns = section.coefficients(heights)
    mass = 2 * np.pi * radius * columns[:, COLUMNS["mass"].start]
    outer = radius + 0.5 * nominal
    inner = outer - section.thickness_at(heights)
    np.testing.assert_allclose(mass, 2700 * np.pi * (outer**2 - inner**2), rtol=1e-12)
    shift = columns[:, COLUMNS["shift"]].reshape(-1, 3, 3)
    np.testing.assert_allclose(shift[2], 0.0, atol=1e-15)
    np.testing.assert_allclose(shift[:, 0, 0], 0.5 * (nominal - section.thickness_at(heights)), atol=1e-7)
