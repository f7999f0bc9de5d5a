r"""Joints against closed forms: hysteresis loops, describing functions in harmonic balance, and time histories."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
import xarray as xr
from scipy.integrate import quad

from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.joints import (
    BoucWen,
    Coulomb,
    Gap,
    Iwan,
    Jenkins,
    Joint,
    Spring,
    joint_force,
    with_joints,
)  # fmt: skip
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance, solve_motion
from wroll_fem.dynamics.periodic.response import HarmonicCurve, response_curve
from wroll_fem.dynamics.reduction.condensation import condense
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.simulate import simulate
from wroll_fem.errors import InputError
from wroll_fem.results.energy import energy_balance_error
from wroll_fem.signals.base_motion import Dwell
from wroll_fem.typing import FloatArray

MASS, SPRING, DASHPOT = 1.0, 1.0e4, 8.0
STIFFNESS, LIMIT = 5.0e3, 2.0
LEVEL = 8.0
"""Mass kg, spring N/m and dashpot N s/m of the oscillator; stiffness N/m and limit N of its joints; base m/s^2."""

JENKINS = Jenkins(at=0, stiffness=STIFFNESS, limit=LIMIT)
IWAN = Iwan(at=0, stiffness=STIFFNESS, limit=LIMIT, chi=-0.3, beta=0.2)
LINEAR = BoucWen(at=0, stiffness=STIFFNESS, limit=LIMIT)  # n = 1
SQUARE = BoucWen(at=0, stiffness=STIFFNESS, limit=LIMIT, exponent=2.0)
CUBIC = Spring(at=0, coefficients=(0.0, 0.0, 1.0e9), length=1.0e-3)
STOPS = Gap(at=0, stiffness=2.0e4, gap=1.0e-3, both=True)


def oscillator(*joints: Joint) -> tuple[System, ContactState]:
    """One damped mass on a spring and on joints, on a shaken base."""
    plain = System(
        sp.csr_matrix([[SPRING]]), sp.csr_matrix([[MASS]]), np.ones(1), probes={"tip": np.ones(1)},
        damping=sp.csr_matrix([[DASHPOT]]),
    )  # fmt: skip
    return with_joints(plain, joints)


def contact_of(joint: Joint, harmonics: int, samples: int) -> HarmonicContact:
    system, state = oscillator(joint)
    model = ReducedModel.complete(condense(system, stick_springs(system, state), Scheme.hht(0.0), 1e-3))
    return HarmonicContact(model, state, system.laws, Sampling(harmonics, samples))


def response(joint: Joint, samples: int = 4096) -> HarmonicCurve:
    return response_curve(contact_of(joint, 1, samples), amplitude=LEVEL, frequencies=(10.0, 25.0))


# --- loops ------------------------------------------------------------------------------------------------------------


def test_a_jenkins_loop_is_a_parallelogram() -> None:
    """Stiffness k_t up to the limit; slides; unloads with k_t; the loss is 4 F (X - F / k_t)."""
    reach, onset = 2.0e-3, LIMIT / STIFFNESS
    path = np.concatenate(
        [np.linspace(0, reach, 201), np.linspace(reach, -reach, 401), np.linspace(-reach, reach, 401)]
    )
    force = joint_force(JENKINS, path)
    np.testing.assert_allclose(force[:41], STIFFNESS * path[:41], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(force[41:201], LIMIT, rtol=1e-12)
    back = np.maximum(-LIMIT, LIMIT - STIFFNESS * (reach - path[201:602]))
    np.testing.assert_allclose(force[201:602], back, atol=1e-12)
    loop = slice(201, None)
    loss = float(np.sum(0.5 * (force[loop][1:] + force[loop][:-1]) * np.diff(path[loop])))
    assert loss == pytest.approx(4.0 * LIMIT * (reach - onset), rel=1e-12)  # the corners lie on samples


def test_a_jenkins_joint_in_two_directions_slides_at_the_magnitude_of_the_limit() -> None:
    joint = Jenkins(at=0, across=1, stiffness=STIFFNESS, mu=0.25, normal_force=8.0)
    path = np.column_stack([np.linspace(0, 3e-3, 50), np.linspace(0, 4e-3, 50)])
    force = joint_force(joint, path)
    np.testing.assert_allclose(force[-1], LIMIT * np.array([0.6, 0.8]), rtol=1e-12)


def iwan_force(joint: Iwan, x: FloatArray) -> FloatArray:
    """Force of monotonic loading (Segalman 2005, equation 9 with a finite number of parameters eliminated)."""
    last, chi = joint.largest_slip, joint.chi
    power = joint.stiffness / (1.0 + joint.beta) * (chi + 1.0) / last ** (chi + 1.0)
    fixed = joint.stiffness * joint.beta / (1.0 + joint.beta)
    x = np.minimum(x, last)
    return (
        power * (x ** (chi + 2.0) / (chi + 2.0) + x * (last ** (chi + 1.0) - x ** (chi + 1.0)) / (chi + 1.0))
        + fixed * x
    )


@pytest.mark.parametrize("chi", [-0.6, -0.3, 0.0, 0.5])
@pytest.mark.parametrize("beta", [0.0, 0.2, 2.0])
def test_an_iwan_joint_follows_its_closed_form(chi: float, beta: float) -> None:
    """Force of monotonic loading, and by Masing's rules the loop: 1e-3 of the force."""
    joint = Iwan(at=0, stiffness=STIFFNESS, limit=LIMIT, chi=chi, beta=beta)
    last = joint.largest_slip
    path = np.concatenate([np.linspace(0, 1.5 * last, 101), np.linspace(1.5 * last, -1.5 * last, 201)[1:]])
    force = joint_force(joint, path)
    right = iwan_force(joint, path[:101])
    np.testing.assert_allclose(force[:101], right, atol=1e-3 * LIMIT)
    assert force[100] == pytest.approx(LIMIT, rel=1e-12)
    back = LIMIT - 2.0 * iwan_force(joint, 0.5 * (1.5 * last - path[101:]))
    np.testing.assert_allclose(force[101:], back, atol=2e-3 * LIMIT)


