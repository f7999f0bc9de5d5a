"""Shock response spectra against those of pyyeti, for random records and pulses.

Usage: pip install --no-deps --target FOLDER pyyeti
       PYTHONPATH=FOLDER python benchmarks/shock_spectra.py [--page docs/tables/shock_spectra.md]

pyyeti takes the largest sample of a response as its extreme. So its records are refined by straight lines, which does
not change the motion of either program: both are exact for records of straight lines.
"""

from __future__ import annotations

import argparse
import warnings
from importlib.metadata import version
from pathlib import Path

import wroll_fem as wf  # isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
from pyyeti.srs import srs  # type: ignore[import-not-found,unused-ignore]
from scipy.signal import butter, sosfilt

from wroll_fem.signals.shock.spectrum import INTERVALS, shock_spectra
from wroll_fem.typing import FloatArray

SEED, RECORDS, SAMPLES, DT = 1, 20, 2000, 1e-4
HIGHEST, SAMPLES_PER_CYCLE = 1000.0, 200
QUALITIES = (5.0, 10.0, 25.0, 50.0)
QUANTITIES = {"absolute_acceleration": "absacce", "relative_displacement": "reldisp", "pseudo_velocity": "pvelo"}

HEAD = """# Shock response spectra against pyyeti

`wf.signals.shock_spectra` against `pyyeti.srs.srs` {version}: {records} random records (seed {seed}; band-limited noise
of 0.2 s that decays, Q from 5 to 50), a half-sine and a sawtooth of 11 ms, natural frequencies from 10 to 1000 Hz. Both
programs are exact for records of straight lines; pyyeti takes the largest of the samples, {samples} or more per cycle
here: for a sine of the natural frequency that is up to {lost:.3f} % too low. Computed by
`PYTHONPATH=FOLDER .venv/bin/python benchmarks/shock_spectra.py --page docs/tables/shock_spectra.md`, after
`pip install --no-deps --target FOLDER pyyeti` (pyyeti's other requirements are not needed, and one brings an HDF5 of
its own).

"""


def records() -> dict[str, FloatArray]:
    """Base accelerations, m/s^2, with a step of `DT`."""
    rng, time = np.random.default_rng(SEED), DT * np.arange(SAMPLES)
    found = {}
    for number in range(RECORDS):
        band = np.sort(rng.uniform(10.0, 2000.0, 2)) + [0.0, 50.0]
        noise = sosfilt(butter(2, band, "bandpass", fs=1.0 / DT, output="sos"), rng.standard_normal(SAMPLES))
        ends = np.minimum(1.0, np.arange(SAMPLES)[::-1] / 50.0) * np.minimum(1.0, np.arange(SAMPLES) / 50.0)  # no jumps
        found[f"random {number}"] = noise * ends * np.exp(-time / rng.uniform(0.02, 0.2))
    found["half-sine"] = wf.signals.HalfSine(100.0, 0.011).acceleration(time)
    found["sawtooth"] = wf.signals.Sawtooth(100.0, 0.011).acceleration(time)
    return found


def differences(record: FloatArray, frequencies: FloatArray, q: float) -> dict[tuple[str, str], FloatArray]:
    """Relative differences of both programs by quantity and interval."""
    factor = int(np.ceil(SAMPLES_PER_CYCLE * HIGHEST * DT))
    count = (len(record) - 1) * factor + 1
    fine = np.interp(np.arange(count) / factor, np.arange(len(record)), record)
    found = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # 10 samples per cycle at the highest natural frequency
        ours = shock_spectra(record, DT, frequencies, q)
    for quantity, kind in QUANTITIES.items():
        # primary: the record as it is; total: with the free vibration after the last sample, where the base is at rest
        primary = _of_pyyeti(fine, factor, frequencies, q, kind)
        at_rest = np.concatenate([fine, np.zeros(1 + int(1.5 * factor / (DT * frequencies.min())))])
        total = _of_pyyeti(at_rest, factor, frequencies, q, kind)
        values = dict(zip(INTERVALS, ours[quantity], strict=True))
        found[quantity, "primary"] = values["primary"] / primary - 1.0
        found[quantity, "maximax"] = values["maximax"] / total - 1.0
    return found


def _of_pyyeti(record: FloatArray, factor: int, frequencies: FloatArray, q: float, kind: str) -> FloatArray:
    return np.asarray(srs(record, factor / DT, frequencies, q, stype=kind, rolloff="none", parallel="no")).ravel()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--page", type=Path, help="page that receives the table")
    page, frequencies = parser.parse_args().page, np.geomspace(10.0, HIGHEST, 37)
    rows: dict[tuple[str, str], list[float]] = {}
    for number, record in enumerate(records().values()):
        for key, apart in differences(record, frequencies, QUALITIES[number % len(QUALITIES)]).items():
            rows.setdefault(key, []).append(100.0 * float(np.abs(apart).max()))
    lines = ["| quantity | interval | largest difference | median of the records |", "|---|---|---|---|"]
    for (quantity, interval), apart in rows.items():
        lines.append(f"| {quantity} | {interval} | {max(apart):.3f} % | {float(np.median(apart)):.3f} % |")
    print("\n".join(lines))
    if page is not None:
        lost = 100.0 * (1.0 - np.cos(np.pi / SAMPLES_PER_CYCLE))
        head = HEAD.format(version=version("pyyeti"), records=RECORDS, seed=SEED, samples=SAMPLES_PER_CYCLE, lost=lost)
        page.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
