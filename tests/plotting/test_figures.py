"""Figures and slip rasters from a synthetic roll: what is drawn, not only that something is."""

from __future__ import annotations

import builtins
from itertools import pairwise

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import meshio
import numpy as np
import pytest
from matplotlib.image import imread
from support import synthetic_roll

from wroll_fem import load_case
from wroll_fem import plot as figures
from wroll_fem.analyses import write_figures
from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.cylinder import slip_surface
from wroll_fem.results.interface_slip import interface_radius, raster, slipping_area_fraction, surface
from wroll_fem.results.resonance import resonance
from wroll_fem.signals.damping import half_power


@pytest.fixture(scope="module")
def sweep():
    return synthetic_roll.sweep()


@pytest.fixture(autouse=True)
def no_figure_left_open():
    yield
    plt.close("all")


def texts(ax):
    return (
        " ".join([ax.get_title(loc="left"), *(t.get_text() for t in ax.texts)]).replace("\n", " ").replace("\xa0", " ")
    )


def scattered(whole):
    """The same fields on points that form no grid."""
    rng = np.random.default_rng(0)
    keep = rng.random(whole.sizes["point"]) < 0.93
    keep |= np.isin(whole["z_m"], [whole["z_m"].min(), whole["z_m"].max()])
    return whole.isel(point=np.flatnonzero(keep))


# --- slip on the circumference ----------------------------------------------------------------------------------


def test_half_a_roll_shows_the_same_as_the_whole_one():
    whole, half = synthetic_roll.contact_points(), synthetic_roll.contact_points(half=True)
    assert half.sizes["point"] < 0.6 * whole.sizes["point"]
    np.testing.assert_allclose(slipping_area_fraction(half), slipping_area_fraction(whole), rtol=1e-12)
    assert interface_radius(half, 0) == pytest.approx(0.04, rel=1e-9)
    for name in ("cumulative_slip", "peak_slip_hoop", "peak_slip_axial"):
        a, b = (raster(surface(ds, 0, name), name)[2] for ds in (whole, half))
        assert np.abs(a).max() > 0.0
        np.testing.assert_allclose(a, b, atol=1e-15)


@pytest.mark.parametrize("n_theta", [16, 25])
def test_raster_is_seamless_and_exact_at_the_points(n_theta):
    dataset = synthetic_roll.contact_points(n_theta)
    points = surface(dataset, 1, "max_slip")
    theta, z, values = raster(points, "max_slip", n_theta=181)
    np.testing.assert_allclose(values[:, 0], values[:, -1], rtol=1e-12)
    jump = np.abs(np.diff(values, axis=1)).max()
    assert abs(values[0, 1] - values[0, -2]) < 3 * jump
    for k in (0, 3, n_theta // 2):
        at = np.interp(points.theta[k], theta, values[0])
        assert at == pytest.approx(points.values["max_slip"][k], rel=0.02)
    assert z[0] == 0.0


def test_scattered_points_give_the_same_picture_as_a_grid():
    whole = synthetic_roll.contact_points(48, 25)
    some = scattered(whole)
    a = raster(surface(whole, 0, "max_slip"), "max_slip", radius=0.04)[2]
    b = raster(surface(some, 0, "max_slip"), "max_slip", radius=0.04)[2]
    assert np.isfinite(b).all()
    assert np.abs(a - b).max() < 0.05 * a.max()


@pytest.mark.parametrize("thin", [False, True])
def test_cylinder_surface_closes_at_the_seam(thin):
    dataset = synthetic_roll.contact_points(24, 13)
    xyz, cells, fields = slip_surface(scattered(dataset) if thin else dataset, 0)
    corners = xyz[cells]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * np.linalg.norm(np.cross(a, b), axis=1).sum()
    if cells.shape[1] == 4:
        area += 0.5 * np.linalg.norm(np.cross(b, corners[:, 3] - corners[:, 0]), axis=1).sum()
    radius = np.hypot(*xyz[0, :2])
    assert area == pytest.approx(2 * np.pi * radius * 0.3, rel=0.02)
    edges = np.sort(np.concatenate([cells[:, [k, (k + 1) % cells.shape[1]]] for k in range(cells.shape[1])]), axis=1)
    border = [e for e, n in zip(*np.unique(edges, axis=0, return_counts=True), strict=True) if n == 1]
    assert {round(xyz[i, 2], 6) for e in border for i in e} == {0.0, 0.3}  # open at base and tip only
    assert fields["cumulative_slip"].shape == (xyz.shape[0],)


def test_missing_field_or_interface_is_named(sweep):
    with pytest.raises(InputError, match="cumulative_slip"):
        figures.slip_map(sweep.drop_vars("cumulative_slip"))
    with pytest.raises(InputError, match="no interface 2"):
        figures.slip_map(sweep, interface=2)
    with pytest.raises(InputError, match="transmissibility_real"):
        figures.transmissibility(sweep.drop_vars("transmissibility_real"))
    with pytest.raises(InputError, match="contact_energy"):
        figures.energy_ledger(sweep.drop_vars("contact_energy"))


# --- figures ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "draw",
    [
        figures.transmissibility,
        lambda ds, ax: figures.comparison({"30 kPa": ds}, ax),
        figures.response,
        figures.energy_ledger,
        lambda ds, ax: figures.slip_map(ds, 0, ax),
        lambda ds, ax: figures.peak_slip_vectors(ds, 1, ax),
        lambda _, ax: figures.modes(synthetic_roll.modes(), ax),
    ],
)
def test_figures_draw_into_the_axes_given_label_them_and_show_nothing(draw, sweep, monkeypatch):
    monkeypatch.setattr(plt, "show", lambda *a, **k: pytest.fail("a figure was shown"))
    before = sweep.copy(deep=True)
    _, ax = plt.subplots()
    assert draw(sweep, ax) is ax
    assert len(plt.get_fignums()) == 1
    assert ax.get_xlabel().endswith(")") or "°" in ax.get_xlabel()
    assert any(c.isdigit() for c in ax.get_title(loc="left"))
    assert sweep.identical(before)


