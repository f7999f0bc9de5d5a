"""Simulated images of the targets of the slip measurement (section 3.5), and their evaluation in the laboratory.

The displacements of the targets come from the probes of the dwells: `FACE_GROUP_LAYER_v` (vertical) and `_h`
(horizontal). They are drawn as a camera would see them, with noise of the sensor and uneven light, and read by the kind
`slip`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from wroll_fem.lab.evaluation import evaluate
from wroll_fem.lab.slip_images.example import DIAMETERS, LAYERS
from wroll_fem.lab.slip_images.frames.rendering import Disc, recorded, render
from wroll_fem.typing import FloatArray

FACES = ("axial", "transverse")
GROUPS = {1: 0.010, 2: 0.025, 3: 0.040}
"""Group of targets -> height above the base, m; three groups of five make the 15 targets of Fig. 3.19."""
PIXEL, RATE, FRAMES = 1.0e-4, 2000.0, 400
"""Length of a pixel (m), frames per second and number of frames: 0.1 mm and 2000 fps as in the thesis."""
SHAPE = (420, 88)
NOISE, BAND = 5.0, 40.0
"""Standard deviation of the grey values of a pixel (the light has 100), and half width of the band that is read, Hz."""


def targets() -> tuple[Disc, ...]:
    """Targets in the order of groups and layers, group 1 lowest in the image; rings are 4 px wide."""
    return tuple(
        Disc(43.3 + 0.2 * g, 460.6 - height / PIXEL, outer, 0.0 if layer == 0 else outer - 8.0, 1.1 - 0.01 * layer)
        for g, height in GROUPS.items()
        for layer, outer in zip(LAYERS, DIAMETERS, strict=True)
    )


def motion(history: xr.Dataset, face: str) -> FloatArray:
    """(frames, targets, 2) displacements at the end of a dwell, along columns and down the rows, px."""
    time = history["time"].values
    at = time[-1] - np.arange(FRAMES)[::-1] / RATE
    names = [[f"{face}_{g}_{layer}_{d}" for d in "hv"] for g in GROUPS for layer in LAYERS]
    moved = history["probe_displacement"].sel(probe=np.ravel(names)).transpose("time", "probe").values
    return CubicSpline(time, moved)(at).reshape(FRAMES, -1, 2) / PIXEL * np.array([1.0, -1.0])


def photographed(history: xr.Dataset, face: str, frequency: float, seed: int) -> xr.Dataset:
    """Slip of a dwell on one face, from its images: amplitudes with errors, m, per pair of targets.

    Parameters
    ----------
    history
        Dwell with the probes of the targets.
    face
        Face that the camera sees.
    frequency
        Frequency of the dwell, Hz.
    seed
        Seed of the noise.
    """
    rng, discs = np.random.default_rng(seed), targets()
    moved = motion(history, face)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write(folder / "motion.tif", discs, moved, rng)
        _write(folder / "rest.tif", discs, np.zeros_like(moved), rng)
        (folder / "targets.csv").write_text("\n".join(_rows(discs)) + "\n", encoding="utf-8")
        settings: dict[str, Any] = {"frame_rate": RATE, "frequency": frequency, "band": BAND, "relative_to": 6}
        settings |= {"rest": str(folder / "rest.tif"), "table": str(folder / "targets.csv")}
        data = evaluate("slip", [folder / "motion.tif"], **settings).data
    wanted = ["slip_amplitude", "slip_error", "slip_noise_floor"]
    found = data[wanted].drop_attrs().reset_coords(["slip_group", "slip_layer", "slip_relative_to"])
    found["floor_m"] = (), float(data["slip_noise_floor"]) * float(data.attrs["pixel_length_m"])
    return found.drop_vars(["frequency", "time"], errors="ignore")


def _write(file: Path, discs: tuple[Disc, ...], moved: FloatArray, rng: np.random.Generator) -> None:
    """Write a recording under uneven light, with noise."""
    from PIL import Image

    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]] / SHAPE[0]
    light = (100.0 * (1.0 + 0.4 * (y - 0.5) - 0.8 * (x - 0.1) ** 2)).astype(np.float32)
    frames = (render(SHAPE, discs, shift, light=light, ground=0.4) for shift in moved)
    pages = [Image.fromarray(recorded(frame, rng.normal(0.0, NOISE, SHAPE))) for frame in frames]
    pages[0].save(file, save_all=True, append_images=pages[1:])


def _rows(discs: tuple[Disc, ...]) -> Iterator[str]:
    """Lines of the table of groups and layers."""
    yield "target,group,layer,x_px,y_px,diameter_px,diameter_mm"
    places = [(g, layer) for g in GROUPS for layer in LAYERS]
    for k, (disc, (g, layer)) in enumerate(zip(discs, places, strict=True), start=1):
        size = 1e3 * PIXEL * disc.diameter
        yield f"{k},{g},{layer or 'mandrel'},{disc.x:.1f},{disc.y:.1f},{disc.diameter:.1f},{size:.2f}"
