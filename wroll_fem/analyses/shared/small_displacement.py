r"""Limits of small-displacement theory for a roll: flattening of a bent tube, rotation of its tip, slip of layers.

A cantilever whose tip moves by u has the curvature :math:`\kappa = 3 u / L^2` at its root and the rotation
:math:`\theta = 3 u / (2 L)` at its tip. The linear model leaves out

* flattening: compressed and stretched fibres press a bent tube flat by the share
  :math:`\zeta = (1 - \nu^2)\, \kappa^2 R^4 \sum E t / \sum E t^3` of its radius (Brazier 1927, for nested tubes with a
  common shape), and its bending stiffness falls by :math:`\tfrac32 \zeta`. Ends that are kept circular reduce the
  flattening, so this is an upper bound. Long before a thin wall buckles, at the strain 0.6 t/R, flattening is its
  largest effect;
* rotation: forces and inertia keep their directions, with a relative error of :math:`\theta^2/2`;
* sliding of the contact points: they are matched only once. The positions at which friction and pressure act are
  therefore wrong by the slip, and the directions of the tangents by the angle slip / R.

References
----------
Brazier (1927), Proc. R. Soc. A 116, 104, doi:10.1098/rspa.1927.0125.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from wroll_fem.analyses.forecasts.closed_forms import root_element_height
from wroll_fem.case.structural import OnRoll

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.case import Case, RollSections

STIFFNESS_ERROR = 0.01
"""Relative loss of bending stiffness due to flattening of the cross-section, or relative error due to the rotation of
the tip, above which a run warns."""

SLIP_OF_RADIUS, SLIP_OF_ELEMENT = 0.01, 0.1
"""Slip divided by the radius, and slip divided by the smallest element edge, above which a run warns."""

SIGMAS, OF_RANDOM = 3.0, " (three standard deviations)"
"""Motion at which a random response is judged, in standard deviations, where no largest value is known."""


def flattening(roll: RollSections, tip: float) -> float:
    """Relative loss of bending stiffness at the root due to flattening, for a tip displacement ``tip`` in m.

    Layers flatten with the mandrel and slide on it. A solid coil is assumed not to resist the flattening of the
    mandrel, which overestimates the loss.
    """
    g, wall, coil = roll.geometry, roll.mandrel.material.in_plane, roll.coil
    radius = 0.5 * (g.mandrel_outer_diameter - g.mandrel_thickness)
    stretch, bend = wall.E_z * g.mandrel_thickness, wall.E_theta * g.mandrel_thickness**3
    if coil.model in ("layers", "bonded"):
        layer = coil.layer_material.in_plane
        stretch += coil.layers * layer.E_z * coil.layer_thickness
        bend += coil.layers * layer.E_theta * coil.layer_thickness**3
    curvature = 3.0 * tip / g.length**2
    return 1.5 * (1.0 - wall.nu_theta_z**2) * curvature**2 * radius**4 * stretch / bend


def displacement_doubts(dataset: xr.Dataset, summary: Mapping[str, Any], case: Case) -> list[str]:
    """Warnings about motions of a roll beyond small-displacement theory.

    Parameters
    ----------
    dataset
        Results, with the tip motion that `largest_tip` looks for.
    summary
        Entries of summary.json.
    case
        Case of the run; only a roll has the dimensions.
    """
    if not isinstance(case, OnRoll):
        return []
    return [*_of_tip(largest_tip(dataset), case), *_of_slip(*_largest_slip(summary), case)]


def largest_tip(dataset: xr.Dataset) -> tuple[float, str]:
    """Largest tip displacement of results, m, and a text on its meaning: `SIGMAS` standard deviations of random motion.

    It is that of the levels asked for, if there are levels, and not that of a backbone that goes beyond them.
    """
    if "tip_displacement_rms_at_level" in dataset.variables:
        rms = float(dataset.attrs.get("tip_displacement_rms_m", 0.0))
        return SIGMAS * max(rms, _largest(dataset, "tip_displacement_rms_at_level")), OF_RANDOM
    names = ("tip_at_level",) if "tip_at_level" in dataset.variables else ("tip_displacement", "tip_amplitude")
    return max(_largest(dataset, name) for name in names), ""


def _largest(dataset: xr.Dataset, name: str) -> float:
    if name not in dataset.variables:
        return 0.0
    return float(np.abs(dataset[name].fillna(0.0).values).max(initial=0.0))


def _largest_slip(summary: Mapping[str, Any]) -> tuple[float, str]:
    """Largest relative displacement of layers, m, and a text on its meaning; 0 without one."""
    if (rms := summary.get("slip_rms_m")) is not None:
        return SIGMAS * float(np.max(rms, initial=0.0)), OF_RANDOM
    found = summary.get("max_relative_displacement_m", summary.get("level_max_slip_m", 0.0))
    return float(np.max(np.nan_to_num(np.asarray(found, float)), initial=0.0)), ""


def _of_tip(largest: tuple[float, str], case: OnRoll) -> list[str]:
    tip, meaning = largest
    loss, rotation = flattening(case, tip), 0.5 * (1.5 * tip / case.geometry.length) ** 2
    if max(loss, rotation) <= STIFFNESS_ERROR:
        return []
    part, what = max((loss, "flattening of the tube"), (rotation, "rotation of the tip"))
    return [
        f"the tip moves by {1e3 * tip:.2g} mm{meaning}, beyond small-displacement theory: {what} is neglected, "
        f"with a relative error of up to {100 * part:.2g} %; it is below {100 * STIFFNESS_ERROR:.0f} % up to a tip "
        f"motion of {1e3 * tip * math.sqrt(STIFFNESS_ERROR / part):.2g} mm"
    ]


def _of_slip(slip: float, meaning: str, case: OnRoll) -> list[str]:
    radius, mesh = 0.5 * case.geometry.mandrel_outer_diameter, case.mesh
    edge = min(2.0 * math.pi * radius / mesh.circumferential, root_element_height(case))
    limit = SLIP_OF_RADIUS * radius if mesh.file is not None else min(SLIP_OF_RADIUS * radius, SLIP_OF_ELEMENT * edge)
    if slip <= limit:
        return []
    return [
        f"layers slide by up to {1e3 * slip:.2g} mm{meaning}, {100 * slip / radius:.2g} % of the radius: contact "
        f"points are matched only once, which is accurate up to {1e3 * limit:.2g} mm: results at larger slip are "
        "doubtful"
    ]
