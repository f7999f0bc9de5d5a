"""Modes of a structure whose interfaces are held by springs, computed separately for each circumferential block.

Without truncation the modes represent the interior exactly. They give the compliance of the interfaces, for static
solutions and for time steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.reduction.cyclic_blocks import Blocks, by_component, spread, without_tangential_springs
from wroll_fem.dynamics.system.harmonic_force import HarmonicForce
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.numerics.linear import factorise
from wroll_fem.typing import BoolArray, FloatArray

DENSE_LIMIT = 2500
"""Largest number of DOFs of a structure without rotational symmetry for which all modes are kept."""

LOW_MODES = 120
"""Number of lowest modes in the projection basis of a structure without rotational symmetry that has more than
`DENSE_LIMIT` DOFs."""

NO_MOTION = 1e-10
"""Energy norm of the response to a load, relative to the largest such norm in the same circumferential block, below
which the response is dropped."""

DEPENDENT = 1e-12
"""Tolerance of linear dependence in the series K^{-1} L, K^{-1} M K^{-1} L, ... (L: loads). A vector is dropped if its
component orthogonal to the vectors already kept is smaller than this fraction of the largest such component."""


MOMENTS, MOMENTS_OF_LARGE, LARGE = 4, 3, 20_000
"""Number of terms in the series (in frequency squared) for the compliance of each circumferential block, where not all
modes are kept (see `condense`); the same for a structure with more than `LARGE` DOFs. The relative error is below 1e-9
up to about ten times the resonance frequency of the lab roll. Dwells of the solid coils of HabEx and iROSA change by
4e-6 and 1e-10 of the tip motion if two terms are added to four of them, by 2e-5 and 1e-7 with three."""


LEAST_PARTICIPATION = 1e-3
"""Participation of a mode, relative to that of the main mode, above which it counts as moving the tip."""


@dataclass(frozen=True)
class Condensation:
    """Modes of the structure with its interfaces stuck, sorted by circumferential block; modal masses are 1.

    Attributes
    ----------
    eigenvalues : (r,) rad^2/s^2 of the r modes, block after block
    blocks : (n_blocks + 1,) index of the first mode of each block, then r
    vectors : mode shapes (n_dofs, r_b) of each block, as a pair of sparse basis and dense Ritz vectors to be multiplied
    jump : one (n_waves 3 n_rows, r_b) per block: amplitudes of the hoop, axial and normal jump of each wave in each row
        of contact points
    profiles : (n_blocks, n_waves, 3, n_theta) shape of these components around a row
    base : (r,) modal participation factors; the modal load is -base per unit base acceleration, kg^(1/2)
    tip : (r,) tip displacement
    probes : (p, r) displacement at the other probes, then the rows of the loads at the base (`System.output_rows`)
    springs : (3 n_points,) reference contact stiffness D_0, Pa/m
    exact : False for the projection of a large structure without symmetry, whose error is about 1e-4
    damping : viscous damping of the modes of each block, 1/s: (r_b,) if they are uncoupled, otherwise (r_b, r_b); empty
        without damping
    moments : 0 if every mode of every block is kept; otherwise see `condense`
    forces : harmonic forces in addition to the excitation, on the modal coordinates
    rigid_tip : displacement of the tip under a unit base translation; 0 if a force excites the structure
    """

    eigenvalues: FloatArray
    blocks: np.ndarray
    vectors: list[tuple[sp.csc_matrix, FloatArray]]
    jump: list[FloatArray]
    profiles: FloatArray
    base: FloatArray
    tip: FloatArray
    probes: FloatArray
    springs: FloatArray
    exact: bool
    damping: tuple[FloatArray, ...] = ()
    moments: int = 0
    rigid_tip: float = 1.0
    forces: tuple[HarmonicForce, ...] = ()

    @property
    def n_theta(self) -> int:
        """Number of contact points per circumferential row."""
        return int(self.profiles.shape[3])

    @property
    def main_mode(self) -> tuple[float, float]:
        """Frequency (Hz) and participation (base times tip) of the mode with the largest tip motion; nan without modes.

        The peak of this mode alone has the height participation / (2 zeta).
        """
        return self.main_mode_of(np.ones(len(self.eigenvalues), dtype=bool))

    def main_mode_between(self, low: float, high: float) -> tuple[float, float]:
        """`main_mode` of the modes between two frequencies, Hz; of all modes if none between them moves the tip."""
        hertz, share = np.sqrt(np.maximum(self.eigenvalues, 0.0)) / (2.0 * np.pi), np.abs(self.base * self.tip)
        within = (hertz >= low) & (hertz <= high) & (share > LEAST_PARTICIPATION * share.max(initial=0.0))
        return self.main_mode_of(within) if within.any() else self.main_mode

    def main_mode_of(self, chosen: BoolArray) -> tuple[float, float]:
        """`main_mode` of the modes ``chosen`` (r,); nan if none of them moves the tip."""
        share = np.where(chosen, np.abs(self.base * self.tip), 0.0)
        if not share.any():
            return float("nan"), float("nan")
        main = int(np.argmax(share))
        return float(np.sqrt(max(self.eigenvalues[main], 0.0)) / (2.0 * np.pi)), float(share[main])

    def displacement(self, q: FloatArray) -> FloatArray:
        """(n_dofs, ...) displacement from modal coordinates (r, ...)."""
        total = np.zeros((self.vectors[0][0].shape[0], *q.shape[1:]))
        for (basis, ritz), part in zip(self.vectors, np.split(q, self.blocks[1:-1]), strict=True):
            total += basis @ (ritz @ part)  # one block after the other: the shapes of a refined coil take gigabytes
        return total

    def compliance(self, inverse: Sequence[FloatArray], area: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Interface compliance G V A V^T G^T W (V: mode shapes), by block and assembled for all points.

        Parameters
        ----------
        inverse : A, displacement per modal force, s^2, of each block: (r_b,) factor of each mode, or a matrix
            (r_b, r_b)
        area : (n_points,) area of the contact points, m^2

        Returns
        -------
        blocks : (n_blocks, n_waves 3 n_rows, n_waves 3 n_rows) amplitude of the jump per unit amplitude of the force,
            m/N
        dense : (3 n_points, 3 n_points) jump per unit traction, m/Pa
        """
        blocks = np.array([(j * p if p.ndim == 1 else j @ p) @ j.T for j, p in zip(self.jump, inverse, strict=True)])
        return blocks, spread(blocks, self.profiles, area)

    def sliding_compliance(self, blocks: FloatArray, area: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What `compliance` returns, without the tangential springs; ``blocks`` are those that it returned."""
        found = without_tangential_springs(blocks, self.profiles, self.springs, area)
        return found, spread(found, self.profiles, area)

    def viscous_force(self, velocity: FloatArray) -> FloatArray:
        """(r, k) modal forces of the dashpots at the modal velocities (r, k)."""
        parts = np.split(velocity, self.blocks[1:-1])
        return np.concatenate(
            [c[:, None] * v if c.ndim == 1 else c @ v for c, v in zip(self.damping, parts, strict=True)]
        )

    def coordinates(self, momentum: FloatArray) -> FloatArray:
        """(r,) modal coordinates of a displacement u; the argument is the product M u (n_dofs,)."""
        return np.concatenate([ritz.T @ (basis.T @ momentum) for basis, ritz in self.vectors])


def condense_cyclic(system: System, springs: FloatArray, moments: int = 0) -> Condensation | None:
    """Modes of a roll with rotational symmetry, sorted by circumferential block; None without this symmetry.

    Parameters
    ----------
    springs
        (3 n_points,) interface springs, Pa/m; they are made uniform around each row of points (`level_springs`).
    moments
        See `condense`.
    """
    blocks = Blocks.of(system, springs)
    return None if blocks is None else _condense_blocks(blocks, moments)


def condense(system: System, springs: FloatArray, scheme: Scheme, dt: float, moments: int = 0) -> Condensation:
    """Modes and interface amplitudes of ``system`` with ``springs`` (3 n_points,) in its interfaces.

    Parameters
    ----------
    scheme, dt
        Time integration scheme and step (s); used only to project a large structure without rotational symmetry.
    moments
        0 keeps all modes of a roll with rotational symmetry. A positive number keeps, in each block, the static
        responses to all loads at the interfaces, the base and the tip probe, and moments - 1 inertia corrections of
        each. The compliance then has this number of exact terms in its series in powers of the squared frequency. This
        takes a quarter of the modes and a third of the cost, and is meant for models that are reduced further. Error
        for the lab roll with 2 / 3 / 4 moments: compliance at 525 Hz 1e-7 / 1e-11 / 1e-11, at 2100 Hz 8e-4 / 3e-9 /
        2e-11; tip motion of a slipping dwell with 30 x 10 cells 1e-5 / 1e-6 / 2e-7. The last error is due to free
        oscillations of the stiffest modes in the HHT integration, which the series does not contain.
    """
    cyclic = condense_cyclic(system, springs, moments)
    if cyclic is not None:
        return cyclic
    stiffness = system.with_interface_springs(springs)
    exact = system.n_dofs <= DENSE_LIMIT
    if exact:
        values, vectors = la.eigh(stiffness.toarray(), system.mass.toarray())
    else:
        values, vectors = _attachment_projection(system, stiffness, scheme, dt)
    return in_one_block(system, springs, values, vectors, exact=exact)


def in_one_block(
    system: System, springs: FloatArray, values: FloatArray, vectors: FloatArray, *, exact: bool
) -> Condensation:
    """Condensation on the mass-orthonormal ``vectors`` (n_dofs, r), in which the stiffness is diag(``values``) (r,).

    ``springs`` (3 n_points,), Pa/m, are those of this stiffness; for ``exact`` see `Condensation`.
    """
    whole = sp.identity(system.n_dofs, format="csc")
    coupled = [] if system.damping is None else [vectors.T @ (system.damping @ vectors)]
    losses = modal_losses(system, whole, vectors)
    return Condensation(
        eigenvalues=values,
        blocks=np.array([0, len(values)]),
        vectors=[(whole, vectors)],
        jump=[np.ascontiguousarray((system.jump @ vectors)[by_component(system.n_points)])],
        profiles=np.ones((1, 1, 3, 1)),
        base=vectors.T @ (system.mass @ system.influence),
        tip=vectors.T @ system.probes["tip"],
        probes=system.output_rows @ vectors,
        springs=springs,
        exact=exact,
        damping=viscous_damping(system, values, [len(values)], coupled, losses),
        rigid_tip=system.rigid_tip,
        forces=tuple(HarmonicForce(f.order, vectors.T @ f.cosine, vectors.T @ f.sine) for f in system.harmonic_forces),
    )


def enough_moments(system: System, springs: FloatArray) -> int:
    """Number of moments (see `condense`) for periodic motions; 0, all modes, if the ``springs`` leave a body free."""
    if not held(system, springs):
        return 0
    return MOMENTS if system.n_dofs <= LARGE else MOMENTS_OF_LARGE


def held(system: System, springs: FloatArray) -> bool:
    """Whether the ``springs`` (3 n_points,) hold every interface against sliding.

    Otherwise a body is free and has no static response.
    """
    ends = np.cumsum([interface.n_points for interface in system.interfaces])[:-1]
    return all(np.any(part > 0.0) for part in np.split(tangentials(springs)[:, 0], ends))


def _condense_blocks(blocks: Blocks, moments: int) -> Condensation:
    system = blocks.system
    inertia, tip = system.mass @ system.influence, system.probes["tip"]
    values, vectors, jumps, base, end, probes, coupled, losses = [], [], [], [], [], [], [], []
    for b in range(len(blocks)):
        basis, jump = blocks.basis(b), blocks.jump(b)
        stiffness, mass = blocks.stiffness(b), blocks.mass(b)
        ends = np.column_stack([basis.T @ inertia, basis.T @ tip])
        span = _series_span(stiffness, mass, np.column_stack([jump.T.toarray(), ends]), moments) if moments else None
        pair = [m.toarray() if span is None else span.T @ (m @ span) for m in (stiffness, mass)]
        # symmetric: the transposes are the column-major arrays that LAPACK works on in place
        eigenvalues, ritz = la.eigh(pair[0].T, pair[1].T, overwrite_a=True, overwrite_b=True, check_finite=False)
        ritz = ritz if span is None else span @ ritz
        values.append(eigenvalues)
        vectors.append((basis, ritz))
        jumps.append(np.ascontiguousarray(jump @ ritz))
        base.append(ritz.T @ ends[:, 0])
        end.append(ritz.T @ ends[:, 1])
        probes.append(system.output_rows @ basis @ ritz)
        losses.append(modal_losses(system, basis, ritz))
        if (dashpots := blocks.damping(b)) is not None:
            coupled.append(ritz.T @ (dashpots @ ritz))
    counts = [len(v) for v in values]
    return Condensation(
        eigenvalues=np.concatenate(values),
        blocks=np.concatenate([[0], np.cumsum(counts)]),
        vectors=vectors,
        jump=jumps,
        profiles=blocks.profiles,
        base=np.concatenate(base),
        tip=np.concatenate(end),
        probes=np.column_stack(probes),
        springs=blocks.springs,
        exact=True,
        damping=viscous_damping(system, np.concatenate(values), counts, coupled, np.concatenate(losses)),
        moments=moments,
        rigid_tip=system.rigid_tip,
    )


def modal_losses(system: System, basis: sp.csc_matrix, ritz: FloatArray) -> FloatArray:
    """(r,) loss of each mode shape (see `ModalDamping.loss`), rad^2/s^2; empty if no loss factors are given."""
    if system.modal_damping is None or system.modal_damping.loss is None:
        return np.zeros(0)
    shapes = basis @ ritz
    return np.asarray(np.einsum("ij,ij->j", shapes, system.modal_damping.loss @ shapes))


def viscous_damping(
    system: System, eigenvalues: FloatArray, counts: Sequence[int], coupled: Sequence[FloatArray], losses: FloatArray
) -> tuple[FloatArray, ...]:
    """Viscous damping of the modes of each block: that of ``system.modal_damping`` and the matrices ``coupled``.

    Parameters
    ----------
    eigenvalues
        (r,) of all modes, rad^2/s^2.
    counts
        Number of modes of each block.
    coupled
        (r_b, r_b) ``system.damping`` in the modal coordinates of each block, 1/s; empty without it.
    losses
        (r,) from `modal_losses`.
    """
    if system.modal_damping is None:
        return tuple(coupled)
    ratios = system.modal_damping.of_modes(eigenvalues, losses if losses.size else None)
    rates = np.split(2.0 * ratios * np.sqrt(np.maximum(eigenvalues, 0.0)), np.cumsum(counts)[:-1])
    if not coupled:
        return tuple(rates)
    return tuple(matrix + np.diag(rate) for matrix, rate in zip(coupled, rates, strict=True))


def _series_span(stiffness: sp.spmatrix, mass: sp.spmatrix, loads: FloatArray, moments: int) -> FloatArray:
    """(k, m) orthonormal basis of the first ``moments`` terms of K^{-1} L, K^{-1} M K^{-1} L, ...; L (k, n): loads."""
    factor = factorise(stiffness)
    right, terms = loads, []
    for _ in range(moments):
        term = factor.solve(right)
        size = np.sqrt(np.maximum(np.einsum("ij,ij->j", term, stiffness @ term), 0.0))
        moves = size > NO_MOTION * size.max()
        terms.append(term[:, moves] / size[moves])
        right = mass @ terms[-1]
    basis, triangle = la.qr(np.column_stack(terms), mode="economic", overwrite_a=True, check_finite=False)
    # pivots of the triangle are those of all terms, which would take LAPACK three times as long
    turn, triangle, _ = la.qr(triangle, mode="economic", pivoting=True, check_finite=False)
    weight = np.abs(np.diag(triangle))
    return np.asarray(basis @ turn[:, weight > DEPENDENT * weight[0]])


def _attachment_projection(
    system: System, stiffness: sp.spmatrix, scheme: Scheme, dt: float
) -> tuple[FloatArray, FloatArray]:
    """Ritz values (r,) and Ritz vectors (n_dofs, r) in a basis of attachment vectors and low modes."""
    parts = [part for force in system.harmonic_forces for part in (force.cosine, force.sine)]
    loads = np.column_stack([system.jump.T.toarray(), system.mass @ system.influence, system.probes["tip"], *parts])
    static = factorise(stiffness)
    dynamic = factorise(system.mass / (scheme.beta * dt**2) + (1.0 + scheme.alpha) * stiffness)
    start = np.random.default_rng(1).standard_normal(system.n_dofs)
    inverse = spla.LinearOperator(stiffness.shape, matvec=static.solve)
    modes = spla.eigsh(stiffness, LOW_MODES, system.mass, sigma=0.0, OPinv=inverse, v0=start)[1]
    attachments = dynamic.solve(loads)
    span = np.column_stack([modes, static.solve(loads), attachments, dynamic.solve(system.mass @ attachments)])
    scale = np.sqrt(np.einsum("ij,ij->j", span, system.mass @ span))
    span = span[:, scale > 0.0] / scale[scale > 0.0]  # hoop motion vanishes on a symmetry plane
    gram = span.T @ (system.mass @ span)
    weight, rotation = la.eigh(0.5 * (gram + gram.T))
    keep = weight > 1e-11 * weight[-1]
    basis = span @ (rotation[:, keep] / np.sqrt(weight[keep]))
    values, ritz = la.eigh(basis.T @ (stiffness @ basis), basis.T @ (system.mass @ basis))
    return values, basis @ ritz
