"""Checks of the interfaces of a coil: the sections that describe them, and their preload."""

from __future__ import annotations

from wroll_fem.case.base import validation_error
from wroll_fem.case.coil import Coil
from wroll_fem.case.contact import Contact, friction_law
from wroll_fem.case.modal import Modal
from wroll_fem.case.preload import Preload

INTERFACE_SECTIONS = {"contact": "friction and normal contact", "preload": "pressure on the layers"}
"""Case sections that describe the interfaces of a coil."""

STEADY = ("harmonic", "backbone", "random_response")
"""Analyses of steady motions, whose mean displacement must be determined."""


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


def check_held(coil: Coil, contact: Contact | None, preload: Preload | None, analysis: str) -> None:
    """Refuse layers that neither friction at rest nor the base of the coil holds, for the analyses of steady motions.

    Such a layer drifts: its mean displacement is undetermined. Layers without friction have a steady motion if the
    normal contact holds them.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if analysis not in STEADY or not coil.has_interfaces or contact is None or preload is None:
        return
    loose = [layer for layer in range(1, coil.layers + 1) if not coil.holds(layer)]
    law = friction_law(contact.friction)
    bare = [layer for layer in preload.bare_interfaces(coil.layers) if layer in loose]
    drifts = "its mean displacement is undetermined"
    if bare and (law.mu > 0 or contact.normal.separation):
        raise validation_error(
            f"leaves {_named(coil, bare[0])} without pressure, and coil.base: {coil.base} does not hold it: {drifts}",
            key="preload.pressure", value=preload.pressure,
            remedy="give pressures that press every interface, in Pa, or use analysis: dwell or sweep",
        )  # fmt: skip
    if loose and law.mu > 0 and not law.acts_at_rest:
        raise validation_error(
            f"transmits no traction at rest, and coil.base: {coil.base} does not hold {_named(coil, loose[0])}: "
            f"{drifts}", key="contact.friction.law", value=law.name,
            remedy="use penalty_coulomb, or analysis: dwell or sweep",
        )  # fmt: skip


def _named(coil: Coil, layer: int) -> str:
    return f"layer {layer}" if coil.layers > 1 else "the coil"
