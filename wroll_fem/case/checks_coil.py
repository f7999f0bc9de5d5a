"""Checks of a solid coil against the analysis: modal_transient and slip_damping."""

from __future__ import annotations

from wroll_fem.case.base import validation_error
from wroll_fem.case.coil import Coil
from wroll_fem.case.excitation import SineExcitation


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
            remedy="use bonded, or analysis: dwell",
        )  # fmt: skip


def check_inside(coil: Coil, analysis: str) -> None:
    """Require `coil.inside: slipping` for slip_damping, and refuse it for every other analysis.

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
    if analysis != "slip_damping" and coil.inside == "slipping":
        raise validation_error(
            f"analysis {analysis} has no slip between the wraps of a solid coil", key="coil.inside",
            value=coil.inside, remedy="leave it out, or use analysis: slip_damping",
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
