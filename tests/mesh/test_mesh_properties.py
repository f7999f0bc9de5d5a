"""Properties of meshes and mesh files for generated input (hypothesis, derandomised)."""

from __future__ import annotations

from pathlib import Path

import gmsh
import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from wroll_fem.errors import InputError
from wroll_fem.mesh.files import read_mesh, write_mesh
from wroll_fem.mesh.generate import axial_stations, make_cylinders, with_borders
from wroll_fem.mesh.shells import mirror_nodes

SAME = settings(
    derandomize=True, deadline=None, max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
lengths = st.floats(1e-3, 1e2)


@SAME
@given(lengths, st.integers(2, 300), st.floats(1.0, 1e6))
def test_elements_grow_by_one_ratio_from_end_to_end(length: float, divisions: int, grading: float) -> None:
    stations = axial_stations(length, divisions, grading)
    sizes = np.diff(stations)
    assert (stations[0], len(stations)) == (0.0, divisions + 1)
    np.testing.assert_allclose(stations[-1], length, rtol=1e-14)
    # a size is a difference of heights, whose rounding error is some 1e-16 of the length
    ratio = grading ** (1.0 / (divisions - 1))
    np.testing.assert_allclose(sizes[1:], sizes[:-1] * ratio, rtol=1e-9, atol=1e-14 * length * ratio)
    np.testing.assert_allclose(sizes[-1], grading * sizes[0], rtol=1e-9, atol=1e-14 * grading * length)


@SAME
@given(lengths, st.integers(1, 30), st.lists(st.floats(-0.5, 1.5), max_size=6))
def test_borders_are_put_at_all_heights_and_stay_in_order(length: float, divisions: int, shares: list[float]) -> None:
    stations = axial_stations(length, divisions, 3.0)
    heights = [length * share for share in shares]
    borders = with_borders(stations, heights, keep=(0.0, length))
    assert (borders[0], borders[-1]) == (stations[0], stations[-1])
    assert (np.diff(borders) > 0.0).all()
    for z in heights:
        if stations[0] < z < stations[-1]:
            assert np.isclose(borders, z, rtol=1e-9, atol=0.0).any()
    assert len(borders) <= len(stations) + len(heights)


@settings(SAME, max_examples=4)  # reading tries a file in a process of its own, which takes half a second
@given(
    radii=st.lists(st.floats(1e-3, 1.0), min_size=1, max_size=3, unique=True),
    around=st.integers(2, 6),
    axial=st.integers(1, 4),
    grading=st.floats(1.0, 20.0),
)
def test_any_tubes_are_symmetric_and_read_back_the_same(
    radii: list[float], around: int, axial: int, grading: float, tmp_path: Path
) -> None:
    shells = list(zip(("mandrel", "layer_01", "layer_02"), radii, strict=False))
    mesh = make_cylinders(shells, 0.3, 2 * around, axial, grading)
    assert len(mesh.nodes) == len(shells) * 4 * around * (2 * axial + 1)
    partner = mirror_nodes(mesh.nodes)
    assert partner is not None
    np.testing.assert_array_equal(mesh.nodes[partner], mesh.nodes * [1, -1, 1])
    for name, radius in shells:
        nodes = mesh.part(name).nodes
        np.testing.assert_allclose(np.hypot(nodes[:, 0], nodes[:, 1]), radius, rtol=1e-14)
    again = read_mesh(write_mesh(mesh, tmp_path)[0], [name for name, _ in shells])
    np.testing.assert_allclose(again.nodes, mesh.nodes, rtol=1e-15, atol=0.0)  # written with 16 digits
    np.testing.assert_array_equal(again.cells, mesh.cells)
    assert all(np.array_equal(again.groups[name], members) for name, members in mesh.groups.items())


WORDS = ("0", "1", "-1", "99999999", "4294967296", "1e300", "nan", "x", "")


@settings(SAME, max_examples=4)
@given(data=st.data())
def test_a_mesh_file_with_changed_numbers_is_a_mesh_or_one_line(data: st.DataObject, tmp_path: Path) -> None:
    """tests/fuzz/damaged_files.py does the same with thousands of files."""
    path = tmp_path / "own.msh"
    if not path.exists():
        write_mesh(make_cylinders([("mandrel", 0.04)], 0.3, 6, 1), tmp_path, "own")
        (tmp_path / "whole").write_bytes(path.read_bytes())
    lines = (tmp_path / "whole").read_text().splitlines()
    nodes = range(lines.index("$Nodes") + 1, lines.index("$EndNodes"))
    at = data.draw(st.sampled_from(nodes))
    words = lines[at].split(" ")
    words[data.draw(st.integers(0, len(words) - 1))] = data.draw(st.sampled_from(WORDS))
    path.write_text("\n".join([*lines[:at], " ".join(words), *lines[at + 1 :]]) + "\n")
    refused: list[InputError] = []
    try:
        assert np.isfinite(read_mesh(path).nodes).all()
    except InputError as error:
        refused.append(error)
    assert not [error for error in refused if "\n" in str(error) or not error.remedy]
    assert not gmsh.isInitialized()
