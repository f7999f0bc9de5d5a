"""Meshes: matching shells, named groups, files."""

import os
import re

import gmsh
import meshio
import numpy as np
import pytest
from support.paths import ROOT

from wroll_fem.case import load_case
from wroll_fem.errors import InputError
from wroll_fem.mesh.files import read_mesh, start_gmsh, write_mesh
from wroll_fem.mesh.generate import axial_stations, build_mesh, check_geometry, make_cylinders, shell_layout
from wroll_fem.mesh.shells import CylinderMesh, canonical_vertices, mirror_nodes, ring_edges

SHELLS = [("mandrel", 0.03925), ("layer_01", 0.040625), ("layer_02", 0.041875)]
LENGTH = 0.3


@pytest.fixture(scope="module")
def mesh():
    return make_cylinders(SHELLS, LENGTH, 14, 5, grading=3.0)


def own_mesh(folder, *, quarter=3, order=2, recombine=True, drop=(), incomplete=False):
    """A mesh as a user makes it: own_roll.geo through gmsh, with changes."""
    text = (ROOT / "meshes" / "own_roll.geo").read_text()
    if not recombine:
        text = text.replace(" Recombine;", "")
    text = text.replace("quarter = 3", f"quarter = {quarter}")
    text = text.replace("Mesh.ElementOrder = 2", f"Mesh.ElementOrder = {order}")
    if incomplete:
        text += "Mesh.SecondOrderIncomplete = 1;\n"
    script, out = folder / "own.geo", folder / "own.msh"
    script.write_text(text)
    gmsh.initialize(["-v", "0"], interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(script))
        gmsh.model.mesh.generate(2)
        for dim, tag in gmsh.model.getPhysicalGroups():
            if gmsh.model.getPhysicalName(dim, tag) in drop:
                gmsh.model.removePhysicalGroups([(dim, tag)])
        gmsh.write(str(out))
    finally:
        gmsh.finalize()
    return out


def test_shells_are_radial_scalings_of_each_other_with_the_same_numbering(mesh):
    first = mesh.part("mandrel")
    for name, radius in SHELLS[1:]:
        other = mesh.part(name)
        np.testing.assert_array_equal(other.cells, first.cells)
        np.testing.assert_allclose(other.nodes[:, :2] / radius, first.nodes[:, :2] / 0.03925, atol=1e-14)
        np.testing.assert_array_equal(other.nodes[:, 2], first.nodes[:, 2])
        for end in ("base", "tip"):
            np.testing.assert_array_equal(other.groups[end], first.groups[end])


def test_nodes_lie_on_the_cylinders_and_arc_centres_are_gone(mesh):
    assert len(mesh.nodes) == 3 * 28 * 11
    for name, radius in SHELLS:
        nodes = mesh.part(name).nodes
        np.testing.assert_allclose(np.hypot(nodes[:, 0], nodes[:, 1]), radius, rtol=1e-14)


def test_nodes_mirror_about_the_xz_plane_exactly(mesh):
    partner = mirror_nodes(mesh.nodes)
    assert partner is not None
    np.testing.assert_array_equal(mesh.nodes[partner], mesh.nodes * [1, -1, 1])
    on_plane = partner == np.arange(len(partner))
    assert on_plane.sum() == 3 * 2 * 11  # theta = 0 and pi on every level
    turned = mesh.nodes @ np.array([[np.cos(0.1), np.sin(0.1), 0], [-np.sin(0.1), np.cos(0.1), 0], [0, 0, 1]])
    assert mirror_nodes(turned) is None


def test_rings_are_the_ends(mesh):
    for name, _ in SHELLS:
        part = mesh.part(name)
        assert len(part.groups["base"]) == len(part.groups["tip"]) == 28
        assert (part.nodes[part.groups["base"], 2] == 0.0).all()
        assert (part.nodes[part.groups["tip"], 2] == LENGTH).all()
        assert len(ring_edges(part.cells, part.groups["tip"])) == 14


def test_grading_is_the_ratio_of_top_to_root_element_height(mesh):
    stations = np.unique(mesh.part("mandrel").nodes[:, 2])[::2]
    heights = np.diff(stations)
    assert heights[-1] / heights[0] == pytest.approx(3.0, rel=1e-12)
    np.testing.assert_allclose(heights[1:] / heights[:-1], 3.0**0.25, rtol=1e-12)
    np.testing.assert_allclose(axial_stations(2.0, 4), [0, 0.5, 1, 1.5, 2], rtol=1e-15)
    np.testing.assert_allclose(axial_stations(2.0, 1, 5.0), [0, 2])


