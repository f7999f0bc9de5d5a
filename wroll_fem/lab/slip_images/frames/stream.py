"""Frames of a recording as a stream: image files, multi-page TIFF, or raw video; one frame in memory at a time."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.frames.decoding import decoded, page_count

Frame = npt.NDArray[np.float32]

IMAGES = (".png", ".tif", ".tiff", ".bmp", ".jpg", ".jpeg", ".pgm")
RAW = (".raw", ".mraw", ".bin")
LARGEST = 64_000_000
"""Pixels of a frame at most; larger sizes come from damaged headers."""


class Frames(Protocol):
    """Stream of frames of one recording.

    Attributes
    ----------
    shape
        Rows and columns of every frame, px.
    name
        Path of the recording, for messages.
    """

    shape: tuple[int, int]
    name: str

    def __len__(self) -> int:
        """Return the number of frames."""

    def __iter__(self) -> Iterator[Frame]:
        """Iterate over the frames: grey values, (rows, columns), single precision."""


@dataclass(frozen=True)
class RawFormat:
    """Layout of raw video: frames of unsigned integers without gaps, row by row from the top left.

    Attributes
    ----------
    width, height
        Columns and rows, px.
    bits
        8 or 16.
    header
        Bytes before the first frame.
    big_endian
        Whether the high byte of 16 bits is first.
    """

    width: int
    height: int
    bits: int = 8
    header: int = 0
    big_endian: bool = False

    @property
    def dtype(self) -> np.dtype[np.unsignedinteger]:
        """Type of a grey value in the file."""
        return np.dtype(np.uint8) if self.bits == 8 else np.dtype(">u2" if self.big_endian else "<u2")

    @property
    def frame_bytes(self) -> int:
        """Bytes of one frame."""
        return self.width * self.height * self.dtype.itemsize


def natural_order(path: Path) -> tuple[tuple[int, int, str], ...]:
    """Key that sorts names by the numbers in them: frame_2 is before frame_10."""
    parts = re.findall(r"\d+|\D+", path.name)
    return tuple((0, int(part), part) if part.isdecimal() else (1, 0, part) for part in parts)


class ImageFiles:
    """Frames from image files, one frame each.

    Parameters
    ----------
    files
        Files in their order.
    name
        Path of the recording, for messages.

    Raises
    ------
    InputError
        When iterated, if a file is damaged or its size differs from that of the first one.
    """

    def __init__(self, files: Sequence[Path], name: str) -> None:
        self._files, self.name = files, name
        first = next(iter(decoded(files[0], most_pixels=LARGEST)))
        self.shape = (first.shape[0], first.shape[1])

    def __len__(self) -> int:
        return len(self._files)

    def __iter__(self) -> Iterator[Frame]:
        for file in self._files:
            yield from decoded(file, self.shape, most_pixels=LARGEST)


class Pages:
    """Frames from the pages of one TIFF file.

    Parameters
    ----------
    file
        TIFF file.

    Raises
    ------
    InputError
        If the file is damaged, or, when iterated, if its pages differ in size.
    """

    def __init__(self, file: Path) -> None:
        self._file, self.name = file, str(file)
        self._count = page_count(file)
        first = next(iter(decoded(file, most_pixels=LARGEST)))
        self.shape = (first.shape[0], first.shape[1])

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[Frame]:
        yield from decoded(self._file, self.shape, pages=self._count, most_pixels=LARGEST)


class RawVideo:
    """Frames from raw video.

    Parameters
    ----------
    file
        File.
    layout
        Size and type of its frames.

    Raises
    ------
    InputError
        If the size of the file is no multiple of the size of a frame, as when the file is cut off.
    """

    def __init__(self, file: Path, layout: RawFormat) -> None:
        self._file, self._layout, self.name = file, layout, str(file)
        self.shape = (layout.height, layout.width)
        try:
            size = file.stat().st_size - layout.header
        except OSError as error:
            raise InputError(f"cannot be read ({error.strerror})", file=str(file), remedy="check the file") from None
        self._count, rest = divmod(size, layout.frame_bytes)
        if rest or self._count < 1:
            raise InputError(
                f"{max(size, 0)} bytes after the header are {max(size, 0) / layout.frame_bytes:.3f} frames of "
                f"{layout.width} x {layout.height} px with {layout.bits} bits",
                file=str(file), remedy="set raw.width, raw.height, raw.bits and raw.header, or record the file again",
            )  # fmt: skip

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[Frame]:
        layout = self._layout
        try:
            with self._file.open("rb") as stream:
                stream.seek(layout.header)
                for k in range(self._count):
                    block = stream.read(layout.frame_bytes)
                    if len(block) < layout.frame_bytes:
                        raise InputError(f"ends within frame {k}", file=self.name, remedy="record the file again")
                    yield np.frombuffer(block, layout.dtype).reshape(self.shape).astype(np.float32)
        except OSError as error:
            raise InputError(f"cannot be read ({error.strerror})", file=self.name, remedy="check the file") from None


def open_frames(paths: Sequence[Path], layout: RawFormat | None = None) -> Frames:
    """Open a recording.

    Parameters
    ----------
    paths
        One folder of images, one multi-page TIFF, one file of raw video, or image files of one frame each. Images are
        sorted by the numbers in their names.
    layout
        Layout of raw video.

    Raises
    ------
    InputError
        If there are no frames, or the first one cannot be read.
    """
    if len(paths) == 1 and paths[0].is_dir():
        return _folder(paths[0])
    name = str(paths[0]) if len(paths) == 1 else str(paths[0].parent)
    if layout is not None and any(path.suffix.lower() in IMAGES for path in paths):
        raise InputError("raw is set, but the files are images", key="raw", remedy="remove raw")
    if layout is not None or paths[0].suffix.lower() in RAW:
        return _raw(paths, layout)
    for path in paths:
        if path.suffix.lower() not in IMAGES:
            raise InputError(
                f"{path.suffix or 'a file without ending'} is no format of frames", file=str(path),
                remedy="give PNG, TIFF or raw video (with raw.width and raw.height); other videos: export their frames",
            )  # fmt: skip
    if len(paths) == 1 and paths[0].suffix.lower() in (".tif", ".tiff"):
        return Pages(paths[0])
    return ImageFiles(sorted(paths, key=natural_order), name)


def _folder(folder: Path) -> Frames:
    try:
        files = sorted((p for p in folder.iterdir() if p.suffix.lower() in IMAGES and p.is_file()), key=natural_order)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", file=str(folder), remedy="check the folder") from None
    if not files:
        raise InputError(
            "the folder has no images", file=str(folder), remedy=f"give a folder with {', '.join(IMAGES)} files"
        )
    if len({file.suffix.lower() for file in files}) > 1:
        kinds = ", ".join(sorted({file.suffix.lower() for file in files}))
        raise InputError(f"images of several kinds ({kinds})", file=str(folder), remedy="keep one kind in the folder")
    return ImageFiles(files, str(folder))


def _raw(paths: Sequence[Path], layout: RawFormat | None) -> Frames:
    if len(paths) > 1:
        raise InputError(f"{len(paths)} files of raw video", file=str(paths[1]), remedy="give one file")
    if layout is None:
        raise InputError("raw video has no size", file=str(paths[0]), remedy="set raw.width and raw.height in px")
    return RawVideo(paths[0], layout)
