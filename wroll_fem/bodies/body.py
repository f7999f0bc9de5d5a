"""Data classes of a linear body: matrices, surface traces and probes, independent of any finite-element library.

Cylindrical coordinates are ordered (theta, z, r) and Cartesian ones (x, y, z). Local components at an interface are
always (normal, hoop, axial); the normal points radially outward.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from wroll_fem.typing import FloatArray


@dataclass(frozen=True)
class Trace:
    """Displacement of one surface of a body at its contact points.

    Attributes
    ----------
    operator
        (3 * n_points, n_dofs) sparse; row 3 k + c is component c of (normal, hoop, axial)
        of the surface's area-averaged displacement at point k, in m per unit of the body's DOFs.
        Includes the offset of the surface from the mid-surface (rotation times half the thickness).
    points
        (n_points, 3) cylindrical coordinates (theta in [-pi, pi] rad, z in m, r in m).
    areas
        (n_points,) tributary area of each point on this surface, m^2.
    """

    operator: sp.csr_matrix
    points: FloatArray
    areas: FloatArray


@dataclass(frozen=True)
class SolidPart:
    """Homogenised coil of a body: its mesh and its displacements in terms of the body's unknowns.

    Attributes
    ----------
    nodes
        (n_nodes, 3) coordinates, m, in layers from the inside outwards; each layer matches the nodes of the mandrel.
    layers
        Number of these layers.
    cells
        (n_cells, 27) node numbers in VTK_TRIQUADRATIC_HEXAHEDRON order; the third local axis points outwards.
    expand
        (3 * n_nodes, n_dofs) sparse map from the unknowns to the nodal displacements, node-major [ux, uy, uz].
    mass
        Mass of the coil, whole circumference, kg.
    skin
        (n, 9) node numbers of the free faces, in VTK_BIQUADRATIC_QUAD order.
    """

    nodes: FloatArray
    layers: int
    cells: npt.NDArray[np.int64]
    expand: sp.csr_matrix
    mass: float
    skin: npt.NDArray[np.int64]


@dataclass(frozen=True)
class Body:
    """One meshed part with its constraints eliminated; a `System` is assembled from such bodies.

    Attributes
    ----------
    name
        "mandrel", "layer_01", ... (inner layer first), or "coil", a solid that rubs on the mandrel. Such a body has
        no shell: `nodes` and `cells` are empty.
    stiffness, mass
        (n, n) sparse symmetric, N/m and kg; constraints are eliminated, so there are no Dirichlet rows.
    influence
        (n, 3) displacement of the DOFs under a unit rigid translation of the base along x, y, z.
    expand
        (6 * n_nodes, n) sparse map from the unknowns to all nodal values, node-major [ux, uy, uz, rx, ry, rz] (m, rad).
        With a symmetry plane it restores the whole circumference.
    nodes
        (n_nodes, 3) Cartesian coordinates in m.
    cells
        (n_cells, 9) node numbers of the quadratic quads in VTK_BIQUADRATIC_QUAD order.
    traces
        "inner" and "outer" surface.
    pressure_force
        (n,) force vector of a unit external pressure (1 Pa, pointing radially inward) on the outer surface.
    probes
        Name -> (3, n) sparse operator; "tip" gives the Cartesian displacement of the centre of the tip.
    mass_total
        Mass of the body, tip mass included, whole circumference, kg.
    symmetric
        True if only motions symmetric about the x-z plane remain.
    solid
        Homogenised coil of this body (included in its matrices), or None.
    unknown_node, unknown_component
        (n,) node of each unknown in `places` (-1 for a rigid tip, -2 for a rigid base ring) and its component in
        [ux, uy, uz, rx, ry, rz]; None if unknown.
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
    def places(self) -> FloatArray:
        """(n, 3) nodes to which `unknown_node` refers, m: those of the shell, or of the solid of a body without one."""
        return self.nodes if self.solid is None or len(self.nodes) else self.solid.nodes

    @property
    def n_dofs(self) -> int:
        """Number of unknowns."""
        return int(self.stiffness.shape[0])
