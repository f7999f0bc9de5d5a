"""Public names of the figures."""

from __future__ import annotations

import pytest

from wroll_fem import plot as figures
from wroll_fem import plotting
from wroll_fem.plotting.series import FIGURES


def test_every_figure_has_one_name_and_the_old_spellings_work():
    assert set(FIGURES) <= set(figures.__all__)
    assert all(getattr(figures, name) is draw for name, draw in FIGURES.items())
    for old in ("plot_slip_map", "plot_comparison", "plot_mode_shapes", "plot_two_dof_readings", "write_slip_vtu"):
        assert getattr(plotting, old) is getattr(figures, old) is getattr(figures, old.removeprefix("plot_"))
    assert plotting.save_figure is figures.save
    assert figures.family is figures.curves
    assert figures.frequency_over_shear_stiffness is figures.shear_stiffness
    with pytest.raises(AttributeError, match="no attribute 'plot_nothing'; it has backbone, comparison"):
        figures.plot_nothing  # noqa: B018
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        plotting.nothing  # noqa: B018
