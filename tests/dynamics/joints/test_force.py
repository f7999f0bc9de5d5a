"""Forces of the user: which harmonics they may have."""

from __future__ import annotations

import pytest

from wroll_fem.dynamics.joints.force import Force
from wroll_fem.errors import InputError


def test_a_force_may_have_a_higher_harmonic_but_no_zeroth_one() -> None:
    assert Force(at=0, amplitude=1.0, harmonic=3).harmonic == 3
    for wrong in (0, -1, 1.5):
        with pytest.raises(InputError, match="harmonic"):
            Force(at=0, amplitude=1.0, harmonic=wrong)
