"""All calls that differ between dolfinx versions (0.5, 0.9 and later): spaces, forms, assembly into SciPy matrices.

No other module may depend on the version of dolfinx, UFL or basix.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator
from importlib.metadata import version
from typing import Any

import basix
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
import ufl
from dolfinx import cpp, fem, mesh
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from wroll_fem.errors import WrollError

_major, _minor = version("fenics-dolfinx").split(".")[:2]
VERSION = (int(_major), int(_minor))
"""(major, minor) version of the installed dolfinx."""

_BASIX_UFL = VERSION >= (0, 7)  # elements come from basix.ufl instead of ufl


def require_real_scalars() -> None:
    """Raise an error if PETSc is built with complex scalars.

    Raises
    ------
    WrollError
        If PETSc's scalar type is complex.
    """
    if np.issubdtype(PETSc.ScalarType, np.complexfloating):
        raise WrollError(
            "PETSc is built with complex scalars, which wroll_fem does not support; use the real build "
            "(Debian: python3-dolfinx-real python3-petsc4py-real python3-slepc4py-real, and unset PETSC_DIR)"
        )


@contextlib.contextmanager
def quiet_compiler() -> Iterator[None]:
    """Suppress the command lines of the C compiler, which setuptools writes to the root logger.

    setuptools also changes the handlers and the level of the root logger; both are restored.
    """
    root, manager = logging.getLogger(), logging.root.manager
    level, handlers, disabled = root.level, list(root.handlers), manager.disable
    logging.disable(logging.INFO)
    try:
        yield
    finally:
        logging.disable(disabled)
        root.setLevel(level)
        root.handlers[:] = handlers


JIT_SECONDS = 120
"""Longest time, s, to wait for a form that another process compiles; ffcx's default, 10 s, is too short under load."""


def compile_form(form: Any) -> Any:
    """Compile a UFL form, or load it from the cache of earlier runs."""
    options: dict[str, Any] = {"jit_options" if _BASIX_UFL else "jit_params": {"timeout": JIT_SECONDS}}
    with quiet_compiler():
        return fem.form(form, **options)


def lagrange(cell: str, degree: int, components: int = 1, dimension: int = 3) -> Any:
    """Lagrange element, scalar or vector-valued.

    Parameters
    ----------
    cell
        Name of the cell, for example "quadrilateral".
    degree
        Polynomial degree.
    components
        Number of components; 1 for a scalar element.
    dimension
        Geometric dimension of the space.
    """
    if _BASIX_UFL:
        import basix.ufl as basix_ufl

        return basix_ufl.element("Lagrange", cell, degree, shape=(components,) if components > 1 else ())
    ufl_cell = ufl.Cell(cell, geometric_dimension=dimension)
    if components == 1:
        return ufl.FiniteElement("Lagrange", ufl_cell, degree)
    return ufl.VectorElement("Lagrange", ufl_cell, degree, dim=components)


def discontinuous(cell: str, degree: int, components: int = 1) -> Any:
    """Discontinuous Lagrange element, scalar or vector-valued, on a surface in space."""
    if _BASIX_UFL:
        import basix.ufl as basix_ufl

        shape = (components,) if components > 1 else ()
        return basix_ufl.element("Lagrange", cell, degree, shape=shape, discontinuous=True)
    ufl_cell = ufl.Cell(cell, geometric_dimension=3)
    if components == 1:
        return ufl.FiniteElement("DQ", ufl_cell, degree)
    return ufl.VectorElement("DQ", ufl_cell, degree, dim=components)


def piecewise_constant(cell: str) -> Any:
    """Scalar element with one value per cell."""
    if _BASIX_UFL:
        import basix.ufl as basix_ufl

        return basix_ufl.element("DG", cell, 0)
    return ufl.FiniteElement("DG", ufl.Cell(cell, geometric_dimension=3), 0)


def function_space(domain: mesh.Mesh, element: Any) -> fem.FunctionSpace:
    """Create the function space of `element` on the mesh `domain`."""
    make = fem.functionspace if hasattr(fem, "functionspace") else fem.FunctionSpace
    with quiet_compiler():
        return make(domain, element)


