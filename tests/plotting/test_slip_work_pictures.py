"""Slip zone and slip work of a coil whose wraps slide: whole circumference, root sections, picture in space."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.image import imread

import wroll_fem as wf
from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.coil_slip import grid_of, level_colours
from wroll_fem.plotting.slip_work import whole_coil

INNER, OUTER, LENGTH, G = 0.01, 0.02, 0.1, 9.80665


@pytest.fixture(scope="module")
def half() -> xr.Dataset:
    """Half of a coil; its wraps slide below 20 mm and within 2.5 mm of the mandrel, near the mandrel at 1 g already."""
    theta = np.pi * (np.arange(8) + 0.5) / 8
    z, r = LENGTH * (np.arange(20) + 0.5) / 20, INNER + 0.01 * (np.arange(8) + 0.5) / 8
    t, z, r = (grid.ravel() for grid in np.meshgrid(theta, z, r, indexing="ij"))
    slides = (z < 0.02) & (r < INNER + 2.5e-3)
    work = np.where(slides, 1e6 * (1.0 + np.cos(t) ** 2) * np.exp(-(r - INNER) / 1e-3), 0.0)
    onset = np.where(slides, np.where(r < INNER + 1e-3, 5e-4, 2e-3), np.nan)
    values = {"theta_rad": t, "z_m": z, "r_m": r, "slip_work_density": work, "tip_amplitude_at_slip": onset}
    volume = 2.0 * np.pi / 8 * (LENGTH / 20) * r * 0.01 / 8
    tips = np.array([2.5e-4, 5e-4, 2e-3, 4e-3])
    return xr.Dataset(
        {name: ("point", column) for name, column in {**values, "volume": volume}.items()}
        | {"resonant_base_acceleration": ("tip_amplitude", G * np.array([0.5, 0.9, 4.0, 8.0]))},
        coords={"tip_amplitude": tips, "amplitude_g": [1.0, 5.0]},
        attrs={"mandrel_radius_m": INNER, "coil_outer_radius_m": OUTER, "length_m": LENGTH, "followed_mode": "bending"},
    )


def test_half_a_coil_is_mirrored_with_its_volume_and_work(half: xr.Dataset) -> None:
    whole = whole_coil(half)
    assert whole.sizes["point"] == 2 * half.sizes["point"]
    assert whole["tip_amplitude"].equals(half["tip_amplitude"])
    assert grid_of(whole).theta.size == 16
    for quantity in (1.0, "slip_work_density"):
        sums = [(d["volume"] * (d[quantity] if isinstance(quantity, str) else quantity)).sum() for d in (half, whole)]
        assert float(sums[1]) == pytest.approx(float(sums[0]), rel=1e-12)
    assert sorted(set(whole["slip_onset"].values)) == [0.9, 4.0, np.inf]
    assert whole_coil(whole).sizes["point"] == whole.sizes["point"]


def test_sections_show_level_and_work_of_each_point(half: xr.Dataset) -> None:
    first = wf.plot.slip_work_sections(half)
    figure = style.figure_of(first)
    level, work = figure.axes[:2]
    assert "at 5 g 19 % of the section slips" in level.get_title(loc="left").replace("\n", " ").replace("\u00a0", " ")
    shown = level.collections[0].get_array()
    # of 8 rings of 16 points one slides at 1 g, another at 5 g, six at no level
    assert np.bincount(np.asarray(shown).ravel().astype(int)).tolist() == [16, 16, 96]
    assert "slip work up to 1.05 MJ/m³" in work.get_title(loc="left").replace("\n", " ")
    assert np.ma.count(work.collections[0].get_array()) == 32
    assert level.get_xlim()[1] < 1e3 * OUTER  # the slip zone, not the whole coil
    above = wf.plot.slip_work_section(half, "work", height=0.08)
    assert "no slip work" in above.get_title(loc="left")
    still = half.assign(slip_work_density=0.0 * half["slip_work_density"], tip_amplitude_at_slip=np.nan * half["z_m"])
    assert "0 % of the section" in wf.plot.slip_work_sections(still).get_title(loc="left").replace("\u00a0", " ")
    plt.close("all")


@pytest.mark.slow
def test_the_picture_in_space_shows_each_level_and_sentence(half: xr.Dataset, tmp_path: Path) -> None:
    pytest.importorskip("pyvista")
    picture = imread(wf.plot.slip_work_in_coil(half, tmp_path / "coil.png"))[..., :3]
    zone = picture[80:-100, : picture.shape[1] // 3 - 30]  # without heading and legend
    for colour in level_colours(2):
        assert (np.abs(zone - np.array(to_rgb(colour))).max(axis=2) < 0.05).sum() > 200


def test_points_without_a_grid_are_refused(half: xr.Dataset, tmp_path: Path) -> None:
    scattered = half.isel(point=slice(0, -3))
    with pytest.raises(InputError, match="do not form a grid"):
        wf.plot.slip_work_section(scattered, "level")
    with pytest.raises(InputError, match="slip work of a coil"):
        wf.plot.slip_work_in_coil(half.drop_vars("volume"), tmp_path / "coil.png")
