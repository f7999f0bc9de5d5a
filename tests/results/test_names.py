"""Every name of results.nc and summary.json is produced, with the dimensions that the registry states."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import xarray as xr
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.margins import mandrel_wall
from wroll_fem.analyses.registry import find_analysis
from wroll_fem.case.analyses import MODULES
from wroll_fem.dynamics.reduction.kept_structure import keeping_structure
from wroll_fem.lab.examples import example_files
from wroll_fem.lab.kinds import KINDS
from wroll_fem.lab.slip_images import example as slip_example
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import FIELDS
from wroll_fem.results.interface_slip import slipping_area_fraction
from wroll_fem.results.summary import SUMMARY
from wroll_fem.signals.transmissibility import magnitude
from wroll_fem.tribology import RateAndState, ShearTest, VelocitySteps, run_shear_test, shear_history

COARSE = ["mesh.circumferential=8", "mesh.axial=2"]
DAMPED = "damping.modal=0.01"
PROBE = "probes={middle: {z: 0.15}}"
PLAIN = ["harmonic.harmonics=1", "harmonic.samples=16"]
WEAK = "{frequency: [80, 250], g2_per_hz: [1e-4, 1e-4]}"
"""Hz, g^2/Hz: almost no slip, and few basis vectors."""
CASES: dict[str, tuple[str, list[str]]] = {
    "sweep": (  # up and down
        "oscillator",
        [
            "excitation.rate_oct_per_min=10", "excitation.f_start=8", "excitation.f_end=30", DAMPED,
            "integrator.steps_per_cycle=20", "excitation.sweep_direction=up_down", "output.damping=gaussian_fit",
        ],
    ),
    "random at levels": (
        "lab_random",
        [*COARSE, "excitation.duration=1", "excitation.psd.frequency=[80, 250]", "excitation.levels=[0.1]",
         "excitation.records=2"],
    ),
    "dwell": (
        "lab_dwell",
        [
            *COARSE, "integrator.steps_per_cycle=20", "excitation.cycles=4", "excitation.ramp_cycles=1",
            "output.every=20", PROBE, DAMPED, "mandrel.yield_stress=1e8",
        ],
    ),
    "random": ("lab_random", [*COARSE, "excitation.duration=1", f"excitation.psd={WEAK}", DAMPED]),
    "shock": ("lab_shock", [*COARSE, "excitation.decay=0.1", "solver.method=condensed"]),
    "harmonic": ("oscillator", ["analysis=harmonic", "excitation.amplitude=3"]),  # its curve folds
    "backbone": (
        "lab_backbone",
        [
            *COARSE, *PLAIN, PROBE, DAMPED, "coil.per_wrap=true", "backbone.tip_largest=5e-5",
            "winding={tension_stress: 2.7e6, wraps: 25, wrap_thickness: 5e-5, web: {E_theta: 2.8e9, nu_theta: 0.35, "
            "radial_modulus: {law: pfeiffer, K1: 1e3, K2: 40}}}",
        ],
    ),
    "random_response": (
        "lab_random_response",
        [
            *COARSE, *PLAIN, DAMPED, "backbone.tip_largest=4e-4",
            "random_response={levels_db: [0], limits: {slip: 2e-5}}",
        ],
    ),
    "harmonic of a roll": (  # forces on a subset of its points
        "lab_harmonic",
        [
            "mesh={circumferential: 16, axial: 4}", *PLAIN, "harmonic.hyper_reduction=true",
            "harmonic.reduction_tolerance=0.1", "excitation.f_start=150", "excitation.f_end=152", PROBE,
            "coil.material={E_1: 2.8e9, E_2: 2.8e9, nu_12: 0.35, G_12: 1e9, G_23: 1e9, rho: 2000}",
        ],
    ),
    "harmonic of wraps that slide": (
        "slipping_harmonic",
        [
            "mesh={circumferential: 8, axial: 2, radial: 1}", "excitation.amplitude_g=3", *PLAIN,
        ],
    ),
    "modal": ("coiled_stiff", [*COARSE, "mesh.radial=1", "modal.count=3", PROBE, DAMPED]),
    "modal_transient": (
        "case_study",
        [
            "mesh.discretisation=fourier", "mesh.axial=4", "mesh.radial=1", "excitation.amplitude_g=[15]",
            "modal.count=4",
        ],
    ),
    "slip_damping": (
        "slipping_coil",
        [
            "mesh={circumferential: 8, axial: 4, grading: 10, radial: 1}", "geometry.mandrel_thickness=8e-3",
            "excitation.amplitude_g=[5]", "coil.pressure=varying",
            "coil.wrap_interfaces={elastic_slip: 1e-7}",
        ],
    ),
    "preload": ("winding_sweep", [*COARSE, "analysis=preload", "preload.steps=2"]),
    "buckling": ("lab_buckling", [*COARSE, "modal.count=1", "preload.pressure=1e4", "preload.steps=1"]),
    "winding": ("winding_lab", []),
    "design_map": (
        "design_map",
        ["design_map.mandrel_radius=[0.04]", "design_map.mandrel_thickness=[1.5e-3]", "mesh.axial=4",
         "design_map.softest=1e7"],
    ),
    "two_dof": (
        "two_dof_design_space",
        [
            "two_dof.omega.points=20", "two_dof.design_space.m2.points=2", "two_dof.design_space.k2.points=2",
            "two_dof.friction_capacity=[2, 10]",
        ],
    ),
    "sizing": ("sizing_sspp", ["mesh.axial=20", "sizing.reading=surface"]),
}  # fmt: skip
"""Case file and overrides, as coarse as they may be: only names are looked at."""

Produced = dict[str, tuple[xr.Dataset, dict]]


@pytest.fixture(scope="module")
def produced(tmp_path_factory: pytest.TempPathFactory) -> Produced:
    """Dataset and summary of each case; one of them through a run folder."""
    folder = tmp_path_factory.mktemp("names")
    found: Produced = {}
    with pytest.MonkeyPatch.context() as patch, keeping_structure():  # rolls with the same mesh share their matrices
        patch.setattr(mandrel_wall, "SAMPLES", 9)
        for name, (config, overrides) in CASES.items():
            out = folder / "run" if name == "winding" else None
            case = wf.load_case(CONFIGS / f"{config}.yaml", overrides)
            data = wf.run(case, out=out, progress=SilentProgress())
            found[name] = data, wf.summarise(data)
    data, _ = found["winding"]
    found["winding"] = data, json.loads(Path(folder / "run" / "summary.json").read_text(encoding="utf-8"))
    return found


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> list[wf.lab.LabResult]:
    """Result of the example of each kind of the laboratory; few frames of the images."""
    folder = tmp_path_factory.mktemp("measured")
    found = []
    for kind in KINDS:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(slip_example, "FRAMES", 150)
            files = example_files(kind, folder / kind)
        settings = folder / kind / "settings.yaml"
        found.append(wf.lab.evaluate(kind, files, settings_file=settings if settings.is_file() else None))
    return found


def test_every_name_of_the_summary_is_produced(produced: Produced, measured: list[wf.lab.LabResult]) -> None:
    names = {name for _, summary in produced.values() for name in summary}
    names |= {name for result in measured for name in result.summary}
    assert names == set(SUMMARY)


def test_every_field_is_produced(produced: Produced, measured: list[wf.lab.LabResult]) -> None:
    shear = run_shear_test(ShearTest(2, 100.0), steps=31)
    rates = shear_history(RateAndState(), *VelocitySteps(1e-6, 1e-5).history(points=3))
    dwell, sweep = produced["dwell"][0], produced["sweep"][0]
    derived = [slipping_area_fraction(dwell), magnitude(sweep), magnitude(sweep, "transmissibility_spectrum")]
    derived.append(magnitude(sweep, "down_transmissibility"))
    names = {str(name) for data in (shear, rates) for name in data.variables} | {str(array.name) for array in derived}
    names |= {str(name) for data, _ in produced.values() for name in data.variables}
    names |= {str(name) for result in measured for name in result.data.variables}
    assert names == set(FIELDS)


@pytest.mark.parametrize("name", MODULES)
def test_an_analysis_has_the_variables_that_the_registry_states(name: str, produced: Produced) -> None:
    data, summary = produced[name]
    assert summary["analysis"] == name
    for dims, variables in find_analysis(name).variables.items():
        for variable in variables:
            shown = ", ".join(map(str, data[variable].dims)).replace("branch_point", "frequency")
            assert shown == dims, variable
