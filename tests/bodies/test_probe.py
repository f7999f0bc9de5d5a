"""Probes: rigid motions, nodal values, interpolation of the exact quadratic field, points off the shell."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import wroll_fem as wf
from wroll_fem.analyses.shared.assembly import build_bodies
from wroll_fem.bodies.body import Body
from wroll_fem.bodies.probe import DIRECTIONS, Probe, _slopes, probe_row, shape_functions
from wroll_fem.errors import InputError

SEED = 20261122


@cache
def bodies(symmetric: bool = False) -> list[Body]:
    return build_bodies(wf.example_case(), symmetric=symmetric)


def frame(theta: float) -> dict[str, np.ndarray]:
    c, s = np.cos(theta), np.sin(theta)
    vectors = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "radial": (c, s, 0), "hoop": (-s, c, 0)}
    return {name: np.array(vector, float) for name, vector in vectors.items()}


def points(count: int) -> list[tuple[float, float]]:
    rng = np.random.default_rng(SEED)
    return [(float(theta), float(z)) for theta, z in rng.uniform((-np.pi, 0.0), (np.pi, 0.3), (count, 2))]


def test_shape_functions_are_one_at_their_node() -> None:
    places = [(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0), (0, 0)]
    values = np.array([shape_functions(np.array(place, float)) for place in places])
    np.testing.assert_allclose(values, np.eye(9), atol=1e-15)


def test_slopes_are_those_of_the_shape_functions() -> None:
    local, step = np.array([0.3, -0.7]), 1e-6 * np.eye(2)
    differences = [(shape_functions(local + d) - shape_functions(local - d)) / 2e-6 for d in step]
    np.testing.assert_allclose(_slopes(local), np.column_stack(differences), atol=1e-9)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_a_probe_interpolates_the_motion_of_its_cell(direction: str) -> None:
    """Random motions of the degrees of freedom; the element's own interpolation, done node by node."""
    body = bodies()[0]
    rng = np.random.default_rng(SEED)
    motion = rng.standard_normal(body.n_dofs)
    nodal = (body.expand @ motion).reshape(-1, 6)[:, :3]
    for node in rng.choice(len(body.nodes), 12, replace=False):
        x, y, z = body.nodes[node]
        theta = float(np.arctan2(y, x))
        row = probe_row(body, Probe(theta, float(z), direction))  # type: ignore[arg-type]
        assert row @ motion == pytest.approx(nodal[node] @ frame(theta)[direction], abs=1e-9)


def test_a_field_that_the_element_holds_is_exact_between_nodes() -> None:
    """A displacement that is quadratic in height and angle comes back at random points."""
    body = bodies()[1]  # its base is free: every node has unknowns
    theta = np.arctan2(body.nodes[:, 1], body.nodes[:, 0])
    height = body.nodes[:, 2]
    values = np.zeros((len(body.nodes), 6))
    values[:, 2] = 1e-3 * (1.0 + 5.0 * height - 20.0 * height**2)
    values[:, 0] = 1e-3 * np.cos(theta)
    dofs = np.linalg.lstsq(body.expand.toarray(), values.ravel(), rcond=None)[0]
    np.testing.assert_allclose(body.expand @ dofs, values.ravel(), atol=1e-12)
    for angle, z in points(20):
        axial = probe_row(body, Probe(angle, z, "z", body.name)) @ dofs
        assert axial == pytest.approx(1e-3 * (1.0 + 5.0 * z - 20.0 * z**2), rel=1e-9)
        lateral = probe_row(body, Probe(angle, z, "x", body.name)) @ dofs
        assert lateral == pytest.approx(1e-3 * np.cos(angle), abs=2e-5)  # 12 quadratic elements around


def test_half_a_roll_moves_as_the_whole_one() -> None:
    """The base translates: both models move by the influence vector, also on the half that is not modelled."""
    for body in (*bodies(symmetric=True), *bodies()):
        for angle, z in points(6):
            z = max(z, 0.1)  # the clamped base has no unknowns
            for direction, vector in frame(angle).items():
                row = probe_row(body, Probe(angle, z, direction, body.name))  # type: ignore[arg-type]
                assert row @ body.influence[:, 0] == pytest.approx(vector[0], abs=1e-9)


@pytest.mark.parametrize("z", [-0.01, 0.31])
def test_a_point_off_the_shell_is_refused(z: float) -> None:
    with pytest.raises(InputError, match=r"z: .* m is outside mandrel; give a height between 0 and 0.3 m"):
        probe_row(bodies()[0], Probe(0.0, z))
