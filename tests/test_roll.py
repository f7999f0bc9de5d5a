"""`wf.Roll`: the same cases as the case files, typed, and results with their figures."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.errors import InputError

LAB = wf.Roll(
    geometry=wf.Geometry(length=0.300, mandrel_outer_diameter=0.080, mandrel_thickness=1.5e-3),
    mandrel=wf.Mandrel(
        material=wf.IsotropicMaterial(E=2.7e9, nu=0.35, rho=1200), tip_mass=0.05, tip="rigid", base="clamped"
    ),
    coil=wf.Coil(
        model="layers", layers=1, total_thickness=1.25e-3, base="free",
        material=wf.IsotropicMaterial(E=2.8e9, nu=0.35, rho=2000),
    ),
    contact=wf.Contact(
        friction=wf.PenaltyFriction(mu=0.25, elastic_slip=1.0e-6),
        normal=wf.Normal(penalty="auto", separation=True),
    ),
    preload=wf.Preload(kind="external_pressure", pressure=1.0e5),
)  # fmt: skip
"""The roll of configs/lab_sweep.yaml."""

GRADED = LAB.replace(mesh=wf.Mesh(circumferential=24, axial=16, grading=40))
COARSE = LAB.replace(mesh=wf.Mesh(circumferential=8, axial=3))


def test_a_sweep_is_the_case_of_the_file() -> None:
    case = GRADED.case(
        "sweep",
        excitation=wf.Chirp(amplitude=5.0, f_start=125, f_end=175, rate_oct_per_min=2, ramp_cycles=20, direction="x"),
        integrator=wf.Integrator(scheme="hht", alpha=-0.05, steps_per_cycle=40),
        solver=wf.Solver(method="reduced"),
        output=wf.Output(fields="slip_map", figures=True),
    )
    written = wf.load_case(CONFIGS / "lab_sweep.yaml")
    assert case.resolved() == written.resolved()
    assert case.hash() == written.hash()


@pytest.mark.parametrize("name", ["lab_dwell", "lab_backbone", "lab_modal", "winding_sweep", "case_study"])
def test_a_roll_comes_back_from_its_case(name: str) -> None:
    case = wf.load_case(CONFIGS / f"{name}.yaml")
    roll = wf.Roll.from_case(case)
    own = ("geometry", "mandrel", "coil", "contact", "preload", "winding", "mesh", "analysis")
    rest = {key: getattr(case, key) for key in case.model_fields_set if key not in own}
    again = roll.case(case.analysis, **rest)
    assert again.hash() == case.hash()


def test_a_case_without_a_roll_is_refused() -> None:
    with pytest.raises(InputError, match="does not describe a roll"):
        wf.Roll.from_case(wf.load_case(CONFIGS / "two_dof.yaml"))


def test_a_wrong_section_is_named() -> None:
    with pytest.raises(InputError, match="excitation"):
        LAB.case("sweep")
    with pytest.raises(InputError, match=r"analysis sweep needs a chirp"):
        LAB.case("sweep", excitation=wf.Dwell(amplitude=1.0, frequency=150.0, cycles=5.0))


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
def test_a_dwell_runs_and_shows_its_result(tmp_path: Path) -> None:
    dwell = wf.Dwell(amplitude=20.0, frequency=150.0, cycles=3.0, ramp_cycles=1.0)
    result = COARSE.run_dwell(dwell, solver=wf.Solver(method="condensed"), out=tmp_path / "dwell", progress=False)
    plain = wf.run(COARSE.case("dwell", excitation=dwell, solver={"method": "condensed"}), progress=False)
    assert result.summary["friction_energy_j"] == wf.summarise(plain)["friction_energy_j"] > 0.0
    assert result.case == COARSE.case("dwell", excitation=dwell, solver={"method": "condensed"})
    assert result.zeta is None
    assert repr(result).startswith("<Result of dwell")
    for ax in (result.plot_response(), result.plot_energy_ledger(), result.plot_slip_map()):
        assert ax.get_xlabel()
    _, own = plt.subplots()
    assert result.plot_response(own) is own
    plt.close("all")
    again = wf.Result.load(result.save(tmp_path / "dwell.nc"))
    assert again.data.identical(wf.load_result(tmp_path / "dwell.nc"))
    np.testing.assert_array_equal(
        again.data["tip_acceleration"], wf.Result.load(tmp_path / "dwell").data["tip_acceleration"]
    )
    with pytest.raises(InputError, match="transmissibility"):
        _ = result.transmissibility


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
def test_modes_and_preload_run_by_their_methods() -> None:
    modes = COARSE.run_modal(wf.Modal(count=4), progress=False)
    assert modes.summary["modes_hz"][0] > 100.0
    assert modes.plot_modes().get_xlabel()
    plt.close("all")
    preload = COARSE.run_preload(progress=False)
    assert 0.3e5 < preload.summary["interface_pressure_mean_pa"][0] < 1.0e5
