"""Clamped tube with a rigid ring and a tip mass: static states, bending frequency and buckling loads."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.tube import Tube
from wroll_fem.fem.eigen import solve_modes
from wroll_fem.fem.fourier_shell.geometric import GeometricStiffness
from wroll_fem.fem.fourier_shell.kinematics import COMPONENTS
from wroll_fem.fem.fourier_shell.model import FourierShellModel
from wroll_fem.fem.prestress.buckling import load_factors
from wroll_fem.numerics.linear import factorise
from wroll_fem.typing import FloatArray

END_SHARE = 0.3
"""Share of the cells in each of the two end zones."""
PER_DECAY = 0.4
"""Largest cell of a buckling model divided by sqrt(R t). A wave of the local buckles of a thin tube under axial
compression, 3.5 sqrt(R t), then has nine cells, and the factor is exact to about 0.1 %."""
MOST_CELLS, MOST_WAVES = 600, 80
"""Largest numbers of cells and of circumferential waves of a buckling model."""
_RISING = 4
"""Number of consecutive wave numbers with a rising buckling pressure after which the search ends."""
BENDING_SHIFT = 0.0


@dataclass(frozen=True)
class Buckling:
    """Lowest buckling load of a tube.

    Attributes
    ----------
    factor
        Buckling load divided by the given load; inf if the load destabilises no motion.
    waves
        Number of circumferential waves; with coupled wave numbers the one with the largest part of the strain energy;
        None without buckling.
    """

    factor: float
    waves: int | None


def end_zone(tube: Tube) -> float:
    """Distance from a clamped edge at which axisymmetric edge bending has decayed to 1 %, ln(100) / beta, m."""
    return math.log(100.0) / tube.edge_decay


def graded_heights(tube: Tube, cells: int) -> FloatArray:
    """(cells + 1,) borders of cells, m: END_SHARE of them in the zone of edge bending at each end."""
    zone = min(end_zone(tube), tube.length / 3.0)
    ends = max(int(END_SHARE * cells), 1)
    zones = ((0.0, zone, ends), (zone, tube.length - zone, cells - 2 * ends), (tube.length - zone, tube.length, ends))
    parts = [np.linspace(start, stop, count + 1)[:-1] for start, stop, count in zones]
    return np.append(np.concatenate(parts), tube.length)


def buckling_size(tube: Tube, cells: int) -> tuple[int, int, bool]:
    """Number of cells (at least `cells`), highest wave number of a buckling model, and whether it resolves the buckles.

    Uniform axial compression buckles thin tubes with at most 0.9 sqrt(R / t) waves (Koiter's circle). Bending confines
    the buckles to one side, which needs higher wave numbers: 2.5 sqrt(R / t) + 8 are used.
    """
    wanted = max(math.ceil(tube.length / (PER_DECAY * math.sqrt(tube.radius * tube.thickness))), cells)
    waves = math.ceil(2.5 * math.sqrt(tube.radius / tube.thickness)) + 8
    return min(wanted, MOST_CELLS), min(waves, MOST_WAVES), wanted <= MOST_CELLS and waves <= MOST_WAVES


class ClampedMandrel:
    """Mandrel clamped at its base, with a rigid ring and a mass at its tip.

    Parameters
    ----------
    model
        Elements; several mandrels one after another may use the same.
    tube
        Geometry and material.
    heights
        (cells + 1,) borders of the cells, m.
    tip_mass
        Mass in the plane of the tip ring, kg.
    """

    def __init__(self, model: FourierShellModel, tube: Tube, heights: FloatArray, tip_mass: float = 0.0):
        model.use(tube, heights)
        self.model, self.tube, self.tip_mass = model, tube, tip_mass

    def _solve(self, wave_number: int, load: FloatArray) -> FloatArray:
        """Nodal displacements of a load on the unknowns."""
        expand = self.model.cantilever(wave_number)
        stiffness = (expand.T @ self.model.stiffness(wave_number) @ expand).tocsr()
        return np.asarray(expand @ factorise(stiffness).solve(load))

    def under_pressure(self) -> FloatArray:
        """(5 n_nodes,) displacements of wave number 0 under an inward pressure of 1 Pa on the outer surface."""
        return self._solve(0, self.model.cantilever(0).T @ self.model.pressure_load())

    def under_acceleration(self) -> FloatArray:
        """(5 n_nodes,) displacements of wave number 1 under an inertial load of 1 m/s^2 along theta = 0."""
        expand = self.model.cantilever(1)
        load = expand.T @ (self.model.mass(1) @ self.model.translation())
        load[-2] += self.tip_mass
        return self._solve(1, load)

    def tip_stiffness(self) -> float:
        """Transverse force on the tip ring per displacement, N/m, with the shear deformation of the tube."""
        load = np.zeros(self.model.cantilever(1).shape[1])
        load[-2] = 1.0
        return 1.0 / float(self._solve(1, load)[-COMPONENTS])

    def bending_frequency(self, tip_inertia: float = 0.0) -> float:
        """First bending frequency with tip mass and non-structural mass, Hz.

        Parameters
        ----------
        tip_inertia
            Moment of inertia of the tip mass about a diameter of the ring, kg m^2.
        """
        expand = self.model.cantilever(1)
        stiffness = expand.T @ self.model.stiffness(1) @ expand
        added = np.zeros(expand.shape[1])
        added[-2:] = self.tip_mass, tip_inertia
        mass = expand.T @ self.model.mass(1) @ expand + sp.diags(added)
        return float(solve_modes(stiffness.tocsr(), mass.tocsr(), 1, BENDING_SHIFT)[0][0])

    def pressure_buckling(self, highest: int) -> Buckling:
        """Lowest buckling load of an external pressure that follows its surface; the factor is in Pa.

        Parameters
        ----------
        highest
            Highest wave number of the search, which starts at 2 and ends when the pressure keeps rising.
        """
        geometric, state = GeometricStiffness(self.model), self.under_pressure()
        best, rising = Buckling(math.inf, None), 0
        for n in range(2, highest + 1):
            expand = self.model.cantilever(n)
            weakening = geometric.stress_stiffness(state, 0, n, n) + geometric.pressure_stiffness(n)
            stiffness = (expand.T @ self.model.stiffness(n) @ expand).tocsr()
            found = load_factors(stiffness, (expand.T @ weakening @ expand).tocsr(), 1)[0]
            if len(found) and found[0] < best.factor:
                best, rising = Buckling(float(found[0]), n), 0
            else:
                rising += 1
            if rising >= _RISING and best.waves is not None:
                break
        return best

    def combined_buckling(self, pressure: float, acceleration: float, highest: int) -> Buckling:
        """Lowest factor on a pressure (Pa) and an inertial load (m/s^2) together, with coupled wave numbers.

        The stresses of the inertial load vary with cos theta; they couple each wave number with its neighbours. Wave
        numbers 0 to `highest` are kept. Motions are symmetric about the plane of the load.
        """
        geometric = GeometricStiffness(self.model)
        static = {0: pressure * self.under_pressure(), 1: acceleration * self.under_acceleration()}
        waves = range(highest + 1)
        expand = [self.model.cantilever(n) for n in waves]
        symmetric = self.model.cantilever(0)  # without torsion, which is antisymmetric
        keep = np.flatnonzero(np.abs(symmetric).T @ np.tile([1.0, 0.0, 1.0, 0.0, 1.0], self.model.n_nodes))
        expand[0] = symmetric[:, keep]
        stiffness = [(e.T @ self.model.stiffness(n) @ e).tocsr() for n, e in enumerate(expand)]
        blocks: list[list[sp.csr_matrix | None]] = [[None] * len(waves) for _ in waves]
        for n in waves:
            weakening = sp.csr_matrix((expand[n].shape[0],) * 2)
            if pressure:
                weakening = geometric.stress_stiffness(static[0], 0, n, n)
                weakening = weakening + pressure * geometric.pressure_stiffness(n)
            blocks[n][n] = expand[n].T @ weakening @ expand[n]
            if acceleration and n < highest:
                beside = expand[n].T @ geometric.stress_stiffness(static[1], 1, n, n + 1) @ expand[n + 1]
                blocks[n][n + 1], blocks[n + 1][n] = beside, beside.T
        factors, shapes = load_factors(sp.block_diag(stiffness, format="csr"), sp.bmat(blocks, format="csr"), 1)
        if not len(factors):
            return Buckling(math.inf, None)
        parts = np.split(shapes[:, 0], np.cumsum([k.shape[0] for k in stiffness])[:-1])
        energies = [float(part @ (k @ part)) for part, k in zip(parts, stiffness, strict=True)]
        return Buckling(float(factors[0]), int(np.argmax(energies)))
