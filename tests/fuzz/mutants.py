"""Mutation testing: do the tests of a module notice a small change of it?

    PYTHONPATH=.:tests python -m tests.fuzz.mutants --list LIST.csv --seed 1 --draw signals=50 winding=50
    PYTHONPATH=.:tests python -m tests.fuzz.mutants --list LIST.csv --work /tmp/mutants
    PYTHONPATH=.:tests python -m tests.fuzz.mutants --list LIST.csv --scores

Mutants (mutations.py) are drawn room by room: first the kind of the change, then the place (mutant_list.py). Every
worker changes its own copy of the checkout, never the code of the checkout. It runs the tests that call the changed
function (a map that reach.py wrote into ``WORK/reach``), or without a map the test files that import its module, the
quick ones first, until one fails. A call runs the mutants of the list that have no outcome, and writes the outcome into
the list; `--again` repeats what survived. `--again killed --by` runs the test alone that noticed a mutant, if there
still is such a quick test: do the tests of today notice what those of the list did?
"""

from __future__ import annotations

import argparse
import filecmp
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import time
import traceback
from collections import defaultdict
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import pytest

from tests.fuzz import mutant_list
from tests.fuzz.mutations import Mutant, functions, functions_at
from tests.fuzz.swapped import NOT_SWAPPED, Server, is_swappable

ROOT = Path(__file__).resolve().parents[2]
BUDGET = 20.0
"""CPU seconds of tests after which a mutant counts as survived."""

PER_TEST = 60.0
"""CPU seconds of one test after which it counts as hanging, and the mutant as killed; compiling takes up to 40."""

LONGEST = 8.0
"""CPU seconds, as reach.py measures them, of the longest test that is chosen; a longer one could count as hanging."""

BUDGET_CODE = 98
NO_TESTS = (4, 5)
"""Exit codes of pytest: a file of tests is missing, no test was selected."""

IMPORT_CODE = 97
"""The changed module cannot be imported: pytest finds its tests only without the change."""

PRELOADED = (
    "wroll_fem", "numpy", "scipy.optimize", "scipy.signal", "scipy.sparse.linalg", "numba", "xarray", "pydantic",
    "hypothesis", "pint",
)  # fmt: skip
"""Imported before the processes are forked that run the tests."""


# ---- choice of the tests ----


@lru_cache
def texts_of_tests() -> dict[str, str]:
    """Test files that may find a mutant, with their text; no pages, batches, tools or searches."""
    files = list((ROOT / "tests").rglob("test_*.py"))
    left_out = ("pages", "jobs", "tools", "fuzz", "case", "report", "plotting")
    texts = {path.relative_to(ROOT).as_posix(): path for path in files}
    return {name: path.read_text() for name, path in texts.items() if name.split("/")[1] not in left_out}


@lru_cache
def callers_of_compiled() -> dict[str, set[str]]:
    """Name used anywhere -> functions ("file:name") whose text contains it, for all functions of the package."""
    found: dict[str, set[str]] = defaultdict(set)
    for path in (ROOT / "wroll_fem").rglob("*.py"):
        lines = path.read_text(encoding="utf-8").splitlines()
        for name, first, last, _ in functions(path):
            here = f"{path.relative_to(ROOT).as_posix()}:{name}"
            for word in set(re.findall(r"[A-Za-z_]\w*", "\n".join(lines[first:last]))):
                found[word].add(here)
    return found


def places(mutant: Mutant) -> set[str]:
    """Functions ("file:name") whose call runs the changed line; empty for a line outside of functions."""
    around = functions_at(ROOT / mutant.file, mutant.line)
    if not around:
        return set()
    name, compiled = around[0]
    if not compiled:
        return {f"{mutant.file}:{name}"}
    uses, seen, front = callers_of_compiled(), {name}, [name]
    found = set()
    while front and len(seen) < 200:
        for caller in uses[front.pop().rsplit(".", 1)[-1]]:
            found.add(caller)
            function = caller.rsplit(":", 1)[1]
            if function not in seen:
                seen.add(function)
                front.append(function)
    return found


