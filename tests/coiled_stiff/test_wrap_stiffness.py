"""Shear and radial modulus of a coil from its web, its interfaces and the pressure between its wraps."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.integrate import trapezoid
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.followed_mode import main_mode
from wroll_fem.analyses.shared.assembly import build_bodies
from wroll_fem.analyses.slip_structure import WoundCoil, slipping_structure
from wroll_fem.bodies.body import Body
from wroll_fem.case import SlipDampingCase, load_case
from wroll_fem.coiled_stiff.shear_points import ShearPoints
from wroll_fem.coiled_stiff.slipping_coil import slipping_system
from wroll_fem.coiled_stiff.wrap_stiffness import radial_change, shear_modulus, with_radial_modulus
from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.statics.contact_state import TrialContact
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import ModalPath, modal_path
from wroll_fem.errors import InputError
from wroll_fem.fem.coil import coil_heights
from wroll_fem.fem.eigen import DEFAULT_SHIFT, solve_pairs
from wroll_fem.fem.solid import SolidModel, thicken
from wroll_fem.mesh.generate import build_mesh

CASE = CONFIGS / "slipping_coil.yaml"
SMALL = "mesh={circumferential: 8, axial: 4, grading: 8, radial: 2}"
FINE = "mesh={circumferential: 8, axial: 8, grading: 20, radial: 2}"
WEB, MU, THICKNESS, SLIP = 1e9, 0.48, 5e-5, 1e-6


def case(*changed: str) -> SlipDampingCase:
    found = load_case(CASE, [SMALL, *changed])
    assert isinstance(found, SlipDampingCase)
    return found


@cache
def coil(mesh: str = SMALL) -> tuple[Body, ShearPoints, np.ndarray]:
    """Roll of the case, its points, and a pressure that falls outwards."""
    (body,) = build_bodies(case(mesh), symmetric=True)
    assert body.solid is not None
    points = ShearPoints.of(body.solid).half()
    r = points.points[:, 2]
    return body, points, 5e6 - 4e6 * (r - r.min()) / np.ptp(r)


def modulus(pressure: np.ndarray, slip: float = SLIP) -> np.ndarray:
    return shear_modulus(WEB, pressure, mu=MU, elastic_slip=slip, wrap_thickness=THICKNESS)


def test_the_compliances_of_web_and_interface_add() -> None:
    """Under mu P, a wrap of 50 um moves by mu P h / G_l, and its interface by gamma*."""
    pressure = np.array([1e5, 1e6, 1e7])
    moved = THICKNESS * MU * pressure / modulus(pressure)
    np.testing.assert_allclose(moved, THICKNESS * MU * pressure / WEB + SLIP, rtol=1e-14)
    np.testing.assert_array_equal(modulus(pressure, 0.0), WEB)
    np.testing.assert_allclose(modulus(pressure, 1e-18), WEB, rtol=1e-9)


def test_without_elastic_slip_the_coil_is_that_of_the_given_modulus() -> None:
    given, wraps = (wf.run(case("excitation.amplitude_g=[3]", *more), progress=False) for more in (
        [], ["coil.wrap_interfaces={elastic_slip: 0}"]
    ))  # fmt: skip
    assert wraps.attrs["f_stuck_hz"] == pytest.approx(given.attrs["f_stuck_hz"], rel=1e-12)
    np.testing.assert_allclose(wraps["damping_at_level"], given["damping_at_level"], rtol=1e-6)
    np.testing.assert_array_equal(wraps["interlayer_shear_modulus"], WEB)
    assert "interlayer_shear_modulus" not in given


def test_shear_at_a_point_has_stiffness_limit_and_loop_of_its_own_modulus() -> None:
    """Displacements to and fro: the modulus and the limit of every point are those of its pressure."""
    body, points, pressure = coil()
    G, limit = modulus(pressure), MU * pressure
    assert np.ptp(G) > 0.5 * G.max()
    system, state = slipping_system(body, points, shear_modulus=G, pressure=pressure, mu=MU, wrap_thickness=5e-5)
    assert body.solid is not None
    u = np.random.default_rng(6).standard_normal(system.n_dofs)
    strain = (points.strain @ body.solid.expand @ u).reshape(-1, 2)
    share = 2.0 * np.median(limit / (G * np.linalg.norm(strain, axis=1)))
    u, strain = share * u, share * strain
    size = np.linalg.norm(strain, axis=1)
    trial, at, plastic = TrialContact(system), state, []
    for factor in (1.0, -1.0, 1.0):
        jump = state.jump + factor * (system.jump @ u)
        tau = tangentials(trial(jump, at)).copy()
        at = trial.committed(factor * u, jump)
        expected = factor * strain / size[:, None] * np.minimum(G * size, limit)[:, None]
        np.testing.assert_allclose(tau, expected, rtol=1e-10)
        plastic.append(factor * strain - tau / G[:, None])
    slides = size > limit / G
    assert 0.2 < slides.mean() < 0.9
    loop = sum(limit * np.linalg.norm(b - a, axis=1) for a, b in pairwise(plastic))
    exact = np.where(slides, 4.0 * limit * (size - limit / G), 0.0)
    np.testing.assert_allclose(loop, exact, atol=1e-10 * exact.max())


def test_the_stuck_stiffness_has_the_modulus_of_each_point() -> None:
    """K_0 plus the shear energy of the points, written out; the path factorises the same matrix."""
    body, points, pressure = coil()
    assert body.solid is not None
    G = modulus(pressure)
    path = LoadPath(*slipping_system(body, points, shear_modulus=G, pressure=pressure, mu=MU, wrap_thickness=5e-5))
    rows = points.strain @ body.solid.expand
    exact = body.stiffness + rows.T @ sp.diags(np.repeat(points.volumes * G, 2)) @ rows
    assert abs(path.stiffness - exact).max() < 1e-12 * abs(exact).max()


def test_two_layers_of_different_moduli_have_the_frequency_of_their_own_assembly() -> None:
    """Each layer assembled by itself with the rule of the elements: 0.1 %, as for the rule with one modulus."""
    body, points, pressure = coil(FINE)
    solid, chosen = body.solid, case(FINE)
    assert solid is not None
    inner, outer, heights = 3e8, 3e7, coil_heights(chosen)
    half = len(heights) // 2
    G = np.where(points.points[:, 2] < 0.01 + heights[half] - heights[0], inner, outer)
    path = LoadPath(*slipping_system(body, points, shear_modulus=G, pressure=pressure, mu=MU, wrap_thickness=5e-5))
    mode = main_mode(path.system, path)
    found = np.sqrt(mode @ (path.stiffness @ mode))
    part, web = build_mesh(chosen).part("mandrel"), chosen.coil.solid()
    n, shear = len(part.nodes), sp.lil_matrix((len(solid.nodes) * 3,) * 2)
    for first, levels, value in ((0, heights[: half + 1], inner), (half, heights[half:], outer)):
        model = SolidModel(*thicken(part.nodes, part.cells, list(levels)), thickness=0.015)
        layer = type(web)(**{**vars(web), "G_r_theta": value, "G_r_z": value})
        own = model.orthotropic_stiffness(layer) - model.orthotropic_stiffness(layer, between_wraps=False)
        at = slice(3 * n * first, 3 * n * first + own.shape[0])
        shear[at, at] = shear[at, at] + own
    stiffness = body.stiffness + solid.expand.T @ shear.tocsr() @ solid.expand
    exact = np.sqrt(solve_pairs(stiffness, body.mass, 1, sigma=DEFAULT_SHIFT).values[0])
    assert found == pytest.approx(exact, rel=1e-3)


def test_a_uniform_radial_modulus_gives_the_stiffness_that_the_elements_assemble() -> None:
    """Whatever the reference is; thick and thin coils have different weights of the two integration rules."""
    for thick in (["coil.thickness=15e-3"], ["coil.thickness=1e-3", "winding.wraps=20"]):
        (reference,), (wanted,) = (
            build_bodies(case(*thick, f"coil.material.E_r={E}"), symmetric=True) for E in (1e8, 7e6)
        )
        assert reference.solid is not None
        found = with_radial_modulus(
            reference.stiffness, reference.solid, case(*thick).coil.solid().stiffness(), lambda r: np.full_like(r, 7e6)
        )
        assert abs(found - wanted.stiffness).max() < 1e-9 * abs(wanted.stiffness).max()
        assert abs(found - reference.stiffness).max() > 1e-3 * abs(wanted.stiffness).max()


def test_the_energy_of_a_radial_motion_is_that_of_the_modulus_at_each_radius() -> None:
    """Displacement c (r - a) along r: strains c and c (r - a) / r; Poisson's ratios are zero."""
    flat = ["coil.material.nu_theta_r=0", "coil.material.nu_z_r=0", "coil.material.nu_theta_z=0"]
    chosen = case(*flat, "mesh.circumferential=16", "mesh.radial=4", "mesh.axial=4")
    (body,) = build_bodies(chosen, symmetric=True)
    assert body.solid is not None
    nodes, a, b, c = body.solid.nodes, 0.01, 0.025, 1e-3

    def law(r: np.ndarray) -> np.ndarray:
        return 1e7 + 9e7 * ((b - r) / (b - a)) ** 2

    changed = with_radial_modulus(sp.csr_matrix(body.stiffness.shape), body.solid, chosen.coil.solid().stiffness(), law)
    r = np.hypot(*nodes[:, :2].T)
    u = np.column_stack([nodes[:, :2] * (c * (r - a) / r)[:, None], np.zeros(len(nodes))]).ravel()
    moved = spla.lsqr(body.solid.expand, u, atol=1e-14, btol=1e-14)[0]
    np.testing.assert_allclose(body.solid.expand @ moved, u, atol=1e-9)
    x = np.linspace(a, b, 20001)
    exact = trapezoid(2.0 * np.pi * x * (law(x) - 1e8) * c**2, x) * 0.3
    assert moved @ (changed @ moved) == pytest.approx(exact, rel=3e-3)  # the circle is made of quadratic edges


