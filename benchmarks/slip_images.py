"""Speed, memory and accuracy of slip from images: rendered frames with known motion are written and streamed.

    python benchmarks/slip_images.py [--frames 10000] [--format raw | tiff | png] [--check]

Fifteen targets (three groups of a disc and four rings around it) under uneven light, with the noise of Fig. 3.19 of the
thesis (centroids at rest scatter by some 0.03 px), one target hidden for 50 frames, and a bright region that appears
beside a target. `--check` ends with an error unless amplitudes are right within 0.02 px, no identity is swapped, and
100 frames per second of CPU time are reached with less than 1 GB.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
from PIL import Image, TiffImagePlugin

from wroll_fem.lab.slip_images.frames.rendering import Disc, recorded, render
from wroll_fem.lab.slip_images.frames.stream import RawFormat, open_frames
from wroll_fem.lab.slip_images.spectrum import harmonics
from wroll_fem.lab.slip_images.targets.paths import follow
from wroll_fem.lab.slip_images.targets.survey import Search
from wroll_fem.lab.slip_images.targets.targets import Filters

SHAPE, RATE, FREQUENCY = (512, 512), 2000.0, 140.0
GROUND = 0.5
"""Brightness of the ground over that of the targets on it."""
LOST, HIDDEN = 7, (300, 350)
"""Target that is hidden, and the frames."""
FALSE = (500, 600)
"""Frames with a false region beside the outer ring of the second group."""


def scene(seed: int = 16) -> tuple[tuple[Disc, ...], np.ndarray, np.ndarray]:
    """Targets, complex amplitudes of their motion (targets, x and y, px), and the light."""
    rng = np.random.default_rng(seed)
    discs = []
    for group in range(3):
        x, y = 256.0 + rng.uniform(-3, 3), 88.0 + 168.0 * group + rng.uniform(-3, 3)
        discs.append(Disc(x, y, 24.0))
        for outer in (48.0, 76.0, 104.0, 132.0):
            discs.append(Disc(x + rng.uniform(-1, 1), y + rng.uniform(-1, 1), outer, outer - 16.0))
    size = rng.uniform(0.02, 0.3, (15, 2)) * np.exp(2j * np.pi * rng.random((15, 2)))
    motion = size + np.array([1.5, 0.6 * np.exp(0.4j)])  # slip, and the motion of the mandrel
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]] / 512.0
    light = 100.0 * (1.0 + 0.5 * (x - 0.5) - 0.7 * (y - 0.4) ** 2)
    return tuple(discs), motion, light.astype(np.float32)


def frames(count: int, seed: int = 16, noise: float = 12.0):
    """Frames one after the other; noise is repeated from a store, as drawing it takes longer than the evaluation."""
    discs, motion, light = scene(seed)
    rng = np.random.default_rng(seed + 1)
    store = rng.normal(0.0, noise, 2**22).astype(np.float32)
    for k in range(count):
        shift = np.real(motion * np.exp(2j * np.pi * FREQUENCY / RATE * k))
        shown = tuple(not (n == LOST and HIDDEN[0] <= k < HIDDEN[1]) for n in range(len(discs)))
        more = (Disc(370.0, 256.0, 24.0),) if FALSE[0] <= k < FALSE[1] else ()
        still = np.zeros((len(more), 2))
        image = render(
            SHAPE,
            discs + more,
            np.concatenate([shift, still]),
            light=light,
            ground=GROUND,
            shown=(*shown, *(True for _ in more)),
        )
        start = int(rng.integers(0, store.size - image.size))
        yield recorded(image, store[start : start + image.size].reshape(SHAPE))


def write(folder: Path, form: str, count: int):
    """Write the recording; return paths and layout for `open_frames`."""
    if form == "raw":
        path = folder / "video.raw"
        with path.open("wb") as file:
            for frame in frames(count):
                file.write(frame.tobytes())
        return [path], RawFormat(SHAPE[1], SHAPE[0])
    images = (Image.fromarray(frame) for frame in frames(count))
    if form == "tiff":
        path = folder / "video.tif"
        with TiffImagePlugin.AppendingTiffWriter(path) as pages:  # one page in memory
            for image in images:
                image.save(pages, format="TIFF")
                pages.newFrame()
        return [path], None
    for k, image in enumerate(images):
        image.save(folder / f"frame_{k}.png", compress_level=1)
    return [folder], None


def largest_memory() -> float:
    """MB of this process; `ru_maxrss` would include the process that started it."""
    (line,) = (line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM:"))
    return int(line.split()[1]) / 1024.0


def main() -> int:
    """Write, follow, compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--format", choices=("raw", "tiff", "png"), default="raw")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    search = Search(Filters((60.0, 20_000.0), (8.0, 200.0), 0.75))
    discs, motion, _ = scene()
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        started = time.process_time()
        paths, layout = write(Path(folder), given.format, given.frames)
        print(f"rendered {given.frames} frames ({given.format}) in {time.process_time() - started:.0f} s of CPU")
        stream = open_frames(paths, layout)
        follow(stream, search, count=16)  # compiles
        started = time.process_time()
        found = follow(stream, search)
        spent = time.process_time() - started
    memory = largest_memory()
    speed = given.frames / spent
    amplitude = harmonics(found.position, RATE, np.array([FREQUENCY]))[0]
    error = float(np.abs(amplitude - motion).max())
    away = float(np.nanmax(np.abs(found.position - _truth(discs, motion, given.frames))))
    lost = int(np.count_nonzero(~found.seen))
    print(f"{spent:.1f} s of CPU: {speed:.0f} frames per second; largest memory {memory:.0f} MB")
    print(f"largest error of an amplitude at {FREQUENCY:g} Hz {error:.5f} px, of a position {away:.3f} px")
    print(f"target lost in {lost} frames, doubles: {found.doubles}")
    good = error <= 0.02 and away < 1.0 and speed >= 100.0 and memory < 1024.0
    good &= lost == len(range(*HIDDEN)) and len(found.doubles) == 1
    if given.check and not good:
        print("a requirement is not met", file=sys.stderr)
        return 1
    return 0


def _truth(discs: tuple[Disc, ...], motion: np.ndarray, count: int) -> np.ndarray:
    turn = np.exp(2j * np.pi * FREQUENCY / RATE * np.arange(count))
    return np.array([(d.x, d.y) for d in discs]) + np.real(motion * turn[:, None, None])


if __name__ == "__main__":
    sys.exit(main())
