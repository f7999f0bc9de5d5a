"""Supports and tip bodies of a mandrel: shells and Fourier elements against beams, limits, and base loads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.forecasts.closed_forms import beam_frequency
from wroll_fem.bodies.beam_modes import SprungBeam
from wroll_fem.bodies.rigid_ends import rigid_mass, spring_matrix
from wroll_fem.case.loader import build_case, load_case
from wroll_fem.progress import SilentProgress
from wroll_fem.results.energy import energy_balance_error

E, NU, RHO = 7.0e10, 0.33, 2700.0
LENGTH, DIAMETER, WALL = 1.2, 0.06, 1.5e-3
"""A slender tube, so that a beam describes it."""

RADIUS = 0.5 * (DIAMETER - WALL)
AREA = 2.0 * np.pi * RADIUS * WALL
SECOND = np.pi * RADIUS**3 * WALL
PLANE = np.ix_([0, 4], [0, 4])


def tube(**mandrel: Any) -> dict[str, Any]:
    return {
        "analysis": "modal",
        "geometry": {"length": LENGTH, "mandrel_outer_diameter": DIAMETER, "mandrel_thickness": WALL},
        "mandrel": {"material": {"E": E, "nu": NU, "rho": RHO}} | mandrel,
        "coil": {"model": "none"},
        "mesh": {"circumferential": 8, "axial": 8, "grading": 1},
        "modal": {"count": 8},
        "output": {"figures": False},
    }


def bending(case: dict[str, Any]) -> list[float]:
    """Frequencies of the first two pairs of bending modes, Hz."""
    data = run_analysis(build_case(case), progress=SilentProgress())
    kinds = data["mode_kind"].values
    found = [float(f) for f, kind in zip(data["mode_frequency"].values, kinds, strict=True) if kind == "bending"]
    return [found[0], found[2]]


def beam(
    base: tuple[float | None, float | None], springs: tuple[float, float] = (0.0, 0.0),
    body: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> SprungBeam:  # fmt: skip
    """Thin tube with the shear factor of its material (Cowper 1966)."""
    factor = 2.0 * (1.0 + NU) / (4.0 + 3.0 * NU)
    shear = factor * E / (2.0 * (1.0 + NU)) * AREA
    return SprungBeam(
        LENGTH, E * SECOND, shear, RHO * AREA, RHO * SECOND, base=base,
        tip_stiffness=spring_matrix((springs[0], springs[0], 0.0, springs[1], springs[1], 0.0))[PLANE],
        tip_mass=rigid_mass(body[0], body[1], 0.0, body[2])[PLANE],
    )  # fmt: skip


SUPPORTS: dict[str, tuple[dict[str, Any], SprungBeam]] = {
    "springs": (
        {"base": "sprung", "base_springs": {"lateral": 4e5, "tilt": 3e4}, "tip_mass": 0.3},
        beam((4e5, 3e4), body=(0.3, 0.0, 0.0)),
    ),
    "two bearings": ({"base": "pinned", "tip_springs": {"lateral": 5e5}}, beam((None, 0.0), (5e5, 0.0))),
    "inertia": (
        {"tip_mass": 0.8, "tip_inertia": {"transverse": 4e-3, "polar": 1e-3}},
        beam((None, None), body=(0.8, 4e-3, 0.0)),
    ),
    "offset": ({"tip_mass": 0.8, "tip_offset": 0.08}, beam((None, None), body=(0.8, 0.0, 0.08))),
    "everything": (
        {
            "base": "sprung", "base_springs": {"lateral": 1e6, "axial": 1e6, "tilt": 5e4, "torsion": 1e4},
            "tip_springs": {"lateral": 1e5, "tilt": 1e3}, "tip_mass": 0.5, "tip_offset": -0.05,
            "tip_inertia": {"transverse": 2e-3},
        },
        beam((1e6, 5e4), (1e5, 1e3), (0.5, 2e-3, -0.05)),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SUPPORTS)
@pytest.mark.parametrize("elements", ["three_dimensional", "fourier"])
def test_supports_and_tip_bodies_are_those_of_a_beam(name: str, elements: str) -> None:
    """First bending 0.5 %, second 1 %; the estimate before the run 3 %."""
    mandrel, right = SUPPORTS[name]
    case = tube(**mandrel)
    case["mesh"]["discretisation"] = elements
    if elements == "fourier":
        case["mesh"] = {"discretisation": "fourier", "axial": 8, "grading": 1}
    found = bending(case)
    first, second = right.frequencies(2)
    assert found[0] == pytest.approx(first, rel=0.005)
    assert found[1] == pytest.approx(second, rel=0.01)
    estimate = beam_frequency(build_case(case), bonded=False)  # type: ignore[arg-type]
    assert estimate == pytest.approx(right.frequencies(1)[0], rel=0.03)


def test_stiff_springs_clamp_and_soft_springs_free_a_mandrel() -> None:
    clamped = bending(tube(tip_mass=0.3))
    stiff = {"lateral": 1e12, "axial": 1e12, "tilt": 1e12, "torsion": 1e12}
    np.testing.assert_allclose(bending(tube(tip_mass=0.3, base="sprung", base_springs=stiff)), clamped, rtol=1e-5)
    held = bending(tube(tip_mass=0.3, base="sprung", base_springs={}))
    np.testing.assert_allclose(held, clamped, rtol=1e-9)
    soft = run_analysis(
        build_case(tube(base="sprung", base_springs={"lateral": 1e-3, "axial": 1e-3, "tilt": 1e-3, "torsion": 1e-3})),
        progress=SilentProgress(),
    )["mode_frequency"].values
    free = run_analysis(build_case(tube(base="free")), progress=SilentProgress())["mode_frequency"].values
    assert soft[:6].max() < 1.0
    assert soft[6] == pytest.approx(free[6], rel=0.005)


def test_base_loads_of_a_sprung_mandrel_are_its_inertia_far_below_resonance() -> None:
    """Far below the resonance the tube moves as a rigid body: mass and first moment times the base acceleration."""
    case = tube(base="sprung", base_springs={"lateral": 4e5, "tilt": 3e4}, tip_mass=0.3, tip_offset=0.05)
    case["analysis"] = "harmonic"
    case["excitation"] = {"kind": "chirp", "amplitude": 1.0, "f_start": 1, "f_end": 5, "rate_oct_per_min": 1}
    case["damping"] = {"modal": 0.01}
    data = run_analysis(build_case(case), progress=SilentProgress())
    total = RHO * AREA * LENGTH + 0.3
    assert float(data["base_shear_amplitude"][0]) == pytest.approx(total, rel=0.005)
    arm = RHO * AREA * LENGTH * 0.5 * LENGTH + 0.3 * (LENGTH + 0.05)
    assert float(data["base_moment_amplitude"][0]) == pytest.approx(arm, rel=0.005)


def test_a_roll_on_springs_slips_in_full_condensed_and_reduced_alike() -> None:
    words = [
        "mesh={circumferential: 8, axial: 3, grading: 1}", "mandrel.base=sprung",
        "mandrel.base_springs={lateral: 2e6, tilt: 2e4}", "mandrel.tip_offset=0.02",
        "mandrel.tip_inertia={transverse: 1e-5, polar: 1e-5}", "output.figures=false", "excitation.frequency=125",
        "excitation.amplitude=30", "excitation.cycles=3",
        "excitation.ramp_cycles=1", "integrator.steps_per_cycle=24",
    ]  # fmt: skip
    tips = {}
    for method in ("full", "condensed", "reduced"):
        words_of = [*words, f"solver.method={method}"]
        data = run_analysis(load_case(CONFIGS / "tiny.yaml", words_of), progress=SilentProgress())
        tips[method] = data["tip_displacement"].values
        assert float(data["friction_energy"][-1]) > 0.0
        assert energy_balance_error(data) < 1e-6
    size = np.abs(tips["full"]).max()
    np.testing.assert_allclose(tips["condensed"], tips["full"], atol=1e-6 * size)
    np.testing.assert_allclose(tips["reduced"], tips["full"], atol=5e-3 * size)
