"""Coil whose wraps slide at a pressure that the motion changes."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
import xarray as xr
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.followed_mode import main_mode
from wroll_fem.analyses.slip_structure import WoundCoil, slipping_structure, stress_rows
from wroll_fem.bodies.body import Body
from wroll_fem.case import SlipDampingCase, load_case
from wroll_fem.coiled_stiff.shear_points import ShearPoints
from wroll_fem.contact.kernels import OPEN
from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.cycle_path import CyclePath, cycle_path
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import ModalPath, modal_path
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError

CASE = CONFIGS / "slipping_coil.yaml"
SMALL = "mesh={circumferential: 8, axial: 3, grading: 6, radial: 2}"
VARYING = "coil.pressure=varying"
SOFT = "coil.wrap_interfaces={elastic_slip: 1.0e-6}"


def case(*changed: str) -> SlipDampingCase:
    found = load_case(CASE, [SMALL, *changed])
    assert isinstance(found, SlipDampingCase)
    return found


@cache
def coil(*changed: str) -> tuple[Body, ShearPoints, System, ContactState, sp.csr_matrix]:
    """Structure of a case and the rows of its radial stress."""
    chosen = case(*changed)
    body, points, system, start = slipping_structure(chosen)
    radial = WoundCoil(chosen).at(points.points[:, 2]).radial_modulus
    return body, points, system, start, stress_rows(body, points, chosen.coil.solid().stiffness(), radial)


@cache
def cycles(factor: float, *, steps: int = 16, tolerance: float = 1e-3) -> tuple[LoadPath, CyclePath]:
    """Cycles of the soft coil with the radial stress times ``factor``."""
    _, _, system, start, stress = coil(VARYING, SOFT)
    path = LoadPath(system, start, stress=factor * stress, tolerance=tolerance)
    return path, cycle_path(path, main_mode(system, path), [1.5, 3.0, 6.0], steps=steps, keep=True)


def test_without_a_change_of_the_pressure_cycles_are_those_of_the_fixed_pressure() -> None:
    """Another law, a constant stick stiffness, and cycles in place of Masing's rule."""
    _, _, system, start, _ = coil(SOFT)
    path = LoadPath(system, start)
    levels, same = [1.0, 1.2, 1.5, 1.8, 2.2, 2.6, 3.0, 3.6, 4.3, 5.1, 6.0], [2, 6, 10]
    fixed: ModalPath = modal_path(path, main_mode(system, path), levels)
    _, found = cycles(0.0)
    np.testing.assert_allclose(found.amplitude, fixed.amplitude[same], rtol=1e-3)
    np.testing.assert_allclose(found.frequency, fixed.frequency[same], rtol=1e-3)
    np.testing.assert_allclose(found.dissipation, fixed.dissipation[same], rtol=0.01)


def test_the_friction_limit_is_that_of_the_pressure_less_the_radial_stress() -> None:
    """At the end of the path, from the displacements; where the stress is larger, the wraps have no friction."""
    path, _ = cycles(1.0)
    state, stress = path.state, coil(VARYING, SOFT)[-1]
    mu = path.system.laws.mu
    pressure = path.start.pressure - stress @ (state.displacement - path.start.displacement)
    np.testing.assert_allclose(state.pressure, np.maximum(0.0, pressure), atol=1e-9 * pressure.max())
    traction = np.linalg.norm(tangentials(state.traction), axis=1)
    assert np.all(traction <= mu * state.pressure * (1.0 + 1e-9) + 1e-6)
    slides = (state.status != 0) & (state.pressure > 0.0)
    np.testing.assert_allclose(traction[slides], (mu * state.pressure)[slides], rtol=1e-9)
    assert np.ptp(pressure / path.start.pressure) > 0.5
    opened = state.status == OPEN
    np.testing.assert_array_equal(traction[opened], 0.0)