def test_transmissibility_figure_states_the_half_power_reading(sweep):
    ax = figures.transmissibility(sweep)
    size = np.hypot(sweep["transmissibility_real"], sweep["transmissibility_imag"])
    read = half_power(sweep["frequency"], size)
    for number in (f"{read.f_n:.2f} Hz", f"{100 * read.zeta:.2f} %", f"{read.peak:.2f}", f"{read.skewness:+.2f}"):
        assert number in ax.texts[0].get_text()
    assert f"damping ratio {100 * read.zeta:.2f} % (half power)" in texts(ax)
    marks = [line for line in ax.lines if line.get_label() == "half power"]
    np.testing.assert_allclose(marks[0].get_xdata(), [read.f_low, read.f_high])


def test_transmissibility_figure_gives_the_reason_for_no_damping_estimate(sweep):
    peak = resonance(sweep).f_n
    ax = figures.transmissibility(
        synthetic_roll.estimated(sweep.isel(frequency=sweep["frequency"].values < peak + 0.3))
    )
    assert "no damping estimate: no half-power point between the peak" in texts(ax)


def test_transmissibility_figure_shows_the_estimate_of_the_results_and_computes_none(sweep):
    text = texts(figures.transmissibility(sweep.assign_attrs(zeta=0.1234, zeta_method="rational fraction, envelope")))
    assert "damping ratio 12.34 % (rational fraction)" in text
    with pytest.raises(
        InputError, match=r"no resonance \(attributes f_n_hz, .*add one: dataset.assign_attrs\(wf.half_po"
    ):
        figures.transmissibility(sweep.drop_attrs(deep=False))


def test_comparison_names_the_ends_of_the_range():
    runs = {name: synthetic_roll.sweep(slip_limit=limit) for name, limit in (("10 kPa", 3.0), ("300 kPa", 12.0))}
    ax = figures.comparison(runs)
    reads = {name: resonance(ds) for name, ds in runs.items()}
    assert f"{reads['10 kPa'].f_n:.1f} Hz (10 kPa) to {reads['300 kPa'].f_n:.1f} Hz (300 kPa)" in texts(ax)
    with pytest.raises(InputError, match="no runs"):
        figures.comparison({})


def test_response_reads_the_sweep_frequency_on_its_second_axis(sweep):
    ax = figures.response(sweep)
    ax.figure.canvas.draw()
    (top,) = (child for child in ax.child_axes if child.get_xlabel() == "Frequency of the base (Hz)")
    np.testing.assert_allclose(top.get_xlim(), synthetic_roll.MOTION.frequency(np.array(ax.get_xlim())), rtol=1e-9)
    tip = np.abs(sweep["tip_acceleration"] + sweep["base_acceleration"])
    assert f"{float(synthetic_roll.MOTION.frequency(sweep['time'][int(tip.values.argmax())])):.1f} Hz" in texts(ax)
    partial = figures.response(sweep.isel(time=slice(0, 9000)))  # a run that stopped keeps its frequencies
    partial.figure.canvas.draw()
    expected = synthetic_roll.MOTION.frequency(np.array(partial.get_xlim()))
    np.testing.assert_allclose(partial.child_axes[0].get_xlim(), expected, rtol=1e-9)


