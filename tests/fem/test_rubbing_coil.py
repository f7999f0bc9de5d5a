"""Solid coil that rubs on its mandrel: assembly, circumferential blocks, and limits in which the answer is known."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from support.rubbing_roll import SECTIONS, roll

from wroll_fem.analyses import history as history_module
from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.forecasts.closed_forms import buckling_pressure, interface_pressures
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.analyses.shared.preflight import contact_warnings
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.bodies.base_loads import base_rotation
from wroll_fem.case import build_case
from wroll_fem.case.case import Case
from wroll_fem.dynamics.reduction import stuck_modes
from wroll_fem.dynamics.reduction.cyclic_blocks import Blocks, spread
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.statics.pressure_matching import mean_pressures
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.simulate import simulate
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.errors import InputError
from wroll_fem.fem.coil import coil_heights, mesh_coil
from wroll_fem.fem.rubbing_coil import clamped_nodes
from wroll_fem.fem.solid import SolidModel
from wroll_fem.mesh.generate import build_mesh, roll_stations
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.base_motion import Dwell

COARSE = {"circumferential": 8, "axial": 4, "radial": 1}


@cache
def system(symmetric: bool = True) -> System:
    case = roll(mesh={"circumferential": 8, "axial": 2, "radial": 1})
    return build_system(case, build_bodies(case, symmetric=symmetric))


def springs_of(system: System) -> np.ndarray:
    return np.concatenate([np.full(2 * system.n_points, 3e9), system.laws.kn])


def first_bending(interface: str, mu: float = 0.25, pressure: float = 1e5, **changed: dict[str, object]) -> float:
    """First bending frequency, Hz, of a coil that presses uniformly on its mandrel."""
    few = {"circumferential": 8, "axial": 3, "radial": 1} if mu == 0.0 or interface == "frictionless" else {}
    friction = {"law": "penalty_coulomb", "mu": mu, "elastic_slip": 1e-6}
    case = roll("modal", modal={"interface": interface, "count": 2 if mu > 1.0 else 6},
                preload={"kind": "winding_stress", "pressure": pressure},
                contact={"friction": friction, **changed.pop("contact", {})}, **{"mesh": few, **changed})  # fmt: skip
    return bending_of(case)


def tied(**changed: dict[str, object]) -> Case:
    """Modes of the bonded solid: the inner face of the coil has no unknowns of its own."""
    coil = {**changed.pop("coil", {}), "interface": "bonded"}
    sections = roll("modal", modal={"count": 2}, coil=coil, **changed).resolved()
    return build_case({name: section for name, section in sections.items() if name not in ("contact", "preload")})


def bending_of(case: Case) -> float:
    modes = run_analysis(case, progress=SilentProgress())
    kinds = modes["mode_kind"].values.tolist()
    return float(modes["mode_frequency"].values[kinds.index("bending")])


def test_both_sides_of_the_interface_move_alike_in_rigid_motions() -> None:
    """The clamped base is left out of the mandrel, so only points above its first row are compared."""
    case = roll()
    bodies = build_bodies(case, symmetric=False)
    whole = build_system(case, bodies)
    above = np.flatnonzero(whole.interfaces[0].points[:, 1] > 0.1 * case.geometry.length)
    for direction in (0, 1):
        turns = [base_rotation(body, direction, case.geometry.length) for body in bodies]
        for motion in (np.concatenate([b.influence[:, direction] for b in bodies]), np.concatenate(turns)):
            jump = whole.jump @ motion
            normal, tangential = jump[2 * whole.n_points :], jump[: 2 * whole.n_points].reshape(-1, 2)
            assert np.abs(normal[above]).max() < 1e-3
            assert np.abs(tangential[above]).max() < 1e-3
    coil = bodies[1]
    rigid = np.column_stack([coil.influence, base_rotation(coil, 0, 0.3), base_rotation(coil, 1, 0.3)])
    strained = np.abs(coil.stiffness @ rigid).max() / np.abs(coil.stiffness).max()
    assert strained < 1e-9
    mass = rigid[:, 0] @ (coil.mass @ rigid[:, 0])
    assert mass == pytest.approx(coil.mass_total, rel=1e-9)
    outer = 0.05
    assert coil.mass_total == pytest.approx(500.0 * np.pi * (outer**2 - 0.04**2) * 0.3, rel=1e-3)


def test_a_model_of_half_the_roll_gives_the_same_matrices_of_motion() -> None:
    half, whole = system(), system(symmetric=False)
    assert half.weights.sum() == pytest.approx(whole.weights.sum(), rel=1e-12)
    found = []
    for one in (half, whole):
        matrix = one.with_interface_springs(springs_of(one))
        u = spla.spsolve(matrix.tocsc(), one.mass @ one.influence)
        found.append((float(one.probes["tip"] @ u), float(u @ (one.mass @ one.influence))))
    assert found[0] == pytest.approx(found[1], rel=1e-9)


@pytest.mark.parametrize("base", ["free", "inner_edge", "clamped"])
def test_half_of_a_coil_counted_twice_has_the_matrices_of_the_whole(base: str) -> None:
    case = roll(mesh=COARSE, coil={"base": base})
    model = SolidModel(*mesh_coil(case, build_mesh(case).part("mandrel")))
    whole, mass = model.orthotropic_stiffness(case.coil.solid()), model.mass(case.coil.solid().rho)
    for symmetric in (True, False):
        coil = build_bodies(case, symmetric=symmetric)[1]
        for ours, nodal in ((coil.stiffness, whole), (coil.mass, mass)):
            exact = coil.solid.expand.T @ nodal @ coil.solid.expand
            assert abs(ours - exact).max() < 1e-14 * abs(exact).max()
        assert coil.mass_total == pytest.approx(500.0 * model.volume, rel=1e-14)


@pytest.mark.parametrize("symmetric", [True, False])
def test_blocks_of_a_solid_carry_the_compliance_of_the_interface(symmetric: bool) -> None:
    one = system(symmetric)
    blocks = Blocks.of(one, springs_of(one))
    assert blocks is not None
    per_block = [
        blocks.jump(b) @ spla.spsolve(blocks.stiffness(b).tocsc(), blocks.jump(b).T.tocsc()) for b in range(len(blocks))
    ]
    compliance = spread(np.array([c.toarray() for c in per_block]), blocks.profiles, one.laws.area)
    whole = spla.splu(one.with_interface_springs(springs_of(one)))
    expected = one.jump @ whole.solve(one.jump.T.toarray() * one.weights)
    np.testing.assert_allclose(compliance, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("cycles", [2, pytest.param(40, marks=pytest.mark.slow)])
def test_full_and_condensed_agree_with_slip(cycles: int) -> None:
    one, motion = system(symmetric=False), Dwell(150.0, 150.0, cycles, 1)
    preload = solve_preload(one)
    runs = [
        simulate(one, preload, motion, dt=1 / 2400, scheme=Scheme.hht(-0.05), method=method)
        for method in ("full", "condensed")
    ]
    assert float(runs[1]["slipping_fraction"].max()) > 0.1
    tip = [run["tip_displacement"].values for run in runs]
    np.testing.assert_allclose(tip[1], tip[0], atol=1e-6 * np.abs(tip[0]).max(), rtol=0)
    least = [run["least_pressure"].values for run in runs]
    np.testing.assert_allclose(least[1], least[0], atol=1e-6 * preload.pressure.max())
    assert np.all(least[0] <= runs[0]["pressure"].values)


@pytest.mark.slow
def test_strong_friction_is_the_bonded_coil() -> None:
    """At 10 MPa and mu = 5 the interface is far stiffer than the coil."""
    assert first_bending("stuck", mu=5.0, pressure=1e7) == pytest.approx(first_bending("bonded"), rel=3e-4)


def drawn(seed: int) -> tuple[dict[str, object], float, float]:
    """Coil no stiffer than the mandrel's material, coefficient of friction, and pressure on the mandrel, Pa."""
    random = np.random.default_rng(seed)
    modulus, thickness = 1e8 * 20.0 ** random.uniform(), random.uniform(2e-3, 30e-3)
    coil: dict[str, object] = {
        "total_thickness": thickness, "material": {"E": modulus, "nu": 0.3, "rho": 500.0},
    }  # fmt: skip
    return coil, random.uniform(2.0, 10.0), random.uniform(5e6, 2e7)


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 2, 3))])
def test_strong_friction_is_the_bonded_coil_with_the_automatic_penalty(seed: int) -> None:
    """On a coarse mesh, against ties at the same contact points."""
    coil, mu, pressure = drawn(seed)
    stuck = first_bending("stuck", mu, pressure, coil=coil, contact={"normal": {"penalty": "auto"}})
    assert stuck == pytest.approx(first_bending("bonded", coil=coil), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_strong_friction_on_a_fine_mesh_is_the_bonded_solid(seed: int) -> None:
    """With the automatic penalty, against the solid whose inner face has no unknowns of its own.

    A penalty that gives way like half of the first element is 0.6 % low with draw 1: the element gives way itself.
    """
    coil, mu, pressure = drawn(seed)
    mesh = {"circumferential": 8, "axial": 20, "radial": 4, "grading": 40}
    stuck = first_bending("stuck", mu, pressure, coil=coil, mesh=mesh, contact={"normal": {"penalty": "auto"}})
    assert stuck == pytest.approx(bending_of(tied(coil=coil, mesh=mesh)), rel=3e-3)


@pytest.mark.slow
def test_the_bonded_interface_is_the_coil_without_unknowns_of_its_inner_face() -> None:
    """The averaged tie approaches the tie of all nodes: 1 % below it on 12 x 6 x 2 cells, 0.08 % on 12 x 20 x 4."""
    mesh = {"axial": 12, "radial": 3, "grading": 16}
    springs = roll("modal", modal={"interface": "bonded", "count": 2}, mesh=mesh)
    assert bending_of(springs) == pytest.approx(bending_of(tied(mesh=mesh)), rel=3e-3)


def test_no_friction_is_the_frictionless_eigenproblem() -> None:
    assert first_bending("stuck", mu=0.0) == pytest.approx(first_bending("frictionless"), rel=1e-6)


def test_a_thin_solid_is_the_layer_of_the_lab_roll() -> None:
    mesh = {"circumferential": 8, "axial": 5, "radial": 1, "grading": 8}
    thin = {"total_thickness": 1.25e-3, "material": {"E": 2.8e9, "nu": 0.35, "rho": 2000.0}}
    band = {"f_start": 143, "f_end": 162}
    solid = roll(coil=thin, mesh=mesh, excitation=band)
    data = solid.resolved()
    data["coil"] = {"model": "layers", "layers": 1, **thin}
    found = []
    for case in (solid, build_case(data)):
        summary = summarise(run_analysis(case, progress=SilentProgress()), case)
        found.append([summary[key] for key in ("f_n_hz", "peak_transmissibility", "zeta")])
        assert summary["energy_balance_error"] < 1e-6
    f_n, peak, zeta = np.array(found[0]) / np.array(found[1]) - 1.0
    assert abs(f_n) < 5e-3
    assert abs(peak) < 0.03
    assert abs(zeta) < 0.03


def preloaded(**changed: dict[str, object]) -> tuple[Case, System, np.ndarray]:
    case = roll("preload", **changed)
    one = build_system(case, build_bodies(case, symmetric=True))
    return case, one, solve_preload(one).pressure


def test_the_pressure_at_the_interface_is_that_of_a_thick_ring() -> None:
    """Mean over half of the height: the ends, which are kept round, carry more, and next to them less arrives."""
    case, one, pressure = preloaded(mesh={"circumferential": 8, "axial": 16, "radial": 1, "grading": 1})
    middle = np.abs(one.interfaces[0].points[:, 1] - 0.15) < 0.075
    mean = np.average(pressure[middle], weights=one.laws.area[middle])
    assert mean == pytest.approx(interface_pressures(case)[0], rel=0.01)


def test_a_prescribed_pressure_reaches_the_interface() -> None:
    case, one, pressure = preloaded(preload={"kind": "interface_pressure", "pressure": 3e4}, mesh=COARSE)
    assert np.average(pressure, weights=one.laws.area) == pytest.approx(3e4, rel=1e-4)
    assert one.pressures[0] == pytest.approx(3e4 * 1e5 / interface_pressures(roll("preload"))[0], rel=0.2)
    assert interface_pressures(case) == [3e4]


def layered(**preload: object) -> dict[str, dict[str, object]]:
    sections = roll(mesh=COARSE).resolved()
    web = {"E": 2.8e9, "nu": 0.35, "rho": 2000.0}
    sections["coil"] = {"model": "layers", "layers": 3, "total_thickness": 3e-3, "material": web}
    return sections | {"preload": preload}


@pytest.mark.parametrize("kind", ["interface_pressure", "winding_stress"])
def test_layers_have_the_prescribed_pressures(kind: str) -> None:
    case = build_case(layered(kind=kind, pressure=[5e4, 4e4, 2e4]))
    one = build_system(case, build_bodies(case, symmetric=True))
    found = mean_pressures(one, solve_preload(one))
    np.testing.assert_allclose(found, [5e4, 4e4, 2e4], rtol=1e-4)


def test_pressures_that_would_pull_and_a_missing_stress_are_refused() -> None:
    steep = build_case(layered(kind="interface_pressure", pressure=[1e4, 2e4, 5e4]))
    with pytest.raises(InputError, match=r"preload.pressure: the interface pressures increase outwards"):
        build_system(steep, build_bodies(steep, symmetric=True))
    with pytest.raises(InputError, match=r"preload.kind: does not compute the stress of the shells"):
        build_case(layered(kind="winding_stress", pressure=1e4, geometric_stiffness=True))


def test_winding_stress_is_uniform_and_has_no_resultant() -> None:
    """The bodies do not deform, also where the coil is as soft as the penalty: once it took a third of the pressure."""
    soft = {"material": {"E": 1e7, "nu": 0.3, "rho": 1000.0}}
    for coil in ({}, soft):
        _, one, pressure = preloaded(preload={"kind": "winding_stress", "pressure": 3e4}, coil=coil, mesh=COARSE)
        np.testing.assert_allclose(pressure, 3e4, rtol=1e-12)
    assert one.pressures == (0.0,)
    assert abs(one.influence @ one.loads["preload"]) < 1e-9 * np.abs(one.loads["preload"]).sum()


@pytest.mark.slow
def test_a_clamped_annulus_converges_and_holds_more_the_wider_it_is() -> None:
    def compliance(width: float, radial: int) -> float:
        case = roll(coil={"base": "inner_edge", "base_width": width}, mesh={"radial": radial, "axial": 4 * radial})
        one = build_system(case, build_bodies(case, symmetric=True))
        shear = spla.spsolve(one.with_interface_springs(springs_of(one)).tocsc(), one.mass @ one.influence)
        return float(one.probes["tip"] @ shear)

    narrow, wide = compliance(1.5e-3, 2), compliance(5e-3, 2)
    assert wide < narrow < compliance(0.0, 2)
    assert compliance(5e-3, 3) == pytest.approx(wide, rel=0.02)


@pytest.mark.parametrize("width", [3e-4, 1e-3, 2e-3])
def test_elements_near_a_clamped_annulus_grow_from_half_its_width(width: float) -> None:
    """Along the axis and across the coil, whose extent stays; a width far below the elements was a bare line once."""
    mesh = {"circumferential": 8, "radial": 3, "axial": 6, "grading": 20}
    case = roll(coil={"base": "inner_edge", "base_width": width}, mesh=mesh)
    wall, coil = 0.5 * case.geometry.mandrel_thickness, case.coil.total_thickness
    across, along = coil_heights(case)[::2] - wall, roll_stations(case)
    assert across[[0, -1]] == pytest.approx([0.0, coil], abs=1e-15)
    assert along[[0, -1]] == pytest.approx([0.0, case.geometry.length], abs=1e-15)
    for borders in (across, along):
        sizes = np.diff(borders[borders < 4.0 * width])
        assert borders[1] == pytest.approx(0.5 * width, rel=0.5)
        assert np.all(sizes[1:] < 4.0 * sizes[:-1])
    assert np.abs(across - width).min() < 1e-12
    held = across[across <= 1.000001 * width]
    part = build_mesh(case).part("mandrel")
    assert len(clamped_nodes(case, part, mesh_coil(case, part)[0])) == 16 * (2 * len(held) - 1)


@pytest.mark.parametrize(
    ("changed", "key"),
    [
        ({"coil": {"base_width": 1e-3}}, "base_width"),
        ({"coil": {"base_width": 1.0, "base": "inner_edge"}}, "base_width"),
        ({"coil": {"model": "layers"}}, "interface"),
        ({"mesh": {"discretisation": "fourier"}}, "mesh.discretisation"),
        ({"preload": {"kind": "interface_pressure", "pressure": 0.0}}, "preload.pressure"),
    ],
)
def test_keys_that_do_not_fit_are_refused(changed: dict[str, dict[str, object]], key: str) -> None:
    with pytest.raises(InputError, match=key):
        roll(**changed)


def test_a_bare_edge_and_a_coarse_root_are_warned_about() -> None:
    """A case without a warning, and what each of the others changes in it."""
    pressed = {"preload": {"kind": "interface_pressure", "pressure": 5e3}}
    fine = {"mesh": {"axial": 12, "grading": 20}}
    assert contact_warnings(roll(**pressed, **fine)) == []
    bare = contact_warnings(roll(**pressed, **fine, coil={"base": "inner_edge", "base_width": 0.0}))
    assert [warning.split(":")[0] for warning in bare] == [
        "coil.base_width 0 clamps a line, whose stiffness falls with the size of the elements"
    ]
    coarse = contact_warnings(roll(**pressed, mesh={"axial": 6, "grading": 1}))
    assert any("50.0 mm high, but the wall bends within sqrt(R t) = 7.7 mm" in warning for warning in coarse)
    case = roll(**fine, preload={"kind": "winding_stress", "pressure": 1e6})
    [buckled] = (text for text in contact_warnings(case) if "hoop-buckling pressure of the tube alone" in text)
    assert f"with about 1e+03 kPa, {1e6 / buckling_pressure(case):.3g} times the linear" in buckled


def test_a_chirp_balances_its_energy_while_the_coil_slides() -> None:
    """Input work against stored energy, friction and the rest, through the resonance: 0.1 %."""
    excitation = {"amplitude": 20.0, "f_start": 110, "f_end": 200, "rate_oct_per_min": 120, "ramp_cycles": 2}
    case = roll("sweep", excitation=excitation, preload={"pressure": 3e4}, solver={"method": "condensed"})
    found = summarise(run_analysis(case, progress=SilentProgress()))
    assert found["energy_balance_error"] < 1e-3
    assert found["friction_energy_j"] > 0.3 * found["input_work_j"]


@pytest.mark.parametrize("missing", ["contact", "preload"])
def test_friction_needs_contact_and_preload(missing: str) -> None:
    sections = {name: section for name, section in SECTIONS.items() if name != missing}
    with pytest.raises(InputError, match=f"{missing}.*required section is missing.*coil.interface: friction"):
        build_case({"analysis": "harmonic", **sections})


def test_all_points_slip_alike_whatever_the_numbering() -> None:
    """A system without subspaces is condensed as one block."""
    one = system()
    preload, motion = solve_preload(one), Dwell(150.0, 150.0, 3, 1)
    run = [
        simulate(each, preload, motion, dt=1 / 4000, scheme=Scheme.hht(-0.05), method="condensed")
        for each in (one, dataclasses.replace(one, subspaces=()))
    ]
    tip = [r["tip_displacement"].values for r in run]
    np.testing.assert_allclose(tip[1], tip[0], atol=1e-8 * np.abs(tip[0]).max(), rtol=0)


def test_modes_that_the_loads_excite_are_enough_for_a_history(monkeypatch: pytest.MonkeyPatch) -> None:
    """The coil slides and opens; far fewer modes than all of them give the same motion."""
    case = roll(preload={"pressure": 5e3}, mesh={"circumferential": 8, "axial": 4, "radial": 2})
    each, preload = prepare(case, SilentProgress())
    scheme, motion, dt = Scheme.hht(-0.05), Dwell(20.0, 130.0, 8, 2), 1 / 5200
    tips, counts = [], []
    for many in (each.n_dofs, each.n_dofs - 1):
        monkeypatch.setattr(stuck_modes, "MANY_DOFS", many)
        modes = stuck_modes.modes_to_reduce(each, preload, scheme, dt)
        run = CondensedStepper(each, preload, scheme, NewtonOptions(), dt=dt, condensation=modes)
        history = simulate(each, preload, motion, dt=dt, scheme=scheme, stepper=run)
        tips.append(history["tip_displacement"].values)
        counts.append(len(modes.eigenvalues))
    assert counts[1] < 0.6 * counts[0]
    assert float(history["open_fraction"].max()) > 0.1
    np.testing.assert_allclose(tips[1], tips[0], atol=1e-5 * np.abs(tips[0]).max(), rtol=0)


def test_a_reduced_run_and_the_one_that_replaces_it_have_the_same_modes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also if the run is resumed: the checkpoint holds as many modal coordinates as there are modes."""
    monkeypatch.setattr(stuck_modes, "MANY_DOFS", 0)
    monkeypatch.setattr(history_module, "LARGE_REDUCTION_ERROR", 0.0)
    case = roll("sweep", excitation={"amplitude": 20.0, "rate_oct_per_min": 600}, preload={"pressure": 1e4},
                mesh={"circumferential": 8, "axial": 3, "radial": 1})  # fmt: skip
    progress = SilentProgress()
    found = run_analysis(case, progress=progress)
    assert found.attrs["method"] == "condensed"
    assert any("falls back" in text for text in progress.warnings)
    monkeypatch.setattr(history_module, "saved_method", lambda saving: "condensed")
    again = run_analysis(case, progress=SilentProgress())
    np.testing.assert_array_equal(again["tip_displacement"].values, found["tip_displacement"].values)
