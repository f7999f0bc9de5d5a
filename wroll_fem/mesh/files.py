"""Mesh files: reading and writing .msh with named groups (gmsh), writing .vtu (meshio)."""

from __future__ import annotations

import contextlib
import os
import signal
import tempfile
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path

import gmsh
import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.mesh.shells import VTK_GRID, CylinderMesh, ring_edges
from wroll_fem.results.storage.atomic import make_folder, replacing
from wroll_fem.results.storage.guarded import trial_mesh
from wroll_fem.typing import FloatArray, IntArray

_QUAD9, _LINE3, _HEX27 = 10, 8, 12  # gmsh element types

Hexes = tuple[FloatArray, IntArray]
"""Nodes (n, 3), m, and cells (n_cells, 27), in VTK_TRIQUADRATIC_HEXAHEDRON order, of a solid coil."""


def start_gmsh() -> None:
    """Initialise gmsh and suppress one false warning on stderr.

    The PETSc library in the gmsh wheel mistakes Open MPI 5, whose ROMIO defines a few symbols of MPICH, for a second
    MPI library and warns that the program will not run correctly. Meshing does not use MPI.
    """
    terminal = os.dup(2)
    with tempfile.TemporaryFile() as messages:
        os.dup2(messages.fileno(), 2)
        try:
            gmsh.initialize([], readConfigFiles=False, interruptible=False)
            if threading.current_thread() is threading.main_thread():  # gmsh replaces the handler
                signal.signal(signal.SIGTERM, signal.getsignal(signal.SIGTERM))
        finally:
            os.dup2(terminal, 2)
            os.close(terminal)
            messages.seek(0)
            os.write(2, b"".join(line for line in messages if b"against both OpenMPI and MPICH" not in line))


@contextlib.contextmanager
def gmsh_model(name: str) -> Iterator[None]:
    """Open a new gmsh model without terminal output and restore the state of gmsh afterwards."""
    started = not gmsh.isInitialized()
    if started:
        start_gmsh()
    previous = None if started else gmsh.model.getCurrent()
    terminal = gmsh.option.getNumber("General.Terminal")
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add(name)
    try:
        yield
    finally:
        gmsh.model.remove()
        gmsh.option.setNumber("General.Terminal", terminal)
        if started:
            gmsh.finalize()
        elif previous is not None:
            gmsh.model.setCurrent(previous)


def read_mesh(path: str | Path, required: Sequence[str] = ("mandrel",)) -> CylinderMesh:
    """Read a .msh file whose physical groups are named as in `CylinderMesh`.

    Parameters
    ----------
    path
        File in a format that gmsh reads (.msh 2.2 or 4.1).
    required
        Shells that the file must contain, each with its "_base" and "_tip" ring.

    Raises
    ------
    InputError
        If the file is missing or unreadable, is a script, lacks groups, or contains cells other than 9-node quads.
    RuntimeError
        If reading the file changes the list of gmsh models.
    """
    path = Path(path)
    _check_file(path)
    with gmsh_model("read"):
        before = set(gmsh.model.list())
        try:
            gmsh.merge(str(path))
        except Exception as error:  # gmsh raises bare Exception for every failure
            raise InputError(
                f"gmsh cannot read the mesh ({error})", key="mesh.file", file=str(path), remedy="save it as .msh 4.1"
            ) from error
        if set(gmsh.model.list()) != before:
            raise RuntimeError(f"reading {path} changed the list of gmsh models")
        return extract_mesh(str(path), required)


def _check_file(path: Path) -> None:
    """Refuse a file that gmsh would run as a script, or that ends its process."""
    if not path.is_file():
        raise InputError("mesh file does not exist", key="mesh.file", file=str(path), remedy="give an existing file")
    with path.open("rb") as file:
        head = file.read(20)
    if path.suffix.lower() != ".msh" or not head.startswith((b"$MeshFormat", b"$Comments")):
        # gmsh takes any other text for a .geo script, which may start programs
        raise InputError("is not a .msh file", key="mesh.file", file=str(path), remedy="save the mesh as .msh 4.1")
    if problem := trial_mesh(path):
        raise InputError(
            f"the mesh file is damaged ({problem})", key="mesh.file", file=str(path), remedy="write the mesh again"
        )


def extract_mesh(source: str, required: Sequence[str] = ()) -> CylinderMesh:
    """Cells and groups of the current gmsh model; nodes outside all quads (arc centres) are removed.

    Parameters
    ----------
    source
        Name of the mesh file, for the messages.
    required
        Shells that the model must contain; empty for all groups.

    Raises
    ------
    InputError
        If a group is missing, has the wrong dimension, or contains other cells than 9-node quads and 3-node lines.
    """
    found = {gmsh.model.getPhysicalName(dim, tag): (dim, tag) for dim, tag in gmsh.model.getPhysicalGroups()}
    wanted = [name for part in required for name in (part, f"{part}_base", f"{part}_tip")] or list(found)
    missing = [name for name in wanted if name not in found]
    if missing:
        lacks = f"group{'s' * (len(missing) > 1)} {', '.join(missing)}"
        raise InputError(
            f"mesh lacks the {lacks} (it has: {', '.join(found) or 'none'})",
            key="mesh.file",
            file=source,
            remedy="add physical groups of these names: surfaces for the shells, curves for their end rings",
        )
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    cells: list[IntArray] = []
    groups: dict[str, IntArray] = {}
    count = 0
    for name in wanted:
        dim, group = found[name]
        expected = 1 if name.endswith(("_base", "_tip")) else 2
        if dim != expected:
            raise InputError(
                f"group {name} has dimension {dim} instead of {expected}",
                key="mesh.file",
                file=source,
                remedy="define shells as physical surfaces and their end rings as physical curves",
            )
        own = _group_elements(dim, group, name, source)
        if dim == 2:
            groups[name] = np.arange(count, count + len(own))
            count += len(own)
            cells.append(own)
        else:
            groups[name] = np.unique(own)
    all_cells = np.concatenate(cells)
    used = np.unique(all_cells)
    order = np.argsort(tags)
    nodes = coordinates.reshape(-1, 3)[order[np.searchsorted(tags, used, sorter=order)]]
    if not np.isfinite(nodes).all():
        raise InputError(
            f"node {used[~np.isfinite(nodes).all(axis=1)][0]} has a coordinate that is not finite",
            key="mesh.file",
            file=source,
            remedy="write the mesh again",
        )
    for name, members in groups.items():
        if name.endswith(("_base", "_tip")):
            groups[name] = np.searchsorted(used, members)
    return CylinderMesh(nodes, np.searchsorted(used, all_cells), groups)


