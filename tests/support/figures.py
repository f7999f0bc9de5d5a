"""Pytest plugin that prints the numbers every passed comparison of a test saw: ``-p support.figures -s``.

It needs ``-o enable_assertion_pass_hook=true`` and a fresh ``PYTHONPYCACHEPREFIX``, since pytest caches its asserts.
"""

from __future__ import annotations

import sys
from collections.abc import Generator
from pathlib import Path
from typing import Any

import numpy as np
import pytest


def pytest_assertion_pass(item: pytest.Item, lineno: int, orig: str, expl: str) -> None:
    """Print an assertion with the values that it compared."""
    lines = [line.strip() for line in expl.split("comparison failed")[0].splitlines()]
    shown = " ".join(line for line in lines if not line.startswith("+"))
    print(f"    {item.path.name}:{lineno}  {orig}   [{shown[:300]}]")  # noqa: T201


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, Any, Any]:
    """Print the largest difference of every `assert_allclose`."""
    print(f"\n{item.nodeid}")  # noqa: T201
    close = np.testing.assert_allclose

    def reported(actual: Any, desired: Any, rtol: float = 1e-7, atol: float = 0, **options: Any) -> None:
        close(actual, desired, rtol, atol, **options)
        apart = float(np.max(np.abs(np.asarray(actual) - np.asarray(desired)), initial=0.0))
        size = float(np.max(np.abs(np.asarray(desired)), initial=0.0))
        caller = sys._getframe(1)
        place = f"{Path(caller.f_code.co_filename).name}:{caller.f_lineno}"
        print(f"    {place}  allclose: {apart:.2e} apart, largest {size:.4g}; rtol {rtol:g}, atol {atol:g}")  # noqa: T201

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(np.testing, "assert_allclose", reported)
        return (yield)
