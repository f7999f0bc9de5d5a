"""Onset of slip of a coil whose wraps slide: of the first point, which falls with the mesh, and averaged."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.constants import g as GRAVITY
from support.paths import CONFIGS

from wroll_fem.analyses.followed_mode import main_mode
from wroll_fem.analyses.slip_damping import run_slip_damping
from wroll_fem.analyses.slip_onset import slip_onset
from wroll_fem.analyses.slip_path import JUST_BELOW
from wroll_fem.analyses.slip_structure import slipping_structure
from wroll_fem.case import SlipDampingCase, load_case
from wroll_fem.coiled_stiff.slip_start import averaged_start, start_at_points
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.mesh.point_grid import CoilGrid, coil_grid
from wroll_fem.progress import SilentProgress
from wroll_fem.typing import FloatArray

INNER, OUTER, HEIGHT, ANGLES = 0.01, 0.025, 0.3, 8
SIZE: dict[str, Any] = {"r": (INNER, OUTER), "height": HEIGHT}
COARSE = "mesh={circumferential: 8, axial: 8, grading: 100, radial: 2, radial_grading: 10}"
FINE = "mesh={circumferential: 8, axial: 12, grading: 300, radial: 3, radial_grading: 20}"


def gauss(low: float, high: float, cells: int, ratio: float) -> tuple[FloatArray, FloatArray]:
    """Two Gauss points per cell and their weights; each cell is ``ratio`` times as large as the one before."""
    ends = low + (high - low) * (ratio ** np.arange(cells + 1.0) - 1.0) / (ratio**cells - 1.0)
    middle, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
    return np.sort(np.concatenate([middle - half / 3**0.5, middle + half / 3**0.5])), np.repeat(half, 2)


def points(along: int, through: int) -> tuple[CoilGrid, FloatArray, FloatArray]:
    """Grid, coordinates (n, 3) and volumes of the points of a graded coil."""
    (z, dz), (r, dr) = gauss(0.0, HEIGHT, along, 1.2), gauss(INNER, OUTER, through, 1.5)
    theta = 2.0 * np.pi * (np.arange(ANGLES) + 0.5) / ANGLES - np.pi
    at = np.stack([grid.ravel() for grid in np.meshgrid(theta, z, r, indexing="ij")], axis=1)
    volume = 2.0 * np.pi / ANGLES * np.tile(np.outer(dz, r * dr).ravel(), ANGLES)
    grid = coil_grid(at)
    assert grid is not None
    return grid, at, volume


def test_of_uniform_stress_both_are_the_same() -> None:
    grid, at, volume = points(12, 4)
    shear = np.tile([3e5, 4e5], (len(at), 1))
    limit, change = np.full(len(at), 1.2e6), np.full(len(at), 1e5)
    for length in (1e-3, 0.03, 1.0):
        found = averaged_start(grid, volume, shear, limit, length, change=change, **SIZE)
        assert found == pytest.approx(2.0, rel=1e-12)
    assert start_at_points(shear, limit, change).min() == pytest.approx(2.0)


def test_of_a_singular_stress_the_mean_converges_and_the_first_point_does_not() -> None:
    """z^(-1/2): the mean over [0, l] is twice the value at l. Finer points come closer to the edge without end."""
    length, first, mean = 0.004, [], []
    for along in (24, 28, 32):
        grid, at, volume = points(along, 3)
        shear = np.outer(1e5 * np.sqrt(length / at[:, 1]), [0.6, 0.8])
        limit = np.full(len(at), 1e6)
        first.append(start_at_points(shear, limit).min())
        mean.append(averaged_start(grid, volume, shear, limit, length, **SIZE))
    errors = np.array(mean) / 5.0 - 1.0  # two points do not integrate the first element: as the root of its height
    assert 0.0 < errors[-1] < 0.05
    np.testing.assert_allclose(np.divide(errors[1:], errors[:-1]), 1.2**-2, rtol=0.1)
    np.testing.assert_allclose(np.divide(first[1:], first[:-1]), 1.2**-2, rtol=0.05)  # sqrt of 1.2^4


def test_the_rectangle_finds_a_peak_away_from_the_edges_and_the_weaker_radius() -> None:
    grid, at, volume = points(40, 6)
    bump = np.exp(-(((at[:, 1] - 0.05) / 0.01) ** 2) - ((at[:, 2] - 0.014) / 0.003) ** 2)
    limit, length = 1e6 * (OUTER - at[:, 2]) / (OUTER - INNER), 0.002
    found = averaged_start(grid, volume, np.outer(bump * 1e6, [1.0, 0.0]), limit, length, **SIZE)
    # 2 mm are small in the bump: nearly the value of its points
    assert found == pytest.approx(start_at_points(np.outer(bump * 1e6, [1.0, 0.0]), limit).min(), rel=0.1)
    assert start_at_points(np.zeros((3, 2)), limit[:3]).tolist() == [np.inf] * 3


@cache
def onset(*overrides: str) -> dict[str, Any]:
    case = load_case(CONFIGS / "slipping_coil.yaml", list(overrides)).expect(SlipDampingCase)
    _, at, system, start = slipping_structure(case)
    path = LoadPath(system, start)
    return slip_onset(path, at, main_mode(system, path), case)


def test_a_finer_mesh_lowers_the_first_point_alone() -> None:
    coarse, fine = onset(COARSE), onset(FINE)
    assert fine["slip_onset_g"] < 0.93 * coarse["slip_onset_g"]
    assert fine["slip_onset_averaged_g"] == pytest.approx(coarse["slip_onset_averaged_g"], rel=0.03)
    assert fine["slip_onset_averaged_g"] > fine["slip_onset_g"]
    assert fine["slip_onset_length_m"] == 1e-3
    assert "averaged over 1 mm slip starts at 0.8 g" in fine["slip_onset_statement"]


def test_a_mesh_without_points_within_the_length_has_no_mean() -> None:
    found = onset("mesh={circumferential: 8, axial: 4, radial: 1}")
    assert "slip_onset_averaged_g" not in found
    assert "elements are too large for a mean over 1 mm" in found["slip_onset_statement"]


def test_onset_is_the_first_load_of_the_path_and_follows_friction() -> None:
    case = load_case(CONFIGS / "slipping_coil.yaml", [COARSE, "excitation.amplitude_g=[0.1]"]).expect(SlipDampingCase)
    found = run_slip_damping(case, progress=SilentProgress())
    first = float(found["resonant_base_acceleration"][0]) / GRAVITY / JUST_BELOW
    assert found.attrs["slip_onset_g"] == pytest.approx(first, rel=1e-6)
    twice, plain = onset(COARSE, "winding.mu=0.96"), onset(COARSE)
    assert twice["slip_onset_averaged_g"] == pytest.approx(2.0 * plain["slip_onset_averaged_g"], rel=1e-9)
