"""The solid coil bonded to the mandrel's shell: constraints, limits, modes, stress, files."""

from functools import cache

import meshio
import numpy as np
import pytest
import scipy.sparse.linalg as spla
from support.paths import CONFIGS

from wroll_fem.analyses.modal import run_modal
from wroll_fem.analyses.shared.assembly import build_bodies
from wroll_fem.analyses.slip_model import shear_modes
from wroll_fem.bodies.mode_shapes import circumferential_content, classify_mode, main_bending
from wroll_fem.case import load_case
from wroll_fem.coiled_stiff.shear_points import quadratic_basis
from wroll_fem.coiled_stiff.solid_stress import shear_modes as shear_modes_of_bodies
from wroll_fem.errors import InputError
from wroll_fem.fem.body import assemble_bodies
from wroll_fem.fem.coil import coil_hexes
from wroll_fem.fem.constraints import rigid_motions
from wroll_fem.fem.eigen import solve_modes, solve_pairs
from wroll_fem.mesh.files import write_mesh
from wroll_fem.mesh.generate import build_mesh
from wroll_fem.mesh.shells import VTK_GRID
from wroll_fem.progress import SilentProgress

STIFF = CONFIGS / "coiled_stiff.yaml"
KAPTON = CONFIGS / "kapton_roll.yaml"
SMALL = ("mesh.circumferential=8", "mesh.axial=5", "mesh.radial=2")
AROUND, ALONG, ACROSS = 8, 5, 2
FREE = ("mandrel.base=free", "mandrel.tip=free")


def stiff(*overrides):
    return load_case(STIFF, [*SMALL, *overrides])


@cache
def body(*overrides, symmetric=False):
    return assemble_bodies(stiff(*overrides), symmetric=symmetric)[0]


def lowest(part, count=1):
    return solve_modes(part.stiffness, part.mass, count)[0]


# ---- bond and constraints --------------------------------------------------------------------------------------------


def test_free_roll_moves_rigidly_without_strain_and_has_no_other_zero_mode():
    part = body(*FREE, "mesh.circumferential=12", "mesh.axial=3")
    values = solve_pairs(part.stiffness, part.mass, 10, sigma=-1e4).values
    assert np.abs(values[:6]).max() < 1e-6 * values[6]
    everywhere = np.vstack([part.nodes, part.solid.nodes])
    motions = rigid_motions(everywhere, np.array([0.0, 0.0, 0.1])).reshape(-1, 6, 6)
    shell, coil = motions[: len(part.nodes)].reshape(-1, 6), motions[len(part.nodes) :, :3].reshape(-1, 6)
    E = part.expand
    y = spla.spsolve(
        (E.T @ E + part.solid.expand.T @ part.solid.expand).tocsc(), E.T @ shell + part.solid.expand.T @ coil
    )
    assert np.abs(E @ y - shell).max() < 1e-10
    assert np.abs(part.solid.expand @ y - coil).max() < 1e-10  # the wall's offset turns with the wall
    assert np.abs(part.stiffness @ y).max() < 1e-9 * np.abs(part.stiffness).max()
    inertia = part.influence.T @ part.mass @ part.influence
    np.testing.assert_allclose(inertia, part.mass_total * np.eye(3), rtol=1e-9, atol=1e-9)
    density, wall = 1600 * np.pi * (0.025**2 - 0.010**2), 2700 * np.pi * (0.010**2 - 0.009**2)
    assert part.mass_total == pytest.approx(0.3 * (density + wall), rel=5e-4)


def test_half_of_the_roll_has_the_modes_of_the_whole_that_bend_along_x():
    half, whole = body(symmetric=True), body()
    assert half.n_dofs < 0.6 * whole.n_dofs
    both = lowest(whole, 2)
    assert lowest(half)[0] == pytest.approx(both[0], rel=1e-9)
    assert both[1] == pytest.approx(both[0], rel=1e-9)
    shaken = [part.influence.T @ part.mass @ part.influence for part in (half, whole)]
    np.testing.assert_allclose(shaken[0][[0, 2], [0, 2]], shaken[1][[0, 2], [0, 2]], rtol=1e-9)
    assert shaken[0][1, 1] == 0.0  # shaking along y has no part that is symmetric
    restored = half.solid.expand @ solve_modes(half.stiffness, half.mass, 1)[1][:, 0]
    u = restored.reshape(-1, 3)
    mirrored = np.lexsort(np.round(half.solid.nodes * [1, -1, 1], 9).T)
    straight = np.lexsort(np.round(half.solid.nodes, 9).T)
    np.testing.assert_allclose(u[mirrored] * [1, -1, 1], u[straight], atol=1e-12)


def test_bases_are_ordered_and_the_inner_edge_is_the_mandrels():
    free, edge, clamped = (
        lowest(body(f"coil.base={base}", symmetric=True))[0] for base in ("free", "inner_edge", "clamped")
    )
    assert edge == free  # bonded to a clamped mandrel, the inner edge does not move
    assert clamped > 1.05 * free
    with pytest.raises(InputError, match=r"coil\.base: the base of the coil is clamped .* base of the mandrel is free"):
        body(*FREE, "coil.base=clamped")


