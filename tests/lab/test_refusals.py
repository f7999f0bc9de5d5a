"""Bad measurements and motions on the command line: one line, exit code 2, and no results."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support.paths import CONFIGS
from typer.testing import CliRunner

from tests.fuzz.laboratory_originals import write_uff
from wroll_fem.cli import app
from wroll_fem.lab.slip_images.frames.rendering import Disc, recorded, render

RNG = np.random.default_rng(3)
RATE = 500.0
TIME = np.arange(1000) / RATE
BASE = RNG.normal(size=TIME.size)
TIP = np.convolve(BASE, np.exp(-np.arange(40) / 8.0) * np.sin(np.arange(40)), mode="same")
BARE = ("lab", "transmissibility", "--set", "method=random")
LAB = (*BARE, "--set", "base_unit=g", "--set", "tip_unit=g")
SLIP = ("lab", "slip", "--set", "frame_rate=2000", "--set", "frequency=140", "--set", "band=200")
RANDOM, SHOCK = str(CONFIGS / "lab_random.yaml"), str(CONFIGS / "lab_shock.yaml")


def measured(path: Path, **changed: np.ndarray) -> str:
    columns = {"time": TIME, "base": BASE, "tip": TIP} | changed
    np.savetxt(path, np.transpose(list(columns.values())), "%.9g", ",", header=",".join(columns), comments="")
    return str(path)


def with_value(values: np.ndarray, at: int, value: float) -> np.ndarray:
    found = values.copy()
    found[at] = value
    return found


def frames(folder: Path, discs: tuple[Disc, ...], drift: float = 0.0, sizes: tuple[int, ...] = (80,)) -> str:
    """Folder of images of discs; the first one drifts by ``drift`` px per frame."""
    folder.mkdir()
    for k in range(60):
        shape = (60, sizes[k % len(sizes)])
        shift = np.zeros((len(discs), 2))
        shift[0, 0] = drift * k
        image = recorded(render(shape, discs, shift, ground=0.4), np.random.default_rng(k).normal(0, 1, shape))
        Image.fromarray(image).save(folder / f"{k}.png")
    return str(folder)


def without_58(folder: Path) -> str:
    path = folder / "a.uff"
    write_uff(path, {"time": TIME[:20], "base": BASE[:20]})
    path.write_text(path.read_text().replace("    58", "   151", 1))
    return str(path)


def cut(folder: Path) -> str:
    path = Path(measured(folder / "cut.csv"))
    path.write_bytes(path.read_bytes()[:-9])
    return str(path)


PROGRESS = re.compile(r"[a-z]+( \(60 frames\))?( \.\.\.|: (stopped|done) in .* s)|the base moves at random")
"""Lines that show how far an evaluation has come."""

PAIR = (Disc(20.0, 30.0, 14.0), Disc(50.0, 30.0, 14.0))
CASES: dict[str, Callable[[Path], tuple[str, ...]]] = {
    "no column 'tpi'; did you mean 'tip'?": lambda p: (*LAB, measured(p / "a.csv"), "--set", "tip=tpi"),
    "column 9 of 3": lambda p: (*LAB, measured(p / "a.csv"), "--set", "tip=9"),
    "tip_unit: unknown unit 'gal'; use one of": lambda p: (*LAB, measured(p / "a.csv"), "--set", "tip_unit=gal"),
    "tip_unit: required key is missing": lambda p: (*BARE, measured(p / "a.csv"), "--set", "base_unit=g"),
    "base_unit: required key is missing": lambda p: (*BARE, measured(p / "a.csv"), "--set", "tip_unit=g"),
    "units: required section is missing": lambda p: ("lab", "shear", measured(p / "a.csv")),
    "sample 31 is nan (1 such)": lambda p: (*LAB, measured(p / "a.csv", tip=with_value(TIP, 30, np.nan))),
    "time does not rise: sample 301": lambda p: (*LAB, measured(p / "a.csv", time=with_value(TIME, 300, 0.1))),
    "gap of 0.502 s after": lambda p: (*LAB, measured(p / "a.csv", time=TIME + 0.5 * (TIME > 1.0))),
    "too few to average": lambda p: (*LAB, measured(p / "a.csv"), "--set", "resolution=1"),
    "fewer than 2.5 times the highest frequency": lambda p: (*LAB, measured(p / "a.csv"), "--set", "band=[20, 220]"),
    "does not end with a line break": lambda p: (*LAB, cut(p)),
    "no target found in the first frame: the largest regions have": lambda p: (
        *SLIP, frames(p / "f", PAIR), "--set", "area=[900, 2000]",
    ),
    "targets 1 and 2 merge into one region": lambda p: (*SLIP, frames(p / "f", PAIR, 0.4), "--set", "area=[50, 400]"),
    "frame of 79 x 60 px, but the first frame has 80 x 60 px": lambda p: (*SLIP, frames(p / "f", PAIR, 0.0, (80, 79))),
    "no set 58 with a time response": lambda p: (*LAB, without_58(p)),
    "the frequencies must rise, but 20 Hz follows 300 Hz": lambda p: (
        "run", RANDOM, "--set", "excitation.psd.frequency=[300, 20]",
    ),
    "got -0.01 g^2/Hz": lambda p: ("run", RANDOM, "--set", "excitation.psd.g2_per_hz=[0.01, -0.01]"),
    "no shock has this spectrum": lambda p: (
        "run", SHOCK, "--set",
        "excitation={kind: srs, srs: {frequency: [10, 100, 2000], acceleration_g: [5, 500, 5], q: 10}}",
    ),
    "unknown unit 'gal'": lambda p: (
        "run", SHOCK, "--set", f"excitation={{kind: file, file: {measured(p / 'a.csv')}, unit: gal, column: base}}",
    ),
    "no column 'bsae'": lambda p: (
        "run", SHOCK, "--set", f"excitation={{kind: file, file: {measured(p / 'a.csv')}, unit: g, column: bsae}}",
    ),
}  # fmt: skip


@pytest.mark.parametrize("message", CASES)
def test_a_bad_measurement_or_motion_is_one_line_and_exit_code_2(message: str, tmp_path: Path) -> None:
    if "set 58" in message and not find_spec("pyuff"):
        pytest.skip("pyuff is not installed")
    done = CliRunner().invoke(app, [*CASES[message](tmp_path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 2, done.output
    lines = [line for line in done.output.splitlines() if line and not PROGRESS.fullmatch(line)]
    assert len(lines) == 1, done.output
    assert message in lines[0]
    assert not (tmp_path / "out" / "results.nc").exists()
