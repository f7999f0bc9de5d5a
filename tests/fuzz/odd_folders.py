"""Reports of run folders whose case.yaml, provenance.json and summary.json have content of other types.

    PYTHONPATH=.:tests python -m tests.fuzz.odd_folders --seed 1 --count 5000

A defect is anything but a report or an error in one line, or more than 5 s of CPU.
"""

from __future__ import annotations

import argparse
import copy
import json
import random
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path
from typing import Any

from tests.fuzz.case_files import RAM_DISK
from wroll_fem.case import load_case
from wroll_fem.case.strict_yaml import dump_yaml
from wroll_fem.errors import WrollError
from wroll_fem.report import write_report
from wroll_fem.results.summary import SUMMARY

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
HANG = 5.0
VALUES: list[Any] = [
    None, True, False, 0, 1, -1, 1.5, 1e308, -1e-320, 10**400, "", "x", "é" * 50, "dwell", "1e3", "2001-99-99", [], {},
    [None], ["a", 1], [[1]], [{"a": 1}], [{"a": 1}, 2], {"a": 1}, {"kind": "x"}, {"kind": [1]}, {"law": {}}, {"": None},
    {1: 2}, {None: [{2: 3}]},
]  # fmt: skip
KEYS = ["kind", "a", "mu", "material", "law", "E", "", 1]
ORIGIN = {
    "status": "complete", "case_hash": "ab", "command": "x", "time_utc": "2026-01-01T00:00:00", "wall_time_s": 3.2,
    "git": {"commit": "a", "dirty": False}, "versions": {"a": "1"}, "machine": {"a": "b"}, "seeds": {}, "exit_code": 0,
    "error": "", "resumed": False,
}  # fmt: skip


def odd(chance: random.Random, depth: int = 0) -> Any:
    """Value of any type, up to three levels deep."""
    if depth > 1 or chance.random() < 0.7:
        return copy.deepcopy(chance.choice(VALUES))
    entries = [odd(chance, depth + 1) for _ in range(chance.randint(0, 3))]
    return entries if chance.random() < 0.5 else {chance.choice(KEYS): entry for entry in entries}


def changed(data: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    """Copy with one to three values, at any depth, replaced by odd ones."""
    data = copy.deepcopy(data)
    for _ in range(chance.randint(1, 3)):
        here: Any = data
        while here:
            key = chance.choice(list(here) if isinstance(here, dict) else list(range(len(here))))
            if not (isinstance(here[key], dict | list) and here[key] and chance.random() < 0.6):
                here[key] = odd(chance)
                break
            here = here[key]
    return data


def fill(folder: Path, cases: list[dict[str, Any]], chance: random.Random) -> None:
    """Write the three files of a folder."""
    case = chance.choice(cases)
    (folder / "case.yaml").write_text(dump_yaml(changed(case, chance) if chance.random() < 0.8 else odd(chance)))
    origin = changed(ORIGIN, chance) if chance.random() < 0.7 else ORIGIN
    (folder / "provenance.json").write_text(json.dumps(origin))
    numbers = {chance.choice(list(SUMMARY)): odd(chance) for _ in range(3)} if chance.random() < 0.4 else {}
    (folder / "summary.json").write_text(json.dumps({"analysis": case["analysis"], **numbers}))


def outcome(folder: Path) -> str:
    """How a report of the folder ends; a defect begins with "DEFECT"."""
    started = time.process_time()
    try:
        write_report(folder)
        told = "report"
    except WrollError as error:
        told = "one line" if str(error).count("\n") == 0 else "DEFECT: lines"
    except Exception as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        told = f"DEFECT: {type(error).__name__} in {Path(frame.filename).name}:{frame.lineno}"
    return told if time.process_time() - started < HANG else "DEFECT: hangs"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=1000)
    given = parser.parse_args()
    cases = [load_case(path).model_dump(mode="json") for path in sorted(CONFIGS.glob("*.yaml"))]
    found: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(dir=RAM_DISK) as scratch:
        folder = Path(scratch) / "run"
        folder.mkdir()
        for number in range(given.count):
            fill(folder, cases, random.Random(f"{given.seed} {number}"))
            told = outcome(folder)
            if told.startswith("DEFECT") and told not in found:
                print(f"{number}: {told}", flush=True)
            found[told] += 1
    print(f"seed {given.seed}: {given.count} folders, {time.process_time():.0f} s of CPU: {dict(found)}")


if __name__ == "__main__":
    main()
