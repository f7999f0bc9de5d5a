"""Claims on the lab roll from 10 to 300 kPa: C64 to C70."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from reproduction.claim_group import ClaimGroup, study_figure
from reproduction.evidence import Evidence
from reproduction.lab_studies import beside, sweeps
from reproduction.verdict import Verdict
from reproduction.words import kpa, listed, monotone, rank_correlation
from wroll_fem.plotting.study import StudyCase, friction_work, natural_frequency, read
from wroll_fem.signals.sweeps import sweep_of

Members = Sequence[StudyCase]


def both_bases(evidence: Evidence, said: Callable[[Members], str]) -> str:
    """Result for both base conditions as text."""
    return beside(evidence, said, lambda base: sweeps(evidence, base))


def upward(members: Members) -> Members:
    """Cases from the preload of the largest damping upward; claims on trends are judged on them."""
    zeta = [read(m).zeta for m in members]
    return members[int(np.nanargmax(zeta)) :] if np.isfinite(zeta).any() else members


def judged_from(evidence: Evidence) -> str:
    """The preload of the largest damping and its pressure at the interface, as text."""
    first = upward(sweeps(evidence, "free"))[0]
    inside = evidence.summary("preload", first)["interface_pressure_mean_pa"][0]
    return f"judged from the largest damping upward: {kpa(first)} outside, {1e-3 * inside:.3g} kPa at the interface; "


def c64(evidence: Evidence) -> Verdict:
    def said(members: Members) -> str:
        f, zeta = [read(m).f_n for m in members], [read(m).zeta for m in members]
        best = int(np.nanargmax(zeta))
        return f"f_n {min(f):.1f} to {max(f):.1f} Hz, zeta up to {100 * zeta[best]:.2f} % ({kpa(members[best])})"

    members = sweeps(evidence, "free")
    f, zeta = [read(m).f_n for m in members], [read(m).zeta for m in members]
    holds = 128 <= min(f) <= 142 and 157 <= max(f) <= 173 and 0.02 <= np.nanmax(zeta) <= 0.08
    return Verdict(both_bases(evidence, said), bool(holds))


def c65(evidence: Evidence) -> Verdict:
    def said(members: Members) -> str:
        peaks, first = listed(members, lambda m: read(m).peak, ".1f"), upward(members)[0]
        return f"T_pk {peaks} at {', '.join(map(kpa, members))}; SK({kpa(first)}) = {read(first).skewness + 1:.2f}"

    members = upward(sweeps(evidence, "free"))
    holds = monotone([read(m).peak for m in members], 1) and read(members[0]).skewness + 1 > 1.05
    return Verdict(judged_from(evidence) + both_bases(evidence, said), holds)


def c66(evidence: Evidence) -> Verdict:
    def said(members: Members) -> str:
        return ", ".join(f"f_n({kpa(m)}) = {read(m).f_n:.1f} Hz" for m in (members[-1], members[0]))

    f_m, members = natural_frequency(evidence.reference("bounds")), sweeps(evidence, "free")
    return Verdict(
        f"f_m = {f_m:.1f} Hz; {both_bases(evidence, said)}", read(members[-1]).f_n > f_m > read(members[0]).f_n
    )


def c67(evidence: Evidence) -> Verdict:
    def rho(members: Members) -> float:
        return rank_correlation([read(m).f_n for m in members], [read(m).zeta for m in members])

    def said(members: Members) -> str:
        zeta = listed(members, lambda m: 100 * read(m).zeta, ".2f")
        return f"rank correlation {rho(upward(members)):.2f} ({rho(members):.2f} over all), zeta {zeta} %"

    value = judged_from(evidence) + both_bases(evidence, said)
    return Verdict(value, rho(upward(sweeps(evidence, "free"))) < -0.8)


def c68(evidence: Evidence) -> Verdict:
    """Fraction of E_F dissipated within 10 % of f_n, and frequency of its largest rate (windows of about 20 cycles)."""
    members = sweeps(evidence, "free")
    parts, holds = [], True
    for m in (members[0], members[-1]):
        sweep = sweep_of(m.data)
        assert sweep is not None
        time, work = m.data["time"].values, m.data["friction_energy"].values
        frequency = sweep.frequency(time)
        f_n = read(m).f_n
        near = np.abs(frequency / f_n - 1) <= 0.1
        share = (work[near][-1] - work[near][0]) / work[-1]
        edges = np.linspace(0, time.size - 1, max(2, int((time[-1] - time[0]) * f_n / 20))).astype(int)
        window = int(np.argmax(np.diff(work[edges]) / np.diff(time[edges])))
        at = float(frequency[(edges[window] + edges[window + 1]) // 2])
        holds &= bool(share >= 0.5 and abs(at / f_n - 1) <= 0.1)
        parts.append(
            f"{kpa(m)}: {100 * share:.0f} % within 10 % of f_n, largest rate at {at:.1f} Hz (f_n {f_n:.1f} Hz)"
        )
    return Verdict("free base: " + "; ".join(parts), holds)


def c69(evidence: Evidence) -> Verdict:
    def said(members: Members) -> str:
        work = listed(members, lambda m: 1e3 * friction_work(m), ".0f")
        return f"E_F {work} mJ at {', '.join(kpa(m) for m in members)}"

    falls = monotone([friction_work(m) for m in sweeps(evidence, "free")], -1)
    return Verdict(both_bases(evidence, said), falls)


def c70(evidence: Evidence) -> Verdict:
    def r(members: Members) -> float:
        return float(np.corrcoef([friction_work(m) for m in members], [read(m).zeta for m in members])[0, 1])

    def said(members: Members) -> str:
        work, zeta = [friction_work(m) for m in members], [read(m).zeta for m in members]
        return (
            f"r = {r(upward(members)):.2f} ({r(members):.2f} over all), max zeta at "
            f"{kpa(members[int(np.argmax(zeta))])}, max E_F at {kpa(members[int(np.argmax(work))])}"
        )

    value = judged_from(evidence) + both_bases(evidence, said)
    return Verdict(value, r(upward(sweeps(evidence, "free"))) > 0.8)


GROUP = ClaimGroup(
    {"C64": c64, "C65": c65, "C66": c66, "C67": c67, "C68": c68, "C69": c69, "C70": c70},
    figures={
        "ch4_transmissibility_over_preload": (
            "Fig 4.4: transmissibility, base of the layer free",
            study_figure("preload", "transmissibility_over_preload"),
        ),
        "ch4_preload_clamped_transmissibility_over_preload": (
            "Fig 4.4 with the base of the layer clamped",
            study_figure("preload_clamped", "transmissibility_over_preload"),
        ),
        "ch4_damping_over_frequency": (
            "Fig 4.5: damping over resonance, one point per preload",
            study_figure("preload", "damping_over_frequency"),
        ),
        "ch4_friction_along_sweep": (
            "Fig 4.6: tip acceleration and friction work along the sweep, lowest and highest preload",
            study_figure("preload", "friction_along_sweep"),
        ),
        "ch4_friction_over_preload": (
            "Fig 4.7: friction work over preload",
            study_figure("preload", "friction_over_preload"),
        ),
        "ch4_friction_over_damping": (
            "Fig 4.8: friction work over damping, one point per preload",
            study_figure("preload", "friction_over_damping"),
        ),
    },
    studies=("bounds", "preload", "preload_clamped"),
)
