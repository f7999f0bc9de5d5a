"""Short roll: n layers that stand for its wraps (`coil.per_wrap`) against the slipping continuum, f and zeta by level.

    python benchmarks/resolved_layers.py --layers 5 10 20

The layers are shells with friction between them, the continuum is a solid coil whose wraps slide
(`coil.inside: slipping`), with a modulus from its interfaces (`coil.wrap_interfaces`). Web, mandrel, pressure P(r) of
the wound roll, and mesh around and along the axis are the same. An interface of two layers has the elastic slip of all
wrap interfaces between their mid-surfaces; without `--per-wrap` it would have that of one.

The pressure is constant in both (`coil.pressure: fixed`): normal contact acts as springs of the radial modulus. Both
follow the quasi-static path of their first bending mode and the response at levels of the base acceleration.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
import scipy.sparse as sp
from scipy.constants import g as GRAVITY
from threadpoolctl import threadpool_limits

from wroll_fem.analyses.followed_mode import main_mode
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.analyses.slip_path import followed_path
from wroll_fem.analyses.slip_results import base_acceleration, displacements
from wroll_fem.analyses.slip_structure import slipping_structure
from wroll_fem.case import build_case
from wroll_fem.case.structural import OnRoll
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.system.system import System
from wroll_fem.progress import SilentProgress
from wroll_fem.typing import FloatArray

WRAPS, WRAP, SLIP, MU = 500, 1e-5, 1e-7, 0.3  # -, m, m, -
E, NU, E_R = 4e9, 0.3, 4e8  # Pa, -, Pa
SHEAR = E / (2.0 * (1.0 + NU))
ZETA, LEVELS = 0.02, (10.0, 20.0, 40.0, 80.0)  # -, g
TOLERANCE = 1e-3


class Response(NamedTuple):
    """Frequency without slip (Hz), and frequency (Hz), damping by friction, slip work (J) and tip (m) at each level."""

    stuck: float
    frequency: FloatArray
    damping: FloatArray
    work: FloatArray
    tip: FloatArray
    points: int


def roll(coil: dict[str, Any], mesh: dict[str, Any], **sections: Any) -> OnRoll:
    """Case of the short roll with a coil."""
    data = {
        "geometry": {"length": 0.12, "mandrel_outer_diameter": 0.040, "mandrel_thickness": 1e-3},
        "mandrel": {
            "material": {"E": 10e9, "nu": 0.33, "rho": 1500}, "tip": "rigid", "base": "clamped", "tip_mass": 0.2,
        },
        "coil": {"total_thickness": WRAPS * WRAP, "base": "free", **coil},
        "winding": {
            "tension_stress": 10e6, "wraps": WRAPS, "wrap_thickness": WRAP, "mu": MU,
            "web": {"E_theta": E, "nu_theta": NU, "radial_modulus": {"law": "pfeiffer", "K1": 1e3, "K2": 40}},
        },
        "mesh": mesh,
        **sections,
    }  # fmt: skip
    return build_case(data).expect(OnRoll)


def continuum(mesh: dict[str, Any], radial: int, grading: float = 300.0) -> tuple[System, ContactState]:
    """Solid coil whose wraps slide; ``radial`` elements through its thickness, the outermost ``grading`` as thick."""
    # shells have the shear factor 5/6, so the web between the wraps of the solid has it too
    material = {
        "kind": "cylindrical_orthotropic", "E_theta": E, "E_z": E, "E_r": E_R, "nu_theta_z": NU, "nu_theta_r": 0.0,
        "nu_z_r": 0.0, "G_z_theta": SHEAR, "G_r_theta": 5.0 / 6.0 * SHEAR, "rho": 1400,
    }  # fmt: skip
    case = roll(
        {"model": "solid", "inside": "slipping", "material": material, "wrap_interfaces": {"elastic_slip": SLIP}},
        {**mesh, "radial": radial, "radial_grading": grading}, analysis="slip_damping", damping_ratio=ZETA,
        excitation={"kind": "sine", "frequency": "resonance", "amplitude_g": list(LEVELS)},
    )  # fmt: skip
    _, _, system, start = slipping_structure(case)
    return system, start


def layered(layers: int, mesh: dict[str, Any], *, per_wrap: bool = True) -> tuple[System, ContactState]:
    """Layers with friction at the constant pressure of the wound roll, and normal springs of the radial modulus."""
    case = roll(
        {"model": "layers", "layers": layers, "per_wrap": per_wrap, "material": {"E": E, "nu": NU, "rho": 1400}},
        mesh, analysis="backbone", backbone={"tip_smallest": 1e-6, "tip_largest": 1e-4},
        contact={"friction": {"mu": MU, "elastic_slip": SLIP}}, preload={"kind": "winding_stress"},
    )  # fmt: skip
    system = build_system(case, build_bodies(case, symmetric=True))
    assert system.initial_pressure is not None
    stiffness, interfaces = system.stiffness, []
    for number, interface in enumerate(system.interfaces):
        # between two mid-surfaces the web has the radial stiffness E_r / t; the mandrel is half a layer away
        spring = E_R / case.coil.layer_thickness * (1.0 if number else 2.0)
        normal = interface.operator[::3]
        stiffness = stiffness + normal.T @ sp.diags(spring * interface.areas) @ normal
        tangential = sp.diags(np.tile([0.0, 1.0, 1.0], interface.n_points)) @ interface.operator
        interfaces.append(replace(interface, operator=tangential.tocsr()))
    pressure = system.initial_pressure
    system = replace(system, stiffness=stiffness.tocsr(), interfaces=tuple(interfaces), loads={}, initial_pressure=None)
    return system, ContactState.pressed(system, pressure)


def first_mode(system: System, start: ContactState) -> tuple[LoadPath, FloatArray, float]:
    """Path from rest, first mode of the sticking structure, and its frequency, Hz."""
    path = LoadPath(system, start, tolerance=TOLERANCE)
    mode = main_mode(system, path)
    return path, mode, float(np.sqrt(mode @ (path.stiffness @ mode))) / (2.0 * np.pi)


def response(system: System, start: ContactState, levels: Sequence[float] = LEVELS) -> Response:
    """Follow the first mode up to the highest level, g."""
    path, mode, stuck = first_mode(system, start)
    highest = 1.02 * GRAVITY * levels[-1]
    found = followed_path(
        path, mode, lambda done: bool(base_acceleration(path, done, mode, ZETA)[-1] > highest), SilentProgress()
    )
    base = base_acceleration(path, found, mode, ZETA) / GRAVITY
    tip = np.abs(displacements(path, found) @ system.probes["tip"])

    def at(values: FloatArray) -> FloatArray:
        return np.interp(np.log(levels), np.log(base), values, left=np.nan, right=np.nan)

    logs = np.exp(at(np.log(np.maximum(found.dissipation, 1e-30))))
    return Response(stuck, at(found.frequency / (2.0 * np.pi)), at(found.damping), logs, at(tip), system.n_points)


def table(limit: Response, found: dict[int, Response]) -> list[str]:
    """Rows of a table: differences from the continuum in per cent, the largest over the levels."""
    rows = ["| layers | f without slip | f | damping by friction | slip work | tip |", "|---|---|---|---|---|---|"]
    for n, one in found.items():
        changes = [100.0 * (np.atleast_1d(a) / b - 1.0) for a, b in zip(one[:5], limit[:5], strict=True)]
        largest = [float(change[np.argmax(np.abs(change))]) for change in changes]
        rows.append(f"| {n} | " + " | ".join(f"{value:+.2f} %" for value in largest) + " |")
    return rows


def stuck_frequencies(
    mesh: dict[str, Any], radial: int, grading: float, layers: Sequence[int], *, per_wrap: bool
) -> None:
    """Print the frequency without slip of the continuum, and of the layers relative to it."""
    with threadpool_limits(1):
        limit = first_mode(*continuum(mesh, radial, grading))[2]
        print(f"continuum: {limit:.3f} Hz", flush=True)
        for n in layers:
            hertz = first_mode(*layered(n, mesh, per_wrap=per_wrap))[2]
            seconds = time.process_time()
            print(f"{n} layers: {hertz:.3f} Hz, {100.0 * (hertz / limit - 1.0):+.3f} %, {seconds:.0f} s", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--layers", type=int, nargs="*", default=[5, 10, 20])
    parser.add_argument("--around", type=int, default=16, help="elements around the roll")
    parser.add_argument("--along", type=int, default=8, help="elements along the axis")
    parser.add_argument("--radial", type=int, default=8, help="elements of the continuum through its thickness")
    parser.add_argument("--radial-grading", type=float, default=300.0, help="ratio of their thicknesses")
    parser.add_argument("--levels", type=float, nargs="+", default=LEVELS, help="levels, g")
    parser.add_argument("--of-one", action="store_true", help="interfaces with the elastic slip of one wrap interface")
    parser.add_argument("--stuck", action="store_true", help="frequency without slip alone")
    given = parser.parse_args()
    mesh = {"circumferential": given.around, "axial": given.along, "grading": 10.0}
    if given.stuck:
        stuck_frequencies(mesh, given.radial, given.radial_grading, given.layers, per_wrap=not given.of_one)
        return
    with threadpool_limits(1):
        limit = response(*continuum(mesh, given.radial, given.radial_grading), given.levels)
        print(f"continuum: {limit.stuck:.2f} Hz without slip, {limit.points} points, {time.process_time():.0f} s")
        print("Hz", np.round(limit.frequency, 2), "damping %", np.round(100.0 * limit.damping, 2))
        found = {n: response(*layered(n, mesh, per_wrap=not given.of_one), given.levels) for n in given.layers}
    print(*table(limit, found), f"{time.process_time():.0f} s of CPU", sep="\n")


if __name__ == "__main__":
    main()
