"""Structured fuzz of case files through `wroll validate`, in this process.

    python -m tests.fuzz.case_files --count 100000 --seed 1

A case is a shipped case file with one to six changes: hostile numbers, texts, types and sections, changes of the text
itself. It must be refused with exit code 2 in lines that fit a terminal, or be valid; within 5 s of CPU time.
"""

from __future__ import annotations

import argparse
import contextlib
import copy
import io
import random
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import typer
import yaml

from wroll_fem.cli.cases import validate

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = sorted((ROOT / "configs").glob("*.yaml"))
LONGEST = 1600
"""Longest line of a message that is accepted: file, key, problem and remedy are cut at 300, 120, 600 and 800."""

SECONDS, WAITING = 5, 300
"""CPU seconds, and seconds on the clock, after which a case hangs; other processes may take most of the clock."""

RAM_DISK = Path("/dev/shm")
"""Writing costs little there."""

DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
"""A tenth of the time of a case, where PyYAML was built with libyaml, in place of a quarter."""

NUMBERS: tuple[Any, ...] = (
    0, 1, -1, 2, 3, 7, 0.0, -0.0, 1e-3, 1e3, 1e6, 1e9, 1e12, 1e29, 1e30, 1.1e30, 1e-29, 1e-30, 9e-31, 1e300, 1e308,
    5e-324, -1e308, float("inf"), float("-inf"), float("nan"), 10**18, 10**400, -(10**20), 2**63, 2**31, 1.7e-7, 0.5,
    0.49999, 0.25, -0.41421, 1e5, 2.7e9, 50, 100, 1000, 9999, 20000,
)  # fmt: skip
TEXTS = (
    "", " ", "x", "1e-3", "1e3", "0150", "2:30", "1_000", "１５０", "1 mm", "1200 mm", "70 GPa", "1 GPa mm", "3 dB",
    "5 %",
    "1e400 m", "1 m**9", "20 ms", "30 rpm", "1 degC", "0.5 g", "nan", "inf", ".inf", "yes", "no", "on", "null", "~",
    "auto", "all", "none", "full", "reduced", "PET", "aluminium", "../x", "/dev/null", "/", "a" * 300, "é",
    "\U0001f600",
    "2001-12-14", "!!int 3", "*a", "&a", "=cmd|x", "@", "-", "--", "0x10", "0o17", "0b11", "+.5", "1.", ".5", "1e",
    "e1",
)  # fmt: skip
ODD: tuple[Any, ...] = (
    None,
    True,
    False,
    [],
    {},
    [[]],
    [1],
    [1, 2],
    [1, "x"],
    {"a": 1},
    [None],
    [[1, 2], [3, 4]],
    [[1], 2],
)
LINES = (
    "a: !!binary MTUw", "a: !!timestamp x", "a: !!set {b}", "a: !!float x", "a: !foo 1", "a: &g {b: *g}", "b: *nowhere",
    "a: 2001-99-99", "a: 0x_", "a: 0b_", "? [1, 2]\n: 3", "? {a: 1}\n: 2", "1: 2", "null: 1", "1.5: 1", "true: 1",
    "<<: {analysis: modal}", "<<: 3", "<<: [1]", "a: " + "[" * 200, "a: " + "{b: " * 60 + "1" + "}" * 60,
    "a: '\\uD83D'",
    'a: "\\uD83D"', 'a: "\\0"', "a: \"\\e[31m\"", "---", "...", "%YAML 1.1", "%TAG ! x", "\t", "a: |\n  b",
    "a: >-\n  b",
    "a: " + "9" * 5000, "a: " + "x" * 5000, "x" * 500 + ": 1", "analysis: dwell", "a: 1\na: 1", "- 1", "a", "'", '"',
)  # fmt: skip

Path_ = tuple[Any, ...]


def places(data: Any, path: Path_ = ()) -> list[Path_]:
    """Path of every value of nested dicts and lists."""
    found = [path] if path else []
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in entries:
        found += places(value, (*path, key))
    return found


def around(data: Any, path: Path_) -> Any:
    """Container of the value at ``path``."""
    for part in path[:-1]:
        data = data[part]
    return data


def changed(data: dict[str, Any], chance: random.Random, donor: dict[str, Any]) -> None:
    """One random change in place."""
    spots = places(data)
    if not spots:
        return
    path = chance.choice(spots)
    here, key = around(data, path), path[-1]
    what = chance.random()
    if what < 0.4:
        here[key] = chance.choice(NUMBERS)
    elif what < 0.5:
        value = here[key]
        if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 10**300:
            here[key] = value * 10.0 ** chance.choice((-9, -6, -3, -1, 1, 3, 6, 9)) * chance.choice((1, -1))
    elif what < 0.65:
        here[key] = chance.choice(TEXTS)
    elif what < 0.72:
        here[key] = copy.deepcopy(chance.choice(ODD))
    elif what < 0.8:
        del here[key]
    elif what < 0.85 and isinstance(here, list):
        here.extend(copy.deepcopy([here[key]] * chance.choice((1, 3, 300))))
    elif what < 0.92:
        other = chance.choice(places(donor))
        name = other[0]
        data[name] = copy.deepcopy(donor[name])
    elif isinstance(here, dict):
        here[chance.choice((*TEXTS, *NUMBERS, str(key) + "x", str(key)[:-1], None))] = here.pop(key)


