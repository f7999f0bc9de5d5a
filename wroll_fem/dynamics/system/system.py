"""Linear structure with nonlinear interfaces, independent of the finite-element library."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Body
from wroll_fem.bodies.stress import ShellStress
from wroll_fem.contact.interface import FrictionLaw, Interface, NormalPenalty, PointwiseFriction, matched_interface
from wroll_fem.contact.laws import PointLaws, stack_laws
from wroll_fem.contact.point import per_dof
from wroll_fem.dynamics.system.cyclic_symmetry import Subspace, cyclic_subspaces
from wroll_fem.dynamics.system.harmonic_force import HarmonicForce
from wroll_fem.dynamics.system.modal_damping import ModalDamping
from wroll_fem.errors import InputError
from wroll_fem.numerics.linear import factorise
from wroll_fem.typing import FloatArray

TIE_FACTOR = 100.0
"""Stiffness of bonded interfaces in all directions, divided by the normal penalty. Natural frequencies then agree with
those of exactly tied interfaces to 1e-4."""


@dataclass(frozen=True)
class System:
    """Matrices, interfaces, probes and loads of a structure: the input of statics and dynamics.

    It can be assembled from bodies (`System.from_bodies`) or from the user's own matrices.

    Attributes
    ----------
    stiffness, mass
        (n, n) sparse symmetric, N/m and kg.
    influence
        (n,) displacement of the DOFs under a unit base translation along the excitation.
    interfaces
        Interfaces, inner first; may be empty.
    probes
        By name, the row (n,) that gives a displacement in m; "tip" is along the excitation.
    loads
        By name, the static force vector (n,), N; "preload" is applied by the preload step.
    subspaces
        Invariant subspaces of a rotationally symmetric structure (see `cyclic_symmetry`); empty without this symmetry.
    damping
        (n, n) sparse symmetric viscous damping, N s/m; None without it.
    modal_damping
        Damping ratios of the modes with sticking interfaces, in addition to ``damping``; None without them.
    pressures
        External pressure on each layer in Pa, inner first, that causes the load "preload"; empty for other loads.
    initial_pressure
        (n_points,) contact pressure of the initial stress of a wound roll, Pa, with which the load "preload" is in
        equilibrium without deformation; None for other loads.
    probe_base
        Displacement of probes under a unit base translation, for points near a clamped end, where degrees of freedom
        are missing. For other probes it follows from their row and the influence vector.
    base_loads
        By name (`BASE_LOADS`), the row (n,) whose product with the accelerations relative to the base, with the sign
        changed, is a load on the base (N, N m), and the load per unit base acceleration of the rigid structure.
    force
        (n,) force in N that excites the structure in place of the base, per unit of the excitation; see `excited_by`.
    harmonic_forces
        Further periodic forces, per unit of the excitation; harmonic balance only.
    shell_stress
        Function that returns the stress recovery of each shell, innermost first; None if it is not known.
    """

    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    influence: FloatArray
    interfaces: tuple[Interface, ...] = ()
    probes: Mapping[str, FloatArray] = field(default_factory=dict)
    loads: Mapping[str, FloatArray] = field(default_factory=dict)
    subspaces: tuple[Subspace, ...] = ()
    damping: sp.csr_matrix | None = None
    modal_damping: ModalDamping | None = None
    pressures: tuple[float, ...] = ()
    initial_pressure: FloatArray | None = None
    probe_base: Mapping[str, float] = field(default_factory=dict)
    base_loads: Mapping[str, tuple[FloatArray, float]] = field(default_factory=dict)
    shell_stress: Callable[[], tuple[ShellStress, ...]] | None = None
    force: FloatArray | None = None
    harmonic_forces: tuple[HarmonicForce, ...] = ()

    def __post_init__(self) -> None:
        n = self.stiffness.shape[0]
        if self.stiffness.shape != (n, n) or self.mass.shape != (n, n) or self.influence.shape != (n,):
            raise InputError(
                f"stiffness {self.stiffness.shape}, mass {self.mass.shape} and influence {self.influence.shape} "
                "do not have matching shapes"
            )
        if self.damping is not None:
            _check_damping(self.damping, n)
        for interface in self.interfaces:
            if interface.operator.shape[1] != n:
                raise InputError(
                    f"the operator of interface {interface.name} has {interface.operator.shape[1]} columns, "
                    f"but the system has {n} degrees of freedom"
                )

    @cached_property
    def shells(self) -> tuple[ShellStress, ...]:
        """Stress recovery of each shell, innermost first; empty if it is not known."""
        return () if self.shell_stress is None else self.shell_stress()

    @property
    def n_dofs(self) -> int:
        """Number of degrees of freedom."""
        return int(self.stiffness.shape[0])

    @property
    def n_points(self) -> int:
        """Number of contact points of all interfaces."""
        return sum(interface.n_points for interface in self.interfaces)

    @property
    def probe_names(self) -> tuple[str, ...]:
        """Names of the probes: the tip first, then the probes of the case or of the file."""
        return ("tip", *(name for name in self.probes if name != "tip"))

    def excited_by(self, force: FloatArray) -> System:
        """System that a ``force`` (n,), N, excites in place of the base.

        The inertia force -M r a of a base acceleration a is this force for r = -M^-1 F. The displacements relative to
        the base are then those of the structure, so no probe moves with the base. The mass matrix has to be regular.
        """
        influence = -factorise(sp.csc_matrix(self.mass)).solve(force)
        rigid = dict.fromkeys(self.probes, 0.0)
        return replace(self, influence=influence, force=force, probe_base=rigid, base_loads={})

    @property
    def rigid_tip(self) -> float:
        """Displacement of the tip under a unit base translation: 1, or 0 if a force excites the structure."""
        return 1.0 if self.force is None else 0.0

    def rigid_motion(self, probe: str) -> float:
        """Displacement of a probe under a unit base translation along the excitation."""
        return float(self.probe_base.get(probe, self.probes[probe] @ self.influence))

    @cached_property
    def named_probes(self) -> FloatArray:
        """(p, n) matrix whose rows give the displacements of all probes but the tip, in the order of `probe_names`."""
        return np.array([self.probes[name] for name in self.probe_names[1:]]).reshape(-1, self.n_dofs)

    @cached_property
    def output_rows(self) -> FloatArray:
        """(k, n) matrix of `named_probes`, followed by the rows of `base_loads`."""
        return np.array([*self.named_probes, *(row for row, _ in self.base_loads.values())]).reshape(-1, self.n_dofs)

    def with_base_loads(self, rotation: FloatArray | None = None, mass_total: float | None = None) -> System:
        """System that records the base shear, and the base moment if the rotation of the base is given.

        The inertia forces of all degrees of freedom are summed with their rigid motions. In equilibrium this is the
        reaction of the base.

        Parameters
        ----------
        rotation
            (n,) displacement of the DOFs under a unit rotation of the base.
        mass_total
            Mass including that of clamped nodes, which have no DOFs, kg; None if there are none.
        """
        shear = self.mass @ self.influence
        moved = float(self.influence @ shear)
        if self.force is not None:
            return self
        loads = {"base_shear": (shear, moved if mass_total is None else max(mass_total, moved))}
        if rotation is not None:
            loads["base_moment"] = (self.mass @ rotation, float(rotation @ shear))
        return replace(self, base_loads=loads)

    @cached_property
    def laws(self) -> PointLaws:
        """Areas and contact-law parameters of all contact points."""
        return stack_laws(
            [i.areas for i in self.interfaces],
            [i.friction for i in self.interfaces],
            [i.normal.stiffness for i in self.interfaces],
            [i.normal.separation for i in self.interfaces],
        )

    @cached_property
    def jump(self) -> sp.csr_matrix:
        """(3 n_points, n) operator of the relative displacement; its rows are in the order of `contact.point`."""
        tangential, normal = [], []
        for interface in self.interfaces:
            k = np.arange(interface.n_points)
            rows = np.column_stack([3 * k + 1, 3 * k + 2]).ravel()
            tangential.append(interface.operator[rows])
            normal.append(interface.operator[3 * k])
        if not tangential:
            return sp.csr_matrix((0, self.n_dofs))
        return sp.vstack(tangential + normal, format="csr")

    @cached_property
    def _spread(self) -> sp.csr_matrix:
        """(n, 3 n_points) transpose of `jump`; a product with ``jump.T`` would build it every time."""
        return self.jump.T.tocsr()

    def contact_force(self, traction: FloatArray) -> FloatArray:
        """(n,) forces on the degrees of freedom, N, of tractions (3 n_points,) on the contact points, Pa."""
        return np.asarray(self._spread @ (self.weights * traction))

    @cached_property
    def weights(self) -> FloatArray:
        """(3 n_points,) area of each contact degree of freedom, m^2."""
        return per_dof(self.laws.area, self.laws.area)

    def interface_springs(self, stiffness: FloatArray) -> sp.csr_matrix:
        """G^T W diag(stiffness) G for springs of ``stiffness`` (3 n_points,) Pa/m per contact degree of freedom."""
        if not self.interfaces:
            return sp.csr_matrix(self.stiffness.shape)
        return (self._spread @ sp.diags(self.weights * stiffness) @ self.jump).tocsr()

    def with_interface_springs(self, stiffness: FloatArray) -> sp.csc_matrix:
        """K and the `interface_springs` of ``stiffness`` (3 n_points,), Pa/m."""
        return (self.stiffness + self.interface_springs(stiffness)).tocsc()

    @cached_property
    def tie_springs(self) -> FloatArray:
        """(3 n_points,) springs that bond the interfaces, Pa/m: `TIE_FACTOR` times the normal penalty."""
        return TIE_FACTOR * per_dof(self.laws.kn, self.laws.kn)

    def pressed(self, pressures: FloatArray) -> System:
        """System whose preload presses the two surfaces of each interface together, without an external load.

        The forces of the preload are those of uniform pressures on both surfaces. They are the resultant of the initial
        stress of a wound roll, with which the contact pressure is in equilibrium: the bodies do not deform.

        Parameters
        ----------
        pressures
            (n_interfaces,) Pa, inner interface first.
        """
        at_points = np.repeat(pressures, [interface.n_points for interface in self.interfaces])
        force = self.contact_force(per_dof(np.zeros_like(at_points), -at_points))
        return replace(self, loads={**self.loads, "preload": force}, initial_pressure=at_points)

    def bonded(self) -> System:
        """Linear structure with bonded interfaces: its stiffness includes `tie_springs`, and it has no interfaces."""
        stiffness = self.with_interface_springs(self.tie_springs).tocsr()
        return replace(self, stiffness=stiffness, interfaces=())

    @classmethod
    def from_bodies(
        cls,
        bodies: Sequence[Body],
        *,
        direction: int = 0,
        friction: FrictionLaw | PointwiseFriction | Sequence[FrictionLaw] | None = None,
        normal: NormalPenalty | None = None,
        pressures: Sequence[float] = (),
    ) -> System:
        """Stack bodies (inner first) and place an interface between each adjacent pair.

        Of several probes with the same name, the probe of the innermost body is kept: the tip of a roll is the tip of
        its mandrel.

        Parameters
        ----------
        direction
            Direction of the excitation: 0 for x, 1 for y.
        friction, normal
            Friction law and normal law of every interface; required for two or more bodies. A sequence has the friction
            law of each interface, inner first.
        pressures
            (n_bodies - 1,) external pressure on each layer in Pa, inner first.
        """
        starts = np.concatenate([[0], np.cumsum([b.n_dofs for b in bodies])])
        columns = [slice(int(a), int(b)) for a, b in pairwise(starts)]
        n = int(starts[-1])
        interfaces = []
        if len(bodies) > 1:
            if friction is None or normal is None:
                raise InputError("several bodies need a friction law and a normal law", key="contact")
            count = len(bodies) - 1
            laws = [*friction] if isinstance(friction, Sequence) else [friction] * count
            if len(laws) != count:
                raise InputError(f"{len(laws)} friction laws for {count} interfaces", key="contact.friction")
            for i in range(count):
                interfaces.append(
                    matched_interface(
                        f"{bodies[i].name}/{bodies[i + 1].name}",
                        bodies[i].traces["outer"],
                        bodies[i + 1].traces["inner"],
                        (columns[i], columns[i + 1]),
                        n,
                        laws[i],
                        normal,
                    )
                )
        preload = np.zeros(n)
        for pressure, body, cols in zip(pressures, bodies[1:], columns[1:], strict=False):
            preload[cols] += pressure * body.pressure_force
        probes = {}
        for body, cols in zip(bodies, columns, strict=True):
            for name, operator in body.probes.items():
                if name not in probes:  # the tip of the roll is that of the mandrel
                    probes[name] = np.zeros(n)
                    probes[name][cols] = np.asarray(operator[direction].todense()).ravel()
        return cls(
            stiffness=_stacked([b.stiffness for b in bodies]),
            mass=_stacked([b.mass for b in bodies]),
            influence=np.concatenate([b.influence[:, direction] for b in bodies]),
            interfaces=tuple(interfaces),
            probes=probes,
            loads={"preload": preload},
            subspaces=cyclic_subspaces(bodies),
            pressures=tuple(float(pressure) for pressure in pressures),
        )


def _stacked(matrices: Sequence[sp.csr_matrix]) -> sp.csr_matrix:
    """Block diagonal matrix; `scipy.sparse.block_diag` needs several times its memory, gigabytes for a refined coil."""
    parts = [sp.csr_matrix(matrix) for matrix in matrices]
    starts = np.cumsum([0, *(part.shape[0] for part in parts)])
    entries = np.cumsum([0, *(part.nnz for part in parts)])
    index = parts[0].indices.dtype if entries[-1] < np.iinfo(np.int32).max else np.dtype(np.int64)
    columns = np.concatenate([part.indices + index.type(start) for part, start in zip(parts, starts, strict=False)])
    ends = [part.indptr[1:].astype(index) + index.type(of) for part, of in zip(parts, entries, strict=False)]
    pointers = np.concatenate([np.zeros(1, index), *ends])
    return sp.csr_matrix((np.concatenate([part.data for part in parts]), columns, pointers), shape=2 * (starts[-1],))


def _check_damping(damping: sp.csr_matrix, n: int) -> None:
    """Raise unless ``damping`` is (n, n), finite and symmetric."""
    if damping.shape != (n, n):
        raise InputError(f"damping {damping.shape} does not match the stiffness ({n}, {n})", key="damping")
    largest = abs(damping).max() if damping.nnz else 0.0
    if not np.isfinite(largest) or abs(damping - damping.T).max() > 1e-9 * largest:
        raise InputError("the viscous damping matrix is not finite or not symmetric", key="damping")
