"""Interface pressures of a layered model that correspond to a wound roll."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.case.winding import completed
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray
from wroll_fem.winding.stress import wound_roll

if TYPE_CHECKING:
    from wroll_fem.case import Case


def target_pressures(case: Case) -> FloatArray:
    """(layers,) pressure of the wound roll at the radius of each interface, innermost first, Pa.

    Raises
    ------
    InputError
        If the section `winding` of the case is incomplete.
    """
    section = completed(case)
    assert section.mandrel is not None
    radii = section.mandrel.outer_radius + np.arange(case.coil.layers) / case.coil.layers * section.build_up
    return wound_roll(section).pressure_at(radii)


def ring_split(case: Case) -> FloatArray:
    """Pressure at each interface per unit external pressure on each layer, for thin rings without end effects.

    All rings have the same radial displacement, so each carries the fraction of the load given by its stiffness
    E t / R^2. The pressure at an interface is the sum of the external pressures on the layers outside it, less the part
    that these layers carry.

    Returns
    -------
    (layers, layers) row: interface, column: loaded layer, innermost first
    """
    n, radius = case.coil.layers, 0.5 * case.geometry.mandrel_outer_diameter
    core = case.mandrel.material.E * case.geometry.mandrel_thickness / radius**2
    ring = case.coil.layer_material.E * case.coil.layer_thickness / radius**2
    outside = np.arange(n, 0, -1)
    return np.triu(np.ones((n, n))) - (outside * ring / (core + n * ring))[:, None]


def external_pressures(case: Case) -> list[float]:
    """External pressure on each layer, innermost first, Pa; for `winding_tension` estimated with thin rings.

    Raises
    ------
    InputError
        If the section `winding` is incomplete, or if a layer would need a negative external pressure.
    """
    if case.preload.kind != "winding_tension":
        return case.preload.per_layer(case.coil.layers)
    pressures = np.linalg.solve(ring_split(case), target_pressures(case)).tolist()
    refuse_pull(pressures)
    return pressures


def refuse_pull(pressures: Sequence[float]) -> None:
    """Check that no external pressure (Pa) is negative.

    Raises
    ------
    InputError
        If one of the pressures is negative.
    """
    if min(pressures) < 0.0:
        raise InputError(
            "the wound-roll pressure increases outwards so steeply that a layer needs a negative external pressure",
            key="winding.tension_profile", remedy="reduce the tension towards the outside, or use fewer coil.layers",
        )  # fmt: skip
