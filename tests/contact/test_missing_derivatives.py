"""A law without derivatives of its own gets central differences of its update; a law without update is refused."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from wroll_fem.contact import penalty_coulomb, rate_coulomb
from wroll_fem.contact.laws import DIFFERENCE, _differences, _function
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.errors import InputError

GAMMA = 2e-6


def test_differences_are_the_derivatives_of_the_update(monkeypatch: pytest.MonkeyPatch) -> None:
    """Penalty law, sliding obliquely; and a function that depends on the increments too."""
    names = _differences.__globals__
    monkeypatch.setitem(names, "H", DIFFERENCE)
    laws = SimpleNamespace(gamma=np.array([GAMMA]), mu=np.array([0.3]))
    monkeypatch.setitem(names, "UPDATE", penalty_coulomb.slip_update)
    at = (0, 1.7 * GAMMA, -1.1 * GAMMA, 0.0, 0.0, 1e5, laws, 1e-4)
    np.testing.assert_allclose(_differences(*at), penalty_coulomb.slip_derivatives(*at), atol=1e-6)

    def update(k, trial_h, trial_z, dg_h, dg_z, p, laws, dt):  # every derivative is another number
        return (
            2.0 * trial_h + 3.0 * trial_z + 5.0 * dg_h + 7.0 * dg_z,
            11.0 * trial_h + 13.0 * trial_z + 17.0 * (dg_h) + 19.0 * dg_z,
            True,
        )

    monkeypatch.setitem(names, "UPDATE", update)
    np.testing.assert_allclose(_differences(*at), [2.0, 3.0, 11.0, 13.0, 5.0, 7.0, 17.0, 19.0], rtol=1e-6)


def test_functions_of_a_law_are_found_in_its_class_or_module() -> None:
    assert _function(PenaltyCoulomb, "slip_derivatives") is penalty_coulomb.slip_derivatives
    assert _function(rate_coulomb.RateCoulomb, "slip_update") is rate_coulomb.slip_update
    bare = type("Bare", (), {"__module__": __name__, "name": "bare"})
    with pytest.raises(InputError, match="'bare' has no function slip_update"):
        _function(bare, "slip_update")
    own = type(
        "Own", (), {"__module__": __name__, "name": "own", "slip_update": staticmethod(penalty_coulomb.slip_update)}
    )
    assert _function(own, "slip_derivatives").__name__ == "differences"
