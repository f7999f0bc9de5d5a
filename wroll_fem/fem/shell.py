r"""Shear-deformable shell on a curved quad mesh: Q2 displacement u and Q2 rotation vector theta.

A point at height xi above the mid-surface x_0 moves by u + xi theta x d, where the director d is a continuous quadratic
field. Linearised at the mid-surface, with the tangent basis P = [e1 e2] and the tangential gradient `grad`
(docs/theory.md, eq-shell-strains and eq-shell-energy):

    eps   = sym(P^T grad u P)                                                   membrane strain
    kappa = sym(P^T grad(theta x d) P + (grad d P)^T grad u P)                  change of curvature
    gamma = P^T (grad u^T d + theta x d)                                        transverse shear
    omega = theta . n - (e2 . grad u e1 - e1 . grad u e2) / 2                   drilling

    energy = 1/2 int N : eps + M : kappa + Q . gamma + k_d omega^2 dA

All four vanish pointwise for every rigid motion. Membrane and shear terms are integrated as
alpha x (3 x 3 points) + (1 - alpha) x (2 x 2 points) with alpha = t^2 / h^2 <= 1 in each cell (h^2 is the area of the
cell): 2 x 2 points alone leave zero-energy modes, and 3 x 3 points alone lock. Bending, drilling and mass are
integrated with 3 x 3 points.

Ratio of the displacement to its reference value on n x n cells (tests/fem/test_shell.py):

    n                                        4        8        16
    Scordelis-Lo roof (0.3024)               0.999    0.997    0.997
    pinched cylinder, diaphragms (1.8248e-5) 0.937    0.986    1.008

Notes
-----
Linear kinematics, isotropic plane stress, shear factor 5/6. One process (COMM_SELF).

References
----------
E. N. Dvorkin, K.-J. Bathe (1984), doi:10.1108/eb023562 (degenerated shells);
D. N. Arnold, F. Brezzi (1997), doi:10.1090/S0025-5718-97-00785-0 (partial reduced integration, weight t^2/h^2);
T. J. R. Hughes, F. Brezzi (1989), doi:10.1016/0045-7825(89)90124-2 (drilling rotations).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem
from mpi4py import MPI

from wroll_fem.bodies.wall import LayeredSection
from wroll_fem.fem import compat
from wroll_fem.typing import FloatArray, IntArray

Director = Callable[[FloatArray], FloatArray]

SHEAR_FACTOR = 5.0 / 6.0
DRILLING_FACTOR = 0.01
"""Drilling stiffness divided by G t (shear modulus times thickness). The drilling term is consistent, so results
converge to the same values for any ratio. A small ratio stiffens coarse meshes less (lab mandrel, 12 x 4 cells: the
bending frequency is 0.12 % too high with the ratio 1, 0.04 % with 0.01). With a very small ratio, spurious drilling
modes, near sqrt(12 ratio G / rho) / t (rho: density), appear among the physical modes."""
_CELL = "quadrilateral"
_FROM_GMSH = [0, 1, 3, 2, 4, 7, 5, 6, 8]  # basix's quad9 in gmsh's (and VTK's) local numbers
_FULL, _REDUCED = 4, 2  # quadrature degrees: 3 x 3 and 2 x 2 Gauss points


@dataclass(frozen=True)
class ShellSection:
    """Material and thickness of a homogeneous isotropic shell.

    Attributes
    ----------
    E, nu, rho
        Young's modulus (Pa), Poisson's ratio, density (kg/m^3).
    thickness
        Thickness, m.
    bending
        Factor on the bending stiffness; with 0 the shell is a membrane whose rotations are determined by the transverse
        shear and drilling terms.
    extra_mass
        Non-structural mass per area, kg/m^2.
    """

    E: float
    nu: float
    rho: float
    thickness: float
    bending: float = 1.0
    extra_mass: float = 0.0

    @property
    def mass_per_area(self) -> float:
        """Mass per area of the mid-surface, kg/m^2."""
        return self.rho * self.thickness + self.extra_mass


AnySection = ShellSection | LayeredSection
"""Section of a shell: homogeneous and isotropic, or of plies (`layered_shell.LayeredShellModel`)."""


def radial_director(points: FloatArray) -> FloatArray:
    """Outward unit normals (n, 3) of cylinders about the z axis at given points (n, 3), m."""
    director = np.zeros_like(points)
    director[:, :2] = points[:, :2] / np.hypot(points[:, 0], points[:, 1])[:, None]
    return director


class ShellModel:
    """Meshed shell that assembles stiffness, mass and loads for any `ShellSection`.

    Degrees of freedom are node-major [ux, uy, uz, rx, ry, rz] in the order of `nodes`.

    Parameters
    ----------
    nodes
        (n_nodes, 3) Cartesian coordinates, m; every node must belong to a cell.
    cells
        (n_cells, 9) node numbers in gmsh's quad9 order.
    director
        Function from points (n, 3) to unit normals (n, 3).

    Attributes
    ----------
    cell_nodes
        (n_cells, 9) input node numbers of the dolfinx cells in the local order of basix (corners first).
    dof_order
        (6 n_nodes,) dolfinx number of each node-major degree of freedom.

    Raises
    ------
    ValueError
        If a node belongs to no cell.
    WrollError
        If PETSc is built with complex scalars.
    """

    def __init__(self, nodes: FloatArray, cells: IntArray, director: Director = radial_director):
        compat.require_real_scalars()
        self.nodes, self.cells = np.asarray(nodes, float), np.asarray(cells, np.int64)
        self.mesh = compat.create_mesh(MPI.COMM_SELF, self.nodes, self.cells[:, _FROM_GMSH], _CELL)
        self.space = compat.function_space(self.mesh, compat.lagrange(_CELL, 2, components=6))
        self._constants = {
            name: fem.Constant(self.mesh, 0.0)
            for name in ("membrane", "bending", "nu", "shear", "drilling", "mass", "rotary")
        }
        node_of_geometry = np.asarray(self.mesh.geometry.input_global_indices, np.int64)
        geometry = compat.geometry_dofs(self.mesh)
        block_of_node = self._numbering(compat.cell_dofs(self.space), node_of_geometry[geometry])

        vectors = compat.function_space(self.mesh, compat.lagrange(_CELL, 2, components=3))
        self._vector_block = self._numbering(compat.cell_dofs(vectors), node_of_geometry[geometry])
        self.director = fem.Function(vectors, name="director")
        self._load = fem.Function(vectors, name="load")
        self._set(self.director, director(self.nodes))

        scalars = compat.function_space(self.mesh, compat.piecewise_constant(_CELL))
        self._alpha = fem.Function(scalars, name="alpha")
        self._area_of_cell = compat.assemble_array(compat.compile_form(ufl.TestFunction(scalars) * self._dx(_FULL)))
        self.cell_nodes = node_of_geometry[geometry]
        self.dof_order = (6 * block_of_node[:, None] + np.arange(6)).ravel()

    def _numbering(self, dofs: IntArray, nodes_of_cell: IntArray) -> IntArray:
        """(n_nodes,) index of the block of degrees of freedom at each input node.

        Every node has one block, because space and mesh are both quadratic.
        """
        block = np.full(len(self.nodes), -1, np.int64)
        block[nodes_of_cell.ravel()] = dofs.ravel()
        if (block < 0).any():
            raise ValueError(f"{int((block < 0).sum())} nodes belong to no cell of the shell; remove them")
        return block

    def _set(self, function: fem.Function, nodal: FloatArray) -> None:
        function.x.array.reshape(-1, 3)[self._vector_block] = nodal

    def _dx(self, degree: int) -> Any:
        return ufl.Measure("dx", domain=self.mesh, metadata={"quadrature_degree": degree})

    # ---- kinematics ----------------------------------------------------------------------------------------------

    def tangents(self) -> tuple[Any, Any]:
        """Tangent basis P = [e1 e2] (3 x 2) and unit normal e1 x e2 of the curved cell."""
        J = ufl.Jacobian(self.mesh)
        t1, t2 = J[:, 0], J[:, 1]
        e1 = t1 / ufl.sqrt(ufl.dot(t1, t1))
        n = ufl.cross(t1, t2) / ufl.sqrt(ufl.dot(ufl.cross(t1, t2), ufl.cross(t1, t2)))
        e2 = ufl.cross(n, e1)
        return ufl.transpose(ufl.as_matrix([[e1[i] for i in range(3)], [e2[i] for i in range(3)]])), n

    def strains(self, q: Any) -> tuple[Any, Any, Any, Any]:
        """Strains eps, kappa, gamma and omega of a field q = [u, theta], as defined in the module docstring."""
        u, theta = split(q)
        d = self.director
        P, n = self.tangents()
        grad_u, grad_d = ufl.grad(u), ufl.grad(d)
        slope = ufl.cross(theta, d)
        eps = ufl.sym(P.T * grad_u * P)
        kappa = ufl.sym(P.T * ufl.grad(slope) * P + (grad_d * P).T * (grad_u * P))
        gamma = P.T * (grad_u.T * d + slope)
        in_plane = P.T * grad_u * P
        omega = ufl.dot(theta, n) - (in_plane[1, 0] - in_plane[0, 1]) / 2
        return eps, kappa, gamma, omega

    def resultants(self, q: Any) -> tuple[Any, Any, Any]:
        """Membrane forces N (N/m), moments M (N), shear forces Q (N/m) of a field q, with the section set by `use`."""
        c = self._constants
        eps, kappa, gamma, _ = self.strains(q)
        return (
            c["membrane"] * plane_stress(eps, c["nu"]),
            c["bending"] * plane_stress(kappa, c["nu"]),
            c["shear"] * gamma,
        )

    def work(self, state: Any, eps: Any, kappa: Any, gamma: Any, tension: Any = 0) -> Any:
        """Work of the resultants of a field `state` on strains, with the section set by `use`.

        It is integrated at the points of the stiffness. `tension` (2 x 2, N/m) is added to the membrane forces.
        """
        N, M, Q = self.resultants(state)
        return self.integral(ufl.inner(N + tension, eps) + ufl.inner(Q, gamma), ufl.inner(M, kappa))

    def recovered(self, q: Any) -> list[Any]:
        """The six quantities from which stresses are recovered: N_11, N_22, N_12 and M_11, M_22, M_12 of a field q."""
        N, M, _ = self.resultants(q)
        return [N[0, 0], N[1, 1], N[0, 1], M[0, 0], M[1, 1], M[0, 1]]

    def integral(self, mixed: Any, full: Any = None) -> Any:
        """Integral of `mixed` (mixed rule) plus `full` (3 x 3 Gauss points per cell) over the mid-surface.

        Membrane and shear terms need the mixed rule, which is defined in the module docstring.
        """
        dx, dx_reduced, alpha = self._dx(_FULL), self._dx(_REDUCED), self._alpha
        total = alpha * mixed * dx + (1 - alpha) * mixed * dx_reduced
        return total if full is None else total + full * dx

    def area_integral(self, density: Any) -> Any:
        """Integral over the mid-surface with 3 x 3 Gauss points per cell."""
        return density * self._dx(_FULL)

    # ---- forms, compiled once --------------------------------------------------------------------------------------

    @cached_property
    def _stiffness_form(self) -> Any:
        c, alpha = self._constants, self._alpha
        eps, kappa, gamma, omega = self.strains(ufl.TrialFunction(self.space))
        eps_v, kappa_v, gamma_v, omega_v = self.strains(ufl.TestFunction(self.space))
        N = c["membrane"] * plane_stress(eps, c["nu"])
        M = c["bending"] * plane_stress(kappa, c["nu"])
        Q = c["shear"] * gamma
        dx, dx_reduced = self._dx(_FULL), self._dx(_REDUCED)

        membrane = alpha * ufl.inner(N, eps_v) * dx + (1 - alpha) * ufl.inner(N, eps_v) * dx_reduced
        bending = ufl.inner(M, kappa_v) * dx
        shear = alpha * ufl.inner(Q, gamma_v) * dx + (1 - alpha) * ufl.inner(Q, gamma_v) * dx_reduced
        drilling = c["drilling"] * omega * omega_v * dx
        return compat.compile_form(membrane + bending + shear + drilling)

    @cached_property
    def _mass_form(self) -> Any:
        u, theta = split(ufl.TrialFunction(self.space))
        v, phi = split(ufl.TestFunction(self.space))
        c, dx = self._constants, self._dx(_FULL)
        translation = c["mass"] * ufl.inner(u, v) * dx
        rotation = c["rotary"] * ufl.inner(theta, phi) * dx
        return compat.compile_form(translation + rotation)

    @cached_property
    def _load_form(self) -> Any:
        v, _ = split(ufl.TestFunction(self.space))
        return compat.compile_form(ufl.inner(self._load, v) * self._dx(_FULL))

    # ---- assembly --------------------------------------------------------------------------------------------------

    def use(self, section: AnySection) -> None:
        """Set the material and the thickness to those of `section`."""
        section = _homogeneous(section)
        t, G = section.thickness, section.E / (2 * (1 + section.nu))
        plane = section.E / (1 - section.nu**2)
        values = {
            "membrane": plane * t,
            "bending": section.bending * plane * t**3 / 12,
            "nu": section.nu,
            "shear": SHEAR_FACTOR * G * t,
            "drilling": DRILLING_FACTOR * G * t,
        }
        for name, value in values.items():
            self._constants[name].value = value
        self._alpha.x.array[:] = np.minimum(1.0, t**2 / self._area_of_cell)

    def stiffness(self, section: AnySection) -> sp.csr_matrix:
        """(6 n_nodes, 6 n_nodes) unconstrained stiffness, N/m."""
        self.use(section)
        return self.reorder(compat.assemble_csr(self._stiffness_form))

    def mass(self, section: AnySection) -> sp.csr_matrix:
        """(6 n_nodes, 6 n_nodes) consistent mass, kg, with a rotary inertia of rho t^3 / 12 about all three axes."""
        section = _homogeneous(section)
        self._constants["mass"].value = section.mass_per_area
        self._constants["rotary"].value = section.rho * section.thickness**3 / 12
        return self.reorder(compat.assemble_csr(self._mass_form))

    def area_load(self, density: FloatArray) -> FloatArray:
        """(6 n_nodes,) consistent nodal forces, N, of a traction with nodal values `density` (n_nodes, 3), Pa."""
        self._set(self._load, np.broadcast_to(density, self.nodes.shape))
        return compat.assemble_array(self._load_form)[self.dof_order]

    def mass_total(self, section: AnySection) -> float:
        """Mass of the wall, kg."""
        return _homogeneous(section).mass_per_area * self.area

    @property
    def area(self) -> float:
        """Area of the meshed mid-surface, m^2."""
        return float(self._area_of_cell.sum())

    def reorder(self, matrix: sp.csr_matrix) -> sp.csr_matrix:
        """Symmetric part of a matrix, reordered from dolfinx's order of the degrees of freedom to node-major order."""
        ordered = matrix[self.dof_order][:, self.dof_order]
        ordered = (ordered + ordered.T) * 0.5
        return drop_small(ordered.tocsr())


