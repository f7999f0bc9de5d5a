"""Dynamics of wound rolls: linear structures with frictional interfaces.

    import wroll_fem as wf

    case = wf.load_case("configs/lab_dwell.yaml", ["preload.pressure=3.0e4"])
    result = wf.run(case)  # an xarray.Dataset with units
    wf.plot.slip_map(result)

docs/api.md lists the variables and figures of each analysis.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from wroll_fem.blas import select_kernels

__version__ = "0.2.0"

select_kernels()  # before numpy is imported

if TYPE_CHECKING:
    from wroll_fem import lab, signals, two_dof
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
    from wroll_fem.case.coil import Coil
    from wroll_fem.case.contact import Contact, Normal, PenaltyFriction, RateFriction, RateTable, SmoothedFriction
    from wroll_fem.case.design_map import DesignMap
    from wroll_fem.case.excitation import ChirpExcitation as Chirp
    from wroll_fem.case.excitation import DwellExcitation as Dwell
    from wroll_fem.case.excitation import FileExcitation as RecordedMotion
    from wroll_fem.case.excitation import HalfSineExcitation as HalfSine
    from wroll_fem.case.excitation import Psd
    from wroll_fem.case.excitation import RandomExcitation as Random
    from wroll_fem.case.excitation import SawtoothExcitation as Sawtooth
    from wroll_fem.case.excitation import SineExcitation as Sine
    from wroll_fem.case.excitation import SrsExcitation as ShockSpectrum
    from wroll_fem.case.excitation import TrapezoidExcitation as Trapezoid
    from wroll_fem.case.geometry import Geometry
    from wroll_fem.case.harmonic import Backbone, Harmonic
    from wroll_fem.case.integrator import Integrator
    from wroll_fem.case.mandrel import Mandrel
    from wroll_fem.case.material import IsotropicMaterial, OrthotropicMaterial
    from wroll_fem.case.mesh import Mesh
    from wroll_fem.case.modal import Modal
    from wroll_fem.case.output import Output
    from wroll_fem.case.preload import Preload
    from wroll_fem.case.probes import ProbePoint
    from wroll_fem.case.solver import Solver
    from wroll_fem.case.winding import Winding
    from wroll_fem.contact.interface import Interface, NormalPenalty, PenaltyCoulomb, RateCoulomb, SmoothedCoulomb
    from wroll_fem.contact.law import FrictionLaw
    from wroll_fem.contact.law import Parameter as LawParameter
    from wroll_fem.contact.registry import register_law
    from wroll_fem.dynamics import joints
    from wroll_fem.dynamics.system.system import System
    from wroll_fem.errors import ConvergenceError, InputError, WrollError
    from wroll_fem.jobs.grid import load_grid
    from wroll_fem.own_structure import OwnStructure, structure
    from wroll_fem.plotting import names as plot
    from wroll_fem.plotting.study import StudyCase
    from wroll_fem.report import write_report
    from wroll_fem.result import Result
    from wroll_fem.results.dataset import save_dataset as save_result
    from wroll_fem.roll import Roll
    from wroll_fem.signals import estimators
    from wroll_fem.signals.damping import half_power

_HOMES = {
    "roll": "Roll",
    "own_structure": "OwnStructure structure",
    "result": "Result",
    "api": "run load_result summarise case_of run_series run_grid load_series batch_table slip_model transmissibility "
    "CaseWarning",
    "case": "Case example_case load_case",
    "case.geometry": "Geometry",
    "case.mandrel": "Mandrel",
    "case.coil": "Coil",
    "case.material": "IsotropicMaterial OrthotropicMaterial",
    "case.contact": "Contact Normal PenaltyFriction RateFriction RateTable SmoothedFriction",
    "case.preload": "Preload",
    "case.probes": "ProbePoint",
    "case.winding": "Winding",
    "case.excitation": "Chirp=ChirpExcitation Dwell=DwellExcitation HalfSine=HalfSineExcitation Psd "
    "Random=RandomExcitation RecordedMotion=FileExcitation Sawtooth=SawtoothExcitation ShockSpectrum=SrsExcitation "
    "Sine=SineExcitation Trapezoid=TrapezoidExcitation",
    "case.integrator": "Integrator",
    "case.solver": "Solver",
    "case.mesh": "Mesh",
    "case.modal": "Modal",
    "case.harmonic": "Harmonic Backbone",
    "case.design_map": "DesignMap",
    "case.output": "Output",
    "dynamics.system.system": "System",
    "contact.law": "FrictionLaw LawParameter=Parameter",
    "contact.registry": "register_law",
    "contact.interface": "Interface NormalPenalty PenaltyCoulomb RateCoulomb SmoothedCoulomb",
    "analyses": "case_warnings estimate",
    "analyses.slip_model": "SlipModel",
    "jobs.grid": "load_grid",
    "plotting.study": "StudyCase SeriesMember=StudyCase",
    "results.dataset": "save_result=save_dataset",
    "report": "write_report",
    "signals.damping": "half_power",
    "errors": "ConvergenceError InputError WrollError",
}
"""Module -> its public names; "public=own" if the name in the module differs."""

_MODULES = {
    "joints": "dynamics.joints",
    "lab": "lab",
    "plot": "plotting.names",
    "two_dof": "two_dof",
    "estimators": "signals.estimators",
    "signals": "signals",
}
"""Public name -> module."""

_WHERE = {
    public: (module, own or public)
    for module, names in _HOMES.items()
    for public, _, own in (name.partition("=") for name in names.split())
}

__all__ = [
    "Backbone", "Case", "CaseWarning", "Chirp", "Coil", "Contact", "ConvergenceError", "DesignMap", "Dwell",
    "FrictionLaw", "Geometry", "HalfSine", "Harmonic", "InputError", "Integrator", "Interface", "IsotropicMaterial",
    "LawParameter", "Mandrel", "Mesh", "Modal", "Normal", "NormalPenalty", "OrthotropicMaterial", "Output",
    "OwnStructure", "PenaltyCoulomb", "PenaltyFriction", "Preload", "ProbePoint", "Psd", "Random", "RateCoulomb",
    "RateFriction", "RateTable", "RecordedMotion", "Result", "Roll", "Sawtooth", "ShockSpectrum", "Sine", "SlipModel",
    "SmoothedCoulomb", "SmoothedFriction", "Solver", "StudyCase", "System", "Trapezoid", "Winding", "WrollError",
    "__version__", "batch_table", "case_of", "case_warnings", "estimate", "estimators", "example_case", "half_power",
    "joints", "lab", "load_case", "load_grid", "load_result", "load_series", "plot", "register_law", "run", "run_grid",
    "run_series", "save_result", "signals", "slip_model", "structure", "summarise", "transmissibility", "two_dof",
    "write_report",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Import a public name on first use, so that `import wroll_fem` is fast."""
    if name in _MODULES:
        value: Any = import_module(f"{__name__}.{_MODULES[name]}")
    elif name in _WHERE:
        module, own = _WHERE[name]
        value = getattr(import_module(f"{__name__}.{module}"), own)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
