"""Coil whose wraps slide, shaken: harmonic balance and histories in the basis of its quasi-static path."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr
from scipy.constants import g as GRAVITY
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.followed_mode import main_mode
from wroll_fem.analyses.slip_structure import slipping_structure
from wroll_fem.case import load_case
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.response import HarmonicCurve, response_curve
from wroll_fem.dynamics.reduction.path_modes import path_modes
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import modal_path
from wroll_fem.dynamics.system.modal_damping import ModalDamping
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.dynamics.time_stepping.simulate import simulate
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.numerics.continuation import StepControl
from wroll_fem.signals.base_motion import Dwell

COARSE = "mesh={circumferential: 8, axial: 4, grading: 8, radial: 2}"
FINE = "mesh={circumferential: 8, axial: 8, grading: 20, radial: 2}"
LEVELS = (3.0, 5.0, 10.0, 15.0)  # g
RATIO = 0.02
LOSSES = "friction_energy", "pressure_modulation_work", "material_damping", "numerical_dissipation"
STORED = "kinetic_energy", "strain_energy", "contact_energy"


class Shaken(NamedTuple):
    """Path of the coil up to the highest level, its modes, and the response by the analysis."""

    path: LoadPath
    contact: HarmonicContact
    quasi_static: xr.Dataset


def mesh_of(level: float) -> str:
    """Coarse elements for the level of the quick tests."""
    return COARSE if level == 5.0 else FINE


@cache
def shaken(mesh: str) -> Shaken:
    case = load_case(CONFIGS / "slipping_coil.yaml", [mesh, f"excitation.amplitude_g={list(LEVELS)}"])
    _, _, system, start = slipping_structure(case)
    system = replace(system, modal_damping=ModalDamping(table=((1.0, RATIO), (1e6, RATIO))))
    path = LoadPath(system, start)
    modal_path(path, main_mode(system, path), np.geomspace(1.0, 9.0, 13))
    model = ReducedModel.complete(path_modes(path))
    contact = HarmonicContact(model, start, system.laws, Sampling(9, 128))  # seven miss 0.5 % of the tip at 5 g
    return Shaken(path, contact, wf.run(case, progress=False))


@cache
def curve(level: float) -> HarmonicCurve:
    return response_curve(
        shaken(mesh_of(level)).contact,
        amplitude=level * GRAVITY,
        frequencies=(70.0, 110.0),
        control=StepControl(largest=0.1),
    )


def test_modes_of_the_path_contain_the_stuck_mode() -> None:
    path, contact, found = shaken(COARSE)
    modes = contact.model.condensation
    assert np.sqrt(modes.eigenvalues[0]) / (2.0 * np.pi) == pytest.approx(found.attrs["f_stuck_hz"], rel=1e-9)
    _, vectors = modes.vectors[0]
    np.testing.assert_allclose(vectors.T @ (path.system.mass @ vectors), np.eye(len(vectors.T)), atol=1e-8)
    np.testing.assert_allclose(
        vectors.T @ (path.stiffness @ vectors), np.diag(modes.eigenvalues), atol=1e-8 * modes.eigenvalues[-1]
    )


@pytest.mark.parametrize("level", [g if g == 5.0 else pytest.param(g, marks=pytest.mark.slow) for g in LEVELS])
def test_the_path_has_the_peak_of_harmonic_balance(level: float) -> None:
    """Nine harmonics; tip 1.5 %, frequency 0.2 %, damping 1.5 %, energy 1e-6."""
    found, expected = curve(level), shaken(mesh_of(level)).quasi_static.sel(amplitude_g=level)
    model = found.balance.model
    tips = np.array([np.hypot(*(q[1:3] @ model.tip)) for q in found.coefficients])
    k = int(np.argmax(tips))
    top = np.polynomial.Polynomial.fit(found.frequencies[k - 1 : k + 2], tips[k - 1 : k + 2], 2)
    peak = float(top.deriv().roots()[0])
    assert float(expected["tip_at_level"]) == pytest.approx(top(peak), rel=0.015)
    assert float(expected["frequency_at_level"]) == pytest.approx(peak / (2.0 * np.pi), rel=2e-3)
    work = found.balance.cycle_work(found.coefficients[k], found.frequencies[k])
    assert work.input == pytest.approx(work.interface + work.viscous, rel=1e-6)
    amplitude = float(np.linalg.norm(found.coefficients[k][1:3, 0]))  # of the stuck mode
    zeta = (work.friction + work.viscous) / (2.0 * np.pi * (found.frequencies[k] * amplitude) ** 2)
    assert float(expected["damping_at_level"]) == pytest.approx(zeta, rel=0.015)


def undamped(response: complex, zeta: float) -> float:
    """Frequency of the excitation relative to that of an oscillator with the displacement ``response`` to -a_g."""
    phase = -np.angle(response)
    slope = zeta / np.tan(phase)  # r^2 + 2 zeta r / tan(phase) - 1 = 0
    return float(np.hypot(slope, 1.0) - slope)


@pytest.mark.parametrize("level", [g if g == 5.0 else pytest.param(g, marks=pytest.mark.slow) for g in LEVELS])
def test_a_dwell_at_the_peak_has_the_motion_of_harmonic_balance(level: float) -> None:
    """In time, from rest to a steady state: tip 1.5 %, frequency 0.2 %, damping 1.5 %; energy per cycle 1e-3."""
    path, contact, quasi_static = shaken(mesh_of(level))
    found, steps, scheme = curve(level), 60, Scheme.hht(-0.05)
    tips = np.array([np.hypot(*(q[1:3] @ contact.model.tip)) for q in found.coefficients])
    k = int(np.argmax(tips))
    hertz = found.frequencies[k] / (2.0 * np.pi)
    stepper = ReducedStepper(
        path.system, path.start, scheme, NewtonOptions(), dt=1.0 / hertz / steps,
        condensation=contact.model.condensation,
    )  # fmt: skip
    motion = Dwell(level * GRAVITY, hertz, 50, 10)
    run = simulate(path.system, path.start, motion, dt=1.0 / hertz / steps, scheme=scheme, stepper=stepper)
    turn = np.exp(-2j * np.pi * np.arange(steps) / steps)
    moved, base = (
        2.0 / steps * (run[name].values[-steps:] @ turn) for name in ("tip_displacement", "base_acceleration")
    )
    tip, expected = abs(moved), quasi_static.sel(amplitude_g=level)
    assert tip == pytest.approx(tips[k], rel=6e-3)
    assert float(expected["tip_at_level"]) == pytest.approx(tip, rel=0.015)
    cycle = {name: float(run[name][-1] - run[name][-1 - steps]) for name in ("input_work", *LOSSES, *STORED)}
    work = found.balance.cycle_work(found.coefficients[k], found.frequencies[k])
    assert cycle["friction_energy"] == pytest.approx(work.friction, rel=6e-3)
    lost, kept = (sum(cycle[name] for name in names) for names in (LOSSES, STORED))
    assert cycle["input_work"] == pytest.approx(lost + kept, rel=1e-3)
    assert abs(kept) < 1e-3 * lost
    amplitude = tip / tips[k] * float(np.linalg.norm(found.coefficients[k][1:3, 0]))  # of the stuck mode
    spent = cycle["friction_energy"] + cycle["material_damping"]
    zeta = spent / (2.0 * np.pi * (found.frequencies[k] * amplitude) ** 2)
    assert float(expected["damping_at_level"]) == pytest.approx(zeta, rel=0.015)
    assert float(expected["frequency_at_level"]) == pytest.approx(hertz / undamped(-moved / base, zeta), rel=2e-3)
