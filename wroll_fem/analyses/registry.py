"""What an analysis declares, and how it is found; all tables of analyses are derived from these declarations.

An analysis is a module that holds `ANALYSIS`, an `Analysis` object, and stands in `case.analyses.MODULES`. It is
imported when it is asked for, so that this module stays cheap to import.
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
        Case sections without which it is refused, for a roll with layers (or a solid coil).
    run
        Function of the case and ``progress``, that returns an annotated Dataset; a resumable one also takes
        ``checkpoint`` (path or None) and ``resume``.
    summary
        Functions of the Dataset; each returns entries of summary.json, named in `results.summary.SUMMARY`. Attributes
        of the Dataset with names of that table are entries without further ado.
    figures, fields
        Functions of the Dataset and a folder; each writes figures (.png) or fields (.vtu) and returns the files.
    variables
        Dimensions -> main variables over them, for the documentation.
    plots
        Figures of `wf.plot` that draw its results.
    preflight
        Checks before the run: functions of the case that return warnings, each with what to change.
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
    """Return the analysis with a name.

    Raises
    ------
    InputError
        When the registry has no such name.
    """
    if name not in MODULES:
        remedy = f"use one of: {', '.join(MODULES)}"
        raise InputError(f"unknown analysis {name!r}", key="analysis", remedy=remedy)
    found: Analysis = import_module(MODULES[name]).ANALYSIS
    return found


def all_analyses() -> list[Analysis]:
    """Return all analyses in the order of the registry; imports their modules."""
    return [find_analysis(name) for name in MODULES]
