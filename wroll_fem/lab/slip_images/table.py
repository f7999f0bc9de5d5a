"""Table of the targets: group and layer of each, as a CSV file."""

from __future__ import annotations

import csv
import difflib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.regions.regions import Regions
from wroll_fem.typing import FloatArray, IntArray

MANDREL = 0
"""Number that stands for the mandrel in place of a layer."""

_NEEDED = ("target", "group", "layer")
_LARGEST, _SMALLEST = 1e9, 1e-9
"""Limit of the numbers (nan is refused too), and least diameter, mm or px."""
_OPTIONAL = ("x_px", "y_px", "diameter_px", "diameter_mm")


@dataclass(frozen=True)
class Member:
    """Row of the table.

    Attributes
    ----------
    target
        Place of the target in the recording, from 0; -1 for a target that is not used.
    group
        Longitudinal position.
    layer
        Layer, 0 for the mandrel.
    diameter
        Outer diameter, m; None if unknown.
    """

    target: int
    group: int
    layer: int
    diameter: float | None = None


def read_table(path: Path, targets: Regions) -> tuple[Member, ...]:
    """Read the table of a recording.

    Parameters
    ----------
    path
        CSV file with the columns target (number from 1), group, layer (number, or mandrel), and perhaps x_px, y_px and
        diameter_px of each target in a first frame, and diameter_mm. With x_px and y_px the rows belong to the nearest
        targets, whatever their numbers. Rows without a layer are not used.
    targets
        Targets of the first frame.

    Returns
    -------
    tuple of Member
        Rows in the order of groups and layers.

    Raises
    ------
    InputError
        If a column or value is wrong, a target is named twice or does not exist, or a group has no mandrel.
    """
    rows = _rows(path)
    numbers = [_integer(row, "target", path, k) for k, row in rows]
    placed = _placed(rows, targets, path) if rows and _has(rows[0][1], "x_px", "y_px") else None
    members = []
    for n, (k, row) in enumerate(rows):
        if not row.get("layer"):
            continue
        layer = MANDREL if row["layer"].strip().lower() == "mandrel" else _integer(row, "layer", path, k)
        diameter = _number(row, "diameter_mm", path, k)
        place = numbers[n] - 1 if placed is None else int(placed[n])
        if not 0 <= place < len(targets):
            raise InputError(
                f"line {k}: target {numbers[n]}, but the first frame has {len(targets)} targets", file=str(path),
                remedy="see the numbers in the figure targets.png, or change the limits of targets",
            )  # fmt: skip
        group = _integer(row, "group", path, k)
        members.append(Member(place, group, layer, None if diameter is None else 1e-3 * diameter))
    _check(members, path)
    return tuple(sorted(members, key=lambda m: (m.group, m.layer)))


def matched(
    position: FloatArray, diameter: FloatArray | None, targets: Regions, reach: float
) -> tuple[IntArray, FloatArray]:
    """Targets nearest to given positions, each used once; concentric ones are told apart by their diameter.

    Parameters
    ----------
    position
        (n, 2), px.
    diameter
        (n,), px; None: not known.
    targets
        Targets of a first frame.
    reach
        Distance, px, that counts as much as a change of the diameter by a fifth.

    Returns
    -------
    tuple
        (n,) place of each target, -1 for rows beyond their number; (n,) distance, px.
    """
    distance = np.hypot(*(position[:, None] - targets.centroid[None]).T).T
    cost = (distance / reach) ** 2
    if diameter is not None:
        cost = cost + (np.log(targets.diameter[None] / diameter[:, None]) / 0.2) ** 2
    rows, columns = linear_sum_assignment(cost)
    place = np.full(len(position), -1, dtype=np.int64)
    place[rows] = columns
    return place, np.where(place >= 0, distance[np.arange(len(position)), place], np.inf)


