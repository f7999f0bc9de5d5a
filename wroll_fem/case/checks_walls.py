"""Checks of laminates, of a variable wall and of the margins of the coil against geometry, mesh and preload."""

from __future__ import annotations

from wroll_fem.case.base import validation_error
from wroll_fem.case.coil import SHELL_COILS, Coil
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.material import LaminateMaterial
from wroll_fem.case.mesh import Mesh

TOLERANCE = 1e-6
"""Largest relative difference between the thickness of a wall and the sum of its plies."""


def check_plies(geometry: Geometry, mandrel: Mandrel, coil: Coil) -> None:
    """Refuse laminates whose plies do not fill their wall.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    walls = [(mandrel.material, "mandrel", geometry.mandrel_thickness, "geometry.mandrel_thickness")]
    if coil.model in SHELL_COILS:
        walls.append((coil.layer_material, "coil", coil.layer_thickness, "the thickness of a layer"))
    for material, section, thickness, key in walls:
        if not isinstance(material, LaminateMaterial):
            continue
        if abs(material.thickness - thickness) > TOLERANCE * thickness:
            raise validation_error(
                f"the plies are {material.thickness:g} m thick, but {key} is {thickness:g} m",
                key=f"{section}.material.plies", show_value=False,
                remedy="change the plies or the thickness; symmetric: true counts every ply twice",
            )  # fmt: skip


def check_wall(geometry: Geometry, mandrel: Mandrel, coil: Coil, mesh: Mesh) -> None:
    """Refuse a wall table that has no end in the tube or that a laminate cannot follow, and plies in Fourier elements.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if (mandrel.is_layered or coil.is_layered) and mesh.discretisation == "fourier":
        own = "mandrel.material.kind" if mandrel.wall is None else "mandrel.wall"
        raise validation_error(
            "does not work with Fourier elements, whose walls are homogeneous and isotropic",
            key=own if mandrel.is_layered else "coil.material.kind",
            show_value=False, remedy="use mesh.discretisation: three_dimensional",
        )  # fmt: skip
    if mandrel.wall is None:
        return
    if isinstance(mandrel.material, LaminateMaterial):
        raise validation_error(
            "does not work with a laminate, whose plies have their own thicknesses", key="mandrel.wall",
            show_value=False, remedy="give one material (isotropic or kind: lamina), or leave wall out",
        )  # fmt: skip
    radius = 0.5 * geometry.mandrel_outer_diameter
    for k, row in enumerate(mandrel.wall):
        if row.z > geometry.length * (1 + TOLERANCE):
            raise validation_error(
                f"lies above the tip, at {geometry.length:g} m", key=f"mandrel.wall.{k}.z", value=row.z,
                remedy="give heights from 0 to geometry.length",
            )  # fmt: skip
        if row.thickness >= radius:
            raise validation_error(
                "the mandrel wall must be thinner than its radius", key=f"mandrel.wall.{k}.thickness",
                value=row.thickness, remedy=f"use less than mandrel_outer_diameter / 2 = {radius:g} m",
            )  # fmt: skip


def check_margins(geometry: Geometry, coil: Coil, mesh: Mesh, *, prestressed: bool) -> None:
    """Refuse margins that leave no coil, and those with a mesh file, Fourier elements or geometric stiffness.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if coil.margins is None:
        return
    if coil.margins.base + coil.margins.tip >= geometry.length:
        raise validation_error(
            f"leave no coil on a mandrel of {geometry.length:g} m", key="coil.margins", show_value=False,
            remedy="give margins whose sum is below geometry.length",
        )  # fmt: skip
    for key, wrong in (
        ("mesh.file", mesh.file is not None),
        ("mesh.discretisation", mesh.discretisation == "fourier"),
        ("preload.geometric_stiffness", prestressed),
    ):
        if wrong:
            raise validation_error(
                "does not work with coil.margins", key=key, show_value=False, remedy="leave one of them out"
            )
