"""What each analysis leaves behind: the registry is complete, and results with less are drawn as far as they go."""

from __future__ import annotations

import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
import xarray as xr
from support import synthetic_roll
from support.empty_figures import empty_figures

from wroll_fem import analyses
from wroll_fem.analyses.registry import all_analyses, find_analysis
from wroll_fem.case import ANALYSES
from wroll_fem.case.analyses import MODULES
from wroll_fem.errors import InputError
from wroll_fem.results.dataset import FIELDS


@cache
def swept() -> xr.Dataset:
    return synthetic_roll.sweep()


def sweep() -> xr.Dataset:
    data = swept()
    return data.assign(pressure_modulation_work=0.0 * data["friction_energy"]).assign_attrs(analysis="sweep")


def drawn(data: xr.Dataset, folder: Path) -> set[str]:
    paths = analyses.write_figures(data, folder)
    assert {path.name for path in paths} == {path.name for path in folder.iterdir()}
    return {path.stem for path in paths}


def test_the_registry_has_every_analysis_of_the_case_file() -> None:
    assert set(MODULES) == set(ANALYSES)
    for name, analysis in zip(MODULES, all_analyses(), strict=True):
        assert analysis.name == name
        assert analysis.sentence.endswith(".")
        assert {variable for names in analysis.variables.values() for variable in names} <= set(FIELDS)
    with pytest.raises(InputError, match="unknown analysis 'decay'; use one of: sweep, "):
        find_analysis("decay")


def test_the_registry_is_cheap_to_import() -> None:
    code = "import sys, wroll_fem.analyses; assert not {'numpy', 'xarray', 'numba'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_results_are_drawn_and_written_as_far_as_they_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    no_angles = sweep().drop_vars("theta_rad")  # contact points of matrices from a file
    assert drawn(no_angles, tmp_path / "matrices") == {"transmissibility", "response", "energy_ledger"}
    empty_figures(monkeypatch)
    whole = drawn(sweep(), tmp_path / "whole")
    maps = {f"{kind}_0{k}" for kind in ("slip_map", "peak_slip") for k in (1, 2)}
    assert whole == {"transmissibility", "response", "energy_ledger", "slip_on_cylinder"} | maps
    unconverged = sweep().drop_vars(["transmissibility_real", "transmissibility_imag"])
    assert drawn(unconverged, tmp_path / "unconverged") == whole - {"transmissibility"}
    assert analyses.write_fields(no_angles, tmp_path / "fields") == []
    assert [path.name for path in analyses.write_fields(sweep(), tmp_path / "fields")] == ["slip.vtu"]


def test_a_roll_without_interfaces_has_a_summary_without_slip() -> None:
    of_interfaces = {
        "interface_pressure_mean_pa", "max_slip_m", "max_relative_displacement_m", "max_accumulated_slip_m",
        "slipping_area_fraction",
    }  # fmt: skip
    bare = sweep()
    bare = bare.drop_vars([name for name in bare.variables if "interface" in bare[name].dims])
    whole, less = (analyses.summarise(data) for data in (sweep(), bare))
    assert set(whole) - set(less) == of_interfaces
    assert less == {key: value for key, value in whole.items() if key not in of_interfaces}
    assert whole["max_slip_m"] == whole["max_relative_displacement_m"] > 0.0


def test_a_dataset_that_does_not_name_its_analysis_is_refused() -> None:
    with pytest.raises(InputError, match="does not name its analysis"):
        analyses.summarise(xr.Dataset())
