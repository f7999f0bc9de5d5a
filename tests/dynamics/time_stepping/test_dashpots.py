"""Material damping in all methods of time stepping: closed forms, equal motions, closed energy balance."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from support.exact_systems import slipping_pair
from support.paths import CONFIGS

from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.case import load_case
from wroll_fem.dynamics.reduction.condensation import Condensation, condense
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.modal_damping import ModalDamping
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.simulate import simulate
from wroll_fem.results.energy import energy_balance_error
from wroll_fem.signals.base_motion import Dwell

METHODS = ["full", "condensed", "reduced"]
HHT = Scheme.hht(-0.05)
ZETA = 0.02


def modes(system: System, preload: ContactState) -> Condensation:
    return condense(system, stick_springs(system, preload), HHT, 1e-4)


def damped(system: System, kind: str) -> System:
    """System with one of the descriptions of material damping."""
    parts = {
        "modal": {"modal_damping": ModalDamping(ratios=(ZETA,))},
        "rayleigh": {"damping": 5.0 * system.mass + 2e-5 * system.stiffness},
        "loss": {"modal_damping": ModalDamping(loss=0.04 * system.stiffness)},
    }
    parts["both"] = parts["modal"] | parts["rayleigh"]
    return dataclasses.replace(system, **parts[kind])


@cache
def roll() -> tuple[System, ContactState]:
    case = load_case(CONFIGS / "lab_sweep.yaml", ["mesh={circumferential: 8, axial: 2, grading: 1}"])
    system = build_system(case, build_bodies(case))
    return system, solve_preload(system)


@pytest.mark.parametrize("method", [pytest.param("full", marks=pytest.mark.slow), *METHODS[1:]])
def test_the_steady_peak_of_sticking_layers_is_that_of_the_damping_ratio(method: str) -> None:
    """At the natural frequency of a mode T = participation / (2 zeta), plus the small motion of the other modes."""
    zeta = 0.05
    system = dataclasses.replace(slipping_pair(mu=3.0), modal_damping=ModalDamping(ratios=(zeta,)))
    preload = solve_preload(system)
    c = modes(system, preload)
    hertz, participation = c.main_mode
    weak = Dwell(1e-4, hertz, 25.0, ramp_cycles=2.0)
    history = simulate(system, preload, weak, dt=1.0 / (60.0 * hertz), scheme=HHT, method=method)
    last = history.isel(time=slice(-60, None))
    absolute = (last["tip_acceleration"] + last["base_acceleration"]).values
    turn = 2.0 * np.pi * hertz * last["time"].values
    peak = 2.0 * abs(np.mean(absolute * np.exp(-1j * turn))) / 1e-4
    assert participation > 1.0
    assert peak == pytest.approx(participation / (2.0 * zeta), rel=5e-3)
    assert float(history["friction_energy"][-1]) == pytest.approx(0.0, abs=1e-9 * float(history["input_work"][-1]))
    assert energy_balance_error(history) < 1e-8


@pytest.mark.parametrize("kind", [pytest.param("modal", marks=pytest.mark.slow), "both"])
def test_all_methods_give_the_same_motion_with_friction_and_material_damping(kind: str) -> None:
    """The full model forms no matrix of modal damping; the condensed model has diagonal or full blocks."""
    system, preload = roll()
    system = damped(system, kind)
    strong = Dwell(100.0, 150.0, 1.5, ramp_cycles=0.5)
    full, condensed, reduced = (
        simulate(system, preload, strong, dt=1.0 / (150.0 * 24.0), scheme=HHT, method=method) for method in METHODS
    )
    assert float(full["slipping_fraction"].max()) > 0.05
    for other, motion, energy in ((condensed, 1e-7, 1e-6), (reduced, 3e-3, 1e-2)):
        size = float(np.abs(full["tip_displacement"]).max())
        np.testing.assert_allclose(other["tip_displacement"], full["tip_displacement"], atol=motion * size)
        for name in ("friction_energy", "material_damping"):
            assert float(other[name][-1]) == pytest.approx(float(full[name][-1]), rel=energy)
    for exact in (full, condensed):
        assert energy_balance_error(exact) < 1e-8
    assert float(full["material_damping"][-1]) > 0.05 * float(full["friction_energy"][-1])


def test_modal_damping_keeps_the_circumferential_blocks_and_loses_what_the_modes_lose() -> None:
    """Loss factors equal in all bodies damp like one damping ratio, but for the strain energy of the contact."""
    system, preload = roll()
    whole = modes(damped(system, "modal"), preload)
    assert all(rates.ndim == 1 for rates in whole.damping)
    assert len(whole.damping) > 1
    lossy = modes(damped(system, "loss"), preload)
    ratios = np.concatenate(lossy.damping) / (2.0 * np.sqrt(lossy.eigenvalues))
    lowest = int(np.argmin(lossy.eigenvalues))
    assert ratios.max() < 0.02
    assert ratios[lowest] == pytest.approx(0.02, rel=0.05)
    rayleigh = modes(damped(system, "rayleigh"), preload)
    assert all(block.ndim == 2 for block in rayleigh.damping)
    own = np.concatenate([np.diag(block) for block in rayleigh.damping])
    # 2 zeta omega = alpha + beta omega^2, less the part of the strain energy in the contact springs
    assert own[lowest] == pytest.approx(5.0 + 2e-5 * rayleigh.eigenvalues[lowest] * ratios[lowest] / 0.02, rel=1e-9)
