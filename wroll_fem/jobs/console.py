"""What `wroll run` says at its end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_LINES = (
    ("f_n_hz", "resonance f_n", "{:.2f} Hz"),
    ("zeta", "damping ratio zeta", "{:.4f}"),
    ("peak_transmissibility", "peak transmissibility", "{:.2f}"),
    ("transmissibility", "transmissibility", "{:.2f}"),
    ("slip_statement", "coil", "{}"),
    ("energy_balance_error", "energy balance error", "{:.2%}"),
    ("friction_energy_j", "friction energy", "{:.4g} J"),
    ("pressure_mandrel_pa", "pressure at the mandrel", "{:.4g} Pa"),
    ("pressure_mandrel_wrap_grid_pa", "same, source's grid", "{:.4g} Pa"),
    ("capacity_mandrel_pa", "capacity at the mandrel", "{:.4g} Pa"),
    ("mandrel_stiffness_pa", "mandrel stiffness", "{:.4g} Pa"),
    ("interface_pressure_mean_pa", "mean interface pressure", "{:.4g} Pa"),
    ("dofs", "degrees of freedom", "{:d}"),
    ("steps", "time steps", "{:d}"),
    ("wall_time_s", "wall time", "{:.1f} s"),
)
"""Key of summary.json, what is said, format."""


def closing_lines(summary: Mapping[str, Any]) -> list[str]:
    """Lines of the main results, then one for each mode; numbers that are missing are left out."""
    said = []
    for key, name, form in _LINES:
        value = summary.get(key)
        values = value if isinstance(value, list) else [value]
        if key in summary and values and None not in values:
            said.append(f"{name:<24} {', '.join(form.format(v) for v in values)}")
    modes, kinds = summary.get("modes_hz") or [], summary.get("mode_kinds") or []
    for number, frequency in enumerate(modes, start=1):
        kind = kinds[number - 1] if number <= len(kinds) else ""
        said.append(f"{f'mode {number}':<24} {frequency:.2f} Hz  {kind}".rstrip())
    return said
