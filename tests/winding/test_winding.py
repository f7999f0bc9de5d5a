"""Wound-roll stress against exact solutions and against the scheme of the thesis, and its limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from wroll_fem.case.winding import Winding
from wroll_fem.errors import InputError
from wroll_fem.winding import RadialModulus, WoundRoll, closed_form, kernels, tube_stiffness, wound_roll

CASE_STUDY: dict[str, Any] = {
    "tension_stress": 40.0e6, "wraps": 300, "wrap_thickness": 5.0e-5, "mu": 0.48,
    "mandrel": {"outer_radius": 0.010, "wall": 1.0e-3, "E": 70.0e9, "nu": 0.33},
    "web": {"E_theta": 10.0e9, "nu_theta": 0.3, "radial_modulus": {"law": "pfeiffer", "K1": 1.0e3, "K2": 40}},
}  # fmt: skip


def roll(web: dict[str, Any] | None = None, mandrel: dict[str, Any] | None = None, **changes: Any) -> WoundRoll:
    return wound_roll(section(web, mandrel, **changes))


def section(web: dict[str, Any] | None = None, mandrel: dict[str, Any] | None = None, **changes: Any) -> Winding:
    data = CASE_STUDY | changes
    data["web"] = data["web"] | (web or {})
    data["mandrel"] = {"outer_radius": 0.010, **mandrel} if mandrel else data["mandrel"]
    return Winding.model_validate(data)


def constant(modulus: float) -> dict[str, Any]:
    return {"radial_modulus": {"law": "constant", "E_r": modulus}}


# ---- exact solutions -----------------------------------------------------------------------------


def test_the_closed_form_solves_the_winding_equation_and_the_core_condition() -> None:
    """Claim C1: residual of r^2 s'' + 3 r s' + (1 - E/E_r) s by differences of the power law, below 1e-8."""
    ratio, core, inner, outer = 7.0, 1.7, 0.01, 0.025
    q = np.sqrt(ratio)
    r = np.linspace(inner, outer, 7)
    basis = np.array([r ** (q - 1.0), r ** (-q - 1.0)])
    a, b = np.linalg.lstsq(basis.T, closed_form.increment(r, inner, outer, ratio=ratio, core=core), rcond=None)[0]
    s, first = a * basis[0] + b * basis[1], (q - 1) * a * basis[0] / r - (q + 1) * b * basis[1] / r
    second = (q - 1) * (q - 2) * a * basis[0] / r**2 + (q + 1) * (q + 2) * b * basis[1] / r**2
    np.testing.assert_allclose(s, closed_form.increment(r, inner, outer, ratio=ratio, core=core), rtol=1e-10)
    assert np.abs(r**2 * second + 3 * r * first + (1 - ratio) * s).max() < 1e-8
    assert s[-1] == pytest.approx(1.0, rel=1e-12)
    assert inner * first[0] == pytest.approx((core - 1.0) * s[0], rel=1e-9)


CASES = [(10.0e9, 7.6e9), (1.0e8, 7.6e9), (1.0e7, 2.0e8), (40.0e9, 1.0e12)]


def tapering(r: Any) -> Any:
    return 40.0e6 * (1.0 - 0.4 * (r - 0.010) / 0.015)


@pytest.mark.parametrize(("E_r", "stiffness"), CASES)
def test_constant_modulus_agrees_with_the_closed_form(E_r: float, stiffness: float) -> None:
    found = roll(constant(E_r), {"stiffness": stiffness}, tension_profile={"kind": "taper", "taper": 0.4})
    at = np.array([0, 1, 2, 50, 200, 280])
    exact = closed_form.pressure_of_wraps(
        found.radius[at], 0.010, 5.0e-5, tapering(0.010 + 5.0e-5 * np.arange(300)), ratio=10.0e9 / E_r,
        core=10.0e9 / stiffness + 0.3,
    )  # fmt: skip
    np.testing.assert_allclose(found.pressure[at], exact, rtol=1e-6)


