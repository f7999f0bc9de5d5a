"""The curved-quad shell against reference solutions, beam theory and solids."""

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from support.beam_theory import beam_frequency, beam_tip_deflection
from support.shell_patches import mask, patch, solve_static

from wroll_fem.errors import WrollError
from wroll_fem.fem import compat
from wroll_fem.fem.constraints import build_constraints, rigid_motions
from wroll_fem.fem.eigen import solve_modes
from wroll_fem.fem.shell import ShellModel, ShellSection
from wroll_fem.fem.solid import SolidModel, thicken
from wroll_fem.mesh.generate import make_cylinders

LAB = ShellSection(E=2.7e9, nu=0.35, rho=1200.0, thickness=1.5e-3)
RADIUS, LENGTH = 0.03925, 0.3


def normal_to_y_axis(points):
    d = points * [1.0, 0.0, 1.0]
    return d / np.linalg.norm(d, axis=1)[:, None]


def flat(points):
    return np.broadcast_to([0.0, 0.0, 1.0], points.shape).copy()


def tube(circumferential, axial, section=LAB, radius=RADIUS, length=LENGTH):
    part = make_cylinders([("mandrel", radius)], length, circumferential, axial).part("mandrel")
    return part, ShellModel(part.nodes, part.cells)


# ---- benchmarks of shell theory ------------------------------------------------------------------------------------


def scordelis_lo(n):
    """Mid-side deflection of the free edge; roof under its own weight, a quarter of it."""
    radius, half_length, half_angle = 25.0, 25.0, np.radians(40)
    nodes, cells, s, t = patch(
        lambda s, t: (radius * np.sin(half_angle * s), half_length * t, radius * np.cos(half_angle * s)), n, n
    )
    model = ShellModel(nodes, cells, normal_to_y_axis)
    fixed = mask(len(nodes), (t == 0, [1, 3, 5]), (t == 1, [0, 2, 4]), (s == 0, [0, 4, 5]))
    load = model.area_load(np.array([0.0, 0.0, -90.0]))
    u = solve_static(model.stiffness(ShellSection(4.32e8, 0.0, 1.0, 0.25)), load, fixed).reshape(-1, 6)
    return -u[(s == 1) & (t == 0), 2].item()


def pinched_cylinder(n):
    """Deflection under the load; diaphragms at both ends, an eighth of the cylinder."""
    radius, half_length = 300.0, 300.0
    nodes, cells, s, t = patch(
        lambda s, t: (radius * np.sin(np.pi / 2 * s), half_length * t, radius * np.cos(np.pi / 2 * s)), n, n
    )
    model = ShellModel(nodes, cells, normal_to_y_axis)
    fixed = mask(len(nodes), (t == 0, [1, 3, 5]), (t == 1, [0, 2, 4]), (s == 0, [0, 4, 5]), (s == 1, [2, 3, 4]))
    dof = 6 * np.flatnonzero((s == 0) & (t == 0)).item() + 2
    force = np.zeros(6 * len(nodes))
    force[dof] = -0.25
    return -solve_static(model.stiffness(ShellSection(3e6, 0.3, 1.0, 3.0)), force, fixed)[dof]


def test_scordelis_lo_roof_agrees_with_the_reference():
    # 0.3024 is the deep-shell benchmark value; shear-flexible shells converge to about 0.3013, hence 1 %
    assert scordelis_lo(8) / 0.3024 == pytest.approx(1.0, abs=0.01)
    assert scordelis_lo(4) / scordelis_lo(8) == pytest.approx(1.0, abs=0.005)


def test_pinched_cylinder_converges_without_locking():
    # measured 0.937, 0.986, 1.008; full integration gives 0.16, 0.57, 0.91
    ratios = [pinched_cylinder(n) / 1.8248e-5 for n in (4, 8, 16)]
    np.testing.assert_allclose(ratios, [0.937, 0.986, 1.008], atol=0.003)


# ---- consistency ---------------------------------------------------------------------------------------------------


def distorted_plate():
    """Unit square of 3 x 3 straight-sided, visibly distorted quads."""

    def surface(s, t):
        bump = 16 * s * (1 - s) * t * (1 - t)
        return s + 0.12 * bump * np.sin(5 * t + 1), t - 0.10 * bump * np.cos(4 * s), 0 * s

    nodes, cells, s, t = patch(surface, 3, 3)
    for cell in cells:  # straight edges: quadratic fields in x, y then lie in the Q2 space
        a, b, c, d = cell[:4]
        for middle, ends in zip(cell[4:], [(a, b), (b, c), (c, d), (d, a), (a, b, c, d)], strict=True):
            nodes[middle] = nodes[list(ends)].mean(axis=0)
    border = (s == 0) | (s == 1) | (t == 0) | (t == 1)
    return nodes, cells, border


