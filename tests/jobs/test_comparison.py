"""`wroll compare`: runs and measured tables, their resonances, what is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import Result

from wroll_fem.errors import InputError
from wroll_fem.jobs.comparison import comparison_lines, load_curves
from wroll_fem.results.resonance import resonance


def oscillator(f_n: float, zeta: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and complex transmissibility of a damped oscillator."""
    frequency = np.linspace(0.8 * f_n, 1.2 * f_n, 2001)
    ratio = frequency / f_n
    return frequency, (1.0 + 2j * zeta * ratio) / (1.0 - ratio**2 + 2j * zeta * ratio)


def written(path: Path, *columns: np.ndarray, head: str = "", separator: str = ",") -> Path:
    np.savetxt(path, np.column_stack(columns), delimiter=separator, header=head, comments="")
    return path


def test_tables_are_read_with_and_without_names_and_phase(tmp_path: Path) -> None:
    frequency, T = oscillator(100.0, 0.02)
    complex_file = written(tmp_path / "a.csv", frequency, T.real, T.imag, head="frequency_hz,re,im")
    plain = written(tmp_path / "b.txt", frequency[::-1], np.abs(T)[::-1], separator=" ")
    commented = written(tmp_path / "c.csv", frequency, np.abs(T), head="# measured; 0.5 g", separator=";")
    curves = load_curves([complex_file, plain, commented])
    assert list(curves) == ["a", "b", "c"]
    for curve in curves.values():
        read = resonance(curve)
        assert read.f_n == pytest.approx(100.0, rel=1e-3)
        assert read.zeta == pytest.approx(0.02, rel=0.01)
        assert read.peak == pytest.approx(np.abs(T).max(), rel=1e-3)


def test_differences_are_relative_to_the_first_curve(wroll: Callable[..., Result], tmp_path: Path) -> None:
    for name, f_n, zeta in (("low", 100.0, 0.02), ("high", 110.0, 0.01)):
        frequency, T = oscillator(f_n, zeta)
        written(tmp_path / f"{name}.csv", frequency, np.abs(T))
    lines = list(comparison_lines(load_curves([tmp_path / "low.csv", tmp_path / "high.csv"])))
    assert "(+10.0 %)" in lines[2]
    assert "(-50" in lines[2]
    assert "%)" not in lines[1]
    done = wroll("compare", "low.csv", "high.csv", "--out", "both.svg")
    assert done.exit_code == 0
    assert done.stdout.splitlines()[:3] == lines
    assert (tmp_path / "both.svg").is_file()


def test_a_folded_curve_of_harmonic_is_compared(wroll: Callable[..., Result], tmp_path: Path) -> None:
    """Its dimension is the point along the branch, and frequency a variable."""
    frequency, T = oscillator(100.0, 0.02)
    written(tmp_path / "measured.csv", frequency, np.abs(T))
    order = np.r_[0:60, 58, 59, 60 : len(frequency)]
    values = {"frequency": frequency, "transmissibility_real": T.real, "transmissibility_imag": T.imag}
    folded = xr.Dataset({name: ("branch_point", part[order]) for name, part in values.items()})
    folded.assign_attrs(f_n_hz=100.0, peak_transmissibility=25.0, zeta=0.02).to_netcdf(
        tmp_path / "folded.nc", engine="h5netcdf"
    )
    done = wroll("compare", "folded.nc", "measured.csv", "--out", "both.png")
    assert done.exit_code == 0
    assert (tmp_path / "both.png").is_file()


def test_what_is_no_curve_is_refused(tmp_path: Path) -> None:
    frequency, T = oscillator(100.0, 0.02)
    good = written(tmp_path / "good.csv", frequency, np.abs(T))
    (tmp_path / "words.csv").write_text("a,b\nc,d\ne,f\ng,h\n", encoding="utf-8")
    wide = written(tmp_path / "wide.csv", frequency, T.real, T.imag, np.abs(T))
    with pytest.raises(InputError, match="nothing to compare"):
        load_curves([good])
    with pytest.raises(InputError, match="given twice"):
        load_curves([good, good])
    for bad in (tmp_path / "words.csv", wide):
        with pytest.raises(InputError, match="not a table of two or three columns"):
            load_curves([good, bad])
    with pytest.raises(InputError, match="is not a run folder"):
        load_curves([good, tmp_path / "none"])
