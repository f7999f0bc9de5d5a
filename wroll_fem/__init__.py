"""Dynamics of wound rolls: a linear structure with a frictional interface.

    import wroll_fem as wf

    case = wf.load_case("configs/lab_dwell.yaml", ["preload.pressure=3.0e4"])
    result = wf.run(case)  # an xarray.Dataset with units
    wf.plot.slip_map(result)

docs/api.md tells which analysis gives which variables and figures.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from wroll_fem import two_dof
    from wroll_fem.analyses import case_warnings, estimate
    from wroll_fem.analyses.slip_model import SlipModel
    from wroll_fem.api import (
        CaseWarning,
        batch_table,
        case_of,
        load_result,
        load_series,
        run,
        run_grid,
        run_series,
        slip_model,
        summarise,
        transmissibility,
    )
    from wroll_fem.case import Case, example_case, load_case
    from wroll_fem.errors import ConvergenceError, InputError, WrollError
    from wroll_fem.jobs.grid import load_grid
    from wroll_fem.plotting import names as plot
    from wroll_fem.plotting.study import SeriesMember
    from wroll_fem.report import write_report
    from wroll_fem.results.dataset import save_dataset as save_result
    from wroll_fem.signals import estimators
    from wroll_fem.signals.damping import half_power

_WHERE = {
    "Case": "case", "example_case": "case", "load_case": "case",
    "run": "api", "load_result": "api", "summarise": "api", "case_of": "api",
    "save_result": "results.dataset:save_dataset",
    "case_warnings": "analyses", "estimate": "analyses", "CaseWarning": "api",
    "run_series": "api", "run_grid": "api", "load_grid": "jobs.grid", "load_series": "api", "batch_table": "api",
    "SeriesMember": "plotting.study", "write_report": "report",
    "slip_model": "api", "SlipModel": "analyses.slip_model",
    "transmissibility": "api", "half_power": "signals.damping", "estimators": "signals.estimators:",
    "plot": "plotting.names:", "two_dof": "two_dof:",
    "ConvergenceError": "errors", "InputError": "errors", "WrollError": "errors",
}  # fmt: skip
"""Public name -> module that has it, "module:other name" where the name there is another, "module:" for a module."""

__all__ = [
    "Case", "CaseWarning", "ConvergenceError", "InputError", "SeriesMember", "SlipModel", "WrollError", "__version__",
    "batch_table", "case_of", "case_warnings", "estimate", "estimators", "example_case", "half_power", "load_case",
    "load_grid", "load_result", "load_series", "plot", "run", "run_grid", "run_series", "save_result", "slip_model",
    "summarise", "transmissibility", "two_dof", "write_report",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Load a public name on first use, so that `import wroll_fem` stays instant."""
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, colon, other = _WHERE[name].partition(":")
    found = import_module(f".{module}", __name__)
    value = found if colon and not other else getattr(found, other or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
