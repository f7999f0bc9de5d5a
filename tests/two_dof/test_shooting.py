"""Newton's method of the shooting: damped from starts far away, and by way of a smoother friction law."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.errors import ConvergenceError
from wroll_fem.two_dof import TwoMasses, shooting
from wroll_fem.two_dof.shooting import _newton, periodic_orbit

FAR = (  # smoothing, capacity, frequency, amplitude of the base, start: the first full step enlarges the gap
    (428.4, 6.374, 1.0249, 1.957, (26.555, -77.66, 117.169, -99.637)),
    (2889.0, 0.3563, 0.9137, 1.107, (-0.223, 0.233, -0.06, 0.029)),
    (176.2, 6.52, 1.3938, 29.16, (3.534, 7.198, 23.525, -0.381)),
    (5960.0, 2.434, 0.8599, 8.727, (0.07, -0.004, -0.024, 0.051)),
)


@pytest.mark.parametrize(("smoothing", "capacity", "omega", "base", "start"), FAR)
def test_steps_that_enlarge_the_gap_are_halved(
    smoothing: float, capacity: float, omega: float, base: float, start: tuple[float, ...]
) -> None:
    """The orbit from far away is that from rest."""
    masses = TwoMasses(smoothing=smoothing, base_amplitude=base).preloaded(capacity)
    found, rest = (_newton(masses, omega, np.array(x), 1e-10) for x in (start, (0.0, 0.0, 0.0, 0.0)))
    assert found is not None
    np.testing.assert_allclose(found, rest, atol=1e-5 * np.abs(rest).max())


def test_where_no_start_leads_to_the_orbit_a_smoother_law_does(monkeypatch: pytest.MonkeyPatch) -> None:
    masses = TwoMasses(smoothing=100.0).preloaded(3.0)
    exact, asked = periodic_orbit(masses, 1.0), []

    def stubborn(preloaded, omega, x, tolerance):
        asked.append(preloaded.smoothing)
        return None if len(asked) <= 2 else _newton(preloaded, omega, x, tolerance)

    monkeypatch.setattr(shooting, "_newton", stubborn)
    np.testing.assert_allclose(periodic_orbit(masses, 1.0), exact, atol=1e-8 * np.abs(exact).max())
    assert asked == [100.0, 50.0, 25.0, 50.0, 100.0]
    monkeypatch.setattr(shooting, "_newton", lambda *_: None)
    with pytest.raises(ConvergenceError, match="no periodic orbit found at omega = 1 rad/s"):
        periodic_orbit(masses, 1.0)