def test_ledger_figure_states_shares_that_add_up(sweep):
    ax = figures.energy_ledger(sweep)
    share = float(sweep["friction_energy"][-1] / sweep["input_work"][-1])
    assert f"friction {100 * share:.1f} %" in texts(ax)
    assert "closes to rounding" in texts(ax)
    leak = sweep.assign(numerical_dissipation=sweep["numerical_dissipation"] + 0.02 * sweep["input_work"])
    assert "off by 2 %" in texts(figures.energy_ledger(leak))
    dashpot = leak.assign(material_damping=-0.02 * sweep["input_work"])
    assert "material damping −2.0 %; the balance closes to rounding" in texts(figures.energy_ledger(dashpot)).replace(
        "\xa0", " "
    )


def test_a_long_line_keeps_its_extremes_and_ends_when_thinned():
    x = np.linspace(0.0, 1.0, 100_001)
    y = np.cumsum(np.random.default_rng(3).standard_normal(x.size))
    few_x, few_y = style.thinned(x, y)
    assert few_x.size < 4100
    assert np.all(np.diff(few_x) > 0.0)
    assert few_x[[0, -1]].tolist() == [0.0, 1.0]
    for a, b in pairwise(np.linspace(0.0, 1.0, 400)):  # columns of a picture
        all_y, kept_y = y[(x >= a) & (x <= b)], few_y[(few_x >= a - 1e-3) & (few_x <= b + 1e-3)]
        assert kept_y.min() <= all_y.min()
        assert kept_y.max() >= all_y.max()
    short = style.thinned(x[:5000], y[:5000])
    assert short[1].size == 5000


def test_long_histories_keep_their_extremes_when_thinned(sweep):
    tip = sweep["tip_acceleration"].values
    x, low, high = style.line_envelope(sweep["time"].values, tip)
    assert x.size <= 1500 < tip.size
    assert (low.min(), high.max()) == (tip.min(), tip.max())
    assert (high[20:] > 0.0).all()  # every bin holds more than a cycle
    assert (low[20:] < 0.0).all()


def test_slip_map_shows_colour_only_where_it_slipped_near_the_root_along_x(sweep):
    ax = figures.slip_map(sweep)
    (picture,) = (c for c in ax.collections if c.get_array() is not None and c.get_array().ndim == 2)
    shown = np.ma.filled(np.ma.masked_invalid(picture.get_array()), np.nan)
    rows, columns = np.nonzero(np.isfinite(shown))
    theta, z = np.linspace(-180, 180, 361), np.linspace(0.0, 300.0, 241)
    assert z[rows].max() < 150.0
    assert np.isfinite(shown[0, 180])
    assert not np.isfinite(shown[40, 270])
    assert np.allclose(shown[:, 0], shown[:, -1], equal_nan=True)
    assert (np.abs(np.cos(np.radians(theta[columns]))) > 0.1).mean() > 0.95
    fraction = float(slipping_area_fraction(sweep)[0])
    assert f"{100 * fraction:.0f} % of the interface between mandrel and layer 1 slipped" in texts(ax)
    assert np.isfinite(shown).mean() == pytest.approx(fraction, abs=0.03)


def test_axes_say_which_faces_the_excitation_hits(sweep):
    assert "0° and ±180° face the excitation" in figures.slip_map(sweep).get_xlabel()
    across = sweep.assign_attrs(excitation_direction="y")
    assert "±90° face the excitation" in figures.peak_slip_vectors(across).get_xlabel()


def test_slip_map_of_a_stuck_interface_says_so():
    stuck = synthetic_roll.contact_points()
    stuck["slipped"][:] = False
    stuck["cumulative_slip"][:] = 0.0
    assert "No slip between layer 1 and layer 2" in texts(figures.slip_map(stuck, 1))


def test_peak_slip_vectors_point_axially_and_oppositely_on_both_faces(sweep):
    ax = figures.peak_slip_vectors(sweep)
    (arrows,) = (c for c in ax.collections if hasattr(c, "U"))
    at_0, at_180 = (np.flatnonzero((np.abs(arrows.X - x) < 1e-6) & (arrows.Y == 0.0)) for x in (0.0, -180.0))
    assert arrows.V[at_0] == pytest.approx(3.0)
    assert arrows.V[at_180] == pytest.approx(-3.0)
    assert np.abs(arrows.U[at_0]).max() < 1e-9
    assert "3 µm, mostly axial, at 0°" in texts(ax)


