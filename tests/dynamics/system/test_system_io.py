"""Systems as files: round trip, and hand-written matrices end to end."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
import xarray as xr
import yaml
from scipy.integrate import solve_ivp
from support.empty_figures import empty_figures
from support.exact_systems import contact_point, dense_system
from support.paths import ROOT
from support.structures import DWELL, FORCE, GAMMA, MASS, MU, K, oscillator, write_case, wroll

from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.case import Case, example_case, load_case
from wroll_fem.contact.interface import Interface, NormalPenalty, PenaltyCoulomb, RateCoulomb
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.io import load_system, save_system, system_size
from wroll_fem.dynamics.system.modal_damping import ModalDamping
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import load_dataset
from wroll_fem.signals.motions import base_motion

BOTH = pytest.mark.parametrize("suffix", [".npz", ".mat"])
SHORT = DWELL | {"cycles": 2.0, "ramp_cycles": 1.0}


def equal(a: sp.spmatrix, b: sp.spmatrix) -> bool:
    """Same entries, stored in the same order."""
    a, b = sp.csr_matrix(a), sp.csr_matrix(b)
    return a.shape == b.shape and all(np.array_equal(getattr(a, k), getattr(b, k)) for k in ("data", "indices"))


def check_same(a: System, b: System) -> None:
    assert equal(a.stiffness, b.stiffness)
    assert equal(a.mass, b.mass)
    assert (a.damping is None) == (b.damping is None)
    if a.damping is not None:
        assert equal(a.damping, b.damping)
    np.testing.assert_array_equal(a.influence, b.influence)
    for one, other in ((a.probes, b.probes), (a.loads, b.loads)):
        assert set(one) == set(other)
        for name in one:
            np.testing.assert_array_equal(one[name], other[name])
    assert len(a.interfaces) == len(b.interfaces)
    for one, other in zip(a.interfaces, b.interfaces, strict=True):
        assert (one.name, one.friction, one.normal) == (other.name, other.friction, other.normal)
        assert equal(one.operator, other.operator)
        np.testing.assert_array_equal(one.areas, other.areas)
        np.testing.assert_array_equal(one.points, other.points)
    assert len(a.subspaces) == len(b.subspaces)
    for one, other in zip(a.subspaces, b.subspaces, strict=True):
        assert (one.harmonic, one.even) == (other.harmonic, other.even)
        assert equal(one.basis, other.basis)


def check_same_state(a: ContactState, b: ContactState | None) -> None:
    assert b is not None
    for name in ("displacement", "jump", "elastic_slip", "traction", "status"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)


def two_interfaces() -> System:
    """Three masses, an interface of one point and one of two with other laws; damping, a second load and probe."""
    k = 1.0e4 * np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, 0.1], [0.0, 0.1, 1.0]])
    first = replace(contact_point([0, 0, 1], [-1, 1, 0], [0, 0, 0], mu=0.3, gamma=1e-6, kn=1e8), name="a/b")
    rows = [[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, 0.5], [0.1, 0, 0], [0, 0.7, 0]]
    law = RateCoulomb(0.4, 2.0e-6, (0.0, 1.0e-3, 0.1), (0.4, 0.3, 0.2))
    second = Interface("b/c", sp.csr_matrix(np.array(rows)), np.array([0.1, 0.3]), np.full((2, 3), np.nan), law,
                       NormalPenalty(3.0e7, separation=False))  # fmt: skip
    system = dense_system(k, np.diag([1.0, 0.5, 1 / 3]), [1, 1, 0], first, second, tip=[0, 1, 0], preload=[0, 0, -9.1])
    return replace(
        system,
        damping=sp.csr_matrix(1.0e-4 * k),
        loads=dict(system.loads) | {"gravity": np.array([0.0, 0.0, -1.0 / 7.0])},
        probes=dict(system.probes) | {"root": np.array([1.0, 0.0, 0.0])},
    )


# ---- round trip ------------------------------------------------------------------------------------------------------


@BOTH
@pytest.mark.parametrize("kind", ["ratios", "table", "loss"])
def test_damping_ratios_of_modes_come_back(tmp_path: Path, suffix: str, kind: str) -> None:
    system = two_interfaces()
    given = {
        "ratios": (0.01, 0.02),
        "table": ((10.0, 0.01), (20.0, 0.03)),
        "loss": sp.csr_matrix(0.1 * system.stiffness),
    }
    damped = replace(system, modal_damping=ModalDamping(**{kind: given[kind]}))
    again = load_system(save_system(damped, tmp_path / f"system{suffix}"))[0].modal_damping
    assert again is not None
    assert (again.ratios, again.table) == (damped.modal_damping.ratios, damped.modal_damping.table)
    assert (again.loss is None) == (kind != "loss")
    if kind == "loss":
        assert equal(again.loss, damped.modal_damping.loss)


@BOTH
def test_systems_come_back_bit_by_bit(tmp_path: Path, suffix: str) -> None:
    system = two_interfaces()
    state = solve_preload(system)
    path = save_system(system, tmp_path / f"system{suffix}", preload=state)
    again, state_again = load_system(path)
    check_same(system, again)
    check_same_state(state, state_again)
    assert system_size(path) == (3, 3)


@pytest.fixture(scope="module")
def roll() -> tuple[Case, System, ContactState]:
    """The lab roll on a coarse mesh, condensed."""
    case = example_case().changed("solver.method=condensed", "excitation.amplitude=20.0")
    return case, *prepare(case, SilentProgress())


@pytest.fixture(scope="module")
def moved(roll: Any) -> xr.Dataset:
    """History of the roll."""
    return run_analysis(roll[0], progress=SilentProgress())


@BOTH
def test_a_roll_comes_back_with_its_symmetry(tmp_path: Path, suffix: str, roll: Any) -> None:
    _, system, state = roll
    again, state_again = load_system(save_system(system, tmp_path / f"roll{suffix}", preload=state))
    check_same(system, again)
    check_same_state(state, state_again)
    assert len(again.subspaces) > 3


@BOTH
def test_an_exported_roll_moves_like_the_roll_itself(tmp_path: Path, suffix: str, roll: Any, moved: xr.Dataset) -> None:
    """Exported by the command line and run through `structure`: the numbers of the direct case to the last bit."""
    direct: Case = roll[0]
    (tmp_path / "roll.yaml").write_text(direct.resolved_yaml(), encoding="utf-8")
    done = wroll("export", tmp_path / "roll.yaml", "--out", tmp_path / f"roll{suffix}")
    assert done.exit_code == 0, done.output
    assert re.search(rf"roll{suffix}: {roll[1].n_dofs} DOFs, {roll[1].n_points} contact points, [\d.]+ MB", done.output)
    data = direct.resolved()
    for section in ("geometry", "mandrel", "coil", "mesh", "preload", "contact"):
        del data[section]
    del data["excitation"]["direction"]
    case = Case.model_validate(data | {"structure": {"file": str(tmp_path / f"roll{suffix}")}})
    assert Case.model_validate(yaml.safe_load(case.resolved_yaml())) == case
    found = run_analysis(case, progress=SilentProgress())
    assert float(moved["friction_energy"][-1]) > 0.0
    for name in ("tip_displacement", "tip_acceleration", "friction_energy", "cumulative_slip", "theta_rad", "z_m"):
        np.testing.assert_array_equal(found[name].values, moved[name].values, err_msg=name)


# ---- matrices written by hand ----------------------------------------------------------------------------------------


def jenkins_history(time: np.ndarray, acceleration: Any) -> np.ndarray:
    """Displacement of the oscillator with a Jenkins element, each stick and slip phase integrated to 1e-9.

    Stick: m u'' = -m a_g - k u - (F / gamma) (u - s); slip: the element carries F = mu N against the motion until
    the velocity vanishes.
    """
    limit = MU * FORCE

    def ground(t: float) -> float:
        return float(acceleration(np.array([t]))[0])

    now, state, anchor, sign, result = 0.0, np.zeros(2), 0.0, 0, np.zeros_like(time)
    while now < time[-1] - 1e-12:
        if sign == 0:

            def force(u: float, anchor: float = anchor) -> float:
                return limit / GAMMA * (u - anchor)

            def event(t: float, y: np.ndarray, anchor: float = anchor) -> float:
                return limit / GAMMA * abs(y[0] - anchor) - limit

            event.direction = 1  # type: ignore[attr-defined]
        else:

            def force(u: float, sign: int = sign) -> float:  # type: ignore[misc]
                return sign * limit

            def event(t: float, y: np.ndarray, anchor: float = anchor) -> float:
                return float(y[1])

            event.direction = -sign  # type: ignore[attr-defined]
        event.terminal = True  # type: ignore[attr-defined]
        phase = solve_ivp(
            lambda t, y, force=force: [y[1], -ground(t) - (K * y[0] + force(y[0])) / MASS],
            [now, time[-1]], state, events=event, rtol=1e-9, atol=1e-13, dense_output=True, max_step=2e-3,
        )  # fmt: skip
        here = (time >= now) & (time <= phase.t[-1])
        result[here] = phase.sol(time[here])[0]
        now, state = phase.t[-1], phase.y[:, -1]
        sign, anchor = (int(np.sign(state[0] - anchor)), anchor) if sign == 0 else (0, state[0] - sign * GAMMA)
    return result


@pytest.mark.parametrize("method", ["condensed", pytest.param("full", marks=pytest.mark.slow)])
def test_a_hand_written_oscillator_follows_the_exact_jenkins_element(tmp_path: Path, method: str) -> None:
    """`wroll run` on ten lines of matrices against stick and slip phases integrated on their own.

    200 steps per cycle leave 0.2 % of the amplitude (second order in the step, and corners inside steps).
    A steady cycle loses 4 mu N (X - gamma*).
    """
    path = write_case(
        tmp_path, oscillator(), solver={"method": method}, excitation=DWELL | {"cycles": 10.0, "ramp_cycles": 2.0},
        integrator={"scheme": "no_damping", "steps_per_cycle": 200}, output={"figures": False},
    )  # fmt: skip
    done = wroll("run", path, "--out", tmp_path / "run")
    assert done.exit_code == 0, done.output
    result = load_dataset(tmp_path / "run" / "results.nc")
    exact = jenkins_history(result["time"].values, base_motion(load_case(path).excitation).acceleration)
    amplitude = np.abs(exact[-200:]).max()
    assert amplitude > 50 * GAMMA
    np.testing.assert_allclose(result["tip_displacement"].values, exact, atol=3e-3 * amplitude)
    friction = result["friction_energy"].values
    loss = 4.0 * MU * FORCE * (np.abs(result["tip_displacement"].values[-200:]).max() - GAMMA)
    assert friction[-1] - friction[-201] == pytest.approx(loss, rel=3e-3)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["interface_pressure_mean_pa"] == pytest.approx([FORCE], rel=1e-6)
    assert summary["dofs"] == 2


def test_the_ten_lines_of_the_docs_make_the_example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "docs" / "matrices.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    lines = [line for line in block.splitlines() if line.strip() and not line.startswith("import")]
    assert len(lines) <= 10
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "matrices.md", "exec"), {})
    system, state = load_system("oscillator.mat")
    assert state is None
    check_same(system, load_system(ROOT / "configs" / "oscillator.mat")[0])
    names = set(re.findall(r"\b(?:interface_1_\w+|load_\w+|probe_\w+|influence)\b", block))
    matlab = re.findall(r"```matlab\n(.*?)```", text, flags=re.DOTALL)[0]
    assert all(len(re.findall(rf"\b{name}\b", matlab)) == 2 for name in names)  # assigned and saved


def test_pressure_alone_is_a_preload_state(tmp_path: Path) -> None:
    """A known contact pressure gives the motion that solving for it gives."""
    solved, given = (
        run_analysis(load_case(write_case(tmp_path, fields, excitation=SHORT)), progress=SilentProgress())
        for fields in (oscillator(), oscillator(load_preload=None, interface_1_preload_pressure=FORCE))
    )
    amplitude = np.abs(solved["tip_displacement"].values).max()
    np.testing.assert_allclose(given["tip_displacement"], solved["tip_displacement"], atol=1e-7 * amplitude)


def test_sparse_rows_columns_integers_and_strange_shapes_are_accepted(tmp_path: Path) -> None:
    write_case(tmp_path, oscillator())
    plain, state = load_system(tmp_path / "structure.mat")
    assert state is None
    other = oscillator(
        K=sp.csc_matrix(np.diag([K, 0.0])), M=np.eye(2, dtype=np.int32), influence=np.array([[1.0], [0.0]]),
        probe_tip=sp.csc_matrix([[1.0, 0.0]]), interface_1_area=[[1.0]], user_note="mine", wroll_format=1,
    )  # fmt: skip
    write_case(tmp_path, other)
    check_same(plain, load_system(tmp_path / "structure.mat")[0])
    np.savez(tmp_path / "dense.npz", **oscillator())
    check_same(plain, load_system(tmp_path / "dense.npz")[0])


@pytest.mark.parametrize("method", ["full", "condensed", "reduced"])
def test_viscous_damping_of_a_file_acts(tmp_path: Path, method: str) -> None:
    """Without friction a steady sine answers with T = sqrt((1 + (2 zeta r)^2) / ((1 - r^2)^2 + (2 zeta r)^2))."""
    zeta, ratio = 0.1, 11.0 * 2 * np.pi / np.sqrt(K / MASS)
    fields = oscillator(C=np.diag([2 * zeta * np.sqrt(K * MASS), 0.0]), interface_1_friction_mu=0.0)
    dwell = DWELL | {"cycles": 16.0, "ramp_cycles": 3.0}
    path = write_case(
        tmp_path, fields, solver={"method": method}, integrator={"scheme": "no_damping"}, excitation=dwell
    )
    history = run_analysis(load_case(path), progress=SilentProgress())
    # C relative to the base: the absolute acceleration of the tip is -(k u + c v) / m
    viscous = 2 * zeta * ratio
    expected = np.sqrt((1 + viscous**2) / ((1 - ratio**2) ** 2 + viscous**2))
    assert history.attrs["steady_magnitude"] == pytest.approx(expected, rel=5e-3)  # 40 steps per cycle: (w dt)^2 / 12


def test_modes_of_a_structure_are_those_of_its_spring_and_contact(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Frictionless: sqrt(k / m); stuck: k + mu N / gamma* (the mass normal to the ground rides on the penalty)."""
    empty_figures(monkeypatch)
    for interface, stiffness in (("frictionless", K), ("stuck", K + MU * FORCE / GAMMA)):
        path = write_case(tmp_path, oscillator(), analysis="modal", modal={"count": 12, "interface": interface})
        modes = run_analysis(load_case(path), progress=SilentProgress())
        expected = np.sqrt(np.sort([stiffness / MASS, 1.0e8 / MASS])) / (2 * np.pi)
        np.testing.assert_allclose(modes["mode_frequency"], expected, rtol=1e-8)
        np.testing.assert_allclose(modes["effective_mass_fraction"], [1.0, 0.0], atol=1e-12)
    done = wroll("run", path, "--out", tmp_path / "modes")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "modes" / "figures" / "modes.png").is_file()


