"""Tables of the simulated shaker tests of chapter 3 (docs/chapter3.md), from the studies of `wroll reproduce ch3`.

Usage: python -m tools.shaker_table runs/reproduce [--fast]
"""

from __future__ import annotations

import sys

from reproduction import camera_slip, shaker_random, shaker_shock, shaker_sweeps
from reproduction.evidence import Evidence
from reproduction.words import numbers, table


def pressed(pressure: float) -> str:
    """External pressure (kPa) as text."""
    return f"{pressure:.3g} kPa" if pressure else "mandrel alone"


def sweeps(evidence: Evidence) -> str:
    """Sweeps and shocks over the preload."""
    rows = []
    for one, hit in zip(shaker_sweeps.readings(evidence), shaker_shock.responses(evidence), strict=True):
        lab = f"{one.f_lab:.1f} Hz, {100 * one.zeta_lab:.2f} %" if one.zeta_lab == one.zeta_lab else "refused: too fast"
        sweep = f"{one.f_n:.1f} Hz, {100 * one.zeta:.2f} %, {one.peak:.1f}, {one.skew:.2f}"
        shock = f"{hit.spectrum.max():.2f} m/s at {hit.f_peak:.1f} Hz, {1e3 * hit.fade:.0f} ms"
        rows.append((pressed(one.pressure), sweep, lab, shock))
    head = (
        "external pressure", "sweep, spectra: f_n, zeta, peak, SK", "sweep, demodulated: f_n, zeta",
        "shock: peak of the spectrum, time to a tenth",
    )  # fmt: skip
    return table(head, rows)


def levels(evidence: Evidence) -> str:
    """Random motion over the level."""
    series = shaker_random.readings(evidence)
    rows = [
        (f"{level:.3g}", *(f"{s.f_n[k]:.1f} Hz, {100 * s.zeta[k]:.2f} %, {s.tip[k]:.0f} m/s²" for s in series))
        for k, level in enumerate(series[0].level)
    ]
    return table(("level", *(f"{s.name}: f_n, zeta, tip rms" for s in series)), rows)


def slips(evidence: Evidence) -> str:
    """Vertical slip to the mandrel per group, largest of the wraps."""
    rows = [
        (f"{name}, {face} face", numbers(1e6 * view.over_groups(view.vertical), ".1f"), f"{1e6 * view.floor:.1f}")
        for name, faces in zip(camera_slip.ROLLS.values(), camera_slip.seen(evidence), strict=True)
        for face, view in faces.items()
    ]
    return table(("roll and face", "vertical slip of groups 1, 2, 3, µm", "noise floor, µm"), rows)


def main(folder: str, *, fast: bool) -> None:
    """Print the tables."""
    with Evidence(folder, fast=fast) as evidence:
        print("\n\n".join(part(evidence) for part in (sweeps, levels, slips)))


if __name__ == "__main__":
    main(sys.argv[1], fast="--fast" in sys.argv[2:])