# ---- limits ----------------------------------------------------------------------------------------------------------


def test_thin_isotropic_coil_is_the_bonded_layer():
    # bases clamped: a free layer is tied at points, near the base less than a solid all along (0.3 % at 40 x 40 cells)
    lab = ["mesh.circumferential=12", "mesh.axial=6", "mesh.grading=4", "modal.count=5"]
    solid = load_case(KAPTON, [*lab, "coil.base=clamped", "coil.material={E: 4e9, nu: 0.35, rho: 1400}"])
    text = solid.resolved()
    text["coil"] = text["coil"] | {"model": "bonded"}
    layer = type(solid).model_validate(text)
    found = [run_modal(case, progress=SilentProgress()) for case in (solid, layer)]
    assert found[0]["mode_kind"].values.tolist() == found[1]["mode_kind"].values.tolist()
    ours, other = (d["mode_frequency"].values for d in found)
    np.testing.assert_allclose(ours[[0, 1, 4]], other[[0, 1, 4]], rtol=1e-3)  # bending and torsion
    np.testing.assert_allclose(ours[2:4], other[2:4], rtol=0.03)  # ovalling: points let the layers' walls turn


def test_one_material_all_through_is_a_thick_beam():
    # Timoshenko's static tip deflection of the whole thick tube, clamped at its whole base
    E, nu, length, inner, outer = 5e9, 0.0, 0.6, 0.009, 0.025
    part = body(
        f"coil.material={{E: {E}, nu: {nu}, rho: 1600}}", f"mandrel.material={{E: {E}, nu: {nu}, rho: 1600}}",
        "coil.base=clamped", f"geometry.length={length}", "mesh.axial=6", "mesh.grading=1", "mandrel.tip=free",
    )  # fmt: skip
    tip = part.solid.nodes[:, 2] > length - 1e-9
    share = np.zeros((len(tip), 3))
    share[tip, 0] = 1.0 / tip.sum()
    u = spla.spsolve(part.stiffness.tocsc(), part.solid.expand.T @ share.ravel())
    deflection = (part.solid.expand @ u).reshape(-1, 3)[tip, 0].mean()
    inertia, area = np.pi / 4 * (outer**4 - inner**4), np.pi * (outer**2 - inner**2)
    m2 = (inner / outer) ** 2  # Cowper (1966), doi:10.1115/1.3625046
    kappa = 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)
    expected = length**3 / (3 * E * inertia) + length / (kappa * E / 2 / (1 + nu) * area)
    assert deflection == pytest.approx(expected, rel=4e-3)


@pytest.mark.slow
def test_coarse_mesh_is_converged_and_holds_no_false_modes_when_wraps_slide_easily():
    loose = ("coil.material.G_r_theta=1e4", "modal.count=8")
    named = []
    coarse, fine = (
        ("mesh.circumferential=12", "mesh.axial=6"),
        ("mesh.circumferential=16", "mesh.axial=10", "mesh.radial=3"),
    )
    for mesh in (coarse, fine):
        part = body(*loose, *mesh)
        frequencies, vectors = solve_modes(part.stiffness, part.mass, 6)
        named.append((frequencies, [classify_mode([part], v).kind for v in vectors.T]))
    assert named[0][1][:4] == named[1][1][:4] == ["torsion", "axial", "bending", "bending"]
    np.testing.assert_allclose(named[0][0][2:4], named[1][0][2:4], rtol=4e-3)
    assert (named[0][0] > 0.999 * named[1][0]).all()


# ---- modes and stress ------------------------------------------------------------------------------------------------


def test_run_names_the_modes_and_puts_the_coil_into_shapes_and_files():
    case = stiff("modal.count=3")
    data = run_modal(case, progress=SilentProgress())
    part = body()
    kinds = data["mode_kind"].values.tolist()
    assert kinds == ["bending", "bending", "torsion"]
    assert main_bending(kinds, data["effective_mass_fraction"].values) == 0
    share = data["effective_mass_fraction"].values
    assert share[0, 0] == pytest.approx(share[1, 1], rel=1e-6)
    assert 0.6 < share[0, 0] < 0.75
    assert share[2].max() < 1e-9
    assert data.sizes["node"] == len(part.nodes) + len(part.solid.nodes)
    assert data.sizes["cell"] == 2 * AROUND * ALONG + 2 * AROUND * ACROSS  # mandrel, outer surface, both ends
    nodes, hexes = data["node_position"].values, data["solid_cell_nodes"].values
    N, dN = quadratic_basis(np.array(VTK_GRID) / 2)
    np.testing.assert_allclose(N, np.eye(27), atol=1e-14)
    jacobian = np.einsum("qka,ckd->cqda", dN, nodes[hexes])
    assert np.linalg.det(jacobian).min() > 0  # right-handed, as VTK wants them
    skin = nodes[data["cell_nodes"].values[AROUND * ALONG :]]
    radius, z = np.hypot(skin[..., 0], skin[..., 1]), skin[..., 2]
    outside = np.abs(radius - 0.025).max(axis=1) < 1e-9
    assert outside.sum() == AROUND * ALONG
    assert np.isin(np.round(z[~outside], 9), [0.0, 0.3]).all()