def test_quads_are_counterclockwise_seen_from_outside_or_all_from_inside(mesh):
    part = mesh.part("mandrel")
    corners = part.nodes[part.cells[:, :4]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    outward = np.einsum("ij,ij->i", normal, corners.mean(axis=1) * [1, 1, 0])
    assert np.abs(np.sign(outward).sum()) == len(part.cells)
    for middle, (a, b) in zip(range(4, 8), [(0, 1), (1, 2), (2, 3), (3, 0)], strict=True):
        chord = part.nodes[part.cells[:, [a, b]]].mean(axis=1)
        assert np.linalg.norm(part.nodes[part.cells[:, middle]] - chord, axis=1).max() < 0.002


def test_contact_points_are_counted_alike_on_every_shell(mesh):
    reference = canonical_vertices(mesh.part("mandrel"))[1]
    assert len(reference) == 14 * 6
    assert reference[:, 0].max() == pytest.approx(np.pi)
    assert reference[:, 0].min() > -np.pi + 0.1
    assert (np.diff(reference[:14, 0]) > 0).all()
    assert (np.diff(reference[:, 1]) >= -1e-15).all()
    for name, radius in SHELLS[1:]:
        points = canonical_vertices(mesh.part(name))[1]
        np.testing.assert_allclose(points[:, :2], reference[:, :2], atol=1e-13)
        np.testing.assert_allclose(points[:, 2], radius, rtol=1e-13)


def test_written_mesh_reads_back_the_same(mesh, tmp_path):
    msh, vtu = write_mesh(mesh, tmp_path)
    again = read_mesh(msh, [name for name, _ in SHELLS])
    np.testing.assert_allclose(again.nodes, mesh.nodes, atol=1e-16)
    np.testing.assert_array_equal(again.cells, mesh.cells)
    assert set(again.groups) == set(mesh.groups)
    for name, members in mesh.groups.items():
        np.testing.assert_array_equal(np.sort(again.groups[name]), np.sort(members))
    picture = meshio.read(vtu)
    np.testing.assert_array_equal(picture.cells_dict["quad9"], mesh.cells)
    np.testing.assert_array_equal(np.bincount(picture.cell_data_dict["shell"]["quad9"]), [70, 70, 70])


def test_shipped_mesh_is_what_its_case_makes():
    case = load_case(ROOT / "configs" / "tiny.yaml")
    made, shipped = build_mesh(case), read_mesh(ROOT / "meshes" / "lab_small.msh", ["mandrel", "layer_01"])
    np.testing.assert_allclose(shipped.nodes, made.nodes, atol=1e-15)
    np.testing.assert_array_equal(shipped.cells, made.cells)


def test_a_users_own_mesh_takes_the_place_of_the_made_one(tmp_path):
    path = own_mesh(tmp_path, quarter=4)
    case = load_case(ROOT / "configs" / "tiny.yaml", [f"mesh.file={path}"])
    mesh = build_mesh(case)
    assert len(mesh.cells) == 2 * 16 * 4
    assert len(mesh.nodes) == 2 * 32 * 9  # the arcs' centre is a point of the script but no node of a quad
    assert mirror_nodes(mesh.nodes) is not None
    made = canonical_vertices(
        build_mesh(load_case(ROOT / "configs" / "tiny.yaml", ["mesh.circumferential=16"])).part("layer_01")
    )[1]
    np.testing.assert_allclose(canonical_vertices(mesh.part("layer_01"))[1], made, atol=1e-9)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"drop": ["layer_01_tip"]}, ["lacks the group layer_01_tip", "it has", "mandrel_base", "physical"]),
        ({"order": 1}, ["group mandrel ", "Quadrilateral 4", "9-node quads"]),
        ({"recombine": False}, ["group mandrel ", "Triangle 6", "recombine"]),
        ({"incomplete": True}, ["Quadrilateral 8", "no incomplete elements"]),
    ],
)
def test_a_mesh_that_does_not_fit_is_refused_in_one_line(tmp_path, change, words):
    path = own_mesh(tmp_path, **change)
    with pytest.raises(InputError) as caught:
        read_mesh(path, ["mandrel", "layer_01"])
    message = str(caught.value)
    assert "\n" not in message
    for word in [str(path), "mesh.file", *words]:
        assert word in message
    assert caught.value.exit_code == 2


@pytest.mark.parametrize("number", ["nan", "inf"])
def test_a_mesh_with_a_node_nowhere_is_refused_in_one_line(tmp_path, number):
    """Comparisons with NaN are false, so that such a node passed every check of the geometry."""
    lines = (ROOT / "meshes" / "lab_small.msh").read_text().splitlines()
    at = max(k for k, line in enumerate(lines[: lines.index("$EndNodes")]) if len(line.split()) == 3)
    lines[at] = f"{number} " + " ".join(lines[at].split()[1:])
    path = tmp_path / "own.msh"
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(
        InputError, match=r"mesh.file: (node \d+ has a coordinate that is not finite|gmsh cannot)"
    ) as told:
        build_mesh(load_case(ROOT / "configs" / "tiny.yaml", [f"mesh.file={path}"]))
    assert "\n" not in str(told.value)


def test_a_file_that_is_no_mesh_is_refused_and_gmsh_keeps_working(tmp_path, mesh):
    bad = tmp_path / "bad.msh"
    bad.write_text("this is not a mesh\n")
    with pytest.raises(InputError, match=r"bad\.msh"):
        read_mesh(bad)
    with pytest.raises(InputError, match="does not exist"):
        read_mesh(tmp_path / "absent.msh")
    assert not gmsh.isInitialized()
    np.testing.assert_array_equal(make_cylinders(SHELLS, LENGTH, 14, 5, grading=3.0).nodes, mesh.nodes)


