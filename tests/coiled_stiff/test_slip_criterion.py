"""Slip criterion of a solid coil on synthetic modes: stress over a cycle, onset, slip zone, outputs of a run."""

from __future__ import annotations

from dataclasses import replace

import matplotlib.pyplot as plt
import meshio
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.image import imread
from scipy.constants import g as GRAVITY
from support.coil_modes import MASS, SHAPE, beam, coil_points

from wroll_fem.analyses import modal_transient, slip_model
from wroll_fem.analyses.modal_transient import slip_statement, slip_summary
from wroll_fem.analyses.transient_results import remarks, transient_dataset
from wroll_fem.bodies.levels import levels
from wroll_fem.case import load_case
from wroll_fem.coiled_stiff.modal_response import Oscillators
from wroll_fem.coiled_stiff.slip_criterion import (
    cycle_maximum,
    driven_mode,
    onset_levels,
    shear_per_g,
    slip_zone,
    slips,
)
from wroll_fem.errors import InputError
from wroll_fem.mesh.point_grid import coil_cells, coil_grid, largest_along
from wroll_fem.plotting.coil_slip import level_colours, plot_root_section, plot_shear_along, plot_slip_zone
from wroll_fem.plotting.coil_slip_space import plot_slip_in_coil, write_coil_vtu
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import load_dataset, save_dataset

LEVELS = [1.0, 3.0, 5.0, 8.0, 11.0, 15.0]
CAPACITY = 3e5  # Pa, at the mandrel


def falling(radius):
    """Capacity that falls linearly to zero at the coil's surface."""
    return CAPACITY * (SHAPE.outer_radius - radius) / (SHAPE.outer_radius - SHAPE.mandrel_radius)


def computed(capacity_at=falling, modes=None, levels=LEVELS, **keywords):
    options = {"damping_ratio": 0.02, "frequency_hz": None, **keywords}
    return transient_dataset(modes or beam(), capacity_at, SHAPE, levels_g=levels, **options)


@pytest.fixture(scope="module")
def dataset():
    return computed()


def test_modes_and_capacity_are_in_the_results_as_given(dataset):
    modes = beam()
    np.testing.assert_array_equal(dataset["mode_frequency"], modes.frequencies_hz)
    np.testing.assert_array_equal(dataset["effective_mass_fraction"], np.square(modes.participation) / modes.mass_total)
    np.testing.assert_allclose(dataset["capacity_profile"], falling(dataset["capacity_radius"].values))
    ends = dataset["capacity_radius"].values[[0, -1]]
    np.testing.assert_allclose(ends, [SHAPE.mandrel_radius, SHAPE.outer_radius])
    assert dataset.attrs["capacity_mandrel_pa"] == pytest.approx(CAPACITY)
    assert dataset.attrs["participating_mass_fraction"] == pytest.approx(
        float(dataset["effective_mass_fraction"].sum())
    )


# ---- stress over a cycle, slip, onset -------------------------------------------------------------


def test_largest_resultant_of_a_cycle_is_the_half_axis_of_its_ellipse():
    rng = np.random.default_rng(3)
    a, b = (rng.normal(size=(2, 50)) + 1j * rng.normal(size=(2, 50)))[:]
    turn = np.exp(2j * np.pi * np.arange(20000) / 20000)[:, None]
    sampled = np.hypot((a * turn).imag, (b * turn).imag).max(axis=0)
    np.testing.assert_allclose(cycle_maximum(a, b), sampled, rtol=1e-7)
    assert cycle_maximum(np.array([3j]), np.array([4j])) == pytest.approx(5.0)  # in phase: a line
    assert cycle_maximum(np.array([3.0]), np.array([3j])) == pytest.approx(3.0)  # in quadrature: a circle


def test_equality_is_no_slip():
    np.testing.assert_array_equal(slips(np.array([1.0, np.nextafter(1.0, 2.0), 0.0]), np.array([1.0, 1.0, 0.0])),
                                  [False, True, False])  # fmt: skip
    np.testing.assert_array_equal(
        onset_levels(np.array([0.0, 2.0, 2.0]), np.array([0.0, 0.0, 5.0])), [np.inf, 0.0, 2.5]
    )


