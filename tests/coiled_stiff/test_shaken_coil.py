"""Coil whose wraps slide in harmonic, backbone and dwell, from the case file; the modes are those of its path."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from scipy.constants import g as GRAVITY
from support.interrupted import interrupted
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses import run_analysis, slip_modes, slip_path
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.analyses.slip_modes import path_span
from wroll_fem.case import load_case
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.path_span.span import ModalMotion, PathSpan
from wroll_fem.dynamics.periodic.response import response_curve
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.dynamics.training import correction as corrections
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.errors import InputError
from wroll_fem.progress import SilentProgress
from wroll_fem.results.energy import energy_balance_error

CASE = CONFIGS / "slipping_harmonic.yaml"
MESH = "mesh={circumferential: 8, axial: 6, grading: 12, radial: 1}"
LEVEL = 10.0  # g
BAND = ("excitation.f_start=78", "excitation.f_end=100", f"excitation.amplitude_g={LEVEL}")
BACKBONE = "backbone={tip_smallest: 3.0e-4, tip_largest: 4.0e-3}"


def shaken(analysis: str, *changes: str) -> xr.Dataset:
    case = load_case(CASE, [MESH, f"analysis={analysis}", *changes])
    return wf.run(case, progress=False)


@cache
def quasi_static() -> xr.Dataset:
    case = load_case(CONFIGS / "slipping_coil.yaml", [MESH, f"excitation.amplitude_g=[5, {LEVEL}]"])
    return wf.run(case, progress=False)


@cache
def curve() -> xr.Dataset:
    return shaken("harmonic", *BAND)


def test_the_curve_has_the_response_of_the_quasi_static_path() -> None:
    found, expected = curve(), quasi_static().sel(amplitude_g=LEVEL)
    peak = int(found["tip_amplitude"].values.argmax())
    assert float(found["tip_amplitude"][peak]) == pytest.approx(float(expected["tip_at_level"]), rel=0.015)
    assert float(found["frequency"][peak]) == pytest.approx(float(expected["frequency_at_level"]), rel=4e-3)
    friction = float(found["friction_work_per_cycle"][peak])
    assert friction == pytest.approx(float(expected["friction_work_at_level"]), rel=0.03)
    assert found.attrs["energy_balance_error"] < 1e-6
    assert 0.0 < found.attrs["span_error_estimate"] < 5e-3


@pytest.mark.slow
def test_the_backbone_is_that_of_the_quasi_static_path() -> None:
    found, path = shaken("backbone", BACKBONE), quasi_static()
    for tip in (1e-3, 2e-3, 3e-3):
        frequency, zeta = (
            [float(np.interp(tip, data["tip_amplitude"], data[name])) for data in (found, path)]
            for name in ("resonance_frequency", "modal_damping")
        )
        assert frequency[0] == pytest.approx(frequency[1], rel=2e-3)
        assert zeta[0] == pytest.approx(zeta[1], rel=0.015)
    assert found.attrs["span_error_estimate"] < 1e-2


def test_a_dwell_has_the_magnitude_of_the_curve_and_closes_its_energy() -> None:
    peak = float(curve()["frequency"][int(curve()["tip_amplitude"].values.argmax())])
    motion = f"excitation={{kind: dwell, frequency: {peak:.4f}, amplitude_g: {LEVEL}, cycles: 45, ramp_cycles: 8}}"
    with pytest.warns(UserWarning, match="steady_residual"):  # the acceleration has harmonics of the friction
        found = shaken("dwell", motion)
    height = float(np.abs(curve()["transmissibility_real"] + 1j * curve()["transmissibility_imag"]).max())
    assert found.attrs["steady_magnitude"] == pytest.approx(height, rel=0.015)
    assert energy_balance_error(found) < 1e-3
    assert 0.0 < found.attrs["span_error_estimate"] < 2e-2


def test_a_dwell_goes_on_bit_by_bit_with_what_it_has_seen_of_its_span(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = f"excitation={{kind: dwell, frequency: 88, amplitude_g: {LEVEL}, cycles: 8, ramp_cycles: 4}}"
    coarse = "mesh={circumferential: 8, axial: 4, grading: 8, radial: 1}"
    case = load_case(CASE, [coarse, "analysis=dwell", motion, "integrator={scheme: hht, steps_per_cycle: 60}"])
    whole, file = run_analysis(case, progress=SilentProgress()), tmp_path / "run.ckpt"
    with interrupted(monkeypatch, ReducedStepper, 3):
        run_analysis(case, progress=SilentProgress(), checkpoint=file)
    again = run_analysis(case, progress=SilentProgress(), checkpoint=file, resume=True)
    np.testing.assert_array_equal(again["tip_displacement"].values, whole["tip_displacement"].values)
    assert again.attrs["span_error_estimate"] == whole.attrs["span_error_estimate"]


def test_slip_is_that_between_two_wraps() -> None:
    """The work per area of all interfaces in the coil is the friction work; twice as thick wraps slip twice as far."""
    found = curve()
    work = float((found["friction_work_density"] * found["area"]).sum())
    peak = int(np.abs(found["transmissibility_real"] + 1j * found["transmissibility_imag"]).argmax())
    assert work == pytest.approx(float(found["friction_work_per_cycle"][peak]), rel=1e-3)
    thick = shaken(
        "harmonic", *BAND, "winding.wrap_thickness=1.0e-4", "winding.wraps=150",
        "winding.tension_stress=40.0e6",
    )  # fmt: skip
    assert float(thick["cumulative_slip"].max()) == pytest.approx(2.0 * float(found["cumulative_slip"].max()), rel=0.02)
    assert float(thick["area"].sum()) == pytest.approx(0.5 * float(found["area"].sum()), rel=1e-9)


@pytest.mark.slow
def test_a_span_of_a_short_path_is_enlarged_to_the_same_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slip_path, "MOST_LEVELS", 4)
    monkeypatch.setattr(slip_modes, "ROUNDS", 8)
    found = shaken("harmonic", *BAND)
    heights = [float(data["tip_amplitude"].max()) for data in (found, curve())]
    assert heights[0] == pytest.approx(heights[1], rel=5e-3)
    assert found.attrs["span_error_estimate"] < 5e-3


def test_what_a_motion_lacks_is_told_and_a_static_state_lacks_nothing() -> None:
    """A static stuck response under a load outside the span lacks its part outside the span, exactly."""
    case = load_case(CASE, [MESH])
    system, state = prepare(case, SilentProgress())
    span: PathSpan = path_span(case, system, state, SilentProgress())
    path, modes = span.path, span.modes
    (_, vectors), *_ = modes.vectors
    none = np.zeros((3 * system.n_points, 1))
    inertia = system.mass @ system.influence
    response = path.stuck(-inertia)
    q = (vectors.T @ (system.mass @ response))[:, None]
    rest = np.zeros_like(q)
    _, share = span.lacking(ModalMotion(q, rest, rest, none, np.ones(1)))
    assert share < 1e-5  # the response to the base is in the span
    row = np.zeros(system.n_dofs)
    row[system.n_dofs // 2] = 1.0
    outside = path.stuck(row)
    outside = outside - vectors @ (vectors.T @ (system.mass @ outside))
    inside = (vectors.T @ (system.mass @ path.stuck(row)))[:, None]
    shapes, _ = span.lacking(ModalMotion(inside, rest, rest, none, np.zeros(1)))
    left = row - path.stiffness @ (vectors @ inside[:, 0])  # the load is not part of the motion: add it here
    np.testing.assert_allclose(path.stuck(row) + shapes[:, 0], path.stuck(left), atol=1e-9 * np.abs(outside).max())
    size = len(modes.eigenvalues)
    span.enlarge(outside[:, None], 0.0)
    assert len(span.modes.eigenvalues) == size + 1


def test_corrections_by_the_modes_are_those_by_the_jumps(monkeypatch: pytest.MonkeyPatch) -> None:
    case = load_case(CASE, [MESH])
    system, state = prepare(case, SilentProgress())
    modes = path_span(case, system, state, SilentProgress()).modes
    structure = Structure.of(modes, state, system.laws, Sampling(3, 64), 8)
    points = response_curve(structure.contact(structure.first_model()), amplitude=98.0, frequencies=(80.0, 100.0))
    for k in range(0, len(points.frequencies), 7):
        pair = []
        for limit in (2000, 0):
            monkeypatch.setattr(corrections, "DIRECT", limit)
            pair.append(corrections.correction(points.balance, points.coefficients[k], float(points.frequencies[k])))
        assert pair[0].energy == pytest.approx(pair[1].energy, rel=1e-3)
        np.testing.assert_allclose(pair[0].modal, pair[1].modal, atol=1e-3 * np.abs(pair[1].modal).max())


def test_the_figure_shows_the_slip_between_the_wraps() -> None:
    ax = wf.plot.wrap_slip(curve())
    assert "Wraps slide in" in ax.get_title(loc="left")
    assert "per period" in ax.get_title(loc="left")
    plt.close("all")
    for other in (quasi_static(), xr.Dataset({"cumulative_slip": (("interface", "point"), np.zeros((1, 3)))})):
        with pytest.raises(InputError, match="no slip between wraps"):
            wf.plot.wrap_slip(other)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (("coil.pressure=varying",), "coil.pressure"),
        (("damping={loss_factor: {coil: 0.02}}",), "damping.loss_factor"),
        (("winding.mu=0",), "winding.mu"),
        (("analysis=modal",), "coil.inside"),
        (("analysis=dwell", "solver.method=condensed"), "solver.method"),
    ],
)
def test_what_a_shaken_coil_cannot_have_is_refused_in_one_line(changes: tuple[str, ...], words: str) -> None:
    dwell = ("excitation={kind: dwell, frequency: 88, amplitude_g: 5, cycles: 8}",) if "dwell" in changes[0] else ()
    with pytest.raises(InputError, match=words) as told:
        load_case(CASE, [*changes, *dwell])
    assert "\n" not in str(told.value)


def test_levels_are_in_g_of_the_case() -> None:
    assert load_case(CASE).excitation.amplitude == pytest.approx(15.0 * GRAVITY)  # type: ignore[union-attr]
