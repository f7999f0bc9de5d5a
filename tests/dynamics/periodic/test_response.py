"""Response curves of small systems: folds, gaps at unbounded resonances, refused input."""

from __future__ import annotations

import numpy as np
import pytest
from support.exact_systems import coulomb_oscillator, lifting_mass
from support.periodic import TURN, complete

from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.response import solve_response
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.numerics.continuation import StepControl


@pytest.mark.parametrize("usual", [4.0, 7.0])
def test_curve_passes_its_folds_and_every_point_balances(usual: float) -> None:
    """Opening leans the curve over by 0.9 Hz: three motions between the folds, the middle one unstable."""
    system = lifting_mass()
    model, preload = complete(system)
    curve = solve_response(
        model, preload, system.laws, amplitude=2.0, frequencies=(14.0, 30.0), samples=256,
        control=StepControl(usual=usual),
    )  # fmt: skip
    assert -np.diff(curve.frequencies)[np.diff(curve.frequencies) < 0.0].sum() == pytest.approx(TURN * 0.901, rel=0.01)
    assert np.abs(curve.transmissibility).max() == pytest.approx(22.81, rel=2e-3)
    assert curve.folds == 2
    assert np.any(np.diff(curve.frequencies) < 0.0)
    turning = np.diff(curve.frequencies) < 0.0
    signs = []
    for q, w in zip(curve.coefficients, curve.frequencies, strict=True):
        matrix, _ = curve.balance.jacobian(q, w, curve.balance.residual(q, w)[1], threshold=0.0)
        signs.append(np.linalg.slogdet(matrix)[0])
    np.testing.assert_array_equal(curve.stable, np.array(signs) == signs[0])
    assert 0 < np.count_nonzero(~curve.stable) < 0.5 * len(curve.stable)
    for q, w in zip(curve.coefficients[::7], curve.frequencies[::7], strict=True):
        residual, _ = curve.balance.residual(q, w)
        assert np.linalg.norm(residual) < 1e-4 * np.linalg.norm(curve.balance.load())
    middle = 0.5 * (curve.frequencies[1:][turning].min() + curve.frequencies[1:][turning].max())
    crossings = np.diff(np.sign(curve.frequencies - middle)) != 0
    assert np.count_nonzero(crossings) == 3


def test_an_unbounded_resonance_leaves_a_gap() -> None:
    """A force above 4/pi of the friction force drives the Coulomb oscillator without bound (Den Hartog).

    Its resonance is that of the frictionless oscillator; both flanks are found, up to the same growth.
    """
    system = coulomb_oscillator(gamma=1e-5)
    model, preload = complete(system)
    keywords = {"amplitude": 5.0, "frequencies": (10.0, 25.0), "samples": 512}
    curve = solve_response(model, preload, system.laws, **keywords)
    assert curve.gap is not None
    low, high = curve.gap
    assert low < 100.0 < high
    assert high - low < 1.0
    assert curve.frequencies[[0, -1]] == pytest.approx([TURN * 10.0, TURN * 25.0], rel=1e-9)
    size = np.abs(curve.transmissibility)
    assert 500.0 < size.max() < 1000.0
    # Den Hartog: far up, friction takes the constant 4 mu F / pi out of the force in quadrature
    force, drag = 5.0, 4.0 / np.pi * 3.0
    upper = int(np.argmax(curve.frequencies > high - 1e-9))
    w = curve.frequencies[upper]
    tip = np.sqrt(force**2 - drag**2) / abs(100.0**2 - w**2)
    assert w**2 * tip / force == pytest.approx(size[upper], rel=0.01)


def test_a_bounded_resonance_has_no_gap() -> None:
    """Below 4/pi of the friction force friction bounds the motion."""
    system = coulomb_oscillator(gamma=1e-5)
    model, preload = complete(system)
    curve = solve_response(model, preload, system.laws, amplitude=3.5, frequencies=(10.0, 90.0))
    assert curve.gap is None
    assert np.abs(curve.transmissibility).max() < 500.0


def test_wrong_bands_and_samples_are_refused() -> None:
    model, preload = complete(coulomb_oscillator())
    laws = coulomb_oscillator().laws
    with pytest.raises(InputError, match="not positive and increasing"):
        solve_response(model, preload, laws, amplitude=1.0, frequencies=(20.0, 10.0))
    with pytest.raises(InputError, match="amplitude"):
        solve_response(model, preload, laws, amplitude=0.0, frequencies=(10.0, 20.0))
    with pytest.raises(InputError, match="samples"):
        Sampling(16, 64)


def test_a_body_that_nothing_holds_is_named() -> None:
    """A mass without a spring slides on the ground: any mean displacement solves the equations, which are singular."""
    system = coulomb_oscillator(stiffness=0.0, gamma=1e-5)
    model, preload = complete(system)
    with pytest.raises(ConvergenceError, match=r"after 1 iterations; .*mean displacement is undetermined"):
        solve_response(model, preload, system.laws, amplitude=5.0, frequencies=(10.0, 25.0))
