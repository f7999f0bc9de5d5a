r"""Forecast of slip before a run: friction capacity of the interfaces against the shear of the sticking first mode.

A bent roll with a tip displacement x has the curvature 3 x / L^2 at its root. If the layers outside an interface stick,
they carry the axial force n = E t R 3 x / L^2 per unit of circumference, which enters them through the interface. Near
their free end the traction decays over the shear-lag length :math:`\lambda`, so that its largest value is
:math:`n / \lambda`. Slip starts where this value reaches mu p, and is gross where n exceeds what friction transfers on
half of the length, mu p L / 2.

The estimate of the start is within a factor of 2 to 3 of computed backbones. In random rolls (`FEW`, `GROSS`) it tells
in advance which resonances friction does not bound, and which rolls slide and open so widely that harmonic balance
finds no motion.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from wroll_fem.analyses.forecasts.closed_forms import beam_frequency, interface_pressures, shear_lag
from wroll_fem.case.structural import OnRoll

if TYPE_CHECKING:
    from wroll_fem.case.damping import Damping
    from wroll_fem.case.structural import StructuralCase

FEW = 250.0
"""Transmissibility at which slip starts, above which friction hardly damps the resonance. Of 71 random rolls (seed 12),
all six with a higher value have a resonance that grows beyond 500 times the base motion."""

GROSS = 4.5
"""Transmissibility of gross slip below which the layers slide and open widely. For the rolls with a lower value whose
layers are not clamped (six of 78), harmonic balance finds no periodic motion."""


PARTICIPATION = 1.57
"""Participation of the first bending mode at the tip of a uniform cantilever; a tip mass makes it smaller."""


class SlipForecast(NamedTuple):
    """Tip displacements (m) at which slip starts, and at which it is gross, at the interface that slips first."""

    start: float
    gross: float


def slip_forecast(case: StructuralCase) -> SlipForecast | None:
    """Estimated tip displacements of slip; None if they do not apply.

    They apply to rolls with layers, friction and preload whose layers are neither clamped nor held by springs.
    With `coil.base: inner_edge` the innermost layer moves with the mandrel, and the next interface is the first to
    slip.
    """
    if not isinstance(case, OnRoll) or case.coil.model != "layers" or case.preload is None or case.contact is None:
        return None
    g, coil = case.geometry, case.coil
    if layers_clamped(case) or case.friction.law == "smoothed_coulomb" or case.mandrel.base != "clamped":
        return None
    if coil.base == "guided" and coil.base_stiffness:
        return None
    first = 1 if coil.base == "inner_edge" else 0
    begin, end = case.coil_span
    layer = coil.layer_material.in_plane.E_z * coil.layer_thickness
    mandrel = case.mandrel.material.in_plane.E_z * g.mandrel_thickness
    found = []
    for k, (law, pressure) in enumerate(zip(case.interface_laws, interface_pressures(case), strict=True)):
        limit = law.mu * pressure
        if k < first or not limit > 0.0:
            continue
        outside, inside = (coil.layers - k) * layer, mandrel + k * layer
        lag = shear_lag(inside, outside, limit / law.elastic_slip)
        per_tip = (
            outside
            * (0.5 * g.mandrel_outer_diameter + k * coil.layer_thickness)
            * 3.0
            * (g.length - begin)
            / g.length**3
        )
        cover = end - begin
        found.append(SlipForecast(limit * lag / math.tanh(cover / lag) / per_tip, 0.5 * limit * cover / per_tip))
    return min(found, default=None)


def layers_clamped(case: OnRoll) -> bool:
    """Whether all layers are held at the base, so that they bend with the mandrel and hardly slip on it."""
    return case.coil.base == "clamped" or (case.coil.base == "inner_edge" and case.coil.layers == 1)


def _highest_peak(damping: Damping | None) -> float:
    """Largest transmissibility that the first bending mode can have with the material damping of the case."""
    if damping is None or not damping.ratios or not damping.ratios[0] > 0.0:
        return math.inf
    return PARTICIPATION / (2.0 * damping.ratios[0])


def slip_warnings(case: Any) -> list[str]:
    """Warn if friction will hardly damp the resonance at this excitation, or if the layers will slide widely."""
    if not isinstance(case, OnRoll) or case.coil.model != "layers" or case.contact is None:
        return []
    if layers_clamped(case):
        return [
            "the layers are clamped at the base: they bend with the mandrel and hardly slip on it, so that friction "
            "hardly damps the resonance; check that coil.base describes the roll"
        ]
    forecast, excitation, backbone = slip_forecast(case), case.excitation, case.backbone
    if forecast is None:
        return []
    if case.analysis in ("backbone", "random_response") and backbone is not None:
        if forecast.start < 2.0 * backbone.tip_largest:
            return []
        return [
            f"slip is expected to start at a tip displacement of about {forecast.start:.2g} m, above "
            f"backbone.tip_largest = {backbone.tip_largest:.2g} m: no damping at these amplitudes; raise "
            "backbone.tip_largest"
        ]
    amplitude = getattr(excitation, "amplitude", None)
    if amplitude is None:
        return []
    per_metre = (2.0 * math.pi * beam_frequency(case, bonded=True)) ** 2 / amplitude
    start, gross = (per_metre * tip for tip in forecast)
    if start > min(FEW, _highest_peak(case.damping)):
        return [
            f"the interfaces will hardly slip: at this excitation slip is expected to start at a transmissibility of "
            f"about {start:.2g} (tip displacement {forecast.start:.2g} m), so that friction hardly damps the "
            f"resonance: expect {'a sharp peak' if start > FEW else 'the peak of the material damping'}, which a sweep "
            "has to pass slowly"
        ]
    if gross < GROSS:
        return [
            f"expect gross slip: friction holds the layers up to a transmissibility of about {gross:.2g} (tip "
            f"displacement {forecast.gross:.2g} m); above it they slide over most of their area and may open, and "
            "harmonic may find no periodic motion, and a sweep may take hours"
        ]
    return []
