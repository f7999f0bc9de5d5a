"""Sprung Timoshenko beam against the characteristic equations of Euler-Bernoulli beams."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from wroll_fem.bodies.beam_modes import SprungBeam
from wroll_fem.bodies.rigid_ends import rigid_mass, spring_matrix

LENGTH, BENDING, MASS = 0.8, 50.0, 0.4
STIFF = 1e12
"""Shear stiffness, N, of a beam without shear."""


def plain(**changes: object) -> SprungBeam:
    return SprungBeam(LENGTH, BENDING, STIFF, MASS, **changes)  # type: ignore[arg-type]


def hertz(beta_l: float) -> float:
    return float((beta_l / LENGTH) ** 2 * np.sqrt(BENDING / MASS) / (2.0 * np.pi))


def roots(function: Callable[[float], float], count: int) -> list[float]:
    x = np.linspace(0.05, 4.0 * count + 2.0, 4000)
    values = [function(v) for v in x]
    signs = [k for k in range(len(x) - 1) if values[k] * values[k + 1] < 0.0]
    return [hertz(float(brentq(function, x[k], x[k + 1]))) for k in signs[:count]]


def determinant(beta_l: float, base: tuple[float, float], tip: np.ndarray) -> float:
    """Determinant of the end conditions: springs at the base, and at the tip a dynamic stiffness (2, 2)."""
    b = beta_l / LENGTH
    w2 = b**4 * BENDING / MASS

    def derivatives(z: float) -> np.ndarray:
        """(4, 4) value to third derivative of cos, sin, cosh, sinh of b z."""
        c, s, ch, sh = np.cos(b * z), np.sin(b * z), np.cosh(b * z), np.sinh(b * z)
        return np.array(
            [[c, s, ch, sh], [-b * s, b * c, b * sh, b * ch], [-(b**2) * c, -(b**2) * s, b**2 * ch, b**2 * sh],
             [b**3 * s, -(b**3) * c, b**3 * sh, b**3 * ch]]
        )  # fmt: skip

    foot, head = derivatives(0.0), derivatives(LENGTH)
    stiff = tip[0] - w2 * tip[1]
    rows = np.array(
        [
            BENDING * foot[3] + base[0] * foot[0], BENDING * foot[2] - base[1] * foot[1],
            BENDING * head[3] - stiff[0, 0] * head[0] - stiff[0, 1] * head[1],
            BENDING * head[2] + stiff[1, 0] * head[0] + stiff[1, 1] * head[1],
        ]
    )  # fmt: skip
    return float(np.linalg.det(rows / np.abs(rows).max(axis=1, keepdims=True)))


PLANE = np.ix_([0, 4], [0, 4])


@pytest.mark.parametrize(
    ("base", "springs", "body"),
    [
        ((2e3, 30.0), (0, 0), (0.0, 0.0, 0.0)), ((500.0, 5.0), (800.0, 0.0), (0.05, 0.0, 0.0)),
        ((1e5, 100.0), (0.0, 3.0), (0.2, 1e-3, 0.03)), ((3e3, 40.0), (2e3, 10.0), (0.4, 5e-3, -0.05)),
    ],
)  # fmt: skip
def test_springs_and_a_rigid_body_follow_the_characteristic_equation(
    base: tuple[float, float], springs: tuple[float, float], body: tuple[float, float, float]
) -> None:
    mass, inertia, offset = body
    tip_mass = rigid_mass(mass, inertia, 0.0, offset)[PLANE]
    tip_stiffness = spring_matrix((springs[0], springs[0], 0.0, springs[1], springs[1], 0.0))[PLANE]
    beam = plain(base=base, tip_stiffness=tip_stiffness, tip_mass=tip_mass)
    exact = roots(lambda x: determinant(x, base, np.array([tip_stiffness, tip_mass])), 3)
    np.testing.assert_allclose(beam.frequencies(3), exact, rtol=1e-4)


@pytest.mark.parametrize(
    ("base", "exact"),
    [
        ((None, None), [1.875104, 4.694091, 7.854757]), ((1e9, 1e9), [1.875104, 4.694091, 7.854757]),
        ((None, 0.0), [0.0, 3.926602, 7.068583]), ((0.0, 0.0), [0.0, 0.0, 4.730041]),
    ],
    ids=["held", "stiff", "pinned", "free"],
)  # fmt: skip
def test_limits_are_clamped_pinned_and_free(base: tuple[float | None, float | None], exact: list[float]) -> None:
    np.testing.assert_allclose(plain(base=base).frequencies(3), [hertz(x) for x in exact], rtol=1e-4, atol=0.02)


def test_shear_and_rotary_inertia_lower_the_frequencies_as_timoshenko_says() -> None:
    """Pinned at both ends: k^2 = quadratic in w^2 of the n-th sine (Timoshenko 1922)."""
    shear, rotary = 2e4, 1e-4
    held = spring_matrix((1e10,) * 3 + (0.0,) * 3)[PLANE]
    beam = SprungBeam(LENGTH, BENDING, shear, MASS, rotary, base=(None, 0.0), tip_stiffness=held)
    for n, found in enumerate(beam.frequencies(2), start=1):
        k = n * np.pi / LENGTH
        a, b, c = MASS * rotary / shear, -(MASS + k**2 * (rotary + MASS * BENDING / shear)), BENDING * k**4
        w2 = (-b - np.sqrt(b * b - 4 * a * c)) / (2 * a)
        assert found == pytest.approx(np.sqrt(w2) / (2 * np.pi), rel=1.5e-3)
