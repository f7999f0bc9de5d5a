"""Checks of the supports of a mandrel against the coil and the analysis."""

from __future__ import annotations

import math

from wroll_fem.case.base import validation_error
from wroll_fem.case.coil import Coil
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.supports import BaseSprings, TipSprings


def check_supports(mandrel: Mandrel, coil: Coil, analysis: str, *, prestressed: bool) -> None:
    """Refuse springs that leave a mandrel free, layers held where the mandrel is not, and geometric stiffness.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    springs = mandrel.springs
    if springs is None:
        return
    if coil.model not in ("none", "nonstructural_mass") and coil.base != "free":
        raise validation_error(
            f"holds the coil to the shaker, but the base of the mandrel is {mandrel.base}", key="coil.base",
            value=coil.base, remedy="use coil.base: free",
        )  # fmt: skip
    if prestressed:
        raise validation_error(
            "has no term for the rotation of a rigid base ring", key="mandrel.base", value=mandrel.base,
            remedy="use mandrel.base: clamped, or leave preload.geometric_stiffness out",
        )  # fmt: skip
    loose = _loose(springs, mandrel.tip_springs or TipSprings())
    if loose and analysis != "modal":
        raise validation_error(
            f"leaves the mandrel free {loose}", key="mandrel.base", value=mandrel.base,
            remedy="give springs in this direction (base_springs, tip_springs), or use analysis: modal",
        )  # fmt: skip


def _loose(base: BaseSprings, tip: TipSprings) -> str:
    """First direction in which springs leave a mandrel free; empty if it is held."""
    lateral, axial, tilt, torsion = (
        math.inf if k is None else k for k in (base.lateral, base.axial, base.tilt, base.torsion)
    )
    for stiffness, words in (
        (axial + tip.axial, "along the axis"), (torsion + tip.torsion, "about the axis"),
        (lateral + tip.lateral, "across the axis"),
        (tilt + tip.tilt + min(lateral, tip.lateral), "to tilt"),  # held by a spring, or by springs at both ends
    ):  # fmt: skip
        if not stiffness > 0:
            return words
    return ""