def test_the_forces_balance_without_a_force_of_the_pressure() -> None:
    """K_0 v plus the shear of the points equals the load: the radial stress belongs to K_0 alone."""
    path, found = cycles(1.0, tolerance=1e-5)
    body, points, system, start, _ = coil(VARYING, SOFT)
    assert body.solid is not None
    moved = path.state.displacement - start.displacement
    shear = np.repeat(points.volumes, 2) * tangentials(path.state.traction).ravel()
    inner = body.stiffness @ moved + (points.strain @ body.solid.expand).T @ shear
    load = found.force[-1] * (system.mass @ main_mode(system, path))
    unbalanced = path.stuck(inner - load)
    assert np.sqrt(unbalanced @ (path.stiffness @ unbalanced)) < 2e-5 * np.sqrt(load @ path.stuck(load))


def test_loop_area_and_slip_work_agree_and_cycles_close() -> None:
    _, found = cycles(1.0)
    np.testing.assert_allclose(found.loop_area, found.dissipation, rtol=0.03, atol=0.01 * found.dissipation[-1])
    np.testing.assert_allclose(found.dissipation_by_point.sum(axis=0), found.dissipation_by_component[-1], rtol=1e-9)
    assert found.closure.max() < 5e-3


def test_halved_steps_change_frequency_and_damping_little() -> None:
    (_, coarse), (_, fine) = cycles(1.0), cycles(1.0, steps=32)
    np.testing.assert_allclose(coarse.amplitude, fine.amplitude, rtol=2e-3)
    np.testing.assert_allclose(coarse.frequency, fine.frequency, rtol=5e-4)
    np.testing.assert_allclose(coarse.dissipation, fine.dissipation, rtol=0.01, atol=1e-3 * fine.dissipation[-1])


def test_a_mirrored_roll_slips_as_much() -> None:
    """The load to the other side swaps the sides whose pressure rises and falls."""
    _, found = cycles(1.0)
    _, mirrored = cycles(-1.0)
    np.testing.assert_allclose(mirrored.frequency, found.frequency, rtol=1e-3)
    np.testing.assert_allclose(mirrored.dissipation, found.dissipation, rtol=0.02, atol=1e-3 * found.dissipation[-1])


@cache
def runs() -> tuple[xr.Dataset, xr.Dataset]:
    """Soft coil at fixed and at varying pressure."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fixed = wf.run(case(SOFT, "excitation.amplitude_g=[2, 8]"), progress=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a pressure that follows the motion needs no warning
        warnings.filterwarnings("ignore", "the mesh does not resolve")  # it is coarse
        varying = wf.run(case(SOFT, VARYING, "excitation.amplitude_g=[2, 8]"), progress=False)
    return fixed, varying


def test_the_analysis_takes_the_varying_pressure() -> None:
    fixed, varying = runs()
    assert varying.attrs["f_stuck_hz"] == pytest.approx(fixed.attrs["f_stuck_hz"], rel=1e-9)
    assert "cycles" in varying.attrs["method"]
    assert varying.attrs["cycle_closure"] < 0.01
    assert "cycle_closure" not in fixed.attrs
    # the wraps on one side press more, those on the other less: the first slip is earlier, the response similar
    assert float(varying["tip_amplitude"][0]) < float(fixed["tip_amplitude"][0])
    np.testing.assert_allclose(varying["frequency_at_level"], fixed["frequency_at_level"], rtol=0.01)
    np.testing.assert_allclose(varying["damping_at_level"], fixed["damping_at_level"], rtol=0.1)
    difference = varying["damping_at_level"] / fixed["damping_at_level"] - 1.0
    assert np.abs(difference).max() > 1e-3
    work, by_component = varying["friction_work_per_cycle"], ("rt", "rz")
    total = sum(varying[f"friction_work_{name}_per_cycle"] for name in by_component)
    np.testing.assert_allclose(total, work, rtol=1e-9)
    wf.plot.slip_work(varying)
    wf.plot.slip_damping(varying)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (["coil.pressure=constant"], "coil.pressure: is not one of the choices, got 'constant'; use fixed, varying"),
        (
            [VARYING, "coil.inside=stiff", "analysis=modal_transient"],
            "coil.pressure: is for a solid coil whose wraps slide, got 'varying'; leave it out",
        ),
    ],
)
def test_a_wrong_pressure_is_refused_in_one_line(changed: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        case(*changed)
