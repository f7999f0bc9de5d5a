"""Stress of shells: bent and pressed tubes against beam and membrane theory; largest stress of runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.interrupted import interrupted
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.case import load_case
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.fem.shell_stress import shell_stresses
from wroll_fem.numerics.linear import factorise
from wroll_fem.progress import SilentProgress

FINE = "mesh={circumferential: 24, axial: 16, grading: 1}"
COARSE = ("mesh={circumferential: 8, axial: 4, grading: 1}", "output.figures=false")


def test_von_mises_stress_of_a_bent_tube_is_that_of_a_beam() -> None:
    """Force at the tip: F (L - z) r / I on the outer surface, away from the ends by more than the decay of edges."""
    case = load_case(CONFIGS / "lab_mandrel.yaml", [FINE])
    bodies = build_bodies(case, symmetric=True)
    system = build_system(case, bodies)
    (shell,) = shell_stresses(case, bodies)
    displacement = factorise(system.stiffness.tocsc()).solve(10.0 * system.probes["tip"])
    stress = shell.von_mises(shell.resultants(displacement))
    length, outer = case.geometry.length, 0.5 * case.geometry.mandrel_outer_diameter
    inner = outer - case.geometry.mandrel_thickness
    moment_of_area = 0.25 * np.pi * (outer**4 - inner**4)
    heights = np.unique(np.round(shell.points[:, 2], 9))
    middle = [z for z in heights if 0.25 * length < z < 0.75 * length]
    assert len(middle) > 5
    for z in middle:
        at = np.abs(shell.points[:, 2] - z) < 1e-6
        beam = 10.0 * (length - z) * np.array([inner, outer]) / moment_of_area
        np.testing.assert_allclose(stress[at].max(axis=0), beam, rtol=0.01)


def test_hoop_stress_of_a_pressed_layer_is_that_of_a_ring() -> None:
    """Uniform pressure on a free layer: n_theta = -p r, n_z = 0; von Mises stress p r / t."""
    case = load_case(CONFIGS / "lab_harmonic.yaml", [FINE])
    bodies = build_bodies(case, symmetric=True)
    shell = shell_stresses(case, bodies)[1]
    layer, pressure = bodies[1], 1e4
    start = bodies[0].n_dofs
    free = layer.stiffness + 1e-9 * abs(layer.stiffness).max() * layer.mass / layer.mass.max()
    displacement = np.zeros(sum(body.n_dofs for body in bodies))
    displacement[start:] = factorise(free.tocsc()).solve(pressure * layer.pressure_force)
    stress = shell.von_mises(shell.resultants(displacement))
    radius = float(np.hypot(*shell.points[0, :2]))
    outer = radius + 0.5 * shell.thickness
    ring = pressure * outer / shell.thickness
    np.testing.assert_allclose(stress.mean(axis=1), ring, rtol=0.01)
    # thin shells: the surfaces are uncertain by t / (2 R), 1.5 %
    np.testing.assert_allclose(stress, ring, rtol=0.01 + 0.5 * shell.thickness / radius)


def run(analysis: str, *overrides: str) -> dict[str, Any]:
    file = "lab_dwell" if analysis == "dwell" else "lab_harmonic"
    case = load_case(CONFIGS / f"{file}.yaml", [f"analysis={analysis}", *COARSE, *overrides])
    return summarise(run_analysis(case, progress=SilentProgress()))


def test_dwell_and_harmonic_balance_find_the_same_largest_stress() -> None:
    """A bonded roll with material damping, steady at its resonance."""
    linear = ("coil.model=bonded", "damping.modal=0.05", "mandrel.yield_stress=50 MPa")
    periodic = run("harmonic", *linear, "excitation.f_end=200.0")
    f = periodic["f_n_hz"]
    dwell = f"excitation={{kind: dwell, amplitude: 5.0, frequency: {f}, cycles: 25, ramp_cycles: 2}}"
    steady = run("dwell", *linear, dwell, "integrator.steps_per_cycle=160")
    np.testing.assert_allclose(steady["von_mises_max_pa"], periodic["von_mises_max_pa"], rtol=0.01)
    assert periodic["yield_margin"][0] == pytest.approx(50e6 / periodic["von_mises_max_pa"][0] - 1.0)
    assert periodic["yield_margin"][1] is None


def test_stress_at_the_largest_motion_survives_a_resumed_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The chunk with the largest motion lies before the interrupt: a burst that decays."""
    burst = [
        *COARSE,
        "damping.modal=0.05",
        "integrator.steps_per_cycle=40",
        "excitation={kind: dwell, amplitude: 5.0, frequency: 450.0, cycles: 30, ramp_cycles: 0}",
    ]
    case = load_case(CONFIGS / "lab_dwell.yaml", burst)
    whole = run_analysis(case, progress=SilentProgress())
    assert int(np.abs(whole["tip_displacement"].values).argmax()) < 400
    file = tmp_path / "run.ckpt"
    with interrupted(monkeypatch, ReducedStepper, 4):
        run_analysis(case, progress=SilentProgress(), checkpoint=file)
    again = run_analysis(case, progress=SilentProgress(), checkpoint=file, resume=True)
    np.testing.assert_array_equal(again["von_mises_max"], whole["von_mises_max"])
