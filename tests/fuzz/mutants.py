"""Mutation testing: do the tests of a module notice a small change of it?

    PYTHONPATH=.:tests python -m tests.fuzz.mutants --work /tmp/mutants --seed 1 --rooms signals=50 winding=50
    PYTHONPATH=.:tests python -m tests.fuzz.mutants --work /tmp/mutants --seed 1 --table

Mutants (mutations.py) are drawn room by room: first the kind of the change, then the place. Every worker changes its
own copy of the checkout, never the checkout. It runs the tests that call the changed function (a map that reach.py
wrote into ``WORK/reach``), or without a map the test files that import its module, the quick ones first, until one
fails.
Results are lines of ``WORK/results.jsonl``; a further call continues. `--again` repeats what survived.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import re
import resource
import shutil
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import pytest

from tests.fuzz.mutations import Mutant, functions_at, mutants_of, parses
from tests.fuzz.swapped import Server, is_swappable

ROOT = Path(__file__).resolve().parents[2]
KINDS = ("comparison", "arithmetic", "constant", "boolean", "condition", "negation", "removed", "returned")
BUDGET = 45.0
"""CPU seconds of tests after which a mutant counts as survived."""

PER_TEST = 30.0
"""CPU seconds of one test after which it counts as hanging, and the mutant as killed."""

LONGEST = 8.0
"""CPU seconds, as reach.py measures them, of the longest test that is chosen; a longer one could count as hanging."""

KILLED = ("killed", "hangs", "crashes", "import")
BUDGET_CODE = 98


def sample(room: str, count: int, seed: int) -> list[Mutant]:
    """Mutants of a room, at most one per line; the same for the same code and seed, and more if more are wanted."""
    chance, drawn = random.Random(f"{seed} {room}"), []
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
            drawn.append(mutant)
    return drawn


# ---- choice of the tests ----


@lru_cache
def texts_of_tests() -> dict[str, str]:
    """Test files that may find a mutant, with their text; no pages, batches, tools or searches."""
    files = list((ROOT / "tests").rglob("test_*.py"))
    left_out = ("pages", "jobs", "tools", "fuzz", "case", "report", "plotting")
    texts = {path.relative_to(ROOT).as_posix(): path for path in files}
    return {name: path.read_text() for name, path in texts.items() if name.split("/")[1] not in left_out}


@lru_cache
def callers_of_compiled(root: Path) -> dict[str, set[str]]:
    """Name used anywhere -> names of the functions whose text contains it, for all functions of the package."""
    found: dict[str, set[str]] = defaultdict(set)
    for path in (root / "wroll_fem").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_bytes())):
            if isinstance(node, ast.FunctionDef):
                first = min([node.lineno, *(d.lineno for d in node.decorator_list)])
                for part in ast.walk(node):
                    name = getattr(part, "id", None) or getattr(part, "attr", None)
                    if isinstance(name, str) and name != node.name:
                        found[name].add(f"{path.relative_to(root).as_posix()}:{first}:{node.name}")
    return found


def places(mutant: Mutant) -> set[str]:
    """Functions ("file:line") whose call runs the changed line; empty for a line outside of functions."""
    around = functions_at(ROOT / mutant.file, mutant.line)
    if not around:
        return set()
    name, line, compiled = around[0]
    if not compiled:
        return {f"{mutant.file}:{line}"}
    uses, seen, front = callers_of_compiled(ROOT), {name}, [name]
    found = set()
    while front and len(seen) < 200:
        for caller in uses[front.pop()]:
            file, first, function = caller.rsplit(":", 2)
            found.add(f"{file}:{first}")
            if function not in seen:
                seen.add(function)
                front.append(function)
    return found


def chosen_tests(mutant: Mutant, reach: dict[str, Any]) -> list[str]:
    """Tests that may find a mutant, in the order in which they run."""
    room = mutant.file.split("/")[1]
    at = places(mutant)
    found = []
    for name, (seconds, passed, functions) in reach.items():
        same_file = any(f.rsplit(":", 1)[0] == mutant.file for f in functions)
        if passed and seconds <= LONGEST and (at & set(functions) if at else same_file):
            found.append((seconds * (1.0 if name.startswith(f"tests/{room}/") else 3.0), name))
    if found:
        return [name for _, name in sorted(found)][:400]
    module = mutant.file[:-3].replace("/", ".")
    parent, stem = module.rsplit(".", 1)
    direct = re.compile(
        rf"from {re.escape(module)} import|import {re.escape(module)}\b|from {re.escape(parent)} import .*\b{stem}\b"
    )
    around = functions_at(ROOT / mutant.file, mutant.line)
    scores = []
    for name, text in texts_of_tests().items():
        score = (
            4.0 * bool(direct.search(text)) + 2.0 * name.startswith(f"tests/{room}/") + 2.0 * (stem in Path(name).stem)
        )
        score += sum(1.0 for function, _, _ in around if not function.startswith("_") and function in text)
        score += 1.0 * (f"analysis: {stem}" in text or f'"{stem}"' in text or f"lab_{stem}" in text)
        if score >= 2.0:
            scores.append((-score, len(text), name))
    return [name for _, _, name in sorted(scores)][:12]


# ---- one mutant ----


class _Watch:
    """Plugin of pytest: ends the session after `BUDGET` CPU seconds and keeps the name of the test that failed."""

    def __init__(self, note: Path, budget: float):
        self.note, self.budget, self.start, self.count = note, budget, time.process_time(), 0

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.note.write_text(report.nodeid)

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        self.count += 1
        self.note.write_text(f"hang in {item.nodeid}")
        used = time.process_time() - self.start
        resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time() + PER_TEST) + 1, resource.RLIM_INFINITY))
        if used > self.budget:
            os._exit(BUDGET_CODE)


def _child(copy: Path, tests: list[str], note: Path, budget: float) -> None:
    os.chdir(copy)
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)
    sys.dont_write_bytecode = True
    for name in [name for name in sys.modules if name.partition(".")[0] in ("wroll_fem", "tests", "support")]:
        del sys.modules[name]
    sys.path[:] = [
        str(copy),
        str(copy / "tests"),
        *(p for p in sys.path if p not in ("", str(ROOT), str(ROOT / "tests"))),
    ]
    watch = _Watch(note, budget)
    words = ["-q", "-x", "-p", "no:cacheprovider", "-p", "no:xdist", "-p", "no:randomly", "-m", "not slow", *tests]
    code = int(pytest.main(words, plugins=[watch]))
    with note.open("a") as file:
        file.write(f"\n{watch.count}")
    os._exit(code)


def run(mutant: Mutant, copy: Path, tests: list[str], budget: float) -> dict[str, Any]:
    """Outcome of the tests with the mutant in a copy of the checkout."""
    path, note = copy / mutant.file, copy / "note.txt"
    content, stat = path.read_bytes(), path.stat()
    if content != (ROOT / mutant.file).read_bytes():
        raise SystemExit(f"{path} differs from the checkout; delete the copy and call again")
    note.write_text("")
    caches = kept_caches(copy)
    path.write_bytes(mutant.applied(content))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        child = os.fork()
        if not child:
            _child(copy, tests, note, budget)
        _, status = os.waitpid(child, 0)
    finally:
        path.write_bytes(content)
        os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
        restore_caches(copy, caches)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    code, words = os.waitstatus_to_exitcode(status), note.read_text().splitlines()
    cpu = round(used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime, 1)
    return judged(code, words[0] if words else "", words[1] if len(words) > 1 else "", cpu)


def kept_caches(copy: Path) -> dict[Path, tuple[int, int]]:
    """Compiled functions that numba keeps in a copy, with time and size."""
    return {p: (p.stat().st_mtime_ns, p.stat().st_size) for p in (copy / "wroll_fem").rglob("__pycache__/*.nb[ic]")}


def restore_caches(copy: Path, caches: dict[Path, tuple[int, int]]) -> None:
    """Undo all changes of numba's caches, so that no mutant lives on in them."""
    kept = copy.parent / f"{copy.name}.caches"
    for path, found in kept_caches(copy).items():
        if caches.get(path) != found:
            path.unlink()
    for path in caches:
        if not path.exists():
            shutil.copy2(kept / path.relative_to(copy), path)