def test_modes_are_named_with_frequency_and_mass():
    ax = figures.modes(synthetic_roll.modes())
    assert "402.7 Hz" in texts(ax)
    assert "148.3 Hz, 71 % of the mass along x" in texts(ax)
    assert "first bending at 148.3 Hz" in texts(ax)
    assert [t.get_text().split()[-1] for t in ax.get_yticklabels()][2] == "torsion"


def test_numbers_in_titles_are_short():
    assert style.engineering(0.0123, "J") == "12.3 mJ"
    assert style.engineering(0.9996, "J") == "1 J"
    assert style.engineering(1800e-6, "m") == "1.8 mm"
    assert style.three_digits(1799.6) == "1800"


# --- files ------------------------------------------------------------------------------------------------------


def test_saved_figure_is_readable_at_readme_width_and_closed(sweep, tmp_path):
    path = figures.save(figures.transmissibility(sweep), tmp_path / "figures" / "t.png")
    assert imread(path).shape[1] == pytest.approx(1080, abs=2)
    assert plt.get_fignums() == []


def test_slip_vtu_holds_every_interface_in_si(sweep, tmp_path):
    mesh = meshio.read(figures.write_slip_vtu(sweep, tmp_path / "fields" / "slip.vtu"))
    assert set(np.unique(mesh.point_data["interface"])) == {0.0, 1.0}
    inner = mesh.point_data["interface"] == 0.0
    assert mesh.point_data["cumulative_slip"][inner].max() == float(sweep["cumulative_slip"][0].max())
    assert np.hypot(*mesh.points[inner, :2].T) == pytest.approx(0.04, rel=1e-6)


def quad9_tube(around=12, along=6, radius=0.04, height=0.3):
    theta, z = (
        g.ravel() for g in np.meshgrid(np.arange(2 * around) * np.pi / around, np.linspace(0, height, 2 * along + 1))
    )
    points = np.stack([radius * np.cos(theta), radius * np.sin(theta), z], axis=1)
    steps = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
    cells = [
        [(j + b) * 2 * around + (i + a) % (2 * around) for a, b in steps]
        for j in range(0, 2 * along, 2)
        for i in range(0, 2 * around, 2)
    ]
    return points, np.array(cells)


def test_mode_shapes_are_rendered_and_arrays_checked(tmp_path):
    pytest.importorskip("pyvista")
    points, cells = quad9_tube()
    shapes = np.array([np.outer((points[:, 2] / 0.3) ** 2, axis) for axis in np.eye(3)[:2]])
    picture = imread(figures.mode_shapes(points, cells, shapes, ["1  bending", "2  bending"], tmp_path / "m.png"))
    assert (np.ptp(picture[: int(0.7 * len(picture)), :, :3], axis=2) > 0.15).mean() > 0.05  # above the colour bar
    with pytest.raises(InputError, match=r"titles, shapes .* do not match"):
        figures.mode_shapes(points, cells, shapes[:, :-1], ["a", "b"], tmp_path / "m.png")


def test_missing_pyvista_names_the_extra_to_install(tmp_path, monkeypatch):
    real = builtins.__import__

    def without(name, *args, **options):
        if name == "pyvista":
            raise ImportError("No module named 'pyvista'")
        return real(name, *args, **options)

    monkeypatch.setattr(builtins, "__import__", without)
    points, cells = quad9_tube()
    figures.slip_on_cylinder(synthetic_roll.contact_points(), tmp_path / "c.png")  # does without
    with pytest.raises(InputError, match=r"wroll-fem\[view\]"):
        figures.mode_shapes(points, cells, np.zeros((1, *points.shape)), ["1"], tmp_path / "m.png")


# ---- pressure --------------------------------------------------------------------------------------


@pytest.mark.parametrize("half", [False, True])
def test_pressure_of_a_preload_run_is_drawn(half, root, tmp_path):  # its results hold no slip
    points = synthetic_roll.contact_points(half=half)[["pressure", "area"]]
    ax = figures.pressure_map(points, interface=1)
    assert "Pressure between layer 1 and layer 2: mean 50 kPa, 45 kPa to 55 kPa" in texts(ax)
    drawn = ax.collections[0].get_array()
    assert (drawn.min(), drawn.max()) == pytest.approx((45.0, 55.0), rel=1e-3)
    case = load_case(root / "configs" / "tiny.yaml", ["analysis=preload"])
    assert [path.name for path in write_figures(points.assign_attrs(case_yaml=case.resolved_yaml()), tmp_path)] == [
        "pressure_01.png",
        "pressure_02.png",
    ]
