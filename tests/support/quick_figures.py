"""Figures without the arrangement of their axes and with few pixels, which take most of the time of a figure."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from matplotlib.layout_engine import ConstrainedLayoutEngine

from wroll_fem.plotting import style

COARSE = 50
"""Dots per inch."""


@contextmanager
def quick_figures() -> Iterator[None]:
    """Leave axes where they are made and write few pixels, for tests that count or compare figures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ConstrainedLayoutEngine, "execute", lambda self, figure: None)
        patch.setattr(style, "DPI", COARSE)
        yield
