"""Claims on the double shear test of preloaded stacks: C119 to C121 (appendix E.3)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.verdict import THESIS_ERROR, Verdict
from reproduction.words import numbers
from wroll_fem.plotting.lab import plot_shear_tests
from wroll_fem.tribology import ShearTest, run_shear_test

LAYERS = (50, 100)
"""Numbers of loose layers in a stack; it has one more interface than layers."""
PRESSURES = (25e3, 50e3, 100e3, 150e3, 200e3, 300e3)
"""Pressures F_N/A, Pa."""
RIGID = 1.0e6
"""Ratio of the stick stiffness to the stiffness of the layers in the check of a solid block."""


def tests(evidence: Evidence) -> list[xr.Dataset]:
    """Tests of both stacks at every pressure."""
    inputs = [{"layers": n, "pressure": p} for n in LAYERS for p in PRESSURES]
    return evidence.kept_each("shear_test", one_test, inputs)


def one_test(layers: int, pressure: float) -> xr.Dataset:
    """Test of a stack at a pressure (Pa), with mu and gamma* of the lab roll."""
    return run_shear_test(ShearTest(layers + 1, pressure * ShearTest.area))


def readings(evidence: Evidence, name: str) -> np.ndarray:
    """(n_layers, n_pressures) values of an attribute of the tests."""
    return np.reshape([float(data.attrs[name]) for data in tests(evidence)], (len(LAYERS), len(PRESSURES)))


def fit(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope of the fitted straight line, and R^2."""
    slope, offset = np.polyfit(x, y, 1)
    rest = y - slope * x - offset
    return float(slope), float(1.0 - rest @ rest / np.sum((y - y.mean()) ** 2))


def c119(evidence: Evidence) -> Verdict:
    capacity, force = readings(evidence, "shear_capacity_n"), np.array(PRESSURES) * ShearTest.area
    slope, quality = zip(*(fit(force, line) for line in capacity), strict=True)
    apart = float(np.abs(capacity[1] / capacity[0] - 1.0).max())
    wanted = 2.0 * ShearTest.mu
    off = max(abs(one / wanted - 1.0) for one in slope)
    value = (
        f"stacks of {LAYERS[0]} and {LAYERS[1]} layers ({LAYERS[0] + 1} and {LAYERS[1] + 1} interfaces), "
        f"{numbers((1e-3 * p for p in PRESSURES), 'g')} kPa: F_c = {numbers(capacity[0], '.1f')} N; dF_c/dF_N = "
        f"{numbers(slope, '.4f')} (2 mu = {wanted:g}), 1 - R^2 below {max(1e-15, 1 - min(quality)):.0e}; stacks "
        f"{apart:.0e} apart; model consistent (mu and the law are put in), no evidence on Kapton"
    )
    return Verdict(value, min(quality) > 0.999 and apart < 0.01 and off < 0.01)


def c120(evidence: Evidence) -> Verdict:
    stiffness, modulus = readings(evidence, "shear_stiffness_n_m"), readings(evidence, "shear_modulus_pa")
    interfaces = np.array(LAYERS) + 1.0
    by_pressure = stiffness / np.array(PRESSURES)
    with_pressure = float(np.ptp(by_pressure, axis=1).max() / by_pressure.min())
    product = stiffness * interfaces[:, None]
    with_count = float(np.abs(product[1] / product[0] - 1.0).max())
    value = (
        f"K = {numbers(1e-3 * stiffness[0], '.0f')} N/mm ({LAYERS[0]} layers), {numbers(1e-3 * stiffness[1], '.0f')} "
        f"({LAYERS[1]}); K/p constant to {100 * with_pressure:.2f} %, K times interfaces to {100 * with_count:.3f} % "
        f"(the rest is the layers' own shear); G = {1e-6 * modulus.min():.2f} to {1e-6 * modulus.max():.1f} MPa with "
        f"gamma* = {1e6 * ShearTest.elastic_slip:g} um, the same for both stacks to "
        f"{100 * np.abs(modulus[1] / modulus[0] - 1).max():.2f} % (printed: up to about 10 MPa, rising with the "
        "layers, which springs in series cannot do); model consistent, no evidence on Kapton"
    )
    return Verdict(value, with_pressure < 0.01 and with_count < 0.01)


def c121(evidence: Evidence) -> Verdict:
    layers, solid = 50, ShearTest(50, 1.0)
    own = solid.layer_shear_modulus
    # friction far stiffer than the layers: the stack is a block of n - 1 layers of the film itself
    slip = solid.mu * 100e3 * solid.layer_thickness / (RIGID * own)
    test = ShearTest(layers + 1, 100e3 * solid.area, elastic_slip=slip, machine_stiffness=1e12)
    stiffness = float(run_shear_test(test).attrs["shear_stiffness_n_m"])
    block = layers * solid.layer_thickness
    two, one = stiffness * block / (2.0 * solid.area) / own, stiffness * block / solid.area / own
    value = (
        f"a block of {layers} bonded layers: G = F t/(2 A dy) gives {two:.5f} of its modulus, F t/(A dy) as in E.3 "
        f"with the whole force {one:.5f}; K_s = 2 G A/t; E.5's mu = F_c/(2 F_N) has the factor"
    )
    holds = abs(two - 1.0) < 1e-3
    return Verdict(value, holds, THESIS_ERROR if holds else "")


def plot(evidence: Evidence) -> Axes:
    """Draw Figs. E.6 to E.9."""
    return plot_shear_tests(tests(evidence))


GROUP = ClaimGroup(
    {"C119": c119, "C120": c120, "C121": c121},
    figures={
        "shear_tests": ("Figs E.6 to E.9: double shear test of stacks of 50 and 100 layers over the preload", plot)
    },
)
