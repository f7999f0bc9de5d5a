"""Drawings without the arrangement of their axes, which takes half of the time of a drawing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from matplotlib.layout_engine import ConstrainedLayoutEngine


@contextmanager
def plain_layout() -> Iterator[None]:
    """Leave axes where they are made. For tests that compare drawings with each other, or count them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ConstrainedLayoutEngine, "execute", lambda self, figure: None)
        yield