def _homogeneous(section: AnySection) -> ShellSection:
    if not isinstance(section, ShellSection):
        raise TypeError(f"plies need a LayeredShellModel, got {type(section).__name__}; use layered_shell.shell_model")
    return section


def split(q: Any) -> tuple[Any, Any]:
    """Displacement u and rotation theta, from the six components of a field q."""
    return ufl.as_vector([q[0], q[1], q[2]]), ufl.as_vector([q[3], q[4], q[5]])


def plane_stress(strain: Any, nu: Any) -> Any:
    """Plane-stress law (1 - nu) strain + nu tr(strain) I, without its stiffness factor.

    The factor is E t / (1 - nu^2) for membrane strains and E t^3 / (12 (1 - nu^2)) for changes of curvature.
    """
    return (1 - nu) * strain + nu * ufl.tr(strain) * ufl.Identity(2)


def drop_small(matrix: sp.csr_matrix, tolerance: float = 1e-15) -> sp.csr_matrix:
    """Remove entries below `tolerance` times the geometric mean of the diagonal entries of their row and column.

    The matrix is changed in place and returned: that of a refined coil takes gigabytes.
    """
    scale = np.sqrt(np.abs(matrix.diagonal()))
    least = np.repeat(tolerance * scale, np.diff(matrix.indptr))
    least *= scale[matrix.indices]
    matrix.data[np.abs(matrix.data) <= least] = 0.0
    matrix.eliminate_zeros()
    return matrix