def create_mesh(
    comm: Any, nodes: npt.NDArray[np.float64], cells: npt.NDArray[np.int64], cell: str, degree: int = 2
) -> mesh.Mesh:
    """Create a dolfinx mesh from nodes and cells.

    Parameters
    ----------
    comm
        MPI communicator.
    nodes
        (n, geometric dimension) coordinates, m.
    cells
        (n_cells, nodes per cell) node numbers in the local order of basix.
    cell
        Name of the cell, for example "hexahedron".
    degree
        Degree of the geometry.
    """
    nodes, cells = np.ascontiguousarray(nodes, float), np.ascontiguousarray(cells, np.int64)
    if _BASIX_UFL:
        import basix.ufl as basix_ufl

        domain = ufl.Mesh(basix_ufl.element("Lagrange", cell, degree, shape=(nodes.shape[1],)))
    else:
        own = ufl.Cell(cell, geometric_dimension=nodes.shape[1])
        domain = ufl.Mesh(ufl.VectorElement("Lagrange", own, degree, dim=nodes.shape[1]))
    with quiet_compiler():
        if VERSION >= (0, 10):
            return mesh.create_mesh(comm, cells, domain, nodes)
        if not _BASIX_UFL:  # given an array, 0.5 first formats an error that prints it
            return mesh.create_mesh(comm, cpp.graph.AdjacencyList_int64(cells), nodes, domain)
        return mesh.create_mesh(comm, cells, nodes, domain)


def geometry_dofs(domain: mesh.Mesh) -> npt.NDArray[np.int64]:
    """(n_cells, nodes per cell) local indices of the geometry nodes of each cell."""
    table = domain.geometry.dofmaps[0] if VERSION >= (0, 11) else domain.geometry.dofmap
    if hasattr(table, "array"):
        n_cells = domain.topology.index_map(domain.topology.dim).size_local
        return np.asarray(table.array.reshape(n_cells, -1), np.int64)
    return np.asarray(table, np.int64)


def cell_dofs(space: fem.FunctionSpace) -> npt.NDArray[np.int64]:
    """(n_cells, nodes per cell) numbers of the dof blocks of each cell; one block contains the dofs of one node."""
    table = space.dofmap.list
    if hasattr(table, "array"):
        n_cells = space.mesh.topology.index_map(space.mesh.topology.dim).size_local
        return np.asarray(table.array.reshape(n_cells, -1), np.int64)
    return np.asarray(table, np.int64)


def hexahedron_points() -> npt.NDArray[np.float64]:
    """(27, 3) reference coordinates of the nodes of a quadratic hexahedron in basix's local order."""
    element: Any = basix
    made = element.create_element(
        element.ElementFamily.P, element.CellType.hexahedron, 2, element.LagrangeVariant.equispaced
    )
    return np.asarray(made.points, float)


def tabulate_quadrilateral(degree: int, points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Values and derivatives of the scalar `lagrange` basis on the unit square.

    Parameters
    ----------
    degree
        Polynomial degree.
    points
        (n_points, 2) reference coordinates.

    Returns
    -------
    (3, n_points, n_functions) values and both derivatives; functions in the local order of basix, as in `cell_dofs`.
    """
    element: Any = basix
    made = element.create_element(
        element.ElementFamily.P, element.CellType.quadrilateral, degree, element.LagrangeVariant.gll_warped
    )
    return np.asarray(made.tabulate(1, np.ascontiguousarray(points, float)), float)[..., 0]


def assemble_csr(form: Any) -> sp.csr_matrix:
    """Assemble a compiled bilinear form (square or rectangular) without boundary conditions into a CSR matrix."""
    matrix = fem_petsc.assemble_matrix(form)
    matrix.assemble()
    indptr, indices, values = matrix.getValuesCSR()
    shape = matrix.getSize()
    matrix.destroy()
    return sp.csr_matrix((values, indices, indptr), shape=shape)


def assemble_array(form: Any) -> npt.NDArray[np.float64]:
    """Assemble a compiled linear form into a numpy array (one process)."""
    vector = fem.assemble_vector(form)
    return np.array(vector.array, float)


def versions() -> dict[str, str]:
    """Versions of dolfinx, basix and PETSc."""
    return {
        "dolfinx": version("fenics-dolfinx"),
        "basix": version("fenics-basix"),
        "petsc": ".".join(str(part) for part in PETSc.Sys.getVersion()),
    }
