"""Torsion and axial modes of a coil whose wraps slide: against closed forms, Fourier elements and whole cycles."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import jv, yv
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.followed_mode import axisymmetric_mode
from wroll_fem.analyses.shared.assembly import build_bodies
from wroll_fem.analyses.slip_structure import WoundCoil, slipping_structure
from wroll_fem.bodies.base_loads import axial_rotation
from wroll_fem.case import SlipDampingCase, load_case
from wroll_fem.dynamics.statics.cycle_path import cycle_path
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import modal_path
from wroll_fem.errors import InputError
from wroll_fem.fem.fourier_modes import symmetry_class_modes
from wroll_fem.fem.fourier_roll import AXIAL, TORSION, FourierRoll

CASE = CONFIGS / "slipping_coil.yaml"
MESHES = {
    "torsion": "mesh={circumferential: 8, axial: 8, grading: 20, radial: 2}",
    "axial": "mesh={circumferential: 8, axial: 6, grading: 12, radial: 2}",
}
RIGID = ["mandrel.material.E=1e15", "coil.material.G_r_theta=1e7", "mesh={circumferential: 12, axial: 2, radial: 3}"]
A, B, LENGTH, RHO = 0.010, 0.025, 0.3, 1600.0  # m, kg/m^3


def case(mode: str, *changed: str, levels: str = "[1]") -> SlipDampingCase:
    motion = f"excitation={{kind: sine, frequency: resonance, amplitude_g: {levels}, mode: {mode}}}"
    found = load_case(CASE, [MESHES[mode], motion, *changed])
    assert isinstance(found, SlipDampingCase)
    return found


@cache
def followed(mode: str, *changed: str) -> tuple[LoadPath, np.ndarray]:
    """Path from rest of a case, and its mode."""
    _, _, system, start = slipping_structure(case(mode, *changed))
    path = LoadPath(system, start)
    return path, axisymmetric_mode(system, path)


def hertz(mode: str, *changed: str) -> float:
    path, shape = followed(mode, *changed)
    residual = path.stiffness @ shape - (square := float(shape @ (path.stiffness @ shape))) * (path.system.mass @ shape)
    assert np.sqrt(residual @ path.stuck(residual)) < 1e-6 * np.sqrt(square)
    return float(np.sqrt(square) / (2.0 * np.pi))


@pytest.mark.parametrize("mode", ["torsion", "axial"])
def test_without_slip_the_mode_is_that_of_modal(mode: str) -> None:
    """Fourier elements of the stiff coil; the mesh of hexahedra is coarse."""
    changed = ["analysis=modal", "damping_ratio=null", "coil.inside=stiff", "mesh={discretisation: fourier, radial: 4}"]
    found = symmetry_class_modes(FourierRoll(load_case(CASE, changed)), {"torsion": TORSION, "axial": AXIAL}[mode], 4)
    same = next(one for one in found if one.kind == mode)
    assert hertz(mode) == pytest.approx(same.frequency_hz, rel=5e-3)


@pytest.mark.parametrize(("mode", "order"), [("torsion", 1), ("axial", 0)])
def test_a_coil_on_a_rigid_mandrel_has_the_frequency_of_its_shear(mode: str, order: int) -> None:
    """Hoop motion J1, Y1 without stress at the free surface (J2, Y2); axial motion J0, Y0 without slope (J1, Y1).

    Along the axis, the radial motion near the ends is held by a stiff E_r without Poisson's ratios.
    """
    held = ["coil.material.E_r=1e11", "coil.material.nu_theta_r=0", "coil.material.nu_z_r=0"] if mode == "axial" else []
    up = order + 1

    def determinant(k: float) -> float:
        return float(jv(order, k * A) * yv(up, k * B) - yv(order, k * A) * jv(up, k * B))

    k = brentq(determinant, 0.3 / (B - A), 2.0 / (B - A))
    assert hertz(mode, *RIGID, *held) == pytest.approx(k * np.sqrt(1e7 / RHO) / (2.0 * np.pi), rel=3e-3)


def test_torsion_of_wraps_whose_modulus_follows_the_pressure_is_that_of_its_differential_equation() -> None:
    """(r^3 G phi')' + w^2 rho r^3 phi = 0 with phi(a) = 0 and phi'(b) = 0, integrated from the mandrel outwards."""
    changed = (*RIGID, "coil.material.G_r_theta=1e9", "coil.wrap_interfaces={elastic_slip: 1.0e-5}")
    coil = WoundCoil(case("torsion", *changed))
    at = np.linspace(A, B - 1e-6, 400)
    modulus = coil.at(at).shear_modulus
    assert modulus.max() > 1.5 * modulus[at < 0.024].min()

    def moment(w: float) -> float:
        def slope(r: float, y: np.ndarray) -> list[float]:
            G = float(np.interp(r, at, modulus))
            return [y[1] / (r**3 * G), -(w**2) * RHO * r**3 * y[0]]

        return float(solve_ivp(slope, (A, B), [0.0, 1.0], rtol=1e-8, atol=1e-14, max_step=1e-3).y[1, -1])

    w = brentq(moment, 2.0 * np.pi * 500.0, 2.0 * np.pi * 2500.0, xtol=1.0)
    assert hertz("torsion", *changed) == pytest.approx(w / (2.0 * np.pi), rel=3e-3)


def test_gross_slip_on_a_rigid_mandrel_is_where_the_torque_reaches_that_of_friction() -> None:
    """The stress is statically determined: a ring of points that slides holds no further load, and the path ends."""
    coarse = (*RIGID, "mesh={circumferential: 8, axial: 2, radial: 2}")
    chosen = case("torsion", *coarse, levels="[1e6]")
    with pytest.warns(UserWarning, match=r"all wraps at r = 10.\d+ mm slide \(gross slip\)"):
        found = wf.run(chosen, progress=False)
    assert found.sizes["tip_amplitude"] == 1
    assert np.isnan(found["tip_at_level"]).all()
    path, mode = followed("torsion", *coarse)
    body, points, _, start = slipping_structure(chosen)
    square = float(mode @ (path.stiffness @ mode))
    state = path.to(modal_path(path, mode, [1.0 - 1e-6]).force[0] * (path.system.mass @ mode))
    traction = np.abs(state.traction[: 2 * len(points.volumes) : 2])
    r = points.points[:, 2]
    ratio = traction / (0.48 * start.pressure)
    assert ratio.max() == pytest.approx(1.0, rel=1e-5)
    # the moment of the inertia outside the innermost points
    inner = r < r.min() * 1.001
    moved = square * state.displacement @ (path.system.mass @ axial_rotation(body))
    torque = 2.0 * np.pi * r[inner].mean() ** 2 * LENGTH * traction[inner].mean()
    assert torque == pytest.approx(abs(moved), rel=0.02)


@pytest.mark.parametrize("mode", ["torsion", "axial"])
def test_the_curve_gives_frequency_and_dissipation_of_whole_cycles(mode: str) -> None:
    path, shape = followed(mode)
    curve = modal_path(path, shape, np.geomspace(1.0, 6.0, 13))
    path, shape = LoadPath(path.system, path.start), shape
    cycles = cycle_path(path, shape, curve.force[[6, 12]] / curve.force[0])
    np.testing.assert_allclose(cycles.amplitude, curve.amplitude[[6, 12]], rtol=2e-3)
    np.testing.assert_allclose(cycles.frequency, curve.frequency[[6, 12]], rtol=1e-3)
    np.testing.assert_allclose(cycles.dissipation, curve.dissipation[[6, 12]], rtol=0.01)
    # loops of a percent of the stored energy: the error of their area is that of the states
    np.testing.assert_allclose(cycles.loop_area, cycles.dissipation, rtol=0.03)


def test_a_turning_base_moves_every_free_node_by_the_rotation() -> None:
    (body,) = build_bodies(case("torsion"), symmetric=False)
    turned = axial_rotation(body)
    assert body.solid is not None
    for nodes, moved in (
        (body.nodes, (body.expand @ turned).reshape(-1, 6)[:, :3]),
        (body.solid.nodes, (body.solid.expand @ turned).reshape(-1, 3)),
    ):
        free = np.abs(moved).max(axis=1) > 0.0
        assert free.mean() > 0.9
        exact = np.column_stack([-nodes[:, 1], nodes[:, 0], np.zeros(len(nodes))])
        np.testing.assert_allclose(moved[free], exact[free], atol=1e-9)
    polar = 0.5 * np.pi * LENGTH * (RHO * (B**4 - A**4) + 2700.0 * (A**4 - 0.009**4))
    assert turned @ (body.mass @ turned) == pytest.approx(polar, rel=0.01)  # the clamped nodes are missing


@pytest.mark.parametrize("mode", ["torsion", "axial"])
def test_base_and_tip_move_by_one_at_the_surface_of_the_mandrel(mode: str) -> None:
    """A rigid motion of the base by 1 m moves the tip by as much; so it is that of a level in g."""
    system = followed(mode)[0].system
    assert float(system.probes["tip"] @ system.influence) == pytest.approx(1.0, rel=1e-9)


def test_a_coil_with_a_clamped_base_is_not_in_gross_slip() -> None:
    """Its base holds a cylinder on which every point slides."""
    coarse = "mesh={circumferential: 8, axial: 4, grading: 20, radial: 1}"
    clamped = wf.run(case("axial", coarse, "coil.base=clamped", "winding.mu=1e-6", levels="[2]"), progress=False)
    assert float(clamped["slipping_volume_fraction"][-1]) > 0.9
    assert np.isfinite(clamped["tip_at_level"]).all()


def test_half_of_the_roll_suffices_for_axial_motion() -> None:
    assert hertz("axial") == pytest.approx(hertz("axial", "solver.symmetry=false"), rel=1e-9)


@cache
def result(mode: str) -> xr.Dataset:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return wf.run(case(mode, levels="[5, 50]"), progress=False)


@pytest.mark.parametrize(("mode", "across", "along"), [("torsion", "rz", "rt"), ("axial", "rt", "rz")])
def test_slip_works_in_the_direction_of_the_mode(mode: str, across: str, along: str) -> None:
    found = result(mode)
    total, worked = found["friction_work_per_cycle"].values[-1], 1e-3
    assert found[f"friction_work_{along}_per_cycle"].values[-1] == pytest.approx(total, rel=worked)
    assert found[f"friction_work_{across}_per_cycle"].values[-1] < worked * total
    density = (found[f"slip_work_density_{along}"] * found["volume"]).sum()
    assert float(density) == pytest.approx(total, rel=worked)
    assert found.attrs["followed_mode"] == mode


@pytest.mark.parametrize("mode", ["torsion", "axial"])
def test_the_base_works_as_much_as_damping_dissipates(mode: str) -> None:
    """At resonance the base works pi A |m v|; at low levels the tip is that of the mode."""
    found = result(mode)
    assert float(found["damping_at_level"][0]) >= 0.02
    assert float(found["damping_at_level"][1]) > 1.1 * float(found["damping_at_level"][0])
    assert float(found["frequency_at_level"][1]) < found.attrs["f_stuck_hz"]
    path, shape = followed(mode)
    inertia = path.system.mass @ path.system.influence
    linear = abs(float((shape @ inertia) * (path.system.probes["tip"] @ shape))) * 5.0 * 9.80665
    linear /= 2.0 * 0.02 * (2.0 * np.pi * found.attrs["f_stuck_hz"]) ** 2
    assert float(found["tip_at_level_without_slip"][0]) == pytest.approx(linear, rel=1e-9)
    base, tip = found["resonant_base_acceleration"].values, found["tip_amplitude"].values
    work = found["friction_work_per_cycle"].values + found["material_damping_work_per_cycle"].values
    per_tip = work[0] / (base[0] * tip[0])
    np.testing.assert_allclose(work[:5], (per_tip * base * tip)[:5], rtol=0.02)  # later the shape changes


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (["excitation.mode=twist"], "excitation.mode: is not one of the choices, got 'twist'; use bending, torsion"),
        (
            ["excitation.mode=axial", "excitation.direction=x"],
            "excitation.direction: is the direction of bending; mode: axial has none, got 'x'; leave it out",
        ),
        (
            ["analysis=modal_transient", "coil.inside=stiff"],
            "excitation.mode: analysis modal_transient has a base that moves along x or y, got 'torsion'; leave it out",
        ),
    ],
)
def test_wrong_modes_are_refused_in_one_line(changed: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        case("torsion", *changed)


def test_bending_is_not_written_to_the_case() -> None:
    plain = load_case(CASE)
    assert "mode" not in plain.resolved()["excitation"]
    assert case("torsion").resolved()["excitation"]["mode"] == "torsion"
    assert "direction" not in case("torsion").resolved()["excitation"]
