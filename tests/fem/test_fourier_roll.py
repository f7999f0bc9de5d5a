"""Fourier elements of the roll against beam theory, shells and solids; their modes and shear stress."""

import dataclasses

import numpy as np
import pytest
from support.beam_theory import beam_frequency
from support.fourier_rolls import RHO, WEB, E, L, case, kapton, model

from wroll_fem.analyses.slip_model import shear_modes
from wroll_fem.coiled_stiff.fourier_stress import shear_amplitudes
from wroll_fem.coiled_stiff.frequency_bounds import fundamental, softest_coil
from wroll_fem.errors import InputError
from wroll_fem.fem.fourier_modes import lowest_modes, symmetry_class_modes
from wroll_fem.fem.fourier_roll import AXIAL, BENDING, TORSION, FourierRoll, SymmetryClass, symmetry_classes
from wroll_fem.fem.shell import ShellSection
from wroll_fem.mesh.axisymmetric import refined_mesh, split_ends
from wroll_fem.mesh.revolve import cartesian, revolve

# ---- rolls ---------------------------------------------------------------------------------------------------------


def test_free_roll_has_the_six_rigid_motions_alone():
    free = case("mandrel.base=free", "mandrel.tip=free", "mandrel.tip_mass=0.0", coil=kapton())
    roll = FourierRoll(free)
    for m, kinds in ((0, ["axial", "torsion"]), (1, ["x", "tilt"]), (2, []), (3, [])):
        found = [mode for f in symmetry_classes(m) for mode in symmetry_class_modes(roll, f, 3)]
        assert sum(mode.kind == "rigid" for mode in found) == len(kinds)
        assert max([mode.frequency_hz for mode in found if mode.kind == "rigid"], default=0.0) < 0.05
        assert min(mode.frequency_hz for mode in found if mode.kind != "rigid") > 100.0


def test_thin_and_thick_tubes_bend_like_a_timoshenko_beam():
    # free tip without Poisson effect at the clamp (nu = 0): what is left is the beam's own approximation
    for t, tolerance in ((1e-3, 1e-3), (4e-3, 1e-3)):
        tube = case(
            "mandrel.material.nu=0.0", "mandrel.tip=rigid", f"geometry.mandrel_thickness={t}",
            "geometry.mandrel_outer_diameter=0.04",
        )  # fmt: skip
        found = symmetry_class_modes(FourierRoll(tube), BENDING, 1)[0].frequency_hz
        beam = beam_frequency(ShellSection(E, 0.0, RHO, t), 0.02 - t / 2, L, 0.05)
        assert found == pytest.approx(beam, rel=tolerance)


def test_lab_mandrel_agrees_with_the_shells():
    # shells, 48 x 24 cells (docs/verification.md): 150.504 Hz; others from configs/lab_mandrel.yaml
    roll = FourierRoll(case())
    modes = lowest_modes(roll, 12)
    kinds = [mode.kind for mode in modes]
    assert kinds == ["bending", "ovalling-2", "ovalling-3", "torsion", "ovalling-3", "bending", "axial"]
    shells = [150.504, 467.19, 597.49, 760.87, 808.99, 833.77, 923.86]
    np.testing.assert_allclose([mode.frequency_hz for mode in modes], shells, rtol=1e-3)
    assert roll.mass_total == pytest.approx(0.1831715, rel=1e-5)
    assert modes[0].participation ** 2 / roll.mass_total == pytest.approx(0.6919, abs=3e-4)
    assert modes[0].tip * modes[0].participation == pytest.approx(1.219, abs=1e-3)
    assert modes[-1].participation ** 2 / roll.mass_total == pytest.approx(0.8178, abs=3e-4)


