"""Checks of a solid coil against the analysis: stress and slip between its wraps."""

from __future__ import annotations

from wroll_fem.case.base import validation_error
from wroll_fem.case.checks_winding import check_winding_friction
from wroll_fem.case.coil import Coil
from wroll_fem.case.damping import Damping
from wroll_fem.case.excitation import SineExcitation
from wroll_fem.case.preload import Preload
from wroll_fem.case.solver import Solver
from wroll_fem.case.winding import Winding

HISTORIES = ("sweep", "dwell")
"""Histories in time with slip between the wraps of a solid coil."""

SLIPPING = ("slip_damping", "harmonic", "backbone", "random_response", *HISTORIES)
"""Analyses with slip between the wraps of a solid coil."""


def check_solid_coil(coil: Coil, analysis: str) -> None:
    """Require a solid coil bonded to the mandrel for modal_transient and slip_damping.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if coil.model != "solid":
        raise validation_error(
            f"analysis {analysis} recovers the stress of a solid coil", key="coil.model", value=coil.model,
            remedy="use coil.model: solid; for layers use analysis: dwell",
        )  # fmt: skip
    if coil.rubs:
        raise validation_error(
            f"analysis {analysis} has no friction on the mandrel", key="coil.interface", value=coil.interface,
            remedy="use bonded, or analysis: backbone, harmonic or dwell",
        )  # fmt: skip


def check_inside(coil: Coil, analysis: str) -> None:
    """Require `coil.inside: slipping` for slip_damping, and refuse it for every analysis that is not in `SLIPPING`.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if analysis == "slip_damping" and coil.model == "solid" and coil.inside == "stiff":
        raise validation_error(
            "analysis slip_damping follows the slip between the wraps", key="coil.inside", value=coil.inside,
            remedy="use slipping; for a coil that does not slip use analysis: modal_transient",
        )  # fmt: skip
    if analysis not in SLIPPING and coil.inside == "slipping":
        raise validation_error(
            f"analysis {analysis} has no slip between the wraps of a solid coil", key="coil.inside",
            value=coil.inside, remedy=f"leave it out, or use analysis: {', '.join(SLIPPING)}",
        )  # fmt: skip


def check_shaken_wraps(
    coil: Coil, winding: Winding | None, damping: Damping | None, solver: Solver, preload: Preload | None, analysis: str
) -> None:
    """Check the sections of a coil whose wraps slide in a periodic motion or a history.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if not coil.slips or analysis == "slip_damping":
        return
    if winding is None:
        raise validation_error(
            "required section is missing", key="winding", show_value=False,
            remedy="add it: it gives the pressure and the friction between the wraps (coil.inside: slipping)",
        )  # fmt: skip
    check_winding_friction(winding, positive=True)
    if coil.pressure == "varying":
        raise validation_error(
            f"analysis {analysis} has a constant pressure between the wraps", key="coil.pressure", value=coil.pressure,
            remedy="leave it out, or use analysis: slip_damping",
        )  # fmt: skip
    if damping is not None and damping.loss_factor is not None:
        raise validation_error(
            "does not apply to wraps that slide: their shear acts through friction", key="damping.loss_factor",
            show_value=False, remedy="use damping.modal",
        )  # fmt: skip
    if analysis in HISTORIES and solver.method != "reduced":
        raise validation_error(
            "has no limit on its unknowns: the friction between the wraps acts at thousands of points",
            key="solver.method", value=solver.method, remedy="use reduced",
        )  # fmt: skip
    if coil.rubs and preload is not None and preload.kind != "winding_stress":
        raise validation_error(
            "does not go with the pressure between the wraps, which is that of the wound roll", key="preload.kind",
            value=preload.kind, remedy="use winding_stress, or coil.inside: stiff",
        )  # fmt: skip
    if preload is not None and preload.geometric_stiffness:
        raise validation_error(
            "does not apply to a coil whose wraps slide", key="preload.geometric_stiffness", value=True,
            remedy="leave it out",
        )  # fmt: skip


def check_mode(excitation: SineExcitation, analysis: str) -> None:
    """Refuse `excitation.mode` torsion and axial for every analysis but slip_damping.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if excitation.mode != "bending":
        raise validation_error(
            f"analysis {analysis} has a base that moves along x or y", key="excitation.mode", value=excitation.mode,
            remedy="leave it out, or use analysis: slip_damping",
        )  # fmt: skip


def check_resonance(excitation: SineExcitation) -> None:
    """Require `excitation.frequency: resonance` for slip_damping.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if excitation.frequency != "resonance":
        raise validation_error(
            "analysis slip_damping follows the resonance, which moves with the amplitude", key="excitation.frequency",
            value=excitation.frequency, remedy="use resonance",
        )  # fmt: skip