@pytest.mark.parametrize(("E_r", "stiffness"), CASES)
def test_continuous_growth_agrees_with_its_closed_form(E_r: float, stiffness: float) -> None:
    profile = {"kind": "taper", "taper": 0.4}
    found = roll(constant(E_r), {"stiffness": stiffness}, tension_profile=profile, growth="continuous")
    at = np.array([0, 1, 20, 200, 1100])
    exact = closed_form.pressure(
        found.radius[at], 0.010, 0.025, ratio=10.0e9 / E_r, core=10.0e9 / stiffness + 0.3, tension=tapering
    )
    np.testing.assert_allclose(found.pressure[at], exact, rtol=1e-6)


@pytest.mark.parametrize("core", [0.3, 50.0])
def test_the_refined_grids_are_of_second_order_at_the_core_and_inside(core: float) -> None:
    law, pull = RadialModulus.constant(1.0e8), 4.0e7
    wraps, grown = [], []
    for cells in (1, 2, 4):  # per wrap of 0.3 mm
        r = 0.010 + 0.015 * np.linspace(0.0, 1.0, 50 * cells + 1)
        found = lay(r, np.full(50, pull), 3.0e-4, cells, core, law)
        at = cells * np.array([0, 5, 25, 40])
        exact = closed_form.pressure_of_wraps(r[at], 0.010, 3.0e-4, np.full(50, pull), ratio=100.0, core=core)
        wraps.append(np.abs(found[at] / exact - 1.0))
        r = 0.010 * 2.5 ** np.linspace(0.0, 1.0, 250 * cells + 1)
        found = kernels.accrete(r, np.full(250 * cells + 1, pull), 10.0e9, core, *law.knots)
        at = cells * np.array([0, 25, 125, 225])
        exact = closed_form.pressure(r[at], 0.010, 0.025, ratio=100.0, core=core, tension=lambda _: pull)
        grown.append(np.abs(found[at] / exact - 1.0))
    for errors in (np.array(wraps), np.array(grown)):
        np.testing.assert_allclose(np.log2(errors[1] / errors[2]), 2.0, atol=0.1)


def lay(
    r: np.ndarray, tension: np.ndarray, h: float, cells: int, core: float, law: RadialModulus, blocks: Any = (1,),
    zones: Any = (10**6,),
) -> np.ndarray:  # fmt: skip
    return kernels.lay_wraps(r, tension, h, cells, 10.0e9, core, *law.knots, np.array(blocks), np.array(zones))


def test_nonlinear_roll_against_an_integrator_of_its_own() -> None:
    """Quadratic elements in r, the load of every wrap as a differential equation: shares nothing with the kernel."""
    wraps, h, inner, pull, core = 5, 2.0e-3, 0.010, 40.0e6, 10.0e9 / 7.6e9 + 0.3
    found = roll({"nu_theta": 0.3}, {"stiffness": 7.6e9}, wraps=wraps, wrap_thickness=h, cells=1600)
    per_wrap = 10
    r = inner + h / per_wrap * np.arange(per_wrap * wraps + 1)
    points, weights = np.polynomial.legendre.leggauss(6)
    Q = np.zeros(len(r))

    def increments(Q: np.ndarray, top: int) -> np.ndarray:
        """y per load: stationary value of the integral of r y'^2 + kappa y^2/r, core y(0)^2, with y(top) = 1."""
        matrix = np.zeros((top + 1, top + 1))
        matrix[0, 0] = core
        for e in range(0, top, 2):
            half = r[e + 1] - r[e]
            for xi, weight in zip(points, weights, strict=True):
                shape = np.array([0.5 * xi * (xi - 1), 1 - xi**2, 0.5 * xi * (xi + 1)])
                slope = np.array([xi - 0.5, -2 * xi, xi + 0.5]) / half
                place = r[e + 1] + xi * half
                kappa = 10.0e9 / (40.0 * (1.0e3 + max(0.0, float(shape @ Q[e : e + 3])) / place))
                matrix[e : e + 3, e : e + 3] += (
                    weight * half * (place * np.outer(slope, slope) + kappa / place * np.outer(shape, shape))
                )
        inside = np.linalg.solve(matrix[:top, :top], -matrix[:top, top]) if top else np.zeros(0)
        return np.append(inside, 1.0)

    for wrap in range(wraps):
        top = wrap * per_wrap
        rate = lambda _, q, top=top: increments(np.append(q, np.zeros(len(r) - top - 1)), top)  # noqa: E731
        Q[: top + 1] = solve_ivp(rate, (0.0, pull * h), Q[: top + 1], rtol=1e-7, atol=1e-3).y[:, -1]
        Q[top : top + per_wrap] = pull * h * (1.0 - np.arange(per_wrap) / per_wrap)
    faces = slice(0, None, per_wrap)
    np.testing.assert_allclose(found.pressure_at(r[faces]), Q[faces] / r[faces], rtol=5e-6, atol=1.0)