def copied(copy: Path) -> None:
    """Copy of the checkout, with a copy of the caches of numba beside it."""
    if not copy.exists():
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".git", ".venv", "runs", "build", "site"))
        ignored = lambda folder, names: [n for n in names if not ((Path(folder) / n).is_dir() or ".nb" in n)]  # noqa: E731
        shutil.copytree(copy / "wroll_fem", copy.parent / f"{copy.name}.caches" / "wroll_fem", ignore=ignored)


# ---- command ----


def read_results(work: Path) -> dict[str, dict[str, Any]]:
    """Name of a mutant -> its last result."""
    path = work / "results.jsonl"
    lines = path.read_text().splitlines() if path.exists() else []
    return {entry["name"]: entry for entry in map(json.loads, lines)}


def read_reach(work: Path) -> dict[str, Any]:
    """Map of the tests: name -> CPU seconds, whether it passed, functions."""
    found: dict[str, Any] = {}
    for path in sorted((work / "reach").glob("*.json")):
        found |= json.loads(path.read_text())
    return found


def table(results: dict[str, dict[str, Any]]) -> str:
    """Results as a table of Markdown."""
    rows = ["| mutant | change | outcome | by |", "|---|---|---|---|"]
    for entry in results.values():
        change = f"`{entry['before']}` -> `{entry['text']}`".replace("\n", " ").replace("|", "\\|")
        by = entry["by"].removeprefix("hang in ").replace("|", "\\|") or f"{entry['tests']} tests"
        rows.append(f"| {entry['file']}:{entry['line']} | {change[:160]} | {entry['outcome']} | {by[:140]} |")
    return "\n".join(rows) + "\n"


