"""Coils shorter than their mandrel: contact points, stepped beams, finer meshes, solvers that agree."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.paths import CONFIGS
from support.stepped_beam import stepped_beam

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.forecasts.closed_forms import beam_frequency
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.case.loader import build_case, load_case
from wroll_fem.mesh.generate import build_mesh, roll_stations, with_borders
from wroll_fem.progress import SilentProgress

LENGTH, DIAMETER, WALL, COIL = 1.2, 0.06, 1e-3, 1e-3
E, NU, RHO = 70e9, 0.33, 2700.0
LOW, HIGH = 0.2, 0.9
MARGINS = f"coil.margins={{base: {LOW}, tip: {LENGTH - HIGH}}}"


def roll(**coil: Any) -> dict[str, Any]:
    metal = {"E": E, "nu": NU, "rho": RHO}
    return {
        "analysis": "modal",
        "geometry": {"length": LENGTH, "mandrel_outer_diameter": DIAMETER, "mandrel_thickness": WALL},
        "mandrel": {"material": metal},
        "coil": {"model": "bonded", "total_thickness": COIL, "material": metal} | coil,
        "mesh": {"circumferential": 16, "axial": 12, "grading": 1},
        "modal": {"count": 6},
        "output": {"figures": False},
    }


def test_borders_lie_at_given_heights() -> None:
    even = np.linspace(0.0, 1.0, 6)
    np.testing.assert_allclose(with_borders(even, [0.21, 0.5, 0.6]), [0.0, 0.21, 0.4, 0.5, 0.6, 0.8, 1.0])
    np.testing.assert_allclose(with_borders(even, [0.21], keep=[even[1]]), [0.0, 0.2, 0.21, 0.4, 0.6, 0.8, 1.0])
    np.testing.assert_array_equal(with_borders(even, [0.0, 1.0]), even)
    np.testing.assert_allclose(with_borders(even, [0.05, 0.95]), [0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0])


@pytest.mark.parametrize(("axial", "grading"), [(12, 8.0), (7, 3.0), (5, 1.0)])
def test_the_ends_of_the_coil_are_borders_of_elements(axial: int, grading: float) -> None:
    data = roll(margins={"base": 0.1 * LENGTH / 3, "tip": 0.7 * LENGTH / 11})
    data["mesh"] = {"circumferential": 8, "axial": axial, "grading": grading}
    case = build_case(data)
    stations = roll_stations(case)
    inside = stations[(stations > case.coil_span[0] - 1e-12) & (stations < case.coil_span[1] + 1e-12)]
    assert len(inside) == axial + 1
    assert np.diff(stations).min() > 0.0
    assert len(build_system(case, build_bodies(case)).interfaces) == 1


def test_the_layers_cover_the_coil_and_match_the_mandrel() -> None:
    mesh = {"circumferential": 8, "axial": 6, "grading": 1}
    case = build_case(roll(layers=2, margins={"base": "200 mm", "tip": 0.3}) | {"mesh": mesh})
    assert case.coil_span == pytest.approx((LOW, HIGH))
    made = build_mesh(case)
    heights = {name: made.part(name).nodes[:, 2] for name in made.parts}
    assert (heights["mandrel"].min(), heights["mandrel"].max()) == pytest.approx((0.0, LENGTH))
    for name in ("layer_01", "layer_02"):
        assert (heights[name].min(), heights[name].max()) == pytest.approx((LOW, HIGH))
    assert {LOW, HIGH} <= {round(float(z), 12) for z in roll_stations(case)}
    bodies = build_bodies(case)
    for interface in build_system(case, bodies).interfaces:
        assert interface.areas.sum() == pytest.approx(2 * np.pi * (HIGH - LOW) * 0.03, rel=0.04)
        assert interface.points[:, 1].min() > LOW
        assert interface.points[:, 1].max() < HIGH
    total = sum(body.mass_total for body in bodies)
    radii = 0.03 - WALL / 2, 0.03 + COIL / 2
    thin = 2 * np.pi * RHO * (radii[0] * WALL * LENGTH + radii[1] * COIL * (HIGH - LOW))
    assert total == pytest.approx(thin, rel=0.01)


@pytest.mark.slow
def test_a_bonded_coil_with_margins_is_a_stepped_beam() -> None:
    data = run_analysis(build_case(roll(margins={"base": LOW, "tip": LENGTH - HIGH})), progress=SilentProgress())
    kinds, found = data["mode_kind"].values, data["mode_frequency"].values
    bending = [float(f) for f, kind in zip(found, kinds, strict=True) if kind == "bending"]
    expected = stepped_beam(
        LENGTH, lambda z: (0.03 - WALL + 0.0 * z, np.where((z > LOW) & (z < HIGH), 0.03 + COIL, 0.03)), E, NU, RHO
    )
    np.testing.assert_allclose([bending[0], bending[2]], expected, rtol=0.005)
    case = build_case(roll(margins={"base": LOW, "tip": LENGTH - HIGH}))
    assert beam_frequency(case, bonded=True) == pytest.approx(expected[0], rel=0.08)


LAB_MARGINS = "coil.margins={base: 0.04, tip: 0.06}"


@pytest.mark.slow
def test_friction_with_margins_hardly_changes_on_a_finer_mesh() -> None:
    """Lab roll with 40 and 60 mm without coil: resonance 0.1 %, peak 0.5 % of a mesh with twice the elements."""
    found = []
    for mesh in ("{circumferential: 16, axial: 8, grading: 4}", "{circumferential: 24, axial: 16, grading: 4}"):
        case = load_case(CONFIGS / "lab_harmonic.yaml", [LAB_MARGINS, f"mesh={mesh}", "output.figures=false"])
        found.append(summarise(run_analysis(case, progress=SilentProgress()), case))
    coarse, fine = found
    assert coarse["f_n_hz"] == pytest.approx(fine["f_n_hz"], rel=0.001)
    assert coarse["peak_transmissibility"] == pytest.approx(fine["peak_transmissibility"], rel=0.005)


def test_all_solver_methods_agree_with_margins() -> None:
    changes = [LAB_MARGINS, "mesh={circumferential: 8, axial: 2, grading: 1}", "output.figures=false",
               "excitation.cycles=2", "excitation.ramp_cycles=1", "integrator.steps_per_cycle=24"]  # fmt: skip
    tips = {}
    for method in ("full", "condensed", "reduced"):
        case = load_case(CONFIGS / "lab_dwell.yaml", [*changes, f"solver.method={method}"])
        tips[method] = run_analysis(case, progress=SilentProgress())["tip_displacement"].values
    scale = np.abs(tips["full"]).max()
    np.testing.assert_allclose(tips["condensed"], tips["full"], atol=1e-6 * scale)
    np.testing.assert_allclose(tips["reduced"], tips["full"], atol=0.02 * scale)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"coil": {"margins": {"base": 0.7, "tip": 0.5}}}, "leave no coil on a mandrel of 1.2 m"),
        ({"coil": {"margins": {"base": 0.1}, "base": "clamped"}}, "the coil begins above the base"),
        ({"coil": {"margins": {"base": 0.1}, "model": "solid"}}, "apply to shells, not to model: solid"),
        ({"probes": {"top": {"z": 1.1, "body": "layer_01"}}, "coil": {"margins": {"tip": 0.3}}}, "is outside the coil"),
    ],
)
def test_margins_that_contradict_the_case_are_refused(changes: dict[str, Any], words: str) -> None:
    data = roll(**changes.pop("coil")) | changes
    with pytest.raises(Exception) as caught:  # noqa: PT011
        build_case(data)
    assert words in str(caught.value)
