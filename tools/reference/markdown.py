"""Markdown of the reference pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

GENERATED = "<!-- Made from the code by `make schema`; edit the code, not this page. -->"


def code(text: str) -> str:
    """Text as inline code."""
    return f"`{text}`"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Table with one line per row; bars and line ends inside cells are escaped."""
    lines = [list(head), ["---"] * len(head), *([*row] for row in rows)]
    return "\n".join("| " + " | ".join(_cell(text) for text in line) + " |" for line in lines)


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())


def prose(text: str) -> str:
    """Description with Markdown characters escaped, except in code spans."""
    parts = text.split("`")
    parts[::2] = [part.replace("*", "\\*").replace("_", "\\_").replace("<", "\\<") for part in parts[::2]]
    return "`".join(parts)
