r"""Semi-analytical axisymmetric finite elements: Fourier terms in theta, Lagrange elements in the r-z half plane.

With displacements of circumferential wave number m

    u_r = U(r, z) cos m theta,    u_theta = V(r, z) sin m theta,    u_z = W(r, z) cos m theta

the strains (Voigt, engineering shear) are

    cos m theta:  rr = U,r        tt = (U + m V) / r    zz = W,z    rz = U,z + W,r
    sin m theta:  tz = V,z - m W / r                    rt = V,r - (V + m U) / r

A material whose axes are r, theta, z does not couple the two groups. Wave numbers are therefore independent of each
other, and the integral over theta is c = pi (m >= 1) for both groups:

    energy = c / 2 int (e_c . C_c e_c + e_s . C_s e_s) r dr dz,    kinetic = c / 2 int rho (U'^2 + V'^2 + W'^2) r dr dz

For m = 0 the same form, with c = 2 pi, separates into [U, W] (axial and breathing motions) and torsion, u_theta = V.
For m >= 1 every mode belongs to a degenerate pair: the other one is the same mode rotated by pi / (2 m) about the axis.

Notes
-----
Linear kinematics, r > 0. The Lagrange cells have degree 3 by default and are fully integrated; thin walls do not lock
(tests/fem/test_fourier.py). The forms are compiled only once: the wave number and the materials are constants of the
forms, and for another geometry the mesh is moved. One process.

References
----------
E. L. Wilson, Structural analysis of axisymmetric solids, AIAA Journal 3 (1965) 2269-2274.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from wroll_fem.fem import compat
from wroll_fem.mesh.axisymmetric import AxisymmetricMesh
from wroll_fem.typing import FloatArray, IntArray

COSINE, SINE = [0, 1, 2, 4], [3, 5]
"""Indices of the strains (rr, tt, zz, rz) and (tz, rt) in the Voigt order (rr, tt, zz, tz, rz, rt)."""
WALL, COIL = 1, 2
"""Cell tags of the mandrel wall and of the coil."""
DEGREE = 3
"""Default polynomial degree of the Lagrange cells."""
_CELL = "quadrilateral"


def angular_weight(wave_number: int) -> float:
    """Integral of cos^2 m theta over the circumference, rad: pi for m >= 1, 2 pi for m = 0.

    For m = 0 it also applies to torsion, whose amplitude does not vary with theta.
    """
    return np.pi if wave_number else 2 * np.pi


def strains(u: Any, r: Any, m: Any) -> tuple[Any, Any]:
    """Strain amplitudes (UFL expressions) of a displacement with circumferential wave number m.

    Parameters
    ----------
    u
        Displacement amplitudes (U, V, W) as functions of (r, z), m.
    r
        Radial coordinate, m.
    m
        Circumferential wave number.

    Returns
    -------
    cosine : (rr, tt, zz, rz), amplitudes of cos m theta
    sine : (tz, rt), amplitudes of sin m theta
    """
    U, V, W = u
    rr = U.dx(0)
    tt = (U + m * V) / r
    zz = W.dx(1)
    rz = U.dx(1) + W.dx(0)
    tz = V.dx(1) - m * W / r
    rt = V.dx(0) - (V + m * U) / r
    return ufl.as_vector([rr, tt, zz, rz]), ufl.as_vector([tz, rt])


class FourierModel:
    """Finite elements of the half plane of a roll; assembles stiffness and mass for any circumferential wave number.

    The degrees of freedom are node-major [U, V, W].

    Parameters
    ----------
    half_plane
        Rectangles in the r-z half plane.
    degree
        Degree of the Lagrange cells.

    Raises
    ------
    WrollError
        If PETSc is built with complex scalars.
    """

    def __init__(self, half_plane: AxisymmetricMesh, degree: int = DEGREE):
        compat.require_real_scalars()
        self.half_plane, self.degree = half_plane, degree
        self.mesh = compat.create_mesh(MPI.COMM_SELF, half_plane.nodes, half_plane.cells, _CELL, degree=1)
        self.space = compat.function_space(self.mesh, compat.lagrange(_CELL, degree, components=3, dimension=2))
        self._node = np.asarray(self.mesh.geometry.input_global_indices, np.int64)
        corners = half_plane.nodes[self._node[compat.geometry_dofs(self.mesh)]]
        centre = corners.mean(axis=1)
        along_r = np.searchsorted(half_plane.radii, centre[:, 0]) - 1
        along_z = np.searchsorted(half_plane.heights, centre[:, 1]) - 1
        self._cell_order = np.lexsort((along_z, along_r))
        region = np.where(along_r < half_plane.wall_cells, WALL, COIL).astype(np.int32)
        tags = mesh.meshtags(self.mesh, 2, np.arange(len(region), dtype=np.int32), region)
        metadata = {"quadrature_degree": 2 * degree + 1}
        self._dx = ufl.Measure("dx", domain=self.mesh, subdomain_data=tags, metadata=metadata)
        self._wave_number = fem.Constant(self.mesh, 0.0)
        self._cosine = {k: fem.Constant(self.mesh, np.zeros((4, 4))) for k in (WALL, COIL)}
        self._sine = {k: fem.Constant(self.mesh, np.zeros((2, 2))) for k in (WALL, COIL)}
        self._density = {k: fem.Constant(self.mesh, 0.0) for k in (WALL, COIL)}
        self._mass: sp.csr_matrix | None = None
        self._forms()

    def _forms(self) -> None:
        r, m = ufl.SpatialCoordinate(self.mesh)[0], self._wave_number
        u, v = ufl.TrialFunction(self.space), ufl.TestFunction(self.space)
        cos_u, sin_u = strains(u, r, m)
        cos_v, sin_v = strains(v, r, m)
        energy, inertia = [], []
        for region in (WALL, COIL):
            dx = self._dx(region)
            energy.append(ufl.inner(self._cosine[region] * cos_u, cos_v) * r * dx)
            energy.append(ufl.inner(self._sine[region] * sin_u, sin_v) * r * dx)
            inertia.append(self._density[region] * ufl.inner(u, v) * r * dx)
        self._energy = compat.compile_form(sum(energy[1:], energy[0]))
        self._inertia = compat.compile_form(sum(inertia[1:], inertia[0]))

    def move(self, half_plane: AxisymmetricMesh) -> None:
        """Move the mesh to another geometry with the same number of cells along r and along z.

        Raises
        ------
        ValueError
            If a number of cells differs.
        """
        if half_plane.shape != self.half_plane.shape or half_plane.wall_cells != self.half_plane.wall_cells:
            raise ValueError(
                f"a mesh of {half_plane.shape} cells does not fit a model of {self.half_plane.shape}; build a new model"
            )
        self.half_plane, self._mass = half_plane, None
        self.mesh.geometry.x[:, :2] = half_plane.nodes[self._node]

    def set_material(self, region: int, stiffness: FloatArray, density: float) -> None:
        """Set the material of the mandrel wall or of the coil.

        Parameters
        ----------
        region
            `WALL` or `COIL`.
        stiffness
            (6, 6) elastic stiffness in the order (rr, tt, zz, tz, rz, rt), Pa.
        density
            Mass density, kg/m^3.

        Raises
        ------
        ValueError
            If the material couples (rr, tt, zz, rz) with (tz, rt), which would couple the two groups of strains.
        """
        C = np.asarray(stiffness, float)
        if np.abs(C[np.ix_(COSINE, SINE)]).max() > 1e-12 * np.abs(C).max():
            raise ValueError("the principal axes of the material are not r, theta, z")
        self._cosine[region].value[...] = C[np.ix_(COSINE, COSINE)]
        self._sine[region].value[...] = C[np.ix_(SINE, SINE)]
        if float(density) != float(self._density[region].value):
            self._density[region].value, self._mass = float(density), None

    @property
    def nodes(self) -> FloatArray:
        """(n_nodes, 2) coordinates [r, z] of the nodes, m."""
        return np.asarray(self.space.tabulate_dof_coordinates()[:, :2], float)

    @cached_property
    def cell_nodes(self) -> IntArray:
        """(n_r, n_z, nodes per cell) node numbers of the n_r cells along r and n_z along z, in basix's local order."""
        return compat.cell_dofs(self.space)[self._cell_order].reshape(*self.half_plane.shape, -1)

    def stiffness(self, wave_number: int) -> sp.csr_matrix:
        """(3 n_nodes, 3 n_nodes) stiffness, N/m, of the whole circumference for a circumferential wave number."""
        self._wave_number.value = float(wave_number)
        return angular_weight(wave_number) * compat.assemble_csr(self._energy)

    def mass(self, wave_number: int) -> sp.csr_matrix:
        """(3 n_nodes, 3 n_nodes) consistent mass, kg, of the whole circumference for a circumferential wave number."""
        if self._mass is None:
            self._mass = compat.assemble_csr(self._inertia)
        return angular_weight(wave_number) * self._mass

    def tip_weights(self) -> FloatArray:
        """(n_nodes,) weight of each node in the mean displacement of the wall's end face; sums to 1."""
        r, z = ufl.SpatialCoordinate(self.mesh)
        wall = fem.Constant(self.mesh, self.half_plane.wall_radius + 1e-6 * self.half_plane.length)
        tip = fem.Constant(self.mesh, float(self.half_plane.heights[-1]) - 1e-6 * self.half_plane.length)
        there = ufl.conditional(ufl.And(ufl.gt(z, tip), ufl.lt(r, wall)), 1.0, 0.0)
        ds = ufl.Measure("ds", domain=self.mesh, metadata={"quadrature_degree": 2 * self.degree})
        share = compat.assemble_array(compat.compile_form(there * r * ufl.TestFunction(self.space)[0] * ds))[0::3]
        return np.asarray(share / share.sum())

    def evaluate(self, values: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values and gradients of nodal fields at points of the half plane.

        Parameters
        ----------
        values
            (n_nodes, k) nodal values of k fields.
        points
            (p, 2) coordinates [r, z], m. On the border between two cells the gradient is taken from the inner or lower
            cell.

        Returns
        -------
        values : (p, k)
        gradients : (p, k, 2) derivatives with respect to r and z, per m.
        """
        cell, size, local = [], [], []
        for borders, x in zip((self.half_plane.radii, self.half_plane.heights), np.asarray(points).T, strict=True):
            at = np.clip(np.searchsorted(borders, x) - 1, 0, len(borders) - 2)
            cell.append(at)
            size.append(np.diff(borders)[at])
            local.append((x - borders[at]) / size[-1])
        basis = compat.tabulate_quadrilateral(self.degree, np.column_stack(local))
        nodal = np.asarray(values)[self.cell_nodes[cell[0], cell[1]]]
        here, by_r, by_z = (np.einsum("pn,pnk->pk", table, nodal) for table in basis)
        return here, np.stack([by_r / size[0][:, None], by_z / size[1][:, None]], axis=-1)
