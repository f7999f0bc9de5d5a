"""Quasi-static paths: against closed forms, the equilibrium of the whole structure, and nonlinear modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from support.paths import CONFIGS
from support.periodic import small_roll

import wroll_fem as wf
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.case import load_case
from wroll_fem.contact.kernels import SLIP
from wroll_fem.dynamics.joints.assembly import with_joints
from wroll_fem.dynamics.joints.friction import Jenkins
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.full import solve_static
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import modal_path
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import ConvergenceError
from wroll_fem.progress import SilentProgress
from wroll_fem.typing import FloatArray

MASS, STIFFNESS, STICK, LIMIT = 2.0, 1e4, 5e3, 3.0


SHAPE = np.array([MASS**-0.5])


def jenkins() -> LoadPath:
    matrices = (sp.csr_matrix([[STIFFNESS]]), sp.csr_matrix([[MASS]]), np.ones(1))
    plain = System(*matrices, probes={"tip": np.ones(1)})
    return LoadPath(*with_joints(plain, [Jenkins(at=0, stiffness=STICK, limit=LIMIT)]), tolerance=1e-9)


def test_mass_with_a_jenkins_element_has_the_closed_form_of_its_loop() -> None:
    found = modal_path(jenkins(), SHAPE, np.geomspace(0.5, 20.0, 80))
    u, slips = found.amplitude / np.sqrt(MASS), LIMIT / STICK
    np.testing.assert_allclose(found.force * np.sqrt(MASS), STIFFNESS * u + np.minimum(STICK * u, LIMIT), rtol=1e-12)
    exact = 4.0 * LIMIT * np.maximum(u - slips, 0.0)
    np.testing.assert_allclose(found.dissipation, exact, atol=1e-12 * exact.max())
    np.testing.assert_allclose(found.loop_area, exact, atol=1e-5 * exact.max())
    # describing function of the element
    angle = np.arccos(np.clip(1.0 - 2.0 * slips / u, -1.0, 1.0))
    spring = np.where(u > slips, STICK / np.pi * (angle - 0.5 * np.sin(2.0 * angle)), STICK)
    np.testing.assert_allclose(found.frequency, np.sqrt((STIFFNESS + spring) / MASS), rtol=3e-4)
    np.testing.assert_allclose(
        found.damping, exact / (2.0 * np.pi * (found.frequency * found.amplitude) ** 2), atol=1e-12
    )


def test_levels_can_be_added_to_a_path() -> None:
    levels, path = np.geomspace(0.5, 20.0, 9), jenkins()
    whole = modal_path(jenkins(), SHAPE, levels)
    found = modal_path(path, SHAPE, levels[:4])
    found = found.joined(modal_path(path, SHAPE, levels[4:], after=found))
    for name in ("amplitude", "force", "dissipation", "frequency"):
        np.testing.assert_allclose(getattr(found, name), getattr(whole, name), rtol=1e-12)


def shaken_down(system: System, state: ContactState) -> tuple[System, ContactState]:
    """System, and its state at rest without tangential traction, as after cycles of large amplitude."""
    traction = state.traction.copy()
    traction[: 2 * len(state.status)] = 0.0
    return system, replace(state, traction=traction, elastic_slip=np.zeros_like(state.elastic_slip))


def mode_of(path: LoadPath) -> FloatArray:
    system = path.system
    mode = path.stuck(system.mass @ system.influence)
    for _ in range(30):
        mode = path.stuck(system.mass @ mode)
        mode /= np.sqrt(mode @ (system.mass @ mode))
    return mode


def test_a_state_of_the_path_is_the_equilibrium_of_the_whole_structure() -> None:
    system, preload, _ = small_roll(8, 3)
    load = 200.0 * (system.mass @ system.influence)
    path = LoadPath(system, preload, tolerance=1e-7)
    for share in (0.5, 1.0):
        found = path.to(share * load)
    assert np.mean(found.status == SLIP) > 0.2
    # the same steps by Newton's method with a factorisation of the whole structure per iteration
    at_rest = system.stiffness @ preload.displacement + system.jump.T @ (system.weights * preload.traction)
    state = preload
    for share in (0.5, 1.0):
        state = solve_static(system, at_rest + share * load, state)
    moved, exact = found.displacement - preload.displacement, state.displacement - preload.displacement
    assert np.abs(moved - exact).max() < 1e-5 * np.abs(exact).max()
    assert len(path.vectors) < 0.5 * system.n_dofs


@pytest.mark.slow
def test_frequency_and_damping_of_a_roll_are_those_of_its_nonlinear_mode() -> None:
    """Quasi-static path against harmonic balance, up to the amplitude of the largest damping."""
    mesh = "mesh={circumferential: 12, axial: 8, grading: 20}"
    case = load_case(CONFIGS / "lab_backbone.yaml", [mesh, "backbone.tip_largest=1.1e-3"])
    exact = wf.run(case, progress=False)
    path = LoadPath(*shaken_down(*prepare(case, SilentProgress())))
    mode = mode_of(path)
    found = modal_path(path, mode, np.geomspace(1.0, 12.0, 24))
    tip = abs(float(path.system.probes["tip"] @ mode)) * found.amplitude
    hertz, zeta = (
        np.interp(tip, exact["tip_amplitude"], exact[name]) for name in ("resonance_frequency", "modal_damping")
    )
    slips = found.damping > 0.01
    assert slips.sum() > 12
    np.testing.assert_allclose(found.frequency[slips] / (2.0 * np.pi), hertz[slips], rtol=1e-3)
    np.testing.assert_allclose(found.damping[slips], zeta[slips], rtol=0.02)
    far = found.force > 4.0 * found.force[0]
    np.testing.assert_allclose(found.loop_area[far], found.dissipation[far], rtol=0.01)


def test_a_load_without_equilibrium_is_named() -> None:
    system, preload, _ = small_roll(8, 3)
    path = LoadPath(system, preload)
    with pytest.raises(ConvergenceError, match="quasi-static path: no equilibrium"):
        path.to(np.full(system.n_dofs, np.nan))
