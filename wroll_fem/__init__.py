"""Dynamics of wound rolls: a linear structure with a frictional interface."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from .case import Case, example_case, load_case

__all__ = ["Case", "__version__", "example_case", "load_case"]


def __getattr__(name: str) -> Any:
    """Load the case models on first use, so that `import wroll_fem` stays instant."""
    if name in ("Case", "example_case", "load_case"):
        from . import case

        return getattr(case, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
