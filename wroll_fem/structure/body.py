"""A linear body: what an assembler hands over, free of any finite-element library.

Frame order is (theta, z, r) for cylindrical coordinates and (x, y, z) for Cartesian
ones; the interface's local components are always (normal, hoop, axial), the normal
pointing radially outward.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from wroll_fem.typing import FloatArray


@dataclass(frozen=True)
class Trace:
    """Motion of one surface of a body at its contact points.

    Attributes
    ----------
    operator
        (3 * n_points, n_dofs) sparse; row 3 k + c is component c of (normal, hoop, axial)
        of the surface's area-averaged displacement at point k, in m per unit of the body's DOFs.
        Includes the offset of the surface from the mid-surface (rotation x half thickness).
    points
        (n_points, 3) cylindrical coordinates (theta in [-pi, pi] rad, z in m, r in m).
    areas
        (n_points,) area that each point stands for, in m^2, on this surface.
    """

    operator: sp.csr_matrix
    points: FloatArray
    areas: FloatArray


@dataclass(frozen=True)
class SolidPart:
    """The homogenised coil bonded to a body: its mesh, and how it follows the body's unknowns.

    Attributes
    ----------
    nodes
        (n_nodes, 3) m; layers of nodes from the inside out, each with as many as the mandrel, facing its nodes.
    cells
        (n_cells, 27) in VTK_TRIQUADRATIC_HEXAHEDRON order, the third local axis outwards.
    expand
        (3 * n_nodes, n_dofs) sparse map to the nodal displacements, node-major [ux, uy, uz].
    mass
        kg, whole circumference.
    skin
        (n, 9) faces that are seen, in VTK_BIQUADRATIC_QUAD order.
    """

    nodes: FloatArray
    cells: npt.NDArray[np.int64]
    expand: sp.csr_matrix
    mass: float
    skin: npt.NDArray[np.int64]


@dataclass(frozen=True)
class Body:
    """One meshed part, constrained and ready for a `System`.

    Attributes
    ----------
    name
        "mandrel", "layer_01", ... (inner layer first).
    stiffness, mass
        (n, n) sparse symmetric, N/m and kg (constraints already eliminated: no Dirichlet rows).
    influence
        (n, 3) displacement of the DOFs under a unit rigid translation of the base along x, y, z.
    expand
        (6 * n_nodes, n) sparse map to all nodal values, node-major [ux, uy, uz, rx, ry, rz] (m, rad);
        with a symmetry plane it restores the whole circumference.
    nodes
        (n_nodes, 3) Cartesian coordinates in m.
    cells
        (n_cells, 9) node numbers of the quadratic quads in VTK_BIQUADRATIC_QUAD order.
    traces
        "inner" and "outer" surface.
    pressure_force
        (n,) force vector of a unit external pressure (1 Pa, pointing radially inward) on the outer surface.
    probes
        Name -> (3, n) sparse; "tip" gives the Cartesian displacement of the tip centre.
    mass_total
        Mass of the body with its tip mass, whole circumference, kg.
    symmetric
        True when only motions symmetric about the x-z plane are left.
    solid
        The homogenised coil that is bonded to this body, in its matrices already; None without one.
    unknown_node, unknown_component
        (n,) node of each DOF (-1: a rigid tip's) and which of [ux, uy, uz, rx, ry, rz] it is; None when unknown.
    """

    name: str
    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    influence: FloatArray
    expand: sp.csr_matrix
    nodes: FloatArray
    cells: npt.NDArray[np.int64]
    traces: dict[str, Trace]
    pressure_force: FloatArray
    probes: dict[str, sp.csr_matrix] = field(default_factory=dict)
    mass_total: float = 0.0
    symmetric: bool = False
    solid: SolidPart | None = None
    unknown_node: npt.NDArray[np.int64] | None = None
    unknown_component: npt.NDArray[np.int64] | None = None

    @property
    def n_dofs(self) -> int:
        """Number of unknowns."""
        return int(self.stiffness.shape[0])
