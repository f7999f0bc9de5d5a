"""Kinds of laboratory evaluations: table of all kinds, and what the module of a kind declares.

A kind is a module that contains `KIND`, a `Kind` object, and is listed in `KINDS`. It is imported on first use, so that
importing this module is fast.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from wroll_fem.errors import InputError
from wroll_fem.lab.figure import Figure

__all__ = ["KINDS", "Figure", "Kind", "Listed", "find_kind"]

if TYPE_CHECKING:
    from wroll_fem.lab.result import LabResult
    from wroll_fem.lab.settings import LabSettings
    from wroll_fem.progress import Progress

    Evaluate = Callable[[Sequence[Path], Any, Progress], LabResult]  # files, settings of the kind
    Example = Callable[[Path], list[Path]]  # folder


class Listed(NamedTuple):
    """Kind in the table: its module, and what it computes in one sentence."""

    module: str
    sentence: str


KINDS: dict[str, Listed] = {
    "transmissibility": Listed(
        "wroll_fem.lab.shaker.transmissibility",
        "Transmissibility, resonance frequency and damping from records of base and tip.",
    ),
    "fit": Listed(
        "wroll_fem.lab.fits.fit",
        "Two-mass model, or friction and elastic slip of a roll, from measured resonances.",
    ),
    "slip": Listed(
        "wroll_fem.lab.slip_images.evaluation",
        "Slip of layers to the mandrel and between each other from high-speed images of targets.",
    ),
    "shear": Listed(
        "wroll_fem.lab.shear.kind",
        "Capacity, stiffness, modulus, loops and coefficient of friction from shear tests.",
    ),
    "friction": Listed(
        "wroll_fem.lab.friction.kind",
        "Friction laws fitted to shear tests: mu over slip rate, rate and state, elastic slip.",
    ),
    "tension": Listed(
        "wroll_fem.lab.tension.kind",
        "Tension of a winding machine over voltage and current, and the pressure that it winds.",
    ),
}
"""Name of a kind -> module and sentence, in the order of `wroll lab --help`."""


@dataclass(frozen=True)
class Kind:
    """Declaration of a kind of evaluation.

    Attributes
    ----------
    settings
        Model of the settings; every key has a description with its unit.
    evaluate
        Function of files, settings and progress that returns a `LabResult` with `summary` and `data`. It reports
        warnings to the progress object. Entries and variables are named in `wroll_fem/results/lab/`.
    files
        What the files contain, and their formats; for the help and the reference page.
    figures
        Name (that of the .png) -> figure. The first is the one that `LabResult.plot` draws by default.
    variables
        Dimensions -> main variables with these dimensions, for the documentation.
    example
        Function that writes example files with known truth into a folder, and returns those to evaluate; it may also
        write `settings.yaml` there.
    folders
        Whether the inputs may be folders.
    """

    settings: type[LabSettings]
    evaluate: Evaluate
    files: str
    figures: Mapping[str, Figure] = field(default_factory=dict)
    variables: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    example: Example | None = None
    folders: bool = False


def find_kind(name: str) -> Kind:
    """Return the declaration of the kind with the given name.

    Raises
    ------
    InputError
        If the table has no such name.
    """
    if name not in KINDS:
        raise InputError(f"unknown kind {name!r} of evaluation", remedy=f"use one of: {', '.join(KINDS)}")
    found: Kind = import_module(KINDS[name].module).KIND
    return found