def test_onset_of_a_beam_is_the_closed_form():
    modes = replace(beam(), participation=np.array([0.0, 0.8, 0.0]))  # one mode answers
    data = computed(lambda r: np.full_like(r, CAPACITY), modes)
    # at resonance |q| = Gamma g / (2 zeta w^2); largest shear at the lowest, innermost point on the faces along x
    q = 0.8 * GRAVITY / (2 * 0.02 * (2 * np.pi * 100.0) ** 2)
    up, depth = 1.0 - 0.0125 / SHAPE.length, 1.5e-3
    per_g = q * 2e8 * up**2 * np.exp(-depth / 4e-3)
    summary = slip_summary(data)
    assert summary["slip_onset_g"] == pytest.approx(CAPACITY / per_g, rel=1e-12)
    place = [summary[f"slip_onset_{name}"] for name in ("radius_m", "height_m")]
    np.testing.assert_allclose(place, [SHAPE.mandrel_radius + depth, 0.0125], rtol=1e-12)
    assert abs(np.sin(summary["slip_onset_theta_rad"])) < 1e-12
    # slip zone on the face theta = 0: g q s up^2 exp(-d/4mm) > capacity
    points, volumes = coil_points()
    theta, z, r = points.T
    up, d = 1 - z / SHAPE.length, r - SHAPE.mandrel_radius
    size = np.hypot(up**2 * np.exp(-d / 4e-3) * np.cos(theta), 0.5 * up * np.exp(-d / 8e-3) * np.sin(theta))
    for level, fraction, height, zone in zip(
        LEVELS, summary["slipping_volume_fraction"], summary["slip_zone_height_m"], summary["slip_zone_depth_m"],
        strict=True,
    ):  # fmt: skip
        slipping = level * q * 2e8 * size > CAPACITY
        assert fraction == pytest.approx(volumes[slipping].sum() / (np.pi * (0.025**2 - 0.010**2) * 0.3), rel=1e-12)
        assert (height, zone) == pytest.approx((z[slipping].max(), d[slipping].max()) if slipping.any() else (0, 0))
    assert summary["slipping_volume_fraction"][0] == 0.0 < summary["slipping_volume_fraction"][-1] < 1.0


def test_all_modes_add_up_with_their_phases():
    modes = beam()
    oscillators = Oscillators(modes.frequencies_hz, modes.participation, 0.02)
    per_g = shear_per_g(modes, oscillators, 300.0)
    times = np.linspace(0.0, 1 / 300.0, 2001)
    q = (oscillators.steady(300.0, GRAVITY)[:, None] * np.exp(2j * np.pi * 300.0 * times)).imag
    point = 77
    sampled = np.hypot(modes.srz[:, point] @ q, modes.srt[:, point] @ q).max()
    assert per_g.resultant[point] == pytest.approx(sampled, rel=1e-5)


def test_stress_scales_with_the_level_and_the_history_reaches_it(dataset):
    modes, first = beam(), int(np.argmin(dataset["slip_onset"].values))
    oscillators = Oscillators(modes.frequencies_hz, modes.participation, 0.02)
    q = oscillators.steady(100.0, 15.0 * GRAVITY)
    at_15_g = cycle_maximum(q @ modes.srz, q @ modes.srt)
    np.testing.assert_allclose(at_15_g, 15.0 * dataset["shear_resultant"].values, rtol=1e-12)
    last = dataset["shear_resultant_history"].values[-65:].max()
    assert last == pytest.approx(15.0 * float(dataset["shear_resultant"][first]), rel=3e-3)
    for data in (dataset, computed(frequency_hz=40.0)):  # below resonance the base's own motion is most of it
        attrs = data.attrs
        assert attrs["transmissibility_last_cycle"] == pytest.approx(attrs["transmissibility"], rel=3e-3)


def test_nothing_slips_where_nothing_may():
    modes = beam()
    assert slip_zone(modes, np.zeros(len(modes.volumes), dtype=bool), 0.01) == (0.0, 0.0, 0.0)


# ---- what is driven, what is said -----------------------------------------------------------------


def test_resonance_is_that_of_the_mode_with_the_largest_effective_mass(dataset):
    assert driven_mode(beam()) == 1  # not torsion, which lies below
    assert dataset.attrs["f_n_hz"] == dataset.attrs["excitation_frequency_hz"] == 100.0
    assert computed(frequency_hz=80.0).attrs["excitation_frequency_hz"] == 80.0


