"""Semi-analytical shell: beam and membrane theory, solid elements, buckling of tubes and of a column."""

import numpy as np
import pytest
import scipy.sparse as sp
from support.paths import CONFIGS
from support.ritz_tube import SIMPLE, RitzTube, von_mises

from wroll_fem.bodies.tube import Tube
from wroll_fem.case import load_case
from wroll_fem.fem.eigen import solve_modes
from wroll_fem.fem.fourier_modes import symmetry_class_modes
from wroll_fem.fem.fourier_roll import BENDING, FourierRoll
from wroll_fem.fem.fourier_shell.geometric import GeometricStiffness
from wroll_fem.fem.fourier_shell.mandrel import ClampedMandrel, buckling_size, end_zone, graded_heights
from wroll_fem.fem.fourier_shell.model import FourierShellModel
from wroll_fem.fem.prestress.buckling import load_factors
from wroll_fem.fem.prestress.shell import PrestressedShell
from wroll_fem.fem.shell import ShellModel, ShellSection
from wroll_fem.mesh.generate import make_cylinders
from wroll_fem.numerics.linear import factorise

LONG = Tube(length=3.0, outer_radius=0.25, thickness=2.5e-3, E=70e9, nu=0.33, rho=2700.0, extra_mass=25.0)
SHORT = Tube(length=1.0, outer_radius=0.2, thickness=12.5e-3, E=70e9, nu=0.33, rho=2700.0, extra_mass=500.0)
SLENDER = Tube(length=4.0, outer_radius=0.2, thickness=12.5e-3, E=70e9, nu=0.33, rho=2700.0, extra_mass=500.0)
CAP = 1.3


def mandrel(tube, cells=160, tip_mass=0.0):
    return ClampedMandrel(FourierShellModel(cells), tube, graded_heights(tube, cells), tip_mass)


def uniform(tube, cells):
    return ClampedMandrel(FourierShellModel(cells), tube, np.linspace(0.0, tube.length, cells + 1))


def second_moment(tube):
    outer, inner = tube.outer_radius, tube.outer_radius - tube.thickness
    return np.pi / 4.0 * (outer**4 - inner**4)


def tension_and_shear(tube):
    """Bending flexibility and shear flexibility of the tip: L^3 / (3 E I), L / (k G A), m/N; k of Cowper."""
    shear = 2.0 * (1.0 + tube.nu) / (4.0 + 3.0 * tube.nu) * 0.5 * tube.E / (1.0 + tube.nu) * tube.area
    return tube.length**3 / (3.0 * tube.E * second_moment(tube)), tube.length / shear


# ---- static states ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("tube", [LONG, SLENDER], ids=["thin", "thick"])
def test_bending_stress_at_mid_span_is_that_of_a_beam(tube):
    """All three surfaces; measured within 0.3 %."""
    body = mandrel(tube, tip_mass=CAP)
    z, stress = body.model.surface_stress(body.under_acceleration(), 1)
    here = np.abs(z - 0.5 * tube.length).argmin()
    arm = tube.length - z[here]
    moment = (tube.mass + tube.extra_mass) / tube.length * arm**2 / 2.0 + CAP * arm
    for surface, side in enumerate((-1.0, 0.0, 1.0)):
        lever = tube.radius + 0.5 * side * tube.thickness
        expected = -moment * lever / second_moment(tube)  # compressed on the side to which the load points
        assert stress[surface, 0, here] == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("tube", [LONG, SHORT], ids=["thin", "thick"])
def test_hoop_stress_at_mid_span_is_that_of_a_ring(tube):
    """Middle: -p R_o / t. Faces: a strain of U / r without radial stress, so they differ by p / (1 - nu^2)."""
    body = mandrel(tube)
    z, stress = body.model.surface_stress(body.under_pressure(), 0)
    here = np.abs(z - 0.5 * tube.length).argmin()
    assert stress[1, 1, here] == pytest.approx(-tube.outer_radius / tube.thickness, rel=0.01)
    assert stress[0, 1, here] - stress[2, 1, here] == pytest.approx(-1.0 / (1.0 - tube.nu**2), rel=0.05)
    assert np.abs(stress[1, 0, here]) < 2e-3 * tube.outer_radius / tube.thickness  # no axial force


