"""Structures from matrices with joints in Python: excitation by a force, files, messages, and laws of the user."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.paths import CONFIGS, ROOT

import wroll_fem as wf
from wroll_fem.dynamics.joints.joint import row_of
from wroll_fem.dynamics.system.io import load_system

K = 1e4 * np.array([[2.0, -1.0], [-1.0, 1.0]])
M = np.diag([1.0, 0.5])
BAND = wf.Chirp(f_start=5.0, f_end=40.0, rate_oct_per_min=1.0, amplitude=2.0)
JOINTS = [
    wf.joints.Jenkins(at=0, stiffness=5e3, limit=1.0, name="ground"),
    wf.joints.Jenkins(at=(1, 0), stiffness=5e3, mu=0.2, normal_force=5.0),
]


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def test_a_force_gives_the_receptance_of_a_linear_chain() -> None:
    """Joints that never slip are springs: accelerance and displacement of the tip against the dynamic stiffness."""
    joints = [wf.joints.Jenkins(at=joint.at, stiffness=5e3, limit=1e6) for joint in JOINTS]
    dashpots = np.diag([2.0, 1.0])
    chain = wf.structure(K, M, joints, damping=dashpots, force={0: 3.0, 1: -1.0})
    data = chain.run_harmonic(BAND, output={"figures": False}).data
    w = 2.0 * np.pi * data["frequency"].values
    stiff = K + 5e3 * np.array([[2.0, -1.0], [-1.0, 1.0]])
    exact = np.array([np.linalg.solve(stiff - x**2 * M + 1j * x * dashpots, [6.0, -2.0])[1] for x in w])
    np.testing.assert_allclose(data["tip_amplitude"].values, np.abs(exact), rtol=1e-6)
    found = data["transmissibility_real"].values + 1j * data["transmissibility_imag"].values
    np.testing.assert_allclose(found, -(w**2) * exact / 2.0, rtol=1e-6)
    assert data.attrs["excited_by"] == "force"
    assert "base_shear_amplitude" not in data


FORCES = [
    wf.joints.Force(at=1, amplitude=2.0), wf.joints.Force(at=0, amplitude=1.5, phase=60.0),
    wf.joints.Force(at=(1, 0), amplitude=0.7, phase=-30.0, harmonic=3), wf.joints.Force(at=0, harmonic=2, phase=90.0),
]  # fmt: skip


def test_forces_with_phase_and_harmonics_superpose_on_a_linear_chain() -> None:
    """Every harmonic against the dynamic stiffness at its own frequency; in the energy balance too."""
    joints = [wf.joints.Jenkins(at=0, stiffness=5e3, limit=1e6)]
    dashpots = np.diag([8.0, 4.0])
    chain = wf.structure(K, M, joints, damping=dashpots, force=FORCES, probes={"first": 0})
    data = chain.run_harmonic(BAND, harmonic={"harmonics": 3}).data
    w, stiff = 2.0 * np.pi * data["frequency"].values, K + 5e3 * np.diag([1.0, 0.0])
    turn = np.exp(1j * np.pi / 3.0)
    exact = [np.linalg.solve(stiff - x**2 * M + 1j * x * dashpots, [3.0 * turn, 4.0])[1] for x in w]
    found = data["transmissibility_real"].values + 1j * data["transmissibility_imag"].values
    np.testing.assert_allclose(found, -(w**2) * np.array(exact) / 2.0, rtol=1e-6)
    assert data.attrs["energy_balance_error"] < 1e-8
    work = np.zeros(len(w))
    for order, load in ((1, [3.0 * turn, 4.0]), (2, [2j, 0.0]), (3, 1.4 * np.exp(-1j * np.pi / 6) * np.array([-1, 1]))):
        for i, x in enumerate(order * w):
            u = np.linalg.solve(stiff - x**2 * M + 1j * x * dashpots, load)
            work[i] += np.pi * order * x * float(np.real(np.conj(u) @ dashpots @ u))
    np.testing.assert_allclose(data["material_damping_work_per_cycle"], work, rtol=1e-6)


def test_two_harmonics_on_a_cubic_spring_are_those_of_an_integration_in_time() -> None:
    forces = [wf.joints.Force(at=0, amplitude=4.0), wf.joints.Force(at=0, amplitude=3.0, phase=40.0, harmonic=2)]
    spring = wf.joints.Spring(at=0, coefficients=(0.0, 0.0, 3e9), length=1e-3)
    mass = wf.structure([[1e4]], [[1.0]], [spring], damping=[[20.0]], force=forces)
    band = wf.Chirp(f_start=9.0, f_end=10.0, rate_oct_per_min=1.0, amplitude=1.0)
    data = mass.run_harmonic(band, harmonic={"harmonics": 11, "samples": 256}).data
    w = 2.0 * np.pi * float(data["frequency"][-1])

    def rate(t: float, y: np.ndarray) -> list[float]:
        push = 4.0 * np.cos(w * t) + 3.0 * np.cos(2.0 * w * t + np.deg2rad(40.0))
        return [y[1], push - 20.0 * y[1] - 1e4 * y[0] - 3e9 * y[0] ** 3]

    period, cycles = 2.0 * np.pi / w, 25
    times = cycles * period + period * np.arange(256) / 256
    found = solve_ivp(rate, (0.0, times[-1]), [0.0, 0.0], t_eval=times, rtol=1e-9, atol=1e-12).y[0]
    first = 2.0 / 256 * np.sum(found * np.exp(-1j * w * times))
    assert float(data["tip_amplitude"][-1]) == pytest.approx(abs(first), rel=1e-4)


def test_forces_with_phase_are_for_harmonic_balance_and_need_its_harmonics(tmp_path: Path) -> None:
    chain = wf.structure(K, M, JOINTS, damping=0.02, force=FORCES)
    with pytest.raises(wf.InputError, match=r"harmonic.harmonics: is 2, but a force acts at harmonic 3; set it to 3"):
        chain.run_harmonic(BAND, harmonic={"harmonics": 2})
    with pytest.raises(wf.InputError, match="force: analysis dwell has one force pattern"):
        chain.run_dwell(wf.Dwell(frequency=10.0, cycles=5, ramp_cycles=1, amplitude=1.0))
    system, _ = load_system(chain.save(tmp_path / "chain.npz"))
    for found, given in zip(system.harmonic_forces, chain.system.harmonic_forces, strict=True):
        assert found.order == given.order
        np.testing.assert_array_equal(found.cosine, given.cosine)
        np.testing.assert_array_equal(found.sine, given.sine)


@pytest.mark.slow
def test_dwell_sweep_and_harmonic_of_a_force_agree() -> None:
    chain = wf.structure(K, M, JOINTS, damping=0.02, force={1: 1.0})
    curve = wf.transmissibility(chain.run_harmonic(BAND, harmonic={"harmonics": 5}).data)
    steady = wf.Dwell(frequency=13.0, cycles=40, ramp_cycles=5, amplitude=2.0)
    dwell = chain.run_dwell(steady, integrator={"steps_per_cycle": 160})
    assert dwell.summary["steady_magnitude"] == pytest.approx(float(curve.interp(frequency=13.0)), rel=5e-3)
    band = wf.Chirp(f_start=9.0, f_end=20.0, rate_oct_per_min=1.0, amplitude=2.0)
    sweep = chain.run_sweep(band, integrator={"steps_per_cycle": 80}, output={"figures": False})
    assert sweep.peak_transmissibility == pytest.approx(float(curve.sel(frequency=slice(9, 20)).max()), rel=0.02)


def test_the_loss_of_the_loops_is_the_friction_work() -> None:
    data = wf.structure(K, M, JOINTS, damping=0.02, force={1: 1.0}).run_harmonic(BAND).data
    x, f = data["loop_displacement"].values, data["loop_force"].values
    loss = 0.5 * np.sum((f + np.roll(f, -1, axis=1)) * (np.roll(x, -1, axis=1) - x), axis=1)
    peak = int(np.argmax(wf.transmissibility(data).values))
    assert loss.sum() == pytest.approx(float(data["friction_work_per_cycle"][peak]), rel=1e-6)
    assert list(data["interface_name"].values) == ["ground", "jenkins_2"]
    assert np.abs(f).max() == pytest.approx(1.0, rel=1e-9)
    ax = wf.plot.hysteresis(data)
    assert ax.get_ylabel() == "Force (N)"
    assert len(ax.get_legend().get_texts()) == 2


@pytest.mark.parametrize("both", [True, False], ids=["both sides", "one side"])
def test_stops_have_loops_towards_the_stop(both: bool) -> None:
    stop = wf.joints.Gap(at=1, stiffness=3e3, gap=1e-3, both=both)
    data = (
        wf.structure(K, M, [stop], damping=0.05, force={1: 1.0})
        .run_harmonic(BAND.model_copy(update={"f_end": 20.0}))
        .data
    )
    x, f = data["loop_displacement"].values[0], data["loop_force"].values[0]
    reached = np.sign(x) * np.maximum(np.abs(x) - 1e-3, 0.0) if both else np.maximum(x - 1e-3, 0.0)
    np.testing.assert_allclose(f, 3e3 * reached, atol=1e-9)
    assert np.abs(f).max() > 1.0


def test_modes_stick_by_default() -> None:
    chain = wf.structure(K, M, JOINTS)
    stuck = K + 5e3 * np.array([[2.0, -1.0], [-1.0, 1.0]])
    exact = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, stuck))) / (2.0 * np.pi)
    np.testing.assert_allclose(chain.run_modal().data["mode_frequency"], np.sort(exact), rtol=1e-9)
    free = chain.run_modal(wf.Modal(interface="frictionless")).data["mode_frequency"]
    np.testing.assert_allclose(
        free, np.sort(np.sqrt(np.linalg.eigvals(np.linalg.solve(M, K)))) / (2.0 * np.pi), rtol=1e-9
    )


@pytest.mark.parametrize("suffix", [".npz", ".mat"])
def test_a_structure_comes_back_from_its_file(tmp_path: Path, suffix: str) -> None:
    joints = [
        *JOINTS, wf.joints.Gap(at=1, stiffness=1e5, gap=1e-3),
        wf.joints.Iwan(at=0, stiffness=1e3, limit=1.0, chi=-0.5),
        wf.joints.Spring(at=1, coefficients=(0.0, 0.0, 1e9), length=1e-4),
    ]  # fmt: skip
    chain = wf.structure(K, M, joints, damping=[0.01, 0.02], force=[0.0, 2.0], probes={"first": 0})
    system, state = load_system(chain.save(tmp_path / f"chain{suffix}"))
    assert state is not None
    np.testing.assert_array_equal(system.force, chain.system.force)
    np.testing.assert_array_equal(system.influence, chain.system.influence)
    assert system.rigid_motion("first") == 0.0
    for name in ("jump", "traction", "elastic_slip", "status"):
        np.testing.assert_array_equal(getattr(state, name), getattr(chain.rest, name))
    for found, given in zip(system.interfaces, chain.system.interfaces, strict=True):
        assert found.friction == given.friction
        assert (found.operator != given.operator).nnz == 0


def test_the_file_of_a_structure_is_named_by_its_content() -> None:
    one, same, other = (wf.structure(K, M, JOINTS, damping=ratio).file for ratio in (0.01, 0.01, 0.02))
    assert one == same != other


def test_rows_of_places() -> None:
    np.testing.assert_array_equal(row_of(1, 3), [0, 1, 0])
    np.testing.assert_array_equal(row_of((2, 0), 3), [-1, 0, 1])
    np.testing.assert_array_equal(row_of([0.5, 0.5], 2), [0.5, 0.5])
    np.testing.assert_array_equal(row_of((1, 0), 2), [-1, 1])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: wf.structure(K[:1], M), r"stiffness: has the shape \(1, 2\); give a square matrix"),
        (lambda: wf.structure(K, np.eye(3)), r"mass: stiffness \(2, 2\) and mass \(3, 3\) differ"),
        (lambda: wf.structure([[1.0, 2.0], [0.0, 1.0]], M), "stiffness: holds one triangle only"),
        (lambda: wf.structure(K, np.diag([1.0, 0.0]), force={0: 1.0}), "mass: is singular, but a force needs"),
        (lambda: wf.structure(K, M, force={0: 1.0}, influence=[1, 1]), "force: is given with influence"),
        (lambda: wf.structure(K, M, force=[1.0]), r"force: has the shape \(1,\)"),
        (lambda: wf.structure(K, M, [wf.joints.Jenkins(at=2, stiffness=1.0, limit=1.0)]), "degree of freedom 2, but"),
        (lambda: wf.joints.Jenkins(at=0, stiffness=1.0), "limit: Jenkins: give either the limit, or mu"),
        (lambda: wf.joints.Jenkins(at=0, stiffness=-1.0, limit=1.0), "stiffness is -1; give a positive number"),
        (lambda: wf.joints.Iwan(at=0, stiffness=1.0, limit=1.0, chi=-1.0), "chi is -1; give a number above -1"),
        (lambda: wf.joints.Spring(at=0, coefficients=(1.0,)), "no nonlinear coefficient"),
        (lambda: wf.joints.Spring(at=0, coefficients=(0.0, 0.0, 1.0)), "typical displacement is unknown; give length"),
        (lambda: wf.joints.Gap(at=0, stiffness=1.0, gap=-1.0, both=True), "gap is -1 with stops on both sides"),
        (lambda: wf.joints.BoucWen(at=0, stiffness=1.0, limit=1.0, exponent=0.5).points(1), "exponent 0.5 is below 1"),
    ],
)  # fmt: skip
def test_wrong_input_is_told(make, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(wf.InputError, match=message):
        make()


def test_a_structure_that_nothing_holds_is_refused_on_a_shaken_base() -> None:
    """Two masses that a spring joins; a joint to the base holds them, and a force may act on the free ones."""
    free, loose = 1e4 * np.array([[1.0, -1.0], [-1.0, 1.0]]), wf.joints.Jenkins(at=(1, 0), stiffness=1e3, limit=1.0)
    with pytest.raises(wf.InputError, match="K: leaves a motion free that needs no force"):
        wf.structure(free, M, [loose], damping=0.02).run_harmonic(BAND)
    held = wf.joints.Jenkins(at=0, stiffness=1e3, limit=1e3)
    assert wf.structure(free, M, [held], damping=0.02).run_harmonic(BAND).f_n_hz is not None
    pushed = wf.structure(free, M, [loose], damping=0.02, force={1: 0.1}).run_harmonic(BAND)
    assert float(pushed.data["tip_amplitude"].max()) > 0.0


def python_of(page: str, heading: str) -> str:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8").split(f"## {heading}")[1]
    return text.split("```python\n")[1].split("```")[0]


def test_the_example_of_the_page_runs_and_takes_eight_lines(capsys: pytest.CaptureFixture[str]) -> None:
    program = python_of("joints.md", "Two joints in a chain")
    assert len([line for line in program.splitlines() if line.strip()]) <= 8
    names: dict[str, Any] = {}
    exec(program, names)
    assert names["result"].data["interface_name"].values.tolist() == ["jenkins_1", "jenkins_2"]
    assert names["chain"].system.n_dofs == 2
    assert "Hz, zeta" in capsys.readouterr().out


def test_a_law_of_the_user_is_registered_from_outside(tmp_path: Path) -> None:
    """In a process of its own: compiled into a cache of its own, saved to a file and read from it; too late is told."""
    program = (
        python_of("joints.md", "A law of your own")
        + f"""