def test_the_fundamental_mode_may_lie_in_a_high_harmonic():
    # wide and thin: ovalling-2 lies above bending, ovalling-5 far below
    roll = FourierRoll(case("geometry.mandrel_outer_diameter=0.16", "geometry.mandrel_thickness=0.5e-3"))
    lowest = {m: min(symmetry_class_modes(roll, f, 1)[0].frequency_hz for f in symmetry_classes(m)) for m in range(11)}
    expected = min(lowest, key=lowest.__getitem__)
    assert lowest[2] > lowest[1] > lowest[expected]
    assert fundamental(roll).kind == f"ovalling-{expected}"
    assert fundamental(roll).frequency_hz == pytest.approx(lowest[expected])


def test_effective_masses_add_up():
    roll = FourierRoll(case("mandrel.tip=free", coil=kapton()))
    for family in (BENDING, AXIAL):
        system = roll.matrices(family)
        moved = system.influence @ system.mass @ system.influence
        everything = symmetry_class_modes(roll, family, 60)
        assert sum(mode.participation**2 for mode in everything) == pytest.approx(moved, rel=0.02)
        assert moved < roll.mass_total


def test_thin_walls_do_not_lock():
    # cubic cells on 8 and 24 axial cells, wall from 1/10 to 1/100 of the radius; one and three cells through it
    for t in (4e-3, 1e-3, 0.4e-3):
        coarse = FourierRoll(case(f"geometry.mandrel_thickness={t}"))
        fine = FourierRoll(case(f"geometry.mandrel_thickness={t}", "mesh.axial=24"))
        for family in (BENDING, SymmetryClass(2, (0, 1, 2)), SymmetryClass(3, (0, 1, 2))):
            a, b = (symmetry_class_modes(roll, family, 1)[0].frequency_hz for roll in (coarse, fine))
            assert a == pytest.approx(b, rel=1e-3)


def test_coil_models_rank_as_they_should():
    f = {}
    for name, coil in {
        "solid": kapton(), "soft": kapton(G_r_theta=1e4, G_r_z=1e4), "mass": kapton("nonstructural_mass"),
        "none": {"model": "none"},
    }.items():  # fmt: skip
        roll = FourierRoll(case(coil=coil))
        f[name] = symmetry_class_modes(roll, BENDING, 1)[0].frequency_hz
    assert f["mass"] < f["soft"] < f["none"] < f["solid"]


def test_bonded_layers_are_an_isotropic_solid_coil():
    material = {"E": 2.8e9, "nu": 0.35, "rho": 2000.0}
    bonded = {"model": "bonded", "layers": 2, "total_thickness": 1.25e-3, "material": material}
    solid = {"model": "solid", "thickness": 1.25e-3, "material": material}
    a, b = (
        symmetry_class_modes(FourierRoll(case("mesh.radial=2", coil=coil)), BENDING, 1)[0].frequency_hz
        for coil in (bonded, solid)
    )
    assert a == pytest.approx(b, rel=1e-10)
    clamped, edge = (
        symmetry_class_modes(FourierRoll(case(coil=bonded | {"base": base})), BENDING, 1)[0].frequency_hz
        for base in ("clamped", "inner_edge")
    )
    assert a < edge < clamped


def test_layers_with_friction_are_refused():
    layers = {"model": "layers", "layers": 1, "total_thickness": 1e-3, "material": {"E": 1e9, "nu": 0.3, "rho": 1e3}}
    with pytest.raises(InputError, match="solid"):
        FourierRoll(case("mesh.discretisation=three_dimensional", coil=layers))


# ---- what is made of the modes -------------------------------------------------------------------------------------


def test_displacements_on_the_revolved_skin():
    outline = np.array([[1.0, 0.0], [1.5, 0.0], [2.0, 0.0], [2.0, 1.5], [2.0, 3.0], [1.0, 1.5]])
    nodes, cells = revolve(outline, 8)
    assert nodes.shape == (6 * 16, 3)
    assert cells.shape == (3 * 8, 9)
    assert np.array_equal(np.unique(cells), np.arange(len(nodes)))
    shift = cartesian(np.tile([1.0, -1.0, 0.0], (6, 1)), 1, 8)
    np.testing.assert_allclose(shift, np.tile([1.0, 0.0, 0.0], (len(nodes), 1)), atol=1e-14)
    rotated = cartesian(np.tile([1.0, -1.0, 0.0], (6, 1)), 1, 8, rotated=True)
    np.testing.assert_allclose(rotated, np.tile([0.0, 1.0, 0.0], (len(nodes), 1)), atol=1e-14)
    spin = cartesian(outline[:, [0]] * [0.0, 1.0, 0.0], 0, 8)
    np.testing.assert_allclose(spin, np.cross([0.0, 0.0, 1.0], nodes), atol=1e-14)


