"""Systems as files: round trip, hand-written matrices end to end, and the one line that says what is wrong."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
import xarray as xr
import yaml
from exact_systems import contact_point, dense_system, slipping_pair
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.preparation import prepare
from wroll_fem.case import Case, example_case, load_case
from wroll_fem.cli import app
from wroll_fem.contact.interface import Interface, NormalPenalty, PenaltyCoulomb, RateCoulomb, SmoothedCoulomb
from wroll_fem.dynamics.static import ContactState, solve_preload
from wroll_fem.dynamics.system import System
from wroll_fem.dynamics.system_io import load_system, save_system, system_size
from wroll_fem.errors import InputError
from wroll_fem.progress import SilentProgress
from wroll_fem.results import load_dataset
from wroll_fem.signals.base_motion import base_motion

ROOT = Path(__file__).parents[1]
BOTH = pytest.mark.parametrize("suffix", [".npz", ".mat"])
DWELL = {"kind": "dwell", "amplitude": 6.0, "frequency": 11.0, "cycles": 30.0, "ramp_cycles": 5.0}

K, MASS, FORCE, MU, GAMMA = 1.0e4, 1.0, 10.0, 0.3, 1.0e-5
"""Spring N/m, mass kg, pressing force N, coefficient, elastic slip m of the hand-written oscillator."""


def oscillator(**changes: Any) -> dict[str, Any]:
    """Fields of docs/matrices.md for a mass on a spring, pressed onto the ground; None takes a field out."""
    fields = {
        "K": np.diag([K, 0.0]), "M": MASS * np.eye(2), "influence": [1, 0], "probe_tip": [1, 0],
        "load_preload": [0, -FORCE], "interface_1_operator": [[0, 1], [1, 0], [0, 0]], "interface_1_area": 1,
        "interface_1_friction_law": "penalty_coulomb", "interface_1_friction_mu": MU,
        "interface_1_friction_elastic_slip": GAMMA, "interface_1_normal_stiffness": 1.0e8,
    } | changes  # fmt: skip
    return {name: value for name, value in fields.items() if value is not None}


def write_case(folder: Path, fields: dict[str, Any], **sections: Any) -> Path:
    """Case file with its .mat beside it."""
    scipy.io.savemat(folder / "structure.mat", fields)
    data = {
        "analysis": "dwell",
        "structure": {"file": "structure.mat"},
        "excitation": DWELL,
        "solver": {"method": "condensed"},
    } | sections
    path = folder / "case.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return path


def wroll(*words: object) -> Any:
    return CliRunner().invoke(app, [str(word) for word in words])


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
def test_systems_come_back_bit_by_bit(tmp_path: Path, suffix: str) -> None:
    system = two_interfaces()
    state = solve_preload(system)
    path = save_system(system, tmp_path / f"system{suffix}", preload=state)
    again, state_again = load_system(path)
    check_same(system, again)
    check_same_state(state, state_again)
    assert system_size(path) == (3, 3)


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


@pytest.fixture(scope="module")
def roll() -> tuple[Case, System, ContactState]:
    """The lab roll on a coarse mesh, condensed."""
    case = example_case().changed("solver.method=condensed", "excitation.amplitude=20.0")
    return case, *prepare(case, SilentProgress())


@BOTH
def test_a_roll_comes_back_with_its_symmetry(tmp_path: Path, suffix: str, roll: Any) -> None:
    _, system, state = roll
    again, state_again = load_system(save_system(system, tmp_path / f"roll{suffix}", preload=state))
    check_same(system, again)
    check_same_state(state, state_again)
    assert len(again.subspaces) > 3


@BOTH
def test_an_exported_roll_moves_like_the_roll_itself(tmp_path: Path, suffix: str, roll: Any) -> None:
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
    runs = [run_analysis(c, progress=SilentProgress()) for c in (direct, case)]
    assert float(runs[0]["friction_energy"][-1]) > 0.0
    for name in ("tip_displacement", "tip_acceleration", "friction_energy", "cumulative_slip", "theta_rad", "z_m"):
        np.testing.assert_array_equal(runs[1][name].values, runs[0][name].values, err_msg=name)


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


@pytest.mark.parametrize("method", ["condensed", "full"])
def test_a_hand_written_oscillator_follows_the_exact_jenkins_element(tmp_path: Path, method: str) -> None:
    """`wroll run` on ten lines of matrices against stick and slip phases integrated on their own.

    200 steps per cycle leave 0.2 % of the amplitude (second order in the step, and corners inside steps).
    A steady cycle loses 4 mu N (X - gamma*).
    """
    path = write_case(
        tmp_path, oscillator(), solver={"method": method}, excitation=DWELL | {"cycles": 16.0},
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
        run_analysis(load_case(write_case(tmp_path, fields)), progress=SilentProgress())
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


def test_viscous_damping_of_a_file_acts(tmp_path: Path) -> None:
    """Without friction a steady sine answers with T = sqrt((1 + (2 zeta r)^2) / ((1 - r^2)^2 + (2 zeta r)^2))."""
    zeta, ratio = 0.1, 11.0 * 2 * np.pi / np.sqrt(K / MASS)
    fields = oscillator(C=np.diag([2 * zeta * np.sqrt(K * MASS), 0.0]), interface_1_friction_mu=0.0)
    path = write_case(tmp_path, fields, solver={"method": "full"}, integrator={"scheme": "no_damping"})
    history = run_analysis(load_case(path), progress=SilentProgress())
    # C relative to the base: the absolute acceleration of the tip is -(k u + c v) / m
    viscous = 2 * zeta * ratio
    expected = np.sqrt((1 + viscous**2) / ((1 - ratio**2) ** 2 + viscous**2))
    assert history.attrs["steady_magnitude"] == pytest.approx(expected, rel=5e-3)  # 40 steps per cycle: (w dt)^2 / 12
    done = wroll("run", path, "--set", "solver.method=condensed", "--out", tmp_path / "run")
    assert done.exit_code == 2
    assert "solver.method: condensed time stepping has no viscous damping; use full, or harmonic" in done.output


def test_modes_of_a_structure_are_those_of_its_spring_and_contact(tmp_path: Path) -> None:
    """Frictionless: sqrt(k / m); stuck: k + mu N / gamma* (the mass normal to the ground rides on the penalty)."""
    for interface, stiffness in (("frictionless", K), ("stuck", K + MU * FORCE / GAMMA)):
        path = write_case(tmp_path, oscillator(), analysis="modal", modal={"count": 12, "interface": interface})
        modes = run_analysis(load_case(path), progress=SilentProgress())
        expected = np.sqrt(np.sort([stiffness / MASS, 1.0e8 / MASS])) / (2 * np.pi)
        np.testing.assert_allclose(modes["mode_frequency"], expected, rtol=1e-8)
        np.testing.assert_allclose(modes["effective_mass_fraction"], [1.0, 0.0], atol=1e-12)
    done = wroll("run", path, "--out", tmp_path / "modes")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "modes" / "figures" / "modes.png").is_file()


def test_points_without_a_place_give_results_but_no_maps(tmp_path: Path) -> None:
    """Interfaces of different size, without coordinates: everything but slip maps."""
    system = replace(two_interfaces(), damping=None)
    save_system(system, tmp_path / "system.npz")
    path = write_case(tmp_path, oscillator(), structure={"file": "system.npz"}, excitation=DWELL | {"cycles": 6.0},
                      output={"every": 100})  # fmt: skip
    done = wroll("run", path, "--out", tmp_path / "run")
    assert done.exit_code == 0, done.output
    result = load_dataset(tmp_path / "run" / "results.nc")
    assert "theta_rad" not in result.variables
    assert result["cumulative_slip"].shape == (2, 2)
    assert np.isnan(result["area"].values).tolist() == [[False, True], [False, False]]
    assert result["relative_displacement_hoop"].shape == (2, 2, 2)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    np.testing.assert_allclose(summary["interface_pressure_mean_pa"], _mean_pressures(system), rtol=1e-9)
    assert not any(name.name.startswith("slip") for name in (tmp_path / "run").rglob("*.*"))


def _mean_pressures(system: System) -> list[float]:
    pressure = solve_preload(system).pressure
    area = np.array([0.1, 0.3])
    return [float(pressure[0]), float(pressure[1:] @ area / area.sum())]


def test_interfaces_with_places_of_their_own_are_mapped_one_by_one(roll: Any, tmp_path: Path) -> None:
    """Two interfaces of a roll that do not share their points: each keeps its coordinates, and its map."""
    from wroll_fem.dynamics.fields import interface_fields
    from wroll_fem.plotting.slip import interface_name
    from wroll_fem.slip import has_surface, surface

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


def friction_of(path: Path, *overrides: str) -> float:
    return float(run_analysis(load_case(path, overrides), progress=SilentProgress())["friction_energy"][-1])


def test_contact_in_the_case_replaces_the_laws_of_the_file(tmp_path: Path) -> None:
    """The same friction written in the case changes nothing; another one is that of a file that holds it."""
    own = friction_of(write_case(tmp_path, oscillator()))
    same = {"friction": {"mu": MU, "elastic_slip": GAMMA}}
    assert friction_of(write_case(tmp_path, oscillator(), contact=same)) == own
    weak = friction_of(write_case(tmp_path, oscillator(interface_1_friction_mu=0.1)))
    written = {"friction": {"mu": 0.1, "elastic_slip": GAMMA}, "normal": {"penalty": "auto"}}
    path = write_case(tmp_path, oscillator(), contact=written)
    assert friction_of(path) == weak != own
    lawless = oscillator(**{name: None for name in oscillator() if "friction" in name})
    assert friction_of(write_case(tmp_path, lawless, contact=same)) == own
    stiff = friction_of(write_case(tmp_path, oscillator(interface_1_normal_stiffness=2.0e8)))
    path = write_case(tmp_path, oscillator(), contact=same | {"normal": {"penalty": 2.0e8}})
    assert friction_of(path) == stiff


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


# ---- what is wrong, in one line --------------------------------------------------------------------------------------


UP = np.array([[K, 5.0], [0.0, 1.0]])
WRONG = {
    "no K": ({"K": None}, "K: required field is missing; add it (stiffness matrix, N/m)"),
    "no M": ({"M": None}, "M: required field is missing; add it (mass matrix, kg)"),
    "no influence": ({"influence": None}, "influence: required field is missing; add it (displacement of each DOF"),
    "no tip": ({"probe_tip": None}, "probe_tip: required field is missing; add it (row that gives the displacement"),
    "no operator": ({"interface_1_operator": None}, "interface_1_operator: required field is missing"),
    "no area": ({"interface_1_area": None}, "interface_1_area: required field is missing; add it (area of each point"),
    "no law": ({"interface_1_friction_law": None}, "interface_1_friction_law: required field is missing"),
    "no mu": ({"interface_1_friction_mu": None}, "interface_1_friction_mu: required field is missing"),
    "no kn": ({"interface_1_normal_stiffness": None}, "interface_1_normal_stiffness: required field is missing"),
    "K not square": ({"K": np.ones((2, 3))}, "K: is 2 x 3, not 2 x 2; write the stiffness matrix"),
    "M too large": ({"M": np.eye(3)}, "M: is 3 x 3, not 2 x 2; write the mass matrix, kg"),
    "influence too long": ({"influence": [1, 0, 0]}, "influence: is 1 x 3, not 2 values; write the displacement"),
    "influence table": ({"influence": np.eye(2)}, "influence: is 2 x 2, not 2 values"),
    "operator short": ({"interface_1_operator": [[0, 1], [1, 0]]}, "interface_1_operator: is 2 x 2, not 3 x 2"),
    "points": ({"interface_1_points": [0, 0]}, "interface_1_points: is 1 x 2, not 1 x 3; write the theta (rad)"),
    "one triangle": ({"K": UP}, "K: holds one triangle only; write the whole matrix"),
    "unsymmetric": ({"K": [[K, 5.0], [4.0, 1.0]]}, "K: is not symmetric: entries (0, 1) and (1, 0), counted from 0"),
    "negative mass": ({"M": np.diag([1.0, -1.0])}, "M: is not positive semi-definite: diagonal entry 1, counted"),
    "indefinite mass": ({"M": [[1.0, 2.0], [2.0, 1.0]]}, "M: is not positive semi-definite: it has a negative eigen"),
    "hollow mass": ({"M": [[1.0, 0.1], [0.1, 0.0]]}, "M: is not positive semi-definite: row 1, counted from 0, has"),
    "negative damping": ({"C": np.diag([1.0, -1.0])}, "C: is not positive semi-definite"),
    "negative stiffness": ({"K": np.diag([-K, 0.0])}, "K: is not positive semi-definite: diagonal entry 0"),
    "massless": ({"M": np.diag([1.0, 0.0])}, "M: is singular: 1 DOFs carry no mass; condense these DOFs"),
    "singular mass": ({"M": np.ones((2, 2))}, "M: is singular; condense these DOFs before (Guyan)"),
    "NaN": ({"K": np.diag([K, np.nan])}, "K: holds NaN or infinite values; write finite numbers"),
    "complex": ({"K": np.diag([K * (1 + 0.02j), 0])}, "K: is complex; write real matrices; structural damping"),
    "text": ({"M": "identity"}, "M: does not hold numbers; write real numbers"),
    "number for text": ({"interface_1_friction_law": 3}, "interface_1_friction_law: is not a text"),
    "area zero": ({"interface_1_area": 0}, "interface_1_area: area 0, counted from 0, is 0 m^2; give every point a"),
    "area negative": ({"interface_1_area": -1}, "interface_1_area: area 0, counted from 0, is -1 m^2"),
    "law unknown": ({"interface_1_friction_law": "dahl"}, "is 'dahl'; use one of: penalty_coulomb, rate_coulomb"),
    "mu negative": ({"interface_1_friction_mu": -0.1}, "interface_1_friction_law: coefficient of friction -0.1 is neg"),
    "kn zero": ({"interface_1_normal_stiffness": 0}, "interface_1_normal_stiffness: is 0 Pa/m; give a positive"),
    "no normal": ({"interface_1_operator": [[0, 0], [1, 0], [0, 1]]}, "the normal row of point 0, counted from 0, is"),
    "turned load": ({"load_preload": [0, FORCE]}, "load_preload: the preload opens every contact point; turn the sign"),
    "turned normal": ({"interface_1_operator": [[0, -1], [1, 0], [0, 0]]}, "load_preload: the preload opens every con"),
    "loose body": ({"interface_1_operator": [[1, 0], [1, 0], [0, 0]], "load_preload": [-1, 0]}, "K: is singular altho"),
    "pressure": (
        {"load_preload": None, "interface_1_preload_pressure": -1}, "interface_1_preload_pressure: is -1 Pa at one poi"
    ),
    "two states": (
        {"interface_1_preload_pressure": 1, "interface_1_preload_jump": [0, 0, 0]}, "stands beside other fields of a p"
    ),
    "turned traction": (
        {"interface_1_preload_jump": [-1e-7, 0, 0], "interface_1_preload_traction": [10, 0, 0],
         "interface_1_preload_elastic_slip": [0, 0]}, "does not follow from its laws: tractions differ by 20 Pa of"
    ),
    "unbalanced": (
        {"interface_1_preload_jump": [-2e-7, 0, 0], "interface_1_preload_traction": [-20, 0, 0],
         "interface_1_preload_elastic_slip": [0, 0], "preload_displacement": [0, -2e-7]},
        "the preload state does not balance load_preload (relative error"
    ),
    "half a state": ({"interface_1_preload_jump": [0, 0, 0]}, "interface_1_preload_traction: required field is miss"),
    "misspelt": ({"interface_1_frction_mu": 0.2}, "interface_1_frction_mu: unknown field; did you mean interface_1_fr"),
    "stiffness": ({"stiffness": 1.0}, "stiffness: unknown field; did you mean K? (fields of your own begin with user_"),
    "gap in numbers": ({"interface_3_area": 1.0}, "has the interfaces 1, 3; number them 1, 2, ... from the inside"),
    "newer": ({"wroll_format": 2}, "wroll_format: has format 2; read it with a newer wroll_fem"),
}  # fmt: skip


@pytest.mark.parametrize(("changes", "expected"), WRONG.values(), ids=WRONG)
def test_a_wrong_field_gets_one_line_with_file_field_and_remedy(tmp_path: Path, changes: Any, expected: str) -> None:
    path = write_case(tmp_path, oscillator(**changes))
    done = wroll("validate", path)
    assert done.exit_code == 2
    assert expected in done.output
    assert done.output.startswith(f"{tmp_path / 'structure.mat'}: ")
    assert done.output.count("\n") == 1


def test_a_massless_dof_needs_the_whole_structure(tmp_path: Path) -> None:
    path = write_case(tmp_path, oscillator(M=np.diag([MASS, 0.0])), solver={"method": "full"})
    expected = run_analysis(load_case(write_case(tmp_path, oscillator())), progress=SilentProgress())
    write_case(tmp_path, oscillator(M=np.diag([MASS, 0.0])), solver={"method": "full"})
    result = run_analysis(load_case(path), progress=SilentProgress())
    scale = float(np.abs(expected["tip_displacement"]).max())
    np.testing.assert_allclose(result["tip_displacement"], expected["tip_displacement"], atol=1e-6 * scale)


def files(folder: Path) -> dict[str, tuple[Path, str]]:
    """Files that are no structure, and what is said about each."""
    pickled, parts, damaged, text = (folder / name for name in ("pickled.npz", "parts.npz", "damaged.npz", "text.mat"))
    np.savez(pickled, **oscillator(K=np.array(sp.csr_matrix(np.eye(2)), dtype=object)))
    sparse = {"K_data": [1.0], "K_indptr": [0, 1, 1], "K_shape": [2, 2]}
    np.savez(parts, **oscillator(K=None), **sparse)
    np.savez(folder / "wild.npz", **oscillator(K=None), **sparse, K_indices=[7])
    damaged.write_bytes(b"PK\x03\x04 and then nothing")
    text.write_text("# Created by Octave 8\n# name: K\n")
    (folder / "hdf.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512) + b"\x89HDF\r\n")
    whole = folder / "whole.mat"
    scipy.io.savemat(whole, oscillator())
    (folder / "cut.mat").write_bytes(whole.read_bytes()[:300])
    return {
        "pickled": (
            pickled,
            "K: is a pickled Python object; save K_data, K_indices, K_indptr, K_shape, or K.toarra",
        ),
        "parts": (parts, "K: K_indices is missing; save all four parts of the sparse matrix"),
        "wild": (folder / "wild.npz", "K: its sparse parts do not fit together"),
        "damaged": (damaged, "is not a readable .npz file"),
        "text": (text, "is not a readable .mat file"),
        "hdf": (folder / "hdf.mat", "is a MATLAB v7.3 (HDF5) file, which is not read here; save it again with -v7"),
        "cut": (folder / "cut.mat", "is not a readable .mat file"),
    }


@pytest.mark.parametrize("kind", ["pickled", "parts", "wild", "damaged", "text", "hdf", "cut"])
def test_a_file_that_is_no_structure_is_refused_in_one_line(tmp_path: Path, kind: str) -> None:
    file, expected = files(tmp_path)[kind]
    path = write_case(tmp_path, {}, structure={"file": file.name})
    done = wroll("run", path, "--out", tmp_path / "run")
    assert done.exit_code == 2
    assert done.output.startswith(f"{file}: {expected}")
    assert done.output.count("\n") == 1


@pytest.mark.parametrize(
    ("sections", "expected"),
    [
        ({"geometry": {"length": 0.3, "mandrel_outer_diameter": 0.08, "mandrel_thickness": 1e-3}},
         "geometry: stands beside structure, whose file replaces it; leave geometry out, or leave structure out"),
        ({"coil": {"model": "none"}}, "coil: stands beside structure, whose file replaces it"),
        ({"mesh": {"axial": 12}}, "mesh: stands beside structure, whose file replaces it"),
        ({"preload": {"pressure": 1e5}}, "preload: stands beside structure, whose file replaces it"),
        ({"excitation": DWELL | {"direction": "x"}},
         "excitation.direction: the influence vector of structure.file sets the direction, got 'x'; leave it out"),
        ({"structure": {"file": "nothing.npz"}}, "structure.file: structure file not found, got '"),
        ({"structure": {"file": "case.yaml"}}, "structure.file: must be a .npz or .mat file, got '"),
        ({"structure": {"file": 3}}, "structure.file: must be the path of a .npz or .mat file, got 3"),
        ({"structure": {}}, "structure.file: required key is missing; add it (matrices and interfaces"),
        ({"structure": {"file": "structure.mat", "preload_steps": 0}}, "structure.preload_steps: must be 1 or more"),
        ({"structure": None}, "geometry: required section is missing; add it (the mandrel's tube)"),
    ],
)  # fmt: skip
def test_a_case_with_structure_says_what_does_not_belong(tmp_path: Path, sections: Any, expected: str) -> None:
    path = write_case(tmp_path, oscillator(), **sections)
    done = wroll("validate", path)
    assert done.exit_code == 2
    assert done.output.startswith(f"{path}: {expected}")
    assert done.output.count("\n") == 1


def test_doubtful_files_are_warned_about(tmp_path: Path) -> None:
    loose = wroll("validate", write_case(tmp_path, oscillator(load_preload=None)))
    assert "warning: nothing presses the interfaces together" in loose.output
    wrong_row = wroll("validate", write_case(tmp_path, oscillator(probe_tip=[0.5, 0])))
    assert "warning: probe_tip moves 0.5 m when the base moves 1 m" in wrong_row.output
    still = wroll("validate", write_case(tmp_path, oscillator(influence=[0, 0])))
    assert "warning: influence is zero" in still.output
    assert [r.exit_code for r in (loose, wrong_row, still)] == [0, 0, 0]


def test_matrices_cannot_be_meshed(tmp_path: Path) -> None:
    done = wroll("mesh", write_case(tmp_path, oscillator()), "--out", tmp_path / "mesh")
    assert done.exit_code == 2
    assert "structure: leaves nothing to mesh; its file holds matrices alone" in done.output


@pytest.mark.parametrize("name", ["roll.txt", "no/such/folder/roll.npz"])
def test_export_says_where_it_cannot_write(tmp_path: Path, name: str) -> None:
    path = write_case(tmp_path, oscillator())
    done = wroll("export", path, "--out", tmp_path / name)
    assert done.exit_code == 2
    assert re.search(r"is neither \.npz nor \.mat; give|cannot be written \(No such file", done.output)


def test_a_dry_run_knows_the_size_of_the_file(tmp_path: Path) -> None:
    done = wroll("run", write_case(tmp_path, oscillator()), "--dry-run")
    assert done.exit_code == 0
    assert re.search(r"dofs +2\ninterface points +1\nsteps +1200", done.output)


def test_analysis_preload_works_on_a_structure(tmp_path: Path) -> None:
    result = run_analysis(load_case(write_case(tmp_path, oscillator(), analysis="preload")), progress=SilentProgress())
    assert isinstance(result, xr.Dataset)
    assert float(result["pressure"][0, 0]) == pytest.approx(FORCE, rel=1e-9)
