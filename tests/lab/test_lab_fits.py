"""Fits to families of resonances: the truth of synthetic rolls, intervals, and what the data do not determine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from scipy.interpolate import CubicSpline
from scipy.stats import binom

import wroll_fem as wf
from wroll_fem.errors import InputError
from wroll_fem.lab.examples import example_files
from wroll_fem.lab.fits import synthetic_roll as roll
from wroll_fem.lab.fits.backbone_fit import BackboneSettings, fit_backbones, predicted, read_backbones
from wroll_fem.lab.fits.family_file import read_families
from wroll_fem.numerics.identifiability import uncertainty
from wroll_fem.results.dataset import save_dataset
from wroll_fem.signals.estimators import estimate_damping
from wroll_fem.two_dof import Measured, PeriodicSolver, TwoMasses, fit_curves

ERRORS = {"frequency": 0.002, "level": 0.03}


@pytest.fixture(scope="module")
def grid_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("grid")
    roll.write_backbones(folder)
    return folder


def family(folder: Path, seed: int) -> list:
    return read_families([save_dataset(roll.measured_family(seed, **ERRORS), folder / f"{seed}.nc")])


def misses(grid_folder: Path, folder: Path, repetitions: int) -> np.ndarray:
    """Repetitions in which mu p of both rolls, and the elastic slip, lie outside their 95 % intervals."""
    grid = read_backbones(grid_folder)
    settings = BackboneSettings(grid="", level_error=ERRORS["level"], frequency_error=0.0)
    truth = np.array([*roll.TRUTH.values(), roll.TRUE_SLIP])
    found = np.zeros(3, int)
    for seed in range(repetitions):
        fit = fit_backbones(family(folder, seed), grid, settings)
        low, high = np.append(fit.friction_low, fit.slip_low), np.append(fit.friction_high, fit.slip_high)
        found += (truth < low) | (truth > high)
    return found


def test_friction_and_elastic_slip_of_the_example_are_found(tmp_path: Path) -> None:
    files = example_files("fit", tmp_path / "example")
    found = wf.lab.evaluate("fit", files, settings_file=tmp_path / "example" / "settings.yaml")
    low, high, value = (found.summary[name] for name in ("parameters_low", "parameters_high", "parameters"))
    for tension, truth in roll.TRUTH.items():
        name = f"mu_p_{tension:g}_newton_pa"
        assert low[name] < truth < high[name]
        assert value[name] == pytest.approx(truth, rel=0.1)
    assert low["elastic_slip_m"] < roll.TRUE_SLIP < high["elastic_slip_m"]
    assert found.summary["undetermined"] == []
    mu = wf.lab.evaluate(
        "fit", files, settings_file=tmp_path / "example" / "settings.yaml", **{"model.pressure": [4.8e4, 1.6e5]}
    )
    assert mu.summary["parameters"]["mu_20_newton"] == pytest.approx(value["mu_p_20_newton_pa"] / 4.8e4)


def test_backbones_scale_with_the_elastic_slip(grid_folder: Path) -> None:
    grid = read_backbones(grid_folder)
    amplitude = np.geomspace(1.6e-7, 9e-5, 9)  # none at the onset of sliding itself
    for factor in (0.1, 1.0, 20.0):
        f, base = predicted(grid, grid[2].stick, factor * grid[2].slip, amplitude)
        exact = roll.jenkins_backbone(amplitude, factor * roll.MU * roll.PRESSURES[2], factor * roll.SLIP)
        np.testing.assert_allclose(np.exp(f), exact[0], rtol=5e-4)  # 160 points over five decades, at a kink
        np.testing.assert_allclose(np.exp(base), exact[1], rtol=5e-3)


def test_the_truth_lies_inside_the_intervals_of_the_roll(grid_folder: Path, tmp_path: Path) -> None:
    assert misses(grid_folder, tmp_path, 4).max() <= binom.ppf(0.98, 4, 0.05)  # 1 of 4


@pytest.mark.slow
def test_the_truth_lies_inside_the_intervals_of_90_to_99_of_100_rolls(grid_folder: Path, tmp_path: Path) -> None:
    found = misses(grid_folder, tmp_path, 100)
    assert found.max() <= 10
    assert found.sum() >= 1


def test_levels_without_sliding_leave_the_product_undetermined(grid_folder: Path, tmp_path: Path) -> None:
    data = roll.measured_family(3).isel(condition=[0, 1])
    quiet = data.assign(base_level=1e-3 * data["base_level"])  # same peaks: all motions stick
    path = save_dataset(quiet, tmp_path / "results.nc")
    found = wf.lab.evaluate("fit", [path], model={"kind": "backbones", "grid": str(grid_folder)})
    assert any("the data do not determine" in text for text in found.summary["undetermined"])
    assert any("the data do not determine" in text for text in found.warnings)


def test_an_interval_of_a_line_is_that_of_the_textbook() -> None:
    rng = np.random.default_rng(4)
    t = np.linspace(0.0, 1.0, 30)
    matrix = np.stack([np.ones_like(t), t], axis=1)
    y = matrix @ np.array([0.3, 0.7]) + 0.05 * rng.standard_normal(t.size)
    x, rest, *_ = np.linalg.lstsq(matrix, y, rcond=None)
    found = uncertainty(("a", "b"), x, matrix, matrix @ x - y)
    slope = np.sqrt(rest[0] / 28.0 / np.sum((t - t.mean()) ** 2))
    assert found.errors[1] == pytest.approx(slope, rel=1e-9)
    assert np.log(found.high[1]) - x[1] == pytest.approx(2.0484 * slope, rel=1e-4)  # Student, 28 degrees of freedom
    assert found.undetermined == ()
    twins = uncertainty(("a", "b"), x, np.stack([t, 1.0001 * t], axis=1), 0.05 * np.ones(30))
    assert "a common change of" in twins.undetermined[0]
    assert "(power -1)" in twins.undetermined[0]


OMEGA = np.linspace(0.85, 1.3, 10)


def two_mass_misses(repetitions: int) -> np.ndarray:
    """Repetitions in which k2 and the capacity lie outside their intervals, with 2 % noise on a curve."""
    truth, capacity = (
        TwoMasses(m2=0.5, k2=0.8, c1=0.03, base_amplitude=1.0, preload_dependent=False, smoothing=3.0),
        2.0,
    )
    exact = [one.transmissibility for one in PeriodicSolver(truth.preloaded(capacity)).curve(OMEGA)]
    found = np.zeros(2, int)
    for seed in range(repetitions):
        noise = np.exp(0.02 * np.random.default_rng(seed).standard_normal(OMEGA.size))
        fit = fit_curves(
            [Measured(OMEGA, np.array(exact) * noise, capacity)], {"k2": (0.4, 1.6)}, model=truth,
            capacity_bounds=(0.8, 6.0), starts=1, workers=1,
        )  # fmt: skip
        sure = fit.uncertainty
        found += (np.array([0.8, capacity]) < sure.low) | (np.array([0.8, capacity]) > sure.high)
    return found


@pytest.mark.slow
def test_the_truth_lies_inside_the_intervals_of_two_masses() -> None:
    assert two_mass_misses(100).max() <= 10


TWO_MASSES = TwoMasses(
    m2=0.5, k2=0.8, c1=0.03, c2=0.002, base_amplitude=1.0, preload_dependent=False, smoothing=3.0
)  # fmt: skip
MODEL = {
    "kind": "two_masses", "primary_hz": 130.0, "primary_mass": 0.4, "mass_ratio": 0.5, "zeta_primary": 0.015,
    "stiffness_ratio": [0.5, 1.3], "capacity": [0.8, 5.0], "points": 8, "starts": 1,
}  # fmt: skip


def check_two_masses(folder: Path, model: dict, amplitudes: tuple[float, ...], tolerance: float) -> None:
    path = save_dataset(two_mass_family(TWO_MASSES, 2.0, amplitudes), folder / "results.nc")
    found = wf.lab.evaluate("fit", [path], model=model)
    value = found.summary["parameters"]
    unit = 0.4 * (2.0 * np.pi * 130.0) ** 2 * read_families([path])[0].base_amplitude
    assert value["stiffness_ratio"] == pytest.approx(0.8, rel=tolerance)
    assert value.get("mass_ratio", 0.5) == pytest.approx(0.5, rel=tolerance)
    assert value["capacity_20_newton_n"] == pytest.approx(2.0 * unit, rel=tolerance)
    assert set(np.unique(found.data["datum_quantity"].values)) == {"transmissibility"}
    np.testing.assert_allclose(found.data["fit_computed"], found.data["fit_measured"], rtol=0.05)


def test_curves_that_stick_give_the_stiffness_of_two_masses_but_not_the_capacity(tmp_path: Path) -> None:
    path = save_dataset(two_mass_family(TWO_MASSES, 30.0, (1.0,)), tmp_path / "results.nc")
    found = wf.lab.evaluate("fit", [path], model=MODEL | {"capacity": [15.0, 60.0], "points": 6})
    assert found.summary["parameters"]["stiffness_ratio"] == pytest.approx(0.8, rel=0.01)  # of an interpolated curve
    np.testing.assert_allclose(found.data["fit_computed"], found.data["fit_measured"], rtol=0.05)
    assert set(np.unique(found.data["datum_quantity"].values)) == {"transmissibility"}


@pytest.mark.slow
def test_stiffness_and_capacity_of_two_masses_are_fitted_from_sweeps(tmp_path: Path) -> None:
    check_two_masses(tmp_path, MODEL, (1.0,), 0.01)  # the curve is interpolated between 60 frequencies


@pytest.mark.slow
def test_all_parameters_of_two_masses_are_fitted_from_sweeps(tmp_path: Path) -> None:
    more = {"mass_ratio": [0.3, 0.8], "zeta_primary": [0.01, 0.03], "points": 12}
    check_two_masses(tmp_path, MODEL | more, (1.0, 0.5), 0.05)


def two_mass_family(truth: TwoMasses, capacity: float, amplitudes: tuple[float, ...]) -> xr.Dataset:
    """Sweeps of one roll with several base amplitudes, as `transmissibility` writes them."""
    omega = np.linspace(0.85, 1.3, 60)
    f, fine = 130.0 * omega, np.linspace(110.5, 169.0, 400)
    rows, curves = [], []
    for amplitude in amplitudes:
        model = TwoMasses(**{**truth.__dict__, "base_amplitude": amplitude})
        size = np.array([one.transmissibility for one in PeriodicSolver(model.preloaded(capacity)).curve(omega)])
        smooth = np.exp(CubicSpline(f, np.log(size))(fine))
        read = estimate_damping(fine, smooth)
        level = amplitude * 1e-5 * (2.0 * np.pi * read.damping.f_n) ** 2
        rows.append((20.0, level, read.damping.f_n, 0.1, read.damping.zeta, read.shape.peak))
        curves.append(smooth)
    names = ("tension", "base_level", "condition_f_n", "condition_f_n_interval", "condition_zeta", "condition_peak")
    data = {name: ("condition", np.array(values)) for name, values in zip(names, zip(*rows, strict=True), strict=True)}
    axes = ("condition", "frequency")
    data |= {"condition_name": ("condition", np.array([f"{amplitude:g}" for amplitude in amplitudes]))}
    data |= {"family_real": (axes, np.array(curves)), "family_imag": (axes, np.zeros((len(amplitudes), fine.size)))}
    return xr.Dataset(data, coords={"frequency": fine}, attrs={"method": "sweep"})


def test_wrong_fits_are_refused_in_one_line(grid_folder: Path, tmp_path: Path) -> None:
    path = save_dataset(roll.measured_family(), tmp_path / "results.nc")
    other = tmp_path / "table.csv"
    other.write_text("f,T\n1,2\n", encoding="utf-8")
    good = {"kind": "backbones", "grid": str(grid_folder)}
    for files, model, message in (
        ([path], {"grid": "x"}, "model.kind: required key is missing; add it"),
        ([path], {"kind": "two_masses"}, "model.primary_hz: required key is missing"),
        ([path], good | {"grid": str(tmp_path / "none")}, "0 backbones with different stick stiffness"),
        ([path], good | {"pressure": [1.0]}, "1 pressures for 2 rolls"),
        ([path], {"kind": "two_masses", "primary_hz": 100.0, "capacity": [3.0, 1.0]}, "in ascending order"),
        ([other], good, "is no results.nc; evaluate the records first"),
        ([next(grid_folder.rglob("*.nc"))], good, "has no family of curves"),
    ):
        with pytest.raises(InputError) as caught:
            wf.lab.evaluate("fit", files, model=model)
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)


def test_a_relative_grid_is_taken_from_the_settings_file(tmp_path: Path) -> None:
    files = example_files("fit", tmp_path / "example")
    other = tmp_path / "other.yaml"
    other.write_text(yaml.safe_dump({"model": {"kind": "backbones", "grid": "example/backbones"}}), encoding="utf-8")
    found = wf.lab.evaluate("fit", files, settings_file=other)
    assert found.settings is not None
    assert found.summary["fit_model"] == "backbones"


@pytest.mark.parametrize("name", ["family_imag", "condition_f_n", "tension"])
def test_results_without_a_variable_are_no_family(name: str, tmp_path: Path) -> None:
    path = save_dataset(roll.measured_family().drop_vars(name), tmp_path / "results.nc")
    with pytest.raises(InputError, match=f"has no family of curves \\({name} is missing\\)"):
        read_families([path])
