"""Stress resultants of the shells of a roll, recovered at the corners of their elements.

The resultants are evaluated at the 2 x 2 Gauss points of an element, where membrane forces of quadratic elements
converge fastest (Barlow 1976). The bilinear function through these four values gives them at the corners.

References
----------
Barlow (1976), Int. J. Numer. Meth. Engng 10, 243, doi:10.1002/nme.1620100202.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
import ufl

from wroll_fem.bodies.body import Body
from wroll_fem.bodies.stress import PlyStress, ShellStress
from wroll_fem.bodies.wall import LayeredSection
from wroll_fem.fem import compat
from wroll_fem.fem.body import shell_section
from wroll_fem.fem.layered_shell import shell_model
from wroll_fem.fem.shell import AnySection, ShellModel
from wroll_fem.mesh.generate import shell_layout
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case.roll import RollSections

_CELL = "quadrilateral"
_GAUSS = 2  # quadrature degree: 2 x 2 points


def shell_stresses(roll: RollSections, bodies: Sequence[Body]) -> tuple[ShellStress, ...]:
    """Stress of every shell of a roll, for the degrees of freedom of all ``bodies`` (inner first) in a row.

    A homogenised coil is left out: its shell is the mandrel.
    """
    ends = np.cumsum([0, *(body.n_dofs for body in bodies)])
    found: list[ShellStress] = []
    for index, (body, (_, _, thickness)) in enumerate(zip(bodies, shell_layout(roll), strict=False)):
        section = shell_section(roll, index, thickness)
        operator, points = stress_operator(shell_model(body.nodes, body.cells, section), section)
        own = (operator @ body.expand).tocoo()
        whole = sp.csr_matrix((own.data, (own.row, own.col + ends[index])), shape=(own.shape[0], ends[-1]))
        parts = (body.name, whole, points, thickness)
        found.append(PlyStress(*parts, section) if isinstance(section, LayeredSection) else ShellStress(*parts))
    return tuple(found)


def stress_operator(model: ShellModel, section: AnySection) -> tuple[sp.csr_matrix, FloatArray]:
    """Map from nodal displacements to resultants, (24 n_cells, 6 n_nodes), and its points (4 n_cells, 3), m.

    Columns are node-major; the rows of a point are n_11, n_22, n_12 (N/m), m_11, m_22, m_12 (N). For plies they are the
    strains and curvatures of `LayeredShellModel.recovered`.
    """
    model.use(section)
    values = compat.function_space(model.mesh, compat.discontinuous(_CELL, 1, components=6))
    corners = compat.function_space(model.mesh, compat.discontinuous(_CELL, 1))
    dx = ufl.Measure("dx", domain=model.mesh, metadata={"quadrature_degree": _GAUSS})
    parts = ufl.as_vector(model.recovered(ufl.TrialFunction(model.space)))
    projected = compat.assemble_csr(compat.compile_form(ufl.inner(parts, ufl.TestFunction(values)) * dx))
    weight = ufl.inner(ufl.TrialFunction(corners), ufl.TestFunction(corners)) * dx
    mass = compat.assemble_csr(compat.compile_form(weight)).tocsr()
    cells = compat.cell_dofs(corners)
    shape = (*cells.shape, cells.shape[1])
    rows, columns = (np.broadcast_to(part, shape).ravel() for part in (cells[:, :, None], cells[:, None, :]))
    inverse = np.linalg.inv(np.asarray(mass[rows, columns]).reshape(shape))
    local = sp.csr_matrix((inverse.ravel(), (rows, columns)), shape=mass.shape)
    operator = sp.kron(local, sp.identity(6)).tocsr() @ projected
    vectors = compat.function_space(model.mesh, compat.discontinuous(_CELL, 1, components=3))
    place = ufl.inner(ufl.SpatialCoordinate(model.mesh), ufl.TestFunction(vectors)) * dx
    points = local @ compat.assemble_array(compat.compile_form(place)).reshape(-1, 3)
    return operator[:, model.dof_order].tocsr(), points
