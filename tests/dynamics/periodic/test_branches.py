"""Branches of a response curve that turn at an internal resonance."""

from __future__ import annotations

import numpy as np
import pytest
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.curve_reading import other_mode_remark
from wroll_fem.dynamics.periodic.branches import _end_of_way_out
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.numerics.continuation import CurvePoint


def branch(places: list[float], height: float = 1.0) -> list[CurvePoint]:
    """Points of a smooth curve at scaled frequencies; ``height`` scales the motion after the largest of them."""
    turn = int(np.argmax(np.abs(places)))
    size = [height if k > turn else 1.0 for k in range(len(places))]
    return [CurvePoint(np.array([s * p * p, s * np.cos(p), p]), np.zeros(3), 1, True)
            for s, p in zip(size, places, strict=True)]  # fmt: skip


@pytest.mark.parametrize("forward", [1.0, -1.0])
def test_the_way_back_along_a_branch_is_left_out(forward: float) -> None:
    there, back = [1.0, 1.3, 1.6, 1.9, 2.0], [1.8, 1.4, 1.02, 0.9]
    assert _end_of_way_out(branch([forward * p for p in there + back])) == len(there)


def test_another_branch_is_no_way_back() -> None:
    there, back = [1.0, 1.3, 1.6, 1.9, 2.0], [1.8, 1.4, 1.02, 0.9]
    assert _end_of_way_out(branch(there + back, height=1.5)) == len(there + back)
    assert _end_of_way_out(branch([*there, 1.8, 1.7])) == 7  # a fold that ends between
    assert _end_of_way_out(branch(there)) == 5


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
def test_a_curve_passes_a_narrow_internal_resonance() -> None:
    """With some orders of summation the curve of this roll turned back at 153.6 Hz and ended below the band."""
    mesh = "mesh={circumferential: 12, axial: 6, grading: 8}"
    band = ["excitation.f_start=145", "excitation.f_end=165"]
    case = wf.load_case(CONFIGS / "lab_harmonic.yaml", [mesh, *band, "preload.pressure=1e5", "contact.friction.mu=0.4"])
    assert wf.run(case, progress=False).attrs["f_n_hz"] == pytest.approx(156.15, rel=2e-3)


def condensation(eigenvalues: list[float], base: list[float], tip: list[float]) -> Condensation:
    """Modes of one block without interfaces."""
    values, count = (2.0 * np.pi * np.array(eigenvalues)) ** 2, len(base)
    return Condensation(
        values, np.array([0, count]), [], [], np.ones((1, 1, 3, 1)), np.array(base), np.array(tip),
        np.zeros((0, count)), np.zeros(0), exact=True,
    )  # fmt: skip


def test_a_mode_that_takes_most_of_the_mass_is_named() -> None:
    """The base drives the coil at 20 Hz; the tip moves with the mandrel, at 80 Hz."""
    modes = condensation([20.0, 80.0], [9.0, 5.0], [0.01, 0.3])
    told = other_mode_remark(modes, (60.0, 90.0))
    assert told.startswith("the base excites a mode at 20 Hz most (76 % of the mass that it moves)")
    assert "in the mode at 80 Hz" in told
    assert "follow the mode at 80 Hz" in told
    assert "follow the mode at 20 Hz" in other_mode_remark(modes, (15.0, 30.0))
    assert "follow the mode at 80 Hz" in other_mode_remark(modes, (40.0, 60.0))  # no mode there
    assert other_mode_remark(condensation([20.0, 80.0], [9.0, 5.0], [0.3, 0.01]), (15.0, 30.0)) == ""
