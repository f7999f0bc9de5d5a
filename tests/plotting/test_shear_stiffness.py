"""Figures over the shear stiffness between wraps, from made-up modes: what is read, what is told."""

import numpy as np
import pytest
import xarray as xr

from wroll_fem.bodies.mode_shapes import main_bending
from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.series import FIGURES
from wroll_fem.plotting.shear_stiffness import MODULUS, SHEAR, bending_mode, crossing
from wroll_fem.plotting.study import StudyCase


def member(bending, *, lower=(), values=None, reference=False):
    """Modes of a roll: (kind, Hz) below a bending pair at `bending` Hz, and a second bending pair above."""
    kinds = [kind for kind, _ in lower] + ["bending"] * 4
    hertz = [f for _, f in lower] + [bending] * 2 + [8 * bending] * 2
    share = np.zeros((len(kinds), 3))
    share[-4:, :2] = [[0.68, 0], [0, 0.68], [0.2, 0], [0, 0.2]]
    data = xr.Dataset(
        {
            "mode_frequency": ("mode", np.array(hertz, float)),
            "mode_kind": ("mode", np.array(kinds)),
            "effective_mass_fraction": (("mode", "component"), share),
        },
        coords={"component": ["x", "y", "z"]},
    )
    return StudyCase("case", values or {}, data, reference=reference)


def test_bending_is_the_pair_with_most_mass_wherever_it_stands():
    low = member(72.0, lower=[("torsion", 22.0), ("ovalling-2", 30.0), ("ovalling-2", 30.0), ("bending", 40.0)])
    assert main_bending(low.data["mode_kind"].values.tolist(), low.data["effective_mass_fraction"].values) == 4
    assert bending_mode(low) == (72.0, 4)  # torsion, the ovalling pair and a bending mode without mass lie below
    assert bending_mode(member(97.0)) == (97.0, 1)
    assert main_bending(["torsion"], np.zeros((1, 3))) is None
    torsion = StudyCase("loose", {}, low.data.isel(mode=[0]))
    with pytest.raises(InputError, match="the modes of loose include no bending mode; increase it"):
        bending_mode(torsion)


def test_crossing_is_interpolated_over_the_logarithm():
    x = np.array([1e4, 1e5, 1e6])
    assert crossing(x, np.array([100.0, 110.0, 130.0]), 105.0) == pytest.approx(10**4.5)
    assert np.isnan(crossing(x, np.array([100.0, 110.0, 130.0]), 140.0))
    assert np.isnan(crossing(x, np.array([100.0, 110.0, 130.0]), 90.0))


def test_curve_over_shear_stiffness_is_drawn_over_mass_alone():
    grid = [
        member(72.0, lower=[("torsion", 22.0)], values={SHEAR: 1e4}), member(97.0, values={SHEAR: 1e9}),
        member(80.0, values={SHEAR: 1e8}),
    ]  # fmt: skip
    ax = FIGURES["shear_stiffness"]([*grid, member(50.0, reference=True)])
    np.testing.assert_allclose(ax.lines[0].get_ydata(), [1.44, 1.60, 1.94])
    np.testing.assert_allclose(ax.lines[0].get_xdata(), [1e4, 1e8, 1e9])
    hollow = next(line for line in ax.lines if line.get_label() == "other modes are lower")
    np.testing.assert_allclose(hollow.get_xdata(), [1e4])
    assert "1.44 and 1.94 times mass alone" in ax.get_title(loc="left").replace("\n", " ")
    with pytest.raises(InputError, match="a curve needs at least two finished cases"):
        FIGURES["shear_stiffness"]([grid[0], member(50.0, reference=True)])
    style.plt.close(ax.figure)
    with pytest.raises(InputError, match="needs the reference case of the coil as mass without stiffness"):
        FIGURES["shear_stiffness"](grid)


def test_band_states_where_the_roll_reaches_the_frequency_of_the_mandrel():
    members = [
        member(low + (f if G > 1e5 else 0.0), values={SHEAR: G, MODULUS: E})
        for E, low, f in ((2.5e9, 140.0, 30.0), (4e9, 142.0, 48.0))
        for G in (1e4, 1e6)
    ]
    ax = FIGURES["shear_stiffness_band"]([*members, member(153.0, reference=True)])
    title = ax.get_title(loc="left").replace("\n", " ").replace("\u00a0", " ")
    assert "gains 30 Hz and 48 Hz" in title
    assert style.engineering(crossing(np.array([1e4, 1e6]), np.array([140.0, 170.0]), 153.0), "Pa") in title
    labels = [line.get_label() for line in ax.lines]
    assert "$E$ = 2.5 GPa" in labels
    assert "mandrel alone, 153.0 Hz" in labels
    assert "other modes are lower" not in labels
    style.plt.close(ax.figure)
