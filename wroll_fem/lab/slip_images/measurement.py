"""Measurement of slip: frames in motion and at rest, table and settings to paths, noise, slip and scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.frames.stream import open_frames
from wroll_fem.lab.slip_images.scale import Scale, pixel_length
from wroll_fem.lab.slip_images.settings import SlipSettings
from wroll_fem.lab.slip_images.slip import Slip, layer_slip, mandrel_slip
from wroll_fem.lab.slip_images.spectrum import Noise, band_lines, better_frequency, noise_at_rest, noise_beside_line
from wroll_fem.lab.slip_images.table import Member, matched, read_table
from wroll_fem.lab.slip_images.targets.paths import Paths, follow
from wroll_fem.lab.slip_images.targets.targets import number_words
from wroll_fem.progress import Progress
from wroll_fem.typing import FloatArray

_SAME_FREQUENCY = 1.02
"""Ratio of the largest amplitude near the excitation to that at the given frequency, above which a warning is given."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """What is read from the images.

    Attributes
    ----------
    paths
        Paths of the targets.
    rest
        (frames, targets, 2) positions at rest, px; None without a recording at rest.
    members
        Table of the targets; empty without one.
    slip
        Slip relative to the mandrel, then between layers; None without a table.
    lines
        Frequencies of the band, Hz.
    noise
        Noise of the positions.
    scale
        Length of a pixel; None if no size is known.
    best_frequency
        Frequency near the excitation at which the motion is largest, Hz.
    """

    paths: Paths
    rest: FloatArray | None
    members: tuple[Member, ...]
    slip: Slip | None
    lines: FloatArray
    noise: Noise
    scale: Scale | None
    best_frequency: float


def measure(files: Sequence[Path], settings: SlipSettings, progress: Progress) -> Measurement:
    """Read frames and evaluate them; doubts are warnings.

    Raises
    ------
    InputError
        If frames, table or settings are wrong.
    """
    layout = settings.raw.layout() if settings.raw else None
    recording = open_frames(files, layout)
    count = len(recording) - settings.first_frame
    if settings.frames is not None:
        if settings.frames > count:
            progress.warning(
                f"frames: {settings.frames} are asked for, but the recording has {max(count, 0)} from first_frame on; "
                "these are used"
            )
        count = min(settings.frames, count)
    lines = band_lines(max(count, 1), settings.frame_rate, settings.frequency, settings.band)
    paths = follow(recording, settings.search(), first=settings.first_frame, count=settings.frames, progress=progress)
    _warn_of_losses(paths, progress)
    rest = None if settings.rest is None else _at_rest(Path(settings.rest), paths, settings, progress)
    noise = _noise(paths.position, rest, lines, settings, progress)
    members = () if settings.table is None else read_table(Path(settings.table), paths.first)
    slip = _slip(paths, members, settings)
    if slip is None:
        progress.warning(
            "no table of groups and layers: only the motion of the targets is evaluated; complete targets.csv of this "
            "folder and give it as table"
        )
    best = _best_frequency(paths.position, settings, progress)
    return Measurement(paths, rest, members, slip, lines, noise, _scale(paths, members, settings), best)


def _at_rest(path: Path, paths: Paths, settings: SlipSettings, progress: Progress) -> FloatArray:
    """Positions at rest of the targets of the motion, in their order."""
    if not path.exists():
        raise InputError("file or folder not found", key="rest", file=str(path), remedy="give the frames at rest")
    layout = settings.raw.layout() if settings.raw else None
    found = follow(open_frames([path], layout), settings.search(), progress=progress)
    reach = float(paths.first.diameter.min())
    mean = np.nanmean(paths.position, axis=0)
    place, distance = matched(mean, paths.first.diameter, found.first, reach)
    far = np.flatnonzero(distance > reach)
    if far.size:
        raise InputError(
            f"{number_words(far)} of the motion {'is' if far.size == 1 else 'are'} not among the "
            f"{len(found.first)} targets at rest within {reach:.3g} px", key="rest", file=str(path),
            remedy="record both with the same camera position and light",
        )  # fmt: skip
    return found.position[:, place]


def _noise(
    position: FloatArray, rest: FloatArray | None, lines: FloatArray, settings: SlipSettings, progress: Progress
) -> Noise:
    if rest is None:
        progress.warning(
            "noise floor from the lines beside the excitation, which contain motion as well; give rest frames as rest"
        )
        return noise_beside_line(position, settings.frame_rate, lines, settings.frequency)
    if len(rest) < len(position):
        progress.warning(
            f"{len(rest)} frames at rest, but {len(position)} in motion: the noise floor is too high by about "
            f"{np.sqrt(len(position) / len(rest)):.2g}; record as many frames at rest"
        )
    return noise_at_rest(rest, settings.frame_rate, lines, len(position))


def _slip(paths: Paths, members: tuple[Member, ...], settings: SlipSettings) -> Slip | None:
    if not members:
        return None
    mandrel = mandrel_slip(paths.position, members)
    layers = layer_slip(mandrel, settings.relative_to)
    return Slip(*(np.concatenate([a, b], axis=axis) for a, b, axis in zip(mandrel, layers, (0, 0, 1), strict=True)))


def _scale(paths: Paths, members: tuple[Member, ...], settings: SlipSettings) -> Scale | None:
    own = [(m.target, m.diameter) for m in members if m.diameter is not None]
    if own:
        places, known = np.array([p for p, _ in own]), np.array([d for _, d in own], dtype=float)
        return pixel_length(known, paths.diameter[places], settings.target_diameter_error)
    if settings.target_diameter is None:
        return None
    known = np.full(len(paths.diameter), settings.target_diameter)
    return pixel_length(known, paths.diameter, settings.target_diameter_error)


def _best_frequency(position: FloatArray, settings: SlipSettings, progress: Progress) -> float:
    best, ratio = better_frequency(position, settings.frame_rate, settings.frequency)
    if ratio > _SAME_FREQUENCY:
        progress.warning(
            f"the motion is largest at {best:.6g} Hz, {ratio:.3g} times as large as at {settings.frequency:g} Hz: "
            "amplitudes are too small; check frequency and frame_rate"
        )
    return best


def _warn_of_losses(paths: Paths, progress: Progress) -> None:
    lost = np.count_nonzero(~paths.seen, axis=0)
    merged = np.count_nonzero(paths.merged, axis=0)
    for n in np.flatnonzero(lost):
        together = f" (in {merged[n]} of them grown together with something bright)" if merged[n] else ""
        progress.warning(f"target {n + 1} is lost in {lost[n]} of {len(paths.position)} frames{together}")
    for one in paths.doubles:
        beside = f", beside target {one.near + 1}" if one.near >= 0 else ""
        progress.warning(
            f"a region like a target, but none of the first frame, in {one.count} frames from {one.first} to "
            f"{one.last} at x = {one.x:.1f} px, y = {one.y:.1f} px{beside}; it is not used"
        )
