"""Checks of the interfaces of a coil: the sections that describe them, and their preload."""

from __future__ import annotations

from wroll_fem.case.base import validation_error
from wroll_fem.case.coil import Coil
from wroll_fem.case.modal import Modal
from wroll_fem.case.preload import Preload

INTERFACE_SECTIONS = {"contact": "friction and normal contact", "preload": "pressure on the layers"}
"""Case sections that describe the interfaces of a coil."""


def check_interfaces(section: str, coil: Coil, modal: Modal, analysis: str, written: set[str]) -> None:
    """Require a case section of `INTERFACE_SECTIONS` if the analysis uses the interfaces of the coil.

    Parameters
    ----------
    written
        Names of the case sections in the file.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    stuck = analysis == "modal" and modal.interface == "stuck"
    if not coil.has_interfaces or (analysis == "modal" and not stuck) or section in written:
        return
    slips = "coil.interface: friction" if coil.rubs else "coil.model: layers"
    reason = "modal.interface: stuck linearises the preloaded contact" if stuck else f"{slips} has interfaces"
    remedy = f"add it ({INTERFACE_SECTIONS[section]}): {reason}"
    raise validation_error("required section is missing", key=section, show_value=False, remedy=remedy)


def check_layers(coil: Coil) -> None:
    """Require a coil with interfaces for the analysis preload.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if not coil.has_interfaces:
        problem = "analysis preload needs layers, or a solid coil that rubs on its mandrel"
        remedy = "use layers, or solid with coil.interface: friction"
        raise validation_error(problem, key="coil.model", value=coil.model, remedy=remedy)


def check_pressures(preload: Preload | None, layers: int) -> None:
    """Require one external pressure, or a list with one external pressure per layer.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    pressure = None if preload is None else preload.pressure
    if isinstance(pressure, list) and len(pressure) != layers:
        raise validation_error(
            f"{len(pressure)} pressures for {layers} layer{'s' if layers > 1 else ''}", key="preload.pressure",
            value=pressure, remedy=f"give {layers} (inner first), or one number for the outermost layer",
        )  # fmt: skip


def check_winding_stress(preload: Preload | None) -> None:
    """Refuse a preload by winding stress with geometric stiffness.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if preload is not None and preload.kind == "winding_stress":
        raise validation_error(
            "does not compute the stress of the shells, which sets their geometric stiffness", key="preload.kind",
            value=preload.kind, remedy="use winding_tension, or leave the geometric stiffness out",
        )  # fmt: skip