def test_the_radial_stress_of_a_strain_is_that_of_the_modulus_at_the_point() -> None:
    moduli, reference = (7e6, 4e8), case().coil.solid().stiffness()
    for modulus, factor in zip(moduli, radial_change(np.array(moduli), reference), strict=True):
        exact = case(f"coil.material.E_r={modulus}").coil.solid().stiffness()[0, :3]
        np.testing.assert_allclose(factor * reference[0, :3], exact, rtol=1e-12)


@cache
def followed(factor: float, slip: float | None) -> ModalPath:
    """Path at the pressure times ``factor``, with the modulus of its pressure at an elastic slip, or a fixed one."""
    body, points, pressure = coil()
    G = modulus(pressure) if slip is None else modulus(factor * pressure, slip)
    path = LoadPath(
        *slipping_system(body, points, shear_modulus=G, pressure=factor * pressure, mu=MU, wrap_thickness=5e-5)
    )
    return modal_path(path, main_mode(path.system, path), np.geomspace(1.0, 5.0, 6))


def test_similarity_holds_for_a_fixed_modulus_but_not_for_one_that_follows_the_pressure() -> None:
    one, fixed = followed(1.0, None), followed(2.0, None)
    np.testing.assert_allclose(fixed.amplitude, 2.0 * one.amplitude, rtol=1e-6)
    np.testing.assert_allclose(fixed.frequency, one.frequency, rtol=1e-6)
    follows, together = followed(2.0, SLIP), followed(2.0, 2.0 * SLIP)
    assert np.all(follows.frequency > 1.02 * one.frequency)
    # with the elastic slip times the same factor the modulus stays
    np.testing.assert_allclose(together.amplitude, 2.0 * one.amplitude, rtol=1e-6)
    np.testing.assert_allclose(together.dissipation, 4.0 * one.dissipation, rtol=1e-6, atol=1e-9 * one.dissipation[-1])


