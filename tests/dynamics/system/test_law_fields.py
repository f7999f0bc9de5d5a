"""Contact laws in matrix files, and laws of the case in their place."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.exact_systems import slipping_pair
from support.structures import DWELL, GAMMA, MU, oscillator, write_case

from wroll_fem.analyses import run_analysis
from wroll_fem.case import load_case
from wroll_fem.contact.interface import NormalPenalty, PenaltyCoulomb, PointwiseFriction, RateCoulomb, SmoothedCoulomb
from wroll_fem.dynamics.system.io import load_system, save_system
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError
from wroll_fem.progress import SilentProgress

BOTH = pytest.mark.parametrize("suffix", [".npz", ".mat"])
RATE = RateCoulomb(0.4, 2.0e-6, (0.0, 1.0e-3, 0.1), (0.4, 0.3, 0.2))


def two_points() -> System:
    """The slipping pair with its contact point doubled."""
    system = slipping_pair()
    (one,) = system.interfaces
    rows = one.operator[[0, 1, 2, 0, 1, 2]]
    both = replace(one, operator=rows, areas=np.array([0.5, 0.5]), points=np.zeros((2, 3)))
    return replace(system, interfaces=(both,))


@BOTH
def test_laws_that_vary_from_point_to_point_come_back(tmp_path: Path, suffix: str) -> None:
    system = two_points()
    laws = PointwiseFriction((PenaltyCoulomb(0.1, 3e-7), RATE), np.array([1, 0]))
    normal = NormalPenalty(np.array([3.0e7, 5.0e7]), np.array([False, True]))
    system = replace(system, interfaces=(replace(system.interfaces[0], friction=laws, normal=normal),))
    again, _ = load_system(save_system(system, tmp_path / f"varying{suffix}"))
    (found,) = again.interfaces
    assert (found.friction, found.normal) == (laws, normal)
    for column, expected in zip(again.laws, system.laws, strict=True):
        np.testing.assert_array_equal(column, expected)
    other, _ = load_system(tmp_path / f"varying{suffix}", friction=RATE, normal_stiffness=1.0e8)
    assert other.interfaces[0].friction == RATE
    assert other.interfaces[0].normal == NormalPenalty(1.0e8, np.array([False, True]))


def test_a_point_without_a_law_is_refused(tmp_path: Path) -> None:
    system = two_points()
    laws = PointwiseFriction((PenaltyCoulomb(0.1, 3e-7), RATE), np.array([1, 0]))
    system = replace(system, interfaces=(replace(system.interfaces[0], friction=laws),))
    path = save_system(system, tmp_path / "varying.npz")
    fields = dict(np.load(path)) | {"interface_1_friction_index": np.array([2.0, 0.0])}
    np.savez(path, **fields)
    with pytest.raises(InputError, match=r"interface_1_friction_index.*from 1"):
        load_system(path)


def test_a_law_that_is_not_registered_cannot_be_saved(tmp_path: Path) -> None:
    system = slipping_pair()
    broken = replace(system.interfaces[0], friction=object())  # type: ignore[arg-type]
    with pytest.raises(InputError, match="object is not a registered friction law"):
        save_system(replace(system, interfaces=(broken,)), tmp_path / "pair.npz")


@BOTH
@pytest.mark.parametrize(
    "law", [PenaltyCoulomb(0.1, 3e-7), SmoothedCoulomb(0.25, 2.0e-3)], ids=lambda law: type(law).__name__
)
def test_laws_come_back_whatever_their_class(tmp_path: Path, suffix: str, law: Any) -> None:
    system = slipping_pair()
    system = replace(system, interfaces=(replace(system.interfaces[0], friction=law),))
    again, state = load_system(save_system(system, tmp_path / f"pair{suffix}"))
    assert again.interfaces[0].friction == law
    assert state is None
    assert [np.array_equal(a, b) for a, b in zip(system.laws, again.laws, strict=True)] == [True] * len(system.laws)


def friction_of(path: Path, *overrides: str) -> float:
    return float(run_analysis(load_case(path, overrides), progress=SilentProgress())["friction_energy"][-1])


def test_contact_in_the_case_replaces_the_laws_of_the_file(tmp_path: Path) -> None:
    """The same friction written in the case changes nothing; another one is that of a file that holds it."""
    write = partial(write_case, tmp_path, excitation=DWELL | {"cycles": 2.0, "ramp_cycles": 1.0})
    own = friction_of(write(oscillator()))
    same = {"friction": {"mu": MU, "elastic_slip": GAMMA}}
    assert friction_of(write(oscillator(), contact=same)) == own
    weak = friction_of(write(oscillator(interface_1_friction_mu=0.1)))
    written = {"friction": {"mu": 0.1, "elastic_slip": GAMMA}, "normal": {"penalty": "auto"}}
    path = write(oscillator(), contact=written)
    assert friction_of(path) == weak != own
    lawless = oscillator(**{name: None for name in oscillator() if "friction" in name})
    assert friction_of(write(lawless, contact=same)) == own
    stiff = friction_of(write(oscillator(interface_1_normal_stiffness=2.0e8)))
    path = write(oscillator(), contact=same | {"normal": {"penalty": 2.0e8}})
    assert friction_of(path) == stiff
