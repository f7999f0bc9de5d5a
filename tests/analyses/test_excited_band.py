"""Energy of a base motion above the modes of mesh and reduced basis, and what the time step does to it."""

from __future__ import annotations

import numpy as np
import pytest
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.excited_band import band_remark, basis_remark, excited_to, mesh_band, period_error
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.analyses.shared.time_step import time_step
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.dynamics.time_stepping.simulate import make_stepper
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.progress import SilentProgress

SILENT = SilentProgress()


def lab(name: str, *overrides: str) -> wf.Case:
    return wf.load_case(CONFIGS / f"{name}.yaml", list(overrides))


def bending_modes(mesh: str) -> np.ndarray:
    case = lab("lab_sweep", "coil={model: none}", "analysis=modal", "modal.count=40", mesh)
    found = wf.run(case, progress=SILENT)
    kinds = np.array([str(kind) for kind in found["mode_kind"].values])
    return np.unique(np.round(found["mode_frequency"].values[kinds == "bending"], 1))


def test_modes_below_the_band_of_the_mesh_are_resolved_and_some_above_are_not() -> None:
    fine = bending_modes("mesh={circumferential: 12, axial: 10}")[:4]
    worst = []
    for mesh in ("axial: 2", "axial: 3", "axial: 4, grading: 4"):
        mesh = f"mesh={{circumferential: 12, {mesh}}}"
        band = mesh_band(lab("lab_sweep", "coil={model: none}", mesh))
        found = bending_modes(mesh)[: len(fine)]
        error = found / fine[: len(found)] - 1.0
        assert error[fine[: len(found)] < band].max() < 0.05
        worst.append(error.max())
    assert max(worst) > 0.2


@pytest.mark.parametrize("name", ["lab_sweep", "lab_dwell", "lab_random", "lab_shock"])
def test_shipped_cases_have_their_energy_below_the_band_of_their_mesh(name: str) -> None:
    case = lab(name)
    assert band_remark(case) == ""
    assert 100.0 < excited_to(case) < mesh_band(case)


@pytest.mark.parametrize(
    ("name", "override", "highest"),
    [
        ("lab_shock", "excitation={kind: half_sine, amplitude_g: 20, duration: 2.0e-4}", 5.9e3),
        ("lab_random", "excitation.psd.frequency=[20, 9000]", 9.0e3),
        ("lab_sweep", "excitation={kind: chirp, amplitude: 5, f_start: 100, f_end: 9000, rate_oct_per_min: 9}", 9.0e3),
    ],
)
def test_energy_above_the_mesh_is_told_with_the_error_of_the_time_step(
    name: str, override: str, highest: float
) -> None:
    case = lab(name, override, "mesh={circumferential: 24, axial: 6, grading: 6}")
    text = band_remark(case)
    assert excited_to(case) == pytest.approx(highest, rel=0.3)
    assert f"has energy up to {excited_to(case):.4g} Hz" in text
    assert f"up to {mesh_band(case):.4g} Hz" in text
    assert f"lengthens periods there by {100 * period_error(case, excited_to(case)):.2g} %" in text
    damping = numerical_damping(Scheme.hht(-0.05), 2.0 * np.pi * excited_to(case) * time_step(case))[0]
    assert f"and adds a damping ratio of {100 * damping:.2g} %" in text
    exact = case.changed("integrator={scheme: trigonometric}")
    assert "the time step is exact for linear modes there" in band_remark(exact)
    need = int(text.split("raise mesh.axial to ")[1].split(",")[0])
    assert need > 6
    assert "\n" not in text


def test_a_mode_outside_the_reduced_basis_is_told() -> None:
    case = lab("lab_random", "mesh={circumferential: 8, axial: 3}", "excitation.psd.frequency=[20, 3000]")
    system, state = prepare(case, SILENT)
    dt = 1.0 / (3000.0 * 20)
    stepper = make_stepper(system, state, method="reduced", scheme=Scheme.hht(-0.05), options=NewtonOptions(), dt=dt)
    assert isinstance(stepper, ReducedStepper)
    assert not stepper.complete
    assert basis_remark(case, stepper) == ""
    modes = stepper.condensation
    share = np.abs(modes.base * modes.tip)
    natural = np.sqrt(modes.eigenvalues) / (2.0 * np.pi)
    second = int(np.flatnonzero((share > 0.05 * share.max()) & (natural > 1.5 * modes.main_mode[0]))[0])
    kept = stepper.vectors.copy()
    kept[second] = 0.0
    stepper._use(ReducedModel.of_vectors(modes, kept[:, :]))
    text = basis_remark(case, stepper)
    assert f"the lowest at {natural[second]:.4g} Hz" in text
    assert "the time step lengthens periods" in text


def test_the_result_states_the_error_at_the_highest_frequency() -> None:
    case = lab("lab_random", "mesh={circumferential: 8, axial: 2}", "excitation.duration=0.6")
    found = wf.run(case, progress=SILENT).attrs
    assert found["excited_to_hz"] == pytest.approx(300.0, rel=1e-3)
    exact = numerical_damping(Scheme.hht(-0.05), 2.0 * np.pi / found["steps_per_cycle"])[1]
    assert found["period_error_at_highest"] == pytest.approx(exact, rel=1e-6)
    assert period_error(case, 1e5) == np.inf
