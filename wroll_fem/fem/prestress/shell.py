r"""Geometric stiffness of a prestressed shell: stresses, follower pressure, tractions on its surfaces.

A point at height xi moves by u + xi (R d - d) with the finite rotation R d = d + a_1 + a_2 + ..., a_1 = theta x d and
a_2 = theta x (theta x d) / 2. The Green-Lagrange strains of the mid-surface have the second-order parts
(docs/geometric-stiffness.md, eq-second-strains)

    eps_2   = 1/2 (grad u P)^T (grad u P)
    kappa_2 = sym((grad u P)^T grad a_1 P + P^T grad a_2 P)
    gamma_2 = (grad u P)^T a_1 + P^T a_2

and the geometric stiffness is the second derivative of int N : eps_2 + M : kappa_2 + Q . gamma_2 dA. N, M and Q are the
resultants of the static state, taken at the integration points of the linear stiffness. A rigid rotation w then has
exactly the energy -f . q_2, with the nodal forces f of the state and q_2 = w x (w x x) / 2. The drilling term has no
second-order part, because the gradient of w x (w x x) is symmetric.

A surface at height h has the position y = x + h d and moves by v = u + h (a_1 + a_2). An inward pressure of 1 Pa has
the second-order potential (subscripts 1 and 2: derivatives along e_1 and e_2)

    V = int (y_1 x y_2) . v + 1/2 (v_1 x y_2 + y_1 x v_2) . v dA,

the change of the enclosed volume (eq-volume). Its second derivative is the symmetric part of the follower stiffness.
The skew part is an integral over the edges, and vanishes where they are held.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem

from wroll_fem.fem import compat
from wroll_fem.fem.shell import AnySection, ShellModel, split
from wroll_fem.fem.trace import cell_node_rows, cylinder_frame
from wroll_fem.typing import FloatArray


class PrestressedShell:
    """Loads and geometric stiffness of one prestressed shell; matrices are node-major, (6 n_nodes, 6 n_nodes).

    Parameters
    ----------
    model
        The shell.
    section
        Material and thickness.
    """

    def __init__(self, model: ShellModel, section: AnySection):
        self.model, self.section = model, section
        self._state = fem.Function(model.space, name="state")
        self._motion = fem.Function(model.space, name="motion")
        per_cell = compat.function_space(model.mesh, compat.discontinuous("quadrilateral", 2, components=3))
        self._traction = fem.Function(per_cell, name="traction")
        self._traction_rows = cell_node_rows(model, per_cell)
        self._tension = fem.Constant(model.mesh, 0.0)
        self._height = fem.Constant(model.mesh, 0.0)

    # ---- stress resultants -----------------------------------------------------------------------------------------

    def _hoop_tension(self) -> Any:
        """Membrane force (2 x 2) of the initial hoop tension, in the tangent basis."""
        P, _ = self.model.tangents()
        hoop = P.T * cylinder_frame(ufl.SpatialCoordinate(self.model.mesh))[1]
        return self._tension * ufl.outer(hoop, hoop)

    @cached_property
    def _stress_form(self) -> Any:
        """Compiled second derivative of the work of the stress resultants on the second-order strains."""
        model = self.model
        u, first, second = finite_rotation(self._motion, model.director)
        P, _ = model.tangents()
        slope_u, slope_1, slope_2 = ufl.grad(u) * P, ufl.grad(first) * P, ufl.grad(second) * P
        eps = 0.5 * slope_u.T * slope_u
        kappa = ufl.sym(slope_u.T * slope_1 + P.T * slope_2)
        gamma = slope_u.T * first + P.T * second
        return self._hessian(model.work(self._state, eps, kappa, gamma, tension=self._hoop_tension()))

    @cached_property
    def _tension_form(self) -> Any:
        eps = self.model.strains(ufl.TestFunction(self.model.space))[0]
        return compat.compile_form(self.model.integral(-ufl.inner(self._hoop_tension(), eps)))

    def geometric_stiffness(self, state: FloatArray, hoop_tension: float = 0.0) -> sp.csr_matrix:
        """Geometric stiffness, N/m, due to the stresses in a static state.

        Parameters
        ----------
        state
            (6 n_nodes,) nodal displacements (m) and rotations (rad), from which the resultants follow linearly.
        hoop_tension
            Initial hoop tension, N/m, in addition to these resultants.
        """
        self.model.use(self.section)
        self._state.x.array[self.model.dof_order] = state
        self._tension.value = hoop_tension
        return self.model.reorder(compat.assemble_csr(self._stress_form))

    def tension_load(self) -> FloatArray:
        """(6 n_nodes,) inward nodal forces, N, equivalent to an initial hoop tension of 1 N/m."""
        self.model.use(self.section)
        self._tension.value = 1.0
        return compat.assemble_array(self._tension_form)[self.model.dof_order]

    # ---- pressure --------------------------------------------------------------------------------------------------

    @cached_property
    def _pressure_forms(self) -> tuple[Any, Any]:
        """Forces and follower stiffness of an inward pressure of 1 Pa on a surface, from the pressure potential."""
        model, h = self.model, self._height
        u, first, second = finite_rotation(self._motion, model.director)
        P, normal = model.tangents()
        y, v = P + h * ufl.grad(model.director) * P, ufl.grad(u + h * first) * P
        outward = ufl.sign(ufl.dot(normal, model.director))
        area = outward * ufl.cross(y[:, 0], y[:, 1])
        turned = outward * (ufl.cross(v[:, 0], y[:, 1]) + ufl.cross(y[:, 0], v[:, 1]))
        linear = ufl.dot(area, u + h * first)
        quadratic = ufl.dot(area, h * second) + 0.5 * ufl.dot(turned, u + h * first)
        load = -ufl.derivative(model.area_integral(linear), self._motion, ufl.TestFunction(model.space))
        return compat.compile_form(load), self._hessian(model.area_integral(quadratic))

    def pressure_load(self, height: float) -> FloatArray:
        """(6 n_nodes,) nodal forces, N, of an inward pressure of 1 Pa at `height` (m) above the mid-surface."""
        self._height.value = height
        return compat.assemble_array(self._pressure_forms[0])[self.model.dof_order]

    def pressure_stiffness(self, height: float) -> sp.csr_matrix:
        """Symmetric part of the follower stiffness, N/m, of an inward pressure of 1 Pa at `height` (m)."""
        self._height.value = height
        return self.model.reorder(compat.assemble_csr(self._pressure_forms[1]))

    # ---- tractions of the contact ----------------------------------------------------------------------------------

    @cached_property
    def _traction_forms(self) -> tuple[Any, Any]:
        """Nodal forces and geometric stiffness due to a surface traction of fixed direction, derived from its work."""
        model, h = self.model, self._height
        u, first, second = finite_rotation(self._motion, model.director)
        frame = cylinder_frame(ufl.SpatialCoordinate(model.mesh))
        traction = sum(self._traction[c] * frame[c] for c in range(3))
        linear = model.area_integral(ufl.dot(traction, u + h * first))
        load = ufl.derivative(linear, self._motion, ufl.TestFunction(model.space))
        return compat.compile_form(load), self._hessian(model.area_integral(-h * ufl.dot(traction, second)))

    def surface_traction(self, values: FloatArray, height: float) -> tuple[FloatArray, sp.csr_matrix]:
        """Nodal forces and geometric stiffness of tractions of fixed direction at the contact points of a surface.

        Parameters
        ----------
        values
            (9 n_cells, 3) normal, hoop and axial traction on this shell, Pa relative to the mid-surface, at the nodes
            of each cell: the shape functions of `mesh.contact_points` times the tractions at the points.
        height
            Height of the surface above the mid-surface, m.

        Returns
        -------
        forces : (6 n_nodes,) N.
        stiffness : (6 n_nodes, 6 n_nodes) N/m, from the second-order change of the director.
        """
        self._height.value = height
        self._traction.x.array.reshape(-1, 3)[:] = values[self._traction_rows]
        load, second = self._traction_forms
        return compat.assemble_array(load)[self.model.dof_order], self.model.reorder(compat.assemble_csr(second))

    def _hessian(self, energy: Any) -> Any:
        """Compiled second derivative of an energy with respect to the motion."""
        gradient = ufl.derivative(energy, self._motion, ufl.TestFunction(self.model.space))
        return compat.compile_form(ufl.derivative(gradient, self._motion, ufl.TrialFunction(self.model.space)))


def finite_rotation(q: Any, director: Any) -> tuple[Any, Any, Any]:
    """Displacement u of a field q = [u, theta], and the first-order and second-order changes of the director."""
    u, theta = split(q)
    first = ufl.cross(theta, director)
    return u, first, 0.5 * ufl.cross(theta, first)


def rigid_tip_stiffness(forces: FloatArray, arms: FloatArray) -> FloatArray:
    """(3, 3) geometric stiffness, N m, for the rotation of a rigid ring, due to the forces at its nodes.

    A node at the position r moves by Omega x r + Omega x (Omega x r) / 2. The second-order energy of the force g at
    this node is therefore [(g . Omega)(r . Omega) - (g . r) |Omega|^2] / 2.

    Parameters
    ----------
    forces
        (n, 3) derivative of the energy with respect to the displacement of each node, N: minus the force that the ring
        exerts on the node.
    arms
        (n, 3) positions relative to the centre of the ring, m.
    """
    product = forces.T @ arms
    return np.asarray(0.5 * (product + product.T) - np.trace(product) * np.eye(3))