def test_points_without_a_place_give_results_but_no_maps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Interfaces of different size, without coordinates: everything but slip maps."""
    empty_figures(monkeypatch)
    system = replace(two_interfaces(), damping=None)
    save_system(system, tmp_path / "system.npz")
    path = write_case(tmp_path, oscillator(), structure={"file": "system.npz"}, excitation=SHORT,
                      output={"every": 40})  # fmt: skip
    done = wroll("run", path, "--out", tmp_path / "run")
    assert done.exit_code == 0, done.output
    result = load_dataset(tmp_path / "run" / "results.nc")
    assert "theta_rad" not in result.variables
    assert result["cumulative_slip"].shape == (2, 2)
    assert np.isnan(result["area"].values).tolist() == [[False, True], [False, False]]
    assert result["relative_displacement_hoop"].shape == (2, 2, 2)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    np.testing.assert_allclose(summary["interface_pressure_mean_pa"], _mean_pressures(system), rtol=1e-9)
    assert list((tmp_path / "run" / "figures").iterdir())
    assert not any(name.name.startswith("slip") for name in (tmp_path / "run").rglob("*.*"))


def _mean_pressures(system: System) -> list[float]:
    pressure = solve_preload(system).pressure
    area = np.array([0.1, 0.3])
    return [float(pressure[0]), float(pressure[1:] @ area / area.sum())]


def test_interfaces_with_places_of_their_own_are_mapped_one_by_one(roll: Any, tmp_path: Path) -> None:
    """Two interfaces of a roll that do not share their points: each keeps its coordinates, and its map."""
    from wroll_fem.dynamics.time_stepping.fields import interface_fields
    from wroll_fem.plotting.slip import interface_name
    from wroll_fem.results.interface_slip import has_surface, surface

    _, system, _ = roll
    one = system.interfaces[0]
    keep = one.points[:, 1] > 0.1
    rows = np.repeat(3 * np.flatnonzero(keep), 3) + np.tile([0, 1, 2], keep.sum())
    upper = replace(one, operator=one.operator[rows], areas=one.areas[keep], points=one.points[keep])
    both = replace(system, interfaces=(one, upper), subspaces=())
    fields = interface_fields(both, ContactState.unloaded(both))
    assert fields["theta_rad"].dims == ("interface", "point")
    assert interface_name(0, fields) == interface_name(0) == "mandrel and layer 1"
    assert (
        interface_name(0, fields.assign_coords(interface_name=("interface", ["lid", "lid"]))) == "the surfaces of lid"
    )
    assert [has_surface(fields, k) for k in (0, 1)] == [True, True]
    areas = [surface(fields, k, "area") for k in (0, 1)]
    assert areas[1].z.min() == pytest.approx(one.points[keep, 1].min())
    assert np.isfinite(areas[1].values["area"]).all()
    assert areas[0].theta.size > areas[1].theta.size


# ---- laws of the case file -------------------------------------------------------------------------------------------


def test_new_laws_solve_the_preload_again_or_say_that_they_cannot(roll: Any, tmp_path: Path) -> None:
    """Friction loaded while the layer was pressed on belongs to its law."""
    _, system, state = roll
    weaker = PenaltyCoulomb(0.05, 1e-6)
    path = save_system(system, tmp_path / "roll.npz", preload=state)
    assert load_system(path)[1] is not None
    assert load_system(path, friction=system.interfaces[0].friction)[1] is not None
    assert load_system(path, friction=weaker)[1] is None
    path = save_system(replace(system, loads={}), tmp_path / "roll.npz", preload=state)
    with pytest.raises(InputError, match=r"does not follow from its laws: tractions differ by .*; give load_preload"):
        load_system(path, friction=weaker)


def test_the_hash_follows_the_content_of_the_file_and_not_its_place(tmp_path: Path) -> None:
    def case(folder: str, **changes: Any) -> Case:
        (tmp_path / folder).mkdir()
        path = write_case(tmp_path / folder, {})
        np.savez(tmp_path / folder / "s.npz", **oscillator(**changes))
        return load_case(path, [f"structure.file={tmp_path / folder / 's.npz'}"])

    one, same, other = case("a"), case("b"), case("c", M=2.0 * np.eye(2))
    assert load_case(tmp_path / "a" / "case.yaml").structure.file == (tmp_path / "a" / "structure.mat").resolve()  # type: ignore[union-attr]
    assert one.hash() == same.hash()
    assert one.hash() != other.hash()