def scores(results: dict[str, dict[str, Any]]) -> str:
    """Killed and all mutants, by room and by kind."""
    lines = []
    for key in ("room", "kind"):
        for value in sorted({entry[key] for entry in results.values()}):
            counts = Counter(e["outcome"] for e in results.values() if e[key] == value)
            lines.append(f"{value:12} {sum(counts[k] for k in KILLED):4} of {counts.total():4}  {dict(counts)}")
    return "\n".join(lines)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rooms", nargs="+", default=[], help="room=count, in this order")
    parser.add_argument("--worker", default="1/1", help="1/2 and 2/2 share the mutants")
    parser.add_argument("--budget", type=float, default=BUDGET)
    parser.add_argument("--again", nargs="?", const="survived", help="run the mutants with this outcome again")
    parser.add_argument("--tests", nargs="+", help="these tests in place of the chosen ones")
    parser.add_argument("--swap", action=argparse.BooleanOptionalAction, default=True, help="use swapped.py")
    parser.add_argument("--only", default="", help="mutants whose name contains this text")
    parser.add_argument("--table", action="store_true", help="print the table of the results, and scores")
    given = parser.parse_args()
    results = read_results(given.work)
    if given.table:
        print(table(results) + "\n" + scores(results))
        return
    rooms = {room: int(count) for room, _, count in (words.partition("=") for words in given.rooms)}
    planned = plan(rooms, given)
    which, of = map(int, given.worker.split("/"))
    copy = given.work / f"copy{which}"
    given.work.mkdir(parents=True, exist_ok=True)
    copied(copy)
    for name in (
        "wroll_fem",
        "numpy",
        "scipy.optimize",
        "scipy.signal",
        "scipy.sparse.linalg",
        "numba",
        "xarray",
        "pydantic",
        "hypothesis",
        "pint",
    ):
        __import__(name)
    todo = [p for p in planned if given.only in p[0].name and _is_due(results.get(p[0].name), given.again)]
    todo = todo[which - 1 :: of]
    quick = [mutant for mutant, swappable, _ in todo if given.swap and swappable]
    tests = {mutant.name: given.tests or names for mutant, _, names in todo}

    def work(swapped: Callable[..., tuple[int, str, int, float]]) -> None:
        for mutant in quick:
            names = tests[mutant.name]
            if "::" not in (names or ["::"])[0]:
                names = [name for file in names for name in server.items if name.partition("::")[0] == file]
            result: dict[str, Any] = {"outcome": "untested", "by": "", "tests": "0", "cpu": 0.0}
            if names:
                code, by, count, cpu = swapped(mutant, names, given.budget, PER_TEST)
                result = judged(code, by, str(count), cpu)
            keep(given, mutant, result)

    if quick:
        server = Server(ROOT, work)
        folders = sorted({name.partition("::")[0] for m in quick for name in tests[m.name]})
        pytest.main(["-q", "-s", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", "not slow", *folders], [server])
    for mutant, _, _ in todo:
        if mutant not in quick:
            result = {"outcome": "untested", "by": "", "tests": "0", "cpu": 0.0}
            if tests[mutant.name]:
                result = run(mutant, copy, tests[mutant.name], given.budget)
            keep(given, mutant, result)


def plan(rooms: dict[str, int], given: argparse.Namespace) -> list[tuple[Mutant, bool, list[str]]]:
    """Mutants of a sample, whether their code can be swapped, and their tests; kept in the folder of the results."""
    reach, found = read_reach(given.work), []
    for room, count in rooms.items():
        path = given.work / f"plan_{given.seed}_{room}_{count}.json"
        if not path.exists():
            entries = [
                (m.__dict__, is_swappable(m, ROOT), chosen_tests(m, reach)) for m in sample(room, count, given.seed)
            ]
            path.write_text(json.dumps(entries))
        found += [(Mutant(**fields), quick, tests) for fields, quick, tests in json.loads(path.read_text())]
    return found


def _is_due(known: dict[str, Any] | None, again: str | None) -> bool:
    return known is None or known["outcome"] == again


def judged(code: int, by: str, tests: str, cpu: float) -> dict[str, Any]:
    """Result of a mutant from the exit code of its tests."""
    ends = {0: "survived", 1: "killed", BUDGET_CODE: "survived", -24: "hangs"}
    outcome = ends.get(code, "crashes" if code < 0 else "import")
    return {
        "outcome": outcome, "by": "" if outcome == "survived" else by, "code": code, "tests": tests, "cpu": cpu,
        "within_budget": code != BUDGET_CODE,
    }  # fmt: skip


def keep(given: argparse.Namespace, mutant: Mutant, result: dict[str, Any]) -> None:
    """Append a result to the file of results, and print it."""
    told = {"name": mutant.name, "room": mutant.file.split("/")[1], "seed": given.seed} | {
        key: getattr(mutant, key) for key in ("file", "line", "kind", "before", "text")
    }
    with (given.work / "results.jsonl").open("a") as file:
        file.write(json.dumps(told | result) + "\n")
    print(f"{result['outcome']:9} {result['cpu']:6.1f} s  {mutant.name[:110]}  {result['by'][:90]}", flush=True)


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("MPLBACKEND", "Agg")
    main()
