"""Decoding of image files by Pillow; damaged files become one-line errors."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError

_PNG_END = b"\x00\x00\x00\x00IEND\xaeB\x60\x82"
_GREY = ("L", "I;16", "I;16L", "I;16B", "I", "F")
"""Modes of Pillow that hold one grey value per pixel; others are colours and are converted by their luminance."""


def decoded(
    path: Path, shape: tuple[int, int] | None = None, *, pages: int = 1, most_pixels: int
) -> Iterator[npt.NDArray[np.float32]]:
    """Frames of an image file: grey values, (rows, columns).

    Parameters
    ----------
    path
        Image file.
    shape
        Rows and columns that each frame must have; None accepts any.
    pages
        Number of pages to read.
    most_pixels
        Largest size that is accepted; larger sizes come from damaged headers.

    Raises
    ------
    InputError
        If the file is damaged or cut off, or a frame has another size.
    """
    with _opened(path) as image:
        for page in range(pages):
            with _one_line(path, page, pages):
                image.seek(page)
                _check_size(image, shape, most_pixels)
                frame = _grey(image)
                if not np.isfinite(frame).all():
                    raise ValueError("it has values that are no numbers")
            yield frame


def page_count(path: Path) -> int:
    """Count the frames of an image file.

    Raises
    ------
    InputError
        If the file is damaged or cut off.
    """
    with _opened(path) as image, _one_line(path, 0, 1):
        return int(getattr(image, "n_frames", 1))


def _grey(image: Any) -> npt.NDArray[np.float32]:
    with _silent() if any(tile[0] == "libtiff" for tile in image.tile) else nullcontext():
        image.load()
    if image.mode in _GREY:
        return np.asarray(image).astype(np.float32)
    return np.asarray(image.convert("RGB").convert("L")).astype(np.float32)


@contextmanager
def _silent() -> Iterator[None]:
    """Keep libtiff from writing to standard error; Pillow raises an exception as well."""
    with open(os.devnull, "w", encoding="utf-8") as nothing:
        kept = os.dup(2)
        try:
            os.dup2(nothing.fileno(), 2)
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)


class _Size(ValueError):
    """Frame of another size."""


def _check_size(image: Any, shape: tuple[int, int] | None, most_pixels: int) -> None:
    width, height = image.size
    if shape is not None and (height, width) != shape:
        raise _Size(f"{width} x {height} px, but the first frame has {shape[1]} x {shape[0]} px")
    if width * height > most_pixels:
        raise _Size(f"{width} x {height} px are more than {most_pixels} px")


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Image of Pillow, header read; its pixels are read later."""
    from PIL import Image

    with ExitStack() as stack:
        with _one_line(path, 0, 1):
            if path.suffix.lower() == ".png":
                _check_png_end(path)
            # a path in place of an open file would map all pages of a TIFF into memory, one after the other
            image = stack.enter_context(Image.open(stack.enter_context(path.open("rb"))))
        yield image


def _check_png_end(path: Path) -> None:
    """Pillow accepts a PNG that is cut off after its pixels."""
    with path.open("rb") as file:
        file.seek(0, 2)
        file.seek(max(file.tell() - 256, 0))
        if _PNG_END not in file.read():
            raise ValueError("its end is missing")


@contextmanager
def _one_line(path: Path, page: int, pages: int) -> Iterator[None]:
    """Turn what Pillow raises for a damaged file, which may be any exception, into one line."""
    where = f"{path}, page {page + 1}" if pages > 1 else str(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # Pillow only warns of some truncated files
            yield
    except (KeyboardInterrupt, InputError):
        raise
    except _Size as error:
        raise InputError(f"frame of {error}", file=where, remedy="give frames of one size") from None
    except Exception as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(
            f"the image is damaged or cut off ({reason})", file=where, remedy="export it again, as PNG or TIFF"
        ) from None
