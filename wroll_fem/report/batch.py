"""Report of a batch folder: table, figures, varied keys and failed cases."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from wroll_fem.errors import InputError
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.grid import REFERENCE, short_names
from wroll_fem.report import html
from wroll_fem.report.run import caption, logged, origin_table, plain_case, solved
from wroll_fem.report.values import open_balance, shown
from wroll_fem.results.summary import label

Row = dict[str, str]

_MAIN = (
    "f_n_hz", "zeta", "zeta_quality", "peak_transmissibility", "bending_hz", "friction_energy_j",
    "energy_balance_error", "max_slip_m", "slip_onset_g", "pressure_mandrel_pa", "capacity_mandrel_pa", "wall_time_s",
)  # fmt: skip
_NUMBER = re.compile(r"\d[\d.eE+-]*")


def batch_page(path: Path) -> str:
    """HTML report of a batch folder.

    Raises
    ------
    InputError
        If batch.csv is not the table of a batch.
    """
    rows = _table(path)
    columns = list(rows[0]) if rows else []
    keys = [name for name in columns if "." in name or name in ("case", "analysis")]
    grid = [row for row in rows if row["name"] != REFERENCE]
    kept = {key: {row[key] for row in grid if row[key] or row["status"] != "failed"} for key in keys}
    varied = [key for key in keys if len(kept[key]) > 1]
    constant = [(key, grid[0][key]) for key in keys if key not in varied] if grid else []
    failed = [row for row in rows if row["status"] == "failed"]
    done = [row for row in rows if row["status"] != "failed"]
    folders = [RunFolder(path / row["name"]) for row in rows]
    origins = [folder.provenance() for folder in folders]
    figures = html.join(html.figure(p, caption(p.stem)) for p in sorted((path / "figures").glob("*.png")))
    return html.page(
        f"Batch {path.resolve().name}",
        f"{len(rows)} cases · {len(done)} complete · {len(failed)} failed",
        [
            ("What was solved", _solved(folders, varied, grid, constant)),
            ("Warnings", html.notes(_warnings(rows, folders))),
            ("Cases", _cases(rows, varied)),
            ("Figures", figures),
            ("Energy ledger", _ledger(done, varied)),
            ("All metrics", html.folded(f"{len(columns)} columns of batch.csv", _everything(rows, columns))),
            ("Versions and provenance", _origins(origins)),
        ],
    )


def _table(path: Path) -> list[Row]:
    file = path / "batch.csv"
    with file.open(newline="", encoding="utf-8", errors="replace") as stream:
        rows = [{str(k): v or "" for k, v in row.items()} for row in csv.DictReader(stream)]
    if rows and not {"name", "status", "error"} <= set(rows[0]):
        raise InputError("is not the table of a batch", file=str(file), remedy="run `wroll batch` again")
    return rows


def _value(name: str, cell: str) -> str:
    """Cell of batch.csv with its unit."""
    if cell == "":
        return ""
    try:
        number = float(cell)
    except ValueError:
        return cell
    if "." in name:  # a key of the case: as written
        return f"{number:.6g}"
    return shown(name, int(number) if cell.lstrip("-").isdigit() else number)


def _solved(
    folders: Sequence[RunFolder], varied: list[str], rows: list[Row], constant: list[tuple[str, str]]
) -> html.Markup:
    varying = []
    for key in varied:
        counted = Counter(row[key] for row in rows)
        values = [_value(key, cell) or "(case file's)" for cell in counted]
        short = values if len(values) <= 12 else [*values[:5], "...", *values[-2:]]
        varying.append((key, f"{len(values)} values: {', '.join(short)}"))
    parts = [html.paragraph("What varies:"), html.terms(varying)] if varying else []
    if constant:
        parts.append(html.paragraph(f"Set for every case: {', '.join(f'{k} = {v}' for k, v in constant if v)}."))
    first = next((folder for folder in folders if folder.case_file.is_file()), None)
    if first is not None:
        written = first.case_file.read_text(encoding="utf-8", errors="replace")
        parts.append(html.subheading(f"Case {first.path.name}"))
        parts.append(solved(plain_case(written)))
        parts.append(html.folded("Its case file", html.listing(written)))
    return html.join(parts)


def _warnings(rows: list[Row], folders: Sequence[RunFolder]) -> list[tuple[str, bool]]:
    found = [(f"{row['name']} failed: {row['error']}", True) for row in rows if row["status"] == "failed"]
    gaps = {row["name"]: gap for row in rows if (gap := open_balance(row)) is not None}
    if gaps:
        worst = max(gaps, key=lambda name: gaps[name])
        where = f"{len(gaps)} cases, at worst {worst}" if len(gaps) > 1 else worst
        found.append((f"{where}: the energy balance error is {gaps[worst]:.2%} of the input.", True))
    warned: dict[str, list[tuple[str, str]]] = {}
    for folder in folders:
        for kind, words in dict.fromkeys(logged(folder)):
            if kind == "warning":
                warned.setdefault(_NUMBER.sub("#", words), []).append((folder.path.name, words))
    for cases in warned.values():
        name, words = cases[0]
        where = name if len(cases) == 1 else f"{len(cases)} cases, first {name}"
        found.append((f"{where}: {words}", False))
    return found


def _cases(rows: list[Row], varied: list[str]) -> html.Markup:
    main = [name for name in _MAIN if any(row.get(name) for row in rows)]
    head = ["case", "status", *short_names(varied).values(), *map(label, main)]
    lines = [
        [row["name"], row["status"], *(_value(name, row.get(name, "")) for name in (*varied, *main))] for row in rows
    ]
    return html.table(head, lines, numbers=range(2 + len(varied), len(head)))


def _ledger(rows: list[Row], varied: list[str]) -> html.Markup:
    """Table of the energies of every case, divided by its input work."""
    parts: list[html.Markup] = []
    for kind, given in (("At the end of the histories", "input_work_j"), ("Per cycle", "input_work_per_cycle_j")):
        names = [
            name for name in (rows[0] if rows else ())
            if name.endswith("_j") and name != given and ("per_cycle" in name) == ("per_cycle" in given)
            and "base_acceleration" not in name
        ]  # fmt: skip
        kept = [row for row in rows if row.get(given) and float(row[given]) != 0.0]
        if not kept:
            continue
        lines = [
            [row["name"], _value(given, row[given]),
             *(f"{100 * float(row[name]) / float(row[given]):.3g} %" if row.get(name) else "" for name in names),
             _value("energy_balance_error", row.get("energy_balance_error", ""))]
            for row in kept
        ]  # fmt: skip
        head = ["case", label(given), *map(label, names), label("energy_balance_error")]
        parts.append(
            html.paragraph(f"{kind}; shares of the input.") + html.table(head, lines, numbers=range(1, len(head)))
        )
    return html.join(parts)


def _everything(rows: list[Row], columns: list[str]) -> html.Markup:
    used = [name for name in columns if any(row[name] for row in rows)]
    return html.table(used, [[_short(row[name]) for name in used] for row in rows])


def _short(cell: str) -> str:
    """Cell of the table; numbers are rounded to eight digits."""
    try:
        return cell if cell.lstrip("-").isdigit() else f"{float(cell):.8g}"
    except ValueError:
        return cell


def _origins(origins: Sequence[dict[str, Any]]) -> html.Markup:
    kept = [origin for origin in origins if origin]
    if not kept:
        return html.paragraph("No case has a provenance.json.")
    revisions = Counter(str((origin.get("git") or {}).get("revision")) for origin in kept)
    versions = {str(origin.get("versions")) for origin in kept}
    words = []
    if len(revisions) > 1 or len(versions) > 1:
        words.append(html.notes([(f"The cases were run with different code: {len(revisions)} revisions of the "
                                  f"program, {len(versions)} sets of library versions.", False)]))  # fmt: skip
    return html.join(words) + html.paragraph("Of the first case:") + origin_table(kept[0])
