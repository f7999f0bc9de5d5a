"""Claims on the distribution of slip and on the number of layers: C71 to C75."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.constants import g as GRAVITY

from reproduction import base_spring
from reproduction.claim_group import ClaimGroup, study_figure
from reproduction.evidence import Evidence
from reproduction.lab_studies import beside
from reproduction.layer_slip import AMPLITUDE, areas
from reproduction.verdict import THESIS_ERROR, Verdict
from reproduction.words import kpa, numbers
from wroll_fem.analyses.forecasts.closed_forms import interface_pressures
from wroll_fem.errors import InputError
from wroll_fem.plotting.study import StudyCase, is_sweep, read
from wroll_fem.results.interface_slip import surface

OUTSIDE = "preload.pressure"
DWELL_STUDY = {"free": "dwell_layers", "clamped": "dwell_layers_clamped", "contact": "dwell_layers_contact"}
"""Base condition of the layers -> study of dwells at 150 Hz; contact: base free, 1 to 0.2 kPa at the interfaces."""

Members = Sequence[StudyCase]


class Slip(NamedTuple):
    """Largest relative displacement: interface (0 is innermost), hoop and axial component (m), angle from x (deg)."""

    interface: int
    hoop: float
    axial: float
    angle: float


def dwells(evidence: Evidence, base: str = "free") -> list[StudyCase]:
    """Dwells with one base condition, in order of increasing level."""
    return sorted(evidence.study(DWELL_STUDY[base]), key=lambda m: float(m.values[AMPLITUDE]))


def level(member: StudyCase) -> str:
    """Level of a dwell as text, "1 g"."""
    return f"{member.values[AMPLITUDE] / GRAVITY:.3g} g"


def all_series(evidence: Evidence, said: Callable[[Members], str]) -> str:
    """Result for both base conditions, and for contact pressures of 1 to 0.2 kPa, as text."""
    bases = beside(evidence, said, lambda base: dwells(evidence, base))
    return f"{bases}; free base, contact pressures 1 to 0.2 kPa: {said(dwells(evidence, 'contact'))}"


def judged(evidence: Evidence) -> list[list[StudyCase]]:
    """Series on which C72 to C74 are judged: 200 Pa on each layer, and 1 to 0.2 kPa at the interfaces."""
    return [dwells(evidence, name) for name in ("free", "contact")]


def largest(member: StudyCase) -> Slip:
    """Largest relative displacement of a dwell."""
    best = Slip(0, 0.0, 0.0, 0.0)
    for k in range(member.data.sizes["interface"]):
        points = surface(member.data, k, "peak_slip_hoop", "peak_slip_axial")
        hoop, axial = points.values["peak_slip_hoop"], points.values["peak_slip_axial"]
        i = int(np.argmax(np.hypot(hoop, axial)))
        if np.hypot(hoop[i], axial[i]) > np.hypot(best.hoop, best.axial):
            angle = abs(float(np.degrees(points.theta[i])))
            best = Slip(k, float(hoop[i]), float(axial[i]), min(angle, 180.0 - angle))
    return best


def top(member: StudyCase) -> float:
    """Height of the highest slipping point, m; 0 if there is none."""
    slipped = member.data["slipped"].values.astype(bool).any(axis=0)
    return float(member.data["z_m"].values[slipped].max(initial=0.0))


def second(members: Members) -> str:
    """Level of the first dwell in which two interfaces slip, as text."""
    slipping = [m for m in members if np.count_nonzero(areas(m)) >= 2]
    return f"from {level(slipping[0])}" if slipping else f"not up to {level(members[-1])}"


def c71(evidence: Evidence) -> Verdict:
    found = evidence.summary("dwell_layers", dwells(evidence)[0])["interface_pressure_mean_pa"]
    split = interface_pressures(evidence.roll("lab_dwell_layers"))
    members = dwells(evidence, "contact")
    other = evidence.summary(DWELL_STUDY["contact"], members[0])["interface_pressure_mean_pa"]
    outside = float(members[0].values[OUTSIDE][0])
    value = (
        f"mean interface pressures {numbers(found, '.0f')} Pa (inner first); thin-ring split by E t/R^2: "
        f"{numbers(split, '.0f')} Pa; sum applied 1000 Pa, outermost 200 Pa; {outside:g} Pa on each layer press "
        f"{numbers(other, '.0f')} Pa"
    )
    holds = abs(found[0] / 1000 - 1) <= 0.02 and abs(found[-1] / 200 - 1) <= 0.02
    rings = bool(np.all(np.abs(np.divide(found, split) - 1) < 0.1))  # the closed form of the rings explains the loss
    return Verdict(value, holds, THESIS_ERROR if rings and not holds else "")


def c72(evidence: Evidence) -> Verdict:
    def said(members: Members) -> str:
        return f"{level(members[0])}: slipped {numbers(1e4 * areas(members[0]), '.1f')} cm^2, inner first"

    firsts = [areas(members[0]) for members in judged(evidence)]
    holds = all(bool(np.all(first[0] > first[1:]) and first[-1] == 0.0) for first in firsts)
    return Verdict(all_series(evidence, said), holds)


def c73(evidence: Evidence) -> Verdict:
    def said(members: Members) -> str:
        slip = largest(members[0])
        return (
            f"{level(members[0])}: interface {slip.interface + 1}, vertical {1e6 * abs(slip.axial):.2f} um, horizontal "
            f"{1e6 * abs(slip.hoop):.2f} um, {slip.angle:.0f} deg from the axis"
        )

    slips = [largest(members[0]) for members in judged(evidence)]
    holds = all(s.interface == 0 and abs(s.axial) > abs(s.hoop) and s.angle <= 45.0 for s in slips)
    return Verdict(all_series(evidence, said), holds)


def c74(evidence: Evidence) -> Verdict:
    def facts(members: Members) -> list[tuple[float, float, int]]:
        return [(float(areas(m).sum()), top(m), int(np.count_nonzero(areas(m)))) for m in members]

    def said(members: Members) -> str:
        rows = ", ".join(
            f"{level(m)}: {1e4 * a:.0f} cm^2, up to {1e3 * z:.0f} mm, {n} interfaces"
            for m, (a, z, n) in zip(members, facts(members), strict=True)
        )
        return f"{rows} (second interface {second(members)})"

    def grows(members: Members) -> bool:
        found = facts(members)
        area, height, _ = (np.diff(column) for column in zip(*found, strict=True))
        return len(found) == 3 and bool(np.all(area > 0) and np.all(height >= 0))

    value = f"{all_series(evidence, said)}; {base_spring.second_interface_text(evidence)}"
    return Verdict(value, all(map(grows, judged(evidence))))


def c75(evidence: Evidence) -> Verdict:
    most = {}
    for n in (1, 2):
        group = [m for m in evidence.study("layer_count") if m.values["coil.layers"] == n and is_sweep(m)]
        if not group:
            raise InputError(f"study layer_count has no finished sweep with {n} layers", remedy="see its run folders")
        best = max(group, key=lambda m: float(np.nan_to_num(read(m).zeta)))
        most[n] = (read(best).zeta, kpa(best))
    ratio = most[2][0] / most[1][0]
    value = "; ".join(f"n = {n}: max zeta {100 * z:.2f} % at {p}" for n, (z, p) in most.items())
    return Verdict(f"{value}; ratio {ratio:.2f}", 0.02 <= most[1][0] <= 0.08 and 1 / 1.5 <= ratio <= 1.5)


GROUP = ClaimGroup(
    {"C71": c71, "C72": c72, "C73": c73, "C74": c74, "C75": c75},
    figures={
        "ch4_slip_extent": (
            "Fig 4.10: where each interface slipped at 1, 2 and 3 g, base free",
            study_figure("dwell_layers", "slip_extent"),
        ),
        "ch4_dwell_layers_contact_slip_extent": (
            "Fig 4.10 with contact pressures of 1 to 0.2 kPa, base free",
            study_figure("dwell_layers_contact", "slip_extent"),
        ),
        "ch4_dwell_layers_clamped_slip_extent": (
            "Fig 4.10 with the base rings of all layers clamped",
            study_figure("dwell_layers_clamped", "slip_extent"),
        ),
        "ch4_slip_vectors": (
            "Fig 4.11: largest relative displacement of each interface, base free",
            study_figure("dwell_layers", "slip_vectors"),
        ),
        "ch4_dwell_layers_clamped_slip_vectors": (
            "Fig 4.11 with the base rings of all layers clamped",
            study_figure("dwell_layers_clamped", "slip_vectors"),
        ),
        "ch4_layer_count": ("Damping with one and with two slipping interfaces (C75)", study_figure("layer_count")),
    },
    studies=("dwell_layers", "dwell_layers_clamped", "dwell_layers_contact", "layer_count"),
)
