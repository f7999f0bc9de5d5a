"""Synthetic shaker tests with known truth: an oscillator on a shaken base, with noise of the sensors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml
from scipy.signal import cont2discrete, lfilter, ss2tf

from wroll_fem.signals.random.random_motion import random_record
from wroll_fem.typing import ComplexArray, FloatArray


def oscillator_tip(base: FloatArray, dt: float, f_n: float, zeta: float) -> FloatArray:
    """Absolute tip acceleration (n,) of an oscillator from rest, exact for a base acceleration linear between samples.

    Parameters
    ----------
    base
        (n,) base acceleration.
    dt
        Time step, s.
    f_n, zeta
        Natural frequency, Hz, and damping ratio.
    """
    w = 2.0 * np.pi * f_n
    system = ([[0.0, 1.0], [-(w**2), -2.0 * zeta * w]], [[0.0], [-1.0]], [[-(w**2), -2.0 * zeta * w]], [[0.0]])
    a, b, c, d, _ = cont2discrete(tuple(map(np.array, system)), dt, method="foh")
    numerator, denominator = ss2tf(a, b, c, d)
    return np.asarray(lfilter(numerator[0], denominator, base))


WHITE = 1.0 / 280.0 / 9.80665**2
"""PSD, g^2/Hz, of a band of 280 Hz with 1 m/s^2 rms."""

CONDITIONS = (
    (20.0, 0.5, 141.0, 0.020),
    (20.0, 2.0, 137.0, 0.034),
    (60.0, 0.5, 152.0, 0.012),
    (60.0, 2.0, 150.0, 0.018),
)
"""Tension (N), level (m/s^2 rms), f_n (Hz) and zeta of the conditions of the example."""


def shaker_example(folder: Path) -> list[Path]:
    """Write records of an oscillator at two tensions and two levels, three trials each, with 2 % noise.

    The files have time (s), base (g) and tip (m/s); `truth.yaml` has frequency and damping of each condition.
    """
    written, conditions, truth = [], [], []
    fine, keep, duration = 4096.0, 4, 24.0
    for k, (tension, level, f_n, zeta) in enumerate(CONDITIONS):
        for trial in range(3):
            base = level * random_record([20.0, 300.0], WHITE, duration, fine, seed=10 * k + trial)
            tip = oscillator_tip(base, 1.0 / fine, f_n, zeta)[::keep]
            base, rate = base[::keep], fine / keep
            rng = np.random.default_rng(100 * k + trial)
            speed = np.fft.irfft(np.fft.rfft(tip) / _derivative(len(tip), rate), len(tip))
            noisy = [x + 0.02 * x.std() * rng.standard_normal(len(x)) for x in (base / 9.80665, speed)]
            path = folder / f"{tension:g}N_{level:g}_{trial + 1}.npz"
            np.savez(path, time=np.arange(len(base)) / rate, base=noisy[0], tip=noisy[1])
            written.append(path)
        conditions.append({"files": [f"{tension:g}N_{level:g}_*"], "tension": tension, "level": level})
        truth.append({"tension": tension, "level": level, "f_n_hz": f_n, "zeta": zeta})
    settings = {"base_unit": "g", "tip_unit": "m/s", "band": [60, 260], "conditions": conditions}
    (folder / "settings.yaml").write_text(yaml.safe_dump(settings, sort_keys=False), encoding="utf-8")
    (folder / "truth.yaml").write_text(yaml.safe_dump(truth, sort_keys=False), encoding="utf-8")
    return written


def _derivative(count: int, rate: float) -> ComplexArray:
    factors = 2j * np.pi * np.fft.rfftfreq(count, 1.0 / rate)
    factors[0] = np.inf
    return factors
