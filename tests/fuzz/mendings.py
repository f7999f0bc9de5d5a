"""Defects of version 0.1.0: do their tests fail when the mending is taken out?

    PYTHONPATH=.:tests python -m tests.fuzz.mendings --work /tmp/mendings
    PYTHONPATH=.:tests python -m tests.fuzz.mendings --work /tmp/mendings --defects 5 6

`mendings.yaml` names the mendings. Each is taken out of a copy of the checkout, and its tests run there; every named
test, or one of a named file, must fail. All of them must pass as long as the mending is in place.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from functools import reduce
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[2]
LIST = Path(__file__).with_suffix(".yaml")

CPU_SECONDS, MEMORY = 120, 6 << 30
"""Limits of a call of pytest: without its mending a defect may hang, or take all memory (bytes)."""


def _limited(deaf: bool) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS + 5))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.RLIM_INFINITY))
    if deaf:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def outcome(copy: Path, tests: list[str], *, deaf: bool = False, limited: bool = True) -> tuple[int, set[str]]:
    """Exit code of pytest in the copy, and the tests that failed."""
    words = [sys.executable, "-m", "pytest", "-q", "-rfE", "-p", "no:cacheprovider", "-p", "no:xdist", *tests]
    environment = os.environ | {"PYTHONPATH": f"{copy}:{copy / 'tests'}", "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        words, cwd=copy, env=environment, capture_output=True, text=True, errors="replace", check=False,
        preexec_fn=(lambda: _limited(deaf)) if limited else None,
    )  # fmt: skip
    failed = re.findall(r"^(?:FAILED|ERROR) (tests/\S+?\.py(?:::\w+)?)", done.stdout, flags=re.MULTILINE)
    return done.returncode, set(failed)


def judged(mending: dict[str, Any], copy: Path) -> str:
    """What happens without a mending: "fails", "hangs", or what is wrong with the entry."""
    path = copy / mending["file"]
    text = path.read_text(encoding="utf-8")
    taken, put = ([m] if isinstance(m, str) else m for m in (mending["take_out"], mending["put"]))
    if any(text.count(part) != 1 for part in taken):
        return f"GONE: {[text.count(part) for part in taken]} such places"
    without = reduce(lambda changed, pair: changed.replace(*pair), zip(taken, put, strict=True), text)
    try:
        path.write_text(without, encoding="utf-8")
        code, failed = outcome(copy, mending["tests"], deaf=mending.get("deaf", False))
    finally:
        path.write_text(text, encoding="utf-8")
    if code < 0:
        return f"hangs or crashes ({signal.Signals(-code).name})"
    passed = [test for test in mending["tests"] if not any(name.startswith(test.partition("[")[0]) for name in failed)]
    return f"PASSES: {', '.join(passed)}" if passed or code == 0 else "fails"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, default=Path("/tmp/mendings"))
    parser.add_argument("--defects", nargs="+", help="numbers of the defects; all of them if left out")
    given = parser.parse_args()
    mendings = [m for m in yaml.safe_load(LIST.read_text()) if not given.defects or str(m["defect"]) in given.defects]
    copy = given.work / "copy"
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".git", ".venv", "runs", "build", "site"))
    started, wrong = time.monotonic(), 0
    code, failed = outcome(copy, sorted({test for m in mendings for test in m["tests"]}), limited=False)
    print(f"all tests with all mendings: {'pass' if code == 0 else f'FAIL: {sorted(failed)}'}", flush=True)
    for mending in mendings:
        found = judged(mending, copy)
        wrong += found[0].isupper()
        print(f"{mending['defect']!s:>8}  {mending['told']}: {found}", flush=True)
    print(f"{len(mendings)} mendings, {wrong} without a test that fails; {time.monotonic() - started:.0f} s")
    raise SystemExit(1 if wrong or code else 0)


if __name__ == "__main__":
    main()
