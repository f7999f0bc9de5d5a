"""Claims on the experiments of chapter 3 that the lab roll in simulation can settle: C33, C34, C37 to C48, C52 to C56.

Claims on random excitation and on shocks (C49 to C51) need base motions that no study has yet.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from scipy.constants import g as GRAVITY

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.lab_studies import bound, sweeps
from reproduction.layer_slip import AMPLITUDE, outer_slips
from reproduction.layers import dwells, largest
from reproduction.verdict import NOT_YET, Verdict
from reproduction.words import kpa, monotone, numbers
from wroll_fem.case.contact import PenaltyFriction
from wroll_fem.plotting.study import PRESSURE, StudyCase, natural_frequency, read
from wroll_fem.results.interface_slip import surface
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.estimators import single_dof_transmissibility
from wroll_fem.typing import FloatArray

LEVELS_STUDY, MU = "levels", "contact.friction.mu"
LEVELS = (0.5, 1.0, 2.0, 5.0)
"""Base accelerations of C39 to C42, m/s^2, 0-peak; the thesis has 5 and prints no others."""
FACE = math.radians(15.0)
"""Half the angle around an axis that counts as its face."""


# ---- arithmetic ----------------------------------------------------------------------------------


def c33(evidence: Evidence) -> Verdict:
    rate = math.log2(300 / 5) / 0.75
    return Verdict(f"log2(300/5)/0.75 min = {rate:.3f} oct/min", abs(rate / 7.88 - 1) < 1e-3)


def c34(evidence: Evidence) -> Verdict:
    level = 5.0 / GRAVITY
    return Verdict(f"5/9.80665 = {level:.3f} g", abs(level - 0.51) < 5e-3)


def c37(evidence: Evidence) -> Verdict:
    f = np.linspace(0.9, 1.1, 20001)
    found = half_power(f, np.abs(single_dof_transmissibility(f, 1.0, 0.01)))
    exact = abs((found.f_high - found.f_low) / (2.0 * found.f_n) / found.zeta - 1.0) < 1e-12
    value = f"(f2 - f1)/(2 f_n); the curve of a single degree of freedom with 1 % returns {100 * found.zeta:.4f} %"
    return Verdict(value, exact and abs(found.zeta / 0.01 - 1.0) < 0.01)


def c56(evidence: Evidence) -> Verdict:
    spread = math.sqrt(2.0) * 0.01
    return Verdict(f"sqrt(2) x 0.01 px = {spread:.4f} px, 1.4 um at 0.1 mm/px", abs(spread - 0.014) < 5e-4)


# ---- resonance over preload and level ------------------------------------------------------------


def at_level(data: xr.Dataset, level: float) -> float:
    """Resonance (Hz) of a backbone at a base acceleration (m/s^2): the first motion that needs so much; nan if none."""
    base, f = data["resonant_base_acceleration"].values, data["resonance_frequency"].values
    above = np.flatnonzero(base >= level)
    if not above.size or above[0] == 0:
        return math.nan
    k = int(above[0])
    return float(np.interp(np.log(level), np.log(base[k - 1 : k + 1]), f[k - 1 : k + 1]))


def reached_levels(evidence: Evidence, mu: float) -> dict[float, FloatArray]:
    """Preload (Pa) -> resonances (Hz) at `LEVELS`, from backbones with a friction coefficient.

    A level that a backbone does not reach has the resonance nan.
    """
    own = [m for m in evidence.study(LEVELS_STUDY) if float(m.values[MU]) == mu]
    own.sort(key=lambda m: float(m.values[PRESSURE]))
    return {float(m.values[PRESSURE]): np.array([at_level(m.data, a) for a in LEVELS]) for m in own}


def over_levels(evidence: Evidence, mu: float) -> dict[float, FloatArray]:
    """Preload (Pa) -> resonances (Hz) at `LEVELS`; see `reached_levels`.

    A roll that sticks up to the largest amplitude has no resonance of finite height at a level, and is left out.
    """
    return {p: line for p, line in reached_levels(evidence, mu).items() if np.isfinite(line).all()}


def levels_text(found: Mapping[float, FloatArray]) -> str:
    """Resonances over the preload as text, one series per level."""
    lines = np.array(list(found.values())).T
    said = (f"{numbers(line, '.1f')} Hz at {a:g} m/s^2" for a, line in zip(LEVELS, lines, strict=True))
    return f"{numbers((1e-3 * p for p in found), 'g')} kPa: {'; '.join(said)}"


def mandrel(evidence: Evidence) -> float:
    """Resonance of the mandrel alone, Hz."""
    return natural_frequency(evidence.reference("bounds"))


def c38(evidence: Evidence) -> Verdict:
    value = f"the mandrel alone has no contact and is linear: {mandrel(evidence):.2f} Hz at every level"
    return Verdict(value, True)


def c39(evidence: Evidence) -> Verdict:
    found = over_levels(evidence, 0.25)
    table = np.array(list(found.values()))
    change = np.abs(table[:, 0] - table[:, -1])
    up = all(monotone(column.tolist(), 1) for column in table.T)
    down = all(monotone(row.tolist(), -1) for row in table)
    value = f"{levels_text(found)}; change over the levels {numbers(change, '.1f')} Hz"
    return Verdict(value, up and down and bool(change[-1] < change[0]))


def c40(evidence: Evidence) -> Verdict:
    found, f_m = over_levels(evidence, 0.25), mandrel(evidence)
    pressure, f = min(found.items())
    value = (
        f"{1e-3 * pressure:g} kPa: {f[0]:.1f} Hz at {LEVELS[0]:g} m/s^2, {f[-1]:.1f} Hz at {LEVELS[-1]:g} m/s^2; "
        f"mandrel alone {f_m:.1f} Hz"
    )
    return Verdict(value, bool(f[0] > f_m > f[-1]))


def c41(evidence: Evidence) -> Verdict:
    given, doubled = over_levels(evidence, 0.25), over_levels(evidence, 0.5)
    pressures = [p for p in given if p in doubled]
    low, high = (np.array([found[p][-1] for p in pressures]) for found in (given, doubled))
    third = pressures[-1] ** (2 / 3) * pressures[0] ** (1 / 3)
    top = float(np.interp(np.log(third), np.log(pressures), high))
    last = abs(float(high[-1]) / top - 1.0)
    value = (
        f"{numbers((1e-3 * p for p in pressures), 'g')} kPa, 5 m/s^2: mu 0.25 {numbers(low, '.1f')} Hz, mu 0.5 "
        f"{numbers(high, '.1f')} Hz; range {np.ptp(low):.1f} and {np.ptp(high):.1f} Hz; change over the top third "
        f"(logarithmic) {100 * last:.1f} %"
    )
    return Verdict(value, bool(np.all(high >= low) and np.ptp(high) < np.ptp(low) and last < 0.01))


def c42(evidence: Evidence) -> Verdict:
    f_b = bound(evidence, "bonded", "free")
    highest = max(float(np.nanmax(line)) for line in over_levels(evidence, 0.25).values())
    swept = max(read(m).f_n for m in sweeps(evidence, "free"))
    value = (
        f"largest f_n {highest:.1f} Hz (backbones, {LEVELS[0]:g} to {LEVELS[-1]:g} m/s^2) and {swept:.1f} Hz (sweeps), "
        f"f_b = {f_b:.1f} Hz"
    )
    return Verdict(value, max(highest, swept) <= 1.005 * f_b)


def c43(evidence: Evidence) -> Verdict:
    members = sweeps(evidence, "free")
    skew = [read(m).skewness + 1.0 for m in members]
    value = f"SK {numbers(skew, '.2f')} at {', '.join(map(kpa, members))}"
    return Verdict(value, skew[0] > 1.05 and monotone(skew, -1) and abs(skew[-1] - 1.0) < abs(skew[0] - 1.0))


def c44(evidence: Evidence) -> Verdict:
    low = sorted((m for m in evidence.study("preload_low")), key=lambda m: float(m.values[PRESSURE]))[:2]
    (p, before), (top, after) = list(reached_levels(evidence, 0.25).items())[-2:]
    both = max(np.flatnonzero(np.isfinite(before) & np.isfinite(after)), default=0)  # the largest level of both
    changes = read(low[1]).f_n / read(low[0]).f_n - 1.0, float(after[both] / before[both]) - 1.0
    value = (
        f"{kpa(low[0])} to {kpa(low[1])}: {100 * changes[0]:+.2f} % (sweeps, 5 m/s^2); {1e-3 * p:g} to {1e-3 * top:g} "
        f"kPa: {100 * changes[1]:+.2f} % (backbones, {LEVELS[both]:g} m/s^2, the largest level that both reach)"
    )
    return Verdict(value, max(map(abs, changes)) < 0.02)


def c45(evidence: Evidence) -> Verdict:
    members, f_m = sweeps(evidence, "free"), mandrel(evidence)
    lowest = min(members, key=lambda m: read(m).f_n)
    ratio = read(lowest).f_n / f_m
    value = f"{read(lowest).f_n:.1f} Hz at {kpa(lowest)}, {ratio:.3f} of the mandrel alone ({f_m:.1f} Hz); base free"
    return Verdict(value, abs(ratio - 0.9) <= 0.05)


def c46(evidence: Evidence) -> Verdict:
    members, f_m = sweeps(evidence, "free"), mandrel(evidence)
    highest = max(read(m).f_n for m in members) / f_m
    bonded = bound(evidence, "bonded", "free") / f_m
    value = f"largest f_n/f_m {highest:.3f}, f_b/f_m {bonded:.3f} (base free)"
    return Verdict(value, all(1.02 <= ratio <= 1.13 for ratio in (highest, bonded)))


def c47(evidence: Evidence) -> Verdict:
    members = sweeps(evidence, "free")
    zeta = np.array([read(m).zeta for m in members])
    inside = np.count_nonzero((zeta >= 0.01) & (zeta <= 0.05))
    value = f"zeta {numbers(100 * zeta, '.2f')} % at {', '.join(map(kpa, members))}; friction alone damps"
    return Verdict(value, bool(2 * inside >= zeta.size and np.nanmax(zeta) <= 0.1))


def c48(evidence: Evidence) -> Verdict:
    members = sweeps(evidence, "free")
    least = min(members, key=lambda m: read(m).zeta)
    value = f"least {100 * read(least).zeta:.2f} % at {kpa(least)}; the mandrel alone has no damping in the model"
    return Verdict(value, bool(read(least).zeta > 0.0))


# ---- slip ----------------------------------------------------------------------------------------


def loose_and_tight(evidence: Evidence) -> tuple[StudyCase, StudyCase]:
    """Sweeps at the lowest preload and at 100 kPa or the next above, which is beyond 60 N (C61)."""
    members = sweeps(evidence, "free")
    return members[0], next(m for m in members if float(m.values[PRESSURE]) >= 1e5)


def peak_slip(member: StudyCase) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Angle from the axis (rad, 0 to pi/2), height (m), hoop and axial relative displacement (m) at the mandrel."""
    points = surface(member.data, 0, "peak_slip_hoop", "peak_slip_axial")
    angle = np.abs(points.theta)
    hoop, axial = (np.abs(points.values[name]) for name in ("peak_slip_hoop", "peak_slip_axial"))
    return np.minimum(angle, np.pi - angle), points.z, hoop, axial


