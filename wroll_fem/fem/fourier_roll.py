"""A roll in harmonics around its axis: materials, base, rigid tip and coil of a case on a `FourierModel`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from wroll_fem.errors import InputError
from wroll_fem.fem.fourier import COIL, WALL, FourierModel, angular_weight
from wroll_fem.mesh.axisymmetric import IN_SECTION, make_section
from wroll_fem.structure.materials import CylindricalOrthotropic
from wroll_fem.typing import BoolArray, FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import Case


_NEAR = 1e-9  # of the length: nodes on an edge of the section


@dataclass(frozen=True)
class Family:
    """Motions that do not couple with others: a harmonic, for m = 0 its torsion or its axisymmetric half.

    Attributes
    ----------
    harmonic
        m.
    components
        Which of (U, V, W) take part.
    """

    harmonic: int
    components: tuple[int, ...]

    @property
    def direction(self) -> str | None:
        """Direction in which the family's motions shift the roll's centre of mass: "x", "z" or None."""
        if self.harmonic == 1:
            return "x"
        return "z" if self == AXIAL else None


AXIAL, TORSION, BENDING = Family(0, (0, 2)), Family(0, (1,)), Family(1, (0, 1, 2))


def families(harmonic: int) -> tuple[Family, ...]:
    """Families of a harmonic: two for m = 0, one for every other."""
    return (AXIAL, TORSION) if harmonic == 0 else (Family(harmonic, (0, 1, 2)),)


@dataclass(frozen=True)
class FamilyMatrices:
    """Stiffness and mass of a family, supports eliminated (q = T y).

    Attributes
    ----------
    stiffness, mass
        (n, n) N/m, kg.
    expand
        (3 n_nodes, n) T, to the nodal values [U, V, W].
    influence
        (n,) unknowns under a unit translation of the base along the family's direction; zeros without one.
    tip
        (n,) displacement of the tip's centre along the family's direction per unknown.
    """

    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    expand: sp.csr_matrix
    influence: FloatArray
    tip: FloatArray


class FourierRoll:
    """Roll of a case: mandrel's wall as a solid, coil bonded to its outer surface, rigid tip by elimination.

    Parameters
    ----------
    case
        geometry, mandrel, coil and mesh are used.
    model
        A model with the same numbers of cells to move to this geometry (saves building forms); None makes one.

    Raises
    ------
    InputError
        For coil models that slip, or a coil whose base is held while the mandrel's is not.

    Notes
    -----
    The clamp holds every node of the wall's base, the rigid tip every node of its end face, so both also hold the
    wall's thickness. A tip mass sits on the axis at the tip (no rotary inertia); on a free tip it is spread over the
    end face. The coil's lower inner edge belongs to the clamped wall: `free` and `inner_edge` are the same for a
    solid coil.
    """

    def __init__(self, case: Case, model: FourierModel | None = None):
        if case.coil.model not in (*IN_SECTION, "nonstructural_mass", "none"):
            raise InputError(
                "layers with friction have no harmonics of their own", key="coil.model",
                remedy="use solid, bonded, nonstructural_mass or none, or mesh.discretisation: three_dimensional",
            )  # fmt: skip
        if case.coil.model in IN_SECTION and case.mandrel.base == "free" and case.coil.base != "free":
            raise InputError(
                f"the coil's base is held, the mandrel's is free (coil.base: {case.coil.base})", key="coil.base",
                remedy="use coil.base: free, or mandrel.base: clamped",
            )  # fmt: skip
        section = make_section(case)
        if model is None:
            model = FourierModel(section)
        else:
            model.move(section)
        self.case, self.model = case, model
        wall = case.mandrel.material.solid()
        extra = _nonstructural_mass(case) / section.volume(coil=False)
        model.set_material(WALL, wall.stiffness(), wall.rho + extra)
        self.mass_total = case.mandrel.tip_mass + (wall.rho + extra) * section.volume(coil=False)
        if case.coil.model in IN_SECTION:
            coil = case.coil.material.solid()
            self.set_coil(coil)
            self.mass_total += coil.rho * section.volume(coil=True)
        self._nodes = model.nodes
        self._tip_share: FloatArray | None = None if case.mandrel.tip == "rigid" else model.tip_weights()

    def set_coil(self, material: CylindricalOrthotropic) -> None:
        """Give the coil another material of the same density."""
        self.model.set_material(COIL, material.stiffness(), material.rho)

    def matrices(self, family: Family) -> FamilyMatrices:
        """Assemble a family and eliminate its supports."""
        m, r = family.harmonic, self._nodes[:, 0]
        held, tip = self._held(), self._tip_nodes()
        rigid = self.case.mandrel.tip == "rigid"
        free = np.zeros((len(r), 3), bool)
        free[:, list(family.components)] = True
        free[held] = False
        if rigid:
            free[tip] = False
        own = np.flatnonzero(free.ravel())
        expand = sp.csr_matrix((np.ones(len(own)), (own, np.arange(len(own)))), shape=(3 * len(r), len(own)))
        if rigid:
            motions = _rigid_tip(family, r, tip & ~held)
            expand = sp.hstack([expand, sp.csr_matrix(motions)]).tocsr()
        n = expand.shape[1]
        influence, probe = np.zeros(n), np.zeros(n)
        if family.direction is not None:
            influence[: len(own)] = np.tile(_translation(family), len(r))[own]
            if rigid:  # the first of the tip's motions is its translation
                probe[len(own)] = influence[len(own)] = 1.0
            elif self._tip_share is not None:
                mean = np.outer(self._tip_share, _translation(family) / np.abs(_translation(family)).sum()).ravel()
                probe = np.asarray(expand.T @ mean)
        mass = expand.T @ self._nodal_mass(m) @ expand
        if rigid and family.direction is not None and self.case.mandrel.tip_mass:
            mass = mass + sp.diags(self.case.mandrel.tip_mass * probe)
        stiffness = expand.T @ self.model.stiffness(m) @ expand
        return FamilyMatrices(_symmetric(stiffness), _symmetric(mass), expand, influence, probe)

    def _nodal_mass(self, m: int) -> sp.csr_matrix:
        mass = self.model.mass(m)
        if self._tip_share is not None and self.case.mandrel.tip_mass:
            per_node = self.case.mandrel.tip_mass * self._tip_share * angular_weight(m) / (2 * np.pi)
            mass = mass + sp.diags(np.repeat(per_node, 3))
        return mass

    def _held(self) -> BoolArray:
        """(n_nodes,) nodes that move with the base."""
        section, coil = self.model.section, self.case.coil
        near = _NEAR * section.length
        r, z = self._nodes.T
        base = z < section.heights[0] + near
        held = np.zeros(len(r), bool)
        if self.case.mandrel.base == "clamped":
            held |= base & (r < section.wall_radius + near)
        if coil.model in IN_SECTION:
            outside = base & (r > section.wall_radius - near)
            if coil.base == "clamped":
                held |= outside
            elif coil.base == "inner_edge":
                edge = section.wall_radius + (coil.layer_thickness if coil.model == "bonded" else 0.0)
                held |= outside & (r < edge + near)
        return held

    def _tip_nodes(self) -> BoolArray:
        """(n_nodes,) nodes of the wall's end face."""
        section = self.model.section
        near = _NEAR * section.length
        r, z = self._nodes.T
        return np.asarray((z > section.heights[-1] - near) & (r < section.wall_radius + near))