def test_content_of_a_motion_is_weighed_by_the_mass_of_wall_and_coil():
    part = body(*FREE)
    for axis, wave, component in ((0, 1, (0, 2)), (2, 0, (1,))):
        content = circumferential_content(part, part.influence[:, axis])
        assert content[wave, list(component)].sum() == pytest.approx(part.mass_total, rel=1e-9)
        assert content.sum() == pytest.approx(part.mass_total, rel=1e-9)
    coil_alone = np.zeros(part.n_dofs)
    first = part.expand.getnnz(axis=0).nonzero()[0].max() + 1  # the coil's own unknowns come behind the mandrel's
    coil_alone[first:] = part.influence[first:, 2]
    assert circumferential_content(part, coil_alone)[0, 1] > 0.9 * part.solid.mass
    assert classify_mode([part], coil_alone).kind == "axial"


def test_mesh_files_hold_the_coil(tmp_path):
    case = stiff()
    mesh = build_mesh(case)
    msh, vtu = write_mesh(mesh, tmp_path, coil=coil_hexes(case, mesh))
    for path in (msh, vtu):
        cells = {block.type: len(block.data) for block in meshio.read(path).cells}
        assert cells["hexahedron27"] == AROUND * ALONG * ACROSS
        assert cells["quad9"] == AROUND * ALONG
    assert coil_hexes(stiff("coil.model=nonstructural_mass"), mesh) is None


def test_shear_of_the_bending_mode_agrees_with_the_fourier_model():
    mesh = ("mesh.circumferential=8", "mesh.axial=8", "mesh.radial=2", "modal.count=2")
    ours = shear_modes(stiff(*mesh))
    other = shear_modes(stiff(*mesh, "mesh.discretisation=fourier"))
    assert ours.kinds == ("bending", "bending")
    assert ours.frequencies_hz[0] == pytest.approx(other.frequencies_hz[0], rel=5e-3)
    assert ours.volumes.sum() == pytest.approx(other.volumes.sum(), rel=1e-3)
    assert abs(ours.participation[0]) == pytest.approx(abs(other.participation[0]), rel=2e-3)
    assert abs(ours.tip[0]) == pytest.approx(abs(other.tip[0]), rel=2e-3)
    assert abs(ours.participation[1]) < 1e-6 * abs(ours.participation[0])  # the pair's other mode bends along y
    bands = []
    for modes in (ours, other):
        sign = np.sign(modes.participation[0])
        theta, z, _ = modes.points.T
        lower, middle = (z > 0.005) & (z < 0.05), (z > 0.1) & (z < 0.2)
        weights = sign * modes.volumes
        bands.append(
            [
                (weights * modes.srz[0] * np.cos(theta))[lower].sum(),
                (weights * modes.srt[0] * np.sin(theta))[lower].sum(),
                (weights * modes.srz[0] * np.cos(theta))[middle].sum(),
            ]
        )
        assert np.abs(modes.srz[0] * np.sin(theta) * modes.volumes).sum() > 0
        assert abs((modes.srz[0] * np.sin(theta) * modes.volumes).sum()) < 1e-6 * np.abs(bands[-1][0])
    np.testing.assert_allclose(bands[0], bands[1], rtol=0.06)


@pytest.mark.parametrize("direction", ["x", "y"])
def test_half_a_pair_at_the_end_of_the_list_is_along_the_excitation(direction):
    shaken = f"excitation={{kind: sine, frequency: resonance, amplitude_g: 1, direction: {direction}}}"
    few = ("mesh.circumferential=8", "mesh.axial=3", "mesh.radial=1")
    one, two = (shear_modes(stiff(*few, f"modal.count={n}", shaken)) for n in (1, 2))
    assert len(one.frequencies_hz) == 2
    np.testing.assert_allclose(np.abs(one.participation), np.abs(two.participation), rtol=1e-6, atol=1e-6)
    if direction == "x":
        runs = [run_modal(stiff(*few, f"modal.count={n}"), progress=SilentProgress()) for n in (1, 2)]
        assert runs[0].sizes["mode"] == 1
        fractions = [run["effective_mass_fraction"].values[0] for run in runs]
        np.testing.assert_allclose(fractions[0], fractions[1], atol=1e-6)
        assert fractions[0][0] > 0.5
        assert fractions[0][1] < 1e-6


def test_shear_stress_needs_a_solid_coil():
    bare = stiff("coil.model=nonstructural_mass")
    with pytest.raises(InputError, match="for a solid coil only"):
        shear_modes(bare)
    with pytest.raises(InputError, match="for a solid coil only"):
        shear_modes_of_bodies(build_bodies(bare), bare.coil.solid(), count=1, direction=0)
