"""Studies of the flight rolls that rub on their mandrels: readings of steady curves and of the thesis's chirp."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from scipy.integrate import trapezoid

from reproduction.evidence import Evidence
from reproduction.words import numbers
from wroll_fem.errors import InputError
from wroll_fem.jobs.grid import Member
from wroll_fem.plotting import style
from wroll_fem.plotting.study import PRESSURE, StudyCase, friction_work, read
from wroll_fem.signals.transmissibility import magnitude

NAMES = {"irosa_friction": "iROSA", "sspp_friction": "SSPP", "habex_friction": "HabEx"}
"""Case file -> structure."""
BASELINE, CHIRPS, INNER_EDGE = "flight_preload", "flight_chirp", "flight_inner_edge"
SENSITIVITY = {
    "mu": ("contact.friction.mu", 0.25, ("flight_friction",)),
    "E": ("coil.material.E", 5.0e9, ("flight_modulus",)),
    "G": (
        "coil.material.G_r_theta",
        5.0e9 / 2.6,
        ("flight_shear_irosa", "flight_shear_sspp", "flight_shear_habex"),
    ),
    "s": ("coil.total_thickness", 1.0, ("flight_size_irosa", "flight_size_sspp", "flight_size_habex")),
}
"""Parameter of section 6.6, or shear modulus between wraps -> key of the case file, value of the baseline, and studies
of the other values."""
THICKNESS = {"iROSA": 0.15, "SSPP": 0.6, "HabEx": 1.25}
"""Thickness of the coil of the baseline, m; s is relative to it."""
OCTAVES_PER_SECOND = math.log2(160.0 / 5.0) / 20.0
"""Rate of the thesis's chirp, 5 to 160 Hz in 20 s."""


@dataclass(frozen=True)
class Point:
    """Steady curve of one roll at one preload.

    Attributes
    ----------
    pressure, f_n, peak, zeta
        External pressure (Pa), resonance (Hz), largest transmissibility, damping ratio (half power).
    tip
        Largest amplitude of the tip, m.
    cycle_work
        Energy dissipated by friction in one cycle at the peak, J.
    sweep_work
        Estimate of the energy dissipated by friction in the thesis's chirp of 20 s, J.
    """

    pressure: float
    f_n: float
    peak: float
    zeta: float
    tip: float
    cycle_work: float
    sweep_work: float


@dataclass(frozen=True)
class Swept:
    """The thesis's chirp through one roll at one preload.

    Attributes
    ----------
    pressure, f_n, peak
        External pressure (Pa), resonance (Hz) and largest transmissibility of the demodulated envelope.
    tip, work
        Largest displacement of the tip, m, and energy dissipated by friction, J.
    """

    pressure: float
    f_n: float
    peak: float
    tip: float
    work: float

    @property
    def norm(self) -> float:
        """Equation 6.7, J s/m^2."""
        return self.work / self.tip**2 / self.f_n


Series = list[Point]


def point(member: StudyCase) -> Point:
    """Readings of a steady curve.

    A chirp of R octaves per second spends df/(R ln 2) cycles in the band df. Its friction work is therefore about the
    integral of the work per cycle over the frequency, divided by R ln 2, if it passes through steady states.
    """
    data, found = member.data, read(member)
    frequency, work = data["frequency"].values, data["friction_work_per_cycle"].values
    order = np.argsort(frequency, kind="stable")
    total = float(trapezoid(work[order], frequency[order])) / (OCTAVES_PER_SECOND * math.log(2.0))
    top = int(np.argmax(magnitude(data).values))
    tip = float(data["tip_amplitude"].values.max())
    return Point(float(member.values[PRESSURE]), found.f_n, found.peak, found.zeta, tip, float(work[top]), total)


def swept(member: StudyCase) -> Swept:
    """Readings of a chirp."""
    data, found = member.data, read(member)
    tip = float(np.abs(data["tip_displacement"].values).max())
    return Swept(float(member.values[PRESSURE]), found.f_n, found.peak, tip, friction_work(member))


