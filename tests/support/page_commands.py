"""Commands that README and docs show: in fenced shell blocks, in indented lines and in inline code."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from support.paths import ROOT

PAGES = [
    ROOT / "README.md", ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "docs" / "tables").glob("*.md")),
    ROOT / "meshes" / "README.md", *sorted((ROOT / "notebooks").glob("*.py")),
]  # fmt: skip
_COMMAND = re.compile(r"([A-Z_]+=\S+ )*(wroll|make|pip|apt|dask|gmsh|jupyter|cp|\.venv/bin/\S+)( |$)")
_FENCE = re.compile(r"^```(\S*)[^\n]*\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)


def shown(page: Path) -> Iterator[tuple[str, bool]]:
    """Inline code, indented lines and lines of shell blocks, without comments and prompts; whether in a block."""
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".py":
        text = "\n".join(line.removeprefix("# ") for line in text.splitlines() if line.startswith("# "))
    for part in re.split(r"(^```[^\n]*\n.*?^```$)", text, flags=re.DOTALL | re.MULTILINE):
        fence = _FENCE.match(part)
        if fence is None:
            words = re.findall(r"(?<!`)`([^`\n]+)`(?!`)", part) + re.findall(r"^ {4}(\S.*)$", part, flags=re.MULTILINE)
        elif fence[1] in ("", "sh", "bash", "console", "shell"):
            words = [line.removeprefix("$ ") for line in fence[2].splitlines() if line.strip()]
        else:
            words = []
        yield from ((re.sub(r"(^|\s+)#.*", "", line).strip(), fence is not None) for line in words)


def commands(page: Path) -> list[str]:
    """Commands of a page in their order."""
    found = dict.fromkeys(line for line, block in shown(page) if block or _COMMAND.match(line))
    return [line for line in found if line]


def of_another_python(text: str) -> bool:
    """Whether a text is a command that `commands` does not find, as it does not begin with `.venv/bin/python`."""
    return re.match(r"(python[\d.]*|pytest) |(\./)?(tools|benchmarks|tests)/\S+\.py \S", bare(text)) is not None


def bare(command: str) -> str:
    """A command without the environment in front of it."""
    return re.sub(r"^([A-Z_]+=\S+ )+", "", command)