def test_the_loss_of_an_iwan_joint_grows_with_the_power_of_chi() -> None:
    """4 R X^(chi + 3) / ((chi + 2) (chi + 3)) per cycle, over one and a half decades of amplitude, to 1e-3."""
    last = IWAN.largest_slip
    density = IWAN.stiffness / (1.0 + IWAN.beta) * (IWAN.chi + 1.0) / last ** (IWAN.chi + 1.0)
    for reach in last * np.array([0.03, 0.1, 0.3, 1.0]):
        path = reach * np.concatenate([np.linspace(0, 1, 101), np.cos(np.linspace(0, 2 * np.pi, 1001)[1:])])
        force = joint_force(IWAN, path)
        loss = float(np.sum(0.5 * (force[101:] + force[100:-1]) * np.diff(path[100:])))
        right = 4.0 * density * reach ** (IWAN.chi + 3.0) / ((IWAN.chi + 2.0) * (IWAN.chi + 3.0))
        assert loss == pytest.approx(right, rel=1e-3)


def bouc_wen_rise(x: FloatArray, start: float, joint: BoucWen) -> FloatArray:
    """Force for rising x from ``start`` < 0, in closed form (b = 1/2: unloading is elastic); n = 1 or 2."""
    limit, k = joint.limit, joint.stiffness
    elastic = start + k * x  # until the force changes sign
    after = k * x + start  # stiffness times the path since then
    smooth = 1.0 - np.exp(-after / limit) if joint.exponent == 1.0 else np.tanh(after / limit)
    return np.where(elastic < 0.0, elastic, limit * smooth)


@pytest.mark.parametrize("joint", [LINEAR, SQUARE], ids=["n1", "n2"])
@pytest.mark.parametrize("steps", [7, 400])
def test_a_bouc_wen_loop_follows_its_closed_form(joint: BoucWen, steps: int) -> None:
    """Loading is 1 - exp (n = 1) or tanh (n = 2); with b = 1/2 unloading is straight: 1e-7 of the limit."""
    reach = 3.0 * LIMIT / STIFFNESS
    path = np.concatenate([np.linspace(0, reach, steps), np.linspace(reach, -reach, 2 * steps)[1:]])
    force = joint_force(joint, path)
    right = bouc_wen_rise(path[:steps], 0.0, joint)
    np.testing.assert_allclose(force[:steps], right, atol=1e-7 * LIMIT)
    down = -bouc_wen_rise(reach - path[steps:], -right[-1], joint)
    np.testing.assert_allclose(force[steps:], down, atol=1e-7 * LIMIT)


# --- harmonic balance -------------------------------------------------------------------------------------------------


