"""Slip on the cylinder: what is drawn, and where."""

from __future__ import annotations

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.image import imread
from support import synthetic_roll

from wroll_fem import plot as figures
from wroll_fem.plotting import cylinder


def test_slip_on_the_cylinder_is_drawn_grey_where_it_stuck(tmp_path):
    picture = imread(figures.slip_on_cylinder(synthetic_roll.contact_points(half=True), tmp_path / "c.png"))
    assert picture.shape[1] == 1080
    coloured = np.ptp(picture[..., :3], axis=2) > 0.15
    assert 0.02 < coloured[: int(0.85 * len(coloured))].mean() < 0.3  # slip near the root of each view, the rest grey


@pytest.mark.parametrize("azimuth", [0.0, 90.0, 45.0, -175.0])
def test_cells_of_the_cylinder_lie_where_the_viewer_sees_them(azimuth, monkeypatch):
    """Each cell's colour is its number; its corners are those of the tube, projected by the viewer's axes."""
    monkeypatch.setattr(cylinder, "AMBIENT", 1.0)  # colours as given
    monkeypatch.setattr(cylinder, "INSIDE", 1.0)
    radius, elevation, n_z, n_theta = 0.04, 0.25, 6, 72
    height = np.linspace(0.0, 0.3, n_z + 1)
    row, column = np.meshgrid(np.arange(n_z), np.arange(n_theta), indexing="ij")
    colours = np.stack([row / n_z, column / n_theta, np.zeros_like(row)], axis=-1)
    _, ax = plt.subplots()
    cylinder.draw_tube(ax, colours, height, radius, np.radians(azimuth), elevation)
    level = np.cos(elevation) * np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))])
    towards = np.append(level, np.sin(elevation))
    right = np.cross([0.0, 0.0, 1.0], towards) / np.cos(elevation)
    up = np.cross(towards, right)
    seen = set()
    for mesh, near in zip(sorted(ax.collections, key=lambda mesh: mesh.zorder), (False, True), strict=True):
        found = mesh.get_facecolor()[:, :2] * [n_z, n_theta]
        theta = (found[:, 1] + 0.5) / n_theta * 2 * np.pi - np.pi
        z = height[np.rint(found[:, 0]).astype(int)] + 0.5 * height[1]
        points = np.stack([radius * np.cos(theta), radius * np.sin(theta), z], axis=1)
        corners = mesh.get_coordinates()
        centres = 0.25 * (corners[1:, 1:] + corners[:-1, 1:] + corners[1:, :-1] + corners[:-1, :-1]).reshape(-1, 2)
        np.testing.assert_allclose(centres, points @ np.array([right, up]).T, atol=2e-3 * radius)
        assert np.all((points @ towards - z * towards[2] > 0.0) == near)  # the far side lies below
        seen |= set(map(tuple, np.rint(found).astype(int).tolist()))
    assert len(seen) == n_z * n_theta  # every cell, once
