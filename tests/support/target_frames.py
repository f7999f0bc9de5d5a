"""Recordings of rendered targets in memory, with known motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from wroll_fem.lab.slip_images.frames.rendering import Disc, recorded, render
from wroll_fem.lab.slip_images.targets.survey import Search
from wroll_fem.lab.slip_images.targets.targets import Filters

RATE, FREQUENCY = 2000.0, 140.0
SEARCH = Search(Filters((20.0, 1e5), (4.0, 300.0), 0.75))


class Recording:
    """Frames in memory, as from `open_frames`."""

    def __init__(self, frames: Sequence[np.ndarray]) -> None:
        self._frames, self.name = frames, "recording"
        self.shape = frames[0].shape

    def __len__(self) -> int:
        return len(self._frames)

    def __iter__(self) -> Iterator[np.ndarray]:
        return (frame.astype(np.float32) for frame in self._frames)


def uneven_light(shape: tuple[int, int], level: float = 100.0, slope: float = 0.4) -> np.ndarray:
    """Light that falls by ``slope`` over the frame, and is curved."""
    y, x = np.mgrid[: shape[0], : shape[1]] / max(shape)
    return (level * (1.0 + slope * (x - 0.5) - slope * (y - 0.4) ** 2)).astype(np.float32)


def turns(count: int) -> np.ndarray:
    """Rotating unit vector at the excitation frequency, (count,)."""
    return np.exp(2j * np.pi * FREQUENCY / RATE * np.arange(count))


def record(
    shape: tuple[int, int], discs: tuple[Disc, ...], motion: np.ndarray, count: int, *, noise: float = 5.0,
    light: np.ndarray | float = 100.0, ground: float = 0.4, seed: int = 0,
    shown: Callable[[int], tuple[bool, ...]] | None = None, drift: np.ndarray | float = 0.0,
) -> Recording:  # fmt: skip
    """Recording of discs that move with complex amplitudes (targets, 2) and drift (px per frame)."""
    rng, frames = np.random.default_rng(seed), []
    for k, turn in enumerate(turns(count)):
        shift = np.real(motion * turn) + drift * k
        image = render(shape, discs, shift, light=light, ground=ground, shown=None if shown is None else shown(k))
        frames.append(recorded(image, rng.normal(0.0, noise, shape)))
    return Recording(frames)


def positions(discs: tuple[Disc, ...], motion: np.ndarray, count: int, drift: np.ndarray | float = 0.0) -> np.ndarray:
    """True positions (frames, targets, 2), px."""
    rest = np.array([(disc.x, disc.y) for disc in discs])
    return rest + np.real(motion * turns(count)[:, None, None]) + drift * np.arange(count)[:, None, None]