def test_capacity_above_every_load_is_stated_with_the_onset_beyond(dataset):
    strong = computed(lambda r: np.full_like(r, 40 * CAPACITY))
    onset = slip_summary(strong)["slip_onset_g"]
    assert onset > 15.0
    assert slip_summary(strong)["slipping_volume_fraction"] == [0.0] * 6
    assert slip_statement(strong).startswith(f"no slip up to 15 g; slip would start above {onset:.3g} g, 1.50 mm from")
    assert slip_statement(dataset).startswith(f"slip starts above {dataset['slip_onset'].min():.3g} g")
    still = computed(modes=replace(beam(), srz=np.zeros((3, 1440)), srt=np.zeros((3, 1440))))
    assert slip_statement(still) == "no slip at any level: the coil has no shear stress"
    assert "slip_onset_g" not in slip_summary(still)


def test_few_modes_and_a_base_above_them_are_told(dataset):
    assert "3 modes carry 89 % of the mass" in remarks(dataset)[0]
    assert remarks(computed(modes=replace(beam(), mass_total=0.95 * MASS))) == []
    last = remarks(computed(frequency_hz=700.0))[-1]
    assert "raise modal.count until the highest mode lies well above the excitation" in last


def test_modes_that_the_base_does_not_move_are_refused():
    rounding = replace(beam(), participation=1e-9 * beam().participation)
    with pytest.raises(InputError, match="none of 3 modes has effective mass along the excitation"):
        computed(modes=rounding)


def test_a_coil_a_little_thicker_than_the_wound_roll_holds_up_to_its_skin(root, monkeypatch):
    # what the fit allows, 1 % of the thickness; beyond the wound roll itself there is no pressure
    modes = beam()
    points = modes.points.copy()
    points[:, 2] += np.where(points[:, 2] == points[:, 2].max(), 0.0251 - 1e-5 - points[:, 2].max(), 0.0)
    monkeypatch.setattr(slip_model, "shear_modes", lambda case: replace(modes, points=points))
    exact = load_case(root / "configs" / "case_study.yaml")
    thick = exact.changed("coil.thickness=0.0151")
    found = modal_transient.run_modal_transient(thick, progress=SilentProgress())
    assert points[:, 2].max() > 0.025
    assert found["friction_capacity"].values.min() > 0.0
    assert found["capacity_profile"].values[-1] == pytest.approx(0.0, abs=1.0)
    assert found.attrs["capacity_mandrel_pa"] == pytest.approx(0.48 * 6.288e6, rel=1e-3)


def test_results_are_saved_and_read_with_units(dataset, tmp_path):
    back = load_dataset(save_dataset(dataset, tmp_path / "results.nc"))
    np.testing.assert_array_equal(back["slip_onset"], dataset["slip_onset"])
    assert back["shear_resultant"].attrs["units"] == "Pa"
    assert slip_summary(back) == slip_summary(dataset)


def test_shapes_of_hand_made_modes_are_checked():
    with pytest.raises(ValueError, match=r"srz must have the shape \(3, 1440\), got \(3, 2\)"):
        replace(beam(), srz=np.zeros((3, 2)))


# ---- points as a grid -----------------------------------------------------------------------------


def test_points_are_found_to_be_a_grid_whatever_their_order_and_a_little_scatter():
    points, _ = coil_points()
    rng = np.random.default_rng(1)
    order = rng.permutation(len(points))
    scattered = points[order] + rng.uniform(-1, 1, points.shape) * [1e-5, 1e-9, 1e-7]
    grid = coil_grid(scattered)
    assert grid is not None
    assert grid.numbers.shape == (5, 12, 24)
    np.testing.assert_allclose(scattered[grid.numbers[2, 3, 4]], [grid.theta[4], grid.z[3], grid.r[2]], atol=2e-5)
    assert coil_grid(points[:-1]) is None
    nodes, cells = coil_cells(grid, (SHAPE.mandrel_radius, SHAPE.outer_radius), (0.0, SHAPE.length))
    centre = nodes[cells].mean(axis=1)
    turn = np.angle(np.exp(1j * (np.arctan2(centre[:, 1], centre[:, 0]) - scattered[:, 0])))
    assert np.abs(turn).max() < 1e-4  # each cell lies around its point
    assert np.abs(centre[:, 2] - scattered[:, 1]).max() < 1e-8
    edges = nodes[cells][:, [1, 3, 4]] - nodes[cells][:, :1]
    assert np.linalg.det(edges).min() > 0.0  # VTK's orientation


