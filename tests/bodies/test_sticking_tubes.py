"""Concentric tubes that stick on each other by springs: limits, and the compliance of two tubes by their equations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from wroll_fem.bodies.beam_modes import SprungBeam
from wroll_fem.bodies.sticking_tubes import StickingTube, lowest_frequency
from wroll_fem.typing import FloatArray

LENGTH, RADIUS = 0.3, 0.04
BENDING, SHEAR, MASS = 900.0, 2.0e5, 0.5  # N m^2, N, kg/m
TIP = np.diag([0.2, 0.0])
MESH = 2e-3
"""Error of the two-node elements."""


def tube(share: float = 1.0, *, base: float | None = None, mass: float = MASS, radius: float = RADIUS) -> StickingTube:
    return StickingTube(radius, share * BENDING, share * SHEAR, share * mass, (0.0, LENGTH), base)


def test_tubes_that_stick_fully_are_one_beam() -> None:
    """Same radius: springs without limit leave one tilt, also where the base of the outer tube is free."""
    beam = SprungBeam(LENGTH, 1.5 * BENDING, 1.5 * SHEAR, 1.5 * MASS, tip_mass=TIP).frequencies()[0]
    for base in (None, 0.0):
        both = lowest_frequency([tube(), tube(0.5, base=base)], [(RADIUS, 1e16)], LENGTH, tip_mass=TIP)
        assert both == pytest.approx(beam, rel=MESH)


def test_springs_do_nothing_between_tubes_that_move_alike() -> None:
    held = [lowest_frequency([tube(), tube(0.5)], [(RADIUS, k)], LENGTH) for k in (0.0, 1e9, 1e12)]
    np.testing.assert_allclose(held, held[0], rtol=1e-9)


def test_a_tube_without_stiffness_adds_mass_alone() -> None:
    alone = SprungBeam(LENGTH, BENDING, SHEAR, 3.0 * MASS, base=(1e6, 4e4), tip_mass=TIP).frequencies()[0]
    soft = StickingTube(RADIUS, 1e-6, 1e-3, 2.0 * MASS, (0.0, LENGTH), 0.0)
    found = lowest_frequency([tube(base=4e4), soft], [(RADIUS, 0.0)], LENGTH, lateral=1e6, tip_mass=TIP)
    assert found == pytest.approx(alone, rel=MESH)


def test_free_tubes_have_no_rigid_frequency() -> None:
    free = SprungBeam(LENGTH, 2.0 * BENDING, 2.0 * SHEAR, 2.0 * MASS, base=(0.0, 0.0)).frequencies(3)[2]
    found = lowest_frequency([tube(base=0.0), tube(base=0.0)], [(RADIUS, 1e9)], LENGTH, lateral=0.0)
    assert found == pytest.approx(free, rel=3.0 * MESH)  # shorter waves


def compliance(outer: StickingTube, c: float, ratio: float) -> float:
    """Deflection of the tip per force of a held tube with a free one outside, by their differential equations.

    c = pi r k R_i^2; ratio = R_o / R_i; J = R_i (ratio (phi_o - w') - (phi_i - w')).
    """
    inner = tube()
    total = inner.shear + outer.shear + c * (ratio - 1.0) ** 2

    def rates(_: FloatArray, y: FloatArray) -> FloatArray:
        a, da, b, db, _w = y  # tilts of the inner and the outer tube, and their slopes
        more = c * (1.0 - ratio)
        slope = (1.0 + (inner.shear + more) * a + (outer.shear - more * ratio) * b) / total
        jump = ratio * (b - slope) - (a - slope)
        return np.stack([
            da, (-inner.shear * (slope - a) - c * jump) / inner.bending,
            db, (-outer.shear * (slope - b) + ratio * c * jump) / outer.bending, slope,
        ])  # fmt: skip

    def ends(low: FloatArray, high: FloatArray) -> FloatArray:
        return np.array([low[0], low[3], low[4], high[1], high[3]])

    z = np.linspace(0.0, LENGTH, 400)
    found = solve_bvp(rates, ends, z, np.zeros((5, len(z))), tol=1e-8, max_nodes=20000)
    assert found.success
    return float(found.y[4, -1])


@pytest.mark.parametrize(("stick", "ratio"), [(1e8, 1.0), (1e9, 1.0), (3e10, 1.0), (1e9, 1.2), (3e10, 1.2)])
def test_two_tubes_follow_their_differential_equations(stick: float, ratio: float) -> None:
    outer = tube(0.8, base=0.0, mass=1e-6, radius=ratio * RADIUS)
    c = math.pi * RADIUS * stick * RADIUS**2
    found = lowest_frequency([tube(mass=1e-6), outer], [(RADIUS, stick)], LENGTH, tip_mass=TIP)
    assert found == pytest.approx(
        math.sqrt(1.0 / (compliance(outer, c, ratio) * TIP[0, 0])) / (2.0 * math.pi), rel=MESH
    )
