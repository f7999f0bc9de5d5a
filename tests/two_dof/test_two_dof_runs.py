"""Analysis two_dof from case file to run folder: results, summary, figures, invalid inputs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.paths import CONFIGS

from wroll_fem.analyses import estimate, run_analysis
from wroll_fem.case import load_case
from wroll_fem.errors import InputError
from wroll_fem.jobs.run import run_case
from wroll_fem.plotting.two_dof import plot_two_dof, plot_two_dof_arrangements
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import load_dataset

CONFIG = CONFIGS / "two_dof.yaml"
SMALL = ("two_dof.friction_capacity=[2, 5, 20]", "two_dof.omega.points=24")
FEW = ("two_dof.friction_capacity=[2, 3]", "two_dof.omega.points=10")
SPACE = (
    "two_dof.design_space={m2: {start: 0.5, stop: 1.0, points: 2}, k2: {start: 0.8, stop: 1.6, points: 2}, points: 24}"
)


def test_the_config_holds_table_5_2() -> None:
    case = load_case(CONFIG)
    section = case.two_dof
    assert section is not None
    values = (section.m1, section.k1, section.c1, section.m2, section.k2, section.c2, section.Y0, section.smoothing)
    assert values == (1.0, 1.0, 0.002, 0.85, 1.15, 0.0025, 1.5, 1.0)
    assert (section.omega.values[0], section.omega.values[-1], len(section.omega.values)) == (0.4, 2.0, 400)
    assert set(case.resolved()) == {"analysis", "two_dof", "output"}
    assert estimate(case)["motions"] == 3200


def test_a_run_leaves_curves_readings_and_figures(tmp_path: Path) -> None:
    run = run_case(load_case(CONFIG, (*SMALL, SPACE)), tmp_path / "run")
    data, summary = load_dataset(run.folder.results_file), run.summary
    assert data["transmissibility"].dims == ("friction_capacity", "omega")
    assert data["transmissibility"].shape == (3, 24)
    assert {"zeta", "omega_peak"} <= set(data)
    assert data["friction_capacity"].attrs["units"] == "N"
    assert data["omega"].attrs["units"] == "rad s-1"
    work = sum(data[name] for name in ("viscous_work_primary", "viscous_work_secondary", "friction_work_per_cycle"))
    np.testing.assert_allclose(work, data["input_work_per_cycle"], rtol=1e-6)
    assert summary["energy_balance_error"] < 1e-6
    assert summary["friction_capacity_lowest_peak_n"] == 2.0
    assert summary["peak_transmissibility"] == pytest.approx([9.689, 25.52, 99.17], rel=1e-3)  # to 4 digits elsewhere
    np.testing.assert_array_equal(summary["zeta"], data["zeta"].values)
    # the refined peak is above the grid's
    assert (data["peak_transmissibility"] >= data["transmissibility"].max("omega")).all()
    assert data["zeta_max"].dims == ("m2", "k2")
    assert (data["zeta_max"] == data["zeta_over_design"].max("friction_capacity")).all()
    assert summary["zeta_max_over_design"] == float(data["zeta_max"].max())
    names = {path.stem for path in run.figures}
    assert names == {"two_dof", "two_dof_readings", "two_dof_design_space"}


def test_curves_cut_off_are_said_to_be_unreadable(tmp_path: Path) -> None:
    case = load_case(CONFIG, ("two_dof.friction_capacity=[2]", "two_dof.omega={start: 0.4, stop: 0.8, points: 12}"))
    run = run_case(case, tmp_path / "cut")
    data = load_dataset(run.folder.results_file)
    assert np.isnan(data["zeta"].values).all()
    assert "lies on the upper end of the band (0.8 rad/s)" in str(data["reading_note"].values[0])
    assert run.summary["zeta"] == [None]


def test_figures_show_every_capacity_and_arrangement() -> None:
    data = {
        name: run_analysis(
            load_case(CONFIG, (*FEW, f"two_dof.arrangement={name}")), progress=SilentProgress()
        )
        for name in ("both_on_base", "secondary_isolated", "secondary_on_primary")
    }  # fmt: skip
    ax = plot_two_dof(data["both_on_base"])
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts == ["2 N", "3 N"]
    tops = [line.get_ydata().max() for line in ax.get_lines() if len(line.get_ydata()) > 1]
    np.testing.assert_allclose(tops, data["both_on_base"]["peak_transmissibility"])
    assert plot_two_dof_arrangements(data).get_title(loc="left") == "both_on_base"
    with pytest.raises(InputError, match="response of the two masses needs transmissibility"):
        plot_two_dof(data["both_on_base"].drop_vars("transmissibility"))


@pytest.mark.parametrize(
    ("override", "expected"),
    [
        ("two_dof.friction_capacity=[2, 1]", "friction_capacity: must be positive and ascending, got [2, 1]"),
        ("two_dof.friction_capacity=[]", "friction_capacity: must be a list of forces, got []; write forces in N"),
        ("two_dof.friction_capacity=rough", "friction_capacity: must be a number, got 'rough'"),
        ("two_dof.omega.stop=0.3", "two_dof.omega.stop: must be above start = 0.4, got 0.3"),
        ("two_dof.omega.points=4", "two_dof.omega.points: too few frequencies for a curve, got 4; use 5"),
        ("two_dof.c2=0", "two_dof.c2: must be greater than 0, got 0; give the dashpot of the secondary"),
        ("two_dof.arrangement=d", "two_dof.arrangement: is not one of the choices, got 'd'; use both_on_base"),
        ("two_dof.smooting=1", "two_dof.smooting: unknown key, got 1; did you mean smoothing?"),
        (
            "two_dof=null",
            "two_dof: required section is missing; add it (two masses coupled by friction, in place of a roll), for",
        ),
        ("mesh.axial=8", "mesh: analysis two_dof does not use it; leave mesh out"),
        ("analysis=modal", "required section is missing; add it (tube of the mandrel"),
    ],
)
def test_wrong_input_is_one_line(override: str, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        load_case(CONFIG, (override,))
    text = str(caught.value)
    assert expected in text
    assert "\n" not in text


def test_a_roll_has_no_two_masses() -> None:
    with pytest.raises(InputError, match="two_dof: analysis sweep has no two masses; leave it out"):
        load_case(
            CONFIG.with_name("lab_sweep.yaml"),
            ("two_dof={friction_capacity: [1], omega: {start: 0.4, stop: 2, points: 9}}",),
        )
