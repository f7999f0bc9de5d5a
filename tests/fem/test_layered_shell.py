"""Shells with plies and with a variable wall: tubes against beams and closed forms, reference surfaces, stresses."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import scipy.sparse.linalg as sla
from support.paths import CONFIGS
from support.stepped_beam import stepped_beam

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.shared.assembly import uses_symmetry
from wroll_fem.bodies.beam_modes import SprungBeam
from wroll_fem.bodies.body import Body
from wroll_fem.bodies.laminate import Lamina, Ply
from wroll_fem.bodies.stress import PlyStress
from wroll_fem.bodies.wall import LayeredSection
from wroll_fem.case.loader import build_case, load_case
from wroll_fem.case.roll import RollSections
from wroll_fem.fem.body import assemble_bodies
from wroll_fem.fem.layered_shell import shell_model
from wroll_fem.fem.prestress.shell import PrestressedShell
from wroll_fem.fem.shell import ShellModel, ShellSection
from wroll_fem.fem.shell_stress import shell_stresses
from wroll_fem.mesh.generate import make_cylinders
from wroll_fem.progress import SilentProgress

CARBON = {"E_1": 142e9, "E_2": 10.3e9, "nu_12": 0.27, "G_12": 7.2e9, "G_23": 3.7e9, "rho": 1580.0}
ALUMINIUM = {"E": 70e9, "nu": 0.33, "rho": 2700.0}
LENGTH, DIAMETER, WALL = 1.2, 0.06, 1e-3
QUASI_ISOTROPIC = [0.0, 45.0, -45.0, 90.0]
COARSE = {"circumferential": 12, "axial": 8, "grading": 4}
"""Mesh for beam-like motions of a long tube."""


def roll(
    material: Any, *, length: float = LENGTH, diameter: float = DIAMETER, thickness: float = WALL,
    mesh: dict[str, int] | None = None, **mandrel: Any,
):  # fmt: skip
    return RollSections.model_validate({
        "geometry": {"length": length, "mandrel_outer_diameter": diameter, "mandrel_thickness": thickness},
        "mandrel": {"material": material} | mandrel,
        "coil": {"model": "none"},
        "mesh": mesh or {"circumferential": 16, "axial": 14, "grading": 4},
    })  # fmt: skip


def plies(angles: list[float], thickness: float, *, symmetric: bool = False) -> dict[str, Any]:
    count = len(angles) * (2 if symmetric else 1)
    stack = [{"material": CARBON, "thickness": thickness / count, "angle": angle} for angle in angles]
    return {"plies": stack, "symmetric": symmetric}


def modes(body: Body, count: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, Hz, and shares of the mass that turn about the axis."""
    values, vectors = sla.eigsh(body.stiffness, count, body.mass, sigma=0.0, v0=np.ones(body.stiffness.shape[0]))
    order = np.argsort(values)
    node, component = body.unknown_node, body.unknown_component
    assert node is not None
    assert component is not None
    x, y = np.where(node >= 0, body.nodes[node].T[:2], 0.0)
    turn = np.where(component == 0, -y, 0.0) + np.where(component == 1, x, 0.0)
    turn[(node == -1) & (component == 5)] = 1.0
    share = (vectors.T @ (body.mass @ turn)) ** 2 / (turn @ (body.mass @ turn))
    return np.sqrt(values[order]) / (2 * np.pi), share[order]


@pytest.mark.parametrize(
    ("angles", "symmetric"), [([0.0], False), ([0.0, 90.0], True), ([45.0, -45.0], True), (QUASI_ISOTROPIC, True)]
)
def test_tubes_of_laminates_vibrate_as_beams_and_shafts(angles: list[float], symmetric: bool) -> None:
    """First bending frequency of a beam with E_z and G_ztheta of the wall, first torsional one of a shaft: 0.5 %."""
    material = CARBON if angles == [0.0] else plies(angles, WALL, symmetric=symmetric)
    case = roll(material, mesh=COARSE)
    found, turns = modes(assemble_bodies(case, symmetric=False)[0], 30)
    E, _, _, G = case.mandrel.material.in_plane
    radius, rho = 0.5 * (DIAMETER - WALL), CARBON["rho"]
    area, second = 2 * np.pi * radius * WALL, np.pi * radius**3 * WALL
    beam = SprungBeam(LENGTH, E * second, G * area / 2, rho * area, rho * second, base=(None, None))
    assert found[:2] == pytest.approx([beam.frequencies(1)[0]] * 2, rel=0.005)
    assert found[turns.argmax()] == pytest.approx(np.sqrt(G / rho) / (4 * LENGTH), rel=0.005)


