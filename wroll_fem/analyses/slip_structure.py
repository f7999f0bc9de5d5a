"""Solid coil whose wraps slide: its system with friction at every point, and the properties between its wraps."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy.sparse as sp

from wroll_fem.analyses.shared.assembly import DIRECTIONS, build_bodies, build_system, with_base_loads, with_probes
from wroll_fem.analyses.shared.material_damping import with_damping
from wroll_fem.analyses.slip_model import in_wound_roll
from wroll_fem.analyses.transient_results import CoilShape
from wroll_fem.bodies.base_loads import axial_rotation
from wroll_fem.bodies.body import Body
from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.coiled_stiff.shear_points import ShearPoints, radial_stress
from wroll_fem.coiled_stiff.slipping_coil import with_slip
from wroll_fem.coiled_stiff.wrap_stiffness import radial_change, shear_modulus, with_radial_modulus
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray
from wroll_fem.winding import wound_roll

if TYPE_CHECKING:
    from wroll_fem.case.structural import OnRoll
    from wroll_fem.progress import Progress


AXIAL = 2
"""Direction of a base motion along the axis."""


class BetweenWraps(NamedTuple):
    """Properties between the wraps at n radii: `pressure`, `shear_modulus` and `radial_modulus`, each (n,) in Pa."""

    pressure: FloatArray
    shear_modulus: FloatArray
    radial_modulus: FloatArray


class WoundCoil:
    """Coil of a case with the stress of its wound roll.

    Parameters
    ----------
    case
        Its sections geometry, coil and winding are used.
    """

    def __init__(self, case: OnRoll):
        wound = case.wound
        assert wound is not None
        inner = 0.5 * case.geometry.mandrel_outer_diameter
        self._shape = CoilShape(inner, inner + case.coil.total_thickness, case.geometry.length)
        self._wound, self._thickness = wound_roll(wound), wound.wrap_thickness
        self._web, self._interfaces, self._mu = case.coil.solid(), case.coil.wrap_interfaces, wound.mu or 0.0

    @property
    def follows(self) -> bool:
        """Whether the radial modulus follows the pressure."""
        return self._interfaces is not None and self._interfaces.radial_modulus == "winding"

    def at(self, radius: FloatArray) -> BetweenWraps:
        """Pressure, shear modulus and radial modulus between the wraps at radii (n,), m.

        Raises
        ------
        InputError
            If the radial modulus of the wound roll and the other constants of the coil are not admissible.
        """
        web, interfaces, wound = self._web, self._interfaces, self._wound
        pressure = wound.pressure_at(in_wound_roll(radius, self._shape, wound.radius))
        shear, radial = np.full_like(pressure, web.G_r_z), np.full_like(pressure, web.E_r)
        if interfaces is not None:
            shear = shear_modulus(
                web.G_r_z, pressure, mu=self._mu, elastic_slip=interfaces.elastic_slip, wrap_thickness=self._thickness
            )
        if self.follows:
            radial = wound.modulus(pressure)
            _check_admissible(web, radial)
        return BetweenWraps(pressure, shear, radial)


def _check_admissible(web: CylindricalOrthotropic, radial: FloatArray) -> None:
    for modulus in (float(radial.min()), float(radial.max())):
        try:
            replace(web, E_r=modulus)
        except InputError as error:
            raise InputError(
                f"the law gives {modulus:.4g} Pa in the coil, with which {error.key} {error.problem}",
                key="winding.web.radial_modulus",
                remedy="give a law that fits coil.material, or coil.wrap_interfaces.radial_modulus: material",
            ) from None


def slipping_roll(case: OnRoll, progress: Progress) -> tuple[System, ContactState]:
    """System of a case whose wraps slide, with damping, probes and loads at the base, and its state at rest.

    Raises
    ------
    InputError
        If a point of the coil has no friction capacity.
    """
    with progress.stage("mesh and matrices", 1) as stage:
        bodies, _, system, start = _structure(case)
        direction = DIRECTIONS[case.direction]
        system = with_damping(case, system, bodies)
        system = with_probes(system, bodies, case.probes or {}, direction)
        system = with_base_loads(system, bodies, direction, case.geometry.length)
        stage.update(1, f"{system.n_dofs} DOFs, {system.n_points} points between the wraps")
    return system, start


def slipping_structure(case: OnRoll) -> tuple[Body, ShearPoints, System, ContactState]:
    """Body and points of the coil of a case, its system with friction at these points, and the state at rest.

    Raises
    ------
    InputError
        If a point of the coil has no friction capacity.
    """
    bodies, points, system, start = _structure(case)
    return bodies[-1], points, system, start


def _structure(case: OnRoll) -> tuple[list[Body], ShearPoints, System, ContactState]:
    motion, wound = getattr(case.excitation, "mode", "bending"), case.wound
    assert wound is not None
    *others, body = build_bodies(case, symmetric=False if motion == "torsion" else None)
    assert body.solid is not None
    points = ShearPoints.of(body.solid)
    points = points.half() if body.symmetric else points
    coil = WoundCoil(case)
    at = coil.at(points.points[:, 2])
    if coil.follows:
        reference = case.coil.solid().stiffness()
        stiffness = with_radial_modulus(body.stiffness, body.solid, reference, lambda r: coil.at(r).radial_modulus)
        body = replace(body, stiffness=stiffness)
    bodies = [*others, body]
    direction = AXIAL if motion == "axial" else DIRECTIONS[case.direction]
    system = build_system(case, bodies) if others else System.from_bodies(bodies, direction=direction)
    on_mandrel = np.zeros(0) if system.initial_pressure is None else system.initial_pressure
    system = with_slip(
        system, body, points, shear_modulus=at.shear_modulus, pressure=at.pressure, mu=wound.friction_coefficient,
        wrap_thickness=wound.wrap_thickness, varying=case.coil.pressure == "varying",
    )  # fmt: skip
    start = ContactState.pressed(system, np.append(on_mandrel, at.pressure))
    if motion == "torsion":
        system = twisted(system, body, 0.5 * case.geometry.mandrel_outer_diameter)
    return bodies, points, system, start


def stress_rows(body: Body, points: ShearPoints, stiffness: FloatArray, modulus: FloatArray) -> sp.csr_matrix:
    """(n_points, n_dofs) rows of the radial stress at the points, Pa/m.

    Parameters
    ----------
    stiffness
        (6, 6) stiffness of the coil with the radial modulus of its material, Pa.
    modulus
        (n_points,) radial modulus at the points, Pa.
    """
    assert body.solid is not None
    rows = radial_stress(body.solid, stiffness)
    rows = rows[points.kept] if points.kept is not None else rows
    return (sp.diags(radial_change(modulus, stiffness)) @ rows @ body.solid.expand).tocsr()


def twisted(system: System, body: Body, radius: float) -> System:
    """System whose base turns about the axis, with the displacement at ``radius``, m, as the motion of base and tip.

    The tip probe is the mean hoop displacement of the tip ring, at this radius.
    """
    nodes = body.nodes
    ring = np.flatnonzero(nodes[:, 2] > nodes[:, 2].max() - 1e-9 * np.ptp(nodes[:, 2]))
    at = np.hypot(*nodes[ring, :2].T)
    row = np.zeros(6 * len(nodes))
    row[6 * ring], row[6 * ring + 1] = -nodes[ring, 1] / at, nodes[ring, 0] / at
    row[6 * ring] *= radius / at / len(ring)
    row[6 * ring + 1] *= radius / at / len(ring)
    return replace(system, influence=axial_rotation(body) / radius, probes={"tip": row @ body.expand})
