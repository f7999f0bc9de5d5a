"""Small systems with exact solutions, built from matrices, and the quantities that tests compute from them."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy.sparse as sp

from wroll_fem.contact import kernels
from wroll_fem.contact.interface import Interface, NormalPenalty, PenaltyCoulomb
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.full import FullStepper
from wroll_fem.dynamics.time_stepping.records import INPUT, KINETIC, NUMERICAL
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions

STEPPERS = ["full", "condensed"]


def stepper(method, system, state, scheme, dt, options=None):
    """Time stepper by name."""
    options = options or NewtonOptions()
    if method == "full":
        return FullStepper(system, state, scheme, options)
    return CondensedStepper(system, state, scheme, options, dt=dt)


def contact_point(normal, hoop, axial, *, mu, gamma, kn, area=1.0):
    """Interface of one point whose jumps are the given rows over the DOFs."""
    operator = sp.csr_matrix(np.array([normal, hoop, axial], float))
    laws = PenaltyCoulomb(mu, gamma), NormalPenalty(kn)
    return Interface("point", operator, np.array([area]), np.zeros((1, 3)), *laws)


def dense_system(stiffness, mass, influence, *interfaces, tip, preload=None):
    """System from small dense matrices."""
    influence, tip = np.array(influence, float), np.array(tip, float)
    return System(
        sp.csr_matrix(np.array(stiffness, float)),
        sp.csr_matrix(np.array(mass, float)),
        influence,
        interfaces,
        {"tip": tip},
        {} if preload is None else {"preload": np.array(preload, float)},
    )


def oscillator(frequency_hz=10.0, mass=2.0):
    """One mass on a spring, no friction."""
    return dense_system([[mass * (2 * np.pi * frequency_hz) ** 2]], [[mass]], [1.0], tip=[1.0])


def coulomb_oscillator(*, mass=1.0, stiffness=1.0e4, force=10.0, mu=0.3, gamma=1.0e-8):
    """A mass on a spring, pressed by ``force`` (N) on rough ground: DOFs along the ground and normal to it."""
    point = contact_point([0, 1], [1, 0], [0, 0], mu=mu, gamma=gamma, kn=1.0e8)
    k, m = np.diag([stiffness, 0.0]), np.diag([mass, mass])
    return dense_system(k, m, [1, 0], point, tip=[1, 0], preload=[0, -force])


def lifting_mass(*, damping_ratio=0.02):
    """A damped mass on a spring of its own and, under preload, on a second one that it leaves at large amplitude."""
    point = contact_point([1.0], [0.0], [0.0], mu=0.3, gamma=1e-5, kn=1.0e4)
    plain = dense_system([[1.0e4]], [[1.0]], [1.0], point, tip=[1.0], preload=[-20.0])
    return replace(plain, damping=2.0 * damping_ratio * np.sqrt(2.0e4) * plain.mass)


def slipping_pair(*, mu=0.3, gamma=2.0e-6):
    """Two masses in a row, rubbing on each other; an inclined spring makes the pressure vary with the motion.

    DOFs: both along the base motion, and the second normal to the rubbing surface.
    """
    k = 1.0e4 * np.array([[4.0, -1.0, 0.0], [-1.0, 1.0, 0.02], [0.0, 0.02, 1.0]])
    point = contact_point([0, 0, 1], [-1, 1, 0], [0, 0, 0], mu=mu, gamma=gamma, kn=1.0e8)
    return dense_system(k, np.diag([1.0, 0.5, 0.5]), [1, 1, 0], point, tip=[0, 1, 0], preload=[0, 0, -10.0])


def orbiting_mass(*, mu=0.3, gamma=1.0e-5):
    """A mass on two springs of its own that slides on a plane in both directions."""
    point = contact_point([0, 0, 1], [1, 0, 0], [0, 1, 0], mu=mu, gamma=gamma, kn=1.0e8)
    k, m = np.diag([1.0e4, 1.2e4, 0.0]), np.eye(3)
    return dense_system(k, m, [1, 0, 0], point, tip=[1, 0, 0], preload=[0, 0, -10.0])


def with_law(system, law):
    """The system with another friction law in all its interfaces."""
    parts = tuple(replace(interface, friction=law) for interface in system.interfaces)
    return replace(system, interfaces=parts)


def with_preload(system, along, values):
    """Force vectors (n_dofs,) that hold the preload and add each of ``values`` (N) times the row ``along``."""
    return [system.loads["preload"] + value * np.asarray(along, float) for value in values]


def interface_ledger(system, states):
    """(5,) friction, stored, modulation, total and impact work from one committed state to the next, J."""
    work = np.zeros(5)
    for a, b in pairwise(states):
        kernels.interface_work(
            a.jump, a.elastic_slip, a.traction, b.jump, b.elastic_slip, b.traction,
            system.laws, work,
        )  # fmt: skip
    return work


@dataclass(frozen=True)
class TwoLeaves:
    """Cantilever of two Euler-Bernoulli leaves pressed together (Goodman & Klumpp 1956).

    Both leaves share the deflection w; each has its own axial displacement. Elements: cubic w, quadratic
    axial displacement, hence a relative displacement u_2 - u_1 + h w' that is quadratic; two Gauss points per
    element integrate its work exactly, so that the stuck and the slipping solution are both exact on any mesh.
    The pressure is given by pads: one normal DOF per interface point, loaded by p times its area.
    """

    elements: int = 4
    young: float = 70.0e9
    width: float = 0.03
    height: float = 5.0e-3  # of one leaf
    length: float = 0.3
    mu: float = 0.2
    pressure: float = 1.0e6
    gamma: float = 1.0e-9

    @property
    def bending(self) -> float:
        """E I of one leaf, N m^2."""
        return self.young * self.width * self.height**3 / 12.0

    @property
    def slip_load(self) -> float:
        """P_s = 4/3 b h mu p: the shear stress 3 P / (4 b h) at mid-depth of the solid section reaches mu p."""
        return 4.0 / 3.0 * self.width * self.height * self.mu * self.pressure

    @cached_property
    def tip(self) -> np.ndarray:
        """Row that gives the tip's deflection; times a force, the load vector."""
        row = np.zeros(self.system.n_dofs)
        row[2 * (self.elements - 1)] = 1.0
        return row

    @cached_property
    def system(self) -> System:
        """DOFs: (w, w') per node, axial displacements of leaf 1 and of leaf 2, pads; those of the root left out."""
        n, ell = self.elements, self.length / self.elements
        first = np.cumsum([0, 2 * (n + 1), 2 * n + 1, 2 * n + 1, 2 * n])  # w, leaf 1, leaf 2, pads, total
        k, rows = np.zeros((first[-1], first[-1])), np.zeros((6 * n, first[-1]))
        beam = np.array(
            [[12, 6 * ell, -12, 6 * ell], [6 * ell, 4 * ell**2, -6 * ell, 2 * ell**2],
             [-12, -6 * ell, 12, -6 * ell], [6 * ell, 2 * ell**2, -6 * ell, 4 * ell**2]]
        )  # fmt: skip
        beam *= 2.0 * self.bending / ell**3
        bar = self.young * self.width * self.height / (3.0 * ell) * np.array([[7, -8, 1], [-8, 16, -8], [1, -8, 7]])
        for e in range(n):
            w, one, two = (start + 2 * e + np.arange(count) for start, count in zip(first, (4, 3, 3), strict=False))
            for dofs, block in ((w, beam), (one, bar), (two, bar)):
                k[np.ix_(dofs, dofs)] += block
            for i, xi in enumerate((-1.0 / np.sqrt(3.0), 1.0 / np.sqrt(3.0))):
                point, s = 2 * e + i, 0.5 * (1.0 + xi)
                slope = np.array([6 * s * (s - 1) / ell, 1 - 4 * s + 3 * s * s, 6 * s * (1 - s) / ell, s * (3 * s - 2)])
                shape = np.array([0.5 * xi * (xi - 1), 1 - xi * xi, 0.5 * xi * (xi + 1)])
                rows[3 * point, first[3] + point] = 1.0
                rows[3 * point + 2, np.concatenate([w, one, two])] = np.concatenate(
                    [self.height * slope, -shape, shape]
                )
        free = np.setdiff1d(np.arange(first[-1]), [0, 1, first[1], first[2]])
        areas, preload = np.full(2 * n, 0.5 * self.width * ell), np.zeros(len(free))
        preload[-2 * n :] = -self.pressure * areas
        laws = PenaltyCoulomb(self.mu, self.gamma), NormalPenalty(1.0e13)
        interface = Interface("leaves", sp.csr_matrix(rows[:, free]), areas, np.zeros((2 * n, 3)), *laws)
        stiffness, mass = sp.csr_matrix(k[np.ix_(free, free)]), sp.identity(len(free), format="csr")
        return System(stiffness, mass, np.zeros(len(free)), (interface,), {}, {"preload": preload})

    def deflections(self, states: list[ContactState]) -> np.ndarray:
        return np.array([self.tip @ state.displacement for state in states])


def unbalanced(records):
    """Input less everything it can have become, J per step."""
    return records[:, INPUT] - records[:, KINETIC : NUMERICAL + 1].sum(axis=1)


def rest(system):
    return solve_preload(system) if system.interfaces else ContactState.unloaded(system)


def legs(turning, steps):
    """Equal steps from each turning point to the next, the very first point left out."""
    return np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(turning)])
