"""Closed-form estimates of a roll: first frequency, hoop buckling, interface pressures, shear lag, root element."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from wroll_fem.case import RollSections
    from wroll_fem.case.mandrel import Mandrel
    from wroll_fem.case.structural import OnRoll
    from wroll_fem.contact.law import FrictionLaw
    from wroll_fem.typing import FloatArray

DEPTH_ITERATIONS = 20
"""Iterations for the depth to which a solid coil takes part in the shear lag; each halves the error or better."""

RIGID = 1e-3
"""Frequency, Hz, below which a motion of a free beam counts as rigid."""


def beam_frequency(roll: RollSections, *, bonded: bool, added_mass: bool = True) -> float:
    """First bending frequency in Hz of the roll as a beam with shear flexibility; the error is a few per cent.

    With `coil.per_wrap` the layers stick by the elastic slip of all wrap interfaces (`StickingTube`), which
    lowers the frequency; without it the coil is bonded. For a cantilever with a tip mass it is that of Rayleigh: 33/140
    of the mass of the beam acts at the tip. With other supports, or an inertia of the tip mass, it is that of a beam of
    finite elements (`SprungBeam`).

    Parameters
    ----------
    roll
        Case sections of the roll.
    bonded
        Whether the coil adds stiffness.
    added_mass
        Whether the coil adds mass.
    """
    g, m, coil = roll.geometry, roll.mandrel, roll.coil
    if bonded and coil.per_wrap and (found := _sticking(roll, added_mass=added_mass)) is not None:
        return found
    whole = (0.0, g.length)
    radius = 0.5 * g.mandrel_outer_diameter - 0.5 * g.mandrel_thickness
    tubes = [_Tube(m.material, radius, g.mandrel_thickness, whole)]
    if coil.model != "none":
        radius = 0.5 * g.mandrel_outer_diameter + 0.5 * coil.total_thickness
        tubes.append(_Tube(coil.material, radius, coil.total_thickness, roll.coil_span))
    heavy = tubes if added_mass else tubes[:1]
    stiff = tubes if bonded and coil.model != "nonstructural_mass" else tubes[:1]
    if not m.is_cantilever:
        bending, shear = (sum(tube.covers(*whole) * getattr(tube, name) for tube in stiff) for name in _STIFFNESSES)
        return _on_springs(m, g.length, bending, shear, sum(t.mass for t in heavy) / g.length)
    compliance, borders = 0.0, sorted({0.0, *roll.coil_span, g.length})
    for low, high in pairwise(borders):
        bending, shear = (sum(tube.covers(low, high) * getattr(tube, name) for tube in stiff) for name in _STIFFNESSES)
        compliance += ((g.length - low) ** 3 - (g.length - high) ** 3) / (3 * bending) + (high - low) / shear
    at_tip = sum(tube.mass * _share_at_tip(*tube.span, g.length) for tube in heavy)
    return math.sqrt(1 / (compliance * (m.tip_mass + at_tip))) / (2 * math.pi)


_STIFFNESSES = ("bending", "shear")


class _Tube(NamedTuple):
    """Thin tube of a beam: material, radius, thickness and span (heights of its ends), m."""

    material: Any
    radius: float
    thickness: float
    span: tuple[float, float]

    @property
    def area(self) -> float:
        """Area of the cross-section, m^2."""
        return 2 * math.pi * self.radius * self.thickness

    @property
    def bending(self) -> float:
        """Bending stiffness, N m^2."""
        return float(self.material.in_plane.E_z * math.pi * self.radius**3 * self.thickness)

    @property
    def shear(self) -> float:
        """Shear stiffness, N."""
        return float(self.material.in_plane.G_z_theta * self.area / 2)

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return float(self.material.rho * self.area * (self.span[1] - self.span[0]))

    def covers(self, low: float, high: float) -> float:
        """Share of the heights from ``low`` to ``high``, m, that the tube covers."""
        return max(0.0, min(high, self.span[1]) - max(low, self.span[0])) / (high - low)


def _share_at_tip(low: float, high: float, length: float) -> float:
    """Mass at the tip with the kinetic energy of a uniform mass between two heights, m, divided by this mass.

    The cantilever has the deflection of a force at its tip; along its whole length the share is 33/140.
    """
    low, high = low / length, high / length
    below, above = (x**5 * (9 / 5 - x + x**2 / 7) / 4 for x in (low, high))
    return (above - below) / (high - low)


def _sticking(roll: Any, *, added_mass: bool) -> float | None:
    """First bending frequency in Hz of layers that stick on each other; None without friction that sticks."""
    if roll.preload is None or roll.contact is None or roll.friction.law == "smoothed_coulomb":
        return None
    from wroll_fem.bodies.sticking_tubes import StickingTube, lowest_frequency

    g, m, coil = roll.geometry, roll.mandrel, roll.coil
    outer, t = 0.5 * g.mandrel_outer_diameter, coil.layer_thickness
    tubes = [_Tube(m.material, outer - 0.5 * g.mandrel_thickness, g.mandrel_thickness, (0.0, g.length))]
    tubes += [_Tube(coil.material, outer + (k + 0.5) * t, t, roll.coil_span) for k in range(coil.layers)]
    tilts: dict[str, list[float | None]] = {
        "free": [0.0] * coil.layers, "clamped": [None] * coil.layers, "inner_edge": [None] + [0.0] * (coil.layers - 1),
        "guided": [math.pi * tube.radius**3 * coil.base_stiffness for tube in tubes[1:]],
    }  # fmt: skip
    lateral, tilt, tip_stiffness, tip_mass = _ends(m)
    heavy = [tube.mass / (tube.span[1] - tube.span[0]) * (added_mass or not k) for k, tube in enumerate(tubes)]
    laws = zip(roll.interface_laws, interface_pressures(roll), strict=True)
    return lowest_frequency(
        [
            StickingTube(tube.radius, tube.bending, tube.shear, mass, tube.span, base)
            for tube, mass, base in zip(tubes, heavy, [tilt, *tilts[coil.base]], strict=True)
        ],
        [(outer + k * t, law.mu * pressure / law.elastic_slip) for k, (law, pressure) in enumerate(laws)], g.length,
        lateral=lateral, tip_stiffness=tip_stiffness, tip_mass=tip_mass,
    )  # fmt: skip


def _ends(mandrel: Mandrel) -> tuple[float | None, float | None, FloatArray | None, FloatArray]:
    """Lateral and tilt stiffness of the base (None: held), and (2, 2) stiffness and mass for both at the tip."""
    import numpy as np

    from wroll_fem.bodies.rigid_ends import rigid_mass, spring_matrix

    plane = np.ix_([0, 4], [0, 4])  # along x and about y
    turn = mandrel.tip_inertia
    body = rigid_mass(mandrel.tip_mass, turn.transverse if turn else 0.0, 0.0, mandrel.tip_offset or 0.0)
    held, springs = mandrel.springs, mandrel.tip_springs
    lateral, tilt = (
        (0.0, 0.0) if mandrel.base == "free" else (None, None) if held is None else (held.lateral, held.tilt)
    )
    return lateral, tilt, None if springs is None else spring_matrix(springs.six)[plane], body[plane]


def _on_springs(mandrel: Mandrel, length: float, bending: float, shear: float, mass: float) -> float:
    """First bending frequency in Hz with the supports and the tip body of a mandrel; ``mass`` in kg/m."""
    from wroll_fem.bodies.beam_modes import SprungBeam

    lateral, tilt, tip_stiffness, tip_mass = _ends(mandrel)
    beam = SprungBeam(
        length, bending, shear, mass, 0.0, base=(lateral, tilt), tip_stiffness=tip_stiffness, tip_mass=tip_mass
    )
    moving = [f for f in beam.frequencies(3).tolist() if f > RIGID]
    return float(moving[0]) if moving else 0.0


def bending_wave(roll: RollSections, wavelength: float) -> float:
    """Frequency in Hz at which bending waves of the roll with bonded layers have a wavelength in m; with shear."""
    g, coil = roll.geometry, roll.coil
    radius = 0.5 * (g.mandrel_outer_diameter - g.mandrel_thickness)
    tubes = [_Tube(roll.mandrel.material, radius, g.mandrel_thickness, (0.0, g.length))]
    if coil.model != "none":
        radius = 0.5 * (g.mandrel_outer_diameter + coil.total_thickness)
        tubes.append(_Tube(coil.material, radius, coil.total_thickness, roll.coil_span))
    stiff = tubes if coil.model in ("layers", "bonded", "solid") else tubes[:1]
    bending, shear = (sum(getattr(tube, name) for tube in stiff) for name in _STIFFNESSES)
    number, mass = 2 * math.pi / wavelength, sum(tube.mass for tube in tubes) / g.length
    return math.sqrt(1.0 / (mass / (bending * number**4) + mass / (shear * number**2))) / (2 * math.pi)


def buckling_pressure(roll: RollSections) -> float:
    """Linear hoop-buckling pressure in Pa: sum of mandrel and layers, each a short tube whose ends stay circular.

    Of a roll with a solid coil it is that of the mandrel.

    Windenburg and Trilling's formula for a tube is p = 2.42 E (t/D)^2.5 / ((1 - nu^2)^0.75 (L/D - 0.45 (t/D)^0.5)).
    It is infinite for a tube so short that its ends keep all of it round, L/D <= 0.45 (t/D)^0.5.
    """
    g, coil = roll.geometry, roll.coil
    tubes = [(roll.mandrel.material, g.mandrel_outer_diameter - g.mandrel_thickness, g.mandrel_thickness, 1)]
    if coil.bending and coil.model != "solid":
        tubes.append(
            (coil.layer_material, g.mandrel_outer_diameter + coil.total_thickness, coil.layer_thickness, coil.layers)
        )
    total = 0.0
    for material, diameter, thickness, count in tubes:
        slender = thickness / diameter
        length = g.length / diameter - 0.45 * math.sqrt(slender)
        if length <= 0:
            return math.inf
        E, nu = material.in_plane.E_theta, material.in_plane.nu_theta_z
        total += count * 2.42 * E * slender**2.5 / ((1 - nu**2) ** 0.75 * length)
    return total


def interface_pressures(case: OnRoll) -> list[float]:
    """Estimated pressure in Pa at each interface, inner first; rings share the load in proportion to E t / R^2.

    The rings are thin, and end effects are neglected. The pressure of an interface that opens is zero. A solid coil is
    a thick ring (`transmitted_pressure`).
    """
    g, coil = case.geometry, case.coil
    if case.preload is None:
        return [0.0] * coil.layers
    if case.preload.kind != "external_pressure":
        from wroll_fem.winding.interface import prescribed_pressures

        return prescribed_pressures(case, case.preload, case.wound).tolist()
    if coil.rubs:
        from wroll_fem.winding.interface import transmitted_pressure

        return [transmitted_pressure(case) * sum(case.preload.per_layer(1))]
    pressures = case.preload.per_layer(coil.layers)
    core = case.mandrel.material.in_plane.E_theta * g.mandrel_thickness / (0.5 * g.mandrel_outer_diameter) ** 2
    ring = coil.layer_material.in_plane.E_theta * coil.layer_thickness / (0.5 * g.mandrel_outer_diameter) ** 2
    shift = sum(pressures) / (core + coil.layers * ring)
    return [max(0.0, sum(pressures[k:]) - (coil.layers - k) * ring * shift) for k in range(coil.layers)]


def shear_lag_length(roll: RollSections, law: FrictionLaw, pressure: float) -> float:
    """Shear-lag length in m of the transfer of axial force between layer and mandrel.

    It is sqrt(s / k_t). s is the series connection of the axial stiffnesses E t of mandrel and layer; k_t is the stick
    stiffness. The length is infinite if the friction law has no stick stiffness.

    Parameters
    ----------
    roll
        Case sections of a roll with layers.
    law
        Friction law of the interface.
    pressure
        Interface pressure, Pa.
    """
    mandrel = roll.mandrel.material.in_plane.E_z * roll.geometry.mandrel_thickness
    modulus, depth = roll.coil.material.in_plane.E_z, roll.coil.layer_thickness
    if law.name == "smoothed_coulomb":  # sticks nowhere
        return math.inf
    stick = law.mu * pressure / law.elastic_slip
    if roll.coil.rubs:  # a thick coil takes part to a depth of about the length itself
        for _ in range(DEPTH_ITERATIONS):
            depth = min(roll.coil.total_thickness, shear_lag(mandrel, modulus * depth, stick))
    return shear_lag(mandrel, modulus * depth, stick)


def shear_lag(inside: float, outside: float, stick: float) -> float:
    """Shear-lag length in m between shells of axial stiffness E t (N/m) inside and outside of an interface.

    ``stick`` is the stick stiffness of the interface, Pa/m; the length is infinite without it.
    """
    return math.sqrt(inside * outside / (inside + outside) / stick) if stick > 0 else math.inf


def root_element_height(roll: RollSections) -> float:
    """Height in m of the element row at the base of the coil in the generated mesh."""
    n, grading = roll.mesh.axial, roll.mesh.grading
    low, high = roll.coil_span
    if n < 2 or grading == 1:
        return (high - low) / n
    ratio = grading ** (1 / (n - 1))
    return (high - low) * (ratio - 1) / (ratio**n - 1)
