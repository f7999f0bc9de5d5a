"""Light on the ground behind the targets, and the signal: a frame without it, positive on targets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.frames.stream import Frame
from wroll_fem.typing import BoolArray, FloatArray

Background = Literal["surface", "median", "none"]
Evening = Literal["subtract", "divide"]
Targets = Literal["auto", "bright", "dark"]

_DEGREE = 4
_SAMPLES = 4096
_TUKEY = 4.685
"""Cut-off of Tukey's biweight in standard deviations: 95 % efficient for normal noise (Holland and Welsch 1977,
https://doi.org/10.1080/03610927708827533)."""


@dataclass(frozen=True, eq=False)
class Light:
    """Light on the ground, estimated from one frame, and the signal of further frames.

    Attributes
    ----------
    ground
        (rows, columns) grey values of the ground without targets.
    evening
        Subtract: signal = frame - ground. Divide: signal = mean ground (frame/ground - 1); targets have the same
        contrast in dim and in bright parts.
    sign
        +1 for bright targets, -1 for dark ones.
    noise
        Standard deviation of the signal in the ground, grey values.
    samples
        Places of pixels of the ground (in the flattened frame) from which the brightness of a frame is taken.
    """

    ground: Frame
    evening: Evening
    sign: float
    noise: float
    samples: np.ndarray

    def signal(self, frame: Frame) -> Frame:
        """Signal of a frame, (rows, columns) grey values: zero in the ground, positive on targets.

        The mean brightness of the ground is taken from each frame, so that a lamp that flickers has no effect.
        """
        ground = self.ground.ravel()[self.samples]
        seen = frame.ravel()[self.samples]
        if self.evening == "subtract":
            offset = np.float32(np.mean(seen - ground, dtype=float))
            result = frame - self.ground
            result -= offset
        else:
            gain = np.mean(seen / ground, dtype=float)
            level = float(np.mean(self.ground, dtype=float))
            result = frame / self.ground
            result *= np.float32(level / gain)
            result -= np.float32(level)
        return result if self.sign > 0 else np.negative(result, out=result)


