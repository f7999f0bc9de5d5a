"""Recordings of targets for the evaluation `slip`, and how they are damaged."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from tests.fuzz.damaged_files import damaged
from tests.fuzz.laboratory_original import CELLS, Damaged, Original
from wroll_fem.lab.slip_images.frames.rendering import Disc, recorded, render
from wroll_fem.lab.slip_images.frames.stream import open_frames
from wroll_fem.lab.slip_images.regions.regions import Regions
from wroll_fem.lab.slip_images.table import read_table
from wroll_fem.lab.slip_images.targets.survey import Search, survey
from wroll_fem.lab.slip_images.targets.targets import Filters


class Images(Original):
    """Frames with three targets of one group, at rest and in motion, with a table.

    Parameters
    ----------
    form
        png, tiff or raw, or table: the table is damaged, and the frames are whole.
    """

    kind = "slip"
    SHAPE = (56, 56)

    def __init__(self, form: str) -> None:
        self._form, rng = form, np.random.default_rng(7)
        discs = (Disc(27.0, 27.5, 9.0), Disc(27.2, 27.4, 24.0, 16.0), Disc(27.1, 27.5, 42.0, 34.0))
        turn = np.exp(2j * np.pi * 250.0 / 1000.0 * np.arange(26))
        motion = np.array([[0.2, 0.5], [0.2, 0.4], [0.2, 0.3]])
        self._frames = [
            recorded(
                render(self.SHAPE, discs, motion * t.real, light=100.0, ground=0.4), rng.normal(0, 4.0, self.SHAPE)
            )
            for t in turn
        ]
        rows = ["target,group,layer,x_px,y_px,diameter_px,diameter_mm"]
        rows += [f"{k},1,{name},{d.x},{d.y},{d.diameter},{d.diameter / 10}"
                 for k, (name, d) in enumerate(zip(("mandrel", "1", "6"), discs, strict=True), 1)]  # fmt: skip
        self._table = "\n".join(rows) + "\n"
        self._targets: Regions | None = None

    def damaged(self, place: Path, chance: random.Random) -> Damaged:
        settings: dict[str, Any] = {"frame_rate": 1000.0, "frequency": 250.0, "band": 150.0}
        frames = list(self._frames)
        pictured = self._form != "table"
        for _ in range(chance.choice((0, 0, 1, 2)) if pictured else 0):
            frames = self._other_frames(frames, chance)
        form = self._form if pictured else "tiff"
        paths = self._write(place, frames, form, settings)
        if pictured and chance.random() < 0.6:
            self._damage(paths[0], chance)
        table = self._table
        if not pictured:
            cells = [line.split(",") for line in table.splitlines()]
            columns = {name: np.array([row[k] for row in cells[1:]], dtype=object) for k, name in enumerate(cells[0])}
            table = self._other_table(columns, chance)
        if chance.random() < (0.5 if pictured else 1.0):
            file = place / "targets.csv"
            content = table.encode("utf-8")
            file.write_bytes(damaged(content, chance) if not pictured and chance.random() < 0.3 else content)
            settings["table"] = str(file)
        for _ in range(chance.choice((0, 0, 1))):
            key, values = chance.choice(list(_SLIP_OTHERS.items()))
            settings[key] = chance.choice(values)
        return paths, settings

    def read_alone(self, files: list[Path], settings: dict[str, Any]) -> bool:
        if self._form != "table":
            return False
        if self._targets is None:
            search = Search(Filters((30.0, 1e5), (5.0, 300.0), 0.75))
            self._targets = survey(open_frames(files), search, 0, 16).targets
        read_table(Path(settings["table"]), self._targets)
        return True

    @staticmethod
    def _other_table(columns: dict[str, np.ndarray], chance: random.Random) -> str:
        lines = [list(columns)] + [list(map(str, row)) for row in zip(*columns.values(), strict=True)]
        for _ in range(chance.choice((1, 1, 2, 3))):
            line = chance.choice(lines)
            what = chance.randrange(5)
            if what < 3 and line:
                pool = (*CELLS, "mandrel", "Mandrel", "0", "1", "2", "3", "6", "-1", "1e9", "1e19", "2.5", "1e-9")
                line[chance.randrange(len(line))] = chance.choice(pool)
            elif what == 3 and line:
                del line[chance.randrange(len(line))]
            else:
                lines.insert(chance.randrange(len(lines) + 1), list(chance.choice(lines)))
        return "\n".join(",".join(line) for line in lines) + "\n"

    def _other_frames(self, frames: list[np.ndarray], chance: random.Random) -> list[np.ndarray]:
        """Frames that a camera may well write, but which do not show all targets."""
        at, what = chance.randrange(len(frames)), chance.randrange(8)
        if what == 0:
            frames = frames[: chance.choice((1, 2, 3, 5))]
        elif what == 1:
            frames[at] = np.full_like(frames[at], chance.choice((0, 90, 255)))
        elif what == 2:
            frames[at] = frames[at][:, : chance.choice((1, 20, 55))]
        elif what == 3:
            frames[at:] = [np.roll(one, chance.choice((3, 20)), axis=chance.choice((0, 1))) for one in frames[at:]]
        elif what == 4:
            frames = [np.full_like(one, 90) for one in frames]
        elif what == 5:
            frames[at] = np.random.default_rng(at).integers(0, 256, frames[at].shape).astype(frames[at].dtype)
        elif what == 6:
            frames[at:] = [np.maximum(one, np.roll(one, 12, axis=0)) for one in frames[at:]]
        else:
            frames = [255 - one for one in frames] if chance.random() < 0.5 else [one[20:] for one in frames]
        return frames

    def _write(self, place: Path, frames: list[np.ndarray], form: str, settings: dict[str, Any]) -> list[Path]:
        if form == "raw":
            settings["raw"] = {"width": self.SHAPE[1], "height": self.SHAPE[0]}
            (place / "video.raw").write_bytes(b"".join(one.tobytes() for one in frames))
            return [place / "video.raw"]
        images = [Image.fromarray(one) for one in frames]
        if form == "tiff":
            images[0].save(place / "video.tif", save_all=True, append_images=images[1:])
            return [place / "video.tif"]
        (place / "frames").mkdir()
        for k, image in enumerate(images):
            image.save(place / "frames" / f"f_{k}.png", compress_level=1)
        return [place / "frames"]

    @staticmethod
    def _damage(path: Path, chance: random.Random) -> None:
        files = sorted(path.iterdir()) if path.is_dir() else [path]
        file, what = chance.choice(files), chance.random()
        if path.is_dir() and what < 0.15:
            file.unlink()
        elif path.is_dir() and what < 0.25:
            file.rename(file.with_name(chance.choice(("f_²3.png", "f_.png", "x.tif", "f_1e9.PNG", "f_007.png"))))
        elif path.is_dir() and what < 0.3:
            (path / chance.choice(("a.png", "b.tif", "c.txt", "f_1.tiff"))).write_bytes(chance.randbytes(20))
        else:
            content = file.read_bytes()
            head = content[: chance.choice((200, len(content)))]  # headers are more telling than pixels
            file.write_bytes(damaged(head, chance) + content[len(head) :])


_SLIP_OTHERS: dict[str, Sequence[Any]] = {
    "frame_rate": (1e-3, 1e9, 281.0), "frequency": (1e-6, 999.0, 1001.0), "band": (1e-9, 1e9),
    "relative_to": (1, 6, 9), "target_diameter": (1e-3, 1e-30), "target_diameter_error": (1.0,),
    "first_frame": (31, 32, 10**9), "frames": (1, 2, 10**9), "targets": ("bright", "dark"),
    "background": ("median", "none"), "background_window": (3, 10**6), "evening": ("ground", "none"),
    "threshold": ("local", 0.0, -1e9, 1e9, 20.0), "threshold_window": (3, 10**6), "smoothing": (0, 10),
    "margin": (0, 20), "area": ((1.0, 2.0), (1e-9, 1e9)), "diameter": ((1.0, 2.0), (1e-9, 1e9)),
    "circularity": (0.0, 1.2), "gate": (1e-9, 1e9),
    "raw": ({"width": 56, "height": 56, "bits": 16}, {"width": 1, "height": 1}, {"width": 55, "height": 56}),
}  # fmt: skip
