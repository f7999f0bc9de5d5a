"""Fourier finite elements of a roll: a `FourierModel` with the materials, base, tip and coil of a case."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.bodies.rigid_ends import rigid_mass, spring_matrix
from wroll_fem.case.supports import TipInertia
from wroll_fem.errors import InputError
from wroll_fem.fem.fourier import COIL, WALL, FourierModel, angular_weight
from wroll_fem.mesh.axisymmetric import MESHED_COILS, refined_mesh
from wroll_fem.typing import BoolArray, FloatArray

if TYPE_CHECKING:
    from wroll_fem.case.roll import RollSections


_NEAR = 1e-9  # tolerance, relative to the length, for nodes on an edge of the half plane


@dataclass(frozen=True)
class SymmetryClass:
    """Class of motions of one wave number m that do not couple with other motions; for m = 0 there are two classes.

    For m = 0, torsion is one class; axial and breathing motions form the other.

    Attributes
    ----------
    wave_number
        Circumferential wave number m.
    components
        Indices of the displacement amplitudes (U, V, W) that are not zero.
    """

    wave_number: int
    components: tuple[int, ...]

    @property
    def direction(self) -> str | None:
        """Direction in which motions of the class move the centre of mass: "x" (bending), "z" (axial) or None."""
        if self.wave_number == 1:
            return "x"
        return "z" if self == AXIAL else None


AXIAL, TORSION, BENDING = SymmetryClass(0, (0, 2)), SymmetryClass(0, (1,)), SymmetryClass(1, (0, 1, 2))


def symmetry_classes(wave_number: int) -> tuple[SymmetryClass, ...]:
    """Symmetry classes of a circumferential wave number: two for m = 0, one otherwise."""
    return (AXIAL, TORSION) if wave_number == 0 else (SymmetryClass(wave_number, (0, 1, 2)),)


@dataclass(frozen=True)
class SymmetryClassMatrices:
    """Stiffness and mass of a symmetry class, for the unknowns that remain after elimination of the supports.

    Attributes
    ----------
    stiffness, mass
        (n, n) stiffness, N/m, and mass, kg, whole circumference.
    expand
        (3 n_nodes, n) map T from the unknowns y to the nodal amplitudes q = [U, V, W].
    influence
        (n,) values of the unknowns under a unit translation of the base along the direction of the class; zeros if the
        class has no direction.
    tip
        (n,) displacement of the centre of the tip along that direction per unknown.
    """

    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    expand: sp.csr_matrix
    influence: FloatArray
    tip: FloatArray


class FourierRoll:
    """Fourier model of a roll: wall of the mandrel as a solid, coil bonded to its outer surface, rigid or free tip.

    Parameters
    ----------
    sections
        Sections geometry, mandrel, coil and mesh, for example those of a case on a roll.
    model
        Existing model with the same numbers of cells. It is moved to this geometry, so its forms are not compiled
        again. None builds a new model.

    Raises
    ------
    InputError
        For a coil model with frictional interfaces, or if the base of the coil is clamped and that of the mandrel free.
    ValueError
        If `model` has other numbers of cells.

    Notes
    -----
    The clamp fixes every node of the wall's base and the rigid tip constrains every node of its end face, so both also
    prevent a change of the wall's thickness. The tip mass is a point mass on the axis (no rotary inertia); with a free
    tip it is distributed over the end face. The lower inner edge of the coil belongs to the clamped wall, so
    `coil.base: free` and `inner_edge` are the same for a solid coil.
    """

    def __init__(self, sections: RollSections, model: FourierModel | None = None):
        if sections.coil.model not in (*MESHED_COILS, "nonstructural_mass", "none"):
            raise InputError(
                "Fourier elements cannot model friction between layers, which couples the circumferential harmonics",
                key="coil.model",
                remedy="use solid, bonded, nonstructural_mass or none, or mesh.discretisation: three_dimensional",
            )  # fmt: skip
        if sections.coil.model in MESHED_COILS and sections.mandrel.base == "free" and sections.coil.base != "free":
            raise InputError(
                f"the base of the coil is clamped ({sections.coil.base}) but the base of the mandrel is free",
                key="coil.base", remedy="use coil.base: free, or mandrel.base: clamped",
            )  # fmt: skip
        half_plane = refined_mesh(sections)
        if model is None:
            model = FourierModel(half_plane)
        else:
            model.move(half_plane)
        self.sections, self.model = sections, model
        wall = sections.mandrel.solid()
        extra = _nonstructural_mass(sections) / half_plane.volume(coil=False)
        model.set_material(WALL, wall.stiffness(), wall.rho + extra)
        self.mass_total = sections.mandrel.tip_mass + (wall.rho + extra) * half_plane.volume(coil=False)
        if sections.coil.model in MESHED_COILS:
            coil = sections.coil.solid()
            self.set_coil(coil)
            self.mass_total += coil.rho * half_plane.volume(coil=True)
        self._nodes = model.nodes
        self._tip_share: FloatArray | None = None if sections.mandrel.tip == "rigid" else model.tip_weights()

    def set_coil(self, material: CylindricalOrthotropic) -> None:
        """Replace the material of the coil; the density must stay the same.

        Raises
        ------
        ValueError
            If the principal axes of the material are not r, theta, z.
        """
        self.model.set_material(COIL, material.stiffness(), material.rho)

    def matrices(self, symmetry: SymmetryClass) -> SymmetryClassMatrices:
        """Assemble the matrices of a symmetry class and eliminate the supports."""
        m, r = symmetry.wave_number, self._nodes[:, 0]
        clamped, mandrel = self._clamped(), self.sections.mandrel
        tip = self._tip_nodes() & ~clamped if mandrel.tip == "rigid" else np.zeros(len(r), bool)
        base = self._wall_base() & ~clamped if mandrel.springs is not None else np.zeros(len(r), bool)
        free = np.zeros((len(r), 3), bool)
        free[:, list(symmetry.components)] = True
        free[clamped | tip | base] = False
        own = np.flatnonzero(free.ravel())
        expand = sp.csr_matrix((np.ones(len(own)), (own, np.arange(len(own)))), shape=(3 * len(r), len(own)))
        moves = _rigid_components(symmetry)
        at_tip = moves if mandrel.tip == "rigid" else []
        at_base = [] if mandrel.springs is None else [k for k in moves if mandrel.springs.six[k] is not None]
        for nodes, kept in ((tip, at_tip), (base, at_base)):
            if kept:
                motions = _rigid_ring(symmetry, r, nodes)[:, [moves.index(k) for k in kept]]
                expand = sp.hstack([expand, sp.csr_matrix(motions)]).tocsr()
        n, first = expand.shape[1], len(own)
        influence, probe = np.zeros(n), np.zeros(n)
        if symmetry.direction is not None:
            influence[:first] = np.tile(_translation(symmetry), len(r))[own]
            influence[first:] = [k < 3 for k in (*at_tip, *at_base)]
            if mandrel.tip == "rigid":  # the first motion of the rigid tip is its translation
                probe[first] = 1.0
            elif self._tip_share is not None:
                mean = np.outer(self._tip_share, _translation(symmetry) / np.abs(_translation(symmetry)).sum()).ravel()
                probe = np.asarray(expand.T @ mean)
        mass = expand.T @ self._nodal_mass(m) @ expand
        stiffness = expand.T @ self.model.stiffness(m) @ expand
        if at_tip:
            turn = mandrel.tip_inertia or TipInertia()
            body = rigid_mass(mandrel.tip_mass, turn.transverse, turn.polar, mandrel.tip_offset or 0.0)
            mass = mass + _at(body, at_tip, first, n)
            if mandrel.tip_springs is not None:
                stiffness = stiffness + _at(spring_matrix(mandrel.tip_springs.six), at_tip, first, n)
        if at_base and mandrel.springs is not None:
            stiffness = stiffness + _at(spring_matrix(mandrel.springs.six), at_base, first + len(at_tip), n)
        return SymmetryClassMatrices(_symmetric(stiffness), _symmetric(mass), expand, influence, probe)

    def _nodal_mass(self, m: int) -> sp.csr_matrix:
        mass = self.model.mass(m)
        if self._tip_share is not None and self.sections.mandrel.tip_mass:
            per_node = self.sections.mandrel.tip_mass * self._tip_share * angular_weight(m) / (2 * np.pi)
            mass = mass + sp.diags(np.repeat(per_node, 3))
        return mass

    def _clamped(self) -> BoolArray:
        """(n_nodes,) mask of the clamped nodes, which move with the base."""
        half_plane, coil = self.model.half_plane, self.sections.coil
        near = _NEAR * half_plane.length
        r, z = self._nodes.T
        base = z < half_plane.heights[0] + near
        clamped = np.zeros(len(r), bool)
        if self.sections.mandrel.base == "clamped":
            clamped |= base & (r < half_plane.wall_radius + near)
        if coil.model in MESHED_COILS:
            outside = base & (r > half_plane.wall_radius - near)
            if coil.base == "clamped":
                clamped |= outside
            elif coil.base == "inner_edge":
                edge = half_plane.wall_radius + (coil.layer_thickness if coil.model == "bonded" else 0.0)
                clamped |= outside & (r < edge + near)
        return clamped

    def _wall_base(self) -> BoolArray:
        """(n_nodes,) mask of the nodes on the end face of the wall at the base."""
        half_plane = self.model.half_plane
        near = _NEAR * half_plane.length
        r, z = self._nodes.T
        return np.asarray((z < half_plane.heights[0] + near) & (r < half_plane.wall_radius + near))

    def _tip_nodes(self) -> BoolArray:
        """(n_nodes,) mask of the nodes on the end face of the wall at the tip."""
        half_plane = self.model.half_plane
        near = _NEAR * half_plane.length
        r, z = self._nodes.T
        return np.asarray((z > half_plane.heights[-1] - near) & (r < half_plane.wall_radius + near))


def _translation(symmetry: SymmetryClass) -> FloatArray:
    """Displacement amplitudes (U, V, W) of a unit translation along the direction of a symmetry class."""
    return np.array([1.0, -1.0, 0.0]) if symmetry.direction == "x" else np.array([0.0, 0.0, 1.0])


def _rigid_components(symmetry: SymmetryClass) -> list[int]:
    """Components in [U, Omega] of the rigid motions of `_rigid_ring`."""
    if symmetry.wave_number > 1:
        return []
    return [0, 4] if symmetry.wave_number == 1 else [5] if symmetry == TORSION else [2]


def _at(matrix: FloatArray, components: list[int], first: int, n: int) -> sp.csr_matrix:
    """(n, n) matrix with the ``components`` of a (6, 6) ``matrix`` at the unknowns from ``first`` on."""
    block = sp.csr_matrix(matrix[np.ix_(components, components)])
    after = n - first - len(components)
    return sp.block_diag([sp.csr_matrix((first, first)), block, sp.csr_matrix((after, after))], format="csr")


def _rigid_ring(symmetry: SymmetryClass, r: FloatArray, nodes: BoolArray) -> FloatArray:
    """(3 n_nodes, k) nodal amplitudes of the k rigid-body motions of an end face in a symmetry class.

    k is 2 for the wave number 1, 1 for 0, and 0 for all other wave numbers. Translation along x is
    (U, V) = (1, -1); tilt about y, u = Omega x (x - c), is W = -r; torsion is V = r.
    """
    at = 3 * np.flatnonzero(nodes)
    if symmetry.wave_number > 1:
        return np.zeros((3 * len(r), 0))
    motions = np.zeros((3 * len(r), 2 if symmetry.wave_number == 1 else 1))
    if symmetry.wave_number == 1:
        motions[at, 0], motions[at + 1, 0] = 1.0, -1.0
        motions[at + 2, 1] = -r[nodes]
    elif symmetry == TORSION:
        motions[at + 1, 0] = r[nodes]
    else:
        motions[at + 2, 0] = 1.0
    return motions


def _nonstructural_mass(sections: RollSections) -> float:
    """Mass, kg, of a coil without stiffness, which is added to the wall; 0 for other coil models."""
    if sections.coil.model != "nonstructural_mass":
        return 0.0
    outer, t = 0.5 * sections.geometry.mandrel_outer_diameter, sections.coil.total_thickness
    return float(sections.coil.material.rho * np.pi * t * (2 * outer + t) * sections.geometry.length)


def _symmetric(matrix: sp.spmatrix) -> sp.csr_matrix:
    tidy = ((matrix + matrix.T) * 0.5).tocsr()
    tidy.sort_indices()
    return tidy
