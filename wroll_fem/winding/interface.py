"""Pressures at the interfaces of a layered model, set equal to the pressure of a wound roll at the same radii."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray
from wroll_fem.winding.stress import wound_roll

if TYPE_CHECKING:
    from wroll_fem.case.preload import Preload
    from wroll_fem.case.roll import RollSections
    from wroll_fem.case.winding import Winding


def target_pressures(winding: Winding, layers: int) -> FloatArray:
    """(layers,) pressure of the wound roll at the radius of each interface, innermost first, Pa.

    Raises
    ------
    InputError
        If the section `winding` has no mandrel.
    """
    radii = winding.core.outer_radius + np.arange(layers) / layers * winding.build_up
    return wound_roll(winding).pressure_at(radii)


def ring_split(roll: RollSections) -> FloatArray:
    """Pressure at each interface per unit external pressure on each layer, for thin rings without end effects.

    All rings have the same radial displacement, so each carries the fraction of the load given by its stiffness
    E t / R^2. The pressure at an interface is the sum of the external pressures on the layers outside it, less the part
    that these layers carry.

    Returns
    -------
    (layers, layers) row: interface, column: loaded layer, innermost first
    """
    n, radius = roll.coil.layers, 0.5 * roll.geometry.mandrel_outer_diameter
    core = roll.mandrel.material.in_plane.E_theta * roll.geometry.mandrel_thickness / radius**2
    ring = roll.coil.layer_material.in_plane.E_theta * roll.coil.layer_thickness / radius**2
    outside = np.arange(n, 0, -1)
    return np.triu(np.ones((n, n))) - (outside * ring / (core + n * ring))[:, None]


def external_pressures(roll: RollSections, preload: Preload, winding: Winding | None = None) -> list[float]:
    """External pressure on each layer, innermost first, Pa; with `kind: winding_tension` a thin-ring estimate.

    Parameters
    ----------
    winding
        Case section `winding` with its mandrel; used only for `preload.kind: winding_tension`.

    Raises
    ------
    InputError
        If the section `winding` is incomplete, or if a layer would need a negative external pressure.
    """
    if preload.kind != "winding_tension" or winding is None:
        return preload.per_layer(roll.coil.layers)
    pressures = np.linalg.solve(ring_split(roll), target_pressures(winding, roll.coil.layers)).tolist()
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
