"""Section `damping` in every analysis: peak of a linear roll in closed form, parts of zeta, loss factors."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import xarray as xr
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.harmonic import condensed_structure
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.case import Case, load_case
from wroll_fem.errors import InputError
from wroll_fem.progress import SilentProgress
from wroll_fem.results.energy import energy_balance_error

ZETA = 0.05
ONE = "harmonic={harmonics: 1, samples: 32}"
COARSE = ("mesh={circumferential: 8, axial: 2, grading: 1}", "output.figures=false", ONE)
LINEAR = (*COARSE, "coil.model=bonded", f"damping.modal={ZETA}")


def case(analysis: str, *overrides: str) -> Case:
    file = {"dwell": "lab_dwell", "backbone": "lab_backbone"}.get(analysis, "lab_harmonic")
    return load_case(CONFIGS / f"{file}.yaml", [f"analysis={analysis}", *overrides])


@cache
def linear_peak() -> xr.Dataset:
    return run_analysis(case("harmonic", *LINEAR, "excitation.f_end=200.0"), progress=SilentProgress())


def expected() -> float:
    """Height of the peak of the main mode alone; the other modes move in quadrature and add 1e-4 of it."""
    return float(linear_peak().attrs["tip_participation"]) / (2.0 * ZETA)


def test_harmonic_peak_is_participation_over_twice_the_ratio() -> None:
    attrs = summarise(linear_peak())
    assert attrs["peak_transmissibility"] == pytest.approx(expected(), rel=5e-3)
    assert attrs["zeta"] == pytest.approx(ZETA, rel=0.01)  # half power of a mode with 5 % is 0.8 % too high
    assert attrs["zeta_material"] == pytest.approx(attrs["zeta"], rel=1e-9)
    assert attrs["zeta_friction"] == pytest.approx(0.0, abs=1e-9)
    assert attrs["energy_balance_error"] < 1e-8


@pytest.mark.parametrize("ratio", [0.2, 0.4])
def test_a_peak_without_half_power_points_is_read_by_the_rational_fraction(ratio: float) -> None:
    band = (
        "mesh.axial=4",
        "harmonic={harmonics: 5, samples: 64}",
        "excitation.f_start=140.0",
        "excitation.f_end=185.0",
    )
    attrs = summarise(
        run_analysis(case("harmonic", *LINEAR, f"damping.modal={ratio}", *band), progress=SilentProgress())
    )
    assert np.isnan(attrs["half_power_low_hz"])
    assert attrs["zeta"] == pytest.approx(ratio, rel=5e-3)
    assert attrs["f_n_hz"] == pytest.approx(attrs["stuck_resonance_hz"], rel=2e-3)
    assert attrs["zeta_quality"] == "ok"
    assert "read by the rational fraction" in attrs["zeta_reason"]


def test_a_flank_alone_has_no_damping() -> None:
    """The band of a slipping roll ends on its peak: the fit of one linear mode is too poor."""
    band = ("excitation.f_start=140.0", "excitation.f_end=158.0")
    slipping = case("harmonic", *COARSE, "mesh.axial=4", "harmonic={harmonics: 3, samples: 64}", *band)
    attrs = summarise(run_analysis(slipping, progress=SilentProgress()))
    assert np.isnan(attrs["zeta"])
    assert "no half-power point" in attrs["half_power_reason"]


@pytest.mark.parametrize("method", ["reduced", "condensed", pytest.param("full", marks=pytest.mark.slow)])
def test_sweep_reaches_the_same_peak(method: str) -> None:
    """The rate is a fifth of the ISO 7626-2 limit."""
    f = linear_peak().attrs["stuck_resonance_hz"]
    band = f"f_start: {0.88 * f}, f_end: {1.08 * f}"
    chirp = f"excitation={{kind: chirp, amplitude: 5.0, {band}, rate_oct_per_min: 24}}"
    sweep = run_analysis(
        case("sweep", *LINEAR, chirp, f"solver.method={method}", "integrator.steps_per_cycle=80"),
        progress=SilentProgress(),
    )
    assert sweep.attrs["peak_transmissibility"] == pytest.approx(expected(), rel=5e-3)
    assert sweep.attrs["zeta_material"] == pytest.approx(sweep.attrs["zeta"], rel=1e-9)
    assert energy_balance_error(sweep) < 1e-8
    assert summarise(sweep)["material_damping_j"] > 0.9 * summarise(sweep)["input_work_j"]


@pytest.mark.parametrize("method", ["reduced", "condensed", pytest.param("full", marks=pytest.mark.slow)])
def test_dwell_settles_at_the_same_peak(method: str) -> None:
    f = linear_peak().attrs["stuck_resonance_hz"]
    dwell = f"excitation={{kind: dwell, amplitude: 5.0, frequency: {f}, cycles: 25, ramp_cycles: 2}}"
    history = run_analysis(
        case("dwell", *LINEAR, dwell, f"solver.method={method}", "integrator.steps_per_cycle=160"),
        progress=SilentProgress(),
    )
    assert history.attrs["steady_magnitude"] == pytest.approx(expected(), rel=5e-3)


def test_backbone_of_a_linear_roll_has_the_given_ratio_at_every_amplitude() -> None:
    curve = run_analysis(case("backbone", *LINEAR), progress=SilentProgress())
    np.testing.assert_allclose(curve["modal_damping"], ZETA, rtol=1e-6)
    assert curve.attrs["zeta_material"] == pytest.approx(ZETA, rel=1e-6)
    assert curve.attrs["zeta_friction"] == 0.0


@pytest.mark.parametrize("analysis", ["harmonic", "backbone"])
def test_material_and_friction_add_up(analysis: str) -> None:
    short = ["backbone.tip_largest=5e-5"] if analysis == "backbone" else []
    free = summarise(run_analysis(case(analysis, *COARSE, *short), progress=SilentProgress()))
    result = run_analysis(case(analysis, *COARSE, "damping.modal=0.01"), progress=SilentProgress())
    found = summarise(result)
    total = found["zeta" if analysis == "harmonic" else "zeta_max"]
    assert found["zeta_material"] + found["zeta_friction"] == pytest.approx(total, rel=1e-12)
    assert "zeta_material" not in free
    assert found["energy_balance_error"] < 1e-6
    if analysis == "backbone":
        np.testing.assert_allclose(result["material_modal_damping"][0], 0.01, rtol=1e-3)
        parts = result["material_modal_damping"] + result["friction_modal_damping"]
        np.testing.assert_allclose(parts, result["modal_damping"], rtol=1e-12)


@pytest.mark.parametrize("coil", [pytest.param("solid", marks=pytest.mark.slow), "bonded"])
def test_equal_loss_factors_give_half_of_them_as_damping_ratio(coil: str) -> None:
    """All modes of a solid coil; with layers the bond has no loss."""
    web = "material: {E: 2.8e9, nu: 0.35, rho: 2000}"
    overrides = [
        COARSE[0],
        f"coil={{model: {coil}, total_thickness: 1.25e-3, base: free, {web}}}",
    ]
    ratios = {}
    for name, factors in {
        "both": "{mandrel: 0.04, coil: 0.04}", "mandrel": "{mandrel: 0.04}", "coil": "{coil: 0.04}",
    }.items():  # fmt: skip
        one = case("harmonic", *overrides, f"damping.loss_factor={factors}")
        system, state = prepare(one, SilentProgress())
        c = condensed_structure(one, system, state, SilentProgress())
        main = int(np.argmax(np.abs(c.base * c.tip)))
        ratios[name] = np.concatenate(c.damping)[main] / (2.0 * np.sqrt(c.eigenvalues[main]))
    assert ratios["both"] == pytest.approx(0.02, rel=1e-6 if coil == "solid" else 0.01)
    assert ratios["mandrel"] + ratios["coil"] == pytest.approx(ratios["both"], rel=1e-6)
    assert 0.003 < ratios["coil"] < ratios["mandrel"]


@pytest.mark.parametrize("damping", ["modal=[0.01, 0.02]", "rayleigh.alpha=10", "loss_factor.mandrel=0.04"])
def test_modal_analysis_states_the_ratio_of_each_mode(damping: str) -> None:
    """The same ratios as those of the modes that harmonic balance and time histories use."""
    one = case("modal", *COARSE, "modal={count: 8, interface: stuck}", f"damping.{damping}")
    found = summarise(run_analysis(one, progress=SilentProgress()))
    system, state = prepare(case("harmonic", *COARSE, f"damping.{damping}"), SilentProgress())
    c = condensed_structure(one, system, state, SilentProgress())
    main = int(np.argmax(np.abs(c.base * c.tip)))
    rates = np.concatenate([part if part.ndim == 1 else np.diag(part) for part in c.damping])
    natural = float(np.sqrt(c.eigenvalues[main])) / (2.0 * np.pi)
    bending = int(np.argmin(np.abs(np.array(found["modes_hz"]) - natural)))
    assert found["modes_hz"][bending] == pytest.approx(natural, rel=2e-3)
    expected = 0.5 * rates[main] / np.sqrt(c.eigenvalues[main])
    assert found["mode_damping_ratios"][bending] == pytest.approx(expected, rel=5e-3)


def test_loss_factors_of_a_matrix_file_are_refused() -> None:
    with pytest.raises(InputError, match=r"damping\.loss_factor: needs a mandrel and a coil"):
        load_case(CONFIGS / "oscillator.yaml", ["damping.loss_factor.coil=0.1"])
