"""27-node hexahedra with cylindrical material axes: zero modes, patch test, rotation, closed forms, convergence."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.sparse.linalg as spla
import sympy
from support.shell_patches import patch

from wroll_fem.bodies.body import SolidPart
from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.coiled_stiff.shear_points import quadratic_basis
from wroll_fem.coiled_stiff.solid_stress import coil_shear_strain
from wroll_fem.fem.coil import in_vtk_order
from wroll_fem.fem.eigen import solve_pairs
from wroll_fem.fem.shell import radial_director
from wroll_fem.fem.solid import SolidModel, thicken
from wroll_fem.mesh.generate import make_cylinders
from wroll_fem.mesh.shells import VTK_GRID

STRIP = CylindricalOrthotropic(10e9, 5e9, 0.1e9, 0.3, 0.3, 0.3, 1e9, 0.4e9, 0.7e9, 1600.0)
SOFT = replace(STRIP, G_r_theta=1e4, G_r_z=1e4)
INNER, OUTER, LENGTH = 0.010, 0.025, 0.3


@cache
def tube(around, axial, radial, length=LENGTH):
    """Model of a thick tube, and node numbers of its layers (layer, node)."""
    part = make_cylinders([("mandrel", INNER)], length, around, axial).part("mandrel")
    model = SolidModel(*thicken(part.nodes, part.cells, np.linspace(0, OUTER - INNER, 2 * radial + 1)))
    return model, np.arange(len(model.nodes)).reshape(2 * radial + 1, -1)


def sector(n, inner=1.0, outer=2.0):
    """Model of a curved block, n cells each way, and which of its nodes lie on the boundary."""

    def surface(s, t):
        angle = 0.3 + 0.9 * s
        return inner * np.cos(angle), inner * np.sin(angle), 1.2 * t

    nodes, cells, s, t = patch(surface, n, n)
    heights = np.linspace(0, outer - inner, 2 * n + 1)
    model = SolidModel(*thicken(nodes, cells, heights, radial_director))
    edge = np.isin(s, (0, 1)) | np.isin(t, (0, 1))
    return model, np.concatenate([np.full(len(s), k in (0, 2 * n)) | edge for k in range(2 * n + 1)])


def solve(stiffness, force, fixed, values):
    """Displacements (n, 3) with those of the nodes in the mask `fixed` given in `values` (n, 3)."""
    mask = np.repeat(fixed, 3)
    u = np.where(mask, values.ravel(), 0.0)
    free = np.flatnonzero(~mask)
    u[free] = spla.spsolve(stiffness[free][:, free].tocsc(), (force - stiffness @ u)[free])
    return u.reshape(-1, 3)


def cylindrical(nodes):
    return np.hypot(nodes[:, 0], nodes[:, 1]), np.arctan2(nodes[:, 1], nodes[:, 0]), nodes[:, 2]


def to_cartesian(nodes, radial, hoop, axial):
    _, theta, _ = cylindrical(nodes)
    cos, sin = np.cos(theta), np.sin(theta)
    return np.column_stack([cos * radial - sin * hoop, sin * radial + cos * hoop, axial * np.ones_like(cos)])


def part_of(model):
    return SolidPart(model.nodes, 1, in_vtk_order(model.nodes, model.cells), None, 0.0, None)


# ---- stiffness -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("material", "off"), [(STRIP, 0.10), (SOFT, 0.70)], ids=["tight", "loose"])
def test_free_tube_has_exactly_six_zero_modes_and_the_others_converge_from_above(material, off):
    lowest = []
    for mesh in ((12, 2, 1), (24, 3, 2)):
        model, _ = tube(*mesh, length=0.05)
        values = solve_pairs(model.orthotropic_stiffness(material), model.mass(material.rho), 12, sigma=-1e4).values
        assert np.abs(values[:6]).max() < 1e-6 * values[6]
        lowest.append(np.sqrt(values[6:]))
    assert (lowest[0] > 0.999 * lowest[1]).all()  # no false mode slips in below
    assert (lowest[0] < (1 + off) * lowest[1]).all()  # wraps that slide easily ovalise in short waves


def test_isotropic_limit_is_the_isotropic_solid():
    model, _ = tube(8, 2, 1)
    ours = model.orthotropic_stiffness(CylindricalOrthotropic.isotropic(4e9, 0.35, 1400.0))
    other = model.stiffness(4e9, 0.35)
    assert abs(ours - other).max() < 1e-12 * abs(other).max()


def test_turning_the_mesh_about_the_axis_turns_the_matrix():
    model, _ = tube(8, 2, 1)
    turn = np.array([[np.cos(0.7), -np.sin(0.7), 0], [np.sin(0.7), np.cos(0.7), 0], [0, 0, 1]])
    turned = SolidModel(model.nodes @ turn.T, model.cells).orthotropic_stiffness(STRIP).toarray()
    T = np.kron(np.eye(len(model.nodes)), turn)
    K = model.orthotropic_stiffness(STRIP).toarray()
    assert np.abs(T.T @ turned @ T - K).max() < 1e-11 * np.abs(K).max()
    tipped = SolidModel(model.nodes[:, [2, 0, 1]] + [1, 0, 0], model.cells).orthotropic_stiffness(STRIP)
    assert abs(tipped.diagonal().sum() / K.trace() - 1) > 0.1  # the axis matters


def test_distorted_cells_pass_the_patch_test():
    nodes, cells, _, _ = patch(lambda s, t: (1 + s, 0.1 + t, 0 * s), 2, 2)
    up = lambda points: np.tile([0.0, 0.0, 1.0], (len(points), 1))  # noqa: E731
    nodes, cells = thicken(nodes, cells, [0.0, 0.25, 0.5, 0.75, 1.0], up)
    inside = ((nodes > nodes.min(axis=0)) & (nodes < nodes.max(axis=0))).all(axis=1)
    corners = np.unique(cells[:, [0, 1, 2, 3, 4, 5, 6, 7]])
    rng = np.random.default_rng(2)
    moved = nodes.copy()
    move = np.intersect1d(corners, np.flatnonzero(inside))
    moved[move] += rng.uniform(-0.1, 0.1, (len(move), 3))
    model = SolidModel(moved, cells, thickness=1.0)
    K = model.orthotropic_stiffness(CylindricalOrthotropic.isotropic(1.0, 0.3, 1.0))
    u = moved @ rng.uniform(-1, 1, (3, 3))
    force = (K @ u.ravel()).reshape(-1, 3)
    assert np.abs(force[inside]).max() < 1e-12 * np.abs(force).max()


# ---- closed forms ----------------------------------------------------------------------------------------------------


def test_thick_orthotropic_ring_between_two_radii_is_lames():
    # plane strain: C_rr (u'' + u'/r) = C_tt u/r^2, so u = a r^q + b r^-q with q^2 = C_tt / C_rr
    ring = replace(STRIP, E_r=1e9)
    C = ring.stiffness()
    q = np.sqrt(C[1, 1] / C[0, 0])
    a, b = np.linalg.solve([[INNER**q, INNER**-q], [OUTER**q, OUTER**-q]], [1e-5, 0.0])
    model, layers = tube(16, 1, 6, length=0.01)
    r, _, _ = cylindrical(model.nodes)
    exact = a * r**q + b * r**-q
    fixed = np.zeros(len(r), bool)
    fixed[layers[[0, -1]]] = True
    K = model.orthotropic_stiffness(ring)
    axial = 3 * np.arange(len(r)) + 2  # plane strain: every axial displacement is zero
    mask = np.zeros(3 * len(r), bool)
    mask[axial] = True
    mask |= np.repeat(fixed, 3)
    u = np.where(np.repeat(fixed, 3), to_cartesian(model.nodes, exact, 0, 0).ravel(), 0.0)
    free = np.flatnonzero(~mask)
    u[free] = spla.spsolve(K[free][:, free].tocsc(), -(K @ u)[free])
    found = np.einsum("nd,nd->n", u.reshape(-1, 3), radial_director(model.nodes))
    assert np.abs(found - exact).max() < 2e-3 * 1e-5
    reaction = np.einsum("nd,nd->", (K @ u).reshape(-1, 3)[layers[0]], radial_director(model.nodes[layers[0]]))
    slope = q * (a * INNER ** (q - 1) - b * INNER ** (-q - 1))
    stress = C[0, 0] * slope + C[0, 1] * 1e-5 / INNER
    assert reaction == pytest.approx(-stress * 2 * np.pi * INNER * 0.01, rel=3e-3)


def test_manufactured_solution_converges_at_third_order():
    # displacement in cylindrical components; the body force that it needs, by sympy from equilibrium in r, theta, z
    r, t, z = sympy.symbols("r t z", positive=True)
    u, v, w = sympy.sin(z) * sympy.cos(2 * t) * r**2, sympy.cos(z) * sympy.sin(t) * r, sympy.sin(t + z) / r
    material = CylindricalOrthotropic(4.0, 3.0, 0.5, 0.25, 0.3, 0.2, 1.0, 0.3, 0.6, 1.0)
    D = sympy.diff
    strain = [
        D(u, r),
        (u + D(v, t)) / r,
        D(w, z),
        D(v, z) + D(w, t) / r,
        D(u, z) + D(w, r),
        D(u, t) / r + D(v, r) - v / r,
    ]
    C = material.stiffness()
    rr, tt, zz, tz, rz, rt = (sum(float(C[i, j]) * strain[j] for j in range(6) if C[i, j]) for i in range(6))
    force = [
        -(D(rr, r) + D(rt, t) / r + D(rz, z) + (rr - tt) / r),
        -(D(rt, r) + D(tt, t) / r + D(tz, z) + 2 * rt / r),
        -(D(rz, r) + D(tz, t) / r + D(zz, z) + rz / r),
    ]
    exact, load = (sympy.lambdify((r, t, z), parts) for parts in ([u, v, w], force))
    errors = []
    for n in (2, 4):
        model, boundary = sector(n)
        values = to_cartesian(model.nodes, *exact(*cylindrical(model.nodes)))
        body = to_cartesian(model.nodes, *load(*cylindrical(model.nodes)))
        found = solve(model.orthotropic_stiffness(material), model.mass(1.0) @ body.ravel(), boundary, values)
        grid = np.array(VTK_GRID) / 2  # the error where no node is: at the thirds of each cell
        N, _ = quadratic_basis(1 / 6 + grid * 2 / 3)
        cells = part_of(model).cells
        x = np.einsum("qk,ckd->cqd", N, model.nodes[cells]).reshape(-1, 3)
        at = np.einsum("qk,ckd->cqd", N, found[cells]).reshape(-1, 3)
        errors.append(np.sqrt(np.mean((at - to_cartesian(x, *exact(*cylindrical(x)))) ** 2)))
    assert errors[1] < 5e-3
    assert np.log2(errors[0] / errors[1]) > 2.7


# ---- stress recovery -------------------------------------------------------------------------------------------------


def test_shear_between_two_cylinders_is_exact_at_the_reduced_points():
    # outer surface moved along the axis: gamma_rz = 1 / (r ln(b/a)); turned: gamma_rt = -2 c / r^2, u_t = r + c / r
    model, layers = tube(16, 1, 3)
    r, _, z = cylindrical(model.nodes)
    K = model.orthotropic_stiffness(STRIP)
    fixed = np.zeros(len(r), bool)
    fixed[layers[[0, -1]]] = True
    fixed |= (z < 1e-9) | (z > LENGTH - 1e-9)  # the ends follow the exact solution
    axial = np.log(r / INNER) / np.log(OUTER / INNER)
    turn = r - INNER**2 / r
    fields = [to_cartesian(model.nodes, 0 * r, 0 * r, axial), to_cartesian(model.nodes, 0 * r, turn, 0 * r)]
    moved = np.column_stack([solve(K, np.zeros(K.shape[0]), fixed, field).ravel() for field in fields])
    errors = {}
    for points in (2, 3):
        at, volumes, rz, rt = coil_shear_strain(part_of(model), moved, points)
        exact_rz, exact_rt = 1 / (at[:, 2] * np.log(OUTER / INNER)), 2 * INNER**2 / at[:, 2] ** 2
        errors[points] = np.abs(rz[0] / exact_rz - 1).max(), np.abs(rt[1] / exact_rt - 1).max()
        assert np.abs(rz[1]).max() < 1e-6 * exact_rz.max()
        assert np.abs(rt[0]).max() < 1e-6 * exact_rt.max()
        assert volumes.sum() == pytest.approx(np.pi * (OUTER**2 - INNER**2) * LENGTH, rel=2e-4)
        assert at[:, 0].min() > -np.pi
        assert at[:, 0].max() <= np.pi
    assert max(errors[2]) < 0.015
    assert all(two < 0.5 * three for two, three in zip(errors[2], errors[3], strict=True))


def test_tube_with_a_load_at_its_tip_has_saint_venants_shear():
    # A. E. H. Love, Theory of Elasticity, section 230: hollow circular cylinder bent by a force at its end
    E, nu = 3e9, 0.3
    model, _ = tube(16, 10, 2, length=0.2)
    material = CylindricalOrthotropic.isotropic(E, nu, 1.0)
    _, _, z = cylindrical(model.nodes)
    tip = z > 0.2 - 1e-9
    share = np.where(tip, model.mass(1.0).diagonal()[::3], 0.0)
    force = np.zeros((len(z), 3))
    force[:, 0] = share / share.sum()
    u = solve(model.orthotropic_stiffness(material), force.ravel(), z < 1e-9, np.zeros((len(z), 3)))
    points, _, rz, rt = coil_shear_strain(part_of(model), u.reshape(-1, 1))
    middle = np.abs(points[:, 1] - 0.1) < 0.2 / 10
    theta, _, r = points[middle].T
    inertia = np.pi / 4 * (OUTER**4 - INNER**4)
    factor = (3 + 2 * nu) / (8 * (1 + nu)) / inertia
    exact = factor * (OUTER**2 + INNER**2 - r**2 - (OUTER * INNER / r) ** 2) * np.cos(theta)
    found = material.G_r_z * rz[0, middle]
    assert np.abs(found - exact).max() < 0.02 * np.abs(exact).max()
    assert np.abs(material.G_r_theta * rt[0, middle]).max() < 0.02 * np.abs(exact).max()
