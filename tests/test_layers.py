"""The rule of the layers (docs/architecture.md), read from the imports: no circle, no arrow upward."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from support.paths import ROOT

PACKAGE = ROOT / "wroll_fem"

LAYERS = (
    ("errors", "typing", "progress", "blas"),
    ("bodies", "results"),
    ("contact", "signals", "numerics"),
    ("case",),
    ("dynamics",),
    ("winding", "mesh", "two_dof", "tribology"),
    ("fem", "plotting", "lab"),
    ("coiled_stiff",),
    ("analyses",),
    ("jobs",),
    ("report", "api"),
    ("result",),
    ("runs",),
    ("roll", "own_structure"),
    ("cli",),
)
"""Rooms and loose modules, lowest first. A module imports from its own room, its own layer, or lower ones."""

LEVEL = {room: level for level, rooms in enumerate(LAYERS) for room in rooms}

LOOSE = {"__init__", "api", "blas", "cli", "errors", "progress", "typing", "result", "roll", "runs", "own_structure"}
"""Modules at the top: the doors, and what every room uses."""

MANY_FILES = {
    "analyses": "one file per analysis",
    "case": "one file per section of the case file",
    "plotting": "one file per figure",
}
"""Rooms with more than 15 files beside each other, and why."""

DOLFINX_VERSIONS = {"jobs/environment.py", "results/provenance.py"}
"""Files outside fem/ that look up the version of dolfinx and its libraries."""

PHYSICS = {"dynamics", "contact", "fem", "winding", "two_dof", "tribology", "coiled_stiff", "numerics"}
"""Rooms that compute: none of plotting's business."""

SOLVERS = {"dynamics", "contact", "fem", "numerics", "coiled_stiff", "two_dof", "winding", "mesh"}
"""Rooms whose insides report and jobs do not know."""


class Arrow(NamedTuple):
    """An import: file (relative to the package), line, and the full name of what it imports."""

    file: str
    line: int
    target: str


def files() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def module(path: Path) -> str:
    """Dotted name of a file."""
    name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
    return name.removesuffix(".__init__")


MODULES = {module(path): path for path in files()}


def imports(path: Path) -> Iterator[Arrow]:
    """Every import of a file, also those in functions and for type checkers."""
    file = str(path.relative_to(PACKAGE))
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Arrow(file, node.lineno, alias.name)
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                yield Arrow(file, node.lineno, full if full in MODULES else node.module)


@cache
def every_arrow() -> list[Arrow]:
    """Imports of all files; read once, and only where a test asks."""
    return [arrow for path in files() for arrow in imports(path)]


def room(name: str) -> str:
    """First part below the package; the package itself is `__init__`."""
    parts = name.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


def room_of(file: str) -> str:
    return Path(file).parts[0].removesuffix(".py")


def inside() -> list[Arrow]:
    return [arrow for arrow in every_arrow() if arrow.target.split(".")[0] == "wroll_fem"]


def test_every_room_has_a_layer() -> None:
    found = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    found |= {path.stem for path in PACKAGE.glob("*.py")} - {"__init__"}
    assert found <= set(LEVEL)
    assert {path.stem for path in PACKAGE.glob("*.py")} <= LOOSE


def test_no_arrow_points_upward() -> None:
    doors = {"__init__"}  # hands names on
    upward = [
        arrow
        for arrow in inside()
        if room_of(arrow.file) not in doors
        and (room(arrow.target) in doors or LEVEL[room(arrow.target)] > LEVEL[room_of(arrow.file)])
    ]
    assert not upward, "\n".join(map(str, upward))


def circles(arrows: dict[str, set[str]]) -> list[list[str]]:
    """Groups of nodes that reach each other (Tarjan)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in arrows.get(node, ()):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            group = stack[stack.index(node) :]
            del stack[stack.index(node) :]
            if len(group) > 1:
                found.append(sorted(group))

    for node in arrows:
        if node not in index:
            visit(node)
    return found


def test_circles_are_found() -> None:
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [["a", "b", "c"]]
    assert circles({"a": {"b"}, "b": set()}) == []


@pytest.mark.parametrize("rooms", [False, True], ids=["files", "rooms"])
def test_no_imports_form_a_circle(rooms: bool) -> None:
    arrows: dict[str, set[str]] = {}
    for arrow in inside():
        start = module(PACKAGE / arrow.file)
        ends = (room(start), room(arrow.target)) if rooms else (start, arrow.target)
        if "__init__" not in ends and "wroll_fem" not in ends and ends[0] != ends[1]:
            arrows.setdefault(ends[0], set()).add(ends[1])
    assert circles(arrows) == []


def test_dolfinx_is_known_in_fem_alone() -> None:
    heavy = {"dolfinx", "ufl", "basix", "ffcx"}
    users = {arrow.file for arrow in every_arrow() if arrow.target.split(".")[0] in heavy}
    assert {file for file in users if room_of(file) != "fem"} <= DOLFINX_VERSIONS


def test_plotting_computes_no_physics() -> None:
    assert [a for a in inside() if room_of(a.file) == "plotting" and room(a.target) in PHYSICS] == []


def test_reports_and_jobs_know_no_solver() -> None:
    assert [a for a in inside() if room_of(a.file) in ("report", "jobs") and room(a.target) in SOLVERS] == []


def test_nothing_in_the_package_imports_the_reproduction_or_the_tools() -> None:
    outside = {"reproduction", "tools", "tests", "support", "benchmarks"}
    assert [arrow for arrow in every_arrow() if arrow.target.split(".")[0] in outside] == []


def test_rooms_are_small_enough_to_be_seen_at_once() -> None:
    folders = {path.parent for path in files()} - {PACKAGE}
    crowded = {folder.name for folder in folders if len(list(folder.glob("*.py"))) > 16}  # 15 and __init__
    assert crowded <= set(MANY_FILES)


def test_no_file_is_long() -> None:
    folders = (PACKAGE, ROOT / "reproduction", ROOT / "tests", ROOT / "tools", ROOT / "benchmarks")
    long = [
        f"{path.relative_to(ROOT)}: {lines} lines"
        for folder in folders
        for path in sorted(folder.rglob("*.py"))
        if (lines := len(path.read_text(encoding="utf-8").splitlines())) > 400
    ]
    assert not long, "\n".join(long)


def compiled() -> Iterator[tuple[str, ast.FunctionDef]]:
    """Functions that numba compiles."""
    for path in files():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and any("njit" in ast.dump(d) for d in node.decorator_list):
                yield f"{path.relative_to(PACKAGE)}:{node.lineno} {node.name}", node


def test_no_kernel_takes_more_than_twelve_arguments() -> None:
    kernels = list(compiled())
    assert len(kernels) > 20
    crowded = [f"{name}: {len(f.args.args)} arguments" for name, f in kernels if len(f.args.args) > 12]
    assert not crowded, "\n".join(crowded)
