"""Probes in the preload, in the coiled-stiff response and in Fourier modes, against theory and one another."""

from __future__ import annotations

import numpy as np
import pytest
from support.paths import CONFIGS

import wroll_fem as wf

pytestmark = pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")

POINTS = {
    "cap": {"z": 0.300},
    "middle": {"z": 0.150, "theta": 0.7},
    "axial": {"z": 0.150, "theta": 0.7, "direction": "z"},
    "hoop": {"z": 0.150, "theta": 0.7, "direction": "hoop"},
}


def test_preload_presses_the_wall_inwards_by_pressure_over_stiffness() -> None:
    points = {
        "wall": {"z": 0.15, "theta": 0.3, "direction": "radial"},
        "layer": {"z": 0.15, "theta": 0.3, "direction": "radial", "body": "layer_01"},
        "turn": {"z": 0.15, "theta": 0.3, "direction": "hoop"},
    }
    case = wf.load_case(
        CONFIGS / "lab_sweep.yaml", ["analysis=preload", "mesh={circumferential: 12, axial: 10, grading: 1}"]
    )
    result = wf.run(case.replace({"probes": points}), progress=False)
    moved = dict(zip(result["probe"].values, result["probe_displacement"].values, strict=True))
    g, mandrel, coil, pressure = case.geometry, case.mandrel.material, case.coil.material, case.preload.pressure
    radius = 0.5 * g.mandrel_outer_diameter
    wall, t = radius - 0.5 * g.mandrel_thickness, case.coil.total_thickness
    ring = mandrel.E * g.mandrel_thickness / wall**2 + coil.E * t / (radius + 0.5 * t) ** 2
    assert moved["wall"] == pytest.approx(-pressure / ring, rel=0.1)  # rings of thin walls, far from the ends
    assert moved["layer"] == pytest.approx(moved["wall"], rel=0.05)
    assert abs(moved["turn"]) < 1e-3 * abs(moved["wall"])  # zero but for the interpolation in a cell
    assert list(result["probe"].values) == ["tip", *points]


@pytest.mark.parametrize("direction", ["x", pytest.param("y", marks=pytest.mark.slow)])
def test_response_of_a_solid_coil_at_probes_agrees_between_discretisations(direction: str) -> None:
    words = ["mesh={circumferential: 8, axial: 4, grading: 12, radial: 2, radial_grading: 4}", "modal.count=4"]
    three = wf.load_case(CONFIGS / "case_study.yaml", [*words, f"excitation.direction={direction}"])
    first = wf.run(three.replace({"probes": POINTS}), progress=False)
    second = wf.run(three.replace({"probes": POINTS, "mesh.discretisation": "fourier"}), progress=False)
    assert list(first["probe"].values) == list(second["probe"].values) == ["tip", *POINTS]
    for result in (first, second):
        np.testing.assert_array_equal(result["probe_displacement"][0], result["tip_displacement"])
    swing = [np.abs(result["probe_displacement"].values).max(axis=1) for result in (first, second)]
    assert swing[0].min() > (1e-4 if direction == "x" else 0.0) * swing[0].max()
    np.testing.assert_allclose(swing[0], swing[1], rtol=0.05, atol=1e-3 * swing[0].max())
    along = 1 if direction == "x" else None  # the rigid cap moves along the excitation as the tip does
    if along is not None:
        np.testing.assert_allclose(first["probe_displacement"][along], first["tip_displacement"], atol=1e-9)


def test_fourier_modes_at_probes_are_those_of_the_three_dimensional_model() -> None:
    words = ["analysis=modal", "mesh.circumferential=8", "mesh.axial=4", "mesh.radial=2", "modal.count=2"]
    three = wf.load_case(CONFIGS / "coiled_stiff.yaml", ["mesh.discretisation=three_dimensional", *words])
    first = wf.run(three.replace({"probes": POINTS}), progress=False)
    second = wf.run(three.replace({"probes": POINTS, "mesh.discretisation": "fourier"}), progress=False)
    assert list(second["mode_kind"].values) == ["bending", "bending"]
    for k in range(2):  # the sign of a mode is arbitrary
        a, b = (result["mode_at_probe"].values[k] for result in (first, second))
        np.testing.assert_allclose(a * np.sign(a @ b), b, atol=0.03 * np.abs(b).max())
