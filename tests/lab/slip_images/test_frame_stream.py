"""Frames as a stream: formats, order, sizes; damaged and cut-off files are one-line errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.frames.stream import RawFormat, natural_order, open_frames

SHAPE = (24, 32)


def pictures(count: int, top: int = 255, seed: int = 1) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.integers(0, top + 1, SHAPE).astype(np.uint8 if top == 255 else np.uint16) for _ in range(count)]


def same(stream: object, frames: list[np.ndarray]) -> bool:
    read = list(stream)
    return len(read) == len(frames) == len(stream) and all(
        a.dtype == np.float32 and np.array_equal(a, b) for a, b in zip(read, frames, strict=True)
    )


@pytest.mark.parametrize("suffix", [".png", ".tif", ".bmp", ".pgm"])
def test_a_folder_is_read_in_the_order_of_the_numbers(suffix: str, tmp_path: Path) -> None:
    frames = pictures(12)
    for k, frame in enumerate(frames):
        Image.fromarray(frame).save(tmp_path / f"run3_frame{k}{suffix}")
    (tmp_path / "notes.txt").write_text("camera 2", encoding="utf-8")
    stream = open_frames([tmp_path])
    assert stream.shape == SHAPE
    assert same(stream, frames)
    assert same(stream, frames)  # a second time
    listed = open_frames(sorted(tmp_path.glob(f"*{suffix}")))  # as from a shell: frame1, frame10, frame2
    assert same(listed, frames)


def test_16_bits_are_read_in_full(tmp_path: Path) -> None:
    frames = pictures(5, 4095)
    for k, frame in enumerate(frames):
        Image.fromarray(frame).save(tmp_path / f"f_{k:03d}.png")
    assert same(open_frames([tmp_path]), frames)


@pytest.mark.parametrize(("top", "compression"), [(255, None), (255, "tiff_deflate"), (65535, None)])
def test_pages_of_a_tiff_are_frames(top: int, compression: str | None, tmp_path: Path) -> None:
    frames = pictures(7, top)
    first, *rest = [Image.fromarray(frame) for frame in frames]
    first.save(tmp_path / "video.tif", save_all=True, append_images=rest, compression=compression)
    assert same(open_frames([tmp_path / "video.tif"]), frames)


@pytest.mark.parametrize("layout", [RawFormat(32, 24), RawFormat(32, 24, 16, 100), RawFormat(32, 24, 16, 0, True)])
def test_raw_video_is_read(layout: RawFormat, tmp_path: Path) -> None:
    frames = pictures(6, 255 if layout.bits == 8 else 65535)
    data = b"x" * layout.header + b"".join(frame.astype(layout.dtype).tobytes() for frame in frames)
    (tmp_path / "video.raw").write_bytes(data)
    assert same(open_frames([tmp_path / "video.raw"], layout), frames)
    (tmp_path / "video.raw").write_bytes(data[:-5])
    with pytest.raises(InputError, match=r"are 5\.99\d frames of 32 x 24 px"):
        open_frames([tmp_path / "video.raw"], layout)


def test_colours_become_their_luminance(tmp_path: Path) -> None:
    colour = np.random.default_rng(2).integers(0, 256, (*SHAPE, 3)).astype(np.uint8)
    Image.fromarray(colour).save(tmp_path / "c.png")
    Image.fromarray(np.dstack([colour, np.full(SHAPE, 200, np.uint8)])).save(tmp_path / "d.png")
    for frame in open_frames([tmp_path]):
        assert frame == pytest.approx(colour @ [0.299, 0.587, 0.114], abs=1.0)  # whole grey values


def test_natural_order_sorts_numbers_by_value() -> None:
    names = ["b2", "a10", "a9", "a1b20", "a1b3", "a"]
    assert sorted(map(Path, names), key=natural_order) == [Path(n) for n in ("a", "a1b3", "a1b20", "a9", "a10", "b2")]


def test_wrong_recordings_are_one_line(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "mixed").mkdir()
    for name, shape in (("a1.png", (9, 9)), ("a2.png", (9, 9)), ("a3.png", (9, 8)), ("b.tif", (9, 9))):
        Image.fromarray(np.zeros(shape, np.uint8)).save(tmp_path / name)
        Image.fromarray(np.zeros(shape, np.uint8)).save(tmp_path / "mixed" / name)
    (tmp_path / "v.avi").write_bytes(b"RIFF")
    (tmp_path / "v.raw").write_bytes(bytes(81))
    png = sorted(tmp_path.glob("*.png"))
    wrong = {
        "the folder has no images": ([tmp_path / "empty"], None),
        "images of several kinds": ([tmp_path / "mixed"], None),
        ".avi is no format of frames": ([tmp_path / "v.avi"], None),
        "frame of 8 x 9 px, but the first frame has 9 x 9 px; give frames of one size": (png, None),
        "raw is set, but the files are images": (png, RawFormat(9, 9)),
        "raw video has no size": ([tmp_path / "v.raw"], None),
        "2 files of raw video": ([tmp_path / "v.raw", tmp_path / "v.raw"], RawFormat(9, 9)),
    }
    for message, (files, layout) in wrong.items():
        with pytest.raises(InputError) as error:
            list(open_frames(files, layout))
        assert message in str(error.value)
        assert "\n" not in str(error.value)


def originals(folder: Path) -> dict[str, bytes]:
    """Small files of each format."""
    noise = [np.random.default_rng(k).integers(0, 4096, (10, 12)).astype(np.uint16) for k in range(3)]
    grey, deep = Image.fromarray((noise[0] >> 4).astype(np.uint8)), [Image.fromarray(n) for n in noise]
    grey.save(folder / "a.png")
    deep[0].save(folder / "b.png")
    deep[0].save(folder / "c.tif", save_all=True, append_images=deep[1:])
    grey.save(folder / "d.tif", save_all=True, append_images=[grey, grey], compression="tiff_deflate")
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def outcome(path: Path, data: bytes) -> str | list[np.ndarray]:
    """Message of the error, or the frames."""
    path.write_bytes(data)
    try:
        frames = list(open_frames([path]))
    except InputError as error:
        return str(error)
    assert all(np.isfinite(frame).all() for frame in frames)
    return frames


@pytest.mark.parametrize("every", [7, pytest.param(1, marks=pytest.mark.slow)])
def test_a_file_that_is_cut_off_is_refused(every: int, tmp_path: Path) -> None:
    """Only zeros that fill up the last page of a TIFF may be missing."""
    for name, data in originals(tmp_path).items():
        whole = outcome(tmp_path / name, data)
        end = len(data)
        for size in (*range(0, end - 40, every), *range(end - 40, end)):
            found = outcome(tmp_path / name, data[:size])
            if isinstance(found, str):
                assert "\n" not in found
            else:
                assert not any(data[size:]), f"{name} cut off at {size} of {end} bytes is accepted"
                assert np.array_equal(found, whole)


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    found = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        place = int(rng.integers(0, len(found)))
        match int(rng.integers(0, 4)):
            case 0:
                found[place] = int(rng.integers(0, 256))
            case 1:
                found[place] ^= 1 << int(rng.integers(0, 8))
            case 2:
                del found[place : place + int(rng.integers(1, 9))]
            case _:
                found[place:place] = rng.bytes(int(rng.integers(1, 9)))
        if not found:
            return b""
    return bytes(found)


@pytest.mark.parametrize("count", [250, pytest.param(5_000, marks=pytest.mark.slow)])
def test_mutated_files_give_frames_or_one_line(count: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(count)
    refused = 0
    for name, data in originals(tmp_path).items():
        for _ in range(count):
            found = outcome(tmp_path / name, mutated(data, rng))
            if isinstance(found, str):
                refused += 1
                assert "\n" not in found
                assert len(found) < 500
    assert refused > count  # of four times as many
