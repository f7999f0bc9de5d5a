"""Assembled bodies: constraints, symmetry, traces, loads, frequencies of the lab roll."""

import itertools
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from support.beam_theory import beam_frequency
from support.paths import CONFIGS

from wroll_fem.bodies.mode_shapes import classify_mode
from wroll_fem.case import load_case
from wroll_fem.errors import InputError, WrollError
from wroll_fem.fem import eigen
from wroll_fem.fem.body import assemble_bodies, ring_weights, shell_section
from wroll_fem.fem.constraints import rigid_motions
from wroll_fem.fem.eigen import DEFAULT_SHIFT, solve_modes, solve_pairs
from wroll_fem.fem.shell import ShellSection
from wroll_fem.mesh.generate import build_mesh, make_cylinders, shell_layout
from wroll_fem.mesh.shells import CylinderMesh

TINY = CONFIGS / "tiny.yaml"
LAB = ShellSection(2.7e9, 0.35, 1200.0, 1.5e-3)
FREE = ["mandrel.base=free", "mandrel.tip=free", "mandrel.tip_mass=0"]


def lab(*overrides):
    return load_case(TINY, ["analysis=modal", *overrides])


@cache
def bodies_of(*overrides, symmetric):
    """Bodies of the lab roll, assembled once; no test changes them."""
    return assemble_bodies(lab(*overrides), symmetric=symmetric)


@pytest.fixture(scope="module")
def whole():
    return bodies_of("coil.layers=2", symmetric=False)


@pytest.fixture(scope="module")
def half():
    return bodies_of("coil.layers=2", symmetric=True)


def nodal_to_unknowns(body, nodal):
    """Unknowns that best reproduce nodal values, and how well they do."""
    E = body.expand
    y = spla.spsolve((E.T @ E).tocsc(), E.T @ nodal)
    return y, np.abs(body.expand @ y - nodal).max()


# ---- shapes and frequencies ------------------------------------------------------------------------------------------


def test_bodies_are_named_inner_first_and_sized_by_their_constraints(whole):
    assert [body.name for body in whole] == ["mandrel", "layer_01", "layer_02"]
    nodes = 24 * 9
    assert all(len(body.nodes) == nodes for body in whole)
    assert whole[0].n_dofs == 6 * (nodes - 2 * 24) + 6
    assert whole[1].n_dofs == whole[2].n_dofs == 6 * nodes
    for body in whole:
        for matrix in (body.stiffness, body.mass):
            assert matrix.shape == (body.n_dofs, body.n_dofs)
            assert abs(matrix - matrix.T).max() == 0.0
            assert (matrix.diagonal() > 0).all()
        assert body.cells.shape == (48, 9)


def test_lab_mandrel_alone_resonates_at_150_hz():
    body = bodies_of("coil.model=none", "mesh.circumferential=16", "mesh.axial=6", symmetric=True)[0]
    frequencies, _ = solve_modes(body.stiffness, body.mass, 1)
    # thesis: E_m was tuned so that mandrel-only resonates at about 150 Hz; converged value of this model 150.50
    assert frequencies[0] == pytest.approx(150.50, abs=0.1)


def test_coil_as_nonstructural_mass_lowers_the_frequency_by_its_mass():
    alone = bodies_of("coil.model=none", symmetric=True)[0]
    case = lab("coil.model=nonstructural_mass")
    loaded = assemble_bodies(case, symmetric=True)[0]
    coil = 2000.0 * np.pi * (0.04125**2 - 0.04**2) * 0.3
    assert loaded.mass_total - alone.mass_total == pytest.approx(coil, rel=1e-3)  # area of the 12 quadratic arcs
    assert abs(loaded.stiffness - alone.stiffness).max() == 0.0
    f_alone, f_loaded = (solve_modes(b.stiffness, b.mass, 1)[0][0] for b in (alone, loaded))
    heavier = ShellSection(2.7e9, 0.35, 1200.0 * (loaded.mass_total - 0.05) / (alone.mass_total - 0.05), 1.5e-3)
    expected = beam_frequency(heavier, 0.03925, 0.3, 0.05) / beam_frequency(LAB, 0.03925, 0.3, 0.05)
    assert f_loaded / f_alone == pytest.approx(expected, rel=3e-3)  # beam theory turns the section, with its inertia