def lame_increment(r: float, a: float, tube: tuple[float, float, float, float], web: tuple[float, float]) -> float:
    """Radial pressure at r in a thick cylinder on a tube, per pressure on the outside at a (compound cylinder)."""
    (inner, outer, E_m, nu_m), (E, nu) = tube, web
    given = (outer**2 + inner**2) / (outer**2 - inner**2) - nu_m  # hoop strain of the tube x E_m per pressure
    # hoop strain of the outer cylinder at its bore x E: p the pressure in it, 1 that on the outside
    own = (a**2 + outer**2) / (a**2 - outer**2) + nu
    outside = 2.0 * a**2 / (a**2 - outer**2)
    p = (outside / E) / (given / E_m + own / E)
    return (p * outer**2 * (a**2 - r**2) + a**2 * (r**2 - outer**2)) / (r**2 * (a**2 - outer**2))


def test_an_isotropic_roll_is_the_superposition_of_thick_cylinders() -> None:
    """Each wrap presses the compound cylinder of mandrel and roll with T h/a (Lame)."""
    found = roll({"E_theta": 5.0e9, "nu_theta": 0.25, **constant(5.0e9)}, {"wall": 1.0e-3, "E": 70.0e9, "nu": 0.33})
    tube = (0.009, 0.010, 70.0e9, 0.33)
    for wrap in (0, 1, 40, 250):
        r = 0.010 + 5.0e-5 * wrap
        own = 40.0e6 * 5.0e-5 / r
        over = sum(
            40.0e6 * 5.0e-5 / a * lame_increment(r, a, tube, (5.0e9, 0.25))
            for a in 0.010 + 5.0e-5 * np.arange(max(wrap, 1) + (wrap > 0), 300)
        )
        assert found.pressure_at(r) == pytest.approx(own + over, rel=1e-8)


def test_hoop_stress_balances_the_pressure_on_the_mandrel() -> None:
    """Half a roll: the pull of all wraps over their thickness is the pressure times the radius."""
    for web in (constant(1.0e8), {}):
        found = roll(web)
        resultant = np.sum(0.5 * (found.hoop_stress[1:] + found.hoop_stress[:-1]) * np.diff(found.radius))
        assert resultant == pytest.approx(0.010 * found.pressure[0], rel=2e-3)
        assert found.wraps.hoop_stress.sum() * 5.0e-5 == pytest.approx(0.010 * found.wraps.pressure[0], rel=1e-12)
        assert found.hoop_stress[-1] == pytest.approx(40.0e6, rel=1e-12)


# ---- the thesis's scheme -------------------------------------------------------------------------


def thesis_scheme(winding: Winding) -> np.ndarray:
    """Equations 2.10 to 2.14 as printed: one dense system per wrap."""
    assert winding.mandrel is not None
    h, E, nu = winding.wrap_thickness, winding.web.E_theta, winding.web.nu_theta
    K_m = tube_stiffness(winding.mandrel.E, winding.mandrel.nu, winding.mandrel.outer_radius, winding.mandrel.wall)  # type: ignore[arg-type]
    r = winding.mandrel.outer_radius + h * np.arange(winding.wraps + 1)
    K1, K2 = 1.0e3, 40.0
    total = np.zeros(winding.wraps + 1)
    for last in range(winding.wraps):
        matrix, right = np.zeros((last + 1, last + 1)), np.zeros(last + 1)
        for n in range(1, last):
            E_r = K1 * K2 + K2 * total[n]
            matrix[n, n + 1] = 1.0 + 3.0 * h / (2.0 * r[n])
            matrix[n, n] = h**2 / r[n] ** 2 * (1.0 - E / E_r) - 2.0
            matrix[n, n - 1] = 1.0 - 3.0 * h / (2.0 * r[n])
        if last:
            matrix[0, 0], matrix[0, 1] = -r[0] / h - (E / K_m - 1.0 + nu), r[0] / h
        matrix[last], right[last] = 0.0, winding.stress * h / r[last]
        matrix[last, last] = 1.0
        total[: last + 1] += np.linalg.solve(matrix, right)
    return total