def c52(evidence: Evidence) -> Verdict:
    members = sweeps(evidence, "free")
    found = [peak_slip(m)[2:] for m in members]
    slip = [1e6 * float(np.hypot(*pair).max()) for pair in found]
    hoop = [1e6 * float(pair[0].max()) for pair in found]
    value = (
        f"sweeps through f_n at 5 m/s^2: largest relative displacement {numbers(slip, '.1f')} um, horizontal part "
        f"{numbers(hoop, '.2f')} um at {', '.join(map(kpa, members))}"
    )
    return Verdict(value, max(slip) < 30.0 and max(hoop) < 5.0)


def over_height(z: FloatArray, values: FloatArray) -> FloatArray:
    """Largest value at each height, from the base upward."""
    heights = np.unique(np.round(z, 6))
    return np.array([values[np.abs(z - h) < 1e-6].max() for h in heights])


def c53(evidence: Evidence) -> Verdict:
    members = loose_and_tight(evidence)
    loose, tight = map(peak_slip, members)
    angle, z, hoop, axial = loose
    size = np.hypot(hoop, axial)
    along, across = float(size[angle <= FACE].max()), float(size[angle >= 0.5 * np.pi - FACE].max())
    other = float(np.hypot(*tight[2:]).max())
    profile = over_height(z, size)
    friction = evidence.roll("lab_sweep").friction
    assert isinstance(friction, PenaltyFriction)
    slips = np.where(profile > friction.elastic_slip, profile, 0.0)  # below gamma* it sticks
    few = 1e6 * profile[:: max(1, profile.size // 6)]
    top = float(z[int(size.argmax())])
    value = (
        f"loose ({kpa(members[0])}): {1e6 * along:.1f} um on the axial face, {1e6 * across:.1f} on the transverse one; "
        f"vertical {1e6 * axial.max():.1f}, horizontal {1e6 * hoop.max():.2f} um; largest {1e3 * top:.0f} mm above the "
        f"base; tight ({kpa(members[1])}) {1e6 * other:.1f} um; over the height "
        f"{numbers(few, '.1f')} um"
    )
    lowest = bool(top <= 0.1 * z.max())
    holds = along > across and axial.max() > hoop.max() and size.max() > other and lowest
    return Verdict(value, bool(holds) and monotone(slips.tolist(), -1))


def c54(evidence: Evidence) -> Verdict:
    member = dwells(evidence)[0]
    slips = outer_slips(member)
    value = (
        f"five layers of five wraps, {member.values[AMPLITUDE] / GRAVITY:.3g} g: {numbers(1e6 * slips, '.2f')} um, "
        "inner first; layer 6 of the coil is the second of the model"
    )
    return Verdict(value, bool(slips[1:].max() < 2e-6))


def c55(evidence: Evidence) -> Verdict:
    members: Sequence[StudyCase] = dwells(evidence)
    places = [largest(m).interface for m in members]
    levels = ", ".join(f"{m.values[AMPLITUDE] / GRAVITY:.3g} g" for m in members)
    value = f"interface of the largest slip at {levels}: {numbers((k + 1 for k in places), 'd')} (1 is at the mandrel)"
    return Verdict(value, all(k == 0 for k in places))


# ---- not yet -------------------------------------------------------------------------------------


def c49(evidence: Evidence) -> Verdict:
    return Verdict("needs random base motions over a range of levels; no study has them", False, NOT_YET)


def c51(evidence: Evidence) -> Verdict:
    return Verdict("needs a short shock of the base; no study has one", False, NOT_YET)


GROUP = ClaimGroup(
    {
        "C33": c33, "C34": c34, "C37": c37, "C38": c38, "C39": c39, "C40": c40, "C41": c41, "C42": c42, "C43": c43,
        "C44": c44, "C45": c45, "C46": c46, "C47": c47, "C48": c48, "C49": c49, "C50": c49, "C51": c51, "C52": c52,
        "C53": c53, "C54": c54, "C55": c55, "C56": c56,
    },
    studies=("bounds", "levels", "preload_low"),
)  # fmt: skip