chain = wf.structure([[1e4]], [[1.0]], [joint], damping=0.01)
from wroll_fem.dynamics.system.io import load_system
assert load_system(chain.save({str(tmp_path / "chain.npz")!r}))[0].interfaces[0].friction == joint.law
words = ["contact.friction={{law: dahl, mu: 0.25, elastic_slip: 1e-6}}"]
friction = wf.load_case({str(CONFIGS / "tiny.yaml")!r}, words).friction
assert (friction.law, friction.mu) == ("dahl", 0.25)
try:
    wf.register_law(type("Late", (wf.FrictionLaw,), {{"name": "late"}}))
except wf.InputError as error:
    print(error)
"""
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(tmp_path)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "the friction law 'late' comes too late" in done.stdout
    assert list((tmp_path / "wroll_fem" / "laws").glob("*/*"))


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
def test_a_structure_without_joints_is_the_linear_oscillator() -> None:
    """It could not be run: the file of its matrices named an interface that it does not have."""
    zeta, hertz = 0.02, 10.0
    plain = wf.structure([[(2.0 * np.pi * hertz) ** 2]], [[1.0]], damping=zeta)
    found = plain.run_harmonic(wf.Chirp(f_start=8, f_end=12, rate_oct_per_min=1, amplitude=1.0))
    assert found.f_n_hz == pytest.approx(hertz, rel=1e-3)
    size = np.hypot(found.data["transmissibility_real"], found.data["transmissibility_imag"]).values
    ratio = found.data["frequency"].values / hertz
    exact = np.abs((1.0 + 2j * zeta * ratio) / (1.0 - ratio**2 + 2j * zeta * ratio))
    np.testing.assert_allclose(size, exact, rtol=0.01)
    dwell = plain.run_dwell(wf.Dwell(amplitude=1.0, frequency=8.0, cycles=60))
    assert dwell.data.attrs["steady_magnitude"] == pytest.approx(1.0 / (1.0 - 0.64), rel=0.01)