def jenkins_harmonic(reach: float) -> complex:
    """Fundamental of the force for x = X cos (Caughey 1960): in phase, and -i times the part against the velocity."""
    onset = LIMIT / STIFFNESS
    if reach <= onset:
        return STIFFNESS * reach
    theta = np.arccos(1.0 - 2.0 * onset / reach)
    in_phase = STIFFNESS * reach / np.pi * (theta - 0.5 * np.sin(2.0 * theta))
    return complex(in_phase, 4.0 * LIMIT / np.pi * (1.0 - onset / reach))


def masing_harmonic(force: Callable[[float], float], reach: float) -> complex:
    """Fundamental of the force for x = X cos, of a joint that follows Masing's rules, from its virgin curve."""

    def falling(phase: float) -> float:
        return force(reach) - 2.0 * force(0.5 * reach * (1.0 - np.cos(phase)))

    cosine = 2.0 / np.pi * quad(lambda p: falling(p) * np.cos(p), 0.0, np.pi, epsabs=1e-10, limit=400)[0]
    sine = 2.0 / np.pi * quad(lambda p: falling(p) * np.sin(p), 0.0, np.pi, epsabs=1e-10, limit=400)[0]
    return complex(cosine, -sine)


def iwan_harmonic(reach: float) -> complex:
    return masing_harmonic(lambda x: float(iwan_force(IWAN, np.array(x))), reach)


def cubic_harmonic(reach: float) -> complex:
    return complex(0.75 * CUBIC.coefficients[2] * reach**3)


def stops_harmonic(reach: float) -> complex:
    """Symmetric stops: 2 k X / pi (a - sin(2 a) / 2 ... ) of the part of the cosine above the gap."""
    if reach <= STOPS.gap:
        return 0.0j
    a = np.arccos(STOPS.gap / reach)
    return complex(STOPS.stiffness * reach * 2.0 / np.pi * (a - 0.5 * np.sin(2.0 * a)))


@pytest.mark.parametrize(
    ("joint", "harmonic", "tolerance"),
    [
        (JENKINS, jenkins_harmonic, 1e-6), (IWAN, iwan_harmonic, 1e-3), (CUBIC, cubic_harmonic, 1e-6),
        (STOPS, stops_harmonic, 1e-6),
    ],
    ids=["jenkins", "iwan", "cubic", "stops"],
)  # fmt: skip
def test_one_harmonic_is_the_describing_function(
    joint: Joint, harmonic: Callable[[float], complex], tolerance: float
) -> None:
    """(k - m w^2 + i w c) X + F_1(X) = m A at every point of the curve, relative to the force at the peak."""
    curve = response(joint, 256 if joint is IWAN else 4096)
    x = np.abs(curve.fundamental(curve.balance.model.tip))
    w = curve.frequencies
    force = np.array([harmonic(float(reach)) for reach in x])
    found = np.abs((SPRING - MASS * w**2 + 1j * w * DASHPOT) * x + force)
    np.testing.assert_allclose(found, MASS * LEVEL, atol=tolerance * float(np.abs(force).max() + MASS * LEVEL))
    assert np.abs(force).max() > 0.2 * MASS * LEVEL


def test_a_bouc_wen_joint_in_harmonic_balance_has_the_harmonic_of_its_steady_loop() -> None:
    """One harmonic of the loop that `joint_force` reaches under the same cosine: 1e-5 of the limit."""
    joint = BoucWen(at=0, stiffness=STIFFNESS, limit=LIMIT, exponent=1.5, unloading=0.7)
    samples = 512
    curve = response(joint, samples)
    motion, w = curve.fundamental(curve.balance.model.tip), curve.frequencies
    peak = int(np.argmax(np.abs(motion)))
    phase = 2.0 * np.pi * np.arange(1, 4 * samples + 1) / samples
    force = joint_force(joint, np.abs(motion[peak]) * np.cos(phase))[-samples:]
    first = 2.0 / samples * np.sum(force * np.exp(-1j * phase[-samples:]))
    total = (SPRING - MASS * w[peak] ** 2 + 1j * w[peak] * DASHPOT) * np.abs(motion[peak]) + first
    assert abs(total) == pytest.approx(MASS * LEVEL, rel=1e-5)


# --- time histories ---------------------------------------------------------------------------------------------------


JOINTS = pytest.mark.parametrize(
    "joint",
    [JENKINS, replace(IWAN, sliders=25), SQUARE, CUBIC, STOPS],
    ids=["jenkins", "iwan", "bouc_wen", "cubic", "stops"],
)
HERTZ, STEPS = 14.0, 160


