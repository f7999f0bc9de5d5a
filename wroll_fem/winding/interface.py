"""Pressures at the interfaces of a layered model, set equal to the pressure of a wound roll at the same radii."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray
from wroll_fem.winding.stress import WoundRoll, wound_roll

if TYPE_CHECKING:
    from wroll_fem.case.preload import Preload
    from wroll_fem.case.roll import RollSections
    from wroll_fem.case.winding import Winding

LARGEST_POWER = 300.0
"""Logarithm of a ratio of displacements through a solid coil above which no pressure reaches the mandrel."""

_last: tuple[Winding, WoundRoll] | None = None
"""Last section and its roll: warnings, assembly, preload and results of one run ask for the same pressures."""


def target_pressures(winding: Winding, layers: int) -> FloatArray:
    """(layers,) pressure of the wound roll at the radius of each interface, innermost first, Pa.

    Raises
    ------
    InputError
        If the section `winding` has no mandrel.
    """
    global _last
    kept = _last
    if kept is None or kept[0] != winding:
        _last = kept = winding, wound_roll(winding)
    radii = winding.core.outer_radius + np.arange(layers) / layers * winding.build_up
    return kept[1].pressure_at(radii)


def prescribed_pressures(roll: RollSections, preload: Preload, winding: Winding | None) -> FloatArray:
    """(n_interfaces,) pressure that a preload prescribes at each interface, innermost first, Pa.

    For all kinds but external_pressure: from `preload.pressure`, or from the wound roll.
    """
    if preload.needs_winding and winding is not None:
        return target_pressures(winding, roll.coil.layers)
    return np.asarray(preload.per_interface(roll.coil.layers))


def pressure_split(roll: RollSections) -> FloatArray:
    """Pressure at each interface per unit external pressure on each layer, an estimate for rings without end effects.

    Returns
    -------
    (n_interfaces, n_interfaces) row: interface, column: loaded layer, innermost first
    """
    if roll.coil.rubs:
        return np.array([[transmitted_pressure(roll)]])
    return ring_split(roll)


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


def transmitted_pressure(roll: RollSections) -> float:
    """Pressure between mandrel and solid coil per unit external pressure: a thick orthotropic ring on a thin one.

    The radial displacement of the coil in plane stress is A r^k + B r^-k with k^2 = E_theta / E_r (Lekhnitskii 1963,
    Theory of elasticity of an anisotropic elastic body); it follows the mandrel at the inner radius.
    """
    g, coil, web = roll.geometry, roll.coil, roll.coil.solid()
    inner = 0.5 * g.mandrel_outer_diameter
    outer, k = 1.0 + coil.total_thickness / inner, math.sqrt(web.E_theta / web.E_r)  # radii relative to the inner one
    if k * math.log(outer) > LARGEST_POWER:  # the hoops of the outer turns carry all of it
        return 0.0
    coupling = web.nu_theta_r * web.E_r / web.E_theta  # strain along theta per strain along r, under stress along r
    factor = web.E_r / (1.0 - coupling * web.nu_theta_r)

    def stress(power: float, r: float) -> float:  # radial stress of the displacement r^power
        return factor * (power + web.nu_theta_r) * r ** (power - 1.0)

    core = roll.mandrel.material.in_plane.E_theta * g.mandrel_thickness / inner
    at_core = [stress(p, 1.0) - core for p in (k, -k)]  # zero: sigma_r = core u
    at_edge = [stress(p, outer) for p in (k, -k)]  # sigma_r = -1
    shares = [-at_core[1], at_core[0]]
    scale = -1.0 / (at_edge[0] * shares[0] + at_edge[1] * shares[1])
    return -scale * core * (shares[0] + shares[1])


def external_pressures(roll: RollSections, preload: Preload, winding: Winding | None = None) -> list[float]:
    """External pressure on each layer, innermost first, Pa; an estimate if the preload prescribes another pressure.

    Parameters
    ----------
    winding
        Case section `winding` with its mandrel; used only if the preload needs it.

    Raises
    ------
    InputError
        If the section `winding` is incomplete, or if a layer would need a negative external pressure.
    """
    if preload.kind == "external_pressure":
        return preload.per_layer(roll.coil.layers)
    if preload.kind == "winding_stress":
        return [0.0] * roll.coil.layers
    pressures = np.linalg.solve(pressure_split(roll), prescribed_pressures(roll, preload, winding)).tolist()
    refuse_pull(pressures, preload)
    return pressures


def refuse_pull(pressures: Sequence[float], preload: Preload) -> None:
    """Check that no external pressure (Pa) of a preload is negative.

    Raises
    ------
    InputError
        If one of the pressures is negative.
    """
    if min(pressures) < 0.0 and not preload.needs_winding:
        raise InputError(
            "the interface pressures increase outwards so steeply that a layer needs a negative external pressure",
            key="preload.pressure", remedy="reduce the pressures towards the outside, or use kind: winding_stress",
        )  # fmt: skip
    if min(pressures) < 0.0:
        raise InputError(
            "the wound-roll pressure increases outwards so steeply that a layer needs a negative external pressure",
            key="winding.tension_profile", remedy="reduce the tension towards the outside, or use fewer coil.layers",
        )  # fmt: skip
