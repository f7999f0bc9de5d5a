"""Area-averaged displacement of the surfaces of a shell at its contact points (docs/theory.md, eq-jump).

The contact points are the corner vertices of the quads. With the bilinear hat function N_k of vertex k on the
mid-surface, the height xi of the surface above it and the cylindrical unit vectors e_c of the roll,

    motion[k, c] = 1 / A_k  int N_k (u + xi theta x d) . e_c dA,     A_k = int N_k dA,

so a traction that is uniform in the cylindrical frame does the same work at the points as on the surface. The two
surfaces of an interface have the same points, in the same order, and the same areas.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem

from wroll_fem.fem import compat
from wroll_fem.fem.shell import ShellModel
from wroll_fem.typing import FloatArray, IntArray

_DEGREE = 4


def cylinder_frame(x: Any) -> list[Any]:
    """Cylindrical unit vectors (normal, hoop, axial) at a UFL position, about the z axis.

    The vectors are defined by the axis. A frame derived from the components of the normal would change sign around the
    roll.
    """
    radius = ufl.sqrt(x[0] ** 2 + x[1] ** 2)
    normal = ufl.as_vector([x[0] / radius, x[1] / radius, 0.0 * x[2]])
    hoop = ufl.as_vector([-x[1] / radius, x[0] / radius, 0.0 * x[2]])
    axial = ufl.as_vector([0.0 * x[0], 0.0 * x[0], 1.0 + 0.0 * x[2]])
    return [normal, hoop, axial]


class SurfaceTrace:
    """Averages of the displacement of a shell, weighted with the hat functions of its vertices.

    Parameters
    ----------
    model
        The shell.
    vertices
        (n_points,) corner nodes in the order of the contact points.
    """

    def __init__(self, model: ShellModel, vertices: IntArray):
        self.model, self.vertices = model, vertices
        hats = compat.function_space(model.mesh, compat.lagrange("quadrilateral", 1, components=3))
        scalar_hats = compat.function_space(model.mesh, compat.lagrange("quadrilateral", 1))
        block_of_node = np.full(len(model.nodes), -1, np.int64)
        block_of_node[model.cell_nodes[:, :4].ravel()] = compat.cell_dofs(hats).ravel()
        scalar_of_node = np.full(len(model.nodes), -1, np.int64)
        scalar_of_node[model.cell_nodes[:, :4].ravel()] = compat.cell_dofs(scalar_hats).ravel()

        dx = ufl.Measure("dx", domain=model.mesh, metadata={"quadrature_degree": _DEGREE})
        areas = compat.assemble_array(compat.compile_form(ufl.TestFunction(scalar_hats) * dx))
        self._mid_areas = areas[scalar_of_node[vertices]]

        weight = ufl.TestFunction(hats)
        q = ufl.TrialFunction(model.space)
        u, theta = ufl.as_vector([q[0], q[1], q[2]]), ufl.as_vector([q[3], q[4], q[5]])
        self._height = fem.Constant(model.mesh, 0.0)
        motion = u + self._height * ufl.cross(theta, model.director)
        frame = cylinder_frame(ufl.SpatialCoordinate(model.mesh))
        self._form = compat.compile_form(sum(weight[c] * ufl.dot(motion, frame[c]) for c in range(3)) * dx)
        self._rows = (3 * block_of_node[vertices][:, None] + np.arange(3)).ravel()

    def areas(self, scale: float) -> FloatArray:
        """(n_points,) tributary area of each point, m^2; `scale` is r_surface / r_mid-surface."""
        return self._mid_areas * scale

    def operator(self, height: float) -> sp.csr_matrix:
        """(3 n_points, 6 n_nodes) mean (normal, hoop, axial) displacement at a height (m) above the mid-surface."""
        self._height.value = height
        moments = compat.assemble_csr(self._form)[self._rows][:, self.model.dof_order]
        averages = (sp.diags(np.repeat(1.0 / self._mid_areas, 3)) @ moments).tocsr()
        arm = np.tile(np.repeat([1.0, 1.0 / max(abs(height), 1e-300)], 3), len(self.model.nodes))
        entries = averages.tocoo()
        keep = np.abs(entries.data) * arm[entries.col] > 1e-14
        return sp.csr_matrix((entries.data[keep], (entries.row[keep], entries.col[keep])), shape=averages.shape)