def _group_elements(dim: int, group: int, name: str, source: str) -> IntArray:
    """(n, nodes per element) node tags of the elements of a physical group, which must be quad9 or line3."""
    wanted = _QUAD9 if dim == 2 else _LINE3
    blocks = []
    for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, group):
        types, _, node_tags = gmsh.model.mesh.getElements(dim, entity)
        for kind, own in zip(types, node_tags, strict=True):
            kind_name, _, _, per_element, _, _ = gmsh.model.mesh.getElementProperties(kind)
            if kind != wanted:
                raise InputError(
                    f"group {name} contains cells of type {kind_name}",
                    key="mesh.file",
                    file=source,
                    remedy="use 9-node quads (gmsh: recombine, Mesh.ElementOrder = 2, no incomplete elements)",
                )
            blocks.append(np.asarray(own, np.int64).reshape(-1, per_element))
    if not blocks:
        raise InputError(
            f"group {name} contains no elements",
            key="mesh.file",
            file=source,
            remedy="mesh the group and save the file",
        )
    return np.concatenate(blocks)


def write_mesh(mesh: CylinderMesh, folder: str | Path, name: str = "mesh", coil: Hexes | None = None) -> list[Path]:
    """Write a mesh as .msh (gmsh 4.1, named groups) and as .vtu (for ParaView).

    Parameters
    ----------
    mesh
        Shell mesh.
    folder
        Folder of the files; created if needed.
    name
        Name of both files without suffix.
    coil
        Nodes and cells of a solid coil, written as the volume "coil". It has its own nodes, because those of the
        mandrel lie on its mid-surface.

    Returns
    -------
    list of Path
        The .msh and the .vtu file.
    """
    folder = Path(folder)
    make_folder(folder)
    msh, vtu = folder / f"{name}.msh", folder / f"{name}.vtu"
    _write_msh(mesh, msh, coil)
    _write_vtu(mesh, vtu, coil)
    return [msh, vtu]


def _write_msh(mesh: CylinderMesh, path: Path, coil: Hexes | None) -> None:
    with gmsh_model("write"):
        for tag, name in enumerate(mesh.parts, start=1):
            cells = mesh.cells[mesh.groups[name]]
            own = np.unique(cells)
            gmsh.model.addDiscreteEntity(2, tag)
            gmsh.model.mesh.addNodes(2, tag, own + 1, mesh.nodes[own].ravel())
            gmsh.model.mesh.addElementsByType(tag, _QUAD9, [], cells.ravel() + 1)
            gmsh.model.addPhysicalGroup(2, [tag], tag, name=name)
            for ring, end in ((2 * tag - 1, "base"), (2 * tag, "tip")):
                edges = ring_edges(cells, mesh.groups[f"{name}_{end}"])
                gmsh.model.addDiscreteEntity(1, ring)
                gmsh.model.mesh.addElementsByType(ring, _LINE3, [], edges.ravel() + 1)
                gmsh.model.addPhysicalGroup(1, [ring], ring, name=f"{name}_{end}")
        if coil is not None:
            _add_hexes(*coil, first=len(mesh.nodes) + 1)
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        gmsh.write(str(path))


def _add_hexes(nodes: FloatArray, cells: IntArray, first: int) -> None:
    """Add the volume "coil" to the current gmsh model, with its nodes numbered from `first`."""
    local = gmsh.model.mesh.getElementProperties(_HEX27)[4]
    grid = (np.asarray(local).reshape(-1, 3) + 1).round().astype(int).tolist()
    gmsh.model.addDiscreteEntity(3, 1)
    gmsh.model.mesh.addNodes(3, 1, np.arange(len(nodes)) + first, nodes.ravel())
    ordered = cells[:, [VTK_GRID.index((a, b, c)) for a, b, c in grid]]
    gmsh.model.mesh.addElementsByType(1, _HEX27, [], ordered.ravel() + first)
    gmsh.model.addPhysicalGroup(3, [1], 1, name="coil")


def _write_vtu(mesh: CylinderMesh, path: Path, coil: Hexes | None) -> None:
    import meshio

    part = np.zeros(len(mesh.cells), np.int32)
    for index, name in enumerate(mesh.parts):
        part[mesh.groups[name]] = index
    nodes, blocks, parts = mesh.nodes, [("quad9", mesh.cells)], [part]
    if coil is not None:
        nodes = np.vstack([mesh.nodes, coil[0]])
        blocks.append(("hexahedron27", coil[1] + len(mesh.nodes)))
        parts.append(np.full(len(coil[1]), len(mesh.parts), np.int32))
    with replacing(path, "choose another --out") as file:
        meshio.Mesh(nodes, blocks, cell_data={"shell": parts}).write(file, "vtu")
