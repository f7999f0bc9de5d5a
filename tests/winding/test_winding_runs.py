"""Winding from case file to run folder: invalid inputs, results, preload of the layers."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.paths import CONFIGS
from typer.testing import CliRunner

from wroll_fem import Case, cli, load_case
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.analyses.winding import doubts
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.statics.pressure_matching import match_interface_pressure, mean_pressures
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.jobs.grid import load_grid
from wroll_fem.jobs.run import run_case
from wroll_fem.plotting.series import FIGURES
from wroll_fem.plotting.study import StudyCase
from wroll_fem.plotting.style import save_figure
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import load_dataset
from wroll_fem.typing import FloatArray
from wroll_fem.winding import wound_roll
from wroll_fem.winding.interface import external_pressures, ring_split, target_pressures

STUDY, LAB, SWEEP = (CONFIGS / f"winding_{name}.yaml" for name in ("case_study", "lab", "sweep"))
SMALL = ["analysis=preload", "mesh.circumferential=8", "mesh.axial=2", "mesh.grading=1"]


# ---- inputs --------------------------------------------------------------------------------------


def test_the_case_study_holds_the_values_of_tables_2_1_to_2_3() -> None:
    """Claims C10, C11: 20 + 2 x 300 x 0.05 = 50 mm; 40 MPa and mu = 0.48."""
    winding = load_case(STUDY).winding
    assert winding is not None
    assert winding.mandrel is not None
    assert (winding.stress, winding.mu, winding.wraps, winding.wrap_thickness) == (40.0e6, 0.48, 300, 5.0e-5)
    assert (winding.web.E_theta, winding.mandrel.E) == (10.0e9, 70.0e9)
    assert 2 * (winding.mandrel.outer_radius + winding.build_up) == pytest.approx(0.050, rel=1e-12)
    assert 2 * wound_roll(winding).radius[-1] == pytest.approx(0.050, rel=1e-12)


@pytest.mark.parametrize(
    ("file", "override", "expected"),
    [
        (STUDY, "winding.tension_stress=-40e6", "tension_stress: must be greater than 0, got -40000000.0; give"),
        (LAB, "winding.tension_newton=-20", "winding.tension_newton: must be greater than 0, got -20; give the tensio"),
        (STUDY, "winding.tension_newton=20", "winding.tension_newton: cannot be combined with tension_stress, "
        "got 20.0; give"),
        (STUDY, "winding.tension_stress=null", "winding.tension_stress: the tension is missing; give tension_stress i"),
        (LAB, "winding.web_width=null", "winding.web_width: tension_newton needs the width; add it (width of the web"),
        (STUDY, "winding.web.radial_modulus.K2=40e9", "must be dimensionless, not a modulus in Pa, got 40000000000.0"),
        (STUDY, "winding.web.radial_modulus.K2=40 GPa", "K2: K2 must be a number without a unit, got '40 GPa'; give"),
        (STUDY, "winding.web.radial_modulus.K2=-3", "K2: must be greater than 0, got -3"),
        (STUDY, "winding.web.radial_modulus={K1: 1}", "radial_modulus.law: required key is missing; add law: constant"),
        (STUDY, "winding.web.radial_modulus={law: steel}", "radial_modulus.law: is not one of the choices, got 'steel"),
        (
            STUDY,
            "winding.web.radial_modulus={law: table, pressure: [0, 2, 1], modulus: [1, 2, 3]}",
            "radial_modulus.pressure: must rise from row to row, got [0.0, 2.0, 1.0]; sort the rows",
        ),
        (
            STUDY,
            "winding.web.radial_modulus={law: table, pressure: [0, 1], modulus: [1]}",
            "radial_modulus.modulus: 1 values for 2 values of pressure, got [1.0]; give one value per pressure",
        ),
        (
            STUDY,
            "winding.web.radial_modulus={law: table, pressure: [0, .nan], modulus: [1, 2]}",
            "radial_modulus.pressure.1: must be a finite number, got nan; give the pressure between the wraps, Pa, ri",
        ),
        (
            STUDY,
            "winding.tension_profile={kind: table, radius: [], factor: [1]}",
            "tension_profile.radius: must have 1 or more entries, got []; give the radius at which a wrap is laid, m, ",
        ),
        (STUDY, "winding.wrap_thickness=0.02", "wrap_thickness: must be less than the mandrel radius, got"),
        (STUDY, "winding.mandrel.wall=0.02", "winding.mandrel.wall: the wall is thicker than the radius, got 0.02; us"),
        (STUDY, "winding.mandrel.stiffness=1e9", "winding.mandrel.wall: cannot be combined with stiffness, "
        "which replaces it"),
        (STUDY, "winding.mandrel={outer_radius: 0.01}", "winding.mandrel.wall: required key is missing; add it (wall"),
        (STUDY, "winding.mandrel=null", "winding.mandrel: required section is missing; add it (outer_radius with wall"),
        (STUDY, "winding.mu=null", "winding.mu: required key is missing; add it (coefficient of friction between wrap"),
        (STUDY, "winding=null", "winding: required section is missing; add it (winding of the roll"),
        (STUDY, "winding.tension_profile={kind: taper, taper: 1.0}", "tension_profile.taper: must be less than 1, got"),
        (SWEEP, "winding=null", "preload.kind: winding_tension needs it"),
        (SWEEP, "winding.wrap_thickness=2e-3", "wrap_thickness: the web is thicker than the coil, got 0.002; use coil"),
        (SWEEP, "winding.wraps=30", "winding.wraps: 30 wraps of 5e-05 m are 0.0015 m thick, the coil is 0.00125 m, go"),
        (SWEEP, "winding.web_width=0.5", "winding.web_width: the web is wider than the roll is long, got 0.5; use geo"),
        (
            SWEEP,
            "winding.mandrel={outer_radius: 0.05, wall: 1.5e-3, E: 2.7e9}",
            "winding.mandrel.outer_radius: differs from geometry.mandrel_outer_diameter / 2 = 0.04 m, got 0.05; use 0.",
        ),
        (SWEEP, "preload.pressure=1e5", "preload.pressure: must be left out with kind: winding_tension, which "
        "computes the pressure, got 1000"),
        (SWEEP, "preload.kind=external_pressure", "preload.pressure: required key is missing; add it (external pressu"),
    ],
)  # fmt: skip
def test_wrong_input_gets_one_line(file: Path, override: str, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        load_case(file, [override])
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_pull_that_rises_outwards_would_take_a_layer_off() -> None:
    steep = "winding.tension_profile={kind: table, radius: [0.0400, 0.0401, 0.0410], factor: [0.001, 0.001, 30]}"
    case = load_case(SWEEP, ["coil.layers=5", "mandrel.material.E=1e6", steep, "winding.tension_newton=1"])
    assert np.linalg.solve(ring_split(case), target_pressures(case.wound, case.coil.layers)).min() < 0
    with pytest.raises(InputError, match="a layer needs a negative external pressure"):
        external_pressures(case, case.preload, case.wound)


# ---- runs ----------------------------------------------------------------------------------------


def test_a_run_leaves_the_contract_s_names(tmp_path: Path) -> None:
    done = run_case(load_case(STUDY), tmp_path / "run")
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["pressure_mandrel_pa"] == pytest.approx(6.288e6, rel=1e-3)
    assert summary["pressure_mandrel_wrap_grid_pa"] == pytest.approx(6.154e6, rel=1e-3)
    assert summary["capacity_mandrel_pa"] == pytest.approx(0.48 * summary["pressure_mandrel_pa"], rel=1e-12)
    assert summary["mandrel_stiffness_pa"] == pytest.approx(7.6117e9, rel=1e-4)
    data = load_dataset(tmp_path / "run" / "results.nc")
    for name in ("pressure_pa", "capacity_pa", "hoop_stress_pa"):
        assert data[name].dims == ("r",)
        assert data[name].attrs["units"] == "Pa"
    assert data["r"].attrs["units"] == "m"
    assert [path.name for path in done.figures] == ["winding.png"]
    assert load_case(tmp_path / "run" / "case.yaml") == load_case(STUDY)


def test_warnings_of_a_doubtful_roll(tmp_path: Path) -> None:
    runner = CliRunner()
    table = "winding.web.radial_modulus={law: table, pressure: [0, 1.0e4], modulus: [1.0e6, 2.0e11]}"
    said = runner.invoke(cli.app, ["run", str(STUDY), "--set", table, "--out", str(tmp_path / "a")])
    assert said.exit_code == 0
    for part in ("exceeds the last row", "exceeds the modulus along the web"):
        assert part in said.output
    coarse = load_case(STUDY, ["winding.cells=50", "winding.growth=continuous"]).winding
    assert coarse is not None
    (text,) = doubts(coarse, wound_roll(coarse))
    assert "still changes by" in text
    short = load_case(STUDY, ["winding.tension_profile={kind: table, radius: [10, 25], factor: [1, 2]}"]).winding
    assert short is not None
    (text,) = doubts(short, wound_roll(short))
    assert "covers 10 to 25 m, the roll 0.01 to 0.025 m; beyond the table its end values apply" in text
    for command in ("mesh", "export"):
        said = runner.invoke(cli.app, [command, str(STUDY), "--out", str(tmp_path / "b.npz")])
        assert said.exit_code == 2
        assert "analysis winding has no mesh and no matrices" in said.output
    assert "wraps" in runner.invoke(cli.app, ["run", str(STUDY), "--dry-run"]).output


@pytest.mark.parametrize("study", ["winding_tension", "winding_hardness"])
def test_figures_of_the_studies(study: str, tmp_path: Path) -> None:
    from wroll_fem.analyses import run_analysis

    grid = load_grid(CONFIGS / "studies" / f"{study}.yaml")
    members = [StudyCase(m.name, m.values, run_analysis(m.case, progress=SilentProgress())) for m in grid.members]
    for name in grid.figures:
        ax = FIGURES[name](members)
        assert len(ax.get_lines()) >= 2
        assert save_figure(ax, tmp_path / f"{name}.png").stat().st_size > 10_000
    if study == "winding_tension":  # claim C61
        for member in members:
            attrs = member.data.attrs
            assert 10e3 < attrs["pressure_mandrel_pa"] < attrs["hoop_bound_pa"] < 300e3


# ---- preload of the layers -----------------------------------------------------------------------


def small(*overrides: str) -> Case:
    return load_case(SWEEP, [*SMALL, *overrides])


def test_kept_pressures_follow_every_change_of_the_section() -> None:
    section = load_case(LAB).winding
    assert section is not None
    assert section.mandrel is not None
    firm = section.mandrel.model_copy(update={"outer_radius": 0.05})
    other = [section.model_copy(update=change) for change in ({"wraps": 20}, {"mandrel": firm})]
    rolls = [wound_roll(one) for one in (section, *other)]
    for one, roll in zip((section, *other, section), (*rolls, rolls[0]), strict=True):
        radii = one.core.outer_radius + np.arange(2) / 2 * one.build_up
        np.testing.assert_array_equal(target_pressures(one, 2), roll.pressure_at(radii))


@pytest.mark.parametrize("layers", [1, 3])
def test_the_mean_pressure_of_every_interface_is_the_wound_roll_s(layers: int) -> None:
    case = small(f"coil.layers={layers}")
    system, state = prepare(case, SilentProgress())
    radii = 0.040 + 1.25e-3 * np.arange(layers) / layers
    section = load_case(LAB).winding
    assert section is not None
    wanted = wound_roll(section.model_copy(update={"tension_newton": 60.0})).pressure_at(radii)
    np.testing.assert_allclose(mean_pressures(system, state), wanted, rtol=1e-3)
    # the same roll pressed from outside with the pressures found is the same state
    outside = small(
        f"coil.layers={layers}", "preload.kind=external_pressure", f"preload.pressure={list(system.pressures)}"
    )
    other, again = prepare(outside, SilentProgress())
    np.testing.assert_allclose(again.pressure, state.pressure, rtol=1e-9)
    assert other.pressures == pytest.approx(system.pressures)


def test_a_pull_that_only_the_whole_roll_shows_is_refused_too() -> None:
    rising = "winding.tension_profile={kind: table, radius: [0.0400, 0.0405, 0.0411], factor: [0.2, 0.2, 0.34]}"
    case = small("coil.layers=5", "winding.tension_newton=5", rising)
    assert min(external_pressures(case, case.preload, case.wound)) > 0.0  # thin rings alone would do
    with pytest.raises(InputError, match="a layer needs a negative external pressure"):
        prepare(case, SilentProgress())


def test_layer_pull_of_the_preload_is_near_the_pull_of_the_wraps() -> None:
    """A layer under pretension N presses with N/R: what has to be applied is the web's own pull, to some per cent."""
    case = small()
    system, _ = prepare(case, SilentProgress())
    bound = 60.0 / 0.300 * np.sum(1.0 / (0.040 + (np.arange(25) + 0.5) * 5.0e-5))
    assert system.pressures[0] == pytest.approx(bound, rel=0.1)


def test_summary_tells_target_and_external_pressure(tmp_path: Path) -> None:
    run_case(small("output.figures=false", "output.fields=none"), tmp_path)
    summary: dict[str, Any] = json.loads((tmp_path / "summary.json").read_text())
    assert summary["interface_pressure_mean_pa"] == pytest.approx(summary["winding_pressure_pa"], rel=1e-3)
    assert summary["external_pressure_pa"][0] > summary["winding_pressure_pa"][0]


def test_pressing_gives_up_with_its_history() -> None:
    """A target that no external pressure reaches: the interface of a system that carries nothing."""
    case = small()
    system, _ = prepare(case, SilentProgress())
    load: FloatArray = system.loads["preload"][None] / system.pressures[0]
    with pytest.raises(ConvergenceError, match="no external pressures give the interfaces") as caught:
        match_interface_pressure(system, load, np.array([7.0e4]), np.array([[1.0e3]]), steps=2, max_iterations=1)
    assert len(caught.value.residual_history) == 1
    pressed = match_interface_pressure(system, load, np.array([7.0e4]), np.array([[0.9]]), steps=10)
    state = solve_preload(replace(pressed), steps=10)
    assert mean_pressures(pressed, state)[0] == pytest.approx(7.0e4, rel=1e-3)
