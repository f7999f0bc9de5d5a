"""Declaration and lookup of the analyses; all tables of analyses are derived from the declarations.

An analysis is a module that contains `ANALYSIS`, an `Analysis` object, and is listed in `case.analyses.MODULES`. It is
imported on first use, so that importing this module is fast.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wroll_fem.case.analyses import MODULES
from wroll_fem.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    Run = Callable[..., xr.Dataset]
    Check = Callable[[Any], list[str]]  # of a case of the analysis
    Estimate = Callable[[Any], dict[str, Any]]
    Summary = Callable[[xr.Dataset], dict[str, Any]]
    Files = Callable[[xr.Dataset, Path], list[Path]]


@dataclass(frozen=True)
class Analysis:
    """Description of an analysis: its case sections, computation, summary, figures and fields.

    Attributes
    ----------
    name
        Value of `analysis` in the case file.
    sentence
        What it computes.
    sections
        Case sections that are required for a roll with layers (or a solid coil).
    run
        Function of the case and ``progress`` that returns an annotated Dataset. The function of a resumable analysis
        also takes ``checkpoint`` (path or None) and ``resume``.
    summary
        Functions of the Dataset; each returns entries of summary.json, named in `results.summary.SUMMARY`. Attributes
        of the Dataset whose names are in that table become entries as they are.
    figures, fields
        Functions of the Dataset and a folder; each writes figures (.png) or fields (.vtu) and returns the files.
    variables
        Dimensions -> main variables with these dimensions, for the documentation.
    plots
        Figures of `wf.plot` that draw its results.
    preflight
        Checks before the run: functions of the case that return warnings, each with a remedy.
    estimate
        Size and approximate time of the run, from the case.
    resumable
        Whether it writes checkpoints, from which `--resume` continues.
    """

    name: str
    sentence: str
    sections: tuple[str, ...]
    run: Run
    summary: tuple[Summary, ...] = ()
    figures: tuple[Files, ...] = ()
    fields: tuple[Files, ...] = ()
    variables: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    plots: tuple[str, ...] = ()
    preflight: tuple[Check, ...] = ()
    estimate: Estimate = lambda case: {}
    resumable: bool = False


def find_analysis(name: str) -> Analysis:
    """Return the analysis with the given name.

    Raises
    ------
    InputError
        If the registry has no such name.
    """
    if name not in MODULES:
        remedy = f"use one of: {', '.join(MODULES)}"
        raise InputError(f"unknown analysis {name!r}", key="analysis", remedy=remedy)
    found: Analysis = import_module(MODULES[name]).ANALYSIS
    return found


def all_analyses() -> list[Analysis]:
    """Return all analyses in the order of the registry; their modules are imported."""
    return [find_analysis(name) for name in MODULES]
