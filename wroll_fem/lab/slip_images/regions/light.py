"""Light on the ground behind the targets, and the signal: a frame without it, positive on targets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.frames.stream import Frame
from wroll_fem.typing import BoolArray, FloatArray

Background = Literal["surface", "median", "none"]
Evening = Literal["targets", "ground", "none"]
Targets = Literal["auto", "bright", "dark"]

_DEGREE = 4
_SAMPLES = 4096
_TUKEY = 4.685
"""Cut-off of Tukey's biweight in standard deviations: 95 % efficient for normal noise (Holland and Welsch 1977,
https://doi.org/10.1080/03610927708827533)."""


@dataclass(frozen=True, eq=False)
class Light:
    """Light on the ground, and the signal of further frames.

    Attributes
    ----------
    ground
        (rows, columns) grey values of the ground without targets.
    factor
        (rows, columns) by which the difference from the ground is multiplied: positive for bright targets, negative for
        dark ones.
    gain
        Whether the brightness of a frame is a factor (True) or an offset.
    noise
        Standard deviation of the signal in the ground, grey values.
    samples
        Places of pixels of the ground (in the flattened frame) from which the brightness of a frame is taken.
    """

    ground: Frame
    factor: Frame
    gain: bool
    noise: float
    samples: np.ndarray

    def signal(self, frame: Frame) -> Frame:
        """Signal of a frame, (rows, columns) grey values: zero in the ground, positive on targets.

        The mean brightness of the ground is taken from each frame, so that a lamp that flickers has no effect.
        """
        ground = self.ground.ravel()[self.samples]
        seen = frame.ravel()[self.samples]
        if self.gain:
            result = frame / np.float32(np.mean(seen / ground, dtype=float))
            result -= self.ground
        else:
            result = frame - self.ground
            result -= np.float32(np.mean(seen - ground, dtype=float))
        result *= self.factor
        return result

    def evened(self, contrast: Frame) -> Light:
        """Light whose signal is divided by a contrast (rows, columns) with mean 1."""
        noise = self.noise * float(np.mean(1.0 / contrast, dtype=float))
        return replace(self, factor=self.factor / contrast, noise=noise)