def test_modulus_pressure_and_limit_of_a_case_belong_together() -> None:
    chosen = case("coil.wrap_interfaces={elastic_slip: 2 um, radial_modulus: winding}")
    _, points, system, start = slipping_structure(chosen)
    at = WoundCoil(chosen).at(points.points[:, 2])
    laws = system.laws
    np.testing.assert_allclose(start.pressure, at.pressure, rtol=1e-12)
    # the shear strain at the limit is that of the web, and the elastic slip per wrap thickness
    limit = laws.mu * start.pressure
    strain = laws.gamma / (points.volumes / laws.area)
    np.testing.assert_allclose(strain, limit / WEB + 2e-6 / THICKNESS, rtol=1e-9)
    np.testing.assert_allclose(1.0 / at.shear_modulus, 1.0 / WEB + 2e-6 / (MU * at.pressure * THICKNESS), rtol=1e-9)
    np.testing.assert_allclose(at.radial_modulus, 40.0 * (1e3 + at.pressure), rtol=1e-12)


@pytest.mark.filterwarnings("ignore:.*radial stress of the motion")
@pytest.mark.slow
def test_random_coils_are_softer_the_larger_the_elastic_slip() -> None:
    """Two coils, seed 23: tension, friction, wraps, modulus of the web; the points work as much as the curve tells."""
    rng = np.random.default_rng(23)
    for _ in range(2):
        wraps = int(rng.integers(80, 400))
        keys = {
            "coil.thickness": wraps * 5e-5, "winding.wraps": wraps, "winding.tension_stress": rng.uniform(5e6, 5e7),
            "winding.mu": rng.uniform(0.1, 0.6), "coil.material.G_r_theta": 10.0 ** rng.uniform(7.5, 9.0),
            "excitation.amplitude_g": [float(10.0 ** rng.uniform(-0.3, 0.7))],
        }  # fmt: skip
        chosen, hertz = [f"{key}={value}" for key, value in keys.items()], []
        for slip in [0.0, 10.0 ** rng.uniform(-8.0, -5.0)]:
            coil = case(*chosen, f"coil.wrap_interfaces={{elastic_slip: {slip}, radial_modulus: winding}}")
            _, _, system, start = slipping_structure(coil)
            path = LoadPath(system, start)
            mode = main_mode(system, path)
            hertz.append(np.sqrt(mode @ (path.stiffness @ mode)))
        assert hertz[0] > hertz[1]
        found = wf.run(coil, progress=False)
        assert found.attrs["f_stuck_hz"] == pytest.approx(hertz[-1] / (2.0 * np.pi), rel=1e-9)
        assert np.isfinite(found["tip_at_level"].values).all()
        worked, total = float((found["slip_work_density"] * found["volume"]).sum()), found["friction_work_per_cycle"]
        assert worked == pytest.approx(float(total[-1]), rel=0.1, abs=1e-12)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (["coil.wrap_interfaces={elastic_slip: -1e-6}"], "coil.wrap_interfaces.elastic_slip: must be 0 or more"),
        (["coil.wrap_interfaces={}"], "coil.wrap_interfaces.elastic_slip: required key is missing"),
        (["coil.wrap_interfaces={elastic_slip: 1 kg}"], "coil.wrap_interfaces.elastic_slip"),
        (
            ["coil.wrap_interfaces={elastic_slip: 1e-6, radial_modulus: pfeiffer}"],
            "radial_modulus: is not one of the choices, got 'pfeiffer'; use material, winding",
        ),
        (
            ["coil.wrap_interfaces={elastic_slip: 1e-6}", "coil.inside=stiff", "analysis=modal_transient"],
            "coil.wrap_interfaces: are for a solid coil whose wraps slide; leave them out",
        ),
    ],
)
def test_wrong_interfaces_are_refused_in_one_line(changed: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        case(*changed)


def test_a_radial_modulus_that_does_not_fit_the_web_is_refused() -> None:
    stiff = ["winding.web.radial_modulus={law: constant, E_r: 1e12}"]
    chosen = case("coil.wrap_interfaces={elastic_slip: 0, radial_modulus: winding}", *stiff)
    with pytest.raises(InputError, match=r"winding.web.radial_modulus: the law gives 1e\+12 Pa in the coil"):
        wf.run(chosen, progress=False)
