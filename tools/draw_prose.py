"""Draw random docstrings and messages of the package, to read them as a stranger would.

.venv/bin/python tools/draw_prose.py [--seed 1] [--count 125] [FOLDER ...]
"""

from __future__ import annotations

import argparse
import ast
import random
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
CALLS = {"InputError", "ConvergenceError", "validation_error", "warning", "info", "warn", "_warn", "echo"}
"""Calls whose texts a user reads."""


def prose(path: Path) -> Iterator[tuple[int, str]]:
    """Line and text of every docstring and every message of a file."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    docstrings = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, *FUNCTIONS)):
            text = ast.get_docstring(node)
            if text:
                docstrings.add(id(node.body[0]))
                yield getattr(node, "lineno", 1), text.split("\n\n")[0]
        elif id(node) in docstrings:
            continue
        elif isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name in CALLS:
                yield node.lineno, ast.unparse(node)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.lineno, node.value.value


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path, default=[ROOT / "wroll_fem"])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=125)
    asked = parser.parse_args()
    paths = [path for folder in asked.folders for path in sorted(folder.resolve().rglob("*.py"))]
    found = sorted({(str(path.relative_to(ROOT)), line, text) for path in paths for line, text in prose(path)})
    chosen = random.Random(asked.seed).sample(found, min(asked.count, len(found)))
    print(f"{len(chosen)} of {len(found)} texts, seed {asked.seed}")
    for number, (file, line, text) in enumerate(sorted(chosen), 1):
        print(f"{number:3} {file}:{line}: {' '.join(text.split())}")


if __name__ == "__main__":
    main()
