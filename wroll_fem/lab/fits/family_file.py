"""Families of transmissibility curves from the results of the evaluation `transmissibility`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, pi, sqrt
from pathlib import Path

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.results.dataset import load_dataset
from wroll_fem.typing import FloatArray

_NEEDED = (
    "family_real", "family_imag", "frequency", "condition_name", "tension", "base_level", "condition_f_n",
    "condition_zeta", "condition_f_n_interval", "condition_peak",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Resonance:
    """Measured resonance of one condition.

    Attributes
    ----------
    name
        Label of the condition.
    tension
        Winding tension, N; nan if unknown.
    motion
        Motion of the base: "random" or "sweep".
    base_level
        Base acceleration at the resonance, m/s^2 (0-peak of a sweep).
    f_n, f_n_error
        Resonance frequency and its standard error, Hz.
    zeta, peak
        Damping ratio, and height of the peak.
    frequency, magnitude
        (n,) curve: Hz, ascending, and |T|.
    """

    name: str
    tension: float
    motion: str
    base_level: float
    f_n: float
    f_n_error: float
    zeta: float
    peak: float
    frequency: FloatArray
    magnitude: FloatArray

    @property
    def base_amplitude(self) -> float:
        """Amplitude of the base displacement at the resonance, m."""
        return self.base_level / (2.0 * pi * self.f_n) ** 2

    @property
    def tip_amplitude(self) -> float:
        """Amplitude of the tip displacement relative to the base at the resonance, m.

        At the resonance of one mode the relative motion is in quadrature with the base: |u| = Y_0 sqrt(T^2 - 1).
        """
        return self.base_amplitude * sqrt(max(self.peak**2 - 1.0, 0.0))


def read_families(paths: Sequence[Path]) -> list[Resonance]:
    """Resonances of all conditions of all files, without those that have no reading.

    Parameters
    ----------
    paths
        Result folders of the evaluation `transmissibility`, or their files results.nc.

    Raises
    ------
    InputError
        If a path has no such results, or no condition has a resonance.
    """
    found = []
    for path in paths:
        file = path / "results.nc" if path.is_dir() else path
        if file.suffix != ".nc":
            raise InputError(
                "is no results.nc", file=str(file), remedy="evaluate the records first: wroll lab transmissibility"
            )
        data = load_dataset(file)
        missing = [name for name in _NEEDED if name not in data.variables]
        if missing:
            raise InputError(
                f"has no family of curves ({missing[0]} is missing)", file=str(file),
                remedy="give a result of wroll lab transmissibility",
            )  # fmt: skip
        f = data["frequency"].values
        size = np.hypot(data["family_real"].values, data["family_imag"].values)
        numbers = {
            name: data[source].values.astype(float)
            for name, source in (
                ("tension", "tension"), ("base_level", "base_level"), ("f_n", "condition_f_n"),
                ("zeta", "condition_zeta"), ("f_n_error", "condition_f_n_interval"), ("peak", "condition_peak"),
            )
        }  # fmt: skip
        for k, name in enumerate(data["condition_name"].values):
            own = {key: float(values[k]) for key, values in numbers.items()}
            own["f_n_error"] /= 1.96
            positive = all(isfinite(own[key]) and own[key] > 0.0 for key in ("f_n", "base_level", "peak"))
            if not (positive and own["peak"] > 1.0):
                continue
            inside = np.isfinite(size[k])
            found.append(
                Resonance(
                    str(name),
                    motion=str(data.attrs.get("method", "")),
                    frequency=f[inside],
                    magnitude=size[k][inside],
                    **own,
                )
            )
    if not found:
        raise InputError("no condition has a resonance", file=str(paths[0]), remedy="widen the band of the evaluation")
    return found
