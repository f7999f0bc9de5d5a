r"""27-node hexahedra for the homogenised coil. A mandrel of such hexahedra also serves as a check of the shells.

The material axes r, theta, z follow from the axis of the roll at every quadrature point. Strains are in Voigt order
(rr, tt, zz, tz, rz, rt) with engineering shear strains; e_a are the unit vectors of these axes:

    eps_ab = e_a . sym(grad u) e_b,        energy = 1/2 int eps^T C eps dV,       C from `structure.materials`.

Stiffness is integrated as alpha x (3 x 3 x 3 points) + (1 - alpha) x (2 x 2 x 2 points) with alpha = t^2 / h^2 <= 1 in
each cell, as in the shells (t is the total wall thickness, h^2 the area of the cell's face): the reduced rule alone
leaves zero-energy modes, and the full rule locks in thin walls. In a thick coil only the full rule remains. A smaller
alpha makes the frequencies converge faster, but causes spurious modes (618 Hz at G_r = 10 kPa with alpha = 1e-3) and
shear stresses that oscillate from cell to cell near the root (tip-loaded thick tube, 12 cells along the axis: 17 % with
alpha = 0.03, 0.2 % with the full rule).

Notes
-----
Linear kinematics, one process.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem
from mpi4py import MPI

from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.fem import compat
from wroll_fem.fem.shell import Director, drop_small, radial_director
from wroll_fem.typing import FloatArray, IntArray

_CELL = "hexahedron"
_FULL, _REDUCED = 4, 2
_INDEPENDENT = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2), (3, 3), (4, 4), (5, 5))
# grid position (0, 1 or 2 along each axis) -> number of the quad9 node in gmsh order
_GRID = {(0, 0): 0, (2, 0): 1, (2, 2): 2, (0, 2): 3, (1, 0): 4, (2, 1): 5, (1, 2): 6, (0, 1): 7, (1, 1): 8}


def thicken(
    nodes: FloatArray, cells: IntArray, heights: Sequence[float], director: Director = radial_director
) -> tuple[FloatArray, IntArray]:
    """Extrude a quad9 surface into 27-node hexahedra.

    Parameters
    ----------
    nodes, cells
        (n, 3) nodes of the surface, m, and (n_cells, 9) node numbers in gmsh order.
    heights
        (2 k + 1,) heights of the node layers above the surface, m, ascending, for k hexahedra through the thickness.
    director
        Function from points (n, 3) to unit normals (n, 3).

    Returns
    -------
    nodes : (len(heights) * n, 3) coordinates, m, one copy of the surface after the other.
    cells : (k * n_cells, 27) node numbers in the local order of basix.

    Raises
    ------
    ValueError
        If the number of heights is even or below 3.
    """
    if len(heights) < 3 or len(heights) % 2 == 0:
        raise ValueError(f"{len(heights)} heights; give 2 k + 1 for k quadratic cells through the thickness")
    d, n = director(nodes), len(nodes)
    stacked = np.concatenate([nodes + h * d for h in heights])
    grid = np.rint(2 * compat.hexahedron_points()).astype(int)
    blocks = [
        np.column_stack([cells[:, _GRID[a, b]] + (2 * layer + c) * n for a, b, c in grid])
        for layer in range(len(heights) // 2)
    ]
    return stacked, np.concatenate(blocks)


class SolidModel:
    """Meshed solid of quadratic hexahedra that assembles stiffness and mass.

    The degrees of freedom are node-major [ux, uy, uz].

    Parameters
    ----------
    nodes
        (n_nodes, 3) coordinates, m.
    cells
        (n_cells, 27) node numbers in the local order of basix, as returned by `thicken`; the third local axis points
        through the wall.
    thickness
        Thickness of the wall, m; None for the radial extent of the nodes.

    Raises
    ------
    WrollError
        If PETSc is built with complex scalars.
    """

    def __init__(self, nodes: FloatArray, cells: IntArray, thickness: float | None = None):
        compat.require_real_scalars()
        self.nodes, self.cells = np.asarray(nodes, float), np.asarray(cells, np.int64)
        self.mesh = compat.create_mesh(MPI.COMM_SELF, self.nodes, self.cells, _CELL)
        self.space = compat.function_space(self.mesh, compat.lagrange(_CELL, 2, components=3))
        cell_nodes = np.asarray(self.mesh.geometry.input_global_indices, np.int64)[compat.geometry_dofs(self.mesh)]
        block = np.full(len(self.nodes), -1, np.int64)
        block[cell_nodes.ravel()] = compat.cell_dofs(self.space).ravel()
        self.dof_order = (3 * block[:, None] + np.arange(3)).ravel()
        self._constants = {pair: fem.Constant(self.mesh, 0.0) for pair in _INDEPENDENT}
        self._set_weights(cell_nodes, np.ptp(np.hypot(*self.nodes[:, :2].T)) if thickness is None else thickness)

    def _set_weights(self, cell_nodes: IntArray, wall: float) -> None:
        """Compute the weight alpha of the full integration rule in each cell; `cell_nodes` are in dolfinx's order."""
        scalars = compat.function_space(self.mesh, compat.piecewise_constant(_CELL))
        volumes = compat.assemble_array(compat.compile_form(ufl.TestFunction(scalars) * self._dx(_FULL)))
        self.volume = float(volumes.sum())
        grid = np.rint(2 * compat.hexahedron_points()).astype(int).tolist()
        inner, outer = (self.nodes[cell_nodes[:, grid.index([1, 1, c])]] for c in (0, 2))
        face = volumes / np.linalg.norm(outer - inner, axis=1)
        self._alpha = fem.Function(scalars, name="alpha")
        self._alpha.x.array[:] = np.minimum(1.0, wall**2 / face)

    def _dx(self, degree: int) -> Any:
        return ufl.Measure("dx", domain=self.mesh, metadata={"quadrature_degree": degree})

    # ---- cylindrical orthotropy ------------------------------------------------------------------------------------

    def _strain(self, u: Any) -> list[Any]:
        """Strains as defined in the module docstring (Voigt order, axes r, theta, z)."""
        x = ufl.SpatialCoordinate(self.mesh)
        r = ufl.sqrt(x[0] ** 2 + x[1] ** 2)
        axes = ufl.as_matrix([[x[0] / r, x[1] / r, 0], [-x[1] / r, x[0] / r, 0], [0, 0, 1]])
        eps = axes * ufl.sym(ufl.grad(u)) * ufl.transpose(axes)
        return [eps[0, 0], eps[1, 1], eps[2, 2], 2 * eps[1, 2], 2 * eps[0, 2], 2 * eps[0, 1]]

    @cached_property
    def _orthotropic_form(self) -> Any:
        eps = self._strain(ufl.TrialFunction(self.space))
        eps_v = self._strain(ufl.TestFunction(self.space))
        C = {pair: c for (i, j), c in self._constants.items() for pair in ((i, j), (j, i))}
        sigma = [sum(C[i, j] * eps[j] for j in range(6) if (i, j) in C) for i in range(6)]
        work = sum(s * e for s, e in zip(sigma, eps_v, strict=True))
        return compat.compile_form(self._alpha * work * self._dx(_FULL) + (1 - self._alpha) * work * self._dx(_REDUCED))

    def orthotropic_stiffness(
        self, material: CylindricalOrthotropic, *, between_wraps: bool = True, expand: sp.csr_matrix | None = None
    ) -> sp.csr_matrix:
        """(3 n_nodes, 3 n_nodes) stiffness, N/m; the material axes are the directions r, theta, z of the roll.

        Without ``between_wraps`` the shear stiffnesses G_rz and G_rt are zero. A map ``expand`` (3 n_nodes, n) from
        unknowns to nodal displacements gives the (n, n) stiffness of these unknowns.
        """
        C = material.stiffness()
        if not between_wraps:
            C[[4, 5], [4, 5]] = 0.0
        for (i, j), constant in self._constants.items():
            constant.value = C[i, j]
        return self._ordered(self._orthotropic_form, expand)

    # ---- isotropy --------------------------------------------------------------------------------------------------

    def stiffness(self, E: float, nu: float) -> sp.csr_matrix:
        """(3 n_nodes, 3 n_nodes) stiffness, N/m, of an isotropic solid: Young's modulus E (Pa), Poisson's ratio nu."""
        lame = fem.Constant(self.mesh, E * nu / ((1 + nu) * (1 - 2 * nu)))
        shear = fem.Constant(self.mesh, E / (2 * (1 + nu)))
        eps = ufl.sym(ufl.grad(ufl.TrialFunction(self.space)))
        eps_v = ufl.sym(ufl.grad(ufl.TestFunction(self.space)))
        sigma = 2 * shear * eps + lame * ufl.tr(eps) * ufl.Identity(3)
        full = self._alpha * ufl.inner(sigma, eps_v) * self._dx(_FULL)
        reduced = (1 - self._alpha) * ufl.inner(sigma, eps_v) * self._dx(_REDUCED)
        return self._ordered(compat.compile_form(full + reduced))

    def mass(self, rho: float, *, expand: sp.csr_matrix | None = None) -> sp.csr_matrix:
        """(3 n_nodes, 3 n_nodes) consistent mass for the density rho (kg/m^3), kg; ``expand`` as for the stiffness."""
        density = fem.Constant(self.mesh, float(rho))
        u, v = ufl.TrialFunction(self.space), ufl.TestFunction(self.space)
        return self._ordered(compat.compile_form(density * ufl.inner(u, v) * self._dx(_FULL)), expand)

    def _ordered(self, form: Any, expand: sp.csr_matrix | None = None) -> sp.csr_matrix:
        place = np.argsort(self.dof_order)
        own = sp.identity(len(place), format="csr")[place] if expand is None else expand[place]
        matrix = compat.assemble_csr(form) @ own
        return tidy(own.T.tocsr() @ matrix)


