"""Rendered recordings with known slip, to try the evaluation."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from wroll_fem.lab.slip_images.frames.rendering import Disc, recorded, render
from wroll_fem.typing import ComplexArray

SHAPE, RATE, FREQUENCY, FRAMES = (236, 88), 2000.0, 140.0, 400
MILLIMETRE_PER_PIXEL = 0.1
LAYERS = (0, 1, 6, 11, 16)
"""Mandrel, and the layers with targets, as in Fig. 3.18 of the thesis."""
DIAMETERS = (10.0, 24.0, 38.0, 52.0, 66.0)
"""Outer diameters of the mandrel's disc and of the rings of the layers, px; rings are 4 px wide."""


def true_slip() -> dict[tuple[int, int], float]:
    """Vertical slip of layer to mandrel, px: (group, layer) -> 0-peak amplitude, largest near the base (group 1)."""
    largest = {1: 0.10, 6: 0.20, 11: 0.20, 16: 0.20}
    return {(g, j): size * (4 - g) / 3.0 for g in (1, 2, 3) for j, size in largest.items()}


def scene() -> tuple[tuple[Disc, ...], ComplexArray]:
    """Targets (group 1 lowest in the image), and complex amplitudes (targets, x and y) of their motion, px."""
    slip = true_slip()
    discs, motion = [], []
    for group in (1, 2, 3):
        x, y = 43.3 + 0.2 * group, 271.6 - 76.0 * group
        for layer, outer in zip(LAYERS, DIAMETERS, strict=True):
            discs.append(Disc(x, y, outer, 0.0 if layer == 0 else outer - 8.0, brightness=1.1 - 0.01 * layer))
            own = slip.get((group, layer), 0.0) * np.exp(1.2j)
            motion.append((0.3 * group, 0.2j - own))  # eq. 3.2: slip = mandrel - layer
    return tuple(discs), np.array(motion)


def write_example(folder: Path) -> list[Path]:
    """Write motion.tif and rest.tif with 15 targets, their table, and settings.yaml."""
    from PIL import Image

    discs, motion = scene()
    rng = np.random.default_rng(18)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]] / SHAPE[0]
    light = (100.0 * (1.0 + 0.4 * (y - 0.5) - 0.8 * (x - 0.2) ** 2)).astype(np.float32)
    for name, size in (("motion", 1.0), ("rest", 0.0)):
        turn = np.exp(2j * np.pi * FREQUENCY / RATE * np.arange(FRAMES))
        frames = (render(SHAPE, discs, np.real(size * motion * t), light=light, ground=0.4) for t in turn)
        pages = [Image.fromarray(recorded(frame, rng.normal(0.0, 5.0, SHAPE))) for frame in frames]
        pages[0].save(folder / f"{name}.tif", save_all=True, append_images=pages[1:])
    rows = ["target,group,layer,x_px,y_px,diameter_px,diameter_mm"]
    for k, (disc, (group, layer)) in enumerate(
        zip(discs, ((g, j) for g in (1, 2, 3) for j in LAYERS), strict=True), start=1
    ):
        size = MILLIMETRE_PER_PIXEL * disc.diameter
        layer_text = "mandrel" if layer == 0 else str(layer)
        rows.append(f"{k},{group},{layer_text},{disc.x:.1f},{disc.y:.1f},{disc.diameter:.1f},{size:.2f}")
    (folder / "targets.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    (folder / "settings.yaml").write_text(
        f"frame_rate: {RATE:g}\nfrequency: {FREQUENCY:g}\nband: 40\nrest: rest.tif\ntable: targets.csv\n"
        "target_diameter_error: 5.0e-5\n", encoding="utf-8",
    )  # fmt: skip
    return [folder / "motion.tif"]