def chosen_tests(mutant: Mutant, reach: dict[str, Any]) -> list[str]:
    """Tests that may find a mutant, in the order in which they run."""
    room = mutant.file.split("/")[1]
    at = places(mutant)
    found = []
    for name, (seconds, passed, called) in reach.items():
        same_file = any(f.rsplit(":", 1)[0] == mutant.file for f in called)
        if passed and seconds <= LONGEST and (at.intersection(called) if at else same_file):
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
        score += sum(1.0 for function, _ in around if not function.startswith("_") and function in text)
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
    errors = os.dup(2)
    try:
        _session(copy, tests, note, budget)
    except BaseException:
        os.write(errors, traceback.format_exc().encode())
    os._exit(NO_TESTS[0])


def _session(copy: Path, tests: list[str], note: Path, budget: float) -> None:
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)
    sys.dont_write_bytecode = True
    for name in [name for name, module in sys.modules.items() if _is_ours(name, module)]:
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


def _is_ours(name: str, module: Any) -> bool:
    """Whether a module is the checkout's own: the copy has another, and pytest refuses a test file of both."""
    file = Path(getattr(module, "__file__", None) or "/")
    environment = ROOT / ".venv"
    return name.partition(".")[0] in ("wroll_fem", "tests", "support") or (
        file.is_relative_to(ROOT) and not file.is_relative_to(environment)
    )


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
        code = _forked(copy, tests, note, budget)
    finally:
        path.write_bytes(content)
        os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
        restore_caches(copy, caches)
    used, words = resource.getrusage(resource.RUSAGE_CHILDREN), note.read_text().splitlines()
    cpu = round(used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime, 1)
    if code in NO_TESTS and _forked(copy, tests, note, 0.0) not in NO_TESTS:
        code = IMPORT_CODE
    return judged(code, words[0] if words else "", words[1] if len(words) > 1 else "", cpu)


def _forked(copy: Path, tests: list[str], note: Path, budget: float) -> int:
    """Exit code of the tests in a process of their own."""
    child = os.fork()
    if not child:
        _child(copy, tests, note, budget)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


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


def is_current(copy: Path) -> bool:
    """Whether a copy exists and has the Python files of the checkout."""
    files = [path for room in ("wroll_fem", "tests") for path in (ROOT / room).rglob("*.py")]
    pairs = [(path, copy / path.relative_to(ROOT)) for path in files]
    return all(other.exists() and filecmp.cmp(path, other, shallow=True) for path, other in pairs)


def copied(copy: Path) -> None:
    """Copy of the checkout, with a copy of the caches of numba beside it."""
    if not is_current(copy):
        shutil.rmtree(copy, ignore_errors=True)
        part, caches = copy.with_suffix(".part"), copy.parent / f"{copy.name}.caches"
        shutil.rmtree(part, ignore_errors=True)
        shutil.rmtree(caches, ignore_errors=True)
        shutil.copytree(ROOT, part, ignore=shutil.ignore_patterns(".git", ".venv", "runs", "build", "site"))
        ignored = lambda folder, names: [n for n in names if not ((Path(folder) / n).is_dir() or ".nb" in n)]  # noqa: E731
        shutil.copytree(part / "wroll_fem", caches / "wroll_fem", ignore=ignored)
        part.rename(copy)  # an interrupted copy is made again


# ---- command ----


def read_reach(work: Path) -> dict[str, Any]:
    """Map of the tests: name -> CPU seconds, whether it passed, functions."""
    found: dict[str, Any] = {}
    for path in sorted((work / "reach").glob("*.json")):
        found |= json.loads(path.read_text())
    return found


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", type=Path, required=True, help="list of the mutants, a CSV file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--draw", nargs="+", help="write a new list of room=count")
    parser.add_argument("--scores", action="store_true", help="print scores and survivors")
    parser.add_argument("--work", type=Path, default=Path("/tmp/mutants"))
    parser.add_argument("--worker", default="1/1", help="1/2 and 2/2 share the mutants")
    parser.add_argument("--budget", type=float, default=BUDGET)
    parser.add_argument("--count", type=int, default=10**9, help="run this many mutants")
    parser.add_argument("--again", nargs="?", const="survived", default="", help="run the mutants with this outcome")
    parser.add_argument("--rooms", nargs="+", help="run the mutants of these rooms")
    parser.add_argument("--numbers", nargs="+", help="run these mutants again")
    parser.add_argument("--tests", nargs="+", help="these tests in place of the chosen ones")
    parser.add_argument("--by", action="store_true", help="the test of the last outcome in place of the chosen ones")
    given = parser.parse_args()
    if given.draw:
        mutant_list.draw(
            given.list, {room: int(n) for room, _, n in (w.partition("=") for w in given.draw)}, given.seed
        )
        return
    if given.scores:
        print(mutant_list.scores(mutant_list.read(given.list)))
        return
    which, of = map(int, given.worker.split("/"))
    rows = [row for row in mutant_list.read(given.list) if _is_due(row, given)][which - 1 :: of][: given.count]
    _run_all(rows, given, given.work / f"copy{which}")


