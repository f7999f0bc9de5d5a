"""From the wound roll to the layers of a friction model: the pressure that each interface shall have."""

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
    """(layers,) pressure of the wound roll at the radius of each interface, inner first, Pa."""
    section = completed(case)
    assert section.mandrel is not None
    radii = section.mandrel.outer_radius + np.arange(case.coil.layers) / case.coil.layers * section.build_up
    return wound_roll(section).pressure_at(radii)


def ring_split(case: Case) -> FloatArray:
    """(layers, layers) pressure at each interface per external pressure on each layer: thin rings, no end effects.

    All rings move alike, so each carries the share of the load that its E t / R^2 has of their sum; an interface
    passes on what presses outside of it less what the rings outside of it carry.
    """
    n, radius = case.coil.layers, 0.5 * case.geometry.mandrel_outer_diameter
    core = case.mandrel.material.E * case.geometry.mandrel_thickness / radius**2
    ring = case.coil.layer_material.E * case.coil.layer_thickness / radius**2
    outside = np.arange(n, 0, -1)
    return np.triu(np.ones((n, n))) - (outside * ring / (core + n * ring))[:, None]


def external_pressures(case: Case) -> list[float]:
    """External pressure on each layer, inner first, Pa; for winding_tension the thin-ring estimate of it."""
    if case.preload.kind != "winding_tension":
        return case.preload.per_layer(case.coil.layers)
    pressures = np.linalg.solve(ring_split(case), target_pressures(case)).tolist()
    refuse_pull(pressures)
    return pressures


def refuse_pull(pressures: Sequence[float]) -> None:
    """Refuse external pressures on the layers of which one is a pull."""
    if min(pressures) < 0.0:
        raise InputError(
            "the wound roll's pressure rises outwards so steeply that a layer would have to be pulled off",
            key="winding.tension_profile", remedy="let the tension fall outwards, or use fewer coil.layers",
        )  # fmt: skip