@pytest.mark.parametrize("thickness", [0.1, 1e-3])
def test_constant_membrane_strain_is_reproduced_on_a_distorted_mesh(thickness):
    nodes, cells, border = distorted_plate()
    model = ShellModel(nodes, cells, flat)
    x, y, _ = nodes.T
    exact = np.zeros((len(nodes), 6))
    exact[:, 0], exact[:, 1] = 1e-3 * x + 4e-4 * y, 2e-4 * x - 3e-4 * y
    exact[:, 5] = (2e-4 - 4e-4) / 2
    K = model.stiffness(ShellSection(1e9, 0.3, 1.0, thickness))
    u = solve_static(K, np.zeros(exact.size), mask(len(nodes), (border, range(6))), exact.ravel())
    np.testing.assert_allclose(u.reshape(-1, 6), exact, atol=1e-11)


@pytest.mark.parametrize("thickness", [0.1, 1e-3])
def test_constant_curvature_is_reproduced_on_a_distorted_mesh(thickness):
    nodes, cells, border = distorted_plate()
    model = ShellModel(nodes, cells, flat)
    x, y, _ = nodes.T
    exact = np.zeros((len(nodes), 6))
    exact[:, 2] = 1e-3 * (0.5 * x**2 + 0.3 * x * y - 0.2 * y**2)
    exact[:, 3] = 1e-3 * (0.3 * x - 0.4 * y)  # theta_x = dw/dy, theta_y = -dw/dx
    exact[:, 4] = -1e-3 * (x + 0.3 * y)
    section = ShellSection(1e9, 0.3, 1.0, thickness)
    K = model.stiffness(section)
    u = solve_static(K, np.zeros(exact.size), mask(len(nodes), (border, range(6))), exact.ravel())
    np.testing.assert_allclose(u.reshape(-1, 6), exact, atol=1e-11)
    # kappa = -[[w_xx, w_xy], [w_xy, w_yy]], energy = D/2 ((1 - nu) kappa : kappa + nu tr(kappa)^2) on unit area
    kappa = 1e-3 * np.array([[1.0, 0.3], [0.3, -0.4]])
    D = 1e9 * thickness**3 / 12 / (1 - 0.09)
    energy = 0.5 * D * (0.7 * np.sum(kappa**2) + 0.3 * np.trace(kappa) ** 2)
    assert 0.5 * u @ K @ u == pytest.approx(energy, rel=1e-7)


def test_constant_transverse_shear_stores_five_sixths_of_its_energy():
    nodes, cells, _ = distorted_plate()
    model = ShellModel(nodes, cells, flat)
    field = np.zeros((len(nodes), 6))
    field[:, 2], field[:, 4] = 1e-3 * nodes[:, 0], 4e-4  # gamma_xz = dw/dx + theta_y
    K, G = model.stiffness(ShellSection(1e9, 0.3, 1.0, 0.1)), 1e9 / 2.6
    assert field.ravel() @ K @ field.ravel() == pytest.approx(5 / 6 * G * 0.1 * 1.4e-3**2, rel=1e-9)


def test_free_tube_has_exactly_six_zero_modes_and_the_others_converge():
    spectra = []
    for circumferential, axial in ((12, 4), (20, 8)):
        part, model = tube(circumferential, axial)
        K, M = model.stiffness(LAB), model.mass(LAB)
        frequencies, _ = solve_modes(K, M, 14)
        assert (frequencies[:6] < 0.01).all()
        spectra.append(frequencies[6:])
        motions = rigid_motions(part.nodes, np.array([0.0, 0.0, 0.15]))
        strain = np.einsum("ij,ij->j", motions, K @ motions)
        assert np.abs(strain).max() < 1e-12 * K.diagonal().max() * np.einsum("ij,ij->j", motions, motions).max()
    assert spectra[0].min() > 150.0
    # measured differences 0.03 % to 1.0 %
    np.testing.assert_allclose(spectra[0], spectra[1], rtol=0.015)
    # Rayleigh's inextensional mode n = 2 of a free tube (uniform along z), Love (1927) article 233
    n, plane = 2, LAB.E / (1 - LAB.nu**2)
    rayleigh = n * (n**2 - 1) / np.sqrt(n**2 + 1) * np.sqrt(plane * LAB.thickness**2 / 12 / LAB.rho) / RADIUS**2
    assert spectra[1][0] == pytest.approx(rayleigh / (2 * np.pi), rel=0.015)


def test_a_layer_without_bending_has_no_zero_modes_but_the_six():
    _, model = tube(12, 2)
    section = ShellSection(2.8e9, 0.35, 2000.0, 1.25e-3, bending=0.0)
    K, M = model.stiffness(section).toarray(), model.mass(section).toarray()
    full = model.stiffness(ShellSection(2.8e9, 0.35, 2000.0, 1.25e-3)).toarray()
    values = la.eigh(K, M, eigvals_only=True)
    assert (np.abs(values[:6]) < 1e-2).all()
    assert values[6] > 1e2
    # the soft ones come as a membrane's: four inextensional modes per wave number, no others (checkerboards) below
    # the first membrane frequency; n = 2 ... 5 on this mesh
    soft = np.sqrt(values[6:22]) / (2 * np.pi)
    stiff = np.sqrt(la.eigh(full, M, eigvals_only=True)[6:10]) / (2 * np.pi)
    assert soft[0] < 0.2 * stiff[0]
    np.testing.assert_allclose(soft.reshape(-1, 4).max(axis=1), soft.reshape(-1, 4).min(axis=1), rtol=0.2)


