"""Geometric stiffness of a roll in a static state: stresses, follower pressure, contact pressure and rigid tip.

It has the following parts (docs/geometric-stiffness.md):

- stress resultants of the linear static solution, and the tension of the web if that is the load (eq-second-strains);
- external pressure, which follows its surface (eq-volume);
- contact tractions: the pressure acts along the mean director of the two surfaces, so sliding surfaces stay in contact
  along their curvature; friction tractions keep their directions (eq-contact-second);
- the work of the forces on the ring of a rigid tip during the second-order motion of the tip (eq-rigid-tip).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from wroll_fem.bodies.body import Body, Trace
from wroll_fem.contact.point import normals, tangentials
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.fem.body import shell_section
from wroll_fem.fem.layered_shell import shell_model
from wroll_fem.fem.prestress.shell import PrestressedShell, rigid_tip_stiffness
from wroll_fem.fem.shell import AnySection
from wroll_fem.mesh.contact_points import contact_points
from wroll_fem.mesh.generate import shell_layout
from wroll_fem.mesh.shells import CylinderMesh
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case.roll import RollSections


class PrestressedRoll:
    """Bodies of a roll, with the loads and the geometric stiffness of a preload.

    Parameters
    ----------
    roll
        Sections geometry, mandrel, coil and mesh, for example those of a case on a roll.
    bodies
        Bodies of `assemble_bodies`, innermost first, without a solid coil.
    web_tension
        True: the load of a layer is an initial hoop tension of its web, which acts inwards and turns with the web.
        False: it is an external pressure.

    Attributes
    ----------
    bodies
        The bodies, with nodal forces of 1 Pa (`pressure_force`) that are consistent with the geometric stiffness. They
        differ from those of `assemble_bodies` by the discretisation error (1e-4 with 12 cells around).
    """

    def __init__(self, roll: RollSections, bodies: Sequence[Body], *, web_tension: bool):
        self.web_tension = web_tension
        self._walls = [
            _Wall(body, shell_section(roll, index, thickness), radius)
            for index, (body, (_, radius, thickness)) in enumerate(zip(bodies, shell_layout(roll), strict=True))
        ]
        self._centre = np.array([0.0, 0.0, roll.geometry.length])
        self.bodies = [
            replace(wall.body, pressure_force=np.asarray(wall.body.expand.T @ wall.unit_load(web_tension)))
            for wall in self._walls
        ]

    def geometric_stiffness(self, system: System, state: ContactState, pressures: Sequence[float]) -> sp.csr_matrix:
        """(n_dofs, n_dofs) symmetric geometric stiffness due to the preload, N/m; zero without preload.

        Parameters
        ----------
        system
            System of `bodies`.
        state
            Static state of the system under the pressures.
        pressures
            (n_bodies,) pressure on the outside of each body, Pa, or the pressure equivalent to its web tension.
        """
        ends = np.cumsum([body.n_dofs for body in self.bodies])
        parts = np.split(state.displacement, ends[:-1])
        tractions = self._tractions(system, state)
        blocks = [
            wall.stiffness(part, pressure, surfaces, self._centre, web_tension=self.web_tension)
            for wall, part, pressure, surfaces in zip(self._walls, parts, pressures, tractions, strict=True)
        ]
        total = sp.block_diag(blocks, format="csr")
        return sp.csr_matrix(total + _sliding_contact(system, state, self.bodies, [w.thickness for w in self._walls]))

    def _tractions(self, system: System, state: ContactState) -> list[dict[str, FloatArray]]:
        """For each body, a dictionary from surface to (n_points, 3) tractions (normal, hoop, axial), Pa.

        The tractions are forces per area of the mid-surface.
        """
        found: list[dict[str, FloatArray]] = [{} for _ in self.bodies]
        along, across = tangentials(state.traction).reshape(-1, 2), normals(state.traction)
        start = 0
        for k, interface in enumerate(system.interfaces):
            points = slice(start, start + interface.n_points)
            force = interface.areas[:, None] * np.column_stack([across[points], along[points]])
            for side, body, sign in (("outer", k, 1.0), ("inner", k + 1, -1.0)):
                found[body][side] = sign * force / self._walls[body].areas(side)[:, None]
            start += interface.n_points
        return found


class _Wall:
    """One prestressed shell of the roll, with its body."""

    def __init__(self, body: Body, section: AnySection, radius: float):
        self.body, self.section, self.radius = body, section, radius
        self.shell = PrestressedShell(shell_model(body.nodes, body.cells, section), section)

    @property
    def thickness(self) -> float:
        return self.section.thickness

    def height(self, side: str) -> float:
        """Height of a surface above the mid-surface, m."""
        return 0.5 * self.thickness if side == "outer" else -0.5 * self.thickness

    def areas(self, side: str) -> FloatArray:
        """(n_points,) tributary area of each contact point on the mid-surface, m^2."""
        return self.body.traces[side].areas * self.radius / (self.radius + self.height(side))

    def unit_load(self, web_tension: bool) -> FloatArray:
        """(6 n_nodes,) nodal forces, N, of an external pressure of 1 Pa or of the equivalent web tension."""
        if web_tension:
            return (self.radius + self.height("outer")) * self.shell.tension_load()
        return self.shell.pressure_load(self.height("outer"))

    def stiffness(
        self,
        displacement: FloatArray,
        pressure: float,
        tractions: dict[str, FloatArray],
        centre: FloatArray,
        *,
        web_tension: bool,
    ) -> sp.csr_matrix:
        """(n_dofs, n_dofs) geometric stiffness of this shell: stresses, follower pressure, tractions, rigid tip."""
        nodal = self.body.expand @ displacement
        outer = self.height("outer")
        tension = pressure * (self.radius + outer) if web_tension else 0.0
        total = self.shell.geometric_stiffness(nodal, tension)
        unbalanced = self.shell.model.stiffness(self.section) @ nodal
        if pressure:
            unbalanced -= pressure * self.unit_load(web_tension)
            if not web_tension:
                total = total + pressure * self.shell.pressure_stiffness(outer)
        for side, values in tractions.items():
            forces, second = self.shell.surface_traction(
                self._on_cells(values, self.body.traces[side]), self.height(side)
            )
            unbalanced -= forces
            total = total + second
        expand = self.body.expand
        return sp.csr_matrix(expand.T @ total @ expand + self._tip(unbalanced.reshape(-1, 6)[:, :3], centre))

    def _on_cells(self, values: FloatArray, trace: Trace) -> FloatArray:
        """(9 n_cells, 3) tractions at the nodes of each cell, interpolated with the contact points' shape functions.

        The ``values`` (n_points, 3) are the tractions at the contact points of ``trace``.
        """
        at = contact_points(CylinderMesh(self.body.nodes, self.body.cells, {}))
        theta = np.abs(at.points[:, 0]) if self.body.symmetric else at.points[:, 0]
        wanted, held = (
            np.column_stack([self.radius * np.cos(angle), self.radius * np.sin(angle), height])
            for angle, height in ((theta, at.points[:, 1]), (trace.points[:, 0], trace.points[:, 1]))
        )
        found = values[cKDTree(held).query(wanted)[1]]
        if self.body.symmetric:
            found[at.points[:, 0] < 0.0, 1] *= -1.0
        return np.column_stack([at.normal_shapes @ found[:, 0], at.shapes @ found[:, 1:]])

    def _tip(self, forces: FloatArray, centre: FloatArray) -> sp.csr_matrix:
        """(n_dofs, n_dofs) geometric stiffness for the rotation of a rigid tip; zero without a rigid tip."""
        body = self.body
        n = body.n_dofs
        if body.unknown_node is None or body.unknown_component is None or not (body.unknown_node == -1).any():
            return sp.csr_matrix((n, n))
        turn = np.flatnonzero((body.unknown_node == -1) & (body.unknown_component >= 3))
        axes = body.unknown_component[turn] - 3
        ring = np.flatnonzero(np.diff(body.expand[:, turn].tocsr().indptr).reshape(-1, 6)[:, 3:].any(axis=1))
        stiffness = rigid_tip_stiffness(forces[ring], body.nodes[ring] - centre)[np.ix_(axes, axes)]
        rows, cols = np.meshgrid(turn, turn, indexing="ij")
        return sp.csr_matrix((stiffness.ravel(), (rows.ravel(), cols.ravel())), shape=(n, n))


def _sliding_contact(
    system: System, state: ContactState, bodies: Sequence[Body], thicknesses: Sequence[float]
) -> sp.csr_matrix:
    """(n_dofs, n_dofs) geometric stiffness due to the contact pressure.

    It results from the rotation of the mean director of sliding surfaces. The energy is pressure times area
    times relative tangential displacement times change of the mean director.
    """
    n = system.n_dofs
    if not system.interfaces:
        return sp.csr_matrix((n, n))
    starts = np.concatenate([[0], np.cumsum([body.n_dofs for body in bodies])])
    turns = [
        sp.hstack([
            sp.csr_matrix((operator.shape[0], a)), operator, sp.csr_matrix((operator.shape[0], n - b))
        ], format="csr")
        for operator, (a, b) in zip(map(_director_turn, bodies, thicknesses), pairwise(starts), strict=True)
    ]  # fmt: skip
    half = sp.csr_matrix((n, n))
    pressure, start = normals(state.traction), 0
    for k, interface in enumerate(system.interfaces):
        rows = (3 * np.arange(interface.n_points)[:, None] + [1, 2]).ravel()
        force = interface.areas * pressure[start : start + interface.n_points]
        mean = 0.5 * (turns[k] + turns[k + 1])[rows]
        half = half + interface.operator[rows].T @ sp.diags(np.repeat(force, 2)) @ mean
        start += interface.n_points
    return sp.csr_matrix(half + half.T)


def _director_turn(body: Body, thickness: float) -> sp.csr_matrix:
    """(3 n_points, n_dofs) operator for the weighted mean first-order change of the director at each contact point."""
    return sp.csr_matrix((body.traces["outer"].operator - body.traces["inner"].operator) / thickness)
