r"""Finite elements of a cylindrical tube for one circumferential wave number at a time.

    energy = c / 2 int (sum over zeta of w r stress . strain) dz,   c = pi (n >= 1), 2 pi (n = 0)

The cells are quadratic along z. All terms are integrated at two Gauss points per cell: the strains of quadratic cells
converge fastest there (Barlow 1976), thin walls do not lock, and the element has no zero-energy mode (Zienkiewicz et
al. 1977). Three Gauss points through the wall integrate the energy.

References
----------
J. Barlow (1976), Int. J. Numer. Meth. Engng 10, 243, doi:10.1002/nme.1620100202;
O. C. Zienkiewicz, J. Bauer, K. Morgan, E. Onate (1977), Int. J. Numer. Meth. Engng 11, 1545,
doi:10.1002/nme.1620111006.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem
from mpi4py import MPI

from wroll_fem.bodies.tube import Tube
from wroll_fem.fem import compat
from wroll_fem.fem.fourier import angular_weight
from wroll_fem.fem.fourier_shell.kinematics import COMPONENTS, Plane, Strains, strains, stresses
from wroll_fem.typing import FloatArray

_CELL = "interval"
_REDUCED = 2  # quadrature degree: two Gauss points per cell
THROUGH, THROUGH_WEIGHTS = np.polynomial.legendre.leggauss(3)
"""Gauss points through the wall, zeta / (t / 2), and their weights."""
SURFACES = (-1.0, 0.0, 1.0)
"""Inner, middle and outer surface: zeta / (t / 2)."""
_GAUSS = 1.0 / np.sqrt(3.0)


class FourierShellModel:
    """Matrices and loads of a tube; the forms are compiled once, the geometry and the material are constants.

    Nodes are numbered from the base upwards, two per cell and one more; degrees of freedom are node-major
    [U, V, W, B, A].

    Parameters
    ----------
    cells
        Number of cells along z.

    Raises
    ------
    WrollError
        If PETSc is built with complex scalars.
    """

    def __init__(self, cells: int):
        compat.require_real_scalars()
        grid = np.linspace(0.0, 1.0, cells + 1)[:, None]
        pairs = np.column_stack([np.arange(cells), np.arange(1, cells + 1)])
        self.mesh = compat.create_mesh(MPI.COMM_SELF, grid, pairs, _CELL, degree=1)
        self.space = compat.function_space(self.mesh, compat.lagrange(_CELL, 2, components=COMPONENTS, dimension=1))
        self.cells, self._vertex = cells, np.asarray(self.mesh.geometry.input_global_indices, np.int64)
        order = np.argsort(self.space.tabulate_dof_coordinates()[:, 0], kind="stable")
        self.dof_order = (COMPONENTS * order[:, None] + np.arange(COMPONENTS)).ravel()
        self.heights = grid[:, 0]
        names = ("n", "radius", "thickness", "direct", "coupling", "shear", "rho", "extra")
        self.constants = {name: fem.Constant(self.mesh, 0.0) for name in names}
        self._forms()

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return 2 * self.cells + 1

    def _forms(self) -> None:
        c, n = self.constants, self.constants["n"]
        u, v = ufl.TrialFunction(self.space), ufl.TestFunction(self.space)
        density, inertia = [], []
        for zeta, weight in self.layers():
            of_u, of_v = (self.strains(q, n, zeta) for q in (u, v))
            density.append(weight * sum(a * b for a, b in zip(stresses(of_u, self.plane()), of_v, strict=True)))
            moves = [(q[0], q[1] + zeta * q[3], q[2] + zeta * q[4]) for q in (u, v)]
            inertia.append(weight * c["rho"] * sum(a * b for a, b in zip(*moves, strict=True)))
        spread = c["radius"] * c["extra"] * sum(u[i] * v[i] for i in range(3))
        self._energy = compat.compile_form(sum(density[1:], density[0]) * self.dx())
        self._inertia = compat.compile_form((sum(inertia[1:], inertia[0]) + spread) * self.dx(4))
        push = (c["radius"] + 0.5 * c["thickness"]) * v[0]
        self._push = compat.compile_form(push * self.dx())

    def dx(self, degree: int = _REDUCED) -> Any:
        """Measure along z; by default with two Gauss points per cell."""
        return ufl.Measure("dx", domain=self.mesh, metadata={"quadrature_degree": degree})

    def layers(self) -> list[tuple[Any, Any]]:
        """Heights zeta of the Gauss points through the wall, and their weights times r (UFL expressions)."""
        t, radius = self.constants["thickness"], self.constants["radius"]
        heights = [0.5 * float(x) * t for x in THROUGH]
        return [(h, 0.5 * float(w) * t * (radius + h)) for h, w in zip(heights, THROUGH_WEIGHTS, strict=True)]

    def plane(self) -> Plane:
        """Elastic constants of the tube (UFL constants)."""
        return Plane(*(self.constants[name] for name in Plane._fields))

    def strains(self, q: Any, wave_number: Any, zeta: Any) -> Strains:
        """Strains of a field q at the height zeta (UFL expressions)."""
        slopes = [q[i].dx(0) for i in range(COMPONENTS)]
        return strains(q, slopes, wave_number, self.constants["radius"], zeta)

    def use(self, tube: Tube, heights: FloatArray) -> None:
        """Set the tube and the (cells + 1,) heights of the cell borders, m, ascending from 0."""
        if len(heights) != self.cells + 1:
            raise ValueError(f"{len(heights)} heights do not fit a model of {self.cells} cells")
        self.tube, self.heights = tube, np.asarray(heights, float)
        self.mesh.geometry.x[:, 0] = self.heights[self._vertex]
        direct = tube.E / (1.0 - tube.nu**2)
        values = {
            "radius": tube.radius, "thickness": tube.thickness, "direct": direct, "coupling": tube.nu * direct,
            "shear": 0.5 * tube.E / (1.0 + tube.nu), "rho": tube.rho,
            "extra": tube.extra_mass / (2.0 * np.pi * tube.radius * tube.length),
        }  # fmt: skip
        for name, value in values.items():
            self.constants[name].value = value

    def matrix(self, form: Any) -> sp.csr_matrix:
        """Assemble a compiled bilinear form in node-major order."""
        return compat.assemble_csr(form)[self.dof_order][:, self.dof_order].tocsr()

    def stiffness(self, wave_number: int) -> sp.csr_matrix:
        """(5 n_nodes, 5 n_nodes) stiffness, N/m, of the whole circumference without supports."""
        self.constants["n"].value = float(wave_number)
        return angular_weight(wave_number) * self.matrix(self._energy)

    def mass(self, wave_number: int) -> sp.csr_matrix:
        """(5 n_nodes, 5 n_nodes) consistent mass, kg, with the non-structural mass."""
        return angular_weight(wave_number) * self.matrix(self._inertia)

    def pressure_load(self) -> FloatArray:
        """(5 n_nodes,) forces of wave number 0, N, of an inward pressure of 1 Pa on the outer surface."""
        return -angular_weight(0) * compat.assemble_array(self._push)[self.dof_order]

    def translation(self) -> FloatArray:
        """(5 n_nodes,) displacements of wave number 1 of a unit translation along theta = 0."""
        return np.tile([1.0, -1.0, 0.0, 0.0, 0.0], self.n_nodes)

    def cantilever(self, wave_number: int) -> sp.csr_matrix:
        """(5 n_nodes, unknowns) map E from the unknowns to the nodal values: clamped base, rigid ring at the tip.

        The last unknowns are the motions of the ring: for wave number 0 its axial displacement and its rotation about
        the axis; for wave number 1 its translation along theta = 0 and its rotation about y; none for others.
        """
        size, R = COMPONENTS * self.n_nodes, self.constants["radius"].value
        motions = {
            0: [[0.0, 0.0, 1.0, 0.0, 0.0], [0.0, float(R), 0.0, 1.0, 0.0]],
            1: [[1.0, -1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -float(R), 0.0, -1.0]],
        }.get(wave_number, [])
        free = sp.identity(size, format="csc")[:, COMPONENTS : size - COMPONENTS]
        if not motions:
            return free.tocsr()
        ring = np.zeros((size, len(motions)))
        ring[-COMPONENTS:] = np.transpose(motions)
        return sp.hstack([free, sp.csc_matrix(ring)], format="csr")

    def surface_stress(self, field: FloatArray, wave_number: int) -> tuple[FloatArray, FloatArray]:
        """Stresses at both ends of every cell, by the linear function through the values at its two Gauss points.

        Parameters
        ----------
        field
            (5 n_nodes,) nodal values.
        wave_number
            Circumferential wave number of the field.

        Returns
        -------
        heights : (2 cells,) m.
        stress : (3, 3, 2 cells) amplitudes of zz, tt (of cos n theta) and tz (of sin n theta), Pa, on the inner, the
            middle and the outer surface (first index).
        """
        nodal = np.asarray(field).reshape(-1, COMPONENTS)
        cell = np.stack([nodal[0:-2:2], nodal[1:-1:2], nodal[2::2]])  # (3 nodes, cells, 5)
        x = np.array([-_GAUSS, _GAUSS])
        shape = np.stack([0.5 * x * (x - 1.0), 1.0 - x**2, 0.5 * x * (x + 1.0)])
        slope = np.stack([x - 0.5, -2.0 * x, x + 0.5])
        size = np.diff(self.heights)
        values = np.einsum("np,nci->icp", shape, cell)
        slopes = np.einsum("np,nci->icp", slope, cell) * (2.0 / size)[None, :, None]
        plane = Plane(*(float(self.constants[name].value) for name in Plane._fields))
        R, t = self.tube.radius, self.tube.thickness
        found = []
        for side in SURFACES:
            stress = stresses(strains(values, slopes, wave_number, R, 0.5 * side * t), plane)
            found.append(np.stack([stress.zz, stress.tt, stress.tz]))
        at_gauss = np.stack(found)  # (3 surfaces, 3, cells, 2)
        middle, half = at_gauss.mean(axis=-1), 0.5 * np.diff(at_gauss, axis=-1)[..., 0] / _GAUSS
        ends = np.stack([middle - half, middle + half], axis=-1)
        heights = np.column_stack([self.heights[:-1], self.heights[1:]])
        return heights.ravel(), ends.reshape(*ends.shape[:2], -1)
