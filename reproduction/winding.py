"""Claims on winding and on the cantilever: C1 to C11, C13, C61."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup, study_figure
from reproduction.evidence import Evidence
from reproduction.verdict import THESIS_ERROR, Verdict
from reproduction.words import exactly
from wroll_fem.bodies.beam import Cantilever
from wroll_fem.case import WindingCase
from wroll_fem.case.winding import ConstantModulus, Winding
from wroll_fem.plotting.cantilever import plot_cantilever
from wroll_fem.plotting.winding import plot_winding
from wroll_fem.results.pressure_profile import middle_slope
from wroll_fem.winding import RadialModulus, WoundRoll, closed_form, kernels, tube_stiffness, wound_roll


def case_study(evidence: Evidence) -> Winding:
    """Winding of the case study of the thesis."""
    return evidence.case("winding_case_study").expect(WindingCase).winding


def lab(evidence: Evidence, tension: float) -> Winding:
    """Winding of the experiment at a tension in N."""
    return evidence.case("winding_lab", f"winding.tension_newton={tension}").expect(WindingCase).winding


def with_modulus(winding: Winding, E_r: float) -> Winding:
    web = winding.web.model_copy(update={"radial_modulus": ConstantModulus(law="constant", E_r=E_r)})
    return winding.model_copy(update={"web": web})


def core_of(winding: Winding) -> float:
    """Coefficient E_theta/K_m + nu_theta of the core condition."""
    return winding.web.E_theta / wound_roll(winding).mandrel_stiffness + winding.web.nu_theta


def at_the_mandrel(winding: Winding, modulus: RadialModulus, core: float) -> float:
    """Pressure on the refined grid, Pa, for a law or a core condition that a case file does not allow."""
    r = winding.core.outer_radius + winding.wrap_thickness / 4 * np.arange(4 * winding.wraps + 1)
    whole, pull = np.array([winding.wraps]), np.full(winding.wraps, winding.stress)
    laid = kernels.lay_wraps(
        r, pull, winding.wrap_thickness, 4, winding.web.E_theta, core, *modulus.knots, whole, whole
    )
    return float(laid[0])


def c1(evidence: Evidence) -> Verdict:
    winding, ratio, q = case_study(evidence), 100.0, 10.0
    core, ends = core_of(winding), (0.010, 0.025)
    r = np.linspace(*ends, 50)
    exact = closed_form.increment(r, *ends, ratio=ratio, core=core)
    powers = np.array([r ** (q - 1.0), r ** (-q - 1.0)])
    a, b = np.linalg.lstsq((powers / powers.max(axis=1)[:, None]).T, exact, rcond=None)[0] / powers.max(axis=1)
    exponents = np.array([q - 1.0, -q - 1.0])
    terms = np.array([a, b])[:, None] * powers * (exponents * (exponents - 1) + 3 * exponents + 1 - ratio)[:, None]
    residual = float(np.abs(terms.sum(axis=0)).max() + np.abs(a * powers[0] + b * powers[1] - exact).max())
    law, wraps, h = RadialModulus.constant(1.0e8).knots, 60, 2.5e-4
    whole, pull = np.array([wraps]), np.full(wraps, winding.stress)
    errors = []
    for cells in (1, 2, 4, 8):
        r = 0.010 + h / cells * np.arange(cells * wraps + 1)
        found = kernels.lay_wraps(r, pull, h, cells, winding.web.E_theta, core, *law, whole, whole)
        at = cells * np.array([0, 6, 30, 54])
        errors.append(
            np.abs(found[at] / closed_form.pressure_of_wraps(r[at], 0.010, h, pull, ratio=ratio, core=core) - 1)
        )
    orders = np.log2(errors[-2] / errors[-1])
    roll = wound_roll(with_modulus(winding, 1.0e8))
    p = closed_form.pressure_of_wraps(
        roll.radius[:1], 0.010, 5.0e-5, np.full(300, winding.stress), ratio=ratio, core=core
    )
    value = (
        f"residual {residual:.0e}; order {orders[0]:.3f} at the core, {orders[1:].min():.3f} to {orders[1:].max():.3f} "
        f"inside; case study with E_r = 0.1 GPa {abs(roll.pressure[0] / p[0] - 1.0):.0e} off"
    )
    return Verdict(value, bool(residual < 1e-8 and np.all(np.abs(orders - 2.0) < 0.05)))


def c2(evidence: Evidence) -> Verdict:
    winding = case_study(evidence)
    E, nu, K_m = winding.web.E_theta, winding.web.nu_theta, wound_roll(winding).mandrel_stiffness
    s, E_r = 1.0e5, 2.0e8
    slope = (core_of(winding) - 1.0) * s  # r_m s'
    strain = -(s + slope) / E + nu * E_r / E * s / E_r
    off = abs(strain / (-s / K_m) - 1.0)
    parts = []
    for name, roll in (("case study", winding), ("lab at 60 N", lab(evidence, 60.0))):
        right, law = wound_roll(roll), RadialModulus.from_case(roll.web.radial_modulus)
        core = float(law(right.pressure[0])) / right.mandrel_stiffness + roll.web.nu_theta
        printed = at_the_mandrel(roll, law, core)
        parts.append(f"{1e-6 * right.pressure[0]:.3f} MPa ({name}; {1e-6 * printed:.3f} with E_r/K_m)")
    value = (
        f"E_theta/K_m used; strains of roll and mandrel agree to {exactly(off)}; pressure at the mandrel "
        + " and ".join(parts)
    )
    return Verdict(value, off < 1e-10, THESIS_ERROR if off < 1e-10 else "")


def c3(evidence: Evidence) -> Verdict:
    E, nu, outer = 70.0e9, 0.33, 0.010
    inner = outer - 1.0e-3
    hoop, radial = -(outer**2 + inner**2) / (outer**2 - inner**2), -1.0  # Lame, unit external pressure
    off = abs(tube_stiffness(E, nu, outer, 1.0e-3) / (-1.0 / ((hoop - nu * radial) / E)) - 1.0)
    polycarbonate = [tube_stiffness(2.7e9, 0.35, 0.040, wall) for wall in (1.6e-3, 1.5e-3)]
    value = (
        f"Lame to {exactly(off)}; case study {1e-9 * tube_stiffness(E, nu, outer, 1.0e-3):.3f} GPa; lab "
        f"{1e-6 * polycarbonate[0]:.1f} MPa (wall 1.6 mm, Table 2.6) or {1e-6 * polycarbonate[1]:.1f} MPa (1.5 mm, "
        "Table 4.1)"
    )
    return Verdict(value, off < 1e-10)


def c4(evidence: Evidence) -> Verdict:
    winding = case_study(evidence)
    one = wound_roll(winding.model_copy(update={"wraps": 1})).wraps
    whole = wound_roll(winding).wraps
    wanted = winding.stress * winding.wrap_thickness / np.array([one.radius[0], whole.radius[-2]])
    off = float(np.abs(np.array([one.pressure[0], whole.pressure[-2]]) / wanted - 1.0).max())
    return Verdict(f"first and last wrap press with T_w h/r to {exactly(off)}", off < 1e-12)


def c5(evidence: Evidence) -> Verdict:
    winding = case_study(evidence)
    law = RadialModulus.from_case(winding.web.radial_modulus)
    P = np.array([0.0, 1.0e3, 1.0e6])
    off = float(np.abs(law(P) / (40.0 * (1.0e3 + P)) - 1.0).max())
    literal = at_the_mandrel(winding, RadialModulus.pfeiffer(1.0e3, 40.0e9), core_of(winding))
    value = (
        f"E_r = 40 (1 kPa + P) to {exactly(off)}, {1e-6 * float(law(wound_roll(winding).pressure[0])):.0f} MPa at the "
        "mandrel; "
        f"K2 = 40 GPa as printed would make the stack rigid and the pressure {1e-6 * literal:.1f} MPa: refused"
    )
    return Verdict(value, off < 1e-12, THESIS_ERROR if off < 1e-12 else "")


def c6(evidence: Evidence) -> Verdict:
    worst = 0.0
    for r, h, ratio in ((0.010, 5e-5, 250.0), (0.02, 2e-4, 1.0), (0.041, 5e-5, 900.0)):
        first, second = np.array([1, 0, -1]) / (2 * h), np.array([1, -2, 1]) / h**2
        wanted = (h / r) ** 2 * (r**2 * second + 3 * r * first + (1 - ratio) * np.array([0, 1, 0]))
        worst = max(worst, float(np.abs(np.array(kernels.coefficients(r, h, ratio)) / wanted - 1.0).max()))
    value = f"A, B, C equal the central differences to {worst:.0e}; the scheme is a tridiagonal solution in both grids"
    return Verdict(value, worst < 1e-12)


def c7(evidence: Evidence) -> Verdict:
    winding = case_study(evidence)
    roll, coarse = wound_roll(winding), wound_roll(winding.model_copy(update={"cells": winding.cells // 2}))
    change = abs(coarse.pressure[0] / roll.pressure[0] - 1.0)
    thesis = roll.wraps.pressure[0]
    thin = wound_roll(winding.model_copy(update={"growth": "continuous"})).pressure[0]
    value = (
        f"grid of the thesis: P = {1e-6 * thesis:.3f} MPa, mu P = {1e-6 * 0.48 * thesis:.3f} MPa; refined: P = "
        f"{1e-6 * roll.pressure[0]:.3f} MPa, mu P = {1e-6 * roll.capacity[0]:.3f} MPa, {100 * change:.3f} % on halving "
        f"the step; infinitely thin wraps: {1e-6 * thin:.3f} MPa; nu_theta 0.3, nu_m 0.33 ({inputs(winding)})"
    )
    return Verdict(value, change < 0.01)


def inputs(winding: Winding) -> str:
    """Table of the pressure at the mandrel with other values of the inputs that the thesis does not state."""
    said = []
    for key, values in (("nu_theta", (0.0, 0.4)), ("nu", (0.3, 0.35))):
        section = winding.web if key == "nu_theta" else winding.core
        name = "web" if key == "nu_theta" else "mandrel"
        found = [
            wound_roll(winding.model_copy(update={name: section.model_copy(update={key: v})})).pressure[0]
            for v in values
        ]
        text = "nu_theta" if key == "nu_theta" else "nu_m"
        said.append(f"{text} = {values[0]:g}, {values[1]:g}: {1e-6 * found[0]:.2f}, {1e-6 * found[1]:.2f} MPa")
    return "; ".join(said)


def c8(evidence: Evidence) -> Verdict:
    roll = wound_roll(case_study(evidence))
    last = roll.wraps.radius[-2]
    limit, under = 40.0e6 * 5.0e-5 / last, float(roll.pressure_at(last))
    falls = bool(np.all(np.diff(roll.pressure) < 0) and np.all(np.diff(roll.wraps.pressure) < 0))
    ends = roll.pressure[-1] == 0 and roll.wraps.pressure[-1] == 0
    value = (
        f"falls from wrap to wrap on both grids, 0 outside; under the last wrap {1e-3 * under:.1f} kPa (refined), "
        f"{1e-3 * roll.wraps.pressure[-2]:.1f} kPa (grid of the thesis), T_w h/r = {1e-3 * limit:.1f} kPa"
    )
    return Verdict(value, falls and bool(ends) and under <= limit and roll.wraps.pressure[-2] <= limit * (1 + 1e-12))


def c9(evidence: Evidence) -> Verdict:
    members = evidence.study("winding_hardness")
    hard, soft = sorted(members, key=lambda m: -float(m.data["radial_modulus_pa"].mean()))
    slopes = [middle_slope(m.data) for m in (soft, hard)]
    core = [m.data.attrs["pressure_mandrel_pa"] for m in (soft, hard)]
    value = (
        f"E_theta/E_r = 100 against 1: slope over the middle half {1e-9 * slopes[0]:.3f} against "
        f"{1e-9 * slopes[1]:.3f} MPa/mm, pressure at the mandrel {1e-6 * core[0]:.2f} against {1e-6 * core[1]:.2f} MPa"
    )
    return Verdict(value, slopes[0] < slopes[1] and core[0] < core[1])


def c10(evidence: Evidence) -> Verdict:
    winding = case_study(evidence)
    diameter = 2 * (winding.core.outer_radius + winding.build_up)
    return Verdict(f"{1e3 * diameter:.10g} mm", abs(diameter / 0.050 - 1.0) < 1e-12)


def c11(evidence: Evidence) -> Verdict:
    winding, roll = case_study(evidence), wound_roll(case_study(evidence))
    off = float(np.abs(roll.capacity[:-1] / roll.pressure[:-1] / 0.48 - 1.0).max())
    value = f"T_w = {1e-6 * winding.stress:g} MPa, mu = {winding.mu:g}; sigma_c/sigma_r = mu to {exactly(off)}"
    return Verdict(value, winding.stress == 40.0e6 and winding.mu == 0.48 and off < 1e-12)


def mandrel_beam(evidence: Evidence) -> Cantilever:
    """Lab mandrel under inertia loads of 5 g: distributed load of tube and coil, tip load of the tip mass."""
    case = evidence.roll("lab_sweep")
    g, coil, metal = case.geometry, case.coil, case.mandrel.material
    radius, wall, t = 0.5 * g.mandrel_outer_diameter, g.mandrel_thickness, coil.total_thickness
    tube = np.pi * (radius**2 - (radius - wall) ** 2) * metal.rho
    web = np.pi * ((radius + t) ** 2 - radius**2) * coil.material.rho
    level = 5.0 * 9.80665
    return Cantilever(g.length, radius, wall, distributed=level * (tube + web), tip=level * case.mandrel.tip_mass)


def c13(evidence: Evidence) -> Verdict:
    beam = mandrel_beam(evidence)
    z, theta = np.linspace(0.0, beam.length, 301), np.linspace(-np.pi, np.pi, 721)
    bending, shear = np.abs(beam.bending_stress(theta, 0.0)), np.abs(beam.shear_stress(theta, 0.0))
    at = [abs(np.degrees(theta[values.argmax()])) for values in (bending, shear)]
    at[0] = min(at[0], 180.0 - at[0])
    factor = shear.max() * beam.area / float(beam.shear_force(0.0))
    roots = beam.moment(z).argmax() == 0 and beam.shear_force(z).argmax() == 0
    value = (
        f"moment and shear largest at the root; |sigma| largest at {at[0]:.0f} deg (faces along the load), tau at "
        f"{at[1]:.0f} deg (neutral axis), tau_max = {factor:.3f} V/A in the lab tube"
    )
    holds = bool(roots) and at[0] < 1.0 and abs(at[1] - 90.0) < 1.0 and abs(factor / 2.0 - 1.0) < 0.05
    return Verdict(value, holds, THESIS_ERROR if holds else "")


def c61(evidence: Evidence) -> Verdict:
    parts, holds = [], True
    for tension in (20.0, 60.0):
        winding = lab(evidence, tension)
        roll: WoundRoll = wound_roll(winding)
        sums = winding.stress * winding.wrap_thickness * float(np.sum(1.0 / roll.wraps.radius[:-1]))
        found = [roll.pressure[0], roll.wraps.pressure[0]]
        holds &= 10e3 <= found[0] <= roll.hoop_bound <= 300e3 and found[1] <= sums
        parts.append(
            f"{tension:g} N: P = {1e-3 * found[0]:.1f} kPa (grid of the thesis {1e-3 * found[1]:.1f}), hoop bound "
            f"{1e-3 * roll.hoop_bound:.1f} kPa"
        )
    return Verdict("; ".join(parts) + "; 10 kPa lies below, 300 kPa far above even the bound", bool(holds))


def case_study_figure(evidence: Evidence) -> Axes:
    """Draw Fig 2.12."""
    return plot_winding(evidence.result("winding_case_study"))


def beam_figure(evidence: Evidence) -> Axes:
    """Draw Figs 2.8 and 2.9."""
    return plot_cantilever(mandrel_beam(evidence))


GROUP = ClaimGroup(
    {
        "C1": c1, "C2": c2, "C3": c3, "C4": c4, "C5": c5, "C6": c6, "C7": c7, "C8": c8, "C9": c9, "C10": c10,
        "C11": c11, "C13": c13,
    },
    figures={
        "winding_hardness": ("Fig 2.4: pressure in a soft and a hard roll", study_figure("winding_hardness")),
        "cantilever": ("Figs 2.8 and 2.9: moment, shear and stress of the mandrel", beam_figure),
        "winding_case_study": ("Fig 2.12: pressure and friction capacity of the case study", case_study_figure),
    },
    studies=("winding_hardness",),
)  # fmt: skip
