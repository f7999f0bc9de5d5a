"""Claims on the two-mass model: C77 to C90."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

import numpy as np

from reproduction import base_spring
from reproduction import two_dof_figures as figures
from reproduction import two_dof_study as study
from reproduction.claim_group import ClaimGroup, study_figure
from reproduction.evidence import Evidence
from reproduction.explicit import ZETA
from reproduction.verdict import THESIS_ERROR, Verdict
from reproduction.words import numbers, table
from wroll_fem.case import TwoDofCase
from wroll_fem.plotting.two_dof import (
    plot_two_dof_arrangements,
    plot_two_dof_design_space,
    plot_two_dof_readings,
)
from wroll_fem.two_dof import PeriodicSolver, TwoMasses, regularised_sign


def short(values: Iterable[float], form: str = ".3g") -> str:
    """Numbers with three digits, as text."""
    return numbers((float(v) for v in values), form)


def c77(evidence: Evidence) -> Verdict:
    x = np.linspace(-30.0, 30.0, 601)
    gap = float(np.abs(regularised_sign(x) - np.tanh(0.5 * x)).max())
    one, five = regularised_sign([1.0, 5.0])
    holds = gap < 1e-14 and abs(one - 0.4621) < 5e-5 and abs(five - 0.98661) < 5e-6
    return Verdict(f"S(x) = tanh(x/2) to {gap:.0e}; S(1) = {one:.4f}, S(5) = {five:.5f}", bool(holds))


def c78(evidence: Evidence) -> Verdict:
    data = study.settled(evidence)
    gap, periods = np.abs(data["in_time"].values / data["periodic"].values - 1.0), data["periods"].values
    said = (
        f"time integration and harmonic balance agree to {gap.max():.1e} at {gap.size} points; settling took "
        f"{periods.min():.0f} to {periods.max():.0f} periods"
    )
    return Verdict(said, bool(gap.max() < 1e-4))


def c79(evidence: Evidence) -> Verdict:
    data = study.series(evidence)
    error = data.attrs["energy_balance_error"]
    return Verdict(f"{error:.1e} at worst over {data['transmissibility'].size} motions", bool(error < 1e-6))


def c80(evidence: Evidence) -> Verdict:
    data, finer, lowest = study.series(evidence), study.finer(evidence), study.fine(evidence)["peak_transmissibility"]
    change = max(
        float(np.abs(finer[name] / data[name] - 1.0).max()) for name in ("peak_transmissibility", "omega_peak")
    )
    forces, tops, at = (data[name].values for name in ("friction_capacity", "peak_transmissibility", "omega_peak"))
    for capacity, reading, omega in zip(forces, tops, at, strict=True):
        tighter = PeriodicSolver(TwoMasses().preloaded(float(capacity)), accuracy=5e-6)
        change = max(change, abs(tighter.motion(float(omega)).transmissibility / reading - 1.0))
    k = int(lowest.values.argmin())
    said = (
        f"T_pk {short(tops, '.4g')} at omega {short(at, '.4f')} (F_c {short(forces, 'g')}); changes {change:.1e} with "
        f"half the step and tolerance; lowest peak {float(lowest[k]):.2f} near F_c = "
        f"{float(lowest['friction_capacity'][k]):.2g}, of the {len(tops)} at {forces[int(tops.argmin())]:g}"
    )
    return Verdict(said, change < 1e-3)


def c81(evidence: Evidence) -> Verdict:
    model, peaks = TwoMasses(), study.series(evidence)["omega_peak"].values
    floor = float(np.sqrt(model.k1 / model.preloaded(1.0).m1))
    ceiling = float(np.sqrt((model.k1 + model.k2) / (model.m1 + model.m2)))
    gaps = peaks[0] / floor - 1.0, peaks[-1] / ceiling - 1.0
    said = (
        f"floor {peaks[0]:.4f} against {floor:.4f} ({100 * gaps[0]:+.3f} %), ceiling {peaks[-1]:.4f} against "
        f"{ceiling:.4f} ({100 * gaps[1]:+.3f} %)"
    )
    return Verdict(said, bool(max(map(abs, gaps)) < 0.005))


def c82(evidence: Evidence) -> Verdict:
    data = study.fine(evidence)
    forces, peaks, zeta = (data[name].values for name in ("friction_capacity", "peak_transmissibility", "zeta"))
    k, z = int(peaks.argmin()), int(np.nanargmax(zeta))
    rises = bool(np.all(np.diff(peaks[k:]) > 0.0)) and bool(np.all(np.diff(peaks[: k + 1]) < 0.0))
    said = (
        f"T_pk falls from {peaks[0]:.1f} (F_c = 1) to {peaks[k]:.2f} and rises from F_c = {forces[k]:.2g} upward; "
        f"damping is largest, {100 * zeta[z]:.1f} %, at {forces[z]:.2g}, but {100 * zeta[0]:.2f} % at F_c = 1"
    )
    return Verdict(said, rises, THESIS_ERROR if rises and k > 0 else "")  # it does not rise from the lowest capacity


def c83(evidence: Evidence) -> Verdict:
    data = study.series(evidence).isel(friction_capacity=slice(1, None))
    peaks, omega, skew = (data[n].values for n in ("peak_transmissibility", "omega_peak", "skewness"))
    drop = float(np.max(np.maximum.accumulate(omega) / omega - 1.0))
    last = len(skew) - 1
    holds = np.all(np.diff(peaks) > 0) and omega[-1] > omega[0] and drop < 1e-3 and np.argmin(np.abs(skew)) == last
    said = f"F_c 2 to 100: T_pk {short(peaks, '.4g')}; peak omega rises, largest drop {100 * drop:.2f} %; SK "
    return Verdict(said + short(skew + 1.0, ".3f"), bool(holds))


def c84(evidence: Evidence) -> Verdict:
    data, model = study.series(evidence)["skewness"], TwoMasses()
    skew, below = (float(data.sel(friction_capacity=c)) + 1.0 for c in (2.0, 1.0))
    ratio = 2.0 / (model.k1 * model.base_amplitude)
    said = f"SK = {skew:.2f} at F_c = 2 (F_c/(k_1 Y_0) = {ratio:.2f} > pi/4); {below:.2f} at F_c = 1"
    return Verdict(said, skew > 1.05 and ratio > 0.25 * np.pi)


def c85(evidence: Evidence) -> Verdict:
    data = study.dwelt(evidence)
    gap = np.abs(data["six_time_constants"].values / data["periodic"].values - 1.0)
    i, j = np.unravel_index(int(gap.argmax()), gap.shape)
    said = (
        f"worst {100 * gap.max():.1f} % off, at F_c = {float(data['friction_capacity'][i]):g}, omega = "
        f"{float(data['omega'][j]):.2f}; more than 5 % off at {100 * float((gap > 0.05).mean()):.1f} % of {gap.size} "
        f"points; worst per F_c {short(100 * gap.max(axis=1), '.2g')} %"
    )
    omega = float(data["omega"][j])
    pressed = TwoMasses().preloaded(float(data["friction_capacity"][i]))
    closed = study.creeping_dwell(pressed, omega, 6.0 / (ZETA * omega)) - 1.0
    said += f"; closed form of stuck masses from rest {100 * abs(closed):.1f} % at the worst point"
    accounted = bool(abs(abs(closed) / gap.max() - 1.0) < 0.02)
    holds = bool(gap.max() < 0.05)
    return Verdict(said, holds, THESIS_ERROR if accounted and not holds else "")


def c86(evidence: Evidence) -> Verdict:
    """Computed entries of Table 5.1 (equation 5.8)."""
    mu, sigma, radius, height, tip, young, wall = 0.25, 300e3, 0.040, 0.300, 1e-3, 2.8e9, 1.6e-3
    capacity = 2.0 * np.pi * radius * height * mu * sigma
    inertia = 0.25 * np.pi * (radius**4 - (radius - wall) ** 4)
    stiffness = 3.0 * young * inertia / height**3
    ratio = capacity / (stiffness * tip)
    holds = abs(ratio / 60.0 - 1.0) < 0.02 and abs(capacity / 5650.0 - 1) < 0.02 and abs(stiffness / 94.2e3 - 1) < 0.02
    said = (
        f"sigma_c = {1e-3 * mu * sigma:g} kPa, F_c = {1e-3 * capacity:.2f} kN, k = {1e-3 * stiffness:.1f} N/mm, F_k = "
        f"{stiffness * tip:.1f} N, ratio {ratio:.1f}"
    )
    return Verdict(said, bool(holds))


def c87(evidence: Evidence) -> Verdict:
    section = evidence.case(study.CASE).expect(TwoDofCase).two_dof
    said = f"0.12/0.15 = {0.12 / 0.15:.2f}, not 0.85; F_c/(k_1 Y_0) = {100.0 / (section.k1 * section.Y0):.1f}; m_2 is "
    kept = section.m2 == 0.85
    return Verdict(f"{said}{section.m2:g}", kept, THESIS_ERROR if kept else "")


def c88(evidence: Evidence) -> Verdict:
    found, space = study.over_stiffness(evidence), study.space(evidence)
    k2, values = np.array(list(found)), np.array(list(found.values()))
    model = TwoMasses()
    ratio = k2 / model.m2 / (model.k1 / model.m1)
    above, valley = ratio > 1.02, np.abs(ratio - 1.0) <= 0.02
    near, m2, map_k2 = (a.values for a in (space["zeta_max"].sel(m2=0.85, method="nearest"), space["m2"], space["k2"]))
    said = (
        f"for k_2/m_2 > k_1/m_1: m_2 = 0.85, k_2 {short(k2[above], 'g')}: {short(100 * values[above])} %; in the "
        f"valley k_2/m_2 = k_1/m_1 {short(100 * values[valley])} %; below it at k_2 "
        f"{short(k2[ratio < 0.98], 'g')}: {short(100 * values[ratio < 0.98])} %; map of {len(m2)} x {len(map_k2)} "
        f"(m_2 {m2[0]:g} to {m2[-1]:g}, k_2 {map_k2[0]:g} to {map_k2[-1]:g}), next to m_2 = 0.85: "
        f"{100 * near[0]:.1f} to {100 * near[-1]:.1f} %, lowest {100 * near.min():.1f} %"
    )
    enough = int(above.sum()) >= 4 and bool(valley.any())
    return Verdict(said, enough and bool(np.all(np.diff(values[above]) > 0.0)))


def c89(evidence: Evidence) -> Verdict:
    found = study.over_modulus(evidence)
    values = np.array(list(found.values()))
    preloads = sorted({1e-3 * float(m.values["preload.pressure"]) for m in evidence.study(study.FE_STUDY)})
    trend = ": it rises" if np.all(np.diff(values) > 0.0) else ""
    said = (
        f"lab roll, E_l {short(1e-9 * np.array(list(found)), 'g')} GPa, largest zeta of {short(preloads, 'g')} kPa: "
        f"{short(100 * values)} %{trend}; {base_spring.damping_text(evidence)}; {base_spring.thesis_text(evidence)}"
    )
    return Verdict(said, bool(np.all(np.diff(values) < 0.0)))


def c90(evidence: Evidence) -> Verdict:
    a, b, c = study.arrangements(evidence).values()
    tops = [float(d["omega_peak"][-1]) for d in (a, b, c)]
    skews = [short(d["skewness"].values + 1.0, ".2f") for d in (a, b, c)]
    said = (
        f"peak omega at F_c = 100: (a) {tops[0]:.3f}, (b) {tops[1]:.3f}, (c) {tops[2]:.3f} (primary alone 1); SK at "
        f"F_c = 2, 5, 20, 100: (a) {skews[0]}; (b) {skews[1]}; (c) {skews[2]}"
    )
    negative = bool((b["skewness"].values[:3] < 0.0).all())
    return Verdict(said, tops[2] <= 1.0 < tops[0] and negative)


def readings(evidence: Evidence) -> str:
    """Table of half-power damping from the refined peaks."""
    data = study.series(evidence)
    rows = []
    for capacity in data["friction_capacity"].values:
        one = data.sel(friction_capacity=capacity)
        peak, omega, low, high, zeta, skew = (
            float(one[name])
            for name in ("peak_transmissibility", "omega_peak", "omega_low", "omega_high", "zeta", "skewness")
        )
        span = f"{low:.5f} to {high:.5f}"
        rows.append((f"{capacity:g}", f"{peak:.3f}", f"{omega:.5f}", span, f"{100 * zeta:.3f}", f"{skew + 1:.3f}"))
    return table(("F_c", "T_pk", "omega_pk", "half power", "zeta, %", "SK"), rows)


def of_motions(value: Callable[[float, float], str], evidence: Evidence) -> str:
    """Table over capacity and frequency; each entry is a text made from both transmissibilities."""
    data = study.settled(evidence)
    rows = []
    for capacity, line, other in zip(
        data["friction_capacity"].values, data["periodic"].values, data["in_time"].values, strict=True
    ):
        rows.append((f"{capacity:g}", *(value(a, b) for a, b in zip(line, other, strict=True))))
    return table(("F_c \\ omega", *(f"{w:g}" for w in data["omega"].values)), rows)


def smoothing(evidence: Evidence) -> str:
    """Table of peak and damping over the capacity for each scale s (appendix C)."""
    found = study.scales(evidence)
    rows = []
    for s, data in found.items():
        read = zip(data["peak_transmissibility"].values, data["zeta"].values, strict=True)
        rows.append((f"{s:g}", *(f"{t:.4g}; {100 * z:.3g} %" for t, z in read)))
    forces = next(iter(found.values()))["friction_capacity"].values
    return table(("s", *(f"F_c = {c:g}" for c in forces)), rows)


def constant(evidence: Evidence) -> str:
    """Table of the peaks with and without equations 5.6 and 5.7."""
    pair = study.with_and_without_preload(evidence)
    rows = []
    for capacity in pair[0]["friction_capacity"].values:
        ones = [data.sel(friction_capacity=capacity) for data in pair]
        cells = [
            f"{float(d['omega_peak']):.3f}, {float(d['peak_transmissibility']):.1f}, {float(d['skewness']) + 1:.2f}"
            for d in ones
        ]
        rows.append((f"{capacity:g}", *cells))
    return table(("F_c", "peak omega, T_pk, SK as in the thesis", "with constant masses and stiffness"), rows)


GROUP = ClaimGroup(
    {
        "C77": c77, "C78": c78, "C79": c79, "C80": c80, "C81": c81, "C82": c82, "C83": c83, "C84": c84, "C85": c85,
        "C86": c86, "C87": c87, "C88": c88, "C89": c89, "C90": c90,
    },
    figures={
        "two_dof_arrangements": (
            "Figs 5.1 and 5.2: response of the three arrangements, and its skew",
            lambda evidence: plot_two_dof_arrangements(study.arrangements(evidence)),
        ),
        "two_dof": (
            "Fig 5.6: response over preload, finite elements (harmonic balance) and two masses",
            figures.plot_both_models,
        ),
        "two_dof_readings": (
            "Readings of the two masses over the friction capacity",
            lambda evidence: plot_two_dof_readings(study.fine(evidence)),
        ),
        "two_dof_design_space": (
            "Fig 5.7: largest damping over mass and stiffness of the secondary",
            lambda evidence: plot_two_dof_design_space(study.space(evidence)),
        ),
        "layer_space": ("Fig 5.7 in both models, on axes relative to the reference", figures.plot_layer_space),
        "ch4_layer_modulus": ("Fig 5.8: damping over frequency for three layer moduli", study_figure(study.FE_STUDY)),
        "two_dof_stiffness": (
            "Figs 5.7 and 5.8 on one axis: largest damping over the stiffness of the secondary",
            figures.plot_stiffness,
        ),
    },
    tables={
        "Readings of the refined peaks of the two masses (C80 to C84)": readings,
        "x1 amplitude / Y0, harmonic balance (C78)": partial(of_motions, lambda a, b: f"{a:.5f}"),
        "Relative difference of time integration from it": partial(of_motions, lambda a, b: f"{b / a - 1.0:.0e}"),
        "T_pk and half-power damping for S(s v) (appendix C)": smoothing,
        "With and without equations 5.6 and 5.7": constant,
    },
    studies=("layer_modulus",),
    partial_studies=(figures.SPACE_STUDY,),
)  # fmt: skip
