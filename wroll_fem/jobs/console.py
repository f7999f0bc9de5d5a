"""Summary that `wroll run` prints at its end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wroll_fem.results.summary import SUMMARY


def summary_lines(summary: Mapping[str, Any]) -> list[str]:
    """Lines with the main results, one line per mode and one per warning; missing values are omitted."""
    found: list[tuple[str, str]] = []
    for key, entry in SUMMARY.items():
        value = summary.get(key)
        values = value if isinstance(value, list) else [value]
        if entry.console and values and None not in values:
            found.append((entry.label, ", ".join(entry.console.format(v) for v in values)))
        if key == "zeta" and summary.get("zeta_quality") == "invalid" and summary.get("zeta_apparent") is not None:
            found.append((entry.label, f"not stated (apparent value {summary['zeta_apparent']:.4f})"))
    modes, kinds = summary.get("modes_hz") or [], summary.get("mode_kinds") or []
    ratios = [f"zeta {ratio:.4f}" for ratio in summary.get("mode_damping_ratios") or []]
    for number, frequency in enumerate(modes, start=1):
        words = (part[number - 1] for part in (kinds, ratios) if number <= len(part))
        found.append((f"mode {number}", "  ".join((f"{frequency:.2f} Hz", *words))))
    width = max((len(name) for name, _ in found), default=0)
    warnings = [f"warning: {text}" for text in summary.get("warnings") or []]
    return [f"{name:<{width}}  {text}" for name, text in found] + warnings