def test_an_unsymmetric_wall_twists_when_it_is_stretched() -> None:
    """A tube of plies at 30 degrees under axial force: strain a11 N and twist a16 N / R of the laminate."""
    case = roll({"plies": [{"material": CARBON, "thickness": WALL, "angle": 30}]}, mesh=COARSE)
    body = assemble_bodies(case, symmetric=False)[0]
    load = np.zeros(body.n_dofs)
    load[(body.unknown_node == -1) & (body.unknown_component == 2)] = 1.0
    moved = sla.spsolve(body.stiffness.tocsc(), load)
    stretch, twist = (
        float(moved[(body.unknown_node == -1) & (body.unknown_component == axis)][0]) / LENGTH for axis in (2, 5)
    )
    section = LayeredSection(case.mandrel.material.as_plies(WALL), 0.5 * (DIAMETER - WALL))
    a = np.linalg.inv(section.laminate(WALL).abd)
    force = 1 / (2 * np.pi * section.radius)
    assert stretch == pytest.approx(a[0, 0] * force, rel=0.005)
    assert twist * section.radius == pytest.approx(a[0, 2] * force, rel=0.005)


def test_isotropic_plies_are_the_homogeneous_shell() -> None:
    mesh = make_cylinders([("mandrel", 0.04)], 0.3, 8, 4, 2.0).part("mandrel")
    plain = ShellSection(70e9, 0.33, 2700.0, 1.5e-3, extra_mass=2.0)
    ply = Ply(Lamina.isotropic(70e9, 0.33, 2700.0), 0.5e-3)
    layered = LayeredSection((ply, ply, ply), 0.04, extra_mass=2.0)
    models = [shell_model(mesh.nodes, mesh.cells, section) for section in (plain, layered)]
    for name in ("stiffness", "mass"):
        one, two = (getattr(m, name)(s) for m, s in zip(models, (plain, layered), strict=True))
        assert abs(one - two).max() < 1e-12 * abs(one).max()
    assert models[1].mass_total(layered) == pytest.approx(models[0].mass_total(plain), rel=1e-12)
    state = np.random.default_rng(1).normal(size=6 * len(mesh.nodes))
    first, second = (
        PrestressedShell(m, s).geometric_stiffness(state, 100.0) for m, s in zip(models, (plain, layered), strict=True)
    )
    assert abs(first - second).max() < 1e-11 * abs(first).max()


def test_plies_need_their_own_model() -> None:
    mesh = make_cylinders([("mandrel", 0.04)], 0.3, 8, 4).part("mandrel")
    with pytest.raises(TypeError, match="LayeredShellModel"):
        ShellModel(mesh.nodes, mesh.cells).stiffness(LayeredSection((Ply(Lamina.isotropic(1, 0, 1), 1e-3),), 0.04))


@cache
def short_tube(nominal: float) -> tuple[float, np.ndarray]:
    """Mass and frequencies of a wall of 2 mm: uniform, or as a table about the surface of another nominal wall."""
    table = [{"z": 0.0, "thickness": 2e-3}, {"z": 0.3, "thickness": 2e-3}]
    wall = {} if nominal == 2e-3 else {"wall": table}
    case = roll(ALUMINIUM, thickness=nominal, length=0.3, diameter=0.08, tip="free", **wall)
    body = assemble_bodies(case, symmetric=False)[0]
    return body.mass_total, modes(body)[0]


@pytest.mark.parametrize("nominal", [1e-3, 3e-3])
def test_a_wall_does_not_depend_on_its_reference_surface(nominal: float) -> None:
    """A wall of 2 mm as a table about a surface of 1 or 3 mm: the same modes, ovalling and torsion included.

    They differ by the mesh: 2e-4 on this one, 5e-5 on 24 x 12 elements.
    """
    (mass, found), (expected_mass, expected) = short_tube(nominal), short_tube(2e-3)
    assert mass == pytest.approx(expected_mass, rel=1e-12)
    np.testing.assert_allclose(found, expected, rtol=3e-4)


def test_a_tapered_tube_vibrates_as_a_tapered_beam() -> None:
    """Wall from 2 mm at the base to 0.5 mm at the tip, a step in the middle: against a beam, 0.5 %."""
    length, outer = 1.5, 0.03
    rows = [(0.0, 2e-3), (0.75, 1.25e-3), (0.75, 0.8e-3), (1.5, 0.5e-3)]
    wall = [{"z": z, "thickness": t} for z, t in rows]
    case = roll(ALUMINIUM, length=length, diameter=2 * outer, thickness=1.2e-3, wall=wall, mesh=COARSE)
    found = modes(assemble_bodies(case, symmetric=False)[0], 4)[0][[0, 2]]
    expected = stepped_beam(
        length, lambda z: (outer - np.interp(z, *np.transpose(rows)), outer + 0.0 * z), 70e9, 0.33, 2700.0, count=120
    )
    np.testing.assert_allclose(found, expected, rtol=0.005)


