"""Estimates of the cantilevered mandrel: claim C13, integrals over the cross-section, thin and thick limits."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.integrate import quad

from wroll_fem.bodies.beam import Cantilever
from wroll_fem.errors import InputError
from wroll_fem.plotting.cantilever import plot_cantilever
from wroll_fem.plotting.style import save_figure

THIN = Cantilever(0.300, 0.040, 1.5e-3, distributed=70.0, tip=12.0)
THICK = Cantilever(0.300, 0.010, 6.0e-3, distributed=70.0, tip=12.0)


def test_moment_and_shear_follow_from_the_load_and_are_largest_at_the_root() -> None:
    z = np.linspace(0.0, 0.3, 31)
    for at in (0.0, 0.1, 0.25):
        moment = quad(lambda x, at=at: 70.0 * (x - at), at, 0.3)[0] + 12.0 * (0.3 - at)
        assert THIN.moment(at) == pytest.approx(moment, rel=1e-12)
        assert THIN.shear_force(at) == pytest.approx(70.0 * (0.3 - at) + 12.0, rel=1e-12)
    np.testing.assert_allclose(np.gradient(THIN.moment(z), z)[1:-1], -THIN.shear_force(z)[1:-1], rtol=1e-10)
    assert THIN.moment(z).argmax() == 0
    assert THIN.shear_force(z).argmax() == 0
    assert THIN.moment(0.3) == 0.0
    assert THIN.shear_force(0.3) == 12.0


@pytest.mark.parametrize("beam", [THIN, THICK])
def test_bending_stress_carries_the_moment_and_is_largest_along_the_load(beam: Cantilever) -> None:
    theta = np.linspace(-np.pi, np.pi, 721)
    stress = beam.bending_stress(theta, 0.0)
    assert theta[stress.argmin()] == pytest.approx(0.0, abs=1e-9)
    assert abs(theta[stress.argmax()]) == pytest.approx(np.pi)
    assert beam.bending_stress(np.pi / 2, 0.0) == pytest.approx(0.0, abs=1e-9 * stress.max())
    # moment of a stress that is linear over the section: integral of sigma y dA, y = r cos(theta)
    span = quad(lambda r: r**3, beam.inner_radius, beam.outer_radius)[0] * np.pi
    assert -stress.min() / beam.outer_radius * span == pytest.approx(beam.moment(0.0), rel=1e-10)


@pytest.mark.parametrize("beam", [THIN, THICK])
def test_shear_stress_carries_the_shear_force_and_is_largest_at_the_neutral_axis(beam: Cantilever) -> None:
    theta = np.linspace(-np.pi, np.pi, 721)
    stress = beam.shear_stress(theta, 0.0)
    assert np.abs(theta[np.abs(stress).argmax()]) == pytest.approx(np.pi / 2)
    assert beam.shear_stress(0.0, 0.0) == 0.0
    # balance of the part within +-theta: its bending stress changes along z by what the two cuts carry
    for angle in (0.4, 1.2, np.pi / 2):
        first = quad(lambda r: 2 * r**2 * np.sin(angle), beam.inner_radius, beam.outer_radius)[0]  # noqa: B023
        pulled = beam.shear_force(0.0) * first / beam.second_moment
        assert 2 * beam.wall * beam.shear_stress(angle, 0.0) == pytest.approx(pulled, rel=1e-10)


def test_thin_and_solid_limits() -> None:
    """Claim C13: 2 V/A in a thin tube (5 % in the lab's), 4 V/(3 A) in a bar; r_m and wall of the lab mandrel."""
    lab = THIN.shear_stress(np.pi / 2, 0.0) * THIN.area / THIN.shear_force(0.0)
    assert lab == pytest.approx(2.0, rel=0.05)
    thinner = Cantilever(0.3, 0.04, 1e-6, tip=1.0)
    assert thinner.shear_stress(np.pi / 2, 0.0) * thinner.area == pytest.approx(2.0, rel=1e-4)
    bar = Cantilever(0.3, 0.04, 0.04, tip=1.0)
    assert bar.shear_stress(np.pi / 2, 0.0) * bar.area == pytest.approx(4.0 / 3.0, rel=1e-12)


def test_figure_and_wrong_input(tmp_path: Path) -> None:
    open_before = plt.get_fignums()
    assert save_figure(plot_cantilever(THIN), tmp_path / "beam.png").stat().st_size > 10_000
    assert plt.get_fignums() == open_before
    with pytest.raises(InputError, match="the wall is thicker than the radius"):
        Cantilever(0.3, 0.01, 0.02)
    with pytest.raises(InputError, match="length: must be greater than 0"):
        Cantilever(-0.3, 0.01, 0.002)