def test_the_source_s_grid_is_its_own_scheme() -> None:
    winding = section(wraps=60, wrap_thickness=2.5e-4)
    found = wound_roll(winding).wraps
    np.testing.assert_allclose(found.pressure, thesis_scheme(winding), rtol=1e-11, atol=1e-3)
    assert found.pressure[-1] == 0.0
    np.testing.assert_allclose(found.radius, 0.010 + 2.5e-4 * np.arange(61), rtol=1e-15)
    assert found.pressure[-2] == pytest.approx(40.0e6 * 2.5e-4 / found.radius[-2], rel=1e-12)  # C4, equation 2.11


def test_coefficients_are_central_differences_of_the_winding_equation() -> None:
    """Claim C6: A s(r + h) + B s(r) + C s(r - h) = (h/r)^2 times the equation in differences."""
    r, h, ratio = 0.013, 5.0e-5, 250.0
    A, B, C = kernels.coefficients(r, h, ratio)
    first, second = np.array([1, 0, -1]) / (2 * h), np.array([1, -2, 1]) / h**2
    equation = r**2 * second + 3 * r * first + (1 - ratio) * np.array([0, 1, 0])
    np.testing.assert_allclose([A, B, C], (h / r) ** 2 * equation, rtol=1e-12)


def test_the_core_row_keeps_mandrel_and_roll_together() -> None:
    """Claim C2: with s' = (E_theta/K_m - 1 + nu) s / r_m the roll's hoop strain at its bore is the mandrel's."""
    E, E_r, nu, K_m, r_m, s = 10.0e9, 3.0e7, 0.3, 7.6e9, 0.010, 1.0e5
    slope = (E / K_m - 1.0 + nu) * s / r_m
    radial, hoop = -s, -(s + r_m * slope)  # equation 2.1, stresses positive in tension
    nu_r = nu * E_r / E  # nu_r/E_r = nu_theta/E_theta
    roll_strain, mandrel_strain = hoop / E - nu_r * radial / E_r, -s / K_m
    assert roll_strain == pytest.approx(mandrel_strain, rel=1e-10)
    # the rows of both grids have this slope: the thesis's to first order, the refined to second, where s is linear
    h = 5.0e-5
    modulus = RadialModulus.constant(E_r)
    grid = kernels.wrap_by_wrap(
        r_m + h * np.arange(3), np.array([0.0, 1.0, 0.0]), h, E, E / K_m - 1 + nu, *modulus.knots
    )
    assert (grid[1] - grid[0]) / h * r_m / grid[0] == pytest.approx(E / K_m - 1.0 + nu, rel=1e-10)


def test_thin_wraps_tend_to_continuous_growth_on_both_grids() -> None:
    """Independent of each other: r against ln r, wraps against growth; of first order in h."""
    limit = roll(growth="continuous", cells=8000).pressure[0]
    thin = [roll(wraps=300 * k, wrap_thickness=5.0e-5 / k) for k in (1, 2, 4, 8)]
    source = np.array([one.wraps.pressure[0] for one in thin]) / limit - 1.0
    np.testing.assert_allclose(source[:-1] / source[1:], 2.0, atol=0.1)
    refined = np.array([one.pressure[0] for one in thin]) / limit - 1.0
    assert np.all(refined[:-1] / refined[1:] > 1.7)


def test_the_modulus_keeps_pace_with_the_pressure_to_second_order() -> None:
    """Pfeiffer's law, whose modulus all but vanishes at the surface: differences of halved steps fall by four."""
    core, law = 10.0e9 / 7.6e9 + 0.3, RadialModulus.pfeiffer(1.0e3, 40.0)
    grown, laid = [], []
    for cells in (500, 1000, 2000):
        r = 0.010 * 2.5 ** np.linspace(0.0, 1.0, cells + 1)
        grown.append(kernels.accrete(r, np.full(cells + 1, 4.0e7), 10.0e9, core, *law.knots)[0])
        per_wrap = cells // 50
        r = 0.010 + 0.015 * np.linspace(0.0, 1.0, cells + 1)
        laid.append(lay(r, np.full(50, 4.0e7), 3.0e-4, per_wrap, core, law)[0])
    for found in (grown, laid):
        assert (found[0] - found[1]) / (found[1] - found[2]) == pytest.approx(4.0, abs=0.8)