def baseline(evidence: Evidence) -> dict[str, Series]:
    """Structure -> points in order of increasing preload.

    Raises
    ------
    InputError
        If a structure has fewer than three curves.
    """
    return grouped(evidence.finished(BASELINE)[0])


def chirps(evidence: Evidence) -> dict[str, list[Swept]]:
    """Structure -> chirps in order of increasing preload."""
    found: dict[str, list[Swept]] = {name: [] for name in NAMES.values()}
    for member in evidence.finished(CHIRPS)[0]:
        found[NAMES[member.values["case"]]].append(swept(member))
    return {name: sorted(line, key=lambda p: p.pressure) for name, line in found.items()}


def over(parameter: str, evidence: Evidence) -> dict[str, dict[float, Series]]:
    """Structure -> value of a parameter of `SENSITIVITY`, in increasing order -> points."""
    key, usual, studies = SENSITIVITY[parameter]
    members: dict[str, dict[float, list[StudyCase]]] = {name: {} for name in NAMES.values()}
    for study in (BASELINE, *studies):
        for member in evidence.finished(study)[0]:
            name = structure(study, member)
            value = usual if study == BASELINE else float(member.values[key])
            if parameter == "s" and study != BASELINE:
                value = round(value / THICKNESS[name], 6)
            members[name].setdefault(value, []).append(member)
    return {name: {value: series(name, lines[value]) for value in sorted(lines)} for name, lines in members.items()}


def structure(study: str, member: StudyCase | Member) -> str:
    """Name of the structure of a case; studies of one case file are named after it."""
    case = member.values.get("case", f"{study.rsplit('_', 1)[-1]}_friction")
    return NAMES[str(case)]


def points(members: Sequence[StudyCase]) -> Series:
    """Points with a damping ratio, in order of increasing preload."""
    return sorted((p for p in map(point, members) if math.isfinite(p.zeta)), key=lambda p: p.pressure)


def series(name: str, members: Sequence[StudyCase]) -> Series:
    """The `points` of a structure.

    Raises
    ------
    InputError
        If there are fewer than three.
    """
    found = points(members)
    if len(found) < 3:
        raise InputError(f"{name} has fewer than three curves", remedy="see the run folders of the study")
    return found


def grouped(members: Sequence[StudyCase]) -> dict[str, Series]:
    """Structure -> its points."""
    return {name: series(name, [m for m in members if m.values["case"] == case]) for case, name in NAMES.items()}


def missing(evidence: Evidence, study: str = BASELINE) -> str:
    """The cases of a study that have no curve, as text; empty if all have one."""
    parts = []
    for name in NAMES.values():
        own = [m for m in evidence.finished(study)[1] if structure(study, m) == name]
        if own:
            loads = sorted({1e-3 * float(m.values[PRESSURE]) for m in own})
            parts.append(f"{len(own)} of {name} at {numbers(loads, 'g')} kPa")
    return f"; without a curve ({study}): {', '.join(parts)}" if parts else ""


def missing_over(parameter: str, evidence: Evidence) -> str:
    """The cases of all values of a parameter that have no curve, as text."""
    return "".join(missing(evidence, study) for study in (BASELINE, *SENSITIVITY[parameter][2]))


def best(series: Series) -> Point:
    """Point of the largest damping."""
    return max(series, key=lambda p: p.zeta)


def inside(series: Series) -> bool:
    """Whether the largest damping is at neither end of the series."""
    return series[0].zeta < best(series).zeta > series[-1].zeta


def table_of(found: dict[str, Series], value: Callable[[Point], float], form: str) -> str:
    """One value of every point, as text."""
    return "; ".join(f"{name} {numbers(map(value, series), form)}" for name, series in found.items())


def panels(height: float = 3.0) -> list[Axes]:
    """One panel per structure, below each other."""
    _, found = plt.subplots(3, 1, figsize=(style.WIDTH, 3 * height), dpi=style.DPI, layout="constrained")
    return [style.axes(ax) for ax in found]
