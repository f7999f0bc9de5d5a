"""Table of the three flight rolls over the preload (docs/chapter6.md), from the studies of `wroll reproduce ch6`.

Usage: python -m tools.flight_table runs/reproduce
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

ROLLS = {"irosa": "iROSA", "sspp": "SSPP", "habex": "HabEx"}

Row = dict[str, str]


def cases(folder: Path, study: str) -> dict[tuple[str, float], Row]:
    """Finished cases of a study by roll and external pressure in Pa."""
    with (folder / "studies" / study / "batch.csv").open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["status"] == "complete"]
    return {(row["case"].split("_")[0], float(row["preload.pressure"])): row for row in rows}


def damping(row: Row) -> str:
    """Damping ratio in per cent, with its quality if this is not good; empty without one."""
    if not row["zeta"]:
        return ""
    doubt = " (doubtful)" if row["zeta_quality"] == "doubtful" else ""
    return f"{100 * float(row['zeta']):.1f} %{doubt}"


def decimal(text: str) -> str:
    """Number with one decimal; none where a case has no reading (a resonance that grows without bound)."""
    return f"{float(text):.1f}" if text else "none"


def rounded(value: float) -> str:
    """Two significant digits or, from 100 on, a whole number."""
    return f"{value:.0f}" if value >= 10 else f"{value:.2g}"


def table(folder: Path) -> list[str]:
    """Lines of the table."""
    steady, chirps, edge = (cases(folder, f"flight_{name}") for name in ("preload", "chirp", "inner_edge"))
    lines = [
        "| roll | external pressure, kPa | f_n, Hz | peak | zeta (half power) | chirp: f_n, Hz; peak; friction work, J "
        "| inner edge clamped: f_n, Hz; peak; zeta |",
        "|---|---|---|---|---|---|---|",
    ]
    for roll, pressure in sorted(chirps, key=lambda key: (list(ROLLS).index(key[0]), key[1])):
        curve, chirp, clamped = (found.get((roll, pressure)) for found in (steady, chirps, edge))
        cells = [ROLLS[roll], f"{1e-3 * pressure:g}"]
        if curve is None:
            cells += ["none", "", ""]
        else:
            cells += [decimal(curve["f_n_hz"]), decimal(curve["peak_transmissibility"]), damping(curve)]
        assert chirp is not None
        cells.append(
            f"{decimal(chirp['f_n_hz'])}; {decimal(chirp['peak_transmissibility'])}; "
            f"{rounded(float(chirp['friction_energy_j']))}"
        )
        cells.append(
            "none" if clamped is None else
            f"{decimal(clamped['f_n_hz'])}; {decimal(clamped['peak_transmissibility'])}; {damping(clamped)}"
        )  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return lines


if __name__ == "__main__":
    print("\n".join(table(Path(sys.argv[1]))))
