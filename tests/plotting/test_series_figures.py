"""Figures of a study: what is drawn is what the data say, and the sentence above is computed from it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import scipy.sparse.linalg as spla
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgb
from matplotlib.quiver import Quiver
from support.paths import ROOT
from support.synthetic_roll import contact_points, estimated, modes, sweep

from wroll_fem.analyses.modal import tip_participation
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.case import load_case
from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.series import FIGURES
from wroll_fem.plotting.study import StudyCase, friction_work, read, shown, undamped_curve
from wroll_fem.plotting.style import save_figure
from wroll_fem.results.resonance import resonance
from wroll_fem.signals.transmissibility import magnitude

PRESSURES = (1e4, 3e4, 1e5)
LIMITS = dict(zip(PRESSURES, (3.0, 8.0, 20.0), strict=True))  # the slider of the synthetic roll grows with preload


@pytest.fixture(scope="module")
def runs() -> dict[float, xr.Dataset]:
    return {pressure: sweep(slip_limit=limit) for pressure, limit in LIMITS.items()}


@pytest.fixture(autouse=True)
def _close() -> Iterator[None]:
    yield
    plt.close("all")


def reference() -> StudyCase:
    data = xr.Dataset({"mode_frequency": ("mode", [150.0, 900.0]), "tip_participation": ("mode", [1.4, -0.3])})
    return StudyCase("reference", {}, data, reference=True)


def steady(data: xr.Dataset) -> xr.Dataset:
    """A curve without a history, as harmonic balance leaves it."""
    names = ["transmissibility_real", "transmissibility_imag"]
    return estimated(data[names].drop_dims("time", errors="ignore") * 0.97)


def by_preload(runs: dict[float, xr.Dataset], **extra: object) -> list[StudyCase]:
    return [StudyCase(f"p{p:g}", {"preload.pressure": p, **extra}, data) for p, data in runs.items()]


def draw(name: str, members: list[StudyCase], tmp_path: Path) -> Axes:
    ax = FIGURES[name](members)
    assert save_figure(ax, tmp_path / "figure.png").stat().st_size > 10_000
    return ax


def sentence(ax: Axes) -> str:
    figure = style.figure_of(ax)
    text = figure.get_suptitle() or ax.get_title(loc="left")
    return " ".join(text.replace("\u00a0", " ").replace("−", "-").split())


def curves(ax: Axes) -> dict[str, np.ndarray]:
    return {str(line.get_label()): np.asarray(line.get_xydata()) for line in ax.lines}


# ---- transmissibility over a parameter -----------------------------------------------------------


def test_preload_family_draws_every_curve_from_blue_to_red_and_the_mandrel_dashed(
    runs: dict[float, xr.Dataset], tmp_path: Path
) -> None:
    members = by_preload(runs, **{"coil.base": "free"}) + [reference()]
    held = StudyCase("held", {"preload.pressure": 1e4, "coil.base": "clamped"}, sweep(f_n=140.0))
    ax = draw("transmissibility_over_preload", [*members, held], tmp_path)
    panels = ax.figure.axes
    assert [p.get_legend().get_title().get_text() for p in panels] == ["free base", "clamped base"]
    lines = [line for line in panels[0].lines if "kPa" in str(line.get_label())]
    assert len(lines) == len(runs)
    for line, data in zip(lines, runs.values(), strict=True):
        np.testing.assert_array_equal(line.get_ydata(), magnitude(data).values)
    colours = [to_rgb(line.get_color()) for line in lines]
    assert colours[0][2] > colours[0][0]
    assert colours[-1][0] > colours[-1][2]
    alone = next(line for line in panels[0].lines if "mandrel" in str(line.get_label()))
    assert alone.get_linestyle() == "--"
    assert "150.0 Hz" in str(alone.get_label())
    highest = max(read(m).peak for m in members[:-1])
    assert highest < panels[0].get_ylim()[1] < 1.3 * highest  # the undamped curve does not set the scale
    found = [read(m) for m in members[:-1]]
    said = sentence(ax)
    assert f"Free base: resonance rises from {found[0].f_n:.1f} Hz (10 kPa) to {found[-1].f_n:.1f} Hz (100 kPa)" in said
    assert f"clamped base: resonance rises from {read(held).f_n:.1f} Hz (10 kPa)" in said


def test_steady_state_curves_are_dashed_in_the_colour_of_their_sweep(
    runs: dict[float, xr.Dataset], tmp_path: Path
) -> None:
    members = by_preload(runs, analysis="sweep")
    members += by_preload({p: steady(data) for p, data in runs.items()}, analysis="harmonic")
    ax = draw("transmissibility_over_preload", members, tmp_path)
    lines = [line for line in ax.lines if np.size(line.get_xdata()) > 1]
    assert len(lines) == 2 * len(runs)
    assert len([text for text in ax.get_legend_handles_labels()[1] if "harmonic balance" in text]) == 1
    assert f"peaks of sweep and harmonic balance agree to {100 * (1 / 0.97 - 1):.1f} %" in sentence(ax)
    for full, dashed in zip(lines[::2], lines[1::2], strict=True):
        assert (full.get_linestyle(), dashed.get_linestyle()) == ("-", "--")
        assert to_rgb(full.get_color()) == to_rgb(dashed.get_color())
        np.testing.assert_allclose(dashed.get_ydata(), 0.97 * np.asarray(full.get_ydata()))


def test_elastic_slip_family_has_a_panel_per_preload(runs: dict[float, xr.Dataset], tmp_path: Path) -> None:
    key = "contact.friction.elastic_slip"
    members = [
        StudyCase(f"{p:g} {slip:g}", {"preload.pressure": p, key: slip}, data)
        for p in (1e3, 1e5)
        for slip, data in zip((1e-6, 1e-7, 1e-4), runs.values(), strict=True)
    ]
    ax = draw("elastic_slip", members, tmp_path)
    panels = ax.figure.axes
    assert [p.get_legend().get_title().get_text() for p in panels] == ["1 kPa", "100 kPa"]
    for panel in panels:
        labels = [str(line.get_label()).split(":")[0] for line in panel.lines if "µm" in str(line.get_label())]
        assert labels == ["0.1 µm", "1 µm", "100 µm"]


def test_integrators_are_compared_by_their_peaks(runs: dict[float, xr.Dataset], tmp_path: Path) -> None:
    schemes = ("transient_fidelity", "no_damping", "quasi_static")
    members = [StudyCase(s, {"integrator.scheme": s}, d) for s, d in zip(schemes, reversed(runs.values()), strict=True)]
    peaks = [read(m).peak for m in members]
    said = sentence(draw("integrators", members, tmp_path))
    assert f"lie within {100 * (max(peaks[:2]) / min(peaks[:2]) - 1):.1f} %" in said
    assert f"reaches {100 * peaks[2] / max(peaks[:2]):.0f} % of the highest" in said


def test_friction_laws_are_compared_at_equal_preload(runs: dict[float, xr.Dataset], tmp_path: Path) -> None:
    members = by_preload(runs, case="lab_sweep")
    other = {p: sweep(slip_limit=1.05 * limit) for p, limit in LIMITS.items()}
    members += by_preload(other, case="lab_sweep_rate")
    off = max(
        max(read(a).peak, read(b).peak) / min(read(a).peak, read(b).peak) - 1
        for a, b in zip(members[:3], members[3:], strict=True)
    )
    ax = draw("friction_laws", members, tmp_path)
    assert f"differ by at most {100 * off:.1f} %" in sentence(ax)
    assert [p.get_legend().get_title().get_text() for p in ax.figure.axes] == ["lab sweep", "lab sweep rate"]


# ---- damping and friction work over the preload --------------------------------------------------


@pytest.mark.parametrize(
    ("name", "key", "value", "text"),
    [
        ("damping_over_frequency", "coil.base", "free", "free base"),
        ("layer_count", "coil.layers", 1, "1 layer"),
        ("layer_modulus", "coil.material.E", 2.8e9, "2.8 GPa"),
    ],
)
def test_damping_over_frequency_has_a_point_per_preload(
    runs: dict[float, xr.Dataset], tmp_path: Path, name: str, key: str, value: object, text: str
) -> None:
    members = by_preload(dict(reversed(runs.items())), **{key: value})
    ax = draw(name, [*members, reference()], tmp_path)
    found = [read(m) for m in reversed(members)]  # joined by rising preload, in whatever order they come
    points = curves(ax)[text]
    np.testing.assert_allclose(points, [[r.f_n, 100 * r.zeta] for r in found])
    best = max(found, key=lambda r: r.zeta)
    at = shown("preload.pressure", PRESSURES[found.index(best)])
    assert f"largest damping {100 * best.zeta:.2f} % at {at} and {best.f_n:.1f} Hz" in sentence(ax)
    assert ax.get_ylim()[0] == 0.0
    assert "mandrel alone, 150.0 Hz" in curves(ax)


def test_friction_over_preload_says_the_direction_that_the_data_have(
    runs: dict[float, xr.Dataset], tmp_path: Path
) -> None:
    work = {p: friction_work(StudyCase("", {}, data)) for p, data in runs.items()}
    order = sorted(runs, key=work.__getitem__)
    for values, word in ((order, "rises"), (order[::-1], "falls"), ([*order[1:], order[0]], "changes both ways")):
        members = [
            StudyCase("", {"preload.pressure": p}, runs[source]) for p, source in zip(PRESSURES, values, strict=True)
        ]
        ax = draw("friction_over_preload", members, tmp_path)
        expected = [[1e-3 * p, 1e3 * work[source]] for p, source in zip(PRESSURES, values, strict=True)]
        np.testing.assert_allclose(ax.lines[0].get_xydata(), expected)
        said = sentence(ax)
        assert word in said
        assert f"from {1e3 * work[values[0]]:.3g} mJ at 10 kPa to {1e3 * work[values[-1]]:.3g} mJ at 100 kPa" in said


def test_friction_over_damping_prints_pearsons_correlation(runs: dict[float, xr.Dataset], tmp_path: Path) -> None:
    members = by_preload(runs, **{"coil.base": "free"})
    held = StudyCase("held", {"preload.pressure": 1e4, "coil.base": "clamped"}, sweep(f_n=140.0))
    ax = draw("friction_over_damping", [*members, held], tmp_path)
    work, zeta = [friction_work(m) for m in members], [read(m).zeta for m in members]
    assert f"r = {np.corrcoef(work, zeta)[0, 1]:.2f};" in sentence(ax)
    np.testing.assert_allclose(
        ax.collections[0].get_offsets(), np.column_stack([100 * np.array(zeta), 1e3 * np.array(work)])
    )


def test_friction_along_the_sweep_shows_lowest_and_highest_preload_at_one_scale(
    runs: dict[float, xr.Dataset], tmp_path: Path
) -> None:
    members = by_preload(runs)
    ax = draw("friction_along_sweep", [members[1], members[2], members[0]], tmp_path)
    accelerations = [a for a in ax.get_figure(root=True).axes if "acceleration" in a.get_ylabel()]
    assert [a.get_title(loc="left").replace("\u00a0", " ").split(":")[0] for a in accelerations] == [
        "10 kPa", "100 kPa",
    ]  # fmt: skip
    assert accelerations[0].get_ylim() == accelerations[1].get_ylim()
    twins = [a for a in ax.get_figure(root=True).axes if "friction work" in a.get_ylabel()]
    for twin, m in zip(twins, (members[0], members[2]), strict=True):
        np.testing.assert_allclose(np.asarray(twin.lines[0].get_ydata())[-1], 1e3 * friction_work(m))


# ---- mesh ------------------------------------------------------------------------------------------


def test_mesh_friction_measures_against_the_finest_of_the_last_line(
    runs: dict[float, xr.Dataset], tmp_path: Path
) -> None:
    data = dict(zip(((1, 10), (1, 20), (6, 10), (6, 20)), [*runs.values(), sweep(slip_limit=21.0)], strict=True))
    members = [StudyCase("", {"mesh.grading": g, "mesh.axial": n}, d) for (g, n), d in data.items()]
    ax = draw("mesh_friction", members, tmp_path)
    peaks = [read(m).peak for m in members]
    worst = max(range(4), key=lambda k: abs(peaks[k] / peaks[3] - 1))
    g, n = list(data)[worst]
    said = sentence(ax)
    assert f"({n} elements along the axis, grading {g})" in said
    assert f"peak {100 * (peaks[worst] / peaks[3] - 1):+.1f} %" in said
    np.testing.assert_allclose(ax.lines[0].get_xydata(), [[m.values["mesh.axial"], read(m).f_n] for m in members[:2]])


def test_mesh_frequency_shades_one_per_cent_around_the_finest(tmp_path: Path) -> None:
    members = []
    for around, axial, f in ((16, 5, 143.0), (16, 10, 149.0), (30, 5, 150.5), (30, 10, 148.0)):
        data = modes()
        data["mode_frequency"][:] = data["mode_frequency"].values * f / 148.3
        members.append(StudyCase("", {"mesh.circumferential": around, "mesh.axial": axial}, data))
    ax = draw("mesh_frequency", members, tmp_path)
    np.testing.assert_allclose(curves(ax)["elements around 16"], [[5, 143.0], [10, 149.0]])
    band = ax.patches[0].get_bbox()
    np.testing.assert_allclose([band.y0, band.y1], [0.99 * 148.0, 1.01 * 148.0])
    said = sentence(ax)
    assert f"(148.00 Hz): {100 * (143 / 148 - 1):+.3f} % with 16 elements around and 5 along" in said


# ---- slip ------------------------------------------------------------------------------------------


def levels(interfaces: int = 3) -> list[StudyCase]:
    """3 g, 1 g, 2 g: the threshold of slip falls as the level rises."""
    members = []
    for level in (3, 1, 2):
        data = contact_points(interfaces=interfaces, half=True)
        data["max_slip"] = level * data["max_slip"]
        for name in ("peak_slip_axial", "peak_slip_hoop"):
            data[name] = level * data[name]
        data["slipped"] = data["max_slip"] > 1.2e-6
        members.append(StudyCase(f"{level}g", {"excitation.amplitude": 9.80665 * level}, data))
    return members


def test_slip_extent_is_red_where_it_slipped_and_prints_the_area(tmp_path: Path) -> None:
    members = levels()
    ax = draw("slip_extent", members, tmp_path)
    panels = np.array(ax.figure.axes).reshape(3, 3)
    assert [row[0].get_ylabel().split("\n")[0] for row in panels] == ["1 g", "2 g", "3 g"]
    assert [a.get_title() for a in panels[0]] == ["mandrel\nlayer 1", "layer 1\nlayer 2", "layer 2\nlayer 3"]
    counts = []
    for row, m in zip(panels, (members[1], members[2], members[0]), strict=True):
        area = m.data["area"].values
        fraction = (m.data["slipped"].values * area).sum(axis=1) / area.sum(axis=1)
        counts.append(int(np.count_nonzero(fraction)))
        for k, panel in enumerate(row):
            shown_share = panel.texts[0].get_text()
            least = "0 %" if fraction[k] == 0 else "< 1 %"
            assert shown_share == (f"{100 * fraction[k]:.0f} %" if fraction[k] >= 0.01 else least)
            mesh = next(c for c in panel.collections if isinstance(c, QuadMesh))
            red = np.asarray(mesh.get_array()).reshape(241, 361) > 0.5
            assert abs(red.mean() - fraction[k]) < 0.05
            assert red.any() == (fraction[k] > 0)
            assert to_rgb(mesh.cmap(1.0)) == to_rgb(style.RED)
            if red.any() and not red.all():
                assert red[0, 180]  # at the root, 0 degrees: facing the excitation
    said = sentence(ax)
    for level, count in zip((1, 2, 3), counts, strict=True):
        assert f"{count} of 3 at {level} g (" in said
    assert "largest area: mandrel and layer 1" in said


def test_slip_vectors_show_the_lowest_level_at_one_scale(tmp_path: Path) -> None:
    members = levels()
    ax = draw("slip_vectors", members, tmp_path)
    panels = [a for a in ax.figure.axes if any(isinstance(c, Quiver) for c in a.collections)]
    arrows = [next(c for c in a.collections if isinstance(c, Quiver)) for a in panels]
    assert len({(a.scale, a.norm.vmax) for a in arrows}) == 1
    lowest = members[1].data
    for k, quiver in enumerate(arrows):
        size = 1e6 * np.hypot(lowest["peak_slip_hoop"].values[k], lowest["peak_slip_axial"].values[k])
        np.testing.assert_allclose(np.hypot(quiver.U, quiver.V).max(), size.max())
    largest = 1e6 * float(lowest["max_slip"].max())
    assert f"At 1 g the largest relative displacement, {largest:.3g} µm, mostly axial, is between" in sentence(ax)
    assert "mandrel and layer 1 at 0°" in sentence(ax)


# ---- words, readings, errors -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        ("preload.pressure", 1.78e4, "17.8 kPa"),
        ("preload.pressure", [200.0] * 5, "5 x 0.2 kPa"),
        ("contact.friction.elastic_slip", 1e-7, "0.1 µm"),
        ("coil.layers", 2, "2 layers"),
        ("coil.base", "inner_edge", "inner edge base"),
        ("integrator.scheme", "quasi_static", "quasi static"),
        ("excitation.amplitude", 9.80665, "1 g"),
    ],
)
def test_values_are_said_as_people_say_them(key: str, value: object, text: str) -> None:
    assert shown(key, value) == text


def test_a_reading_of_the_results_goes_before_that_of_the_curve(runs: dict[float, xr.Dataset]) -> None:
    data = runs[1e4].assign_attrs(f_n_hz=123.0, peak_transmissibility=4.0, zeta=None, skewness=None)
    found = read(StudyCase("", {}, data))
    assert (found.f_n, found.peak) == (123.0, 4.0)
    assert np.isnan(found.zeta)


@pytest.mark.parametrize("name", sorted(FIGURES))
def test_a_figure_names_the_keys_it_misses(name: str, runs: dict[float, xr.Dataset]) -> None:
    with pytest.raises(InputError, match=r"needs cases with values of \w+"):
        FIGURES[name]([StudyCase("", {"mesh.file": "a.msh"}, runs[1e4])])


def test_the_undamped_curve_of_the_modes_is_that_of_the_matrices() -> None:
    small = ["mesh.circumferential=8", "mesh.axial=4", "modal.count=12"]
    case = load_case(ROOT / "configs" / "lab_mandrel.yaml", small)
    bodies = build_bodies(case, symmetric=False)
    system = build_system(case, bodies)
    from wroll_fem.fem.eigen import solve_pairs

    pairs = solve_pairs(system.stiffness, system.mass, 30, sigma=-((2 * np.pi * 10.0) ** 2))
    hertz = np.sqrt(pairs.values) / (2 * np.pi)
    data = xr.Dataset(
        {"mode_frequency": ("mode", hertz), "tip_participation": ("mode", tip_participation(system, pairs.vectors))}
    )
    frequency = np.array([60.0, 120.0, 145.0, 170.0])
    exact = []
    for f in frequency:
        dynamic = (system.stiffness - (2 * np.pi * f) ** 2 * system.mass).tocsc()
        motion = spla.spsolve(dynamic, (2 * np.pi * f) ** 2 * (system.mass @ system.influence))
        exact.append(abs(1.0 + system.probes["tip"] @ motion))
    np.testing.assert_allclose(undamped_curve(StudyCase("", {}, data), frequency), exact, rtol=1e-2)


def test_a_ringing_curve_is_marked_and_gives_no_damping(runs: dict[float, xr.Dataset], tmp_path: Path) -> None:
    ringing = runs[1e5].assign_attrs(
        f_n_hz=160.0, peak_transmissibility=400.0, zeta=0.2, half_power_reason="rises above half power again at 170 Hz"
    )
    members = by_preload({1e4: runs[1e4], 3e4: runs[3e4], 1e5: ringing}, **{"coil.base": "free"})
    labels = [str(line.get_label()) for line in draw("transmissibility_over_preload", members, tmp_path).lines]
    assert "100 kPa: 160.0 Hz, rings" in labels
    fitted = ringing.assign_attrs(zeta_reason="fitted: the band lacks a half-power point", half_power_reason="")
    assert resonance(ringing).rings
    assert not resonance(fitted).rings
    ax = draw("damping_over_frequency", members, tmp_path)
    np.testing.assert_allclose(curves(ax)["free base, rings: no damping"], [[160.0, 20.0]])
    assert "largest damping 20" not in sentence(ax)
