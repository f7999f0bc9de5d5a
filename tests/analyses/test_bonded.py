"""`coil.model: bonded` in every analysis: linear, at the bonded frequency, without friction; tip of a layered roll."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import xarray as xr
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.case import Case, load_case
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.transmissibility import magnitude

COARSE = ("mesh={circumferential: 8, axial: 4, grading: 1}", "coil.model=bonded", "output.figures=false")
ONE = "harmonic={harmonics: 1, samples: 32}"


def bonded(analysis: str, *overrides: str) -> Case:
    file = {"modal": "lab_modal", "dwell": "lab_dwell"}.get(analysis, "lab_harmonic")
    return load_case(CONFIGS / f"{file}.yaml", [*COARSE, f"analysis={analysis}", *overrides])


@cache
def modes() -> xr.Dataset:
    return run_analysis(bonded("modal"), progress=SilentProgress())


def first() -> float:
    return float(summarise(modes())["bending_hz"])


def test_periodic_motion_is_the_sum_of_the_bonded_modes() -> None:
    f_n = first()
    band = [f"excitation.f_start={0.9 * f_n}", f"excitation.f_end={0.99 * f_n}", "modal.interface=frictionless"]
    result = run_analysis(bonded("harmonic", ONE, *band), progress=SilentProgress())
    f = result["frequency"].values[:, None]
    share, natural = modes()["tip_participation"].values, modes()["mode_frequency"].values
    expected = np.abs(1.0 + (share * f**2 / (natural**2 - f**2)).sum(axis=1))
    # twelve modes of the whole roll; those above add 2e-4 of the base motion, the transmissibility is 5 to 50
    np.testing.assert_allclose(magnitude(result).values, expected, rtol=2e-3)
    assert "cumulative_slip" not in result
    for name in ("friction_work_per_cycle", "modulation_work_per_cycle", "material_damping_work_per_cycle"):
        assert not result[name].values.any()


@pytest.mark.parametrize("method", ["reduced", "condensed", pytest.param("full", marks=pytest.mark.slow)])
def test_a_time_history_is_that_of_the_bonded_modes_and_has_no_friction(method: str) -> None:
    f_n = first()
    f = 0.8 * f_n
    dwell = [
        f"excitation={{kind: dwell, frequency: {f}, amplitude: 5.0, cycles: 5, ramp_cycles: 0}}",
        "integrator.steps_per_cycle=160",
    ]
    case = bonded("dwell", *dwell, f"solver.method={method}", "integrator.alpha=-0.01")
    result = run_analysis(case, progress=SilentProgress())
    t, w = result["time"].values, 2 * np.pi * f
    share, natural = modes()["tip_participation"].values, 2 * np.pi * modes()["mode_frequency"].values
    base = result["base_acceleration"].values
    phase = np.arcsin(np.clip(base[1] / 5.0, -1, 1)) - w * t[1]  # of the program's sine
    forced = np.sin(w * t + phase)
    free = [np.sin(phase) * np.cos(v * t) + w / v * np.cos(phase) * np.sin(v * t) for v in natural]
    expected = sum(-p * 5.0 / (v**2 - w**2) * (forced - h) for p, v, h in zip(share, natural, free, strict=True))
    tip = result["tip_displacement"].values
    # 160 steps per cycle lengthen the period by 1.3e-4
    np.testing.assert_allclose(tip, expected, atol=0.01 * np.abs(tip).max())
    last = summarise(result)
    assert last["friction_energy_j"] == 0.0
    assert last["energy_balance_error"] < 1e-6
    assert "interface_pressure_mean_pa" not in last


def test_bonded_layers_need_neither_contact_nor_a_normal_penalty_of_the_case() -> None:
    text = bonded("dwell", "mesh.axial=2").resolved()
    soft = text | {"contact": text["contact"] | {"normal": {"penalty": 1e3, "separation": True}}}
    without = {key: value for key, value in text.items() if key not in ("contact", "preload")}
    systems = [prepare(Case.model_validate(data), SilentProgress())[0] for data in (text, soft, without)]
    for system in systems:
        assert system.interfaces == ()
        assert abs(system.stiffness - systems[0].stiffness).max() == 0.0


@pytest.mark.parametrize("layers", [1, 3])
def test_the_tip_of_a_layered_roll_is_the_tip_of_its_mandrel(layers: int) -> None:
    case = load_case(
        CONFIGS / "lab_dwell.yaml", ["mesh={circumferential: 8, axial: 4, grading: 1}", f"coil.layers={layers}"]
    )
    bodies = build_bodies(case)
    system = build_system(case, bodies)
    assert len(bodies) == layers + 1
    row = system.probes["tip"]
    centre = np.asarray(bodies[0].probes["tip"].todense())[0]
    np.testing.assert_array_equal(row, np.concatenate([centre, np.zeros(system.n_dofs - bodies[0].n_dofs)]))
    assert np.count_nonzero(row) == 1  # the centre of the rigid cap


def test_a_mesh_that_misses_the_bonded_frequency_is_named_and_a_fine_one_is_not() -> None:
    class Listener(SilentProgress):
        def __init__(self) -> None:
            super().__init__()
            self.told: list[str] = []

        def warning(self, message: str) -> None:
            self.told.append(message)

    motion = "excitation={kind: dwell, frequency: 60, amplitude: 1.0, cycles: 1, ramp_cycles: 0}"
    for mesh, warned in (
        ("{circumferential: 8, axial: 6, grading: 1, radial_grading: 1}", True),
        ("{circumferential: 8, axial: 8}", False),
    ):
        case = load_case(CONFIGS / "coiled_stiff.yaml", ["analysis=dwell", motion, f"mesh={mesh}"])
        listener = Listener()
        prepare(case, listener)
        assert len(listener.told) == warned
        if warned:
            assert listener.told[0].startswith("the mesh does not resolve the modes: bending mode 1 has 1")
            assert "mesh.radial_grading" in listener.told[0]