def test_stresses_of_plies_of_a_bent_tube() -> None:
    """Force at the tip of [0/90]s: the plies along the axis carry E_1 times the strain of the beam; 1 %."""
    case = roll(plies([0.0, 90.0], WALL, symmetric=True))
    bodies = assemble_bodies(case, symmetric=False)
    (shell,) = shell_stresses(case, bodies)
    assert isinstance(shell, PlyStress)
    moved = sla.spsolve(bodies[0].stiffness.tocsc(), bodies[0].probes["tip"].toarray()[0])
    stress = shell.plies(shell.resultants(moved))
    assert stress is not None
    assert np.isnan(shell.von_mises(shell.resultants(moved))).all()
    radius = 0.5 * (DIAMETER - WALL)
    E = case.mandrel.material.in_plane.E_z
    middle = np.abs(shell.points[:, 2] - 0.5 * LENGTH) < 0.1 * LENGTH
    strain = (LENGTH - shell.points[middle, 2]) * shell.points[middle, 0] / (E * np.pi * radius**3 * WALL)
    along = stress[middle][:, [0, 3]][..., 0].mean(axis=(1, 2))
    across = stress[middle][:, [1, 2]][..., 1].mean(axis=(1, 2))
    top = np.abs(strain).max()
    np.testing.assert_allclose(-along / 142e9, strain, atol=0.01 * top)
    assert np.abs(across).max() < 0.1 * np.abs(along).max()


def test_a_roll_of_laminates_runs_as_others_do(tmp_path) -> None:
    """Harmonic balance of the lab roll with a mandrel of [45/-45]s: the whole circumference, ply stresses, energy."""
    material = plies([45.0, -45.0], 1.5e-3, symmetric=True)
    changes = [
        "mesh={circumferential: 8, axial: 4, grading: 1}", "output.figures=false", "excitation.amplitude=0.5",
        "mandrel={material: " + str(material).replace("True", "true") + ", tip_mass: 0.05}",
    ]  # fmt: skip
    case = load_case(CONFIGS / "lab_harmonic.yaml", changes)
    assert not uses_symmetry(case)
    data = run_analysis(case, progress=SilentProgress())
    entries = summarise(data, case)
    assert entries["von_mises_max_pa"][0] is None
    assert entries["ply_stress_1_max_pa"][1] is None
    largest = data["ply_stress_max"].sel(shell="mandrel", ply_component="1").values
    assert np.abs(entries["ply_stress_1_max_pa"][0]) == pytest.approx(np.nanmax(np.abs(largest)))
    assert data["ply_stress_max"].shape == (2, 4, 3)


@pytest.mark.parametrize(
    ("mandrel", "words"),
    [
        ({"material": plies([0.0, 90.0], 2e-3)}, "the plies are 0.002 m thick, but geometry.mandrel_thickness is"),
        ({"material": CARBON | {"nu_12": 4.0}}, r"violates |nu_12| < sqrt(E_1 / E_2) = 3.713"),
        (
            {"material": ALUMINIUM, "wall": [{"z": 0.3, "thickness": 1e-3}, {"z": 0.1, "thickness": 1e-3}]},
            "must ascend",
        ),
        ({"material": ALUMINIUM, "wall": [{"z": 0, "thickness": 1e-3}, {"z": 3, "thickness": 1e-3}]}, "above the tip"),
        ({"material": CARBON, "yield_stress": 1e9}, "does not apply to plies"),
        (
            {"material": plies([0.0], WALL), "wall": [{"z": 0, "thickness": 1e-3}, {"z": 1, "thickness": 1e-3}]},
            "does not work with a laminate",
        ),
    ],
)
def test_walls_that_contradict_themselves_are_refused(mandrel: dict[str, Any], words: str) -> None:
    data = {
        "analysis": "modal",
        "geometry": {"length": LENGTH, "mandrel_outer_diameter": DIAMETER, "mandrel_thickness": WALL},
        "mandrel": mandrel,
        "coil": {"model": "none"},
    }
    with pytest.raises(Exception) as caught:  # noqa: PT011
        build_case(data)
    assert words in str(caught.value)


BONDED: dict[str, Any] = {"model": "bonded", "total_thickness": 1e-3}


@pytest.mark.parametrize(
    ("mandrel", "coil"),
    [
        ({"material": plies([0.0, 90.0], WALL)}, {"model": "none"}),
        ({"material": ALUMINIUM}, BONDED | {"material": CARBON}),
        ({"material": plies([0.0, 90.0], WALL)}, BONDED | {"material": ALUMINIUM, "margins": {"base": 0.1}}),
    ],
)
def test_modal_analysis_takes_walls_that_fourier_elements_do_not(mandrel: Any, coil: Any) -> None:
    """The check of the mesh against Fourier elements is left out; asked for by name they are refused."""
    data = {
        "analysis": "modal",
        "geometry": {"length": LENGTH, "mandrel_outer_diameter": DIAMETER, "mandrel_thickness": WALL},
        "mandrel": mandrel, "coil": coil, "modal": {"count": 4}, "output": {"figures": False},
        "mesh": {"circumferential": 8, "axial": 3, "grading": 1},
    }  # fmt: skip
    assert run_analysis(build_case(data), progress=SilentProgress())["mode_frequency"].values[0] > 0.0
    with pytest.raises(Exception, match=r"does not work with (Fourier elements|coil\.margins)"):
        build_case(data | {"mesh": {"discretisation": "fourier"}})


def test_a_yield_stress_of_plies_in_a_coil_is_refused() -> None:
    with pytest.raises(Exception, match="does not apply to plies"):
        load_case(CONFIGS / "lab_sweep.yaml", [f"coil.material={CARBON}".replace("'", ""), "coil.yield_stress=1e8"])
