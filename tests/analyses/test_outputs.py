"""What each analysis leaves behind: the table is complete, and results with less are drawn as far as they go."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from support import synthetic_roll
from support.paths import CONFIGS

from wroll_fem import analyses, load_case
from wroll_fem.analyses.outputs import OUTPUTS
from wroll_fem.case.case import ANALYSES

SWEEP = load_case(CONFIGS / "lab_sweep.yaml")


def sweep() -> xr.Dataset:
    data = synthetic_roll.sweep()
    return data.assign(pressure_modulation_work=0.0 * data["friction_energy"])


def drawn(data: xr.Dataset, folder: Path) -> set[str]:
    paths = analyses.write_figures(data, SWEEP, folder)
    assert {path.name for path in paths} == {path.name for path in folder.iterdir()}
    return {path.stem for path in paths}


def test_every_analysis_has_a_function_and_outputs() -> None:
    assert set(OUTPUTS) == set(analyses.ANALYSES) == set(ANALYSES)


def test_results_are_drawn_and_written_as_far_as_they_go(tmp_path: Path) -> None:
    whole = drawn(sweep(), tmp_path / "whole")
    maps = {f"{kind}_0{k}" for kind in ("slip_map", "peak_slip") for k in (1, 2)}
    assert whole == {"transmissibility", "response", "energy_ledger", "slip_on_cylinder"} | maps
    unconverged = sweep().drop_vars(["transmissibility_real", "transmissibility_imag"])
    assert drawn(unconverged, tmp_path / "unconverged") == whole - {"transmissibility"}
    no_angles = sweep().drop_vars("theta_rad")  # contact points of matrices from a file
    assert drawn(no_angles, tmp_path / "matrices") == {"transmissibility", "response", "energy_ledger"}
    assert analyses.write_fields(no_angles, SWEEP, tmp_path / "fields") == []
    assert [path.name for path in analyses.write_fields(sweep(), SWEEP, tmp_path / "fields")] == ["slip.vtu"]


def test_a_roll_without_interfaces_has_a_summary_without_slip() -> None:
    of_interfaces = {"interface_pressure_mean_pa", "max_slip_m", "slipping_area_fraction"}
    bare = sweep()
    bare = bare.drop_vars([name for name in bare.variables if "interface" in bare[name].dims])
    whole, less = (analyses.summarise(data, SWEEP) for data in (sweep(), bare))
    assert set(whole) - set(less) == of_interfaces
    assert less == {key: value for key, value in whole.items() if key not in of_interfaces}