def _is_due(row: mutant_list.Row, given: argparse.Namespace) -> bool:
    if given.rooms and row["file"].split("/")[1] not in given.rooms:
        return False
    return row["number"] in given.numbers if given.numbers else row["outcome"] == given.again


def quick_tests() -> set[str]:
    """Names of all tests that are not slow."""
    words = [sys.executable, "-m", "pytest", "-q", "--collect-only", "-p", "no:cacheprovider", "-m", "not slow"]
    found = subprocess.run([*words, "tests"], cwd=ROOT, capture_output=True, text=True, check=True)
    return {line for line in found.stdout.splitlines() if "::" in line}


def _run_all(rows: list[mutant_list.Row], given: argparse.Namespace, copy: Path) -> None:
    """Run the mutants of the rows: those that can be swapped first."""
    reach, quick, slow = read_reach(given.work), [], []
    existing = quick_tests() if given.by else set()
    for row in rows:
        mutant = mutant_list.found_again(row)
        before = {row["by"].removeprefix("hang in ")} & existing
        tests = (given.tests or list(before) or chosen_tests(mutant, reach)) if mutant else []
        if mutant is None or not tests:
            keep(given, row, {"outcome": "gone" if mutant is None else "untested", "by": "", "tests": 0, "cpu": 0.0})
        elif is_swappable(mutant, ROOT):
            quick.append((row, mutant, tests))
        else:
            slow.append((row, mutant, tests))
    for name in PRELOADED:
        __import__(name)

    def work(swapped: Callable[..., tuple[int, str, int, float]]) -> None:
        for row, mutant, names in quick:
            if "::" not in names[0]:
                names = [name for file in names for name in server.items if name.partition("::")[0] == file]
            code, by, count, cpu = swapped(mutant, names, given.budget, PER_TEST)
            if code == NOT_SWAPPED:
                slow.append((row, mutant, names))
                continue
            keep(given, row, judged(code, by, str(count), cpu))

    if quick:
        server = Server(ROOT, [mutant.file for _, mutant, _ in quick], work)
        folders = sorted({name.partition("::")[0] for _, _, names in quick for name in names})
        pytest.main(["-q", "-s", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", "not slow", *folders], [server])
    if slow:
        copied(copy)
    for row, mutant, names in slow:
        keep(given, row, run(mutant, copy, names, given.budget))


def judged(code: int, by: str, tests: str, cpu: float) -> dict[str, Any]:
    """Result of a mutant from the exit code of its tests."""
    ends = {0: "survived", 1: "killed", BUDGET_CODE: "survived", IMPORT_CODE: "import", -24: "hangs"}
    if code in NO_TESTS:
        raise SystemExit("pytest did not find the tests of a mutant; delete the copies and call again")
    outcome = ends.get(code, "crashes" if code < 0 else "import")
    return {"outcome": outcome, "by": "" if outcome == "survived" else by, "tests": tests, "cpu": cpu}


def keep(given: argparse.Namespace, row: mutant_list.Row, result: dict[str, Any]) -> None:
    """Write a result into the list, and print it."""
    mutant_list.keep(given.list, row["number"], result | {"budget": f"{given.budget:g}"})
    name = f"{row['number']} {row['file']} {row['function']} {row['before']} -> {row['text']}".replace("\n", " ")
    print(f"{result['outcome']:9} {result['cpu']:6.1f} s  {name[:140]}  {result['by'][:90]}", flush=True)


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("MPLBACKEND", "Agg")
    main()
