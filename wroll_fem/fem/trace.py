"""Displacement of the surfaces of a shell at its contact points (docs/theory.md, eq-jump).

With the shape function psi_k of the traction at point k (`wroll_fem.mesh.contact_points`), the height xi of the surface
above the mid-surface and the cylindrical unit vectors e_c of the roll,

    motion[k, c] = 1 / A_k  int psi_k (u + xi theta x d) . e_c dA,     A_k = int psi_k dA,

so tractions t_k at the points do the same work as the traction sum_k t_k psi_k on the surface. The normal component has
its own shape functions. The psi_k sum to 1, so uniform tractions in the cylindrical frame are exact. The two surfaces
of an interface have the same points, in the same order, and the same areas.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem

from wroll_fem.fem import compat
from wroll_fem.fem.shell import ShellModel
from wroll_fem.mesh.contact_points import ContactPoints
from wroll_fem.typing import BoolArray, FloatArray, IntArray

_DEGREE = 4


def cylinder_frame(x: Any) -> list[Any]:
    """Cylindrical unit vectors (normal, hoop, axial) about the z axis, at a position given in UFL.

    The vectors are derived from the axis. A frame derived from the components of the normal would change its sign
    around the roll.
    """
    radius = ufl.sqrt(x[0] ** 2 + x[1] ** 2)
    normal = ufl.as_vector([x[0] / radius, x[1] / radius, 0.0 * x[2]])
    hoop = ufl.as_vector([-x[1] / radius, x[0] / radius, 0.0 * x[2]])
    axial = ufl.as_vector([0.0 * x[0], 0.0 * x[0], 1.0 + 0.0 * x[2]])
    return [normal, hoop, axial]


def cell_node_rows(model: ShellModel, space: fem.FunctionSpace) -> IntArray:
    """Row numbers (9 n_cells,) that reorder nodal values from cell-by-cell order to the order of a function space.

    The space is discontinuous and quadratic. Row 9 c + a is the value at node ``model.cells[c, a]`` seen from cell c.
    """
    cells, found = model.cells, model.cell_nodes
    cell_of_centre = np.empty(len(model.nodes), np.int64)
    cell_of_centre[cells[:, 8]] = np.arange(len(cells))
    cell = cell_of_centre[found[:, 8]]
    local = np.empty_like(found)  # place of each node in the input cell
    np.put_along_axis(local, found.argsort(axis=1), cells[cell].argsort(axis=1), axis=1)
    rows = np.empty(found.size, np.int64)
    rows[compat.cell_dofs(space).ravel()] = (9 * cell[:, None] + local).ravel()
    return rows


def half_circumference(points: FloatArray, symmetric: bool) -> tuple[BoolArray, FloatArray]:
    """Contact points (n, 3) that a model keeps, and the number of points for which each of them stands.

    A model of the motions symmetric about the x-z plane keeps those with theta in [0, pi]. The points off the plane
    stand for two.
    """
    weight, keep = np.ones(len(points)), np.ones(len(points), bool)
    if symmetric:
        on_plane = np.abs(np.sin(points[:, 0])) < 1e-9
        keep = (points[:, 0] >= 0.0) | on_plane
        weight[~on_plane] = 2.0
    return keep, weight


class SurfaceTrace:
    """Weighted mean displacement of a shell at each contact point; the weight is the shape function of the point.

    Parameters
    ----------
    model
        The shell.
    contact
        Contact points of the shell.
    """

    def __init__(self, model: ShellModel, contact: ContactPoints):
        self.model = model
        vectors = compat.function_space(model.mesh, compat.discontinuous("quadrilateral", 2, components=3))
        scalars = compat.function_space(model.mesh, compat.discontinuous("quadrilateral", 2))
        dx = ufl.Measure("dx", domain=model.mesh, metadata={"quadrature_degree": _DEGREE})
        areas = compat.assemble_array(compat.compile_form(ufl.TestFunction(scalars) * dx))
        self._mid_areas = np.asarray(contact.shapes[cell_node_rows(model, scalars)].T @ areas)
        rows = cell_node_rows(model, vectors)
        along, across = sp.diags([0.0, 1.0, 1.0]), sp.diags([1.0, 0.0, 0.0])
        self._weights = sp.csr_matrix(
            sp.kron(contact.shapes[rows], along) + sp.kron(contact.normal_shapes[rows], across)
        )

        weight = ufl.TestFunction(vectors)
        q = ufl.TrialFunction(model.space)
        u, theta = ufl.as_vector([q[0], q[1], q[2]]), ufl.as_vector([q[3], q[4], q[5]])
        self._height = fem.Constant(model.mesh, 0.0)
        motion = u + self._height * ufl.cross(theta, model.director)
        frame = cylinder_frame(ufl.SpatialCoordinate(model.mesh))
        self._form = compat.compile_form(sum(weight[c] * ufl.dot(motion, frame[c]) for c in range(3)) * dx)

    def areas(self, scale: float) -> FloatArray:
        """(n_points,) tributary area of each point, m^2; `scale` is surface radius divided by mid-surface radius."""
        return self._mid_areas * scale

    def operator(self, height: float) -> sp.csr_matrix:
        """(3 n_points, 6 n_nodes) operator: weighted mean displacement at a height (m) above the mid-surface.

        Its rows are the normal, hoop and axial components at each point.
        """
        self._height.value = height
        moments = self._weights.T @ compat.assemble_csr(self._form)[:, self.model.dof_order]
        averages = (sp.diags(np.repeat(1.0 / self._mid_areas, 3)) @ moments).tocsr()
        arm = np.tile(np.repeat([1.0, 1.0 / max(abs(height), 1e-300)], 3), len(self.model.nodes))
        entries = averages.tocoo()
        keep = np.abs(entries.data) * arm[entries.col] > 1e-14
        return sp.csr_matrix((entries.data[keep], (entries.row[keep], entries.col[keep])), shape=averages.shape)
