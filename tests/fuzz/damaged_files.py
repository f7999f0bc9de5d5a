"""Damaged files of run folders, and damaged records: each is refused in one line, or read.

    python -m tests.fuzz.damaged_files --count 10000 --seed 1

Files: results.nc (also without its checksum, as version 0.1.0 wrote it), checkpoint.npz, summary.json, provenance.json,
case.yaml, a mesh, and records of a base motion (.csv, .npz, .mat). A file that HDF5 or gmsh parses is read in a child
process, because they may end it. The trial reading of such a file takes most of a second in a new process; here a fork
of this one does it, except for one file in twenty.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import random
import resource
import select
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import scipy.io
import xarray as xr

from tests.fuzz.case_files import (
    NUMBERS,
    ODD,
    RAM_DISK,
    SECONDS,
    TEXTS,
    WAITING,
    Hangs,
    changed,
    requests_to_stop,
    time_limit,
)
from wroll_fem.case import load_case
from wroll_fem.errors import WrollError
from wroll_fem.jobs.console import summary_lines
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.run import run_case
from wroll_fem.mesh import files
from wroll_fem.mesh.files import read_mesh, write_mesh
from wroll_fem.mesh.generate import check_geometry, make_cylinders
from wroll_fem.report import write_report
from wroll_fem.results import dataset
from wroll_fem.results.dataset import load_dataset, netcdf_image
from wroll_fem.results.storage.checkpoint import read_checkpoint, write_checkpoint
from wroll_fem.results.storage.guarded import LEAST_SECONDS, MEMORY, trial_mesh, trial_reading
from wroll_fem.signals.records.record import read_record

ROOT = Path(__file__).resolve().parents[2]
WEIGHTS = {"results.nc": 40, "checkpoint.npz": 40, "summary.json": 2, "provenance.json": 2, "case.yaml": 2}
"""How often a file is damaged; a report takes most of a second."""

NATIVE = ("results.nc of 0.1.0", "mesh.msh")
"""Files that a native library reads after its trial; it may end the process."""

SHELLS = [("mandrel", 0.03925, 1.5e-3), ("layer_01", 0.040625, 1.25e-3)]
OVERRIDES = [
    "analysis=dwell", "excitation={kind: dwell, amplitude: 6.0, frequency: 11.0, cycles: 8}", "output.fields=none",
    "contact.friction={law: penalty_coulomb, mu: 0.3, elastic_slip: 1.0e-5}", "solver.method=condensed",
]  # fmt: skip


def damaged(content: bytes, chance: random.Random) -> bytes:
    """One to three changes of the bytes of a file."""
    found = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 3))):
        at, what = chance.randrange(len(found) + 1), chance.random()
        if what < 0.5 and at < len(found):
            found[at] ^= 1 << chance.randrange(8)
        elif what < 0.65:
            del found[at:]
        elif what < 0.75:
            found[at : at + 64] = bytes(len(found[at : at + 64]))
        elif what < 0.85:
            found[at:at] = chance.randbytes(chance.choice((1, 8, 100)))
        elif what < 0.95:
            del found[at : at + chance.choice((1, 8, 512))]
        else:
            found.clear()
    return bytes(found)


def damaged_json(content: bytes, chance: random.Random) -> bytes:
    """Changed values of a JSON file, or changed bytes."""
    if chance.random() < 0.3:
        return damaged(content, chance)
    data = json.loads(content)
    for _ in range(chance.choice((1, 2, 4))):
        changed(data, chance, data)
        if not data:
            break
    text = json.dumps(data if chance.random() < 0.97 else chance.choice((*ODD, *TEXTS, *NUMBERS)), default=str)
    return text.encode()


NUMERALS = ("0", "1", "-1", "2", "3", "10", "99999999", "4294967296", "1000000000000", "1e300", "nan", "inf", "x", "")


def damaged_table(content: bytes, chance: random.Random) -> bytes:
    """Changed or missing numbers and lines of a text file, or changed bytes."""
    if chance.random() < 0.3:
        return damaged(content, chance)
    lines = content.decode().splitlines()
    for _ in range(chance.choice((1, 1, 2, 4))):
        at = chance.randrange(len(lines))
        words = lines[at].split(" ")
        what = chance.random()
        if what < 0.6:
            words[chance.randrange(len(words))] = chance.choice(NUMERALS)
        lines[at] = " ".join(words[:-1] if what > 0.8 else words if what < 0.6 else [])
    return "\n".join(lines).encode()


def told(action: Callable[[], object]) -> str:
    """ "read", "refused", or the name of a defect."""
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()), time_limit():
            action()
    except Hangs:
        return "hangs"
    except WrollError as error:
        text = str(error)
        return "refused" if "\n" not in text and error.exit_code in (2, 4) else f"message {text[:200]!r}"
    except Exception as error:  # what this search looks for
        frame = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__} {Path(frame.filename).name}:{frame.lineno}: {str(error)[:100]}"
    return "read"


def in_child(action: Callable[[], str], seconds: int = 4 * SECONDS) -> str:
    """Answer of an action in a child process, which may crash or hang; it may take ``seconds`` of CPU time."""
    source, sink = os.pipe()
    child = os.fork()
    if child == 0:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        most = int(time.process_time()) + seconds
        resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
        try:
            os.write(sink, b":" + action().encode()[:2000])
        finally:
            os._exit(0)
    os.close(sink)
    waits = not select.select([source], [], [], WAITING)[0]
    if waits:
        os.kill(child, signal.SIGKILL)
    answer = os.read(source, 2001).decode(errors="replace")
    os.close(source)
    _, status = os.waitpid(child, 0)
    if answer:
        return answer[1:]
    return "hangs in HDF5" if waits or status in (signal.SIGXCPU, signal.SIGKILL) else "crashes"


def trial(path: str | os.PathLike[str]) -> str:
    """As `trial_reading`, in a fork of this process."""
    if random.random() < 0.05:
        return trial_reading(path)

    def read() -> str:
        memory = max(MEMORY, 50 * os.path.getsize(path))
        resource.setrlimit(resource.RLIMIT_AS, (memory, resource.getrlimit(resource.RLIMIT_AS)[1]))
        try:
            xr.load_dataset(path, engine="h5netcdf")
        except Exception as error:
            return " ".join(str(error).split())[:80] or type(error).__name__
        return ""

    return in_child(read, LEAST_SECONDS)


def mesh_read(path: Path) -> None:
    """What a case does with a mesh file."""
    check_geometry(read_mesh(path, [name for name, _, _ in SHELLS]), SHELLS, 0.3, "mesh")


def mesh_trial(path: str | os.PathLike[str]) -> str:
    """As `trial_mesh`, in a fork of this process."""
    if random.random() < 0.05:
        return trial_mesh(path)

    def read() -> str:
        with files.gmsh_model("trial"), contextlib.suppress(WrollError):
            with contextlib.suppress(Exception):
                gmsh.merge(str(path))
            files.extract_mesh("trial", [name for name, _, _ in SHELLS])
        return ""

    return in_child(read, LEAST_SECONDS)


def finished(folder: Path) -> None:
    """What `wroll run` does with the folder of a finished case."""
    run = run_case(load_case(ROOT / "configs" / "oscillator.yaml", OVERRIDES), folder)
    summary_lines(run.summary)


def used(run: Path) -> None:
    """What `wroll run` does with a folder, without running a case that is not complete."""
    folder = RunFolder(run)
    if folder.check(load_case(ROOT / "configs" / "oscillator.yaml", OVERRIDES)) == "complete":
        summary_lines(folder.summary())


def originals(scratch: Path) -> dict[str, tuple[Path, Callable[[bytes, random.Random], bytes], Callable[[Path], Any]]]:
    """Name -> (file, damage, what is done with it)."""
    run, case = scratch / "run", load_case(ROOT / "configs" / "oscillator.yaml", OVERRIDES)
    finished(run)
    results = RunFolder(run).results_file
    old = scratch / "old.nc"
    old.write_bytes(netcdf_image(xr.Dataset({"tip_displacement": ("time", np.arange(2000.0))}, attrs={"a": "b"})))
    checkpoint = scratch / "checkpoint.npz"
    write_checkpoint(
        checkpoint, {"done": 3, "method": "full", "records": np.random.default_rng(1).normal(size=(50, 9))}
    )
    time_s = np.arange(0.0, 0.1, 1e-3)
    columns = {"time": time_s, "base": np.sin(60.0 * time_s), "tip": np.cos(60.0 * time_s)}
    np.savez(scratch / "record.npz", **columns)
    scipy.io.savemat(scratch / "record.mat", columns)
    rows = "\n".join(",".join(f"{x:.6g}" for x in row) for row in zip(*columns.values(), strict=True))
    (scratch / "record.csv").write_text(f"time,base,tip\n{rows}\n")
    found: dict[str, Any] = {
        "results.nc": (results, damaged, lambda path: RunFolder(run).check(case) and load_dataset(path)),
        "results.nc of 0.1.0": (old, damaged, lambda path: load_dataset(path)),
        "checkpoint.npz": (checkpoint, damaged, read_checkpoint),
    }
    for name in ("summary.json", "provenance.json", "case.yaml"):
        damage = damaged if name == "case.yaml" else damaged_json
        found[name] = (run / name, damage, lambda path: (used(run), write_report(run)))
    mesh = write_mesh(make_cylinders([(name, radius) for name, radius, _ in SHELLS], 0.3, 6, 2), scratch)[0]
    found["mesh.msh"] = (mesh, damaged_table, mesh_read)
    for kind in ("csv", "npz", "mat"):
        found[f"record.{kind}"] = (
            scratch / f"record.{kind}",
            damaged,
            lambda path: read_record(path, column="base", unit="g"),
        )
    return found


def main() -> None:
    """Damage the files in turn; print every class of defects with its first number."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=1e9, help="stop after this CPU time")
    chosen = parser.parse_args()
    outcomes: Counter[tuple[str, str]] = Counter()
    defects: dict[str, int] = {}
    asked = requests_to_stop()
    random.seed(chosen.seed)
    dataset.trial_reading, files.trial_mesh = trial, mesh_trial
    begun = time.process_time()
    with tempfile.TemporaryDirectory(dir=RAM_DISK if RAM_DISK.is_dir() else None) as place:
        found = originals(Path(place))
        for number in range(chosen.first, chosen.first + chosen.count):
            chance = random.Random(f"{chosen.seed}:{number}")
            name = chance.choices(list(found), [WEIGHTS.get(name, 8) for name in found])[0]
            file, damage, use = found[name]
            content = file.read_bytes()
            changes = damage(content, chance)
            if changes == content:
                continue
            file.write_bytes(changes)
            act = lambda use=use, file=file: told(lambda: use(file))  # noqa: E731
            answer = in_child(act) if name in NATIVE else act()
            file.write_bytes(content)
            outcomes[name, answer if answer in ("read", "refused") else "defect"] += 1
            if answer not in ("read", "refused") and answer not in defects:
                defects[answer] = number
                print(f"--- {name}, number {number}: {answer}", flush=True)
            if asked or time.process_time() - begun > chosen.seconds:
                break
    for (name, answer), count in sorted(outcomes.items()):
        print(f"{name:<22} {answer:<8} {count}")
    usage = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    seconds = sum(one.ru_utime + one.ru_stime for one in usage)
    print(f"seed {chosen.seed}, from {chosen.first}: {sum(outcomes.values())} files, {seconds:.0f} s of CPU")
    print(f"{len(defects)} classes of defects: {list(defects)}")
    sys.exit(bool(defects))


if __name__ == "__main__":
    main()
