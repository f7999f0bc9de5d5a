r"""Shell with a wall of plies, whose thickness may vary along the roll.

Its energy is that of `wroll_fem.bodies.wall`, in the axes (z, theta) of the roll:

    energy = 1/2 int eps^ . A eps^ + kappa . D^ kappa + gamma . S gamma + k_d omega^2 dA,    eps^ = eps + C kappa

eps^ and gamma are integrated with the mixed rule of `ShellModel`, kappa and omega with 3 x 3 points. The kinetic energy
contains the coupling of translation and rotation, if the centre of mass of the wall is off the reference surface.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem

from wroll_fem.bodies.wall import COLUMNS, COUNT, LayeredSection
from wroll_fem.fem import compat
from wroll_fem.fem.shell import DRILLING_FACTOR, AnySection, Director, ShellModel, radial_director, split
from wroll_fem.typing import FloatArray, IntArray

_CELL = "quadrilateral"
_INWARDS = 1e-6
"""Relative distance from the border of a cell at which its wall is looked up, because a step may lie on the border."""

_MATRICES = (("membrane", 3), ("shift", 3), ("bending", 3), ("shear", 2))
"""Matrices of the energy in `COLUMNS`, and their sizes."""


def shell_model(
    nodes: FloatArray, cells: IntArray, section: AnySection, director: Director = radial_director
) -> ShellModel:
    """Meshed shell for a section: a `ShellModel`, or a `LayeredShellModel` for plies or a variable thickness."""
    kind = LayeredShellModel if isinstance(section, LayeredSection) else ShellModel
    return kind(nodes, cells, director)


class LayeredShellModel(ShellModel):
    """Meshed cylinder about the z axis that assembles stiffness, mass and loads for any `LayeredSection`."""

    def __init__(self, nodes: FloatArray, cells: IntArray, director: Director = radial_director):
        super().__init__(nodes, cells, director)
        space = compat.function_space(self.mesh, compat.discontinuous(_CELL, 2, components=COUNT))
        self._coefficients = fem.Function(space, name="section")
        corners = self.nodes[self.cell_nodes[:, :4], 2]
        self._cell_heights = 0.5 * (corners.min(axis=1) + corners.max(axis=1))
        heights, dofs = np.asarray(space.tabulate_dof_coordinates()[:, 2], float), compat.cell_dofs(space)
        self._heights = heights.copy()
        self._heights[dofs] += _INWARDS * (self._cell_heights[:, None] - heights[dofs])

    def _matrix(self, name: str, size: int) -> Any:
        first = COLUMNS[name].start
        f = self._coefficients
        return ufl.as_matrix([[f[first + size * i + j] for j in range(size)] for i in range(size)])

    def _entry(self, name: str, k: int = 0) -> Any:
        return self._coefficients[COLUMNS[name].start + k]

    @cached_property
    def _axes(self) -> tuple[Any, Any]:
        """Unit vectors along z and theta in the tangent basis."""
        P, n = self.tangents()
        axis = P.T * ufl.as_vector([0.0, 0.0, 1.0])
        along = axis / ufl.sqrt(ufl.dot(axis, axis))
        outward = ufl.sign(ufl.dot(n, self.director))
        return along, outward * ufl.as_vector([along[1], -along[0]])

    def in_axes(self, strain: Any) -> Any:
        """Vector (z, theta, z-theta) of a symmetric tensor of strains in the tangent basis; engineering shear."""
        a, b = self._axes
        return ufl.as_vector([ufl.dot(a, strain * a), ufl.dot(b, strain * b), 2 * ufl.dot(a, strain * b)])

    def _shear_in_axes(self, gamma: Any) -> Any:
        a, b = self._axes
        return ufl.as_vector([ufl.dot(a, gamma), ufl.dot(b, gamma)])

    def work(self, state: Any, eps: Any, kappa: Any, gamma: Any, tension: Any = None) -> Any:
        """Work of the resultants of a field `state` on strains; see `ShellModel.work`."""
        A, C, D, S = (self._matrix(name, size) for name, size in _MATRICES)
        stretched, curved, sheared, _ = self.strains(state)
        stretched, curved, sheared = self.in_axes(stretched), self.in_axes(curved), self._shear_in_axes(sheared)
        bend = self.in_axes(kappa)
        membrane = ufl.dot(A * (stretched + C * curved), self.in_axes(eps) + C * bend)
        if tension is not None:
            membrane = membrane + ufl.inner(tension, eps)
        return self.integral(membrane + ufl.dot(S * sheared, self._shear_in_axes(gamma)), ufl.dot(D * curved, bend))

    def recovered(self, q: Any) -> list[Any]:
        """Membrane strains and curvatures (1/m) of a field q in the axes (z, theta, z-theta)."""
        eps, kappa, _, _ = self.strains(q)
        pair = self.in_axes(eps), self.in_axes(kappa)
        return [part[k] for part in pair for k in range(3)]

    @cached_property
    def _stiffness_form(self) -> Any:
        q = ufl.TrialFunction(self.space)
        *strains, omega = self.strains(ufl.TestFunction(self.space))
        drilling = DRILLING_FACTOR * self._entry("drilling") * self.strains(q)[3] * omega
        return compat.compile_form(self.work(q, *strains) + self.area_integral(drilling))

    @cached_property
    def _mass_form(self) -> Any:
        u, theta = split(ufl.TrialFunction(self.space))
        v, phi = split(ufl.TestFunction(self.space))
        d, (mass, first, rotary) = self.director, (self._entry("mass", k) for k in range(3))
        coupled = ufl.dot(u, ufl.cross(phi, d)) + ufl.dot(v, ufl.cross(theta, d))
        density = mass * ufl.inner(u, v) + first * coupled + rotary * ufl.inner(theta, phi)
        return compat.compile_form(self.area_integral(density))

    @cached_property
    def _mass_total_form(self) -> Any:
        cells = compat.function_space(self.mesh, compat.piecewise_constant(_CELL))
        return compat.compile_form(self.area_integral(self._entry("mass") * ufl.TestFunction(cells)))

    def use(self, section: AnySection) -> None:
        """Set the wall to that of `section`."""
        if not isinstance(section, LayeredSection):
            raise TypeError(f"a layered shell needs a LayeredSection, got {type(section).__name__}")
        self._coefficients.x.array[:] = section.coefficients(self._heights).ravel()
        self._alpha.x.array[:] = np.minimum(1.0, section.thickness_at(self._cell_heights) ** 2 / self._area_of_cell)

    def mass(self, section: AnySection) -> sp.csr_matrix:
        """(6 n_nodes, 6 n_nodes) consistent mass, kg."""
        self.use(section)
        return self.reorder(compat.assemble_csr(self._mass_form))

    def mass_total(self, section: AnySection) -> float:
        """Mass of the wall, kg."""
        self.use(section)
        return float(compat.assemble_array(self._mass_total_form).sum())
