"""Claim on a coefficient of friction that increases with the slip rate: C125."""

from __future__ import annotations

import numpy as np

from reproduction.claim_group import ClaimGroup, study_figure
from reproduction.evidence import Evidence
from reproduction.verdict import Verdict
from wroll_fem.plotting.study import PRESSURE, is_sweep, read
from wroll_fem.results.resonance import Resonance


def c125(evidence: Evidence) -> Verdict:
    files: dict[float, dict[str, Resonance]] = {}
    for m in evidence.study("friction_laws"):
        if is_sweep(m):
            files.setdefault(float(m.values[PRESSURE]), {})[m.values["case"]] = read(m)
    pairs = [(pair["lab_sweep"], pair["lab_sweep_rate"]) for pair in files.values() if len(pair) == 2]
    worst = np.max([[abs(b.f_n / a.f_n - 1), abs(b.peak / a.peak - 1), abs(b.zeta / a.zeta - 1)] for a, b in pairs], 0)
    friction = evidence.roll("lab_sweep_rate").friction
    value = (
        f"largest change over {len(pairs)} preloads: f_n {100 * worst[0]:.2f} %, T_pk {100 * worst[1]:.1f} %, "
        f"zeta {100 * worst[2]:.1f} %; mu(V) used: {friction.model_dump(exclude_unset=True)}"
    )
    holds = len(pairs) == len(files) and worst[0] <= 0.01 and worst[1] <= 0.1 and worst[2] <= 0.1
    return Verdict(value, bool(holds))


GROUP = ClaimGroup(
    {"C125": c125},
    figures={
        "ch4_friction_laws": (
            "Fig E.25: transmissibility with constant and with rate-dependent friction",
            study_figure("friction_laws"),
        )
    },
    studies=("friction_laws",),
)
