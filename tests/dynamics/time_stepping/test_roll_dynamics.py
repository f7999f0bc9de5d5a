"""The preloaded roll on a small mesh: full against condensed, limits of friction, order, ledger, base condition."""

from __future__ import annotations

import dataclasses
import os
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as la
from support.paths import CONFIGS
from support.twisted_wall import TWISTED

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.case import Case, load_case
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.system import TIE_FACTOR, System
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import RECORDS
from wroll_fem.dynamics.time_stepping.simulate import simulate
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.base_motion import Dwell

LAB = CONFIGS / "lab_sweep.yaml"
SMALL = ("mesh={circumferential: 8, axial: 3, grading: 1}", "output.figures=false")
HHT = Scheme.hht(-0.05)
TIP = RECORDS.index("tip_displacement")


def small_case(*overrides: str) -> Case:
    return load_case(LAB, [*SMALL, *overrides])


@cache
def prepared(*overrides: str, symmetric: bool = True) -> tuple[System, ContactState]:
    case = small_case(*overrides)
    system = build_system(case, build_bodies(case, symmetric=symmetric))
    return system, solve_preload(system)


def dwell(system: System, preload: ContactState, motion: Dwell, dt: float, scheme: Scheme = HHT, method="condensed"):
    return simulate(system, preload, motion, dt=dt, scheme=scheme, method=method)


def agreement(method_motion: Dwell, steps_per_cycle: int, *overrides: str, symmetric=True) -> tuple[float, float]:
    """Largest difference of the tips of `full` (whole roll) and `condensed`, and the slipping fraction.

    ``symmetric`` condenses half the roll.
    """
    dt = 1.0 / (method_motion.frequency_hz * steps_per_cycle)
    half = dwell(*prepared(*overrides, symmetric=symmetric), method_motion, dt)
    whole = dwell(*prepared(*overrides, symmetric=False), method_motion, dt, method="full")
    tip = half["tip_displacement"].values
    error = float(np.abs(whole["tip_displacement"].values - tip).max() / np.abs(tip).max())
    return error, float(half["slipping_fraction"].max())


def test_full_and_condensed_agree_over_a_few_cycles_with_slip() -> None:
    error, slipping = agreement(Dwell(100.0, 150.0, 1.5, 0.5), 24, "mesh={circumferential: 8, axial: 2, grading: 1}")
    assert slipping > 0.05
    assert error < 1e-6


@pytest.mark.slow
def test_full_and_condensed_agree_with_a_wall_that_couples_stretch_and_shear() -> None:
    mesh = "mesh={circumferential: 8, axial: 2, grading: 1}"
    error, slipping = agreement(Dwell(900.0, 300.0, 3, 1), 32, mesh, TWISTED, symmetric=False)
    assert slipping > 0.05
    assert error < 1e-6


@pytest.mark.slow
def test_full_and_condensed_agree_over_forty_cycles_with_slip() -> None:
    error, slipping = agreement(Dwell(40.0, 150.0, 40, 5), 24, "mesh={circumferential: 8, axial: 3, grading: 1}")
    assert slipping > 0.05
    assert error < 1e-6


def test_harmonics_and_one_dense_block_of_all_modes_agree() -> None:
    system, preload = prepared()
    motion = Dwell(30.0, 150.0, 12, 3)
    blocks = dwell(system, preload, motion, 1 / 6000)
    dense = dwell(dataclasses.replace(system, subspaces=()), preload, motion, 1 / 6000)
    tip = dense["tip_displacement"].values
    assert float(dense["slipping_fraction"].max()) > 0.05
    np.testing.assert_allclose(blocks["tip_displacement"].values, tip, atol=1e-8 * np.abs(tip).max(), rtol=0)


def test_compiled_loops_older_than_a_law_or_a_loop_they_inline_are_compiled_again(tmp_path: Path) -> None:
    cache, laws = tmp_path / "__pycache__", tmp_path / "contact"
    cache.mkdir()
    laws.mkdir()
    old, young, new = (cache / f"loop.{name}.nbi" for name in ("advance", "young", "new"))
    other = cache / "loop_of_others.advance.nbi"
    files = {old: 100.0, laws / "penalty.py": 150.0, young: 200.0, laws / "rate.py": 150.0, tmp_path / "base.py": 250.0}
    for path, stamp in (files | {new: 300.0, other: 100.0}).items():
        path.touch()
        os.utime(path, (stamp, stamp))
    gone = cache / "loop.gone.nbi"  # like a file that another process removes after it was listed
    gone.symlink_to(cache / "nothing")
    assert drop_stale_cache(tmp_path / "loop.py", laws=laws) == [old]
    assert drop_stale_cache(tmp_path / "loop.py", tmp_path / "base.py", laws=laws) == [young]
    assert sorted(cache.iterdir()) == sorted([new, other, gone])


def test_preload_on_the_interfaces_is_that_of_the_whole_structure() -> None:
    system, preload = prepared()
    whole = solve_preload(system, condensed=False)
    np.testing.assert_allclose(preload.traction, whole.traction, atol=1e-7 * np.abs(whole.traction).max(), rtol=0)
    np.testing.assert_allclose(preload.elastic_slip, whole.elastic_slip, atol=1e-13, rtol=0)


