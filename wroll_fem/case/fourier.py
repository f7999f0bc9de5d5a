"""Checks of what harmonics around the axis can do, and of the design map that needs them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wroll_fem.case.base import owns_section, wrong

if TYPE_CHECKING:
    from wroll_fem.case.case import Case

ANALYSES = ("modal", "modal_transient", "design_map")
"""Analyses that can use `mesh.discretisation: fourier`."""

COILS = ("solid", "bonded", "nonstructural_mass", "none")
"""Coil models without friction, which leave the harmonics apart."""


def fourier_fits(case: Case) -> None:
    """`mesh.discretisation: fourier` with what it can do."""
    if case.mesh.discretisation != "fourier" or case.structure is not None:
        return
    three = "or leave out mesh.discretisation"
    if case.analysis not in ANALYSES:
        raise wrong(
            f"analysis {case.analysis} couples the harmonics", key="mesh.discretisation", value="fourier",
            remedy=f"use three_dimensional, or one of the analyses {', '.join(ANALYSES)}",
        )  # fmt: skip
    if case.coil.model not in COILS:
        raise wrong(
            "layers with interfaces have no harmonics of their own", key="coil.model", value=case.coil.model,
            remedy=f"use {', '.join(COILS)}, {three}",
        )  # fmt: skip
    if case.mesh.file is not None:
        raise wrong(
            "harmonics use a mesh of the r-z half plane, made here", key="mesh.file", value=str(case.mesh.file),
            remedy=f"leave it out, {three}",
        )  # fmt: skip


def design_map_fits(case: Case) -> None:
    """Section `design_map` and what its analysis needs."""
    add = "{mandrel_radius: [...], mandrel_thickness: [...]}"
    if not owns_section(case, "design_map", lacks="map", missing="the mandrels to map", add=add):
        return
    assert case.design_map is not None
    if case.coil.model != "solid":
        raise wrong(
            "analysis design_map loosens a solid coil", key="coil.model", value=case.coil.model, remedy="use solid"
        )
    if case.coil.material.kind != "cylindrical_orthotropic":
        raise wrong(
            "analysis design_map changes the shear moduli between wraps", key="coil.material.kind",
            value=case.coil.material.kind, remedy="use cylindrical_orthotropic",
        )  # fmt: skip
    if case.mesh.discretisation != "fourier":
        raise wrong(
            "analysis design_map works in harmonics around the axis", key="mesh.discretisation",
            value=case.mesh.discretisation, remedy="use mesh.discretisation: fourier",
        )  # fmt: skip
    tightest = min(case.coil.material.G_r_theta, case.coil.material.G_r_z)
    if not isinstance(case.design_map.loosest, str) and case.design_map.loosest >= tightest:
        raise wrong(
            "the loosest coil is not looser than the case's", key="design_map.loosest", value=case.design_map.loosest,
            remedy=f"use less than its shear moduli between wraps, {tightest:g} Pa",
        )  # fmt: skip
    wall, radius = max(case.design_map.mandrel_thickness), min(case.design_map.mandrel_radius)
    if wall >= radius:
        raise wrong(
            f"the thickest wall, {wall:g} m, fills the smallest mandrel", key="design_map.mandrel_radius", value=radius,
            remedy=f"start above {wall:g} m",
        )  # fmt: skip
