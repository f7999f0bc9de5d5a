"""27-node solid tube: an independent check of the shells, on exactly the mandrel's quads.

Stiffness is integrated as alpha x (3 x 3 x 3 points) + (1 - alpha) x (2 x 2 x 2 points) with alpha = 1e-3: the
reduced rule alone leaves zero-energy modes, the full one locks in thin walls.

Notes
-----
Linear kinematics, isotropic material, one process.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
import ufl
from dolfinx import fem
from mpi4py import MPI

from wroll_fem.fem import compat
from wroll_fem.fem.shell import Director, drop_small, radial_director

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

MIXED_WEIGHT = 1e-3
_CELL = "hexahedron"
_FULL, _REDUCED = 4, 2
# position of quad9 node (gmsh order) on the 3 x 3 grid of its cell
_GRID = {(0, 0): 0, (2, 0): 1, (2, 2): 2, (0, 2): 3, (1, 0): 4, (2, 1): 5, (1, 2): 6, (0, 1): 7, (1, 1): 8}


def thicken(
    nodes: FloatArray, cells: IntArray, heights: Sequence[float], director: Director = radial_director
) -> tuple[FloatArray, IntArray]:
    """27-node hexes between a quad9 surface's offsets.

    Parameters
    ----------
    nodes, cells
        (n, 3) and (n_cells, 9) of the surface, gmsh order.
    heights
        Offsets along the director, m, ascending, 2 k + 1 of them for k hexes through the thickness.

    Returns
    -------
    nodes : (len(heights) * n, 3), one copy of the surface after the other.
    cells : (k * n_cells, 27) in basix's local order.
    """
    if len(heights) < 3 or len(heights) % 2 == 0:
        raise ValueError(f"{len(heights)} offsets; k quadratic cells through the thickness need 2 k + 1")
    d, n = director(nodes), len(nodes)
    stacked = np.concatenate([nodes + h * d for h in heights])
    grid = np.rint(2 * compat.hexahedron_points()).astype(int)
    blocks = [
        np.column_stack([cells[:, _GRID[a, b]] + (2 * layer + c) * n for a, b, c in grid])
        for layer in range(len(heights) // 2)
    ]
    return stacked, np.concatenate(blocks)


class SolidModel:
    """Quadratic hexes: assembles stiffness and mass; degrees of freedom are node-major [ux, uy, uz].

    Parameters
    ----------
    nodes
        (n_nodes, 3), m.
    cells
        (n_cells, 27) in basix's local order, as `thicken` returns them.
    """

    def __init__(self, nodes: FloatArray, cells: IntArray):
        compat.require_real_scalars()
        self.nodes = np.asarray(nodes, float)
        self.mesh = compat.create_mesh(MPI.COMM_SELF, self.nodes, cells, _CELL)
        self.space = compat.function_space(self.mesh, compat.lagrange(_CELL, 2, components=3))
        geometry = np.asarray(self.mesh.geometry.input_global_indices, np.int64)[compat.geometry_dofs(self.mesh)]
        block = np.full(len(self.nodes), -1, np.int64)
        block[geometry.ravel()] = compat.cell_dofs(self.space).ravel()
        self.dof_order = (3 * block[:, None] + np.arange(3)).ravel()

    def _dx(self, degree: int) -> Any:
        return ufl.Measure("dx", domain=self.mesh, metadata={"quadrature_degree": degree})

    def stiffness(self, E: float, nu: float) -> sp.csr_matrix:
        """(3 n_nodes, 3 n_nodes) stiffness, N/m."""
        lame = fem.Constant(self.mesh, E * nu / ((1 + nu) * (1 - 2 * nu)))
        shear = fem.Constant(self.mesh, E / (2 * (1 + nu)))
        eps = ufl.sym(ufl.grad(ufl.TrialFunction(self.space)))
        eps_v = ufl.sym(ufl.grad(ufl.TestFunction(self.space)))
        sigma = 2 * shear * eps + lame * ufl.tr(eps) * ufl.Identity(3)
        full = MIXED_WEIGHT * ufl.inner(sigma, eps_v) * self._dx(_FULL)
        reduced = (1 - MIXED_WEIGHT) * ufl.inner(sigma, eps_v) * self._dx(_REDUCED)
        return self._ordered(full + reduced)

    def mass(self, rho: float) -> sp.csr_matrix:
        """(3 n_nodes, 3 n_nodes) consistent mass, kg."""
        density = fem.Constant(self.mesh, float(rho))
        u, v = ufl.TrialFunction(self.space), ufl.TestFunction(self.space)
        return self._ordered(density * ufl.inner(u, v) * self._dx(_FULL))

    def _ordered(self, form: Any) -> sp.csr_matrix:
        matrix = compat.assemble_csr(compat.compile_form(form))[self.dof_order][:, self.dof_order]
        return drop_small(((matrix + matrix.T) * 0.5).tocsr())