def test_the_rings_share_the_pressure_by_their_hoop_stiffness() -> None:
    """Two rings under external pressure P: the inner one carries P k_m / (k_m + k_l), k = E t / R^2.

    Away from the ends; the mandrel's axial stretch and Poisson effects stay within some per cent.
    """
    system, preload = prepared("mesh={circumferential: 12, axial: 8, grading: 1}")
    z = system.interfaces[0].points[:, 1]
    middle = preload.pressure[np.abs(z - 0.15) < 0.04].mean()
    k_m, k_l = 2.7e9 * 1.5e-3 / 0.03925**2, 2.8e9 * 1.25e-3 / 0.040625**2
    assert middle == pytest.approx(1e5 * k_m / (k_m + k_l), rel=0.05)


@pytest.mark.parametrize("alpha", [0.0, -0.05])
def test_halved_steps_converge_at_second_order_while_everything_sticks(alpha: float) -> None:
    system, preload = prepared()
    motion = Dwell(0.01, 150.0, 8, 4)
    histories = []
    for steps in (40, 80, 160):
        run = dwell(system, preload, motion, 1 / (150.0 * steps), Scheme.hht(alpha))
        assert float(run["slipping_fraction"].max()) == 0
        histories.append(run["tip_displacement"].values[:: steps // 40])
    coarse, fine = (np.abs(b - a).max() for a, b in pairwise(histories))
    assert 3.6 < coarse / fine < 4.4


def bending_frequency(system: System, springs: np.ndarray) -> float:
    """Mode that moves most of the mass along x, Hz, of the system with linear interface springs."""
    values, vectors = la.eigh(system.with_interface_springs(springs).toarray(), system.mass.toarray())
    share = (vectors.T @ (system.mass @ system.influence)) ** 2
    return float(np.sqrt(values[np.argmax(share)]) / (2 * np.pi))


def ringing_frequency(system: System, preload: ContactState, guess: float) -> float:
    """Frequency of a small free vibration in the time domain, from the tip's zero crossings, Hz."""
    dt = 1.0 / (guess * 200)
    stepper = CondensedStepper(system, preload, Scheme.hht(0.0), NewtonOptions(), dt=dt)
    modes = stepper.condensation
    main = int(np.argmax(np.abs(modes.base)))
    stepper.start_from(modes.displacement(1e-5 * np.eye(len(modes.eigenvalues))[main]))
    tip = stepper.advance(np.zeros(200 * 20 + 1), dt, 0.0)[:, TIP]
    rising = np.flatnonzero((tip[:-1] < 0) & (tip[1:] >= 0))
    crossings = rising + tip[rising] / (tip[rising] - tip[rising + 1])
    return float((len(crossings) - 1) / ((crossings[-1] - crossings[0]) * dt))


@pytest.mark.parametrize(("mu", "tangential"), [(1e-9, 0.0), (1e5, TIE_FACTOR)])
def test_the_limits_of_friction_are_the_frictionless_and_the_bonded_frequency(mu: float, tangential: float) -> None:
    system, preload = prepared(f"contact.friction.mu={mu}")
    kn, n = system.laws.kn, system.n_points
    limit = bending_frequency(system, np.concatenate([np.repeat(tangential * kn, 2), kn]))
    assert bending_frequency(system, stick_springs(system, preload)) == pytest.approx(limit, rel=2e-4)
    assert ringing_frequency(system, preload, limit) == pytest.approx(limit, rel=1e-3)
    assert n > 0


def test_bonded_is_above_and_frictionless_below_the_sticking_roll() -> None:
    system, preload = prepared()
    kn = system.laws.kn
    free, tied = (bending_frequency(system, np.concatenate([np.repeat(c * kn, 2), kn])) for c in (0.0, TIE_FACTOR))
    assert free < 0.95 * tied
    assert free < bending_frequency(system, stick_springs(system, preload)) < tied


def test_a_clamped_layer_base_leaves_friction_nothing_to_do() -> None:
    """C60: at the same motion of the tip the clamped roll loses less than a twentieth of what the free one loses."""
    friction, tip = {}, {}
    for base, amplitude in (("free", 20.0), ("clamped", 60.0)):
        run = dwell(*prepared(f"coil.base={base}"), Dwell(amplitude, 150.0, 20, 5), 1 / 6000)
        friction[base] = float(run["friction_energy"][-1])
        tip[base] = float(np.abs(run["tip_displacement"]).max())
    assert tip["clamped"] > tip["free"]
    assert friction["free"] > 1e-4
    assert friction["clamped"] < 0.05 * friction["free"]


@pytest.mark.slow
def test_lower_preload_lowers_the_resonance_and_skews_it_to_the_right() -> None:
    read = {}
    for pressure in ("1e4", "1e5"):
        sweep = ["excitation.f_start=115", "excitation.rate_oct_per_min=6", f"preload.pressure={pressure}"]
        case = small_case("mesh={circumferential: 12, axial: 4, grading: 1}", *sweep)
        read[pressure] = summarise(run_analysis(case, progress=SilentProgress()), case)
    loose, tight = read["1e4"], read["1e5"]
    assert loose["f_n_hz"] < 0.93 * tight["f_n_hz"]
    assert loose["peak_transmissibility"] < tight["peak_transmissibility"]
    assert loose["skewness"] > 0.05
    for summary in read.values():
        assert summary["energy_balance_error"] < 1e-6  # 0.5 % is asked
        assert summary["numerical_dissipation_j"] < 0.005 * summary["input_work_j"]
