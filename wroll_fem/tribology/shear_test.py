r"""Double shear test of two preloaded stacks of layers (thesis, appendix E.3).

Two equal stacks lie between fixed pistons and a platen, which a machine pulls through a spring (load cell and frame).
The pistons apply the normal force F_N. Platen and pistons are covered with the same film that the layers are made of,
so a stack of n - 1 layers has n interfaces. Each layer has two faces, connected by its shear stiffness G_l A/h.
Adjacent faces are connected by one contact point with penalty Coulomb friction. The n interfaces are in series,

.. math:: K = 2 \Big(\frac{n}{k_t A} + \frac{n - 1}{G_l A/h}\Big)^{-1}, \qquad k_t = \frac{\mu p}{\gamma^*}, \qquad
          p = F_N/A

until the weakest interface of each stack slides at F_c = 2 mu F_N. If all interfaces were equal, they would reach
their limit at once, and the interface that slides would be undetermined. In the experiment the interface at the platen
slides. The friction limit of all other interfaces is therefore slightly increased (`EDGE`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import xarray as xr

from wroll_fem.contact.interface import Interface, NormalPenalty, PenaltyCoulomb
from wroll_fem.dynamics.statics.preload import solve_load_path
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError, require_positive
from wroll_fem.results.dataset import annotate
from wroll_fem.typing import FloatArray

EDGE = 0.05
"""Relative increase of the friction limit at all interfaces except those at the platen. The stick stiffness is the same
at all interfaces."""
NORMAL = 1.0e11
"""Normal penalty, Pa/m; it does not affect the results, because the normal force is prescribed."""
ELASTIC = 0.8
"""Fraction of the largest force; only the data up to this force are used to fit the stiffness."""


@dataclass(frozen=True)
class ShearTest:
    """Double shear test of two stacks of layers.

    Attributes
    ----------
    interfaces
        Number n of frictional interfaces in one stack: one more than its layers, because platen and piston are covered
        with the same film.
    normal_force
        Normal force F_N of one piston, N.
    mu, elastic_slip
        Coefficient of friction at the platen; elastic slip gamma*, m.
    area
        Contact area A, m^2; 45 mm x 45 mm in the thesis.
    layer_thickness
        Thickness h of a layer, m.
    layer_shear_modulus
        Shear modulus G_l of a layer, Pa; by default the value of Kapton.
    machine_stiffness
        Stiffness of the spring between actuator and platen, N/m.

    Raises
    ------
    InputError
        If a parameter is not positive.
    """

    interfaces: int
    normal_force: float
    mu: float = 0.25
    elastic_slip: float = 1.0e-6
    area: float = 0.045**2
    layer_thickness: float = 50.8e-6
    layer_shear_modulus: float = 2.8e9 / (2.0 * 1.35)
    machine_stiffness: float = 5.0e7

    def __post_init__(self) -> None:
        if self.interfaces < 1:
            raise InputError(f"must be at least 1, got {self.interfaces}", key="interfaces", remedy="give 1 or more")
        names = ("normal_force", "mu", "elastic_slip", "area", "layer_thickness", "layer_shear_modulus")
        require_positive(self, (*names, "machine_stiffness"))

    @property
    def layers(self) -> int:
        """Number of layers in one stack, not counting the films that cover platen and piston."""
        return self.interfaces - 1

    @property
    def thickness(self) -> float:
        """Thickness t of a stack, m: all layers, half of the film on the platen and half of the film on the piston."""
        return self.interfaces * self.layer_thickness

    @property
    def capacity(self) -> float:
        """Friction capacity F_c = 2 mu F_N of both stacks, N (equation E.5)."""
        return 2.0 * self.mu * self.normal_force

    @property
    def stiffness(self) -> float:
        """Shear stiffness K of both stacks, N/m, from the equation in the module docstring."""
        stick = self.mu * self.normal_force / self.elastic_slip
        layer = self.layer_shear_modulus * self.area / self.layer_thickness
        return 2.0 / (self.interfaces / stick + self.layers / layer)

    def system(self) -> System:
        """Discrete model of the test, as a `System`.

        Its unknowns are the shear displacement of the platen and, for each stack from the platen outwards, the shear
        displacements of the two faces of each layer and the normal displacements of each layer and of the piston,
        positive towards the platen.
        """
        faces, bodies = 2 * self.layers, self.layers + 1
        size = 1 + 2 * (faces + bodies)
        stiffness, loads, parts = sp.lil_matrix((size, size)), np.zeros(size), []
        stiffness[0, 0] = self.machine_stiffness
        own = self.layer_shear_modulus * self.area / self.layer_thickness
        for stack in range(2):
            shear, normal = 1 + stack * (faces + bodies), 1 + stack * (faces + bodies) + faces
            for layer in range(self.layers):
                pair = [shear + 2 * layer, shear + 2 * layer + 1]
                for i, j, sign in ((0, 0, 1), (1, 1, 1), (0, 1, -1), (1, 0, -1)):
                    stiffness[pair[i], pair[j]] += sign * own
            loads[normal + self.layers] = self.normal_force
            parts += self._interfaces(stack, shear, normal, size)
        return System(
            stiffness=stiffness.tocsr(),
            mass=sp.identity(size, format="csr"),
            influence=np.zeros(size),
            interfaces=tuple(parts),
            probes={"platen": np.eye(1, size)[0]},
            loads={"preload": loads, "actuator": self.machine_stiffness * np.eye(1, size)[0]},
        )

    def _interfaces(self, stack: int, shear: int, normal: int, size: int) -> list[Interface]:
        """Interface at the platen and the other interfaces of one stack."""
        rows = sp.lil_matrix((3 * self.interfaces, size))
        for k in range(
            self.interfaces
        ):  # interface k connects bodies k and k + 1; body 0 is the platen, the last the piston
            inner = 0 if k == 0 else shear + 2 * k - 1
            rows[3 * k + 2, inner] = -1.0
            if k < self.layers:
                rows[3 * k + 2, shear + 2 * k] = 1.0
            # a positive relative displacement is a gap: bodies move towards the platen
            rows[3 * k, normal + k] = -1.0
            if k > 0:
                rows[3 * k, normal + k - 1] = 1.0
        operator, normal_law = rows.tocsr(), NormalPenalty(NORMAL)
        groups = [("platen", slice(0, 1), 1.0), ("layers", slice(1, self.interfaces), 1.0 + EDGE)]
        found = []
        for name, part, holds in groups:
            count = len(range(*part.indices(self.interfaces)))
            if count == 0:
                continue
            law = PenaltyCoulomb(holds * self.mu, holds * self.elastic_slip)
            own = operator[3 * part.start : 3 * part.stop]
            points = np.column_stack([np.zeros(count), np.arange(part.start, part.stop, dtype=float), np.ones(count)])
            found.append(
                Interface(f"stack {stack + 1}, {name}", own, np.full(count, self.area), points, law, normal_law)
            )
        return found


def run_shear_test(test: ShearTest, *, steps: int = 40, travel: float = 1.5) -> xr.Dataset:
    """Simulate the test quasi-statically: preload, sticking, then sliding of the platen.

    Parameters
    ----------
    test
        Parameters of the test.
    steps
        Number of equal steps of the actuator.
    travel
        Largest displacement of the actuator, divided by the displacement at which the platen starts to slide.

    Returns
    -------
    xr.Dataset
        Versus `step`: `actuator_displacement` and `platen_displacement`, m; `shear_force` of the machine, N;
        `platen_slip` (plastic slip at the platen), m; `friction_coefficient`, the force divided by 2 F_N (equation
        E.5).
        Attributes: `shear_capacity_n`, `shear_stiffness_n_m`, `shear_modulus_pa`, `pressure_pa`, `interfaces`.

    Raises
    ------
    InputError
        If the steps are so large that interfaces other than those at the platen may slide.
    ConvergenceError
        If a step does not converge.
    """
    if travel / steps >= EDGE:
        raise InputError(
            f"with {steps} steps, interfaces other than those at the platen may slide",
            key="steps",
            remedy=f"use more than {travel / EDGE:.0f}",
        )
    system = test.system()
    slides_at = test.capacity * (1.0 / test.stiffness + 1.0 / test.machine_stiffness)
    way = travel * slides_at * np.arange(steps + 1) / steps
    preload, pull = system.loads["preload"], system.loads["actuator"]
    pressed = solve_load_path(system, [preload])[-1]
    states = [pressed, *solve_load_path(system, [preload + value * pull for value in way[1:]], pressed)]
    platen = np.array([state.displacement[0] for state in states])
    first = [state.jump[1] - state.elastic_slip[1] for state in states]  # axial slot of the first stack's platen
    force = test.machine_stiffness * (way - platen)
    stiffness = stiffness_of(platen, force)
    data = xr.Dataset(
        {
            "actuator_displacement": ("step", way),
            "platen_displacement": ("step", platen),
            "shear_force": ("step", force),
            "platen_slip": ("step", np.abs(np.array(first))),
            "friction_coefficient": ("step", force / (2.0 * test.normal_force)),
        },
        {"step": np.arange(steps + 1)},
    )
    return annotate(data).assign_attrs(
        shear_capacity_n=float(force.max()), shear_stiffness_n_m=stiffness,
        shear_modulus_pa=modulus_of(stiffness, test.area, test.thickness),
        pressure_pa=test.normal_force / test.area, interfaces=test.interfaces,
    )  # fmt: skip


def stiffness_of(displacement: FloatArray, force: FloatArray, *, share: float = ELASTIC) -> float:
    """Slope of a straight line fitted to force versus displacement.

    Parameters
    ----------
    displacement, force
        (n,) m, N.
    share
        Fraction of the largest force up to which the line is fitted.

    Returns
    -------
    Stiffness, N/m
    """
    stop = int(np.argmax(force > share * force.max()))
    return float(np.polyfit(displacement[:stop], force[:stop], 1)[0])


def modulus_of(stiffness: float, area: float, thickness: float) -> float:
    """Shear modulus of two stacks in double shear, G = K t/(2 A), Pa: each stack carries half of the force.

    Parameters
    ----------
    stiffness
        Stiffness K of both stacks, N/m.
    area
        Contact area A, m^2.
    thickness
        Thickness t of one stack, m.

    References
    ----------
    Equations E.2 and E.3 of the thesis use K = G A/t, which is the stiffness of one stack.
    """
    return stiffness * thickness / (2.0 * area)
