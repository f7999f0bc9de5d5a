"""Base shear and base moment: against the sum of all nodal inertia forces, the clamped reaction, and beam theory."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.shared.assembly import build_system
from wroll_fem.case import load_case
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.fem.body import assemble_bodies, shell_section
from wroll_fem.fem.eigen import DEFAULT_SHIFT, solve_pairs
from wroll_fem.fem.shell import ShellModel, radial_director
from wroll_fem.mesh.generate import build_mesh
from wroll_fem.progress import SilentProgress

TINY = CONFIGS / "tiny.yaml"
SMALL = ["coil.layers=2", "mesh.circumferential=8", "mesh.axial=3"]


def nodal_matrices(case, mesh, bodies):
    """Stiffness and mass (6 n_nodes) of every shell before its constraints are eliminated, without the tip mass."""
    found = []
    for index, body in enumerate(bodies):
        part = mesh.part(body.name)
        thickness = case.geometry.mandrel_thickness if index == 0 else case.coil.layer_thickness
        model, section = ShellModel(part.nodes, part.cells, radial_director), shell_section(case, index, thickness)
        found.append((model.stiffness(section), model.mass(section)))
    return found


def rigid(nodes, direction):
    """Nodal values (6 n_nodes, 2) of the unit translation along x or y, and of the unit rotation towards it."""
    shift, turn = np.zeros((len(nodes), 6)), np.zeros((len(nodes), 6))
    shift[:, direction] = 1.0
    turn[:, direction], turn[:, 2] = nodes[:, 2], -nodes[:, direction]
    turn[:, 3 + 1 - direction] = 1.0 if direction == 0 else -1.0
    return np.column_stack([shift.ravel(), turn.ravel()])


@pytest.fixture(scope="module", params=["x", "y"])
def roll(request):
    case = load_case(TINY, [*SMALL, f"excitation.direction={request.param}"])
    mesh = build_mesh(case)
    bodies = assemble_bodies(case, mesh, symmetric=False)
    return case, bodies, nodal_matrices(case, mesh, bodies), build_system(case, bodies), "xy".index(request.param)


def parts(bodies, values):
    return np.split(values, np.cumsum([body.n_dofs for body in bodies])[:-1])


def test_rows_sum_the_inertia_forces_of_all_nodes(roll):
    case, bodies, matrices, system, direction = roll
    acceleration = np.random.default_rng(13).standard_normal(system.n_dofs)
    expected = np.zeros(2)
    for body, (_, mass), part in zip(bodies, matrices, parts(bodies, acceleration), strict=True):
        expected += rigid(body.nodes, direction).T @ (mass @ (body.expand @ part))
    tip_mass, tip = case.mandrel.tip_mass, system.probes["tip"] @ acceleration
    expected += tip_mass * tip * np.array([1.0, case.geometry.length])
    shear, moment = (row @ acceleration for row, _ in system.base_loads.values())
    # clamped nodes do not accelerate relative to the base, but neighbours press on them through the mass matrix
    clamped = coupling(bodies, matrices, parts(bodies, acceleration), direction)
    assert [shear, moment] == pytest.approx(expected - clamped, rel=1e-9)
    assert system.base_loads["base_shear"][1] == pytest.approx(sum(body.mass_total for body in bodies), rel=1e-12)


def coupling(bodies, matrices, accelerations, direction):
    """Share of clamped nodes in the sum of the inertia forces: the mass matrix couples them with their neighbours."""
    total = np.zeros(2)
    for body, (_, mass), part in zip(bodies, matrices, accelerations, strict=True):
        held = np.asarray(abs(body.expand).sum(axis=1)).ravel() == 0.0
        total += rigid(body.nodes, direction)[held].T @ (mass @ (body.expand @ part))[held]
    return total


def test_inertia_forces_of_the_modes_equal_the_clamped_reaction(roll):
    """With sticking layers. The reaction is that of a model without the clamp, moved as the clamped one."""
    _, bodies, _, system, direction = roll
    state = solve_preload(system, steps=3)
    springs = stick_springs(system, state)
    pairs = solve_pairs(sp.csr_matrix(system.with_interface_springs(springs)), system.mass, 6, DEFAULT_SHIFT)
    main = int(np.abs(pairs.vectors.T @ (system.mass @ system.influence)).argmax())
    mode = pairs.vectors[:, main]
    loose = load_case(TINY, [*SMALL, "analysis=modal", "mandrel.base=free", f"excitation.direction={'xy'[direction]}"])
    free = assemble_bodies(loose, build_mesh(loose), symmetric=False)
    stiffness = build_system(loose, free).with_interface_springs(springs)
    moved = np.concatenate([
        spla.spsolve((one.expand.T @ one.expand).tocsc(), one.expand.T @ (body.expand @ part))
        for one, body, part in zip(free, bodies, parts(bodies, mode), strict=True)
    ])  # fmt: skip
    forces = parts(free, stiffness @ moved)[0]
    at, component = free[0].unknown_node, free[0].unknown_component
    held = np.flatnonzero((at >= 0) & (np.abs(free[0].nodes[at, 2]) < 1e-9))
    assert len(held) == 6 * 16
    whole = rigid(free[0].nodes, direction)[6 * at[held] + component[held]]
    loads = [pairs.values[main] * (row @ mode) for row, _ in system.base_loads.values()]
    assert loads == pytest.approx(list(-whole.T @ forces[held]), rel=1e-6)


@pytest.mark.slow
def test_time_histories_and_harmonic_balance_agree():
    """A stuck roll without damping below its resonance: dwell by three methods against the amplitude of harmonic."""
    words = ["contact.friction.mu=50", "excitation.amplitude=0.01", "output.figures=false"]
    dwell = [
        *words, "analysis=dwell", "integrator={scheme: no_damping, steps_per_cycle: 60}",
        "excitation={kind: dwell, amplitude: 0.01, frequency: 60.0, cycles: 12, ramp_cycles: 8, direction: x}",
    ]  # fmt: skip
    found = {}
    for method in ("full", "condensed", "reduced"):
        data = run_analysis(load_case(TINY, [*dwell, f"solver.method={method}"]), progress=SilentProgress())
        last = data.isel(time=data["time"] > data["time"][-1] - 2.0 / 60.0)
        found[method] = [float(np.abs(last[name]).max()) for name in ("base_shear", "base_moment")]
        summary = summarise(data)
        assert summary["base_shear_max_n"] == pytest.approx(float(np.abs(data["base_shear"]).max()))
    assert found["condensed"] == pytest.approx(found["full"], rel=1e-5)
    assert found["reduced"] == pytest.approx(found["full"], rel=1e-3)
    band = "excitation={kind: chirp, amplitude: 0.01, f_start: 55.0, f_end: 65.0, rate_oct_per_min: 2, direction: x}"
    data = run_analysis(load_case(TINY, [*words, "analysis=harmonic", band]), progress=SilentProgress())
    steady = [
        float(np.interp(60.0, data["frequency"], data[f"{name}_amplitude"])) for name in ("base_shear", "base_moment")
    ]
    assert steady == pytest.approx(found["full"], rel=0.01)
    assert summarise(data)["base_moment_max_nm"] == pytest.approx(float(data["base_moment_amplitude"].max()))
