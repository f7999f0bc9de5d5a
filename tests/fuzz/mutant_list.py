"""List of sampled mutants with their outcomes, a CSV file that is kept in the repository.

A row names its mutant by file, function, change, and number among equal changes of this function, so that it is found
again after lines have moved. A row without outcome is to be run; several processes may write into one list.
"""

from __future__ import annotations

import csv
import random
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

from filelock import FileLock

from tests.fuzz.mutations import Mutant, functions_at, mutants_of, parses

ROOT = Path(__file__).resolve().parents[2]
KINDS = ("comparison", "arithmetic", "constant", "boolean", "condition", "negation", "removed", "returned")
COLUMNS = (
    "number", "file", "function", "kind", "before", "text", "ordinal", "line_text",
    "outcome", "by", "tests", "cpu", "budget", "verdict",
)  # fmt: skip
KILLED = ("killed", "hangs", "crashes", "import")
"""Outcomes of a mutant that was noticed; the others are survived, untested, gone (the code has changed) and ""."""

Row = dict[str, str]


def drawn(room: str, count: int, seed: int) -> list[Mutant]:
    """Mutants of a room, at most one per line; the same for the same code and seed, and more if more are wanted."""
    chance, found = random.Random(f"{seed} {room}"), []
    every: dict[str, list[Mutant]] = defaultdict(list)
    for path in sorted((ROOT / "wroll_fem" / room).rglob("*.py")):
        if path.name != "__init__.py":
            for mutant in mutants_of(path, ROOT):
                every[mutant.kind].append(mutant)
    lines: set[tuple[str, int]] = set()
    while len(lines) < count:
        mutant = chance.choice(every[chance.choice(KINDS)])
        if (mutant.file, mutant.line) not in lines and parses(mutant, ROOT):
            lines.add((mutant.file, mutant.line))
            found.append(mutant)
    return found


def equals(mutant: Mutant) -> list[Mutant]:
    """Equal changes of the same function, in the order of the file; the mutant is one of them."""
    path, where = ROOT / mutant.file, function_of(mutant)
    same = [
        m for m in mutants_of(path, ROOT) if (m.kind, m.before, m.text) == (mutant.kind, mutant.before, mutant.text)
    ]
    return [m for m in same if function_of(m) == where]


def function_of(mutant: Mutant) -> str:
    """Qualified name of the function around a mutant; empty outside of functions."""
    around = functions_at(ROOT / mutant.file, mutant.line)
    return around[0][0] if around else ""


def row_of(number: int, mutant: Mutant) -> Row:
    """Row of a mutant without outcome."""
    line = (ROOT / mutant.file).read_text(encoding="utf-8").splitlines()[mutant.line - 1]
    return dict.fromkeys(COLUMNS, "") | {
        "number": str(number), "file": mutant.file, "function": function_of(mutant), "kind": mutant.kind,
        "before": mutant.before, "text": mutant.text, "ordinal": str(equals(mutant).index(mutant)),
        "line_text": line.strip(),
    }  # fmt: skip


def found_again(row: Row) -> Mutant | None:
    """Mutant of a row in the present code; None if the code has changed there."""
    path = ROOT / row["file"]
    if not path.exists():
        return None
    keys = ("kind", "before", "text")
    same = [m for m in mutants_of(path, ROOT) if all(getattr(m, key) == row[key] for key in keys)]
    inside = [m for m in same if function_of(m) == row["function"]]
    lines = path.read_text(encoding="utf-8").splitlines()
    as_before = [m for m in inside if lines[m.line - 1].strip() == row["line_text"]]
    at = int(row["ordinal"])
    if at < len(inside) and inside[at] in as_before:
        return inside[at]
    return as_before[0] if len(as_before) == 1 else None


def draw(path: Path, rooms: dict[str, int], seed: int) -> None:
    """Write a new list, in an order in which every part is a sample of all rooms."""
    mutants = [mutant for room, count in rooms.items() for mutant in drawn(room, count, seed)]
    random.Random(seed).shuffle(mutants)
    write(path, [row_of(number, mutant) for number, mutant in enumerate(mutants)])


def read(path: Path) -> list[Row]:
    """Rows of a list."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def write(path: Path, rows: list[Row]) -> None:
    """Write a list in one step."""
    part = path.with_suffix(".part")
    with part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    part.replace(path)


def keep(path: Path, number: str, result: dict[str, Any]) -> None:
    """Store the outcome of one mutant."""
    with FileLock(str(path) + ".lock"):
        rows = read(path)
        for row in rows:
            if row["number"] == number:
                row.update({key: str(value) for key, value in result.items() if key in COLUMNS})
        write(path, rows)


def scores(rows: list[Row]) -> str:
    """Killed and all mutants that were run, by room and by kind, and the survivors."""
    lines, run = [], [row for row in rows if row["outcome"] not in ("", "gone", "untested")]
    groups = {"all": lambda row: "all", "room": lambda row: row["file"].split("/")[1], "kind": lambda row: row["kind"]}
    for group in groups.values():
        for value in sorted({group(row) for row in run}):
            counts = Counter(row["outcome"] for row in run if group(row) == value)
            equivalent = sum(row["verdict"].startswith("equivalent") for row in run if group(row) == value)
            killed = sum(counts[k] for k in KILLED)
            lines.append(f"{value:12} {killed:4} killed, {equivalent} equivalent, of {counts.total()}  {dict(counts)}")
    for row in run:
        if row["outcome"] == "survived":
            lines.append(
                f"{row['number']:>4} {row['file']} {row['function']}: `{row['line_text']}`: "
                f"{row['before']} -> {row['text']}  ({row['tests']} tests)  {row['verdict']}"
            )
    return "\n".join([f"{len(run)} of {len(rows)} mutants were run", *lines])