def estimate_light(
    frame: Frame, mean: Frame | None = None, *, background: Background = "surface", window: int = 128,
    divide: bool = False, targets: Targets = "auto",
) -> Light:  # fmt: skip
    """Light on the ground.

    Parameters
    ----------
    frame
        (rows, columns) grey values of one frame, for its noise.
    mean
        Mean of several frames, for the light; by default the one frame.
    background
        Surface: polynomial of degree 4 through the ground, fitted so that targets have no influence if they cover less
        than half of the frame. Median: median over a window that is wider than the targets. None: no ground.
    window
        Width of the window, px.
    divide
        Whether the frame is also divided by the ground.
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
        centres, blocks = _block_medians(frame if mean is None else mean, size)
        ground = (
            _surface(centres, blocks, frame.shape, targets) if background == "surface"
            else _wide_median(centres, blocks, window / size, frame.shape)
        )  # fmt: skip
    darkest, brightest = float(ground.min()), float(frame.max())
    if divide and darkest <= 0.02 * brightest:
        raise InputError(
            f"the ground is too dark to divide by it (grey value {darkest:.3g} of {brightest:.3g})",
            key="evening", remedy="use evening: targets",
        )  # fmt: skip
    rest = frame - ground
    quiet, noise = _quiet(rest)
    sign = {"bright": 1.0, "dark": -1.0}.get(targets) or _side(rest, noise)
    places = np.flatnonzero(quiet & _away_from_targets((frame if mean is None else mean) - ground))
    factor = np.float32(sign) * (float(np.mean(ground)) / ground if divide else np.ones_like(frame))
    noise = float(np.std(rest.ravel()[places], dtype=float))
    samples = places[:: max(places.size // _SAMPLES, 1)]
    return Light(ground, factor.astype(np.float32), divide, noise * float(np.mean(np.abs(factor))), samples)


def _block_medians(frame: Frame, size: int) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
    """Medians over blocks of size x size pixels, and their centres along rows and columns."""
    rows, columns = (n // size for n in frame.shape)
    cut = frame[: rows * size, : columns * size].reshape(rows, size, columns, size)
    medians = np.median(cut.transpose(0, 2, 1, 3).reshape(rows, columns, -1), axis=2).astype(float)
    return tuple(size * (np.arange(n) + 0.5) - 0.5 for n in (rows, columns)), medians  # type: ignore[return-value]


def _surface(
    centres: tuple[FloatArray, FloatArray], blocks: FloatArray, shape: tuple[int, ...], targets: Targets
) -> Frame:
    """Polynomial through the blocks of the ground."""
    scaled = [2.0 * c / n - 1.0 for c, n in zip(centres, shape, strict=True)]
    terms = [(p, q) for p in range(_DEGREE + 1) for q in range(_DEGREE + 1 - p)]
    v, u = np.meshgrid(*scaled, indexing="ij")
    matrix = np.stack([(v**p * u**q).ravel() for p, q in terms], axis=1)
    shares = {"bright": (0.25,), "dark": (0.75,), "auto": (0.25, 0.75)}[targets]
    _, coefficients = min((_fitted(matrix, blocks.ravel(), share) for share in shares), key=lambda one: one[0])
    powers = [np.stack([(2.0 * np.arange(n) / n - 1.0) ** p for p in range(_DEGREE + 1)]) for n in shape]
    table = np.zeros((_DEGREE + 1, _DEGREE + 1))
    for (p, q), value in zip(terms, coefficients, strict=True):
        table[p, q] = value
    return (powers[0].T @ table @ powers[1]).astype(np.float32)


def _fitted(matrix: FloatArray, values: FloatArray, share: float) -> tuple[float, FloatArray]:
    """Median distance of values from a polynomial, and its coefficients.

    First a share of the values is below it, then it is fitted with Tukey's weights, which leave targets out.
    """
    rest = values - np.quantile(values, share)
    coefficients, scale = np.zeros(matrix.shape[1]), 0.0
    for step in range(40):
        scale = max(1.4826 * float(np.median(np.abs(rest))), 1e-6 * float(np.ptp(values)) + 1e-12)
        far = np.abs(rest) / scale
        if step < 25:  # the quantile, between ground and targets as long as these cover less than half
            weight = np.where(rest > 0.0, share, 1.0 - share) / np.maximum(far, 0.02)
        else:
            weight = np.maximum(1.0 - (far / _TUKEY) ** 2, 0.0) ** 2
        root = np.sqrt(weight)
        coefficients = np.linalg.lstsq(matrix * root[:, None], values * root, rcond=None)[0]
        rest = values - matrix @ coefficients
    return scale, coefficients


def _wide_median(
    centres: tuple[FloatArray, FloatArray], blocks: FloatArray, width: float, shape: tuple[int, ...]
) -> Frame:
    """Median of the blocks over a window (in blocks), interpolated between their centres."""
    from scipy.ndimage import median_filter

    filtered = median_filter(blocks, size=max(round(width) | 1, 3), mode="nearest")
    along = np.stack([np.interp(np.arange(shape[0]), centres[0], column) for column in filtered.T], axis=1)
    return np.stack([np.interp(np.arange(shape[1]), centres[1], row) for row in along]).astype(np.float32)


def _quiet(rest: Frame) -> tuple[BoolArray, float]:
    """Pixels of the ground, and the standard deviation of their noise (at least that of rounding)."""
    sample = rest.ravel()[:: max(rest.size // 65536, 1)].astype(float)
    middle = float(np.median(sample))
    width = 1.4826 * float(np.median(np.abs(sample - middle))) + 0.3
    quiet = np.abs(rest - middle) < 3.0 * width
    return quiet, float(np.std(rest[quiet], dtype=float))


def _away_from_targets(rest: Frame) -> BoolArray:
    """Pixels of the ground away from the targets: 8 px, or fewer if this leaves less than a twentieth of the frame.

    Edges that move over pixels of the ground would change its brightness.
    """
    from scipy.ndimage import binary_dilation, uniform_filter

    smooth = np.abs(uniform_filter(rest, 3))
    covered = smooth > 0.1 * float(np.percentile(smooth, 99.5))
    result = np.ones(rest.shape, dtype=bool)
    for width in (8, 4, 2, 1):
        result = ~binary_dilation(covered, np.ones((3, 3)), iterations=width)
        if float(np.mean(result)) >= 0.05:
            return result
    return result if result.any() else np.ones_like(result)


def _side(rest: Frame, noise: float) -> float:
    """+1 if more light lies above the ground than below it, beyond five standard deviations; otherwise -1."""
    far = rest[np.abs(rest) > 5.0 * noise]
    return 1.0 if float(np.sum(far, dtype=float)) >= 0.0 else -1.0
