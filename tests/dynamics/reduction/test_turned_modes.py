"""Modes turned to other springs of the interfaces, against modes that are computed for these springs."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.paths import CONFIGS
from support.twisted_wall import TWISTED

import wroll_fem as wf
from wroll_fem.analyses import harmonic
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.case import load_case
from wroll_fem.contact.point import per_dof
from wroll_fem.dynamics.reduction import kept_structure
from wroll_fem.dynamics.reduction.condensation import Condensation, condense_cyclic
from wroll_fem.dynamics.reduction.kept_structure import keeping_structure, kept_modes
from wroll_fem.dynamics.reduction.turned_modes import missed, turned
from wroll_fem.dynamics.system.modal_damping import ModalDamping
from wroll_fem.dynamics.system.system import System

BAND = ["excitation.f_start=140", "excitation.f_end=170"]
SHELLS = "mesh={circumferential: 8, axial: 3, grading: 1}"
SOLID = "mesh={circumferential: 8, axial: 3, radial: 1, grading: 4}"
ROLLS = {
    "isotropic": ("lab_sweep", True, [SHELLS]),
    "two layers": ("lab_sweep", True, [SHELLS, "coil.layers=2"]),
    "angle plies": ("lab_sweep", False, [SHELLS, TWISTED]),
    "solid coil": ("sspp_friction", True, [SOLID]),
    "light solid coil, whole": ("irosa_friction", False, [SOLID]),
}
"""Case file, whether half of the roll is modelled, and overrides."""


def roll(name: str, **changed: Any) -> System:
    file, symmetric, more = ROLLS[name]
    case = load_case(CONFIGS / f"{file}.yaml", more)
    return replace(build_system(case, build_bodies(case, symmetric=symmetric)), **changed)


def springs(system: System, tangential: float) -> np.ndarray:
    return per_dof(np.full(system.n_points, tangential), system.laws.kn)


def modes(system: System, tangential: float, moments: int) -> Condensation:
    found = condense_cyclic(system, springs(system, tangential), moments)
    assert found is not None
    return found


def compliance(found: Condensation, system: System, hertz: float) -> np.ndarray:
    part = 1.0 / (found.eigenvalues - (2.0 * np.pi * hertz) ** 2)
    return found.compliance(np.split(part, found.blocks[1:-1]), system.laws.area)[1]


@pytest.mark.parametrize("moments", [0, 4])
@pytest.mark.parametrize("name", list(ROLLS))
def test_turned_modes_are_those_of_the_other_springs(name: str, moments: int) -> None:
    system = roll(name)
    for start, end in ((3e9, 4e11), (4e11, 3e9)):
        known, fresh = modes(system, start, moments), modes(system, end, moments)
        found = turned(system, known, springs(system, end))
        assert missed(system, found) < 1e-7
        assert found.main_mode[0] == pytest.approx(fresh.main_mode[0], rel=1e-8)
        for hertz in (0.0, 400.0):
            expected = compliance(fresh, system, hertz)
            np.testing.assert_allclose(
                compliance(found, system, hertz), expected, rtol=0, atol=1e-6 * np.abs(expected).max()
            )


def test_springs_that_are_left_out_are_found_by_the_check() -> None:
    """A span without the responses to forces of the interfaces does not hold the modes of other springs."""
    system = roll("isotropic")
    known = modes(system, 3e9, 4)
    few = []
    for basis, ritz in known.vectors:
        few.append((basis, ritz[:, :10]))
    cuts = [np.arange(a, a + min(10, b - a)) for a, b in zip(known.blocks[:-1], known.blocks[1:], strict=True)]
    kept = np.concatenate(cuts)
    poor = replace(
        known, eigenvalues=known.eigenvalues[kept], blocks=np.concatenate([[0], np.cumsum([len(c) for c in cuts])]),
        vectors=few, jump=[j[:, :10] for j in known.jump], base=known.base[kept], tip=known.tip[kept],
        probes=known.probes[:, kept],
    )  # fmt: skip
    assert missed(system, turned(system, poor, springs(system, 4e11))) > 1e-3


def test_damping_ratios_are_those_of_the_turned_modes() -> None:
    system = roll("isotropic", modal_damping=ModalDamping(table=((100.0, 0.01), (1000.0, 0.05))))
    fresh = modes(system, 4e11, 0)
    found = turned(system, modes(system, 3e9, 0), springs(system, 4e11))
    for own, expected in zip(found.damping, fresh.damping, strict=True):
        np.testing.assert_allclose(own, expected, rtol=1e-5)


@pytest.mark.slow
def test_a_series_has_the_results_of_its_runs_and_computes_the_structure_once(monkeypatch: pytest.MonkeyPatch) -> None:
    case = wf.load_case(CONFIGS / "lab_harmonic.yaml", ["mesh={circumferential: 8, axial: 4, grading: 8}"])
    keys = {"preload.pressure": [6e4, 1e5], "excitation.amplitude": [5.0, 10.0]}
    combinations = itertools.product(*keys.values())
    alone = [wf.run(case.changed(dict(zip(keys, one, strict=True))), progress=False) for one in combinations]
    spans = []
    condense = harmonic.condense
    monkeypatch.setattr(harmonic, "condense", lambda *words, **more: spans.append(1) or condense(*words, **more))
    series = wf.run_series(case, keys, progress=False)
    assert len(spans) == 1
    for one, member in zip(alone, series, strict=True):
        for name in ("f_n_hz", "zeta", "peak_transmissibility"):
            assert member.data.attrs[name] == one.attrs[name]
        np.testing.assert_array_equal(member.data["transmissibility_real"], one["transmissibility_real"])


@pytest.mark.parametrize(
    ("file", "more"),
    [
        ("lab_harmonic", ["mesh={circumferential: 8, axial: 4, grading: 8}", *BAND]),
        ("sspp_friction", [SOLID]),
        ("irosa_friction", [SOLID]),
    ],
)
@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")  # of the coarse mesh
def test_turned_modes_give_the_curve_of_fresh_ones(monkeypatch: pytest.MonkeyPatch, file: str, more: list[str]) -> None:
    """Of layers at a pressure at which no harmonic meets a mode, and of solid coils that rub on their mandrel."""
    accurate = ["harmonic.reduction_tolerance=1e-5", "harmonic.samples=256"]  # bases, ripples differ more than modes do
    case = wf.load_case(CONFIGS / f"{file}.yaml", ["harmonic.harmonics=3", *accurate, *more])
    found = wf.run(case, progress=False)
    monkeypatch.setattr(harmonic, "kept_modes", lambda system, springs, moments, compute: compute(springs))
    fresh = wf.run(case, progress=False)
    allowed = {
        "stuck_resonance_hz": 1e-8, "f_n_hz": 1e-5, "half_power_low_hz": 1e-5, "half_power_high_hz": 1e-5,
        "peak_transmissibility": 1e-5, "zeta": 1e-4,
    }  # fmt: skip
    assert found.attrs["f_n_hz"] != fresh.attrs["f_n_hz"]
    for name, relative in allowed.items():
        assert found.attrs[name] == pytest.approx(fresh.attrs[name], rel=relative)


def test_modes_are_computed_once_per_structure_and_anew_where_turned_ones_fail(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    system, other = roll("isotropic"), roll("two layers")
    calls: list[float] = []

    def found(one: System, tangential: float, moments: int = 4) -> Condensation:
        def compute(values: np.ndarray) -> Condensation:
            calls.append(float(values.min()))
            modes = condense_cyclic(one, values, moments)
            assert modes is not None
            return modes

        calls.clear()
        return kept_modes(one, springs(one, tangential), moments, compute)

    penalty = float(system.laws.kn.min())
    with keeping_structure():
        first = found(system, 3e9)
        assert calls == [penalty]
        found(system, 4e11)
        assert calls == []
        found(other, 4e11)
        assert calls == [float(other.laws.kn.min())]
        np.testing.assert_array_equal(found(system, 3e9).eigenvalues, first.eigenvalues)
        found(system, 3e9, 0)  # all modes
        assert calls == [3e9]
        monkeypatch.setattr(kept_structure, "MISSED", 0.0)
        found(system, 3e9)
        assert calls == [3e9]
    found(system, 3e9)
    assert calls == [penalty, 3e9]
