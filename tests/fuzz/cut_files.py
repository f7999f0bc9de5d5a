"""Measurements that are cut off: every reader refuses them in one line, wherever the file ends.

    python -m tests.fuzz.cut_files [--every 1] [--readers uff tiff]

Each file is cut at every byte (or at every ``every``-th), and at each of the last 64; a large one at fewer places. A
cut may be accepted only where nothing in the file shows that there was more: a text between two rows, raw video between
two frames. It may also be accepted where all numbers of the record are still there: the zeros that fill up the last
page of a TIFF, the line break after the end mark of a universal file.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import warnings
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy.io
from PIL import Image

from tests.fuzz.laboratory_originals import write_uff
from wroll_fem.errors import InputError
from wroll_fem.lab.fits.family_file import read_families
from wroll_fem.lab.fits.synthetic_roll import measured_family
from wroll_fem.lab.slip_images.frames.stream import RawFormat, open_frames
from wroll_fem.results.dataset import save_dataset
from wroll_fem.signals.records.columns import read_columns

RNG = np.random.default_rng(16)
TIME = np.arange(40) / 500.0
RECORD = {"time": TIME, "base": RNG.normal(size=40), "tip": 10.0 * RNG.normal(size=40)}
FRAMES = [RNG.integers(1, 4096, (10, 12)).astype(np.uint16) for _ in range(3)]
LAYOUT = RawFormat(12, 10, 16)


class Reader(NamedTuple):
    """Format: how a measurement is written, and what is read from it.

    Attributes
    ----------
    suffix
        Ending of the file.
    write
        Function of a path that writes the measurement.
    read
        Function of a path that returns its numbers, as a list of arrays.
    unit
        Function of what remains: whether it ends between two rows or frames, which cannot be known; None without.
    most, last
        Largest number of cuts before the last bytes, and number of the last bytes, each of which is cut.
    """

    suffix: str
    write: Callable[[Path], Any]
    read: Callable[[Path], list[np.ndarray]]
    unit: Callable[[bytes], bool] | None = None
    most: int = 3000
    last: int = 64


def _columns(*names: str) -> Callable[[Path], list[np.ndarray]]:
    def read(path: Path) -> list[np.ndarray]:
        found = read_columns(path)
        return [found.series[found.chosen(name, "columns")] for name in names]

    return read


def _text(path: Path) -> None:
    rows = np.transpose(list(RECORD.values()))
    np.savetxt(path, rows, "%.9g", ",", header=",".join(RECORD), comments="")


def _uff(path: Path) -> None:
    write_uff(path, RECORD)


def _images(form: str, **options: Any) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        deep = form == "tiff" and "compression" not in options
        pages = [Image.fromarray(one if deep else (one >> 4).astype(np.uint8)) for one in FRAMES]
        more = {"save_all": True, "append_images": pages[1:]} if form == "tiff" else {}
        pages[0].save(path, **more, **options)

    return write


def _frames(path: Path) -> list[np.ndarray]:
    return list(open_frames([path], LAYOUT if path.suffix == ".raw" else None))


def _family(path: Path) -> list[np.ndarray]:
    read_families([path])
    return []


_IN_COLUMNS = _columns("time", "base", "tip")
READERS = {
    "csv": Reader(".csv", _text, _IN_COLUMNS, lambda kept: kept.endswith(b"\n")),
    "npz": Reader(".npz", lambda path: np.savez(path, **RECORD), _IN_COLUMNS),
    "npz compressed": Reader(".npz", lambda path: np.savez_compressed(path, **RECORD), _IN_COLUMNS),
    "mat": Reader(".mat", lambda path: scipy.io.savemat(path, RECORD), _IN_COLUMNS),
    "mat compressed": Reader(".mat", lambda path: scipy.io.savemat(path, RECORD, do_compression=True), _IN_COLUMNS),
    "uff": Reader(".uff", _uff, _columns("time", "1:+X", "2:+X")),
    "tiff": Reader(".tif", _images("tiff"), _frames),
    "tiff compressed": Reader(".tif", _images("tiff", compression="tiff_deflate"), _frames),
    "png": Reader(".png", _images("png"), _frames),
    "jpg": Reader(".jpg", _images("jpg"), _frames),
    "bmp": Reader(".bmp", _images("bmp"), _frames),
    "pgm": Reader(".pgm", _images("pgm"), _frames),
    "raw": Reader(
        ".raw", lambda path: path.write_bytes(b"".join(one.astype("<u2").tobytes() for one in FRAMES)), _frames,
        lambda kept: len(kept) % LAYOUT.frame_bytes == 0,
    ),
    "results": Reader(".nc", lambda path: save_dataset(measured_family(), path), _family, most=40, last=4),
}  # fmt: skip
"""Name -> format; `results` are those of `transmissibility`, which the kind `fit` reads; a damaged
one is tried in a process of its own, half a second of CPU each."""


class Cuts(NamedTuple):
    """Numbers of cuts of one format, and the defects.

    Attributes
    ----------
    refused, between, whole
        Cuts that are refused; accepted between two rows or frames; accepted with all numbers.
    defects
        One line per defect: a cut that is read with other numbers, an error of another kind, more than one line.
    """

    refused: int
    between: int
    whole: int
    defects: list[str]


def cut(name: str, folder: Path, *, every: int = 1, seed: int | None = None) -> Cuts:
    """Cut the measurement of one format.

    Parameters
    ----------
    name
        Key of `READERS`.
    folder
        Folder for the files.
    every
        Distance of the cuts, bytes.
    seed
        Seed of cuts at random places, one per ``every`` bytes, in place of equal distances.
    """
    reader = READERS[name]
    original, path = folder / f"whole{reader.suffix}", folder / f"cut{reader.suffix}"
    reader.write(original)
    data, wanted = original.read_bytes(), reader.read(original)
    early = max(len(data) - reader.last, 0)
    places = list(range(0, early, max(every, early // reader.most)))
    if seed is not None:
        places = sorted(np.random.default_rng(seed).choice(early, len(places), replace=False).tolist())
    refused = between = whole = 0
    defects = []
    for size in (*places, *range(early, len(data))):
        path.write_bytes(data[:size])
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                found = reader.read(path)
        except InputError as error:
            refused += 1
            if "\n" in str(error):
                defects.append(f"{name}, {size} of {len(data)} bytes: more than one line")
        except Exception as error:
            defects.append(f"{name}, {size} of {len(data)} bytes: {type(error).__name__} {error}")
        else:
            if found and len(found) == len(wanted) and all(map(np.array_equal, found, wanted)):
                whole += 1
            elif reader.unit is not None and reader.unit(data[:size]):
                between += 1
            else:
                defects.append(f"{name}, {size} of {len(data)} bytes: accepted")
    return Cuts(refused, between, whole, defects)


def available() -> list[str]:
    """Formats whose libraries are installed."""
    return [name for name in READERS if name != "uff" or find_spec("pyuff")]


def main() -> None:
    """Cut the measurements; print the numbers and all defects."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--readers", nargs="*", default=available())
    chosen = parser.parse_args()
    wrong = 0
    for name in chosen.readers:
        with tempfile.TemporaryDirectory() as folder:
            found = cut(name, Path(folder), every=chosen.every)
        wrong += len(found.defects)
        print(f"{name:<16} refused {found.refused:>6}, between rows or frames {found.between:>3}, "
              f"whole {found.whole:>3}, defects {len(found.defects)}")  # fmt: skip
        for text in found.defects[:5]:
            print(f"--- {text}")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
