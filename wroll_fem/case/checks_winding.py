"""Checks of case section `winding` against the case sections that describe the roll."""

from __future__ import annotations

from typing import Any

from wroll_fem.case.base import validation_error
from wroll_fem.case.coil import Coil
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.preload import Preload
from wroll_fem.case.winding import Winding

FIT = 0.01
"""Largest accepted relative difference of a dimension in `winding` from the same dimension in `geometry` or `coil`."""


def check_winding_given(winding: Winding | None, preload: Preload | None) -> None:
    """Require the case section `winding` if the preload is computed from it.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if winding is None and preload is not None and preload.needs_winding:
        other = " without preload.pressure" if preload.kind == "winding_stress" else ""
        raise validation_error(
            "required section is missing", key="winding", show_value=False,
            remedy="add it (winding of the roll: tension, wraps, mandrel, web), because "
            f"preload.kind: {preload.kind}{other} needs it",
        )  # fmt: skip


def check_wraps_of_layers(winding: Winding | None, coil: Coil) -> None:
    """Require the number of wraps, not below that of the layers, for `coil.per_wrap`.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if not coil.per_wrap:
        return
    if winding is None:
        raise validation_error(
            "required section is missing", key="winding", show_value=False,
            remedy="add it (winding of the roll: tension, wraps, mandrel, web), because coil.per_wrap: true needs the "
            "number of wraps",
        )  # fmt: skip
    if coil.layers > winding.wraps:
        raise validation_error(
            f"more layers than wraps: with coil.per_wrap a layer stands for winding.wraps = {winding.wraps} / layers",
            key="coil.layers", value=coil.layers, remedy=f"use at most {winding.wraps} layers, or leave per_wrap out",
        )  # fmt: skip


def check_winding_friction(winding: Winding, *, positive: bool = False) -> None:
    """Require the coefficient of friction between wraps; if ``positive``, refuse zero as well.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if winding.mu is None:
        remedy = "add it (coefficient of friction between wraps): the friction capacity is mu times the pressure"
        raise validation_error("required key is missing", key="winding.mu", show_value=False, remedy=remedy)
    if winding.mu == 0.0 and positive:
        remedy = "use a value above 0: without friction every point slips at any level"
        raise validation_error("the coefficient of friction is zero", key="winding.mu", value=0.0, remedy=remedy)


def check_winding_mandrel(winding: Winding | None, *, described: bool) -> None:
    """Require `winding.mandrel` unless the sections `geometry` and `mandrel` are present (``described``).

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if winding is not None and winding.mandrel is None and not described:
        remedy = "add it (outer_radius with wall and E, or with stiffness)"
        raise validation_error("required section is missing", key="winding.mandrel", show_value=False, remedy=remedy)


def check_winding_size(winding: Winding | None, geometry: Geometry | None, coil: Coil | None) -> None:
    """Check that the wound roll and the simulated roll have the same size, if both are described.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if winding is None or geometry is None:
        return
    radius, wall = 0.5 * geometry.mandrel_outer_diameter, geometry.mandrel_thickness
    if winding.mandrel is not None:
        _check_same(winding.mandrel.outer_radius, radius, "mandrel.outer_radius", "geometry.mandrel_outer_diameter / 2")
        if winding.mandrel.wall is not None:
            _check_same(winding.mandrel.wall, wall, "mandrel.wall", "geometry.mandrel_thickness")
    if winding.wrap_thickness >= radius:
        raise _misfit("wrap_thickness", winding.wrap_thickness, "must be less than the mandrel radius", "a thinner web")
    margins = None if coil is None else coil.margins
    covered = geometry.length - (0.0 if margins is None else margins.base + margins.tip)
    if winding.web_width is not None and winding.web_width > (1.0 + FIT) * covered:
        limit = f"{'geometry.length' if margins is None else 'the length of the coil'} = {covered:g} m or less"
        raise _misfit("web_width", winding.web_width, "the web is wider than the roll is long", limit)
    if coil is None or coil.model == "none":
        return
    thickness = coil.total_thickness
    if winding.wrap_thickness > (1.0 + FIT) * thickness:
        limit = f"coil.total_thickness / wraps, with coil.total_thickness = {thickness:g} m"
        raise _misfit("wrap_thickness", winding.wrap_thickness, "the web is thicker than the coil", limit)
    if abs(winding.build_up - thickness) > FIT * thickness:
        problem = (
            f"{winding.wraps} wraps of {winding.wrap_thickness:g} m are {winding.build_up:g} m thick, the coil is "
        )
        wraps = max(1, round(thickness / winding.wrap_thickness))
        raise _misfit("wraps", winding.wraps, f"{problem}{thickness:g} m", f"wraps: {wraps}, or change the coil")


def _check_same(value: float, wanted: float, key: str, name: str) -> None:
    if abs(value - wanted) > FIT * wanted:
        raise _misfit(key, value, f"differs from {name} = {wanted:g} m", f"{wanted:g} m, or leave winding.mandrel out")


def _misfit(key: str, value: Any, problem: str, use: str) -> Exception:
    return validation_error(problem, key=f"winding.{key}", value=value, remedy=f"use {use}")