@cache
def balanced_tip(joint: Joint) -> float:
    """Amplitude of the tip in a dwell by harmonic balance with nine harmonics, m."""
    balance = HarmonicBalance(contact_of(joint, 9, 512), LEVEL)
    motion = solve_motion(balance, 2.0 * np.pi * HERTZ)
    return float(np.hypot(*(motion[1:3] @ balance.model.tip)))


def dwell(joint: Joint, method: str, cycles: int) -> xr.Dataset:
    system, state = oscillator(joint)
    motion = Dwell(LEVEL, HERTZ, cycles=cycles, ramp_cycles=min(5, cycles / 2))
    return simulate(system, state, motion, dt=1.0 / (HERTZ * STEPS), scheme=Scheme.hht(0.0), method=method)


@JOINTS
def test_the_whole_structure_has_the_motion_and_the_energies_of_the_condensed_one(joint: Joint) -> None:
    """Four cycles, whose steps are not compiled; the condensed dwell goes on to the motion of harmonic balance."""
    full, condensed = dwell(joint, "full", 4), dwell(joint, "condensed", 4)
    for name in ("tip_displacement", "contact_energy", "friction_energy", "input_work"):
        size = np.abs(condensed[name].values).max()
        np.testing.assert_allclose(full[name].values, condensed[name].values, atol=1e-6 * size + 1e-15)
    assert energy_balance_error(full) < 1e-8
    rubs = not isinstance(joint, Spring | Gap)
    assert (float(condensed["friction_energy"][-1]) > 1e-3 * float(condensed["input_work"][-1])) == rubs


@JOINTS
@pytest.mark.parametrize("method", ["condensed", "reduced"])
def test_a_dwell_reaches_the_motion_of_harmonic_balance_and_closes_its_energy(joint: Joint, method: str) -> None:
    history = dwell(joint, method, 30)
    last = history["tip_displacement"].values[-STEPS:]
    first = abs(2.0 / STEPS * np.sum(last * np.exp(-2j * np.pi * np.arange(STEPS) / STEPS)))
    assert first == pytest.approx(balanced_tip(joint), rel=5e-3)
    assert energy_balance_error(history) < 1e-8
    if isinstance(joint, Spring):  # the trapezoidal work of a step is that of the potential to second order
        tip, stored = history["tip_displacement"].values, history["contact_energy"].values
        potential = 0.25 * joint.coefficients[2] * tip**4
        np.testing.assert_allclose(stored, potential, atol=2e-3 * potential.max())
        assert np.abs(history["pressure_modulation_work"].values).max() < 1e-12
    lossless = isinstance(joint, Spring | Gap)
    assert (float(history["friction_energy"].values[-1]) == pytest.approx(0.0, abs=1e-12)) == lossless


@pytest.mark.parametrize("gap", [0.0, 0.4e-3])
def test_friction_under_a_varying_normal_force_is_that_of_a_spring_and_a_slider(gap: float) -> None:
    """Marched by hand, through separation: the spring force is clipped to mu times the present normal force."""
    k_t, k_n, mu, load = 4.0e3, 2.0e4, 0.6, 0.0 if gap else 20.0
    joint = Coulomb(at=0, normal=1, stiffness=k_t, normal_stiffness=k_n, mu=mu, normal_force=load, gap=gap, force=20.0)
    t = np.linspace(0.0, 2.0, 801)
    path = np.column_stack([5e-3 * np.sin(2 * np.pi * t), 1.5e-3 * np.sin(6 * np.pi * t + 0.4)])
    expected, e, before = [], 0.0, 0.0
    for x, opening in path:
        press = max(0.0, load - k_n * (opening + gap) if gap else load - k_n * opening)
        e = float(np.clip(e + x - before, -mu * press / k_t, mu * press / k_t))
        before = x
        expected.append(k_t * e)
    found = joint_force(joint, path)
    assert (np.array(expected) == 0.0).any()
    np.testing.assert_allclose(found[:, 0], expected, atol=1e-9)


def test_a_coulomb_joint_without_load_needs_a_typical_force() -> None:
    with pytest.raises(InputError, match="typical"):
        Coulomb(at=0, normal=1, stiffness=1.0, normal_stiffness=1.0, mu=0.1, gap=1e-3)
    with pytest.raises(InputError, match="give one of them"):
        Coulomb(at=0, normal=1, stiffness=1.0, normal_stiffness=1.0, mu=0.1, gap=1e-3, normal_force=1.0)