def test_shear_stress_of_a_known_field():
    made = model()
    r, z = made.nodes.T
    # U = r z, V = r^2, W = r^2 z with m = 1: rz = r + 2 r z, tz = -r z, rt = 2 r - (r^2 + r z) / r
    values = np.column_stack([r * z, r**2, r**2 * z])
    points = np.random.default_rng(3).uniform([0.02, 0.0], [0.03, L], (40, 2))
    srz, srt = shear_amplitudes(made, values, WEB, 1, points)
    R, Z = points.T
    np.testing.assert_allclose(srz, 0.5e9 * (R + 2 * R * Z), rtol=1e-9)
    np.testing.assert_allclose(srt, 0.3e9 * (R - Z), rtol=1e-8, atol=1.0)


def test_shear_modes_lie_along_the_excitation():
    coil = kapton(G_r_theta=1e6, G_r_z=1e6)
    along_x = shear_modes(case("mesh.circumferential=8", "mesh.axial=4", coil=coil))
    t = along_x.points[:, 0]
    assert along_x.volumes.sum() == pytest.approx(np.pi * (0.04125**2 - 0.04**2) * L, rel=1e-12)
    assert t.min() > -np.pi
    assert t.max() == pytest.approx(np.pi)
    assert abs(t[np.abs(along_x.srz[0]).argmax()]) % np.pi < 1e-12
    assert np.abs(t[np.abs(along_x.srt[0]).argmax()]) == pytest.approx(np.pi / 2)
    roll = FourierRoll(case("mesh.axial=4", coil=coil))
    first = symmetry_class_modes(roll, BENDING, 1)[0]
    assert along_x.frequencies_hz[0] == pytest.approx(first.frequency_hz)
    assert along_x.mass_total == pytest.approx(roll.mass_total)
    assert set(along_x.kinds) == {"bending"}
    with pytest.raises(InputError, match="none of the lowest 1 modes has effective mass along the excitation"):
        # the coil's own shear
        shear_modes(case("mesh.axial=4", "modal.count=1", coil=kapton(G_r_theta=300, G_r_z=300)))


def test_shear_and_bending_frequencies_meet_at_the_softest_coil():
    roll = FourierRoll(case("mesh.axial=4", coil=kapton()))
    tight = case(coil=kapton()).coil.solid()
    found = softest_coil(roll, tight)
    assert found.competing_kind == "torsion"
    torsion = symmetry_class_modes(roll, TORSION, 1)[0].frequency_hz
    assert torsion == pytest.approx(found.bending.frequency_hz, rel=1e-4)
    # a soft ring on a stiff wall: a quarter wave through its thickness
    assert torsion == pytest.approx(np.sqrt(found.shear_modulus / 1400.0) / (4 * 1.25e-3), rel=0.05)
    roll.set_coil(dataclasses.replace(tight, G_r_theta=0.9 * found.shear_modulus, G_r_z=0.9 * found.shear_modulus))
    assert fundamental(roll).kind == "torsion"


def test_a_coil_clamped_at_its_base_may_be_as_loose_as_it_likes():
    # at G = 0 it is a cantilever tube of its own, whose torsion is not slow
    coil = kapton() | {"base": "clamped"}
    roll = FourierRoll(case("mesh.axial=4", coil=coil))
    found = softest_coil(roll, case(coil=coil).coil.solid())
    assert found.competing_kind == ""
    assert found.shear_modulus == pytest.approx(1.0)
    assert found.bending.frequency_hz < found.stiffest.frequency_hz