def test_only_total_thickness_and_stress_count_in_continuous_growth() -> None:
    thin, thick = (roll(growth="continuous", wraps=n, wrap_thickness=0.015 / n) for n in (300, 30))
    np.testing.assert_allclose(thick.pressure, thin.pressure, rtol=1e-9, atol=1e-6)


def test_halving_the_step_changes_the_case_study_by_less_than_a_thousandth() -> None:
    fine, coarse = roll(cells=4800), roll(cells=2400)
    assert coarse.pressure[0] == pytest.approx(fine.pressure[0], rel=1e-4)
    assert fine.error_estimate < 1e-3
    assert coarse.wraps.pressure[0] == fine.wraps.pressure[0]
    np.testing.assert_allclose(fine.pressure, coarse.pressure, rtol=1e-3)


def test_blocks_and_zones_change_nothing_that_counts() -> None:
    law, core = RadialModulus.pfeiffer(1.0e3, 40.0), 10.0e9 / 7.6e9 + 0.3
    r, pull = 0.010 + 5.0e-5 * np.arange(601), np.full(600, 40.0e6)
    whole = lay(r, pull, 5.0e-5, 1, core, law)
    for blocks, zones, error in (((4, 32), (128, 1024), 5e-5), ((4, 32), (64, 256), 4e-4)):
        found = lay(r, pull, 5.0e-5, 1, core, law, blocks, zones)
        np.testing.assert_allclose(found[:-1], whole[:-1], rtol=error)
    constant_law = RadialModulus.constant(1.0e8)
    found = lay(r, pull, 5.0e-5, 1, core, constant_law, (4, 32), (64, 256))
    np.testing.assert_allclose(found, lay(r, pull, 5.0e-5, 1, core, constant_law), rtol=1e-12, atol=1e-6)


# ---- inputs and limits ---------------------------------------------------------------------------


def test_mandrel_stiffness_is_that_of_lame_s_hollow_cylinder() -> None:
    """Claim C3, from the radial displacement under external pressure, plane stress; and its limits."""
    E, nu, outer, wall = 70.0e9, 0.33, 0.010, 1.0e-3
    inner, p = outer - wall, 1.0
    b = p * inner**2 * outer**2 / (outer**2 - inner**2)
    radial, hoop = (-p * outer**2 / (outer**2 - inner**2) + sign * b / outer**2 for sign in (1.0, -1.0))
    assert radial == pytest.approx(-p, rel=1e-12)
    assert tube_stiffness(E, nu, outer, wall) == pytest.approx(-p / ((hoop - nu * radial) / E), rel=1e-10)
    assert tube_stiffness(E, nu, outer, outer) == pytest.approx(E / (1 - nu), rel=1e-12)
    assert tube_stiffness(E, nu, outer, 1e-8) == pytest.approx(E * 1e-8 / outer, rel=1e-5)


def test_radial_modulus_laws() -> None:
    """Claim C5: E_r = 40 (1 kPa + P); K1 in Pa and K2 without a unit give a modulus."""
    law = RadialModulus.pfeiffer(1.0e3, 40.0)
    pressures = np.array([0.0, 1.0, 4.0e3, 1.0e6])
    np.testing.assert_allclose(law(pressures), 40.0 * (1.0e3 + pressures), rtol=1e-12)
    table = RadialModulus.table([1.0e3, 3.0e3, 4.0e3], [1.0e6, 5.0e6, 6.0e6])
    np.testing.assert_allclose(table(np.array([0.0, 2.0e3, 3.0e3, 3.5e3, 9.0e3])), [1e6, 3e6, 5e6, 5.5e6, 6e6])
    assert RadialModulus.constant(7.0)(1.0e9) == 7.0


def test_a_fine_table_of_the_pfeiffer_law_gives_the_same_roll() -> None:
    pressure = np.concatenate([[0.0], np.geomspace(10.0, 2.0e7, 40)])
    table = {"law": "table", "pressure": pressure.tolist(), "modulus": (40 * (1.0e3 + pressure)).tolist()}
    np.testing.assert_allclose(roll({"radial_modulus": table}).pressure, roll().pressure, rtol=1e-12, atol=1e-6)