def test_the_clamped_edge_bends_as_a_beam_on_an_elastic_foundation():
    """Surface stress 6 M / t^2 with M = p / (2 beta^2) at a clamped edge (Timoshenko, section 114)."""
    body = mandrel(LONG)
    _, stress = body.model.surface_stress(body.under_pressure(), 0)
    expected = 3.0 / (LONG.edge_decay * LONG.thickness) ** 2
    assert stress[2, 0, 0] == pytest.approx(-stress[0, 0, 0], rel=0.02)
    assert abs(stress[2, 0, 0]) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("tube", [LONG, SHORT], ids=["thin", "thick"])
def test_tip_stiffness_is_that_of_a_shear_beam(tube):
    """The clamped base and the ring stiffen it: measured +0.2 % (thin) and +1.2 % (thick, length over radius 5)."""
    assert mandrel(tube).tip_stiffness() == pytest.approx(1.0 / sum(tension_and_shear(tube)), rel=0.02)


def test_loads_and_masses_are_those_of_the_tube():
    model = mandrel(LONG).model
    shift = model.translation()
    assert shift @ model.mass(1) @ shift == pytest.approx(LONG.mass + LONG.extra_mass, rel=1e-10)
    outward = np.tile([1.0, 0.0, 0.0, 0.0, 0.0], model.n_nodes)
    area = 2.0 * np.pi * LONG.outer_radius * LONG.length
    assert outward @ model.pressure_load() == pytest.approx(-area, rel=1e-10)


def test_the_free_tube_has_the_rigid_motions_and_no_other_zero_modes():
    """Two for wave number 0 (along the axis, about it), two for wave number 1 (sideways, about y), none beyond."""
    model = uniform(SHORT, 20).model
    for wave_number, count in ((0, 2), (1, 2), (2, 0), (3, 0)):
        values = np.linalg.eigvalsh(model.stiffness(wave_number).toarray())
        assert (np.abs(values) < 1e-9 * values[-1]).sum() == count, wave_number


def test_stresses_hardly_change_with_the_mesh():
    """80 or 320 cells: 2 % away from the ends, and at the clamped edge too."""
    for tube in (LONG, SHORT):
        peaks = []
        for cells in (80, 320):
            body = mandrel(tube, cells)
            z, bent = body.model.surface_stress(body.under_acceleration(), 1)
            pressed = body.model.surface_stress(body.under_pressure(), 0)[1]
            zone = end_zone(tube) * (1.0 - 1e-9)
            away = (z >= zone) & (z <= tube.length - zone)
            peaks.append([np.abs(s[:, 0][:, mask]).max() for s in (bent, pressed) for mask in (away, z >= 0.0)])
        np.testing.assert_allclose(peaks[0][0], peaks[1][0], rtol=0.02)
        np.testing.assert_allclose(peaks[0][1], peaks[1][1], rtol=0.02)
        np.testing.assert_allclose(peaks[0][3], peaks[1][3], rtol=0.02)


def test_bending_frequency_is_that_of_solid_elements():
    """Mandrel of `lab_mandrel` without tip ring in the solid model; a rigid ring in the shell: 1 %."""
    case = load_case(CONFIGS / "coiled_stiff.yaml", ["coil={model: none}", "mesh.discretisation=fourier"])
    g, m = case.geometry, case.mandrel.material
    solid = symmetry_class_modes(FourierRoll(case), BENDING, 1)[0].frequency_hz
    tube = Tube(g.length, 0.5 * g.mandrel_outer_diameter, g.mandrel_thickness, m.E, m.nu, m.rho)
    found = mandrel(tube, tip_mass=case.mandrel.tip_mass).bending_frequency()
    assert found == pytest.approx(solid, rel=0.01)


# ---- buckling --------------------------------------------------------------------------------------------------------


