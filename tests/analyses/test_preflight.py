"""What is said before a run: closed forms against the finite elements."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from support.paths import ROOT

from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.forecasts.closed_forms import beam_frequency, buckling_pressure, interface_pressures
from wroll_fem.analyses.registry import MODULES, find_analysis
from wroll_fem.analyses.shared.preflight import CHECKS
from wroll_fem.case import load_case
from wroll_fem.progress import SilentProgress


def test_estimated_interface_pressures_are_those_of_the_preload_step() -> None:
    """Rings without end effects: the clamped and rigid ends of the mandrel carry a few per cent more."""
    small = ["analysis=preload", "mesh.circumferential=8", "mesh.axial=4", "preload.steps=1"]
    for pressures in ([200.0] * 5, [0.0, 0.0, 0.0, 0.0, 1000.0], [100.0, 150.0, 200.0, 250.0, 300.0]):
        case = load_case(ROOT / "configs" / "lab_dwell_layers.yaml", [*small, f"preload.pressure={pressures}"])
        found = run_analysis(case, progress=SilentProgress())
        mean = (found["pressure"] * found["area"]).sum("point") / found["area"].sum("point")
        np.testing.assert_allclose(interface_pressures(case), mean, rtol=0.08)


def test_an_interface_that_would_be_pulled_apart_has_no_pressure() -> None:
    case = load_case(ROOT / "configs" / "lab_dwell_layers.yaml", ["preload.pressure=[1000.0, 0.0, 0.0, 0.0, 0.0]"])
    assert interface_pressures(case)[1:] == [0.0] * 4
    assert interface_pressures(case)[0] > 0.0


def test_a_tube_that_is_only_a_ring_does_not_buckle() -> None:
    """The denominator of the formula of Windenburg and Trilling has a zero at L = 0.45 sqrt(t D)."""
    roll = ROOT / "configs" / "sspp_friction.yaml"
    ring = ["geometry.mandrel_outer_diameter=1.5", "geometry.mandrel_thickness=0.01"]
    limits = [buckling_pressure(load_case(roll, [*ring, f"geometry.length={L}"])) for L in (0.056, 0.054, 0.001)]
    assert 1e8 < limits[0] < np.inf
    assert limits[1:] == [np.inf, np.inf]


@pytest.mark.parametrize(
    ("name", "share", "state"), [("lab_sweep", 1.0, "frictionless"), ("sspp_friction", 0.7, "open")]
)
def test_a_band_below_the_resonance_names_both_ends_of_its_range(name: str, share: float, state: str) -> None:
    case = load_case(ROOT / "configs" / f"{name}.yaml", ["excitation.f_start=1", "excitation.f_end=2"])
    (line,) = (text for text in CHECKS["sweep"][0](case))
    assert f"between {share * beam_frequency(case, bonded=False):.0f} Hz ({state}) and " in line


@pytest.mark.parametrize("name", MODULES)
def test_an_analysis_has_the_checks_of_the_table(name: str) -> None:
    """The table is read without importing the analysis; one that is not in it names its checks itself."""
    assert find_analysis(name).preflight == CHECKS.get(name, find_analysis(name).preflight)


def test_validation_imports_no_solver() -> None:
    files = [
        str(ROOT / "configs" / f"{name}.yaml") for name in ("lab_dwell", "lab_sweep", "lab_harmonic", "coiled_stiff")
    ]
    code = (
        "import sys; from wroll_fem.case import load_case; from wroll_fem.analyses import case_warnings; "
        f"[case_warnings(load_case(file)) for file in {files}]; "
        "print([name for name in ('numba', 'scipy', 'xarray', 'dolfinx', 'matplotlib') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == "[]"