def test_a_stiff_roll_on_a_stiff_mandrel_reaches_the_hoop_bound() -> None:
    """Isotropic web on a solid core of the same material: every pressure goes through to the axis."""
    solid = roll({"E_theta": 5.0e9, "nu_theta": 0.3, **constant(5.0e9)}, {"wall": 0.010, "E": 5.0e9, "nu": 0.3})
    under = 0.010 + 5.0e-5 * np.arange(300)
    presses = 40.0e6 * 5.0e-5 / under
    assert solid.hoop_bound == pytest.approx(presses.sum(), rel=1e-12)
    np.testing.assert_allclose(solid.pressure_at(under), np.cumsum(presses[::-1])[::-1], rtol=1e-9)
    grown = roll({"E_theta": 5.0e9, **constant(5.0e9)}, {"wall": 0.010, "E": 5.0e9, "nu": 0.3}, growth="continuous")
    np.testing.assert_allclose(grown.pressure, 40.0e6 * np.log(0.025 / grown.radius), rtol=1e-8, atol=1e-6)
    assert roll().pressure[0] < roll().hoop_bound


def test_a_soft_mandrel_holds_no_pressure() -> None:
    pressures = [roll(mandrel={"stiffness": K}).pressure[0] for K in (1.0e10, 1.0e8, 1.0e6)]
    assert pressures[2] < 0.2 * pressures[1] < 0.1 * pressures[0]
    first = 40.0e6 * 5.0e-5 / 0.010  # the first wrap's own pull is always there
    assert roll(mandrel={"stiffness": 1.0e3}).pressure[0] == pytest.approx(first, rel=1e-3)


def test_pressure_falls_from_the_mandrel_to_the_outer_surface() -> None:
    """Claim C8, case study; at most T h/r under the last wrap."""
    found = roll()
    assert np.all(np.diff(found.pressure) < 0)
    assert found.pressure[-1] == 0.0
    assert np.all(np.diff(found.wraps.pressure) < 0)
    last = found.wraps.radius[-2]
    assert found.pressure_at(last) <= 40.0e6 * 5.0e-5 / last * (1 + 1e-12)


def test_a_soft_roll_is_flatter_than_a_hard_one() -> None:
    """Claim C9: E_theta/E_r = 100 against 1."""
    soft, hard = roll(constant(1.0e8)), roll(constant(1.0e10))
    ends = np.array([0.010 + 0.25 * 0.015, 0.010 + 0.75 * 0.015])
    assert -np.diff(soft.pressure_at(ends)) < -np.diff(hard.pressure_at(ends))
    assert soft.pressure[0] < hard.pressure[0]


def test_tension_in_newtons_and_profiles() -> None:
    as_force = roll(tension_stress=None, tension_newton=600.0, web_width=0.300)
    np.testing.assert_allclose(as_force.pressure, roll().pressure, rtol=1e-12)
    radius = [0.010, 0.025]
    by_table = roll(tension_profile={"kind": "table", "radius": radius, "factor": [1.0, 0.5]})
    np.testing.assert_allclose(
        by_table.pressure, roll(tension_profile={"kind": "taper", "taper": 0.5}).pressure, rtol=1e-12
    )
    assert by_table.tension[-1] == pytest.approx(20.0e6)
    assert by_table.pressure[0] < roll().pressure[0]


def test_capacity_over_the_radius() -> None:
    found = roll()
    np.testing.assert_allclose(found.capacity, 0.48 * found.pressure, rtol=1e-12)
    at = np.array([0.0099999, 0.010, float(found.radius[170]), 0.025, 0.03])
    capacity = found.capacity_at(at)
    np.testing.assert_allclose(
        capacity, [found.capacity[0], found.capacity[0], found.capacity[170], 0.0, 0.0], rtol=1e-9, atol=1e-6
    )
    with pytest.raises(InputError, match=r"winding\.mu: required key is missing"):
        roll(mu=None).capacity_at(at)


def test_one_wrap_presses_with_its_tension() -> None:
    found = roll(wraps=1)
    assert found.wraps.pressure[0] == pytest.approx(40.0e6 * 5.0e-5 / 0.010, rel=1e-12)
    assert found.pressure[0] == pytest.approx(40.0e6 * 5.0e-5 / 0.010, rel=1e-12)
