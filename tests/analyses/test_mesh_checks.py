"""Every analysis of a roll tells that its mesh does not resolve what it computes, and is silent on a finer one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.paths import CONFIGS, ROOT

import wroll_fem as wf
from wroll_fem.analyses.buckling import wave_remark
from wroll_fem.analyses.shared.preflight import CHECKS
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.mesh.files import read_mesh, write_mesh
from wroll_fem.progress import SilentProgress

DWELL = "excitation={kind: dwell, frequency: 60, amplitude: 1.0, cycles: 1, ramp_cycles: 0}"
COARSE_COIL = "mesh={circumferential: 8, axial: 3, grading: 1, radial: 1}"
MODES = "the mesh does not resolve the modes: "


def warnings(file: str, *changed: str) -> list[str]:
    found = wf.run(wf.load_case(CONFIGS / file, [*changed, "output.figures=false"]), progress=SilentProgress())
    return [text for text in found.attrs["warnings"].split("\n") if "mesh" in text]


@pytest.mark.parametrize(
    ("file", "coarse", "fine", "words"),
    [
        (
            "lab_mandrel.yaml",
            ["analysis=modal", "mesh={circumferential: 12, axial: 6}"],
            ["analysis=modal"],
            MODES + "ovalling-3",
        ),
        (
            "lab_mandrel.yaml",
            ["analysis=modal", "mesh={circumferential: 12, axial: 6}",
             "coil={model: nonstructural_mass, total_thickness: 1e-3, material: {E: 1e9, nu: 0.3, rho: 900}}"],
            [],
            MODES + "ovalling-3",
        ),
        (
            "slipping_coil.yaml",
            [COARSE_COIL],
            ["mesh={circumferential: 8, axial: 8, grading: 20, radial: 2}"],
            MODES + "bending mode 1",
        ),
        (
            "slipping_harmonic.yaml",
            [COARSE_COIL, "excitation.amplitude_g=1"],
            [],
            MODES + "bending mode 1",
        ),
        (
            "case_study.yaml",
            ["mesh={circumferential: 8, axial: 4, grading: 1, radial_grading: 1}"],
            [],
            MODES + "bending mode 1",
        ),
        (
            "lab_mandrel.yaml",
            ["analysis=buckling", "preload={kind: external_pressure, pressure: 1e4}",
             "mesh={circumferential: 12, axial: 8}"],
            ["analysis=buckling", "preload={kind: external_pressure, pressure: 1e4}"],
            "the buckling mode has 3 waves around the roll and 4 elements per wave",
        ),
    ],
)  # fmt: skip
def test_a_mesh_that_is_too_coarse_is_named(file: str, coarse: list[str], fine: list[str], words: str) -> None:
    told = warnings(file, *coarse)
    assert any(text.startswith(words) for text in told), told
    assert not fine or warnings(file, *fine) == []


@pytest.mark.parametrize("analysis", ["modal", "buckling"])
def test_layers_that_stick_need_a_root_element_below_the_shear_lag(analysis: str) -> None:
    def told(*changed: str) -> list[str]:
        case = wf.load_case(CONFIGS / "lab_modal.yaml", [f"analysis={analysis}", "modal.interface=stuck", *changed])
        return [text for check in CHECKS[analysis] for text in check(case)]

    [text] = told("mesh={circumferential: 24, axial: 6, grading: 1}")
    assert text.startswith("the mesh does not resolve the shear lag: the root element is 50.0 mm high")
    assert told("mesh={circumferential: 24, axial: 16, grading: 40}") == []
    assert told("mesh={circumferential: 24, axial: 6, grading: 1}", "modal.interface=frictionless") == []


def test_the_error_of_a_buckling_load_is_that_of_a_finer_mesh() -> None:
    """The first mode of this tube has five waves; measured against three times as many elements."""
    thin = ["analysis=buckling", "preload={kind: external_pressure, pressure: 1e3}", "geometry.mandrel_thickness=2e-4"]
    factors = []
    for around in (24, 72):
        case = wf.load_case(CONFIGS / "lab_mandrel.yaml", [*thin, f"mesh={{circumferential: {around}, axial: 16}}"])
        found = wf.run(case, progress=SilentProgress())
        assert found.attrs["buckling_wave_number"] == 5
        factors.append(found.attrs["buckling_load_factor"])
    remark = wave_remark(5, 24)
    told = float(remark.split("about ")[1].split(" %")[0])
    assert 100.0 * (factors[0] / factors[1] - 1.0) == pytest.approx(told, rel=0.15)
    assert remark.endswith("raise mesh.circumferential to 28")
    assert wave_remark(5, 28) == wave_remark(0, 8) == ""


def test_contact_at_the_vertices_of_a_mesh_from_a_file_is_told(tmp_path: Path) -> None:
    """Columns of unequal width, symmetric about x-z: the vertices take the place of the Gauss heights."""
    shipped = ROOT / "meshes" / "lab_small.msh"
    mesh = read_mesh(shipped, ["mandrel", "layer_01"])
    x, y, z = mesh.nodes.T
    radius, theta = np.hypot(x, y), np.arctan2(y, x)
    theta = theta + 0.02 * np.sin(2.0 * theta)
    path = write_mesh(
        replace(mesh, nodes=np.column_stack([radius * np.cos(theta), radius * np.sin(theta), z])), tmp_path
    )
    for file, said in ((path[0], 1), (shipped, 0)):
        case = wf.load_case(CONFIGS / "tiny.yaml", [f"mesh.file={file}", "preload.steps=1"])
        progress = SilentProgress()
        prepare(case, progress)
        assert sum("half an element at a free edge is left to slide" in text for text in progress.warnings) == said
