"""List of the package's files in docs/architecture.md: the first sentence of each and its names."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "wroll_fem"
BEGIN, END = "<!-- List made by `make schema` from the files. -->\n", "\n<!-- End of list. -->"


def files_list() -> str:
    """Markdown: a heading per room, its sentence, and a line per file."""
    rooms = sorted({path.parent for path in PACKAGE.rglob("*.py")} - {PACKAGE})
    parts = [_room(PACKAGE, "the top"), *(_room(room, str(room.relative_to(PACKAGE))) for room in rooms)]
    return "\n\n".join(parts)


def with_list(page: str) -> str:
    """Page with the list between its two markers replaced."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}{files_list()}{END}{after}"


def write_list(path: Path) -> Path:
    """Write the list into a page."""
    path.write_text(with_list(path.read_text(encoding="utf-8")), encoding="utf-8")
    return path


def _room(folder: Path, name: str) -> str:
    lines = [f"### {name}"]
    if folder != PACKAGE:
        lines += ["", _sentence(folder / "__init__.py")]
    lines += ["", *(_line(path) for path in sorted(folder.glob("*.py")) if path.name != "__init__.py")]
    return "\n".join(lines)


def _line(path: Path) -> str:
    names = list(_names(path))
    parts = [f"- `{path.relative_to(ROOT)}`: {_sentence(path)}"]
    for title, private in (("", False), ("Inside: ", True)):
        found = [f"`{name}`" for name in names if name.startswith("_") == private]
        if found:
            parts.append(f"{title}{', '.join(found)}.")
    return " ".join(parts)


def _sentence(path: Path) -> str:
    """First paragraph of the module's docstring, in one line."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    first = " ".join(text.partition("\n\n")[0].split()).replace("<", "&lt;").replace("|", "\\|")
    return re.sub(r"\$", r"\\$", first)


def _names(path: Path) -> Iterator[str]:
    """Classes and functions of a file."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