def _translation(family: Family) -> FloatArray:
    """(U, V, W) of a unit translation along the family's direction."""
    return np.array([1.0, -1.0, 0.0]) if family.direction == "x" else np.array([0.0, 0.0, 1.0])


def _rigid_tip(family: Family, r: FloatArray, nodes: BoolArray) -> FloatArray:
    """(3 n_nodes, k) motions that a rigid end face has in a family: k = 2, 1, 1 for m = 1, axial, torsion, else 0.

    Translation along x is (U, V) = (1, -1); tilt about y, u = Omega x (x - c), is W = -r; torsion is V = r.
    """
    at = 3 * np.flatnonzero(nodes)
    if family.harmonic > 1:
        return np.zeros((3 * len(r), 0))
    motions = np.zeros((3 * len(r), 2 if family.harmonic == 1 else 1))
    if family.harmonic == 1:
        motions[at, 0], motions[at + 1, 0] = 1.0, -1.0
        motions[at + 2, 1] = -r[nodes]
    elif family == TORSION:
        motions[at + 1, 0] = r[nodes]
    else:
        motions[at + 2, 0] = 1.0
    return motions


def _nonstructural_mass(case: Case) -> float:
    """Mass in kg of a coil that is carried by the wall without stiffness."""
    if case.coil.model != "nonstructural_mass":
        return 0.0
    outer, t = 0.5 * case.geometry.mandrel_outer_diameter, case.coil.total_thickness
    return float(case.coil.material.rho * np.pi * t * (2 * outer + t) * case.geometry.length)


def _symmetric(matrix: sp.spmatrix) -> sp.csr_matrix:
    tidy = ((matrix + matrix.T) * 0.5).tocsr()
    tidy.sort_indices()
    return tidy