def test_symmetric_model_has_the_bending_x_modes_of_the_whole():
    case = lab("coil.layers=1")
    for full, part in zip(assemble_bodies(case, symmetric=False), assemble_bodies(case, symmetric=True), strict=True):
        assert part.n_dofs < 0.52 * full.n_dofs
        all_modes, _ = solve_modes(full.stiffness, full.mass, 24)
        half_modes, vectors = solve_modes(part.stiffness, part.mass, 8)
        elastic = half_modes > 1.0
        nearest = np.abs(all_modes[:, None] - half_modes[elastic]).min(axis=0) / half_modes[elastic]
        assert nearest.max() < 1e-8
        if part.name == "mandrel":
            assert classify_mode([part], vectors[:, 0]).kind == "bending"
            nodal = (part.expand @ vectors[:, 0]).reshape(-1, 6)
            assert np.abs(nodal[:, 0]).max() > 1.5 * np.abs(nodal[:, 1]).max()
            # the mode of half the roll, unfolded, is a mode of the whole
            y, misfit = nodal_to_unknowns(full, nodal.ravel())
            assert misfit < 1e-9 * np.abs(nodal).max()
            lam = (2 * np.pi * half_modes[0]) ** 2
            residual = full.stiffness @ y - lam * (full.mass @ y)
            assert np.abs(residual).max() < 1e-8 * np.abs(full.stiffness @ y).max()


def test_symmetric_bodies_carry_the_forces_and_masses_of_the_whole_roll(whole, half):
    for full, part in zip(whole, half, strict=True):
        assert part.mass_total == full.mass_total
        assert part.symmetric
        assert not full.symmetric
        for axis in (0, 2):
            a, b = full.influence[:, axis], part.influence[:, axis]
            assert b @ part.mass @ b == pytest.approx(a @ full.mass @ a, rel=1e-12)
        assert not part.influence[:, 1].any()
        for side in ("inner", "outer"):
            assert part.traces[side].areas.sum() == pytest.approx(full.traces[side].areas.sum(), rel=1e-12)
            theta = part.traces[side].points[:, 0]
            assert theta.min() == 0.0
            assert theta.max() == pytest.approx(np.pi)


def test_symmetric_traces_and_loads_are_those_of_the_unfolded_motion(whole, half):
    rng = np.random.default_rng(0)
    for full, part in zip(whole, half, strict=True):
        y = rng.standard_normal(part.n_dofs)
        unfolded, misfit = nodal_to_unknowns(full, part.expand @ y)
        assert misfit < 1e-12
        assert part.pressure_force @ y == pytest.approx(full.pressure_force @ unfolded, rel=1e-9)
        assert y @ part.stiffness @ y == pytest.approx(unfolded @ full.stiffness @ unfolded, rel=1e-9)
        for side in ("inner", "outer"):
            points = full.traces[side].points
            keep = np.flatnonzero(points[:, 0] > -1e-9)
            np.testing.assert_allclose(points[keep], part.traces[side].points, atol=1e-14)
            motion = (full.traces[side].operator @ unfolded).reshape(-1, 3)[keep]
            np.testing.assert_allclose((part.traces[side].operator @ y).reshape(-1, 3), motion, atol=1e-11)


# ---- constraints -----------------------------------------------------------------------------------------------------


def test_rigid_tip_moves_as_one_and_carries_the_tip_mass(whole):
    body = whole[0]
    y = np.zeros(body.n_dofs)
    y[-6:] = [0.1, -0.2, 0.3, 0.01, 0.02, -0.03]
    nodal = (body.expand @ y).reshape(-1, 6)
    ring = np.isclose(body.nodes[:, 2], 0.3)
    arm = body.nodes[ring] - [0, 0, 0.3]
    np.testing.assert_allclose(nodal[ring, :3], y[-6:-3] + np.cross(y[-3:], arm), atol=1e-15)
    np.testing.assert_allclose(nodal[ring, 3:], np.tile(y[-3:], (ring.sum(), 1)), atol=1e-15)
    np.testing.assert_allclose(body.probes["tip"] @ y, y[-6:-3])
    without = bodies_of("mandrel.tip_mass=0", symmetric=False)[0]
    difference = (body.mass - without.mass).tocoo()
    np.testing.assert_allclose(difference.diagonal()[-6:-3], 0.05, rtol=1e-12)
    assert abs(difference).sum() == pytest.approx(0.15, rel=1e-9)


