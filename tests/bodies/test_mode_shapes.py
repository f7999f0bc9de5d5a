"""Names of modes and effective masses, on synthetic fields and on the lab mandrel."""

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from support.paths import CONFIGS

from wroll_fem.bodies.body import Body
from wroll_fem.bodies.mode_shapes import (
    align_pairs,
    circumferential_content,
    classify_mode,
    effective_mass_fractions,
)
from wroll_fem.case import load_case
from wroll_fem.fem.body import assemble_bodies
from wroll_fem.fem.eigen import solve_modes, solve_pairs

TINY = CONFIGS / "tiny.yaml"


def ring_body(levels=7, around=24, mass=2.0, name="mandrel"):
    """Nodes on a cylinder with all six values free; unit stiffness so that nothing counts as rigid."""
    theta, z = np.meshgrid(2 * np.pi * np.arange(around) / around, np.linspace(0, 0.3, levels) ** 1.5)
    nodes = np.column_stack([0.04 * np.cos(theta.ravel()), 0.04 * np.sin(theta.ravel()), z.ravel()])
    n = 6 * len(nodes)
    eye = sp.eye(n, format="csr")
    influence = np.zeros((n, 3))
    influence[0::6, 0] = influence[1::6, 1] = influence[2::6, 2] = 1.0
    empty = np.empty((0, 9), np.int64)
    return Body(name, 1e6 * eye, eye, influence, eye, nodes, empty, {}, np.zeros(n), {}, mass)


def field(body, radial=0.0, hoop=0.0, axial=0.0):
    """Nodal vector from cylindrical components, each a function of (theta, z) or a number."""
    theta, z = np.arctan2(body.nodes[:, 1], body.nodes[:, 0]), body.nodes[:, 2]
    ur, ut, uz = (f(theta, z) if callable(f) else np.full(len(z), f) for f in (radial, hoop, axial))
    values = np.zeros((len(z), 6))
    values[:, 0] = np.cos(theta) * ur - np.sin(theta) * ut
    values[:, 1] = np.sin(theta) * ur + np.cos(theta) * ut
    values[:, 2] = uz
    return values.ravel()


@pytest.mark.parametrize(
    ("components", "kind"),
    [
        ({"hoop": lambda t, z: z}, "torsion"),
        ({"axial": lambda t, z: z}, "axial"),
        ({"radial": lambda t, z: np.sin(9 * z)}, "breathing"),
        ({"radial": lambda t, z: z**2 * np.cos(t), "hoop": lambda t, z: -(z**2) * np.sin(t)}, "bending"),
        ({"radial": lambda t, z: np.cos(2 * t), "hoop": lambda t, z: -0.5 * np.sin(2 * t)}, "ovalling-2"),
        ({"radial": lambda t, z: z * np.cos(5 * t + 0.3)}, "ovalling-5"),
        ({"axial": lambda t, z: np.sin(3 * t)}, "ovalling-3"),
    ],
)
def test_mode_is_named_by_its_dominant_wave_and_component(components, kind):
    body = ring_body()
    found = classify_mode([body], field(body, **components))
    assert found.kind == kind
    assert found.share == pytest.approx(1.0, abs=1e-12)


def test_content_is_the_mean_square_displacement():
    body = ring_body()
    vector = field(body, radial=lambda t, z: 3 + 2 * np.cos(2 * t), hoop=lambda t, z: np.sin(4 * t))
    content = circumferential_content(body, vector)
    assert content[0, 2] == pytest.approx(2.0 * 9.0)
    assert content[2, 2] == pytest.approx(2.0 * 4.0 / 2)
    assert content[4, 0] == pytest.approx(2.0 * 1.0 / 2)
    assert content.sum() == pytest.approx(18 + 4 + 1)


def test_content_weighs_rings_by_the_height_they_stand_for():
    body = ring_body(levels=40)  # rings crowd towards the root
    content = circumferential_content(body, field(body, radial=lambda t, z: z / z.max()))
    assert content[0, 2] == pytest.approx(2.0 / 3, rel=2e-3)


def test_uneven_rings_are_weighed_by_their_arcs():
    body = ring_body(around=48)
    theta = np.arctan2(body.nodes[:, 1], body.nodes[:, 0])
    theta = theta + 0.3 * np.sin(theta)  # crowded on one side
    nodes = np.column_stack([0.04 * np.cos(theta), 0.04 * np.sin(theta), body.nodes[:, 2]])
    n = 6 * len(nodes)
    eye = sp.eye(n, format="csr")
    uneven = Body("own", 1e6 * eye, eye, np.zeros((n, 3)), eye, nodes, body.cells, {}, np.zeros(n), {}, 1.0)
    found = classify_mode([uneven], field(uneven, radial=lambda t, z: np.cos(3 * t)))
    assert found.kind == "ovalling-3"
    assert found.share > 0.9999