def simply_supported(tube, cells, waves):
    """Critical pressures (Pa) of a tube with ends that keep their shape and may warp, prestress -p R_o / t alone."""
    model = uniform(tube, cells).model
    geometric = GeometricStiffness(model)
    size = 5 * model.n_nodes
    free = np.ones((model.n_nodes, 5), bool)
    free[:, [1, 3]] = False
    free[0, 2] = False
    loose = sp.identity(size, format="csc")[:, free.ravel()]
    state = loose @ factorise((loose.T @ model.stiffness(0) @ loose).tocsr()).solve(loose.T @ model.pressure_load())
    held = np.ones((model.n_nodes, 5), bool)
    held[[0, -1]] = [False, False, True, False, True]
    ends = sp.identity(size, format="csc")[:, held.ravel()]
    found = {}
    for n in waves:
        weakening = geometric.stress_stiffness(state, 0, n, n) + geometric.pressure_stiffness(n)
        pair = ((ends.T @ matrix @ ends).tocsr() for matrix in (model.stiffness(n), weakening))
        found[n] = float(load_factors(*pair, 1)[0][0])
    return found


@pytest.mark.parametrize(("length", "thickness", "waves"), [(0.1, 0.25e-3, 6), (0.3, 0.15e-3, 4)])
def test_simply_supported_tubes_buckle_at_the_pressure_of_von_mises(length, thickness, waves):
    """Closed double Fourier solution to 1 %, with its wave number; the Ritz solution of the shell to 0.5 %."""
    tube = Tube(length, 0.04, thickness, 2.7e9, 0.35, 1200.0)
    section = ShellSection(E=tube.E, nu=tube.nu, rho=tube.rho, thickness=thickness)
    closed = {n: von_mises(section, tube.radius, length, n) for n in range(2, 10)}
    found = simply_supported(tube, 60, range(2, 10))
    assert min(found, key=lambda n: found[n]) == min(closed, key=lambda n: closed[n]) == waves
    on_outer = tube.outer_radius / tube.radius  # the pressure acts on the outer surface
    assert found[waves] * on_outer == pytest.approx(closed[waves], rel=0.01)
    ritz = RitzTube(section, tube.radius, length, SIMPLE, 24).critical_pressure(waves)
    assert found[waves] * on_outer == pytest.approx(ritz, rel=0.005)


def test_a_rigid_rotation_costs_what_the_forces_of_any_axisymmetric_state_lose():
    """Rotation W about y moves a point by W x r + W x (W x r) / 2; the stresses of a thick tube do no work in it."""
    tube = Tube(0.3, 0.1, 0.02, 70e9, 0.3, 2700.0)
    model = uniform(tube, 12).model
    z, one = np.linspace(0.0, tube.length, model.n_nodes), np.ones(model.n_nodes)
    state = np.random.default_rng(3).standard_normal((model.n_nodes, 5))
    state[:, [1, 3]] = 0.0  # no torsion
    turned = np.stack([z, -z, -tube.radius * one, 0.0 * z, -one], axis=1).ravel()
    second = np.stack([-tube.radius / 4.0 * one, 0.0 * z, -z / 2.0, 0.0 * z, 0.0 * z], axis=1).ravel()
    work = turned @ GeometricStiffness(model).stress_stiffness(state.ravel(), 0, 1, 1) @ turned
    assert work == pytest.approx(-2.0 * second @ model.stiffness(0) @ state.ravel(), rel=1e-9)


def test_a_long_tube_under_axial_force_is_a_column_of_euler():
    """Wave number 1, dead force on the rigid tip, with the shear of the tube: 0.5 %."""
    tube = Tube(3.0, 0.1, 5e-3, 70e9, 0.33, 2700.0)
    model = uniform(tube, 80).model
    expand = model.cantilever(0)
    load = np.zeros(expand.shape[1])
    load[-2] = -1.0
    state = expand @ factorise((expand.T @ model.stiffness(0) @ expand).tocsr()).solve(load)
    expand = model.cantilever(1)
    pair = (model.stiffness(1), GeometricStiffness(model).stress_stiffness(state, 0, 1, 1))
    found = load_factors(*((expand.T @ matrix @ expand).tocsr() for matrix in pair), 1)[0][0]
    euler = np.pi**2 * tube.E * second_moment(tube) / (4.0 * tube.length**2)
    shear = tube.length / tension_and_shear(tube)[1]
    assert found == pytest.approx(euler / (1.0 + euler / shear), rel=0.005)


