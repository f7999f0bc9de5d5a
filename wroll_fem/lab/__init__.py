"""Laboratory: evaluation of measurements, one kind per file.

`wf.lab.evaluate("transmissibility", files, **settings)` returns a `LabResult`; `wroll lab KIND FILE... --out DIR`
writes it into a folder.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wroll_fem.lab.evaluation import evaluate
    from wroll_fem.lab.kinds import KINDS, find_kind
    from wroll_fem.lab.result import LabResult

_HOMES = {"KINDS": "kinds", "LabResult": "result", "evaluate": "evaluation", "find_kind": "kinds"}
"""Public name -> module, imported on first use."""

__all__ = ["KINDS", "LabResult", "evaluate", "find_kind"]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it has {', '.join(__all__)}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
