"""Fourier axisymmetric elements against closed forms and exact fields."""

import dataclasses

import numpy as np
import pytest
import scipy.sparse.linalg as spla
import ufl
from dolfinx import fem
from support.fourier_rolls import NU, PLASTIC, RHO, WEB, E, L, half_plane, model

from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.fem import compat
from wroll_fem.fem.fourier import COIL, strains


def solve_with(matrix, fixed, values):
    """Solution with the values of the fixed degrees of freedom given, and the forces that hold them."""
    free = np.setdiff1d(np.arange(matrix.shape[0]), fixed)
    u = np.array(values, float)
    u[free] = spla.spsolve(matrix[free][:, free].tocsc(), -(matrix[free][:, fixed] @ u[fixed]))
    return u, matrix @ u


def test_rigid_motions_of_every_harmonic_cost_nothing_and_no_other_motion_does():
    made = model()
    r, z = made.nodes.T
    zero = np.zeros_like(r)
    rigid = {
        0: [[zero, zero, zero + 1], [zero, r, zero]],  # along the axis, around it
        1: [[zero + 1, zero - 1, zero], [z, -z, -r]],  # across, and tilt about y
        2: [],
    }
    for m, motions in rigid.items():
        K, M = made.stiffness(m), made.mass(m)
        scale = abs(K).max()
        for motion in motions:
            u = np.column_stack(motion).ravel()
            assert np.abs(K @ u).max() < 1e-12 * scale * np.abs(u).max()
        values = np.linalg.eigvalsh(K.toarray())
        assert np.count_nonzero(values < 1e-10 * values[-1]) == len(motions)
        mass = np.pi * (0.01**2 * 3 * RHO + (0.03**2 - 0.02**2) * 1400.0) * L
        for motion in motions[:1]:
            u = np.column_stack(motion).ravel()
            assert u @ M @ u == pytest.approx(mass, rel=1e-12)


@pytest.mark.parametrize("degree", [2, 3])
def test_pure_bending_of_a_tube_is_exact(degree):
    # Saint-Venant: ux = -k/2 (z^2 + nu (x^2 - y^2)), uy = -k nu x y, uz = k x z: quadratic, harmonics 1 only
    kappa, made = 0.7, model(coil=PLASTIC, degree=degree)
    r, z = made.nodes.T
    even = -0.5 * kappa * (z**2 + NU * r**2)  # u_r = even cos, from cos^2 - sin^2 and sin^2 cos parts
    u = np.column_stack([even, 0.5 * kappa * (z**2 - NU * r**2), kappa * r * z]).ravel()
    K = made.stiffness(1)
    inertia = 0.25 * np.pi * (0.03**4 - 0.01**4)
    assert 0.5 * u @ (K @ u) == pytest.approx(0.5 * E * inertia * kappa**2 * L, rel=1e-10)
    inside = (z > 1e-9) & (z < L - 1e-9)
    force = (K @ u).reshape(-1, 3)
    assert np.abs(force[inside]).max() < 1e-9 * np.abs(force).max()


def test_uniform_stretch_across_the_axis_is_exact():
    # ux = x alone: u_r = r cos^2, u_theta = -r cos sin: half of it in m = 0, half in m = 2
    made = model(coil=PLASTIC)
    r = made.nodes[:, 0]
    zero = np.zeros_like(r)
    work = 0.0
    for m, motion in ((0, [r / 2, zero, zero]), (2, [r / 2, -r / 2, zero])):
        u = np.column_stack(motion).ravel()
        work += 0.5 * u @ (made.stiffness(m) @ u)
    stiffness = PLASTIC.stiffness()[0, 0]
    assert work == pytest.approx(0.5 * stiffness * np.pi * (0.03**2 - 0.01**2) * L, rel=1e-12)


def test_lame_and_lekhnitskii_tubes():
    # plane strain, u_r given on both surfaces: pressure from the closed forms; orthotropic: u = A r^k + B r^-k
    for material in (PLASTIC, WEB):
        C = material.stiffness()
        k = np.sqrt(C[1, 1] / C[0, 0])
        a, b = 0.02, 0.03
        made = model(half_plane(inner=a, wall=0.024, outer=b, length=0.01, cells=(4, 6, 1)), material, material)
        r = made.nodes[:, 0]
        exact = 1e-4 * ((r / b) ** k + (r / b) ** -k)
        u = np.column_stack([exact, np.zeros_like(r), np.zeros_like(r)]).ravel()
        ends = np.flatnonzero((r < a + 1e-9) | (r > b - 1e-9))
        fixed = np.union1d(3 * ends, np.concatenate([3 * np.arange(len(r)) + 1, 3 * np.arange(len(r)) + 2]))
        found, force = solve_with(made.stiffness(0), fixed, u)
        assert np.abs(found[0::3] - exact).max() < 5e-6 * np.abs(exact).max()
        slope = 1e-4 * k * ((a / b) ** k - (a / b) ** -k) / a
        pressure = -(C[0, 0] * slope + C[0, 1] * 1e-4 * ((a / b) ** k + (a / b) ** -k) / a)
        total = force[0::3][r < a + 1e-9].sum()
        assert total == pytest.approx(pressure * 2 * np.pi * a * 0.01, rel=2e-4)