def test_stresses_that_vary_around_couple_wave_numbers_as_in_a_shell_of_quadrilaterals():
    """Second-order energy of smooth fields, state of wave number 1, motion of wave numbers 2 and 3: 2 % (t/R 1 %)."""
    tube = Tube(0.2, 0.1005, 1e-3, 70e9, 0.3, 2700.0)
    model = uniform(tube, 24).model
    z = np.linspace(0.0, tube.length, model.n_nodes)
    part = make_cylinders([("tube", tube.radius)], tube.length, 64, 12).part("tube")
    section = ShellSection(E=tube.E, nu=tube.nu, rho=tube.rho, thickness=tube.thickness)
    rng = np.random.default_rng(7)
    polynomials = {n: rng.standard_normal((5, 4)) * [[1], [1], [1], [8], [8]] for n in (1, 2, 3)}

    def amplitudes(n, at):
        return np.array([np.polyval(p, at / tube.length) for p in polynomials[n]])

    def nodal(n):
        theta = np.arctan2(part.nodes[:, 1], part.nodes[:, 0])
        U, V, W, B, A = amplitudes(n, part.nodes[:, 2])
        c, s = np.cos(n * theta), np.sin(n * theta)
        radial, hoop, turn_hoop = U * c, V * s, -A * c
        x, y = np.cos(theta), np.sin(theta)
        rotation = [-turn_hoop * y, turn_hoop * x, B * s]
        return np.stack([radial * x - hoop * y, radial * y + hoop * x, W * c, *rotation], axis=1).ravel()

    shell = PrestressedShell(ShellModel(part.nodes, part.cells), section)
    motion = nodal(2) + nodal(3)
    expected = motion @ shell.geometric_stiffness(nodal(1)) @ motion
    geometric = GeometricStiffness(model)
    fields = {n: amplitudes(n, z).T.ravel() for n in (1, 2, 3)}
    found = sum(
        fields[test] @ geometric.stress_stiffness(fields[1], 1, test, trial) @ fields[trial]
        for test in (2, 3)
        for trial in (2, 3)
    )
    assert found == pytest.approx(expected, rel=0.02)


@pytest.mark.slow
def test_bending_buckles_the_compressed_side_of_a_tube_at_the_classical_stress():
    """Largest membrane stress at buckling over 0.605 E t / R (nu = 0.3): 1 to 1.2, for the ends help."""
    tube = Tube(0.6, 0.1, 1.2e-3, 70e9, 0.3, 2700.0)
    cells, waves, resolved = buckling_size(tube, 40)
    assert resolved
    body = uniform(tube, cells)
    buckling = body.combined_buckling(0.0, 1.0, waves)
    stress = np.abs(body.model.surface_stress(body.under_acceleration(), 1)[1][1, 0]).max()
    ratio = buckling.factor * stress / (0.605 * tube.E * tube.thickness / tube.radius)
    assert 1.0 < ratio < 1.2
    finer = uniform(tube, int(1.3 * cells)).combined_buckling(0.0, 1.0, waves + 5)
    assert buckling.factor == pytest.approx(finer.factor, rel=2e-3)


def test_pressure_alone_buckles_at_the_same_load_in_both_searches():
    body = uniform(LONG, 80)
    alone = body.pressure_buckling(12)
    coupled = body.combined_buckling(1.0, 0.0, 8)
    assert (alone.waves, alone.factor) == (coupled.waves, pytest.approx(coupled.factor, rel=1e-8))


def test_without_supports_the_frequency_of_the_ring_is_zero():
    model = uniform(SHORT, 20).model
    shift = 1.0  # (rad/s)^2
    found = solve_modes(model.stiffness(1), model.mass(1), 2, -shift)[0]
    assert found.max() < 1e-2