def estimate_light(
    frame: Frame, *, background: Background = "surface", window: int = 128, evening: Evening = "subtract",
    targets: Targets = "auto",
) -> Light:  # fmt: skip
    """Light on the ground from one frame.

    Parameters
    ----------
    frame
        (rows, columns) grey values.
    background
        Surface: polynomial of degree 4 through the ground, fitted so that targets have no influence if they cover less
        than half of the frame. Median: median over a window that is wider than the targets. None: no ground.
    window
        Width of the window, px.
    evening
        Whether the ground is subtracted, or the frame is divided by it.
    targets
        Whether targets are bright or dark; auto: the side with more light beyond the noise.

    Raises
    ------
    InputError
        If the frame has no contrast, or the ground is too dark to divide by it.
    """
    if float(frame.max()) == float(frame.min()):
        raise InputError(
            f"the first frame is uniform (grey value {float(frame[0, 0]):g})", remedy="check the recording"
        )
    if background == "none":
        ground = np.zeros_like(frame)
    else:
        size = max(min(frame.shape) // 64, 2)
        centres, blocks = _block_medians(frame, size)
        ground = (
            _surface(centres, blocks, frame.shape) if background == "surface"
            else _wide_median(centres, blocks, window / size, frame.shape)
        )  # fmt: skip
    if evening == "divide" and float(ground.min()) <= 0.02 * float(frame.max()):
        raise InputError(
            f"the ground is too dark to divide by it (grey value {float(ground.min()):.3g} of {float(frame.max()):.3g})",
            key="evening", remedy="use evening: subtract",
        )  # fmt: skip
    rest = frame - ground
    quiet, noise = _quiet(rest)
    sign = {"bright": 1.0, "dark": -1.0}.get(targets) or _side(rest, noise)
    places = np.flatnonzero(quiet.ravel())
    samples = places[:: max(places.size // _SAMPLES, 1)]
    scale = float(np.mean(ground)) / ground if evening == "divide" else 1.0
    return Light(ground, evening, sign, noise * float(np.mean(scale)), samples)


def _block_medians(frame: Frame, size: int) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
    """Medians over blocks of size x size pixels, and their centres along rows and columns."""
    rows, columns = (n // size for n in frame.shape)
    cut = frame[: rows * size, : columns * size].reshape(rows, size, columns, size)
    medians = np.median(cut.transpose(0, 2, 1, 3).reshape(rows, columns, -1), axis=2).astype(float)
    return tuple(size * (np.arange(n) + 0.5) - 0.5 for n in (rows, columns)), medians  # type: ignore[return-value]


def _surface(centres: tuple[FloatArray, FloatArray], blocks: FloatArray, shape: tuple[int, ...]) -> Frame:
    """Polynomial through the blocks by least squares with Tukey's weights, which leave targets out."""
    scaled = [2.0 * c / n - 1.0 for c, n in zip(centres, shape, strict=True)]
    terms = [(p, q) for p in range(_DEGREE + 1) for q in range(_DEGREE + 1 - p)]
    v, u = np.meshgrid(*scaled, indexing="ij")
    matrix = np.stack([(v**p * u**q).ravel() for p, q in terms], axis=1)
    values = blocks.ravel()
    fitted = np.full_like(values, np.median(values))
    coefficients = np.zeros(len(terms))
    for step in range(30):
        rest = np.abs(values - fitted)
        scale = max(1.4826 * float(np.median(rest)), 1e-6 * float(np.ptp(values)) + 1e-12)
        far = rest / scale
        # absolute deviations first: their only minimum does not depend on the start
        weight = 1.0 / np.maximum(far, 0.1) if step < 15 else np.maximum(1.0 - (far / _TUKEY) ** 2, 0.0) ** 2
        root = np.sqrt(weight)
        coefficients = np.linalg.lstsq(matrix * root[:, None], values * root, rcond=None)[0]
        fitted = matrix @ coefficients
    powers = [np.stack([(2.0 * np.arange(n) / n - 1.0) ** p for p in range(_DEGREE + 1)]) for n in shape]
    table = np.zeros((_DEGREE + 1, _DEGREE + 1))
    for (p, q), value in zip(terms, coefficients, strict=True):
        table[p, q] = value
    return (powers[0].T @ table @ powers[1]).astype(np.float32)


def _wide_median(
    centres: tuple[FloatArray, FloatArray], blocks: FloatArray, width: float, shape: tuple[int, ...]
) -> Frame:
    """Median of the blocks over a window (in blocks), interpolated between their centres."""
    from scipy.ndimage import median_filter

    filtered = median_filter(blocks, size=max(int(round(width)) | 1, 3), mode="nearest")
    along = np.stack([np.interp(np.arange(shape[0]), centres[0], column) for column in filtered.T], axis=1)
    return np.stack([np.interp(np.arange(shape[1]), centres[1], row) for row in along]).astype(np.float32)


def _quiet(rest: Frame) -> tuple[BoolArray, float]:
    """Pixels of the ground, and the standard deviation of their noise (at least that of rounding)."""
    sample = rest.ravel()[:: max(rest.size // 65536, 1)].astype(float)
    middle = float(np.median(sample))
    width = 1.4826 * float(np.median(np.abs(sample - middle))) + 0.3
    quiet = np.abs(rest - middle) < 3.0 * width
    return quiet, float(np.std(rest[quiet], dtype=float))


def _side(rest: Frame, noise: float) -> float:
    """+1 if more light lies above the ground than below it, beyond five standard deviations; otherwise -1."""
    far = rest[np.abs(rest) > 5.0 * noise]
    return 1.0 if float(np.sum(far, dtype=float)) >= 0.0 else -1.0
