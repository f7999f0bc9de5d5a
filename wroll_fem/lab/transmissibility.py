"""Transmissibility from records of base and tip: H1 and coherence, resonance frequency and damping."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from pydantic import Field

from wroll_fem.case.base import Real
from wroll_fem.lab.kinds import Figure, Kind
from wroll_fem.lab.result import LabResult
from wroll_fem.lab.settings import LabSettings
from wroll_fem.progress import Progress
from wroll_fem.signals.estimators import estimate_damping
from wroll_fem.signals.random.welch import averaged_spectra
from wroll_fem.signals.records.record import read_record


class TransmissibilitySettings(LabSettings):
    """Columns, units and method of the evaluation `transmissibility`."""

    base: str = Field("base", description="column of the base acceleration")
    tip: str = Field("tip", description="column of the absolute tip acceleration")
    unit: str = Field("m/s^2", description="unit of both columns: m/s^2, g or mm/s^2")
    resolution: Real = Field(1.0, gt=0.0, description="distance between the lines of the spectra, Hz")


def transmissibility(files: Sequence[Path], settings: TransmissibilitySettings, progress: Progress) -> LabResult:
    """Evaluate records; each file is one trial."""
    curves = []
    with progress.stage("records", len(files)) as stage:
        for k, path in enumerate(files, start=1):
            base = read_record(path, unit=settings.unit, column=settings.base)
            tip = read_record(path, unit=settings.unit, column=settings.tip)
            for text in (*base.remarks, *tip.remarks):
                progress.warning(f"{path}: {text}")
            curves.append(averaged_spectra(base.acceleration, tip.acceleration, base.dt, settings.resolution))
            stage.update(k)
    h1 = np.mean([one.h1 for one in curves], axis=0)
    coherence = np.mean([one.coherence for one in curves], axis=0)
    read = estimate_damping(curves[0].frequency, h1, "rational_fraction").damping
    columns = {"transmissibility_real": h1.real, "transmissibility_imag": h1.imag, "coherence": coherence}
    data = xr.Dataset(
        {name: ("frequency", np.array(values)) for name, values in columns.items()},
        coords={"frequency": curves[0].frequency},
    )
    return LabResult({"f_n_hz": read.f_n, "zeta": read.zeta}, data)


def example(folder: Path) -> list[Path]:
    """Write one record of an oscillator of 100 Hz with a damping ratio of 2 %."""
    from scipy.signal import lfilter

    rate, f_n, zeta = 1024.0, 100.0, 0.02
    rng = np.random.default_rng(1)
    base = rng.standard_normal(20 * int(rate))
    pole = np.exp((-zeta + 1j * np.sqrt(1.0 - zeta**2)) * 2.0 * np.pi * f_n / rate)
    tip = lfilter([1.0 - 2.0 * pole.real + abs(pole) ** 2], [1.0, -2.0 * pole.real, abs(pole) ** 2], base)
    path = folder / "trial.npz"
    np.savez(path, time=np.arange(base.size) / rate, base=base, tip=tip)
    return [path]


KIND = Kind(
    settings=TransmissibilitySettings,
    evaluate=transmissibility,
    files="One record per file (CSV, .npz, .mat, UFF 58) with columns of time, base and tip.",
    figures={"coherence": Figure("wroll_fem.plotting.laboratory.transmissibility:plot_coherence", "coherence")},
    variables={"frequency": ("transmissibility_real", "transmissibility_imag", "coherence")},
    example=example,
)
