"""Newton's method in all modes: motions of the full model, without a reduced model being solved."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from support.periodic import small_roll, trained_roll

from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.response import HarmonicCurve, response_curve
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.training import correction as corrections_module
from wroll_fem.dynamics.training import full_motions as newton
from wroll_fem.dynamics.training.correction import Correction, correction, corrections
from wroll_fem.dynamics.training.full_motions import full_motions
from wroll_fem.dynamics.training.structure import Structure


def checked(points: HarmonicCurve) -> list[Correction]:
    along = [points.direction(k)[None] for k in range(len(points.frequencies))]
    return corrections(points.balance, points.coefficients, points.frequencies, along)


@pytest.fixture(scope="module")
def rough() -> tuple[Structure, HarmonicCurve]:
    """Points of the curve through the resonance in the first basis, whose motions miss up to one percent."""
    system, preload, condensation = small_roll(12, 4)
    structure = Structure.of(condensation, preload, system.laws, Sampling(3, 64), 8)
    curve = response_curve(structure.contact(structure.first_model()), amplitude=5.0, frequencies=(140.0, 165.0))
    return structure, curve.take(list(range(0, len(curve.frequencies), 3)))


def test_motions_are_those_of_the_full_model(
    rough: tuple[Structure, HarmonicCurve], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a model of all modes they need a correction of second order, in which both balances agree."""
    structure, points = rough
    found = checked(points)
    assert max(one.energy for one in found) > 5e-3
    monkeypatch.setattr(newton, "LAST", 1e-4)
    motions = full_motions(structure, points, found, checked, 1e-6)
    assert motions is not None
    assert len(motions) == len(points.frequencies)
    c = structure.condensation
    everything = structure.contact(ReducedModel.on(c, np.eye(len(c.eigenvalues)), c.eigenvalues))
    left = checked(points.carried(everything, motions))
    assert max(one.energy for one in left) < 2e-5


def test_motions_that_do_not_converge_are_left_out(rough: tuple[Structure, HarmonicCurve]) -> None:
    structure, points = rough
    found = checked(points)
    lost = SimpleNamespace(energy=np.inf, modal=np.full_like(found[0].modal, np.nan))
    assert full_motions(structure, points, [lost] * len(found), checked, 1e-3) is None
    rest = full_motions(structure, points, [lost, *found[1:]], checked, 1e-3)
    assert rest is not None
    assert len(rest) == len(found) - 1
    assert np.isfinite(rest).all()


def test_corrections_together_are_those_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    curve = trained_roll(12, 4).curve
    points = curve.take(list(range(0, len(curve.frequencies), 4)))
    monkeypatch.setattr(corrections_module, "TOGETHER", 3)
    for k, one in enumerate(checked(points)):
        alone = correction(points.balance, points.coefficients[k], points.frequencies[k], points.direction(k)[None])
        np.testing.assert_allclose(one.modal, alone.modal, rtol=0.0, atol=1e-4 * np.abs(alone.modal).max())
        assert one.energy == pytest.approx(alone.energy, rel=1e-4)