def test_torsion_and_stretch_of_a_wall_and_coil_bar():
    # coil with nu = 0 and the wall too, so that both deform alike: EA/L and GJ/L of the composite bar
    wall = CylindricalOrthotropic.isotropic(E, 0.0, RHO)
    coil = dataclasses.replace(WEB, nu_theta_z=0.0, nu_z_r=0.0)
    made = model(wall=wall, coil=coil)
    r, z = made.nodes.T
    tip = np.flatnonzero((z < 1e-9) | (z > L - 1e-9))
    zero = np.zeros_like(r)
    areas = np.pi * np.array([0.02**2 - 0.01**2, 0.03**2 - 0.02**2])
    polar = 0.5 * np.pi * np.array([0.02**4 - 0.01**4, 0.03**4 - 0.02**4])
    _, force = solve_with(made.stiffness(0), 3 * tip + 2, np.column_stack([zero, zero, z]).ravel())
    up = z > L - 1e-9
    assert force[2::3][up].sum() == pytest.approx(areas @ [E, 3e9], rel=1e-10)
    _, force = solve_with(made.stiffness(0), 3 * tip + 1, np.column_stack([zero, r * z, zero]).ravel())
    assert (force[1::3] * r)[up].sum() == pytest.approx(polar @ [E / 2, 1.4e9], rel=1e-10)


def test_a_material_with_tilted_axes_is_refused():
    C = WEB.stiffness()
    C[1, 3] = C[3, 1] = 1e8
    with pytest.raises(ValueError, match="axes"):
        model().set_material(COIL, C, 1.0)


def manufactured_error(degree, cells):
    """L2 error for a smooth field of harmonic 2, body force from the equations of equilibrium in r, theta, z."""
    m, size = 2, 0.02
    made = model(half_plane(0.02, 0.03, 0.04, size, (cells, cells, 2 * cells)), WEB, WEB, degree)
    r, z = ufl.SpatialCoordinate(made.mesh)
    a, b = np.pi / size * r, np.pi / size * z
    exact = ufl.as_vector([ufl.sin(a) * ufl.cos(b), ufl.cos(a + b), ufl.sin(b) * ufl.sin(a)])
    cos_part, sin_part = strains(exact, r, m)
    C = WEB.stiffness()
    rr, tt, zz, rz = ufl.as_matrix(C[np.ix_([0, 1, 2, 4], [0, 1, 2, 4])].tolist()) * cos_part
    tz, rt = ufl.as_matrix(C[np.ix_([3, 5], [3, 5])].tolist()) * sin_part
    load = -ufl.as_vector(
        [
            rr.dx(0) + m * rt / r + rz.dx(1) + (rr - tt) / r,
            rt.dx(0) - m * tt / r + tz.dx(1) + 2 * rt / r,
            rz.dx(0) + m * tz / r + zz.dx(1) + rz / r,
        ]
    )
    v = ufl.TestFunction(made.space)
    dx = ufl.Measure("dx", domain=made.mesh, metadata={"quadrature_degree": 2 * degree + 4})
    force = np.pi * compat.assemble_array(compat.compile_form(ufl.inner(load, v) * r * dx))
    x, y = (np.pi / size * made.nodes).T
    nodal = np.column_stack([np.sin(x) * np.cos(y), np.cos(x + y), np.sin(y) * np.sin(x)]).ravel()
    R, Z = made.nodes.T
    edge = np.minimum.reduce([R - 0.02, 0.04 - R, Z, size - Z]) < 1e-9
    fixed = np.flatnonzero(np.repeat(edge, 3))
    free = np.setdiff1d(np.arange(nodal.size), fixed)
    K = made.stiffness(m)
    nodal[free] = spla.spsolve(K[free][:, free].tocsc(), force[free] - K[free][:, fixed] @ nodal[fixed])
    field = fem.Function(made.space)
    field.x.array[:] = nodal
    error = compat.compile_form(ufl.inner(field - exact, field - exact) * dx)
    return np.sqrt(fem.assemble_scalar(error)) / size


@pytest.mark.parametrize(("degree", "bound"), [(2, 3e-3), (3, 2e-4)])
def test_a_manufactured_solution_converges_at_the_full_rate(degree, bound):
    coarse, fine = manufactured_error(degree, 2), manufactured_error(degree, 4)
    assert np.log2(coarse / fine) > degree + 0.8
    assert fine < bound
