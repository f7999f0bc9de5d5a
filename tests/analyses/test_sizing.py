"""Sizing of a mandrel, from the case file to figures: walls, margins, places, buckling, warnings and refusals."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import g as GRAVITY
from support.paths import CONFIGS
from support.structures import wroll

import wroll_fem as wf
from wroll_fem.analyses.margins.mandrel_wall import READINGS, MandrelStress, tube_of, unreachable, wall_for_margin
from wroll_fem.bodies.stress import largest_von_mises
from wroll_fem.case import Case, load_case
from wroll_fem.errors import InputError, WrollError
from wroll_fem.fem.fourier_shell.mandrel import ClampedMandrel, graded_heights
from wroll_fem.fem.fourier_shell.model import FourierShellModel
from wroll_fem.plotting.margin import plot_margin
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import load_dataset, save_dataset

MISSIONS = ("sizing_irosa", "sizing_sspp", "sizing_habex")
SLENDER = {
    "length": 4.0, "mandrel_outer_diameter": 0.3, "coil_outer_diameter": 0.4, "coil_mass": 300.0,
    "acceleration_g": 10.0, "pressure": 2.0e5,
}  # fmt: skip


def run(case):
    progress = SilentProgress()
    data = wf.run(case, out=None, progress=progress)
    return data, wf.summarise(data), progress.warnings


@pytest.fixture(scope="module", params=[MISSIONS[1], *(pytest.param(m, marks=pytest.mark.slow) for m in MISSIONS[::2])])
def mission(request):
    case = load_case(CONFIGS / f"{request.param}.yaml", ["mesh.axial=40"])
    return case, *run(case)


def test_every_wall_has_the_wanted_margin(mission):
    case, _, summary, _ = mission
    stress = MandrelStress(case.sizing, case.mesh.axial)
    assert list(summary["wall_thickness_m"]) == list(READINGS)
    for reading, wall in summary["wall_thickness_m"].items():
        assert stress.margin(reading, wall) == pytest.approx(0.25, abs=1e-6), reading
        assert summary["peak_stress_pa"][reading] == pytest.approx(280e6 / (1.2 * 1.25), rel=1e-6)
    assert summary["design_wall_m"] == summary["wall_thickness_m"]["surface_away_from_ends"]


def test_readings_are_ordered(mission):
    """Faces have at least the stress of the middle; the whole tube that of its part; pressure adds on one side."""
    _, data, summary, _ = mission
    margin = {name: data["margin"].sel(reading=name).values for name in READINGS}
    for suffix in ("", "_without_pressure"):
        for place in ("", "_away_from_ends"):
            assert (margin["membrane" + place + suffix] >= margin["surface" + place + suffix] - 1e-12).all()
        for name in ("membrane", "surface"):
            away = margin[f"{name}_away_from_ends{suffix}"]
            assert (away >= margin[name + suffix] - 1e-12)[np.isfinite(away)].all()
    walls = summary["wall_thickness_m"]
    for name in READINGS[:4]:
        assert walls[f"{name}_without_pressure"] < walls[name]
        # with pressure, the largest stress is on the side in tension, where the hoop compression adds
        assert summary["peak_stress_theta_rad"][name] == pytest.approx(math.pi)
    assert summary["peak_stress_z_m"]["surface"] == 0.0
    zone = summary["end_zone_m"]
    assert summary["peak_stress_z_m"]["surface_away_from_ends"] == pytest.approx(zone, rel=0.05)


def test_margin_rises_with_the_wall(mission):
    """Up to the printed walls and twice beyond; a very thick tube carries mostly itself."""
    _, data, _, _ = mission
    thin = data["margin"].sel(mandrel_thickness=slice(None, 0.015))
    assert (np.diff(thin.values, axis=0) > 0.0).all()


def test_a_finer_mesh_changes_the_stress_by_less_than_two_per_cent(mission):
    """40 or 400 cells, each reading at its own wall."""
    case, _, summary, _ = mission
    finer = MandrelStress(case.sizing, 400)
    for name, wall in summary["wall_thickness_m"].items():
        assert finer.peaks(wall)[name].stress == pytest.approx(summary["peak_stress_pa"][name], rel=0.02), name


def test_ratios_and_masses_of_a_mission_are_those_of_the_definitions(mission):
    """Equations 6.2 to 6.5, and the tip stiffness of a beam that bends and shears: found 0.4 and 1.5 % less."""
    case, _, summary, _ = mission
    s, wall = case.sizing, summary["design_wall_m"]
    outer = 0.5 * s.mandrel_outer_diameter
    inner = outer - wall
    assert summary["aspect_ratio"] == pytest.approx(s.length / s.mandrel_outer_diameter)
    assert summary["diameter_ratio"] == pytest.approx(s.mandrel_outer_diameter / s.coil_outer_diameter)
    assert summary["thickness_ratio"] == pytest.approx(
        wall / (0.5 * (s.coil_outer_diameter - s.mandrel_outer_diameter))
    )
    mass = 2700.0 * math.pi * (outer**2 - inner**2) * s.length
    assert summary["mandrel_mass_kg"] == pytest.approx(mass)
    assert summary["mass_ratio"] == pytest.approx(mass / s.coil_mass)
    assert summary["end_cap_mass_kg"] == pytest.approx(2700.0 * math.pi * outer**2 * wall)
    inertia, area = math.pi / 4.0 * (outer**4 - inner**4), math.pi * (outer**2 - inner**2)
    kappa, shear_modulus = 2.0 * (1.0 + s.nu) / (4.0 + 3.0 * s.nu), 70e9 / (2.0 * (1.0 + s.nu))  # thin tube
    softness = s.length**3 / (3.0 * 70e9 * inertia) + s.length / (kappa * shear_modulus * area)
    assert summary["tip_stiffness_n_per_m"] == pytest.approx(1.0 / softness, rel=0.02)
    tube, cap = replace(tube_of(s, summary["design_wall_m"]), extra_mass=0.0), summary["end_cap_mass_kg"]
    axial = case.mesh.axial
    alone = ClampedMandrel(FourierShellModel(axial), tube, graded_heights(tube, axial), cap)
    disc = cap * outer**2 / 4.0  # about a diameter
    assert summary["mandrel_hz"] == pytest.approx(alone.bending_frequency(disc), rel=1e-9)
    assert summary["mandrel_with_coil_hz"] < summary["mandrel_hz"]
    assert summary["buckling_factor_combined"] <= min(
        summary["buckling_factor_pressure"], summary["buckling_factor_transverse"]
    )


@pytest.mark.slow
def test_ratios_and_stiffness_are_those_of_the_definitions():
    """Equations 6.2 to 6.5 and 3 E I / L^3 less the flexibility in shear, with the printed wall of iROSA."""
    _, summary, warnings = run(load_case(CONFIGS / "sizing_irosa.yaml", ["sizing.wall=2.5e-3"]))
    assert summary["aspect_ratio"] == 6.0
    assert summary["diameter_ratio"] == 0.625
    assert summary["thickness_ratio"] == pytest.approx(2.5e-3 / 0.15)
    mass = 2700.0 * math.pi * (0.25**2 - 0.2475**2) * 3.0
    assert summary["mandrel_mass_kg"] == pytest.approx(mass)
    assert summary["mass_ratio"] == pytest.approx(mass / 25.0)
    assert summary["end_cap_mass_kg"] == pytest.approx(2700.0 * math.pi * 0.25**2 * 2.5e-3)
    bending = 3.0 * 70e9 * math.pi / 4.0 * (0.25**4 - 0.2475**4) / 27.0
    assert 0.92 * bending < summary["tip_stiffness_n_per_m"] < bending
    assert summary["mandrel_with_coil_hz"] < summary["mandrel_hz"]
    assert "wall_thickness_m" not in summary
    assert summary["wall_margins"]["surface_away_from_ends"] < 0.25
    assert summary["buckling_waves"] == 3
    assert any("exceeds the buckling pressure" in text for text in warnings)
    assert summary["buckling_factor_combined"] <= min(
        summary["buckling_factor_pressure"], summary["buckling_factor_transverse"]
    )


def test_a_given_wall_that_buckles_is_told():
    short = SLENDER | {"length": 0.3, "wall": 4e-3, "pressure": 6.5e6}
    _, summary, warnings = run(Case.model_validate({"analysis": "sizing", "sizing": short, "mesh": {"axial": 20}}))
    assert "wall_thickness_m" not in summary
    assert summary["buckling_factor_pressure"] < 1.0
    assert any("exceeds the buckling pressure" in text for text in warnings)


def test_the_wall_away_from_the_ends_is_that_of_beam_and_membrane_theory():
    """A slender tube with a light end: von Mises stress of axial beam stress and hoop stress -p R_o / t, 1 %."""
    case = Case.model_validate({"analysis": "sizing", "sizing": SLENDER | {"wall": 4e-3}})
    stress = MandrelStress(case.sizing, case.mesh.axial)
    peak = stress.peaks(4e-3)["membrane_away_from_ends"]
    outer, inner, radius = 0.15, 0.146, 0.148
    per_length = 2700.0 * math.pi * (outer**2 - inner**2) + 75.0
    cap, arm = 2700.0 * math.pi * outer**2 * 4e-3, 4.0 - peak.z
    moment = 10.0 * GRAVITY * (per_length * arm**2 / 2.0 + cap * arm)
    axial, hoop = moment * radius / (math.pi / 4.0 * (outer**4 - inner**4)), -2e5 * outer / 4e-3
    assert peak.stress == pytest.approx(math.sqrt(axial**2 - axial * hoop + hoop**2), rel=0.01)


def test_the_largest_stress_on_a_circle_is_that_of_a_fine_sample():
    rng = np.random.default_rng(1)
    constant, cosine = rng.standard_normal((2, 3, 200))
    constant[2] = 0.0
    theta = np.linspace(0.0, np.pi, 2001)
    wave = np.stack([np.cos(theta), np.cos(theta), np.sin(theta)])
    s11, s22, s12 = constant[:, :, None] + cosine[:, :, None] * wave[:, None]
    expected = np.sqrt(s11**2 + s22**2 - s11 * s22 + 3.0 * s12**2).max(axis=1)
    found, angle = largest_von_mises(constant, cosine)
    np.testing.assert_allclose(found, expected, rtol=1e-5)
    assert ((angle >= 0.0) & (angle <= np.pi)).all()


# ---- search ----------------------------------------------------------------------------------------------------------


def test_the_search_takes_the_wall_above_which_the_margin_holds():
    walls = list(np.geomspace(1e-4, 1e-2, 21))
    assert wall_for_margin(lambda t: math.log(t / 1e-3), walls, 0.0) == pytest.approx(1e-3, rel=1e-8)
    falls = wall_for_margin(lambda t: 1.0 - math.log(t / 2e-3) ** 2, walls, 0.0)  # rises, then falls
    assert falls == pytest.approx(2e-3 / math.e, rel=1e-8)
    assert wall_for_margin(lambda t: 1.0, walls, 0.0) is None
    assert wall_for_margin(lambda t: -1.0, walls, 0.0) is None
    assert wall_for_margin(lambda t: math.nan, walls, 0.0) is None
    assert "far enough" in unreachable({1e-3: math.nan}, 0.25)


def test_a_margin_out_of_reach_is_refused_with_both_ends_of_the_search(tmp_path):
    path = tmp_path / "case.yaml"
    text = (CONFIGS / "sizing_irosa.yaml").read_text(encoding="utf-8").replace("margin: 0.25", "margin: 5")
    text += "mesh: {axial: 60}\n"
    path.write_text(text, encoding="utf-8")
    refused = wroll("run", path, "--out", tmp_path / "out")
    assert refused.exit_code == 2
    shown = [line for line in refused.stderr.splitlines() if "sizing.margin" in line]
    assert len(shown) == 1
    assert "case.yaml" in shown[0]
    assert "no wall has the margin 5: it is -0.918 at 0.1 mm and 1.27 at 50 mm" in shown[0]
    assert "sizing.wall" in shown[0]


@pytest.mark.slow
def test_a_reading_without_wall_is_null_beside_the_others():
    """At a margin of 50 % the clamped edge of iROSA has no wall, the tube away from it has."""
    _, summary, warnings = run(load_case(CONFIGS / "sizing_irosa.yaml", ["sizing.margin=0.5", "mesh.axial=60"]))
    assert summary["wall_thickness_m"]["surface"] is None
    assert summary["peak_stress_surface"]["surface"] is None
    assert summary["wall_thickness_m"]["surface_away_from_ends"] > 2.5e-3
    assert any(text.startswith("sizing: surface: no wall has the margin 0.5") for text in warnings)


def test_a_heavy_end_cap_and_a_thick_wall_are_named():
    squat = SLENDER | {"length": 0.04, "coil_mass": 0.0, "acceleration_g": 1e4, "wall": 0.03}
    data = {"analysis": "sizing", "sizing": squat, "mesh": {"axial": 20}}
    _, summary, warnings = run(Case.model_validate(data))
    assert summary["mass_ratio"] is None
    assert any("is heavier than mandrel and coil" in text for text in warnings)
    assert any("exceeds 0.1 of its radius" in text for text in warnings)
    assert summary["wall_margins"]["surface_away_from_ends"] is None  # the end zones meet


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"coil_outer_diameter": 0.2}, "sizing.coil_outer_diameter: must exceed mandrel_outer_diameter = 0.3 m"),
        ({"wall": 0.05}, "sizing.wall: is too thick for a shell"),
        ({"length": -1.0}, "sizing.length: must be greater than 0, got -1.0"),
        ({"readng": "surface"}, "sizing.readng: unknown key"),
        ({"nu": 0.5}, "sizing.nu"),
    ],
)  # fmt: skip
def test_wrong_sections_are_refused_in_one_line(changes, message):
    with pytest.raises(InputError) as caught:
        Case.model_validate({"analysis": "sizing", "sizing": SLENDER | changes})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_sections_of_a_roll_are_refused():
    with pytest.raises(InputError, match="analysis sizing does not use it"):
        Case.model_validate({"analysis": "sizing", "sizing": SLENDER, "geometry": {"length": 1.0}})
    with pytest.raises(InputError, match="sizing"):
        load_case(CONFIGS / "lab_modal.yaml", ["sizing.length=3"])


@pytest.mark.parametrize("number", [0, 1, 2, pytest.param(3, marks=pytest.mark.slow), 4, 5])
def test_random_sections_end_or_are_told_why(number):
    rng = np.random.default_rng([20241124, number])
    diameter = 10 ** rng.uniform(-2, 0.7)
    section = {
        "length": diameter * 10 ** rng.uniform(-0.3, 1.3), "mandrel_outer_diameter": diameter,
        "coil_outer_diameter": diameter * (1.0 + 10 ** rng.uniform(-2, 1)), "coil_mass": 10 ** rng.uniform(-2, 4),
        "acceleration_g": 10 ** rng.uniform(-1, 3), "pressure": float(rng.choice([0.0, 10 ** rng.uniform(2, 7)])),
        "margin": rng.uniform(-0.3, 2.0), "yield_stress": 10 ** rng.uniform(7, 9.2), "nu": rng.uniform(0.0, 0.49),
    }  # fmt: skip
    refused = ""
    try:
        _, summary, _ = run(Case.model_validate({"analysis": "sizing", "sizing": section, "mesh": {"axial": 20}}))
    except WrollError as error:
        refused = str(error)
    if refused:
        assert "sizing.margin" in refused
        assert "\n" not in refused
        return
    assert summary["design_wall_m"] > 0.0
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary


# ---- figure ----------------------------------------------------------------------------------------------------------


def test_the_figure_has_one_curve_per_reading_and_survives_the_file(mission, tmp_path):
    _, data, summary, _ = mission
    again = load_dataset(save_dataset(data, tmp_path / "results.nc"))
    ax = plot_margin(again)
    assert len([line for line in ax.lines if len(line.get_xdata()) == data.sizes["mandrel_thickness"]]) == len(READINGS)
    assert f"{1e3 * summary['design_wall_m']:.3g} mm" in ax.get_title(loc="left").replace("\N{NO-BREAK SPACE}", " ")
    assert ax.get_xlabel() == "Wall of the mandrel (mm)"
    assert ax.get_ylabel() == "Margin against yield (%)"
