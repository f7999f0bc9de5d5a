"""Motions of the two-mass model on which the claims of chapter 5 are judged, computed once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np
import xarray as xr

from reproduction.evidence import Evidence
from reproduction.explicit import ZETA
from wroll_fem.plotting.study import StudyCase
from wroll_fem.two_dof import PeriodicSolver, PreloadedTwoMasses, TwoMasses, integrate_to_steady_state, response_map
from wroll_fem.two_dof.model import RELATIVE_VELOCITY
from wroll_fem.two_dof.time import dwell
from wroll_fem.typing import FloatArray

CASE, SPACE = "two_dof", "two_dof_design_space"
FE_STUDY = "layer_modulus"
ARRANGEMENTS = {
    "(a) both on the base": "both_on_base",
    "(b) secondary on a wall at rest": "secondary_isolated",
    "(c) secondary on the primary": "secondary_on_primary",
}
"""Description -> arrangement of Fig. 5.1."""
SCALES = (1.0, 2.0, 5.0, 10.0)
"""Scales s of the regularised sign function in appendix C."""
STIFFNESSES = (0.575, 0.8, 0.85, 1.15, 1.6, 2.3, 4.6)
"""Values of k_2 of claim C88, N/m: Table 5.2 has 1.15; at 0.85 both masses alone have the same resonance."""
CONSTANT = "[1.5, 2, 3, 5, 20]"
"""Capacities with constant masses and stiffness, N."""
Point = tuple[float, float]


def rounded(values: FloatArray) -> list[float]:
    """Values rounded to three decimals, as in a case file."""
    return [float(v) for v in np.round(values, 3)]


def series(evidence: Evidence) -> xr.Dataset:
    """Curves for Table 5.2 at the eight capacities."""
    return evidence.result(CASE)


def capacities(evidence: Evidence) -> list[float]:
    """The eight capacities, N."""
    return [float(c) for c in series(evidence)["friction_capacity"]]


def finer(evidence: Evidence) -> xr.Dataset:
    """The same curves with half the frequency step."""
    return evidence.result(CASE, f"two_dof.omega.points={2 * series(evidence).sizes['omega'] - 1}")


def fine(evidence: Evidence) -> xr.Dataset:
    """Curves for Table 5.2 at many capacities from 1 to 100 N."""
    count, points = (17, 60) if evidence.fast else (41, 200)
    forces = rounded(np.geomspace(1.0, 100.0, count))
    return evidence.result(CASE, f"two_dof.friction_capacity={forces}", f"two_dof.omega.points={points}")


def arrangements(evidence: Evidence) -> dict[str, xr.Dataset]:
    """Curves for the arrangements of Fig. 5.1 at a low, two medium and a high capacity."""
    force = "two_dof.friction_capacity=[2, 5, 20, 100]"
    found = evidence.results([(CASE, force, f"two_dof.arrangement={name}") for name in ARRANGEMENTS.values()])
    return dict(zip(ARRANGEMENTS, found, strict=True))


def with_and_without_preload(evidence: Evidence) -> list[xr.Dataset]:
    """Curves with equations 5.6 and 5.7, and with masses and stiffness independent of the capacity."""
    force = f"two_dof.friction_capacity={CONSTANT}"
    return evidence.results([(CASE, force), (CASE, force, "two_dof.preload_dependent=false")])


def scales(evidence: Evidence) -> dict[float, xr.Dataset]:
    """Curves for Table 5.2 with larger s; at F_c = 1 and s = 10 the peak needs more harmonics than are available."""
    force = f"two_dof.friction_capacity={capacities(evidence)[1:]}"
    cases = [(CASE, force, f"two_dof.smoothing={s}", "two_dof.omega.points=80") for s in SCALES]
    return dict(zip(SCALES, evidence.results(cases), strict=True))


def space(evidence: Evidence) -> xr.Dataset:
    """Map of the design space."""
    return evidence.result(SPACE)


def settled(evidence: Evidence) -> xr.Dataset:
    """Transmissibility by harmonic balance and time integration over (friction_capacity, omega); number of periods."""
    omegas = [0.4, 0.6, 0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2, 1.5, 2.0][:: 3 if evidence.fast else 1]
    names = ("periodic", "in_time", "periods")
    return _over_motions(evidence, "two_dof_settled", _settled, capacities(evidence), omegas, names)


def dwelt(evidence: Evidence) -> xr.Dataset:
    """Transmissibility of the periodic motion, and of a run over six time constants as in the thesis."""
    omegas = rounded(np.linspace(0.4, 2.0, 9 if evidence.fast else 41))
    return _over_motions(
        evidence, "two_dof_dwelt", _dwelt, capacities(evidence), omegas, ("periodic", "six_time_constants")
    )


def over_stiffness(evidence: Evidence) -> dict[float, float]:
    """k_2 -> largest damping over the capacities, with m_2 of Table 5.2."""
    count, points = (9, 80) if evidence.fast else (25, 160)
    forces = [float(c) for c in np.geomspace(1.2, 30.0, count)]

    def compute() -> xr.Dataset:
        tasks = [(k2, force, points) for k2, force in product(STIFFNESSES, forces)]
        zeta = np.reshape(evidence.map(_damping, tasks, what="stiffness of the secondary"), (len(STIFFNESSES), count))
        return xr.Dataset({"zeta": (("k2", "friction_capacity"), zeta)}, {"k2": list(STIFFNESSES)})

    data = evidence.kept("two_dof_stiffness", compute, k2=STIFFNESSES, capacities=forces, points=points)
    return {float(k2): float(v) for k2, v in zip(data["k2"], data["zeta"].max("friction_capacity"), strict=True)}


def largest_damping(members: Sequence[StudyCase], *keys: str) -> dict[tuple[float, ...], float]:
    """Values of given keys -> largest half-power damping of the cases with these values."""
    found: dict[tuple[float, ...], float] = {}
    for member in members:
        zeta, values = float(member.data.attrs["zeta"]), tuple(float(member.values[key]) for key in keys)
        if np.isfinite(zeta):
            found[values] = max(zeta, found.get(values, 0.0))
    return dict(sorted(found.items()))


def over_modulus(evidence: Evidence) -> dict[float, float]:
    """Layer modulus (Pa) -> largest damping of the finite-element model over the preloads."""
    found = largest_damping(evidence.study(FE_STUDY), "coil.material.E")
    return {modulus: zeta for (modulus,), zeta in found.items()}


def _over_motions(
    evidence: Evidence,
    name: str,
    work: Callable[[Point], tuple[float, ...]],
    forces: Sequence[float],
    omegas: Sequence[float],
    variables: Sequence[str],
) -> xr.Dataset:
    """Stored results of ``work`` at all (friction_capacity, omega); one variable for each returned value."""
    dims = ("friction_capacity", "omega")

    def compute() -> xr.Dataset:
        found = np.array(evidence.map(work, list(product(forces, omegas)), what=name.replace("_", " ")))
        values = found.reshape(len(forces), len(omegas), len(variables))
        data = {variable: (dims, values[..., k]) for k, variable in enumerate(variables)}
        return xr.Dataset(data, {dims[0]: list(forces), dims[1]: list(omegas)})

    return evidence.kept(name, compute, capacities=list(forces), omegas=list(omegas))


def _settled(point: Point) -> tuple[float, float, float]:
    pressed = TwoMasses().preloaded(point[0])
    found = integrate_to_steady_state(pressed, point[1])
    return PeriodicSolver(pressed).motion(point[1]).transmissibility, found.transmissibility, float(found.periods)


def _dwelt(point: Point) -> tuple[float, float]:
    pressed = TwoMasses().preloaded(point[0])
    run = dwell(pressed, point[1], 6.0 / (ZETA * point[1]))
    return PeriodicSolver(pressed).motion(point[1]).transmissibility, run


def creeping_dwell(pressed: PreloadedTwoMasses, omega: float, duration: float) -> float:
    """Closed form of a run from rest with stuck masses: largest abs(x_1) of the last period over the steady one.

    Below its limit the regularised friction is a dashpot F_c s/2 between the masses, and the equations are linear. The
    motion is the steady one minus the free vibration that starts it from rest.

    Parameters
    ----------
    pressed
        Parameters of the model, both masses on the base.
    omega
        Frequency of the base motion, rad/s.
    duration
        Duration of the run, s.
    """
    between = 0.5 * pressed.capacity * pressed.smoothing * np.outer(RELATIVE_VELOCITY, RELATIVE_VELOCITY)
    M, C, K = pressed.mass, pressed.damping + between, pressed.stiffness
    # relative to the base, u = x - (1, 1) y, with y = Y_0 sin(omega t): M u'' + C u' + K u = M (1, 1) omega^2 y
    load = M @ np.ones(2) * omega**2 * pressed.base_amplitude
    steady = np.linalg.solve(K - omega**2 * M + 1j * omega * C, load)  # u = Im(steady e^{i omega t})
    state = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    rates, modes = np.linalg.eig(state)
    velocity = -omega * pressed.base_amplitude * np.ones(2)  # x starts at rest, so u' starts at -y'
    start = np.concatenate([-steady.imag, velocity - omega * steady.real])
    shares = np.linalg.solve(modes, start.astype(complex))
    t = duration - 2.0 * np.pi / omega * np.linspace(0.0, 1.0, 4001)
    base = pressed.base_amplitude * np.sin(omega * t)
    repeated = (steady[0] * np.exp(1j * omega * t)).imag + base
    free = (np.exp(np.outer(t, rates)) @ (modes[0] * shares)).real
    return float(np.abs(repeated + free).max() / np.abs(repeated).max())


def _damping(task: tuple[float, float, int]) -> float:
    k2, force, points = task
    return response_map(TwoMasses(k2=k2), [force], np.linspace(0.4, 3.0, points), workers=1)[0].half_power.zeta