def test_heavier_body_decides_the_name_of_a_shared_mode():
    light, heavy = ring_body(mass=0.1), ring_body(mass=5.0, name="layer_01")
    vector = np.concatenate([field(light, hoop=1.0), field(heavy, radial=lambda t, z: np.cos(2 * t))])
    assert classify_mode([light, heavy], vector).kind == "ovalling-2"
    with pytest.raises(ValueError, match="unknowns"):
        classify_mode([light], vector)


def test_pairs_are_turned_so_that_one_mode_takes_all_motion_along_x():
    body = ring_body()
    shape = lambda t, z: z**2 * np.cos(t)  # noqa: E731
    x = field(body, radial=shape, hoop=lambda t, z: -(z**2) * np.sin(t))
    y = field(body, radial=lambda t, z: z**2 * np.sin(t), hoop=lambda t, z: z**2 * np.cos(t))
    x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
    mixed = np.column_stack([0.6 * x - 0.8 * y, 0.8 * x + 0.6 * y])
    turned = align_pairs(np.array([150.0, 150.0]), mixed, body.mass, body.influence)
    np.testing.assert_allclose(turned.T @ turned, np.eye(2), atol=1e-12)
    np.testing.assert_allclose(np.abs(turned[:, 0] @ x), 1.0, rtol=1e-12)
    apart = align_pairs(np.array([150.0, 151.0]), mixed, body.mass, body.influence)
    np.testing.assert_array_equal(apart, mixed)


@pytest.fixture(scope="module")
def mandrel():
    return assemble_bodies(load_case(TINY, ["analysis=modal", "coil.model=none"]), symmetric=False)[0]


def test_lab_mandrel_modes_have_their_names_and_effective_masses(mandrel):
    frequencies, vectors = solve_modes(mandrel.stiffness, mandrel.mass, 12)
    vectors = align_pairs(frequencies, vectors, mandrel.mass, mandrel.influence)
    kinds = [classify_mode([mandrel], v).kind for v in vectors.T]
    assert kinds[:7] == ["bending"] * 2 + ["ovalling-2"] * 2 + ["ovalling-3"] * 2 + ["torsion"]
    fractions = effective_mass_fractions(mandrel.mass, mandrel.influence, vectors, mandrel.mass_total)
    # a uniform cantilever with this tip mass: 0.69 of the mass in the first bending mode
    np.testing.assert_allclose(fractions[:2], [[0.692, 0, 0], [0, 0.692, 0]], atol=5e-3)
    assert np.abs(fractions[2:7]).max() < 1e-6
    assert "axial" in kinds
    assert fractions[kinds.index("axial"), 2] > 0.75


def test_effective_masses_of_all_modes_sum_to_the_moving_mass():
    body = assemble_bodies(
        load_case(TINY, ["analysis=modal", "coil.model=none", "mesh.circumferential=8", "mesh.axial=2"]), symmetric=True
    )[0]
    import scipy.linalg as la

    _, vectors = la.eigh(body.stiffness.toarray(), body.mass.toarray())
    fractions = effective_mass_fractions(body.mass, body.influence, vectors, body.mass_total)
    moving = np.diag(body.influence.T @ body.mass @ body.influence) / body.mass_total
    np.testing.assert_allclose(fractions.sum(axis=0), moving, rtol=1e-9)
    # what is missing is the mass tied to the clamped ring
    assert 0.9 < moving[0] < 1.0


def test_modes_without_strain_are_called_rigid():
    body = assemble_bodies(
        load_case(TINY, ["analysis=modal", "coil.model=none", "mandrel.base=free", "mandrel.tip=free"]), symmetric=False
    )[0]
    _, vectors = solve_modes(body.stiffness, body.mass, 8)
    kinds = [classify_mode([body], v).kind for v in vectors.T]
    assert kinds == ["rigid"] * 6 + ["ovalling-2"] * 2


@pytest.mark.slow
def test_factors_of_one_eigenproblem_are_gone_before_the_next():
    """9 MB each here, 200 MB in a coarse solid roll: a process that runs many cases must not gather them."""

    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

    side = 120
    line, one = sp.diags([-1, 2, -1], [-1, 0, 1], shape=(side, side)), sp.identity(side)
    stiffness, mass = (sp.kron(line, one) + sp.kron(one, line)).tocsr(), sp.identity(side**2, format="csr")
    solve_pairs(stiffness, mass, 3, -1e-3)
    before = resident()
    for _ in range(3):
        solve_pairs(stiffness, mass, 3, -1e-3)
    assert resident() - before < 9e6
