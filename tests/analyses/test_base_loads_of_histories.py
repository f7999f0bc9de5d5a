"""Base shear, base moment and slip path of every time history; loads of a sliding roll against its reaction."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.shared.assembly import build_system
from wroll_fem.case import load_case
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.time_stepping.full import FullStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.simulate import simulate
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.fem.body import assemble_bodies, shell_section
from wroll_fem.fem.shell import ShellModel, radial_director
from wroll_fem.mesh.generate import build_mesh
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.motions import base_motion

TINY = CONFIGS / "tiny.yaml"
MOTIONS = {
    "sweep": "{kind: chirp, amplitude: 30, f_start: 100, f_end: 300, rate_oct_per_min: 600}",
    "dwell": "{kind: dwell, amplitude: 30, frequency: 150, cycles: 6, ramp_cycles: 2}",
    "random": "{kind: random, psd: {frequency: [50, 300], g2_per_hz: 0.05}, duration: 0.61}",
    "shock": "{kind: half_sine, amplitude_g: 20, duration: 0.003, decay: 0.08}",
}


@pytest.mark.parametrize("analysis", MOTIONS)
def test_every_history_has_base_loads_and_slip_paths(analysis: str) -> None:
    words = [f"analysis={analysis}", f"excitation={MOTIONS[analysis]}", "output.figures=false", "solver.method=reduced"]
    case = load_case(TINY, [*words, "mesh={circumferential: 8, axial: 3, grading: 1}"])
    found = run_analysis(case, progress=SilentProgress())
    summary = summarise(found)
    for name, unit in (("base_shear", "n"), ("base_moment", "nm")):
        assert found[name].dims == ("time",)
        assert summary[f"{name}_max_{unit}"] == float(np.abs(found[name].values).max()) > 0.0
        assert (f"{name}_rms_{unit}" in summary) == (analysis == "random")
    path = found["cumulative_slip"]
    assert path.dims == ("interface", "point")
    assert summary["max_accumulated_slip_m"] == float(path.max()) > 0.0
    assert float(path.max()) > 3.0 * case.friction.elastic_slip
    moved = found["max_slip"].values - case.friction.elastic_slip
    assert (2.0 * path.values + 1e-12 >= moved).all()  # a path is no shorter than the distance


def rigid(nodes: np.ndarray) -> np.ndarray:
    """Nodal values (6 n_nodes, 2) of the unit translation along x, and of the unit rotation towards it."""
    shift, turn = np.zeros((2, len(nodes), 6))
    shift[:, 0] = 1.0
    turn[:, 0], turn[:, 2], turn[:, 4] = nodes[:, 2], -nodes[:, 0], 1.0
    return np.column_stack([shift.ravel(), turn.ravel()])


@pytest.mark.slow
def test_loads_of_a_sliding_roll_are_its_clamped_reaction() -> None:
    """Newmark's rule balances all forces at each step; the reaction is that of the same roll without its clamp."""
    words = ["excitation={kind: half_sine, amplitude_g: 100, duration: 0.0015, decay: 0.0001}", "analysis=shock"]
    case = load_case(TINY, words)
    bodies = assemble_bodies(case, build_mesh(case), symmetric=False)
    system = build_system(case, bodies)
    state = solve_preload(system, steps=3)
    loose = load_case(TINY, [*words, "analysis=modal", "mandrel.base=free"])
    free = assemble_bodies(loose, build_mesh(loose), symmetric=False)
    unclamped = build_system(loose, free)
    scheme, dt = Scheme.hht(0.0), 1.0e-4
    stepper = FullStepper(system, state, scheme, NewtonOptions(1e-10))
    motion = base_motion(case.excitation)
    found = simulate(system, state, motion, dt=dt, scheme=scheme, stepper=stepper)
    assert float(found["slipping_fraction"].max()) > 0.05
    at, component = free[0].unknown_node, free[0].unknown_component
    held = np.flatnonzero((at >= 0) & (np.abs(free[0].nodes[at, 2]) < 1e-9))
    whole = rigid(free[0].nodes)
    places = 6 * at[held] + component[held]
    mandrel = ShellModel(
        *(getattr(build_mesh(case).part(bodies[0].name), n) for n in ("nodes", "cells")), radial_director
    )
    mass = mandrel.mass(shell_section(case, 0, case.geometry.mandrel_thickness))
    carried = whole[places].T @ (mass @ whole[:, 0])[places]
    motions = np.split(stepper.displacement(), np.cumsum([body.n_dofs for body in bodies])[:-1])
    moved = np.concatenate([
        spla.spsolve(sp.csc_matrix(one.expand.T @ one.expand), one.expand.T @ (body.expand @ part))
        for one, body, part in zip(free, bodies, motions, strict=True)
    ])  # fmt: skip
    traction = stepper.state.contact.traction - state.traction
    forces = unclamped.stiffness @ moved + unclamped.jump.T @ (unclamped.weights * traction)
    reaction = whole[places].T @ forces[: free[0].n_dofs][held]
    ground = float(found["base_acceleration"].values[-1])
    loads = [float(found[name].values[-1]) for name in ("base_shear", "base_moment")]
    expected = -(reaction + carried * ground)
    assert abs(expected[0]) > 1.0
    assert loads == pytest.approx(expected.tolist(), rel=1e-6)
