"""Cantilever with a stack of n plates that slide on each other: its limit for many plates is the slipping continuum.

The stack is a beam model: one deflection, Hermite cubic, and an axial displacement per plate. The continuum consists of
the hexahedra and shear points of a coil. Both lie on a stiff plate, and a uniform load bends them. The lowest plate of
the stack shears over half its thickness, from the surface of the stiff plate on; the highest one has a free half. Its
share of the stack falls as 1/n, its shear faster.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp

from wroll_fem.coiled_stiff.shear_points import ShearPoints, quadratic_basis
from wroll_fem.coiled_stiff.slipping_coil import shear_interface
from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.system.system import System
from wroll_fem.mesh.shells import VTK_GRID

LENGTH, HEIGHT, WIDTH, WALL = 1.0, 0.1, 0.02, 0.02  # m; height of the stack, thickness of the stiff plate below it
E, E_WALL, G = 1e9, 2e10, 2e7  # Pa
MU, PRESSURE = 0.25, 4e4  # -, Pa
LEVELS = np.array([1.0, 2.0, 3.0, 5.0])  # of the load at which the first point slides
FAR = 1e3  # m, distance from the axis of the coil: its wraps are flat


def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    x, w = np.polynomial.legendre.leggauss(count)
    return 0.5 * (x + 1.0), 0.5 * w


def nodes_along(count: int) -> np.ndarray:
    """Elements become shorter towards the clamped end."""
    return LENGTH * np.linspace(0.0, 1.0, count + 1) ** 1.5


@cache
def stack(n: int, elements: int = 24, *, stiff: bool = True) -> tuple[LoadPath, np.ndarray, np.ndarray]:
    """Path, load per N/m, and row of the tip deflection of ``n`` plates on a stiff one, or on one like them."""
    x, h = nodes_along(elements), HEIGHT / n
    axial = 2 * elements + 1  # quadratic, per plate; the first plate is the stiff one
    count = 2 * (elements + 1) + (n + 1) * axial
    thickness, modulus = np.array([WALL if stiff else h, *[h] * n]), np.array([E_WALL if stiff else E, *[E] * n])
    stiffness, load = sp.lil_matrix((count, count)), np.zeros(count)
    gamma, volumes = [], []
    points, weights = gauss(3)
    for e, length in enumerate(np.diff(x)):
        bend = np.arange(2 * e, 2 * e + 4)
        for s, weight in zip(points, weights * length, strict=True):
            w = np.array(
                [1 - 3 * s**2 + 2 * s**3, length * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, length * (s**3 - s**2)]
            )
            slope = np.array(
                [6 * s * (s - 1) / length, 1 - 4 * s + 3 * s**2, 6 * s * (1 - s) / length, 3 * s**2 - 2 * s]
            )
            curve = np.array([12 * s - 6, length * (6 * s - 4), 6 - 12 * s, length * (6 * s - 2)]) / length**2
            u = np.array([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)])
            strain = np.array([4 * s - 3, 4 - 8 * s, 4 * s - 1]) / length
            load[bend] += weight * w
            bending = float(modulus @ thickness**3) * WIDTH / 12.0
            stiffness[np.ix_(bend, bend)] += weight * bending * np.outer(curve, curve)
            for k in range(n + 1):
                along = 2 * (elements + 1) + k * axial + np.arange(2 * e, 2 * e + 3)
                area = modulus[k] * thickness[k] * WIDTH
                stiffness[np.ix_(along, along)] += weight * area * np.outer(strain, strain)
                if k:  # shear between the mid-planes; the first plate shears from the surface of the stiff one
                    part = 0.5 * h if stiff and k == 1 else h
                    lever = 0.5 * (thickness[k - 1] + thickness[k])
                    row = np.zeros(count)
                    row[along], row[along - axial], row[bend] = u / part, -u / part, slope * lever / part
                    gamma.append(row)
                    volumes.append(weight * part * WIDTH)
    held = np.array([0, 1, *(2 * (elements + 1) + k * axial for k in range(n + 1))])
    free = np.setdiff1d(np.arange(count), held)
    tip = np.zeros(count)
    tip[2 * elements] = 1.0
    strain = np.zeros((2 * len(gamma), count))
    strain[1::2] = gamma
    return path(stiffness.tocsr()[free][:, free], strain[:, free], np.array(volumes)), load[free], tip[free]


@cache
def continuum(along: int = 24, across: int = 6, wall: int = 2) -> tuple[LoadPath, np.ndarray, np.ndarray]:
    """The same of the slipping continuum, in hexahedra."""
    lines = [x / x.max() for x in (np.arange(3.0), np.arange(2 * along + 1.0), np.arange(2 * (across + wall) + 1.0))]
    theta = WIDTH * (lines[0] - 0.5) / FAR
    z = LENGTH * lines[1] ** 1.5
    r = np.concatenate([np.linspace(-WALL, 0.0, 2 * wall + 1)[:-1], np.linspace(0.0, HEIGHT, 2 * across + 1)])
    R, T, Z = np.meshgrid(FAR + r, theta, z, indexing="ij")
    nodes = np.stack([R * np.cos(T), R * np.sin(T), Z], axis=-1).reshape(-1, 3)
    number = np.arange(len(nodes)).reshape(R.shape)
    grid = np.array(VTK_GRID)
    cells = np.array(
        [number[2 * k + grid[:, 2], grid[:, 0], 2 * j + grid[:, 1]] for k in range(across + wall) for j in range(along)]
    )
    count = 3 * len(nodes)
    # normal strains r, theta, z and shears theta-z, rt, rz without coupling; the flat coil has r along x
    coil = np.diag([1e3 * E, E, E, E, 0.0, 0.0])
    plate = np.diag([1e3 * E_WALL, E_WALL, E_WALL, E_WALL, E_WALL, 1e2 * E_WALL])
    stiffness, load = sp.lil_matrix((count, count)), np.zeros(count)
    for c, cell in enumerate(cells):
        points, weights = gauss(
            2 if c < wall * along else 3
        )  # the stiff plate has no shear strain: two points do not lock
        local = np.stack(np.meshgrid(points, points, points, indexing="ij"), axis=-1).reshape(-1, 3)
        weight = np.einsum("i,j,k->ijk", weights, weights, weights).ravel()
        N, dN = quadratic_basis(local)
        jacobian = np.einsum("qka,kd->qda", dN, nodes[cell])
        slope = np.einsum("qka,qad->qkd", dN, np.linalg.inv(jacobian))
        volume = weight * np.abs(np.linalg.det(jacobian))
        B = np.zeros((len(weight), 6, 27, 3))
        for row, parts in enumerate(
            [[(0, 0)], [(1, 1)], [(2, 2)], [(1, 2), (2, 1)], [(0, 1), (1, 0)], [(0, 2), (2, 0)]]
        ):
            for component, axis in parts:
                B[:, row, :, component] = slope[:, :, axis]
        B = B.reshape(len(weight), 6, 81)
        dofs = (3 * cell[:, None] + np.arange(3)).ravel()
        law = plate if c < wall * along else coil
        stiffness[np.ix_(dofs, dofs)] += np.einsum("q,qia,ij,qjb->ab", volume, B, law, B)
        if c >= wall * along:  # body force of the stack alone; its sum is 1 N/m
            load[3 * cell] += volume @ N / (HEIGHT * WIDTH)
    part = type("Part", (), {"nodes": nodes, "cells": cells[wall * along :]})
    at = ShearPoints.of(part)
    held = np.unique(number[:, :, 0])
    # the motion is plane: no displacement along theta
    fixed = np.unique(np.concatenate([(3 * held[:, None] + np.arange(3)).ravel(), 3 * np.arange(len(nodes)) + 1]))
    free = np.setdiff1d(np.arange(count), fixed)
    tip = np.zeros(count)
    tip[3 * number[0, 1, -1]] = 1.0
    strain = at.strain.tocsc()[:, free]
    return path(stiffness.tocsr()[free][:, free], strain, at.volumes), load[free], tip[free]


def path(stiffness: sp.csr_matrix, strain: object, volumes: np.ndarray) -> LoadPath:
    size, n = stiffness.shape[0], len(volumes)
    points = ShearPoints(np.zeros((n, 3)), volumes, sp.csr_matrix(strain))
    pressure = np.full(n, PRESSURE)
    interface = shear_interface(points, points.strain, shear_modulus=G, pressure=pressure, mu=MU, wrap_thickness=5e-5)
    mass, none = sp.identity(size, format="csr"), np.zeros(size)
    system = System(stiffness, mass, none, interfaces=(interface,), probes={"tip": none})
    return LoadPath(system, ContactState.pressed(system, pressure), tolerance=1e-4)


@cache
def onset(n: int = 32, *, stiff: bool = True) -> float:
    """Load, N/m, at which the first point of a stack of ``n`` plates slides."""
    found, load, _ = stack(n, stiff=stiff)
    rate = np.linalg.norm(tangentials(found.springs * (found.system.jump @ found.stuck(load))), axis=1)
    return MU * PRESSURE / float(rate.max())


@cache
def followed(n: int, *mesh: int) -> tuple[np.ndarray, np.ndarray]:
    """Tip deflection and slip work over the load, the same in all models; the continuum for n = 0."""
    return under(*(stack(n) if n else continuum(*mesh)), LEVELS * onset())


def under(found: LoadPath, load: np.ndarray, tip: np.ndarray, levels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    work, before, deflections, works = 0.0, found.start, [], []
    for level in levels:
        state = found.to(level * load)
        moved = tangentials(state.jump) - tangentials(before.jump)
        slipped = moved - (state.elastic_slip - before.elastic_slip).reshape(-1, 2)
        work += float(found.system.laws.area @ (tangentials(state.traction) * slipped).sum(axis=1))
        before = state
        deflections.append(float(tip @ state.displacement))
        works.append(work)
    return np.array(deflections), np.array(works)


def differences(n: int, *mesh: int) -> np.ndarray:
    """Relative differences of the stack from the continuum: deflection, and slip work away from its onset."""
    stacked, limit = followed(n), followed(0, *mesh)
    return np.concatenate([stacked[0] / limit[0] - 1.0, stacked[1][1:] / limit[1][1:] - 1.0])


@pytest.mark.slow
def test_twice_as_many_plates_halve_the_difference_from_the_slipping_continuum() -> None:
    four, eight = (np.abs(differences(n)) for n in (4, 8))
    assert np.all(eight < 0.5 * four + 1e-3)


@pytest.mark.slow
def test_many_plates_have_deflection_and_dissipation_of_the_slipping_continuum() -> None:
    eight, sixteen = (np.abs(differences(n)) for n in (8, 16))
    assert np.all(sixteen < 0.5 * eight + 1e-3)
    assert sixteen.max() < 0.0125


@pytest.mark.slow
def test_sixty_four_plates_are_within_a_percent_of_the_refined_continuum() -> None:
    assert np.abs(differences(64, 48, 12)).max() < 0.01


def test_gross_slip_dissipates_the_friction_limit_times_the_slip_of_all_interfaces() -> None:
    """The slip is h w' less the elongation of the two outer plates, which friction pulls from one side only."""
    n = 5
    found, load, tip = stack(n, stiff=False)
    deflection, work = under(found, load, tip, onset(n, stiff=False) * np.array([4.0, 8.0]))
    limit, h = MU * PRESSURE, HEIGHT / n
    slip = n * h * deflection - 2.0 * limit * LENGTH**3 / (3.0 * E * h) - n * h * LENGTH * limit / G
    assert 4.0 * work[1] == pytest.approx(4.0 * limit * WIDTH * slip[1], rel=1e-3)