def test_rows_are_told_apart_and_give_their_largest():
    place, which = levels(np.array([3.0, 1.0, 1.001, 3.0005]), 0.01)
    np.testing.assert_allclose(place, [1.0005, 3.00025])
    np.testing.assert_array_equal(which, [1, 0, 0, 1])
    place, largest = largest_along(np.array([0.0, 1.0, 1.0, 0.0]), np.array([1.0, 5.0, 7.0, -2.0]))
    np.testing.assert_array_equal(largest, [1.0, 7.0])


# ---- files and figures ----------------------------------------------------------------------------


def test_vtu_fills_the_coil_with_the_values_of_its_points(dataset, tmp_path):
    mesh = meshio.read(write_coil_vtu(dataset, tmp_path / "coil.vtu"))
    slipping = mesh.cell_data["slips_at_15_g"][0]
    np.testing.assert_array_equal(slipping > 0, dataset["slip_onset"].values < 15.0)
    corners = mesh.points[mesh.cells_dict["hexahedron"]]
    np.testing.assert_allclose(corners[..., 2].mean(axis=1), dataset["z_m"], atol=1e-9)
    points = meshio.read(write_coil_vtu(dataset.isel(point=slice(0, 100)), tmp_path / "points.vtu"))  # no grid
    assert points.cells_dict["vertex"].shape == (100, 1)


def test_distribution_shows_the_largest_of_each_row_at_every_level(dataset):
    ax = plot_shear_along(dataset, "z")
    lines = {line.get_label(): line for line in ax.lines}
    assert set(lines) == {*(f"{g:g} g" for g in LEVELS), "largest capacity"}
    row = dataset["z_m"].values == dataset["z_m"].values.min()
    top = 15.0 * dataset["shear_resultant"].values[row].max() / CAPACITY
    assert lines["15 g"].get_ydata()[0] == pytest.approx(top)
    radial = {line.get_label(): line for line in plot_shear_along(dataset, "r").lines}
    np.testing.assert_allclose(radial["capacity"].get_xydata()[[0, 150]], [[1.0, 1.0], [1.75, 0.5]])
    plt.close("all")


def test_root_sections_show_both_components_on_one_scale(dataset):
    scales = []
    for component, angle in (("rz", "0°"), ("rt", "90°")):
        ax = plot_root_section(dataset, component)
        assert f"at {angle} from x" in ax.get_title(loc="left").replace("\n", " ")
        scales.append(ax.collections[0].get_clim())
        root = dataset["z_m"].values == dataset["z_m"].values.min()
        largest = 15.0 * dataset[f"shear_{component}"].values[root].max() / CAPACITY
        assert ax.collections[0].get_array().max() == pytest.approx(largest)
    assert scales[0] == scales[1]
    plt.close("all")


def test_slip_zone_shades_each_level(dataset):
    ax = plot_slip_zone(dataset)
    assert "At 15 g the slip zone is" in ax.get_title(loc="left").replace("\xa0", " ")
    none = plot_slip_zone(computed(lambda r: np.full_like(r, 40 * CAPACITY)))
    assert none.get_title(loc="left").replace("\xa0", " ").startswith("No slip up to 15 g; it would start above 191 g")
    plt.close("all")


def test_picture_in_space_shows_slip_inside_and_none_outside(dataset, tmp_path):
    pytest.importorskip("pyvista")
    picture = imread(plot_slip_in_coil(dataset, tmp_path / "coil.png"))[..., :3]
    colour = np.array(to_rgb(level_colours(6)[0]))  # the lightest: slips at 15 g alone
    here = np.abs(picture - colour).max(axis=2) < 0.1
    rows = np.flatnonzero(here.any(axis=1))
    assert here.sum() > 500
    assert rows.min() > 0.2 * len(picture)  # the upper part of the coil does not slip
