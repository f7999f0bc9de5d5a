"""Do the analyses of a random roll agree? Verdicts on the reports of `random_rolls`, and their page.

A sweep and a harmonic curve of the same roll and level agree when f_n differs by at most `FREQUENCY` and the peak by at
most `PEAK`; a dwell and the harmonic curve at its frequency by `PEAK`. A disagreement is explained when a run printed a
warning of one of `REASONS`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import isfinite
from typing import Any

import numpy as np

FREQUENCY, PEAK, ZETA = 0.01, 0.05, 0.1
"""Largest relative differences of f_n, of the peak or a dwell's magnitude, and of a zeta whose quality is ok."""

REASONS = {
    "sweep too fast": "ISO 7626-2 limit",
    "time step": "the time step changes",
    "not steady": "the dwell is not steady",
    "undamped": "grows beyond",
    "internal resonance": "internal resonances",
    "neglected harmonic": "harmonic is neglected",
    "mode at a harmonic": "friction may drive it",
    "several motions": "several periodic motions",
    "no resonance in the band": "no resonance inside",
    "band cut off": "no half-power point",
    "reduction error": "estimated error of the reduced model",
    "hysteresis": "hysteresis is not periodic",
    "opening": "surfaces open",
    "energy": "energy balance error",
}
"""Reason of a disagreement -> words of the warning that names it."""

EARLY = "the backbone ends at"

Report = Mapping[str, Any]


def reasons(*reports: Report) -> list[str]:
    """Reasons that the warnings of these runs name."""
    text = "\n".join(line for report in reports for line in report.get("warnings", ()))
    return [name for name, words in REASONS.items() if words in text]


def verdict(name: str, harmonic: Report, other: Report) -> dict[str, Any] | None:
    """Comparison of a sweep, slow sweep or dwell with the harmonic curve; None where one of them has no result.

    Returns
    -------
    dict
        `differences` in per cent (f_n and peak, or magnitude; nan without a reading on one side), `verdict` ("agree",
        "explained", "not explained") and `why`.
    """
    if harmonic.get("outcome") != "curve" or other.get("outcome") != "curve":
        return None
    if name == "dwell":
        limits, pairs = [PEAK], [(at_dwell(harmonic, other), other.get("steady_magnitude", np.nan))]
    else:
        limits = [FREQUENCY, PEAK]
        pairs = [(harmonic.get(key), other.get(key)) for key in ("f_n_hz", "peak_transmissibility")]
    change = [b / a - 1.0 if a and b and isfinite(a) and isfinite(b) else np.nan for a, b in pairs]
    none = all(value is None or not isfinite(value) for pair in pairs for value in pair)
    found = reasons(other) + [name for name in reasons(harmonic) if name not in reasons(other)]
    if none or all(abs(c) <= limit for c, limit in zip(change, limits, strict=True)):
        result = "agree"
    else:
        result = "explained" if found else "not explained"
    return {"differences": [100.0 * c for c in change], "verdict": result, "why": found}


def at_dwell(harmonic: Report, dwell: Report) -> float:
    """|T| of the harmonic curve at the frequency of a dwell; nan outside it, or where it has several motions."""
    frequency = dwell.get("frequency_hz", np.nan)
    f, size = np.asarray(harmonic["curve_hz"]), np.asarray(harmonic["curve_magnitude"])
    passes = np.flatnonzero(np.diff(f >= frequency))
    if len(f) < 5 or len(passes) != 1:
        return float("nan")
    part = slice(passes[0], passes[0] + 2)
    order = np.argsort(f[part])
    return float(np.exp(np.interp(frequency, f[part][order], np.log(size[part][order]))))


def agreement(reports: Iterable[Report]) -> dict[str, list[dict[str, Any]]]:
    """Comparison name -> verdicts of all rolls that have it; each with its roll."""
    found: dict[str, list[dict[str, Any]]] = {"slow": [], "sweep": [], "dwell": []}
    by_roll: dict[int, dict[str, Report]] = {}
    for report in reports:
        by_roll.setdefault(report["roll"], {})[report["analysis"]] = report
    for roll, runs in sorted(by_roll.items()):
        for name, verdicts in found.items():
            if name in runs and "harmonic" in runs:
                one = verdict(name, runs["harmonic"], runs[name])
                if one is not None:
                    verdicts.append({"roll": roll} | one)
    return found


