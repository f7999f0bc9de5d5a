"""Lab roll with a guided base of its layers: an axial spring between the free and the clamped ring (C60, C74, C89)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.constants import g as GRAVITY

from reproduction.evidence import Evidence
from reproduction.layer_slip import AMPLITUDE, areas, outer_slips
from reproduction.words import numbers, table
from wroll_fem.plotting.study import PRESSURE, StudyCase, read

STUDY, DWELLS, THESIS = "base_spring", "dwell_layers_spring", "layer_modulus_thesis"
LEVEL = 5.0
"""Base acceleration at which the resonance is read, m/s^2, 0-peak."""
STIFFNESS, MODULUS = "coil.base_stiffness", "coil.material.E"


def stiffnesses(members: Sequence[StudyCase]) -> list[float]:
    """Axial stiffnesses of a study, ascending, N/m per m of the ring."""
    return sorted({float(m.values[STIFFNESS]) for m in members})


def over_preload(members: Sequence[StudyCase], stiffness: float, modulus: float) -> list[StudyCase]:
    """Cases with one stiffness (N/m^2) and layer modulus (Pa), in order of increasing preload."""
    own = [m for m in members if m.values[STIFFNESS] == stiffness and m.values[MODULUS] == modulus]
    return sorted(own, key=lambda m: float(m.values[PRESSURE]))


def resonance_at(member: StudyCase) -> float:
    """Resonance (Hz) of a backbone at `LEVEL`, or at its largest amplitude if it needs less there."""
    data = member.data
    base, f = data["resonant_base_acceleration"].values, data["resonance_frequency"].values
    above = np.flatnonzero(base >= LEVEL)
    return float(f[above[0]] if above.size else f[-1])


def span(members: Sequence[StudyCase]) -> float:
    """Difference of the largest and the smallest resonance over the preload, Hz; nan with fewer than two cases."""
    f = [resonance_at(m) for m in members]
    return max(f) - min(f) if len(f) > 1 else math.nan


def largest_zeta(members: Sequence[StudyCase]) -> float:
    """Largest modal damping of the backbones over the preload; nan without a case."""
    return max((float(m.data.attrs["zeta_max"]) for m in members), default=math.nan)


def lost(members: Sequence[StudyCase]) -> str:
    """How many cases of the study are missing, as text; empty if none."""
    sizes = [len({m.values[key] for m in members}) for key in (STIFFNESS, MODULUS, PRESSURE)]
    missing = math.prod(sizes) - len(members)
    return f" ({missing} of {math.prod(sizes)} cases not finished)" if missing else ""


def spans_text(evidence: Evidence) -> str:
    """Span of f_n over the preload for every stiffness, as text (C60)."""
    members = evidence.study(STUDY)
    softest = min(float(m.values[MODULUS]) for m in members)
    every = stiffnesses(members)
    spans = [span(over_preload(members, k, softest)) for k in every]
    return (
        f"guided base, {numbers(every, 'g')} N/m^2 along the axis: f_n spans {numbers(spans, '.1f')} Hz{lost(members)}"
    )


def damping_text(evidence: Evidence) -> str:
    """Largest damping at both moduli for every stiffness, as text (C89)."""
    members = evidence.study(STUDY)
    every, moduli = stiffnesses(members), sorted({float(m.values[MODULUS]) for m in members})
    said = []
    for modulus in moduli:
        zeta = [100 * largest_zeta(over_preload(members, k, modulus)) for k in every]
        said.append(f"{numbers(zeta, '.2f')} % at {1e-9 * modulus:g} GPa")
    return f"guided base, {numbers(every, 'g')} N/m^2: largest zeta {', '.join(said)}{lost(members)}"


def thesis_text(evidence: Evidence) -> str:
    """Largest damping over the preload with the settings of the thesis, as text (C89)."""
    members = evidence.study(THESIS)
    moduli = sorted({float(m.values[MODULUS]) for m in members})
    zeta = []
    for modulus in moduli:
        found = [read(m).zeta for m in members if m.values[MODULUS] == modulus]
        zeta.append(100 * max((z for z in found if math.isfinite(z)), default=math.nan))
    rings = any(read(m).rings for m in members)
    remark = " (they ring: half power reads a ripple)" if rings else ""
    return f"settings of the thesis, base clamped: {numbers(zeta, '.2f')} %{remark}"


def second_interface_text(evidence: Evidence) -> str:
    """Slip of the second interface for every stiffness, as text (C74)."""
    members = sorted(evidence.study(DWELLS), key=lambda m: float(m.values[STIFFNESS]))
    slip = [1e6 * float(outer_slips(m)[1]) for m in members]
    area = [1e4 * float(areas(m)[1]) for m in members]
    level = float(members[0].values[AMPLITUDE]) / GRAVITY
    return (
        f"guided base, {numbers(stiffnesses(members), 'g')} N/m^2, {level:.3g} g: interface 2 moves by "
        f"{numbers(slip, '.2f')} um and slips on {numbers(area, '.0f')} cm^2"
    )


def spring_table(evidence: Evidence) -> str:
    """Table over the axial stiffness: f_n and damping over the preload at both moduli, slip of interface 2 at 3 g."""
    members = evidence.study(STUDY)
    dwells = {float(m.values[STIFFNESS]): m for m in evidence.study(DWELLS)}
    moduli = sorted({float(m.values[MODULUS]) for m in members})
    head = ["axial spring, N/m^2"]
    for modulus in moduli:
        head += [f"f_n, Hz, {1e-9 * modulus:g} GPa", "largest zeta, %"]
    rows = []
    for k in stiffnesses(members):
        cells = [f"{k:g}"]
        for modulus in moduli:
            own = over_preload(members, k, modulus)
            cells += [numbers((resonance_at(m) for m in own), ".1f"), f"{100 * largest_zeta(own):.2f}"]
        found = dwells.get(k)
        cells.append("" if found is None else f"{1e6 * np.max(outer_slips(found)[1]):.2f}")
        rows.append(cells)
    return table((*head, "interface 2 at 3 g, um"), rows)
