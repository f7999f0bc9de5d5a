"""Figure of a grid over preload, friction and level: every case has its point, and the sentence names the best."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from wroll_fem.errors import InputError
from wroll_fem.plotting.series import FIGURES
from wroll_fem.plotting.study import StudyCase
from wroll_fem.plotting.style import save_figure

PRESSURES, COEFFICIENTS, LEVELS = (1e5, 2e4, 5e4), (0.45, 0.15), (5.0, 2.5)


def member(p: float, mu: float, level: float | None) -> StudyCase:
    values = {"preload.pressure": p, "contact.friction.mu": mu} | ({"excitation.amplitude": level} if level else {})
    zeta = np.nan if (p, mu) == (2e4, 0.15) else 1e-6 * p * mu * (level or 1.0)
    attrs = {"f_n_hz": 100.0 + 1e-4 * p + mu, "zeta": zeta, "peak_transmissibility": 9.0, "skewness": 0.0}
    return StudyCase(f"{p}{mu}{level}", values, xr.Dataset(attrs=attrs))


def test_every_case_has_its_point_in_the_panel_of_its_level(tmp_path: Path) -> None:
    members = [member(*which) for which in itertools.product(PRESSURES, COEFFICIENTS, LEVELS)]
    first = FIGURES["damping_over_preload"](members)
    panels = np.array(first.figure.axes).reshape(2, 2)
    for column, level in zip(panels.T, sorted(LEVELS), strict=True):
        assert column[0].get_title(loc="left") == f"base at {level:g} m/s² (0-peak)"
        for k, mu in enumerate(sorted(COEFFICIENTS)):
            given = [member(p, mu, level) for p in sorted(PRESSURES)]
            x = [1e-3 * m.values["preload.pressure"] for m in given]
            for ax, y in zip(column, ("zeta", "f_n_hz"), strict=True):
                scale = 100.0 if y == "zeta" else 1.0
                expected = np.column_stack([x, [scale * m.data.attrs[y] for m in given]])
                np.testing.assert_allclose(ax.lines[k].get_xydata(), expected)
                assert ax.lines[k].get_label() == f"{mu:g}"
                low, high = ax.get_ylim()
                seen = expected[np.isfinite(expected[:, 1]), 1]
                assert low <= seen.min() <= seen.max() <= high
    assert first.get_ylim()[0] == 0.0
    best = f"Largest damping, {1e-4 * 1e5 * 0.45 * 5:.2f} %, at 100 kPa, a friction coefficient of 0.45, 5 m/s²"
    assert first.figure.get_suptitle() == best  # type: ignore[union-attr]
    assert save_figure(first, tmp_path / "grid.png").stat().st_size > 10_000


def test_one_level_is_one_column_and_other_keys_are_refused() -> None:
    first = FIGURES["damping_over_preload"]([member(p, mu, None) for p in PRESSURES for mu in COEFFICIENTS])
    assert len(first.figure.axes) == 2
    with pytest.raises(InputError, match=r"values of preload\.pressure and contact\.friction\.mu"):
        FIGURES["damping_over_preload"]([StudyCase("a", {"preload.pressure": 1e4}, xr.Dataset())])
