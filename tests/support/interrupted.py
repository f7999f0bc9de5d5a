"""Time integrations that are interrupted."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from wroll_fem.dynamics.time_stepping.stepper import Stepper


@contextmanager
def interrupted(monkeypatch: pytest.MonkeyPatch, kind: type[Stepper], call: int) -> Iterator[None]:
    """Within this context the steppers of a ``kind`` are interrupted when they advance for the ``call``-th time."""
    advance, calls = kind.advance, []

    def stopped(self: Stepper, *arguments: object) -> np.ndarray:
        calls.append(1)
        if len(calls) == call:
            raise KeyboardInterrupt
        return advance(self, *arguments)  # type: ignore[arg-type]

    with monkeypatch.context() as patch:
        patch.setattr(kind, "advance", stopped)
        with pytest.raises(KeyboardInterrupt):
            yield