def _placed(rows: Sequence[tuple[int, dict[str, str]]], targets: Regions, path: Path) -> IntArray:
    where = [[_number(row, name, path, k) for name in ("x_px", "y_px", "diameter_px")] for k, row in rows]
    missing = next((k for (k, _), w in zip(rows, where, strict=True) if w[0] is None or w[1] is None), None)
    if missing is not None:
        raise InputError(
            f"line {missing}: x_px or y_px is missing", file=str(path), remedy="fill in both, or remove both columns"
        )
    sizes = None if any(w[2] is None for w in where) else np.array([w[2] for w in where], dtype=float)
    reach = float(targets.diameter.min())
    place, distance = matched(np.array([w[:2] for w in where], dtype=float), sizes, targets, reach)
    for n, ((k, row), far) in enumerate(zip(rows, distance, strict=True)):
        if row.get("layer") and far > reach:
            raise InputError(
                f"line {k}: no target within {reach:.3g} px of x = {where[n][0]:g} px, y = {where[n][1]:g} px",
                file=str(path), remedy="write the table for this recording, or change the limits of targets",
            )  # fmt: skip
    return place


def _check(members: Sequence[Member], path: Path) -> None:
    if not members:
        raise InputError("no target has a layer", file=str(path), remedy="fill in the columns group and layer")
    seen: set[tuple[int, int]] = set()
    for member in members:
        if (member.group, member.layer) in seen:
            layer = "the mandrel" if member.layer == MANDREL else f"layer {member.layer}"
            raise InputError(
                f"group {member.group} has {layer} twice", file=str(path), remedy="one target for each group and layer"
            )
        seen.add((member.group, member.layer))
    twice = [m.target for n, m in enumerate(members) if any(m.target == o.target for o in members[:n])]
    if twice:
        raise InputError(f"target {twice[0] + 1} is listed twice", file=str(path), remedy="list each target once")
    for group in sorted({m.group for m in members}):
        if (group, MANDREL) not in seen:
            raise InputError(
                f"group {group} has no target on the mandrel", file=str(path),
                remedy="write mandrel in the column layer of the reference target",
            )  # fmt: skip


def _rows(path: Path) -> list[tuple[int, dict[str, str]]]:
    """Lines of the file with their numbers; names and cells without blanks."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no UTF-8 text"
        raise InputError(f"cannot be read ({reason})", file=str(path), remedy="give a CSV file") from None
    lines = [
        (k, row) for k, row in enumerate(csv.reader(text.splitlines()), start=1) if any(cell.strip() for cell in row)
    ]
    names = [cell.strip().lower() for cell in lines[0][1]] if lines else []
    for name in _NEEDED:
        if name not in names:
            near = difflib.get_close_matches(name, names, 1)
            did = f"rename the column {near[0]!r}" if near else "write a first line target,group,layer"
            raise InputError(f"column {name!r} is missing", file=str(path), remedy=did)
    found = []
    for k, row in lines[1:]:
        if len(row) > len(names):
            raise InputError(
                f"line {k} has {len(row)} cells, the first line {len(names)}", file=str(path), remedy="remove cells"
            )
        found.append((k, {name: cell.strip() for name, cell in zip(names, row, strict=False)}))
    return found


def _has(row: dict[str, str], *names: str) -> bool:
    return all(name in row for name in names)


def _integer(row: dict[str, str], name: str, path: Path, line: int) -> int:
    value = _number(row, name, path, line)
    if value is None or value != int(value) or value < (1 if name == "target" else 0):
        raise InputError(
            f"line {line}: {name} is {row.get(name) or 'empty'}", file=str(path),
            remedy="write a whole number" + (" or mandrel" if name == "layer" else ""),
        )  # fmt: skip
    return int(value)


def _number(row: dict[str, str], name: str, path: Path, line: int) -> float | None:
    text = row.get(name, "")
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not abs(value) < _LARGEST or (name.startswith("diameter") and value < _SMALLEST):
        what = "a number" + (" or mandrel" if name == "layer" else "")
        raise InputError(f"line {line}: {name} is {text!r}", file=str(path), remedy=f"write {what}")
    return value
