"""Columns of a text file with one row per sample."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

COMMENTS = ("#", "%", "//")
"""Starts of lines that are skipped at the top of the file."""

MOST_HEADERS = 2
"""Lines of words above the numbers: names, and units."""


def csv_columns(path: Path) -> dict[str, FloatArray]:
    """Name -> values (n,) of a text file, separated by comma, semicolon, tab or blanks.

    Lines of names and units may stand above the numbers; without names the columns are called 1, 2, ... A record that
    is cut off within a row is refused: each row has as many numbers as the first, and the last ends with a line break.

    Raises
    ------
    InputError
        If a row differs from the first, or the file is empty, is no text, or is cut off.
    """
    where = str(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("the file is no UTF-8 text", file=where, remedy="save it as CSV with UTF-8 encoding") from None
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", file=where, remedy="check the file") from None
    if "\x00" in text:
        raise InputError("the file contains zero bytes: it is no text, or damaged", file=where, remedy="write it again")
    if text and not text.endswith(("\n", "\r")):
        raise InputError(
            "the last row does not end with a line break: the file may be cut off", file=where,
            remedy="write it again, or add a line break if it is complete",
        )  # fmt: skip
    lines = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
    while lines and lines[0][1].lstrip().startswith(COMMENTS):
        lines.pop(0)
    if not lines:
        return {}
    separator = _separator([line for _, line in islice(lines, 5)])
    rows = [(k, [cell.strip() for cell in line.split(separator)]) for k, line in lines]
    headers: list[list[str]] = []
    while rows and len(headers) < MOST_HEADERS and not any(map(_is_number, rows[0][1])):
        headers.append(rows.pop(0)[1])
    if not rows:
        return {}
    names = _names(headers, len(rows[0][1]), where)
    values = _numbers(rows, where)
    return dict(zip(names, values.T, strict=True))


def _separator(lines: list[str]) -> str | None:
    """Separator of most of some lines; None for blanks."""
    return next((mark for mark in (";", "\t", ",") if 2 * sum(mark in line for line in lines) > len(lines)), None)


def _names(headers: list[list[str]], count: int, where: str) -> list[str]:
    if not headers:
        return [str(k) for k in range(1, count + 1)]
    names = [name.strip("\"' ") for name in headers[0]]
    if len(names) != count:
        raise InputError(
            f"{len(names)} names over {count} columns", file=where, remedy="separate names and numbers alike"
        )
    if len(set(names)) != count or not all(names):
        raise InputError(f"names of columns are empty or repeated: {names}", file=where, remedy="give one name each")
    return names


def _numbers(rows: list[tuple[int, list[str]]], where: str) -> FloatArray:
    count = len(rows[0][1])
    for k, cells in rows:
        if len(cells) != count:
            raise InputError(
                f"line {k} has {len(cells)} columns, the first row {count}: the file is damaged or cut off",
                file=where, remedy="write it again",
            )  # fmt: skip
    try:
        return np.array([cells for _, cells in rows], dtype=np.float64)
    except ValueError:
        for k, cells in rows:
            for c, cell in enumerate(cells, start=1):
                if not _is_number(cell):
                    remedy = "write decimal points" if "," in cell else "write a number in each cell"
                    problem = f"line {k}, column {c}: {cell[:40]!r} is no number"
                    raise InputError(problem, file=where, remedy=remedy) from None
        raise InputError("the numbers cannot be read", file=where, remedy="write plain decimal numbers") from None


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return "_" not in text
