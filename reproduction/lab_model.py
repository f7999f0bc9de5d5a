"""Claims on the model of the lab roll: C57 to C63, C76."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from reproduction import base_spring
from reproduction.claim_group import ClaimGroup, study_figure
from reproduction.evidence import Evidence
from reproduction.lab_studies import PRELOAD_STUDY, bound, sweeps
from reproduction.verdict import THESIS_ERROR, Verdict
from reproduction.winding import c61
from reproduction.words import kpa
from wroll_fem.case import SweepCase
from wroll_fem.case.contact import PenaltyFriction
from wroll_fem.contact.laws import slip_update, stack_laws
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.plotting import style
from wroll_fem.plotting.convergence import first_bending
from wroll_fem.plotting.study import PRESSURE, natural_frequency, read
from wroll_fem.signals.motions import base_motion

LAB = "lab_sweep"
BASE_STUDY = "base_motion"
"""Backbones with the base of the layer free and clamped, which compare them at equal motion."""
SLIP_AND_WORK = ("slipping_fraction", "friction_work_per_cycle")


def c57(evidence: Evidence) -> Verdict:
    sums = [n * evidence.roll(LAB, f"coil.layers={n}").coil.layer_thickness for n in range(1, 6)]
    value = f"n t_l = {1e3 * sums[0]:.4g} mm for n = 1 to 5"
    return Verdict(value, bool(np.allclose(sums, 25 * 0.05e-3, rtol=1e-12)))


def c58(evidence: Evidence) -> Verdict:
    lab = evidence.roll(LAB)
    alone = float(evidence.reference("bounds").data.attrs["mass_total_kg"])
    with_layer = evidence.one("bounds", modal__interface="bonded", coil__base="free")
    tube = alone - lab.mandrel.tip_mass
    coil = float(with_layer.data.attrs["mass_total_kg"]) - alone
    value = f"coil {coil:.4f} kg at {lab.coil.material.rho:g} kg/m^3, tube {tube:.4f} kg (tip mass 0.05 kg apart)"
    return Verdict(value, True, THESIS_ERROR)


def c59(evidence: Evidence) -> Verdict:
    f_m = natural_frequency(evidence.reference("bounds"))
    free, clamped = (bound(evidence, "bonded", base) for base in ("free", "clamped"))
    top = sweeps(evidence, "free")[-1]
    f_n = read(top).f_n
    pressed = {"preload__pressure": top.values[PRESSURE], "preload__geometric_stiffness": True}
    f_b_pressed = first_bending(evidence.one("prestress", modal__interface="bonded", **pressed))
    f_n_pressed = read(evidence.one("prestress_sweep", **pressed)).f_n
    value = (
        f"f_b = {free:.2f} Hz (free), {clamped:.2f} Hz (clamped); f_b/f_m = {free / f_m:.3f} and {clamped / f_m:.3f}; "
        f"f_n({kpa(top)}) = {f_n:.2f} Hz, {100 * (f_n / free - 1):+.1f} % of f_b; with the geometric stiffness of the "
        f"preload {f_n_pressed:.2f} Hz, {100 * (f_n_pressed / f_b_pressed - 1):+.1f} % of {f_b_pressed:.2f} Hz"
    )
    return Verdict(value, 1.02 <= free / f_m <= 1.13 and abs(f_n_pressed / f_b_pressed - 1) <= 0.02)


def at_tip(data: xr.Dataset, tip: float, name: str) -> float:
    """Value of a backbone at a tip amplitude (m)."""
    return float(np.interp(np.log(tip), np.log(data["tip_amplitude"].values), data[name].values))


def c60(evidence: Evidence) -> Verdict:
    """Slip and friction work of both bases at the tip amplitude at which the free base damps most."""
    shares, said = [], []
    for pressure in sorted({float(m.values[PRESSURE]) for m in evidence.study(BASE_STUDY)}):
        free, clamped = (
            evidence.one(BASE_STUDY, coil__base=base, preload__pressure=pressure).data for base in ("free", "clamped")
        )
        reach = (data["tip_amplitude"].values for data in (free, clamped))
        low, high = zip(*((tip[0], tip[-1]) for tip in reach), strict=True)
        tip = float(np.clip(free.attrs["tip_amplitude_at_zeta_max_m"], max(low), min(high)))
        pairs = [[at_tip(data, tip, name) for data in (free, clamped)] for name in SLIP_AND_WORK]
        shares += [held / loose for loose, held in pairs]
        said.append(
            f"{1e-3 * pressure:g} kPa, tip {1e3 * tip:.2f} mm: slipping area {100 * pairs[0][0]:.0f} and "
            f"{100 * pairs[0][1]:.1f} %, friction {1e3 * pairs[1][0]:.3g} and {1e3 * pairs[1][1]:.2g} mJ per cycle"
        )
    spans = []
    for base in ("free", "clamped"):
        f = [read(m).f_n for m in sweeps(evidence, base)]
        low_f, high_f = bound(evidence, "frictionless", base), bound(evidence, "bonded", base)
        spans.append(f"{base} {low_f:.2f} to {high_f:.2f} Hz, sweeps {min(f):.1f} to {max(f):.1f} Hz")
    holds = min(shares) >= 0.5
    value = f"base free and clamped, {'; '.join(said)}; frictionless to bonded: {', '.join(spans)}; "
    value += base_spring.spans_text(evidence)
    return Verdict(value, holds, "" if holds else THESIS_ERROR)


def c62(evidence: Evidence) -> Verdict:
    chirp = evidence.case(LAB).expect(SweepCase).excitation
    duration = base_motion(chirp).duration
    value = (
        f"{chirp.f_start:g} to {chirp.f_end:g} Hz at {chirp.rate_oct_per_min:g} oct/min, "
        f"{chirp.amplitude:g} m/s^2: {duration:.2f} s"
    )
    return Verdict(value, math.isclose(duration, math.log2(1.4) / 2 * 60, rel_tol=1e-9) and chirp.amplitude == 5.0)


def c63(evidence: Evidence) -> Verdict:
    parts, offs = [], []
    for study, base in (("mesh_linear_clamped", "base clamped as in the thesis"), ("mesh_linear", "base free")):
        finest = max(evidence.study(study), key=lambda m: m.values["mesh.circumferential"] * m.values["mesh.axial"])
        coarse = evidence.one(study, mesh__circumferential=30, mesh__axial=10)
        offs.append(first_bending(coarse) / first_bending(finest) - 1)
        parts.append(f"{base}: {100 * offs[-1]:+.2f} % off {first_bending(finest):.2f} Hz of the finest mesh")
    most = max(m.values["mesh.axial"] for m in evidence.study("mesh_friction"))
    best = read(evidence.one("mesh_friction", mesh__grading=6, mesh__axial=most))
    uniform = read(evidence.one("mesh_friction", mesh__grading=1, mesh__axial=10))
    change = [100 * (getattr(uniform, key) / getattr(best, key) - 1) for key in ("f_n", "peak", "zeta")]
    value = (
        f"linear, bonded, 30 x 10: {'; '.join(parts)}; friction at 100 kPa, which the thesis did not check: uniform "
        f"30 x 10 is {change[0]:+.2f} % off in f_n, {change[1]:+.1f} % in the peak, {change[2]:+.1f} % in zeta"
    )
    return Verdict(value, abs(offs[0]) <= 0.01)


def c76(evidence: Evidence) -> Verdict:
    lab = evidence.roll(LAB)
    friction = lab.friction
    assert isinstance(friction, PenaltyFriction)
    opens = lab.contact is not None and lab.contact.normal.separation
    same = friction.mu == 0.25 and friction.elastic_slip == 1e-6 and opens
    errors = [
        evidence.summary(study, m)["energy_balance_error"]
        for base, study in PRELOAD_STUDY.items()
        for m in sweeps(evidence, base)
    ]
    numerical = [
        abs(float(m.data["numerical_dissipation"].values[-1]) / float(m.data["input_work"].values[-1]))
        for m in sweeps(evidence, "free")
    ]
    value = (
        f"law {friction.law}, mu {friction.mu:g}, gamma* {friction.elastic_slip:g} m, separation on; balance off by at "
        f"most {100 * max(errors):.1e} % at any time of {len(errors)} sweeps; numerical part of the input at most "
        f"{100 * max(numerical):.2f} % (free base)"
    )
    return Verdict(value, same and max(errors) < 0.01)


def friction_law_figure(evidence: Evidence) -> Axes:
    """Penalty law of the lab case on a closed path of relative displacement, with Coulomb's law (Fig. 4.2)."""
    friction = evidence.roll(LAB).friction
    assert isinstance(friction, PenaltyFriction)
    law = PenaltyCoulomb(mu=friction.mu, elastic_slip=friction.elastic_slip)
    laws = stack_laws([np.array([1.0])], [law], [1e12], [True])
    reach = 4.0 * law.elastic_slip
    path = np.interp(np.linspace(0.0, 3.0, 1201), [0.0, 1.0, 2.0, 3.0], [0.0, reach, -reach, reach])
    elastic, traction = 0.0, []
    for before, now in pairwise(path):
        elastic, _, _ = slip_update(0, elastic + now - before, 0.0, now - before, 0.0, 1.0, laws, np.inf)
        traction.append(elastic / law.elastic_slip)
    ax = style.axes(None, 4.0)
    ax.plot([-4, 0, 0, 4], [-1, -1, 1, 1], color=style.GREY, lw=1.4, ls="--", label="Coulomb")
    ax.plot(1e6 * path[1:], traction, color=style.BLUE, lw=1.8, label="penalty law, there and back")
    ax.axvspan(0.0, 1e6 * law.elastic_slip, color="#E4EEF5", label=f"elastic slip γ* = {1e6 * law.elastic_slip:g} µm")
    ax.set_xlabel("Relative tangential displacement (µm)")
    ax.set_ylabel("Shear stress over µp (–)")
    ax.legend(fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    first = int(np.argmax(np.array(traction) >= 1.0 - 1e-9))
    back = int(np.argmax((np.array(traction) <= -1.0 + 1e-9) & (np.arange(1200) > 400)))
    slips = (path[first + 1] / law.elastic_slip, (reach - path[back + 1]) / law.elastic_slip)
    said = f"is reached after {slips[0]:.1f} γ*, from a turn after {slips[1]:.1f} γ*"
    ax.set_title(f"From rest the limit µp (µ = {law.mu:g}) {said}", loc="left", pad=22, fontsize=10)
    return ax


GROUP = ClaimGroup(
    {"C57": c57, "C58": c58, "C59": c59, "C60": c60, "C61": c61, "C62": c62, "C63": c63, "C76": c76},
    figures={
        "ch4_friction_law": ("Fig 4.2: penalty law and Coulomb's", friction_law_figure),
        "winding_tension": ("Fig 4.3: pressure at the mandrel over winding tension", study_figure("winding_tension")),
        "ch4_mesh_linear_clamped_mesh_frequency": (
            "Linear frequency over the mesh, base clamped as in the thesis (C63)",
            study_figure("mesh_linear_clamped", "mesh_frequency"),
        ),
        "ch4_mesh_linear_mesh_frequency": (
            "Linear frequency over the mesh, base free (C63)",
            study_figure("mesh_linear", "mesh_frequency"),
        ),
        "ch4_mesh_friction": ("Friction response at 100 kPa over the mesh (C63)", study_figure("mesh_friction")),
    },
    tables={"Guided base: ring held across, axial spring; f_n at 10, 30, 100, 300 kPa": base_spring.spring_table},
    studies=(
        "bounds",
        "prestress",
        "prestress_sweep",
        "winding_tension",
        "base_motion",
        "base_spring",
        "dwell_layers_spring",
        "layer_modulus_thesis",
        "mesh_linear",
        "mesh_linear_clamped",
        "mesh_friction",
    ),
)
