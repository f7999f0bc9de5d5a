"""Guided base of the layers: limits of the axial spring, and a tube on its spring in closed form."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from scipy.optimize import brentq
from support.paths import CONFIGS

from wroll_fem.bodies.body import Body
from wroll_fem.case import load_case
from wroll_fem.errors import InputError
from wroll_fem.fem.body import assemble_bodies

GUIDED = ("coil.base=guided", "mesh.circumferential=12", "mesh.axial=3", "mesh.grading=1")
E, RHO, LENGTH = 2.8e9, 2000.0, 0.3


def layer(*overrides: str, symmetric: bool = True) -> Body:
    case = load_case(CONFIGS / "tiny.yaml", ["analysis=modal", *GUIDED, *overrides])
    return assemble_bodies(case, symmetric=symmetric)[1]


def frequencies(body: Body, held: np.ndarray | None = None) -> np.ndarray:
    """Natural frequencies, Hz; `held` marks unknowns that are eliminated."""
    keep = np.ones(body.n_dofs, bool) if held is None else ~held
    K, M = (matrix[keep][:, keep].toarray() for matrix in (body.stiffness, body.mass))
    return np.sqrt(np.maximum(la.eigh(K, M, eigvals_only=True), 0.0)) / (2.0 * np.pi)


def on_base(body: Body, component: int) -> np.ndarray:
    """Unknowns of a component at the base ring."""
    low = body.nodes[:, 2] < 1e-9
    node = np.asarray(body.unknown_node)
    return (node >= 0) & low[node] & (np.asarray(body.unknown_component) == component)


@pytest.mark.parametrize("symmetric", [True, False])
def test_radial_and_hoop_displacements_of_the_ring_are_held(symmetric: bool) -> None:
    body = layer(symmetric=symmetric)
    assert not on_base(body, 0).any()
    assert not on_base(body, 1).any()
    assert on_base(body, 2).any()
    ring = np.flatnonzero(body.nodes[:, 2] < 1e-9)
    rows = (6 * ring[:, None] + np.arange(2)).ravel()
    assert abs(body.expand[rows]).max() == 0.0


def test_without_a_spring_the_ring_slides_along_the_axis() -> None:
    """A translation along the axis costs no energy, one across it does."""
    body = layer(symmetric=False)
    along, across = body.influence[:, 2], body.influence[:, 0]
    assert along @ body.stiffness @ along < 1e-9 * (across @ body.stiffness @ across)


def test_a_stiff_spring_holds_the_ring_like_a_clamp_of_its_displacements() -> None:
    loose = layer()
    held = frequencies(loose, on_base(loose, 2))[:12]
    for stiffness, off in ((1e14, 1e-3), (1e16, 1e-5)):
        found = frequencies(layer(f"coil.base_stiffness={stiffness}"))[:12]
        np.testing.assert_allclose(found, held, rtol=off)
    # rotations of a thin wall hardly matter: a clamped ring differs only in its edge bending
    clamped = frequencies(layer("coil.base=clamped"))[:12]
    np.testing.assert_allclose(held[:3], clamped[:3], rtol=0.02)


@pytest.mark.parametrize("stiffness", [1e6, 1e8, 1e10])
def test_axial_vibration_is_that_of_a_rod_on_a_spring(stiffness: float) -> None:
    """Without Poisson's ratio: E t b tan(b L) = k, f = b sqrt(E/rho)/(2 pi); t is the thickness of the layer."""
    body = layer(f"coil.base_stiffness={stiffness}", "coil.material.nu=0", f"coil.material.E={E}",
                 f"coil.material.rho={RHO}", symmetric=False)  # fmt: skip
    thickness = 1.25e-3

    def off(x: float) -> float:
        return E * thickness / LENGTH * x * np.sin(x) - stiffness * np.cos(x)

    exact = brentq(off, 1e-6, 0.5 * np.pi) / LENGTH * np.sqrt(E / RHO) / (2.0 * np.pi)
    values, modes = la.eigh(body.stiffness.toarray(), body.mass.toarray())
    share = (modes.T @ body.mass @ body.influence[:, 2]) ** 2  # effective mass along the axis
    found = np.sqrt(values[int(share.argmax())]) / (2.0 * np.pi)
    assert found == pytest.approx(exact, rel=2e-4)
    assert body.mass_total > 0.0


def test_the_spring_has_the_stiffness_of_the_whole_ring() -> None:
    """The energy of a unit translation is k times the circumference, of the half model as well."""
    for symmetric in (True, False):
        body, free = (layer(*extra, symmetric=symmetric) for extra in (("coil.base_stiffness=1e7",), ()))
        along = body.influence[:, 2]
        radius = np.hypot(*body.nodes[0, :2])
        added = along @ (body.stiffness - free.stiffness) @ along
        assert added == pytest.approx(1e7 * 2.0 * np.pi * radius, rel=2e-4)


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (["coil.base=clamped", "coil.base_stiffness=1e6"], "does not apply to base: clamped"),
        (["coil.base=guided", "coil.base_stiffness=-1"], "base_stiffness"),
        (["coil.base=guided", "coil.model=nonstructural_mass"], "applies to shells, not to model"),
    ],
)
def test_a_guided_base_that_makes_no_sense_is_refused(overrides: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        load_case(CONFIGS / "tiny.yaml", ["analysis=modal", *overrides])


def test_other_bases_keep_their_case(tmp_path) -> None:
    """The key is written for a guided base alone, so that stored runs are found again."""
    plain = load_case(CONFIGS / "tiny.yaml", ["analysis=modal"])
    assert "base_stiffness" not in plain.coil.model_dump()
    guided = load_case(CONFIGS / "tiny.yaml", ["analysis=modal", "coil.base=guided"])
    assert guided.coil.model_dump()["base_stiffness"] == 0.0
