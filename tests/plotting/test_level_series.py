"""Figure of damping over level, from made-up paths: lines, order, sentence."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from scipy.constants import g as GRAVITY

from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.series import FIGURES
from wroll_fem.plotting.study import StudyCase


def member(mu: float, damping: float) -> StudyCase:
    """Damping that rises from 2 % to ``damping`` at 10 g; frequency that falls from 100 to 90 Hz."""
    g, rise = np.array([2.0, 6.0, 12.0]), np.array([0.0, 0.4, 1.0])
    data = xr.Dataset(
        {
            "resonant_base_acceleration": ("tip_amplitude", g * GRAVITY),
            "modal_damping": ("tip_amplitude", 0.02 + (damping - 0.02) * rise),
            "material_modal_damping": ("tip_amplitude", np.full(3, 0.02)),
            "resonance_frequency": ("tip_amplitude", 100.0 - 10.0 * rise),
            "damping_at_level": ("amplitude_g", [0.02, damping]),
            "frequency_at_level": ("amplitude_g", [100.0, 91.0]),
        },
        coords={"tip_amplitude": [1e-4, 2e-4, 3e-4], "amplitude_g": [1.0, 10.0]},
        attrs={"f_stuck_hz": 100.0},
    )
    return StudyCase(f"mu {mu}", {"winding.mu": mu, "output.figures": False}, data)


def said(ax: Axes) -> str:
    return ax.get_title(loc="left").replace("\n", " ").replace("\u00a0", " ")


def test_each_case_has_a_line_and_its_linear_prediction() -> None:
    ax = FIGURES["damping_over_level"]([member(0.5, 0.05), member(0.25, 0.08)])
    figure = style.figure_of(ax)
    damping, frequency = figure.axes
    np.testing.assert_allclose(damping.lines[0].get_ydata(), [2.0, 2.0, 4.4, 8.0])  # mu 0.25 is the first
    np.testing.assert_allclose(damping.lines[0].get_xdata(), [0.0, 2.0, 6.0, 12.0])
    np.testing.assert_allclose(damping.lines[1].get_ydata(), [2.0, 8.0])
    np.testing.assert_allclose(damping.lines[2].get_ydata(), [2.0, 2.0])
    np.testing.assert_allclose(frequency.lines[2].get_ydata(), [100.0, 100.0])
    title = said(ax)
    assert title == "At 10 g the damping ratio is 5 % (friction coefficient 0.5) to 8 % (friction coefficient 0.25)"
    assert (damping.get_ylabel(), frequency.get_xlabel()) == ("Damping ratio (%)", "Base acceleration (g, 0-peak)")


def test_cases_without_a_result_at_the_highest_level_are_left_out_of_the_sentence() -> None:
    known = FIGURES["damping_over_level"]([member(0.5, 0.05), member(0.25, np.nan)])
    assert said(known) == "At 10 g the damping ratio is 5 % (friction coefficient 0.5)"
    unknown = FIGURES["damping_over_level"]([member(0.5, np.nan)])
    assert said(unknown) == "No case has a result at 10 g"


def test_other_results_are_refused() -> None:
    with pytest.raises(InputError, match="figure of damping over level"):
        FIGURES["damping_over_level"]([StudyCase("sweep", {"winding.mu": 0.5}, xr.Dataset())])