def damaged(text: str, chance: random.Random) -> str:
    """One random change of a text."""
    what, at = chance.random(), chance.randrange(len(text) + 1)
    if what < 0.3:
        return (
            text[:at]
            + chance.choice(
                (
                    "{",
                    "}",
                    "[",
                    "]",
                    ":",
                    ",",
                    "-",
                    "\n",
                    "  ",
                    "&a ",
                    "*a ",
                    "!!",
                    "'",
                    '"',
                    "#",
                    "\0",
                    "\ufeff",
                    "\ud83d",
                    "%",
                    "|",
                    ">",
                    "?",
                    "<<: ",
                )
            )
            + text[at:]
        )
    if what < 0.5:
        return text[:at]
    if what < 0.6:
        end = chance.randrange(len(text) + 1)
        return text[: min(at, end)] + text[max(at, end) :]
    lines = text.splitlines()
    lines.insert(chance.randrange(len(lines) + 1), chance.choice(LINES))
    return "\n".join(lines)


def case_text(seed: int, number: int, parsed: list[dict[str, Any]]) -> str:
    """Text of case ``number``."""
    chance = random.Random(f"{seed}:{number}")
    data = copy.deepcopy(chance.choice(parsed))
    donor = chance.choice(parsed)
    for _ in range(chance.choice((1, 1, 1, 2, 3, 6))):
        changed(data, chance, donor)
    text = str(yaml.dump(data, Dumper=DUMPER, sort_keys=False, allow_unicode=True))
    return damaged(text, chance) if chance.random() < 0.15 else text


def outcome(action: Callable[[], object]) -> tuple[int | str, str]:
    """Exit code of a command and its output; for a defect its name and the traceback."""
    out = io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out), time_limit():
            action()
        return 0, out.getvalue()
    except typer.Exit as end:
        return end.exit_code, out.getvalue()
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        frame = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__} {Path(frame.filename).name}:{frame.lineno}", traceback.format_exc()


class Hangs(BaseException):
    """A case takes more than `SECONDS` of CPU time, or waits; no handler of the package catches it."""


def too_slow(signum: int, frame: FrameType | None) -> None:
    raise Hangs


@contextlib.contextmanager
def time_limit() -> Iterator[None]:
    """Raise `Hangs` in a block that takes too long; a loop inside of compiled code is not interrupted."""
    for timer, number, most in (
        (signal.ITIMER_VIRTUAL, signal.SIGVTALRM, SECONDS),
        (signal.ITIMER_REAL, signal.SIGALRM, WAITING),
    ):
        signal.signal(number, too_slow)
        signal.setitimer(timer, most)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)


def requests_to_stop() -> list[int]:
    """Signals SIGTERM that have arrived; the search ends after its present case, with its figures."""
    arrived: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, frame: arrived.append(number))
    return arrived


def defect_of(code: int | str, output: str) -> str:
    """Name of the defect that an outcome shows, or ""."""
    if isinstance(code, str):
        return code
    if code not in (0, 2):
        return f"exit code {code}"
    longest = max(map(len, output.splitlines()), default=0)
    return f"line of {longest // 1000} thousand characters" if longest > LONGEST else ""


def main() -> None:
    """Run the cases; print every class of defects with its first case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=1e9, help="stop after this CPU time")
    chosen = parser.parse_args()
    parsed = [yaml.safe_load(path.read_text(encoding="utf-8")) for path in CONFIGS]
    scratch = tempfile.TemporaryDirectory(dir=RAM_DISK if RAM_DISK.is_dir() else None)
    for name in ("configs", "meshes"):  # a case may name files beside it
        shutil.copytree(ROOT / name, Path(scratch.name) / name)
    file = Path(scratch.name) / "configs" / "case.yaml"
    asked, codes = requests_to_stop(), Counter[int | str]()
    defects: dict[str, tuple[int, str]] = {}
    started, slowest, done = time.process_time(), 0.0, 0
    try:
        for number in range(chosen.first, chosen.first + chosen.count):
            file.write_text(case_text(chosen.seed, number, parsed), encoding="utf-8", errors="surrogatepass")
            begun = time.process_time()
            code, output = outcome(lambda: validate([file]))
            slowest, done = max(slowest, time.process_time() - begun), done + 1
            codes[code if isinstance(code, int) else "defect"] += 1
            name = defect_of(code, output)
            if name and name not in defects:
                defects[name] = number, output
                print(f"--- {name}: case {number}\n{output[-1500:]}", flush=True)
            if asked or time.process_time() - started > chosen.seconds:
                break
    finally:
        scratch.cleanup()
    seconds = time.process_time() - started
    print(f"seed {chosen.seed}: {done} cases from {chosen.first}, {seconds:.0f} s of CPU, slowest {slowest:.2f} s")
    print(f"exit codes {dict(codes)}; {len(defects)} classes of defects: {list(defects)}")
    sys.exit(bool(defects))


if __name__ == "__main__":
    main()
