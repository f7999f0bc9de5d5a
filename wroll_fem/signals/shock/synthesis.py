"""Base motion with a given shock response spectrum: wavelets whose amplitudes are iterated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.signals.shock.spectrum import GOOD_SAMPLES, shock_spectrum
from wroll_fem.signals.shock.table import TOLERANCE_DB, SpectrumTable
from wroll_fem.signals.shock.wavelets import Wavelets
from wroll_fem.typing import FloatArray

LOWEST_HALF_CYCLES, MOST_HALF_CYCLES = 5, 31
"""Half cycles of the wavelet of the lowest frequency, and the most of any wavelet."""

SPREAD = 0.5
"""Largest delay of a wavelet, relative to the time that the longest wavelet lasts beyond it."""

ITERATIONS, GOOD_DB, TRIALS = 60, 0.5, 8
"""Most iterations of one trial; error that ends them; trials with other delays before the synthesis is given up."""

ACCEPTED_DB = TOLERANCE_DB - 0.05
"""Largest error of a motion that is accepted: a spectrum from finer samples differs by up to 0.05 dB."""


def synthesise_shock(table: SpectrumTable, *, seed: int = 1, before: float = 0.0, after: float = 0.0) -> Wavelets:
    """Base motion whose shock response spectrum is within 1.5 dB of a table at every sixth octave.

    Parameters
    ----------
    table
        Spectrum asked for.
    seed
        Seed of the delays and signs of the wavelets; the same seed gives the same motion.
    before, after
        Time without base acceleration before and after the motion, s.

    Returns
    -------
    Wavelets
        Motion; velocity and displacement of the base are zero at its end.

    Raises
    ------
    InputError
        If no motion has the spectrum, or none was found.

    Notes
    -----
    One wavelet per sixth of an octave. Each iteration multiplies its amplitude by the ratio of the wanted to the
    present spectrum at its frequency. Between these frequencies the spectrum is up to 2 dB off with Q = 10, and 4 dB
    with Q = 25, whose systems are narrower than a sixth of an octave.
    """
    table.refuse_impossible()
    rng = np.random.default_rng(seed)
    lines = table.lines()
    wanted = table.at(lines)
    best, error = None, np.full(len(lines), np.inf)
    for _ in range(TRIALS):
        motion, found = _iterated(_start(lines, wanted, rng), wanted, table.q)
        if np.abs(found).max() < np.abs(error).max():
            best, error = motion, found
        if np.abs(error).max() <= ACCEPTED_DB:
            break
    worst = int(np.argmax(np.abs(error)))
    if best is None or abs(error[worst]) > ACCEPTED_DB:
        raise InputError(
            f"no motion was found within {TOLERANCE_DB:g} dB of the spectrum: at {lines[worst]:.4g} Hz the best of "
            f"{TRIALS} trials is {error[worst]:+.1f} dB off",
            key="excitation.srs",
            remedy="flatten the table there (spectra rise by 12 dB per octave at most at low frequencies, and fall by "
            "less than 8 dB above their peak), or try another seed",
        )  # fmt: skip
    return replace(best, before=before, after=after)


def spectrum_error_db(motion: Wavelets, table: SpectrumTable, per_octave: int = 6) -> tuple[FloatArray, FloatArray]:
    """Frequencies (Hz) and the spectrum of a motion relative to a table there, dB; (m,) each."""
    lines = table.lines(per_octave)
    dt = 1.0 / (GOOD_SAMPLES * lines[-1])
    base = motion.acceleration(dt * np.arange(int(np.ceil(motion.duration / dt)) + 2))
    return lines, 20.0 * np.log10(shock_spectrum(base, dt, lines, table.q) / table.at(lines))


def _start(lines: FloatArray, wanted: FloatArray, rng: np.random.Generator) -> Wavelets:
    longest = 0.5 * LOWEST_HALF_CYCLES / lines[0]
    most = 2.0 * lines * longest * (1.0 - rng.uniform(0.0, SPREAD, len(lines)))
    half_cycles = 2 * np.clip(most // 2, LOWEST_HALF_CYCLES // 2, MOST_HALF_CYCLES // 2).astype(np.int64) + 1
    delay = SPREAD * rng.uniform(size=len(lines)) * np.maximum(longest - 0.5 * half_cycles / lines, 0.0)
    signs = rng.permutation(np.where(np.arange(len(lines)) % 2, -1.0, 1.0))
    return Wavelets(lines, signs * wanted / half_cycles, half_cycles, delay - delay.min())


def _iterated(motion: Wavelets, wanted: FloatArray, q: float) -> tuple[Wavelets, FloatArray]:
    """Best motion of the iteration and its errors (m,), dB."""
    lines = motion.lines
    dt = 1.0 / (GOOD_SAMPLES * lines[-1])
    time = dt * np.arange(int(np.ceil(motion.length / dt)) + 2)
    shapes = [
        replace(
            motion, lines=lines[[k]], level=np.ones(1), half_cycles=motion.half_cycles[[k]],
            delay=motion.delay[[k]],
        ).acceleration(time)
        for k in range(len(lines))
    ]  # fmt: skip
    matrix = np.array(shapes)
    level = motion.level
    best, error = motion, np.full(len(lines), np.inf)
    for _ in range(ITERATIONS):
        found = 20.0 * np.log10(shock_spectrum(level @ matrix, dt, lines, q) / wanted)
        if np.abs(found).max() < np.abs(error).max():
            best, error = replace(motion, level=level), found
        if np.abs(error).max() <= GOOD_DB:
            break
        level = level * 10.0 ** (-found / 20.0)
    return best, error