def agreement_lines(reports: Iterable[Report]) -> list[str]:
    """Table of the agreement, and one line per disagreement that is not explained."""
    label = {"slow": "slow sweep", "sweep": "sweep of 600 cycles", "dwell": "dwell"}
    lines = [
        "| against harmonic | compared | agree | explained by a warning | not explained | the warnings |",
        "|---|---|---|---|---|---|",
    ]
    rest = []
    for name, verdicts in agreement(reports).items():
        counts = [sum(v["verdict"] == kind for v in verdicts) for kind in ("agree", "explained", "not explained")]
        named = [why for v in verdicts if v["verdict"] == "explained" for why in v["why"]]
        why = ", ".join(f"{named.count(one)} {one}" for one in REASONS if one in named)
        lines.append(f"| {label[name]} | {len(verdicts)} | {counts[0]} | {counts[1]} | {counts[2]} | {why} |")
        for v in verdicts:
            if v["verdict"] == "not explained":
                size = " and ".join(f"{d:+.2g} %" for d in v["differences"])
                rest.append(f"- roll {v['roll']}, {label[name]}: {size}")
    return lines + (["", "Not explained (f_n and peak, or magnitude):", "", *rest] if rest else [])


def quality_lines(reports: Iterable[Report]) -> list[str]:
    """Table of the quality of zeta: how far each grade of a sweep differs from harmonic balance."""
    by_roll: dict[int, dict[str, Report]] = {}
    for report in reports:
        by_roll.setdefault(report["roll"], {})[report["analysis"]] = report
    lines = [
        "| against harmonic | quality of zeta, harmonic | sweep | rolls | zeta apart: median, 90 % below, largest |",
        "|---|---|---|---|---|",
    ]
    far = []
    for name, label in (("slow", "slow sweep"), ("sweep", "sweep of 600 cycles")):
        found: dict[tuple[str, str], list[float]] = {}
        for roll, runs in sorted(by_roll.items()):
            pair = [runs.get(kind, {}) for kind in ("harmonic", name)]
            grades = tuple(str(run.get("zeta_quality", "")) for run in pair)
            zeta = [run.get("zeta_apparent") or np.nan for run in pair]
            if "" in grades:
                continue
            change = abs(zeta[1] / zeta[0] - 1.0)
            found.setdefault(grades, []).append(change)  # type: ignore[arg-type]
            if set(grades) == {"ok"} and not change <= ZETA:
                far.append(f"- roll {roll}, {label}: {100 * zeta[0]:.3g} and {100 * zeta[1]:.3g} %")
        for (steady, swept), changes in sorted(found.items()):
            known = np.array([c for c in changes if isfinite(c)])
            sizes = (
                [f"{100 * q:.2g} %" for q in (*np.quantile(known, [0.5, 0.9]), known.max())] if known.size else ["none"]
            )
            lines.append(f"| {label} | {steady} | {swept} | {len(changes)} | {', '.join(sizes)} |")
    return lines + (["", "Called ok on both sides, and apart by more than 10 %:", "", *far] if far else [])


def outcome_lines(reports: Iterable[Report], analyses: Iterable[str]) -> list[str]:
    """Table of the outcomes of each analysis, with the share that ends well and the CPU seconds."""
    kinds = ("curve", "told", "late", "stopped", "limit", "crash")
    lines = [
        "| analysis | cases | " + " | ".join(kinds) + " | end well | CPU s: median, 95 % below, largest |",
        "|---|---|" + "---|" * len(kinds) + "---|---|",
    ]
    everything = list(reports)
    for analysis in analyses:
        mine = [r for r in everything if r["analysis"] == analysis]
        if not mine:
            continue
        outcomes = [r["outcome"] for r in mine]
        good = 100.0 * sum(name in ("curve", "told") for name in outcomes) / len(mine)
        seconds = np.array([r["seconds"] for r in mine])
        cost = f"{np.median(seconds):.1f}, {np.percentile(seconds, 95):.1f}, {seconds.max():.1f}"
        counts = " | ".join(str(outcomes.count(kind)) for kind in kinds)
        lines.append(f"| {analysis} | {len(mine)} | {counts} | {good:.1f} % | {cost} |")
    early = sum(any(EARLY in text for text in r.get("warnings", ())) for r in everything)
    return lines + (
        ["", f"{early} of the backbones end before their largest amplitude, with the cause."] if early else []
    )