def changed(mesh, **fields):
    return CylinderMesh(**({"nodes": mesh.nodes, "cells": mesh.cells, "groups": mesh.groups} | fields))


def test_a_mesh_of_another_geometry_is_refused(mesh):
    layout = [("mandrel", 0.03925, 1.5e-3), ("layer_01", 0.040625, 1.25e-3), ("layer_02", 0.041875, 1.25e-3)]
    check_geometry(mesh, layout, LENGTH, "own.msh")
    millimetres = changed(mesh, nodes=mesh.nodes * 1e3)
    with pytest.raises(InputError, match=r"mandrel are up to .* off its mid-surface radius 0\.03925 m"):
        check_geometry(millimetres, layout, LENGTH, "own.msh")
    with pytest.raises(InputError, match=r"mandrel_tip is up to 0.02 m off z = 0.32 m"):
        check_geometry(mesh, layout, 0.32, "own.msh")
    nodes = mesh.nodes.copy()
    inside = np.unique(mesh.cells[mesh.groups["layer_01"]])
    inside = inside[(nodes[inside, 2] > 0.1) & (nodes[inside, 2] < 0.2)]
    nodes[inside, 2] += 0.003
    with pytest.raises(InputError, match="vertices of layer_01 do not match"):
        check_geometry(changed(mesh, nodes=nodes), layout, LENGTH, "own.msh")


def test_an_odd_number_around_is_refused():
    message = "mesh.circumferential: the number of elements around the circumference, 13, is odd or below 4"
    with pytest.raises(InputError, match=re.escape(message)):
        make_cylinders(SHELLS, LENGTH, 13, 4)


def test_layout_stacks_the_layers_on_the_mandrel():
    case = load_case(ROOT / "configs" / "tiny.yaml", ["coil.layers=5"])
    layout = shell_layout(case)
    assert [name for name, _, _ in layout] == ["mandrel", *(f"layer_{k:02d}" for k in range(1, 6))]
    surface = 0.04
    assert layout[0][1] + layout[0][2] / 2 == pytest.approx(surface, rel=1e-14)
    for _, radius, thickness in layout[1:]:
        assert radius - thickness / 2 == pytest.approx(surface, rel=1e-14)
        assert thickness == pytest.approx(0.25e-3, rel=1e-14)
        surface += thickness
    assert len(shell_layout(load_case(ROOT / "configs" / "tiny.yaml", ["coil.model=none"]))) == 1


def test_an_open_gmsh_session_survives(mesh, tmp_path):
    gmsh.initialize(["-v", "0"], interruptible=False)
    try:
        gmsh.model.add("mine")
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.add("other")
        gmsh.model.setCurrent("mine")
        make_cylinders(SHELLS[:1], LENGTH, 8, 2)
        write_mesh(mesh, tmp_path)
        assert gmsh.model.getCurrent() == "mine"
        assert len(gmsh.model.getEntities(3)) == 1
    finally:
        gmsh.finalize()


def test_gmsh_starts_without_the_false_alarm_about_two_mpi(monkeypatch, capfd):
    alarm = b"PETSc Error --- Application was linked against both OpenMPI and MPICH based MPI libraries\n"
    monkeypatch.setattr(gmsh, "initialize", lambda *args, **options: os.write(2, b"one\n" + alarm + b"two\n"))
    start_gmsh()
    os.write(2, b"after\n")
    assert capfd.readouterr().err == "one\ntwo\nafter\n"


@pytest.mark.parametrize("head", ["", "// $MeshFormat\n", "Exit;\n"])
def test_a_script_with_the_name_of_a_mesh_is_not_run(tmp_path, head):
    """gmsh takes any text for a script of its own, which may start programs or end the process."""
    script, mark = tmp_path / "own.msh", tmp_path / "mark"
    script.write_text(f'{head}SystemCall "touch {mark}";\n')
    with pytest.raises(InputError, match=r"own\.msh: mesh\.file: is not a \.msh file"):
        read_mesh(script)
    assert not mark.exists()
    named = (ROOT / "meshes" / "lab_small.msh").read_bytes()
    (tmp_path / "own.geo").write_bytes(named)
    with pytest.raises(InputError, match=r"own\.geo: mesh\.file: is not a \.msh file"):
        read_mesh(tmp_path / "own.geo")


def test_a_damaged_mesh_that_crashes_gmsh_does_not_end_the_program(tmp_path, mesh):
    """gmsh takes the dimension -1 of a group for the index of an array."""
    path = write_mesh(mesh, tmp_path)[0]
    text = path.read_text()
    assert '\n1 2 "mandrel_tip"' in text
    path.write_text(text.replace('\n1 2 "mandrel_tip"', '\n-1 2 "mandrel_tip"'))
    with pytest.raises(InputError) as caught:
        read_mesh(path)
    assert (
        str(caught.value) == f"{path}: mesh.file: the mesh file is damaged (gmsh crashes on it); write the mesh again"
    )