# ---- a cantilever tube: beam theory and solids -----------------------------------------------------------------------


def cantilever(section, radius, length, circumferential, axial, tip_mass=0.0):
    """Reduced K, M and the column of U_x of a clamped tube with a rigid tip."""
    part, model = tube(circumferential, axial, section, radius, length)
    c = build_constraints(
        part.nodes, clamped=part.groups["base"], rigid=part.groups["tip"], centre=np.array([0.0, 0.0, length])
    )
    K = (c.expand.T @ model.stiffness(section) @ c.expand).tocsr()
    M = (c.expand.T @ model.mass(section) @ c.expand).tolil()
    for column in c.master[:3]:
        M[column, column] += tip_mass
    return K, M.tocsr(), int(c.master[0])


def test_cantilever_tube_agrees_with_timoshenko_beam():
    # Poisson's ratio 0 keeps the clamped base and the rigid tip from squeezing the section, as beam theory assumes
    # measured: deflection +0.018 % and +0.032 %, frequency -0.015 % both
    section = ShellSection(2.7e9, 0.0, 1200.0, 1.5e-3)
    for length, tolerance in ((0.3, 5e-4), (0.8, 5e-4)):
        K, M, column = cantilever(section, RADIUS, length, 16, 8, tip_mass=0.05)
        force = np.zeros(K.shape[0])
        force[column] = 1.0
        deflection = spla.spsolve(K.tocsc(), force)[column]
        assert deflection == pytest.approx(beam_tip_deflection(section, RADIUS, length), rel=tolerance)
        frequency = solve_modes(K, M, 1)[0][0]
        assert frequency == pytest.approx(beam_frequency(section, RADIUS, length, 0.05), rel=tolerance)


@pytest.mark.slow
def test_cantilever_tube_agrees_with_27_node_solids():
    part = make_cylinders([("mandrel", RADIUS)], LENGTH, 16, 8).part("mandrel")
    nodes, cells = thicken(part.nodes, part.cells, LAB.thickness * np.array([-0.5, 0.0, 0.5]))
    solid = SolidModel(nodes, cells)
    n = len(part.nodes)
    base = np.concatenate([part.groups["base"] + k * n for k in range(3)])
    tip = np.concatenate([part.groups["tip"] + k * n for k in range(3)])
    # the rigid-tip map on translations only: rotations of the six-component map are dropped
    c = build_constraints(nodes, clamped=base, rigid=tip, centre=np.array([0.0, 0.0, LENGTH]))
    translations = np.flatnonzero(np.arange(6 * len(nodes)) % 6 < 3)
    E = c.expand[translations]
    used = np.flatnonzero(np.diff(E.tocsc().indptr))
    E = E[:, used]
    K = (E.T @ solid.stiffness(LAB.E, LAB.nu) @ E).tocsr()
    extra = np.isin(used, c.master[:3]) * 0.05
    M = (E.T @ solid.mass(LAB.rho) @ E + sp.diags(extra)).tocsr()
    column = np.flatnonzero(used == c.master[0]).item()
    force = np.zeros(K.shape[0])
    force[column] = 1.0

    K_shell, M_shell, column_shell = cantilever(LAB, RADIUS, LENGTH, 16, 8, tip_mass=0.05)
    force_shell = np.zeros(K_shell.shape[0])
    force_shell[column_shell] = 1.0
    deflection = spla.spsolve(K.tocsc(), force)[column]
    shell_deflection = spla.spsolve(K_shell.tocsc(), force_shell)[column_shell]
    assert shell_deflection == pytest.approx(deflection, rel=2e-3)
    solid_modes, shell_modes = solve_modes(K, M, 8)[0], solve_modes(K_shell, M_shell, 8)[0]
    # measured: bending 150.50 and 150.60 Hz, ovalling-2 467.7 and 468.0 Hz
    # bending pair, ovalling-2 pair, ovalling-3 pair, torsion, ovalling-3
    np.testing.assert_allclose(shell_modes[:2], solid_modes[:2], rtol=1e-3)
    np.testing.assert_allclose(shell_modes, solid_modes, rtol=0.01)


def test_mass_matrix_holds_the_mass_and_the_extra_mass():
    part, model = tube(12, 4)
    M = model.mass(ShellSection(2.7e9, 0.35, 1200.0, 1.5e-3, extra_mass=0.7))
    motion = rigid_motions(part.nodes, np.zeros(3))[:, 0]
    assert motion @ M @ motion == pytest.approx((1200 * 1.5e-3 + 0.7) * model.area, rel=1e-12)
    assert model.area == pytest.approx(2 * np.pi * RADIUS * LENGTH, rel=1e-4)


def test_complex_scalars_are_refused(monkeypatch):
    monkeypatch.setattr(compat.PETSc, "ScalarType", np.complex128)
    with pytest.raises(WrollError, match="real build"):
        tube(8, 2)