def tidy(matrix: sp.spmatrix) -> sp.csr_matrix:
    """Symmetric part of a matrix, in CSR format with sorted indices and without entries at rounding level."""
    symmetric = sp.csr_matrix(matrix + matrix.T)
    symmetric.data *= 0.5
    result = drop_small(symmetric)
    result.sort_indices()
    return result


def constrained_matrices(
    nodes: FloatArray,
    cells: IntArray,
    expand: sp.csr_matrix,
    material: CylindricalOrthotropic,
    *,
    between_wraps: bool,
    symmetric: bool,
) -> tuple[sp.csr_matrix, sp.csr_matrix, float]:
    """Stiffness (N/m) and mass (kg) of a solid coil for its unknowns, and its volume, m^3.

    Of motions that are symmetric about the x-z plane, both halves of the coil store the same energy: the half y > 0 is
    assembled and counted twice, if the plane does not cut its cells.

    Parameters
    ----------
    nodes, cells
        Nodes (n_nodes, 3), m, and cells (n_cells, 27) of the whole coil, as returned by `thicken`.
    expand
        (3 n_nodes, n) map from the n unknowns to the nodal displacements.
    material, between_wraps
        See `SolidModel.orthotropic_stiffness`.
    symmetric
        Whether all motions that ``expand`` allows are symmetric about the x-z plane.
    """
    wall, copies = float(np.ptp(np.hypot(*nodes[:, :2].T))), 1.0
    upper = (nodes[cells, 1] > -1e-9 * np.abs(nodes).max()).all(axis=1)
    if symmetric and 2 * upper.sum() == len(cells):
        kept, cells = np.unique(cells[upper], return_inverse=True)
        cells = cells.reshape(-1, 27)
        nodes, expand, copies = nodes[kept], expand[(3 * kept[:, None] + np.arange(3)).ravel()], 2.0
    model = SolidModel(nodes, cells, wall)
    stiffness = model.orthotropic_stiffness(material, between_wraps=between_wraps, expand=expand)
    mass = model.mass(material.rho, expand=expand)
    for matrix in (stiffness, mass):
        matrix.data *= copies
    return stiffness, mass, copies * model.volume