def test_no_softest_coil_if_bending_is_never_the_fundamental_mode():
    # a free tip lets the thin wide tube become oval first
    wide = case("geometry.mandrel_outer_diameter=0.14", "mandrel.tip=free", coil=kapton())
    assert softest_coil(FourierRoll(wide), wide.coil.solid()) is None


def test_split_ends_keep_the_borders():
    heights = split_ends(np.array([0.0, 0.1, 0.2, 0.4]), 1e-3)
    assert np.all(np.diff(heights) > 0)
    assert {0.0, 0.1, 0.2, 0.4} <= set(heights)
    assert np.diff(heights)[0] == pytest.approx(1e-3)


def test_a_model_moves_to_another_geometry():
    a, b = case(), case("geometry.mandrel_outer_diameter=0.05", "geometry.mandrel_thickness=3.0e-3")
    roll = FourierRoll(a)
    symmetry_class_modes(roll, BENDING, 1)
    model = roll.model
    moved = symmetry_class_modes(FourierRoll(b, model), BENDING, 1)[0].frequency_hz
    assert moved == pytest.approx(symmetry_class_modes(FourierRoll(b), BENDING, 1)[0].frequency_hz, rel=1e-12)
    with pytest.raises(ValueError, match="does not fit"):
        model.move(refined_mesh(case("mesh.axial=9")))


@pytest.mark.slow
def test_solid_coil_in_three_dimensions_has_the_same_frequencies_and_shear():
    # the case study of section 2.4; two discretisations with nothing in common but the material
    coil = kapton(E_theta=10e9, E_z=5e9, E_r=0.1e9, nu_theta_z=0.3, nu_theta_r=0.3, nu_z_r=0.3, rho=1600.0)
    coil["material"] |= {"G_z_theta": 1e9, "G_r_theta": 1e9, "G_r_z": 1e9}
    study = case(
        "geometry.mandrel_outer_diameter=0.02", "geometry.mandrel_thickness=1.0e-3", "mandrel.material.E=70e9",
        "mandrel.material.nu=0.33", "mandrel.material.rho=2700", "mandrel.tip_mass=0.0", "modal.count=5",
        "mesh.circumferential=12", "mesh.axial=20", "mesh.grading=6", "mesh.radial=3", "mesh.radial_grading=6",
        coil=coil | {"thickness": 15e-3},
    )  # fmt: skip
    section_model = shear_modes(study)
    solid = shear_modes(study.changed("mesh.discretisation=three_dimensional"))
    along = np.abs(solid.participation) > 1e-3
    np.testing.assert_allclose(section_model.frequencies_hz, solid.frequencies_hz[along], rtol=3e-3)
    np.testing.assert_allclose(section_model.participation, np.abs(solid.participation[along]), rtol=3e-3)
    assert section_model.mass_total == pytest.approx(solid.mass_total, rel=5e-4)
    assert 95.0 < section_model.frequencies_hz[0] < 100.0
    # 20 x 3 hexes; on 36 x 6 the difference is 0.2 and 1.2 % rms (docs/design-map.md)
    for name, part in (("srz", np.cos), ("srt", np.sin)):
        flat, deep = (
            amplitudes(modes.points, getattr(modes, name)[row], part)
            for modes, row in ((section_model, 0), (solid, int(np.argmax(along))))
        )
        np.testing.assert_allclose(flat[0], deep[0], atol=1e-5)
        high = flat[0][:, 0] > 0.02  # above the clamped corner
        scale = np.abs(flat[1][high]).max()
        sign = np.sign(flat[1] @ deep[1])
        assert np.abs(flat[1] - sign * deep[1])[high].max() < 0.03 * scale


def amplitudes(points, values, part):
    """Points [z, r] in order and the amplitude of `part`(theta) that fits the values at each."""
    place, which = np.unique(np.round(points[:, 1:], 5), axis=0, return_inverse=True)
    trend = part(points[:, 0])
    return place, np.bincount(which, trend * values) / np.bincount(which, trend**2)