def test_free_tip_spreads_the_tip_mass_over_its_ring_and_probes_the_mean():
    body = bodies_of("mandrel.tip=free", symmetric=False)[0]
    translation = body.influence @ np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(body.probes["tip"] @ translation, [1, 2, 3], rtol=1e-12)
    without = bodies_of("mandrel.tip=free", "mandrel.tip_mass=0", symmetric=False)[0]
    r = body.influence[:, 0]
    assert r @ (body.mass - without.mass) @ r == pytest.approx(0.05, rel=1e-9)
    touched = np.abs((body.mass - without.mass) @ r) > 1e-9
    z = body.nodes[(body.expand[:, touched].tocoo().row // 6), 2]
    np.testing.assert_allclose(z, 0.3)


def test_ring_mean_integrates_quadratic_edges_exactly():
    part = make_cylinders([("mandrel", 1.0)], 0.3, 8, 2).part("mandrel")
    weights = ring_weights(part, part.groups["tip"])
    ring = part.groups["tip"]
    at_corner = np.isin(ring, part.cells[:, :4])
    np.testing.assert_allclose(weights[ring], np.where(at_corner, 1 / 3, 2 / 3) / 8, rtol=1e-12)  # Simpson
    assert weights.sum() == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize(
    ("base", "clamped"), [("free", [False, False]), ("clamped", [True, True]), ("inner_edge", [True, False])]
)
def test_layer_base_follows_the_case(base, clamped):
    bodies = bodies_of("coil.layers=2", f"coil.base={base}", symmetric=False)[1:]
    for body, held in zip(bodies, clamped, strict=True):
        ring = np.flatnonzero(np.isclose(body.nodes[:, 2], 0.0))
        values = body.expand[(6 * ring[:, None] + np.arange(6)).ravel()]
        assert (values.nnz == 0) == held


def test_influence_of_a_free_body_gives_its_total_mass():
    for body in bodies_of(*FREE, symmetric=False):
        moment = body.influence.T @ body.mass @ body.influence
        np.testing.assert_allclose(moment, body.mass_total * np.eye(3), atol=1e-12 * body.mass_total)
    tip = bodies_of("mandrel.base=free", symmetric=False)[0]
    np.testing.assert_allclose(
        tip.influence.T @ tip.mass @ tip.influence, tip.mass_total * np.eye(3), atol=1e-12 * tip.mass_total
    )


def test_symmetric_model_of_a_mesh_that_does_not_mirror_is_refused():
    case = lab()
    mesh = build_mesh(case)
    turn = np.array([[np.cos(0.1), np.sin(0.1), 0.0], [-np.sin(0.1), np.cos(0.1), 0.0], [0.0, 0.0, 1.0]])
    turned = CylinderMesh(mesh.nodes @ turn, mesh.cells, mesh.groups)
    with pytest.raises(InputError, match=r"solver\.symmetry"):
        assemble_bodies(case, turned, symmetric=True)
    upright = assemble_bodies(case, mesh, symmetric=False)[0]
    body = assemble_bodies(case, turned, symmetric=False)[0]
    np.testing.assert_allclose(
        solve_modes(body.stiffness, body.mass, 4)[0], solve_modes(upright.stiffness, upright.mass, 4)[0], rtol=1e-8
    )


def test_a_mesh_without_the_layers_of_the_case_is_refused():
    with pytest.raises(InputError, match=r"coil.layers: mesh lacks the shells layer_02; it has mandrel, layer_01"):
        assemble_bodies(lab("coil.layers=2"), build_mesh(lab()), symmetric=False)


# ---- traces ----------------------------------------------------------------------------------------------------------


def test_facing_surfaces_have_the_same_points_and_areas(whole, half):
    for bodies in (whole, half):
        for inner, outer in itertools.pairwise(bodies):
            a, b = inner.traces["outer"], outer.traces["inner"]
            np.testing.assert_allclose(a.points, b.points, rtol=0, atol=1e-12)
            np.testing.assert_allclose(a.areas, b.areas, rtol=1e-9)


def test_areas_sum_to_the_contact_cylinder(whole):
    for body, (_, radius, thickness) in zip(whole, shell_layout(lab("coil.layers=2")), strict=True):
        for side, r in (("inner", radius - thickness / 2), ("outer", radius + thickness / 2)):
            # twelve quadratic arcs are 7e-5 short of a circle
            assert body.traces[side].areas.sum() == pytest.approx(2 * np.pi * r * 0.3, rel=2e-4)
            np.testing.assert_allclose(body.traces[side].points[:, 2], r, rtol=1e-14)
            assert (body.traces[side].areas > 0).all()


def test_trace_has_the_local_components_of_a_rigid_motion_at_its_points():
    bodies = bodies_of(*FREE, "mesh.circumferential=24", symmetric=False)
    for body in bodies:
        for trace in body.traces.values():
            theta, z, r = trace.points.T
            motions = rigid_motions(body.nodes, np.zeros(3))
            zero = 0 * theta
            local = {
                0: [np.cos(theta), -np.sin(theta), zero],
                1: [np.sin(theta), np.cos(theta), zero],
                2: [zero, zero, zero + 1.0],
                3: [-z * np.sin(theta), -z * np.cos(theta), r * np.sin(theta)],
                5: [zero, r, zero],
            }
            for column, components in local.items():
                motion = (trace.operator @ motions[:, column]).reshape(-1, 3)
                # the normal component is averaged over hats along the axis: their mean height is not that of the point
                own = slice(1 if column == 3 else 0, 3)
                # around the circumference the points average to fourth order: 8e-5 with 24 cells
                np.testing.assert_allclose(motion[:, own], np.column_stack(components)[:, own], atol=1e-4)


def test_rigid_motions_open_no_gap_and_no_slip():
    bodies = bodies_of(*FREE, "coil.layers=2", symmetric=False)
    for inner, outer in itertools.pairwise(bodies):
        a = inner.traces["outer"].operator @ rigid_motions(inner.nodes, np.array([0.01, 0.02, 0.1]))
        b = outer.traces["inner"].operator @ rigid_motions(outer.nodes, np.array([0.01, 0.02, 0.1]))
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-14)


def test_local_frame_is_continuous_around_the_roll():
    body = bodies_of(*FREE, symmetric=False)[0]
    swell = np.zeros((len(body.nodes), 6))
    swell[:, :2] = body.nodes[:, :2] / np.hypot(body.nodes[:, 0], body.nodes[:, 1])[:, None]
    swirl = np.zeros_like(swell)
    swirl[:, 0], swirl[:, 1] = -swell[:, 1], swell[:, 0]
    for field, component in ((swell, 0), (swirl, 1)):
        motion = (body.traces["outer"].operator @ field.ravel()).reshape(-1, 3)
        np.testing.assert_allclose(motion[:, component], 1.0, atol=1e-3)
        np.testing.assert_allclose(np.delete(motion, component, axis=1), 0.0, atol=1e-9)


# ---- loads -----------------------------------------------------------------------------------------------------------


def ring_under_pressure(body, radius, thickness, E):
    """Radial displacement over p R^2 / (E t), per node, and axial strain over that hoop strain."""
    # self-equilibrated load on a free body: a touch of mass holds the rigid motions, which the load does not excite
    held = (body.stiffness + 1e2 * body.mass).tocsc()
    u = (body.expand @ spla.spsolve(held, body.pressure_force)).reshape(-1, 6)
    radial = np.einsum("ij,ij->i", u[:, :2], body.nodes[:, :2]) / radius
    expected = -(radius + thickness / 2) / radius * radius**2 / (E * thickness)
    strain_z = np.polyfit(body.nodes[:, 2], u[:, 2], 1)[0]
    return radial / expected, strain_z / (expected / radius)


@pytest.mark.parametrize("nu", [0.0, 0.35])
def test_uniform_pressure_on_a_free_ring_gives_the_hoop_displacement(nu):
    case = lab(*FREE, "mesh.circumferential=16", f"mandrel.material.nu={nu}", f"coil.material.nu={nu}")
    for body, (_, radius, thickness), E in zip(
        assemble_bodies(case, symmetric=False), shell_layout(case), (2.7e9, 2.8e9), strict=True
    ):
        assert np.abs(body.influence.T @ body.pressure_force).max() < 1e-12
        radial, axial = ring_under_pressure(body, radius, thickness, E)
        # shell theory of any kind is exact to nu t / R at a free end (the curvature of a swelling ring bends it)
        np.testing.assert_allclose(radial, 1.0, atol=1e-3 if nu == 0.0 else 0.6 * nu * thickness / radius)
        assert radial.mean() == pytest.approx(1.0, abs=2e-3)
        assert axial == pytest.approx(-nu, abs=1e-3)


# ---- eigenproblem ----------------------------------------------------------------------------------------------------


def test_constraints_leave_no_spurious_modes(whole):
    # equal Dirichlet diagonals in K and M would sit at lambda = 1, f = 0.159 Hz; count what lies below bending
    body = whole[0]
    values = solve_pairs(body.stiffness, body.mass, 6, DEFAULT_SHIFT).values
    assert np.sqrt(values[0]) / (2 * np.pi) > 150.0
    dense = np.sort(spla.eigsh(body.stiffness, 6, body.mass, sigma=-1e4, return_eigenvectors=False))
    np.testing.assert_allclose(values, dense, rtol=1e-8)


def test_modes_are_mass_normalised_and_converged(whole):
    body = whole[1]
    pairs = solve_pairs(body.stiffness, body.mass, 12, DEFAULT_SHIFT)
    np.testing.assert_allclose(pairs.vectors.T @ body.mass @ pairs.vectors, np.eye(12), atol=1e-9)
    assert pairs.residuals.max() < 1e-7
    assert (np.sqrt(np.abs(pairs.values[:6])) / (2 * np.pi) < 0.01).all()
    assert pairs.values[6] > 1e5


def test_a_missed_mode_is_counted(whole):
    body = whole[0]
    K, M = eigen._petsc(body.stiffness), eigen._petsc(body.mass)
    values = solve_pairs(body.stiffness, body.mass, 12, DEFAULT_SHIFT).values
    assert eigen._missed(K, M, values, 10, DEFAULT_SHIFT) == 0
    assert eigen._missed(K, M, np.delete(values, [1, 6]), 8, DEFAULT_SHIFT) == 2


def test_negative_stiffness_is_reported_not_hidden():
    K = sp.diags([-3.0e4, 1.0e5, 2.0e5, 3.0e5, 4.0e5]).tocsr()
    with pytest.raises(WrollError, match=r"1 negative eigenvalue\(s\), lowest -3.000e\+04"):
        solve_modes(K, sp.eye(5, format="csr"), 3)


def test_coupled_matrices_of_any_origin_give_their_known_frequencies():
    n = 60  # fixed-free chain of n equal masses and springs
    K = sp.diags([[-1.0] * (n - 1), [2.0] * (n - 1) + [1.0], [-1.0] * (n - 1)], [-1, 0, 1]).tocsr() * 1e6
    exact = 2 * np.sqrt(1e6) * np.sin((2 * np.arange(1, 6) - 1) * np.pi / (2 * (2 * n + 1))) / (2 * np.pi)
    frequencies, vectors = solve_modes(K, sp.eye(n, format="csr"), 5)
    np.testing.assert_allclose(frequencies, exact, rtol=1e-9)
    assert (vectors[np.abs(vectors).argmax(axis=0), range(5)] > 0).all()
    with pytest.raises(ValueError, match="got 61"):
        solve_modes(K, sp.eye(n, format="csr"), 61)


def test_bending_of_layers_can_be_switched_off():
    case = lab("coil.bending=false")
    assert shell_section(case, 1, 1e-3).bending == 0.0
    assert shell_section(case, 0, 1e-3).bending == 1.0
    on, off = (assemble_bodies(c, symmetric=True) for c in (lab(), case))
    assert abs(on[0].stiffness - off[0].stiffness).max() == 0.0
    soft, stiff = (solve_modes(b[1].stiffness, b[1].mass, 5)[0][3:] for b in (off, on))
    assert (soft < 0.2 * stiff).all()


def test_frequency_converges_with_the_mesh():
    found = []
    for circumferential, axial in ((12, 4), (16, 6), (24, 12)):
        mesh = make_cylinders([("mandrel", 0.03925)], 0.3, circumferential, axial)
        body = assemble_bodies(lab("coil.model=none"), mesh, symmetric=True)[0]
        found.append(solve_modes(body.stiffness, body.mass, 2)[0])
    bending, ovalling = np.array(found).T
    np.testing.assert_allclose(bending, 150.504, rtol=5e-4)  # measured 150.568, 150.515, 150.505; 48 x 24: 150.504
    assert (np.abs(np.diff(bending)) < [0.1, 0.02]).all()
    np.testing.assert_allclose(ovalling, 466.94, rtol=0.011)
