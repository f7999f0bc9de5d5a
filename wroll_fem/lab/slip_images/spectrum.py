"""Amplitude and phase at single frequencies by least squares, which tolerate missing frames; noise floor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import ComplexArray, FloatArray

LEAST_CYCLES, LEAST_RATE, LEAST_LINES = 3.0, 2.5, 3
"""Cycles of the excitation in a recording, frames per cycle, and lines on each side of the band, at least."""

LEAST_SHARE = 0.5
"""Share of the frames in which both targets are seen, below which no amplitude is given."""


def harmonics(values: FloatArray, rate: float, frequency: FloatArray) -> ComplexArray:
    """Complex amplitudes X of values = offset + drift t + Re(X exp(2 pi i f t)), one frequency f at a time.

    Parameters
    ----------
    values
        (frames, ...) samples at equal steps from t = 0; nan where missing.
    rate
        Frames per second, Hz.
    frequency
        (n,) frequencies, Hz.

    Returns
    -------
    ndarray
        (n, ...) amplitude (0-peak) and phase at the first frame; nan if more than half of the samples are missing.
    """
    flat = values.reshape(len(values), -1)
    valid = np.isfinite(flat)
    result = np.full((len(frequency), flat.shape[1]), np.nan + 1j * np.nan)
    patterns, which = np.unique(valid, axis=1, return_inverse=True)
    step = np.arange(len(flat))
    for n, pattern in enumerate(patterns.T):
        if np.count_nonzero(pattern) < max(LEAST_SHARE * len(pattern), 8):
            continue
        channels = np.flatnonzero(np.ravel(which) == n)
        data, place = flat[np.ix_(pattern, channels)], step[pattern]
        line = np.stack([np.ones(len(place)), 2.0 * place / len(flat) - 1.0], axis=1)
        for k, f in enumerate(frequency):
            angle = 2.0 * np.pi * f / rate * place
            matrix = np.concatenate([line, np.cos(angle)[:, None], -np.sin(angle)[:, None]], axis=1)
            found = np.linalg.solve(matrix.T @ matrix, matrix.T @ data)
            result[k, channels] = found[2] + 1j * found[3]
    return result.reshape(len(frequency), *values.shape[1:])


def band_lines(count: int, rate: float, frequency: float, half_width: float) -> FloatArray:
    """Frequencies around the excitation, Hz: the excitation itself, and steps of one over the duration to both sides.

    Raises
    ------
    InputError
        If the frames are too few, too slow, or do not resolve the band.
    """
    if rate < LEAST_RATE * frequency:
        raise InputError(
            f"{rate:g} frames per second are {rate / frequency:.2f} per cycle of {frequency:g} Hz (at least "
            f"{LEAST_RATE:g})", key="frame_rate", remedy="record faster",
        )  # fmt: skip
    duration = count / rate
    if duration * frequency < LEAST_CYCLES:
        raise InputError(
            f"{count} frames are {duration * frequency:.2g} cycles of {frequency:g} Hz (at least {LEAST_CYCLES:g})",
            key="frequency", remedy=f"record at least {int(np.ceil(LEAST_CYCLES / frequency * rate))} frames",
        )  # fmt: skip
    below = min(half_width, frequency - 1.0 / duration)
    above = min(half_width, 0.5 * rate - frequency - 1.0 / duration)
    counts = [int(np.floor(width * duration + 1e-9)) for width in (below, above)]
    if min(counts) < LEAST_LINES:
        raise InputError(
            f"{count} frames resolve {1.0 / duration:.3g} Hz, too coarse for a band of +-{half_width:g} Hz around "
            f"{frequency:g} Hz", key="band", remedy="record longer or widen the band",
        )  # fmt: skip
    return frequency + np.arange(-counts[0], counts[1] + 1) / duration


class Noise(NamedTuple):
    """Noise of the positions.

    Attributes
    ----------
    floor
        Largest amplitude of any target along x or y at any line of the band, 0-peak px (delta of the thesis).
    spectrum
        (lines, targets, 2) amplitudes, the largest over the parts of the recording, 0-peak px.
    deviation
        (targets, 2) standard deviation of the positions in time, px.
    parts
        Number of parts of the length of the motion's recording.
    """

    floor: float
    spectrum: FloatArray
    deviation: FloatArray
    parts: int

    @property
    def slip_floor(self) -> float:
        """Floor of a difference of two positions with independent noise, sqrt(2) floor, 0-peak px."""
        return float(np.sqrt(2.0) * self.floor)


def noise_at_rest(position: FloatArray, rate: float, lines: FloatArray, length: int) -> Noise:
    """Noise from a recording at rest, by the same steps as the motion.

    Parameters
    ----------
    position
        (frames, targets, 2), px.
    rate
        Frames per second, Hz.
    lines
        Frequencies of the band, Hz.
    length
        Number of frames of the motion; a longer recording at rest is divided into parts of this length, because the
        amplitude of noise falls with the square root of the number of frames.
    """
    parts = max(len(position) // length, 1)
    pieces = [position[k * length : (k + 1) * length] for k in range(parts)] if parts > 1 else [position]
    spectrum = np.nanmax([np.abs(harmonics(piece, rate, lines)) for piece in pieces], axis=0)
    return Noise(_largest(spectrum), spectrum, np.nanstd(position, axis=0), parts)


def noise_beside_line(position: FloatArray, rate: float, lines: FloatArray, frequency: float) -> Noise:
    """Noise from the motion itself: lines of the band after the motion at the excitation frequency is subtracted."""
    at = harmonics(position, rate, np.array([frequency]))[0]
    time = np.arange(len(position)) / rate
    rest = position - np.real(at[None] * np.exp(2j * np.pi * frequency * time)[:, None, None])
    away = np.abs(lines - frequency) > 0.5 * rate / len(position)
    spectrum = np.abs(harmonics(rest, rate, lines))
    return Noise(_largest(spectrum[away]), spectrum, np.nanstd(rest, axis=0), 1)


def _largest(spectrum: FloatArray) -> float:
    if not np.isfinite(spectrum).any():
        raise InputError(
            "no target is seen in half of the frames", remedy="improve the light, or change the limits of targets"
        )
    return float(np.nanmax(spectrum))


def better_frequency(values: FloatArray, rate: float, frequency: float) -> tuple[float, float]:
    """Frequency within 1.5 lines at which the motion is largest, and its amplitude there over that at ``frequency``.

    Parameters
    ----------
    values
        (frames, ...) positions, px.
    rate, frequency
        Frames per second and excitation frequency, Hz.
    """
    width = 1.5 * rate / len(values)
    trial = frequency + np.linspace(-width, width, 61)
    flat = values.reshape(len(values), -1)
    flat = flat[:, np.isfinite(flat).mean(axis=0) >= LEAST_SHARE]
    power = np.sum(np.abs(harmonics(flat, rate, np.append(trial, frequency))) ** 2, axis=1)
    best = int(np.argmax(power[:-1]))
    return float(trial[best]), float(np.sqrt(power[best] / max(power[-1], 1e-300)))
