"""Entries of summary.json of the analysis shock."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, number, share

SHOCK: dict[str, Entry] = {
    "tip_peak_m_s2": number("m/s²", "largest absolute tip acceleration", console="{:.4g} m/s²"),
    "tip_displacement_peak_m": Entry("m", "largest tip displacement", "relative to the base"),
    "base_peak_m_s2": number("m/s²", "largest base acceleration", "at the time steps"),
    "shock_end_s": Entry("s", "end of the shock", "the free vibration starts there"),
    "velocity_change_m_s": number("m/s", "velocity change of the base"),
    "srs_q": number("", "quality factor of the shock response spectra", "Q = 1/(2 zeta)"),
    "decay_f_hz": number(
        "Hz", "frequency of the decay", "of the tip, from its largest amplitude after the shock to half of it",
        "{:.2f} Hz",
    ),
    "decay_zeta": share(
        "damping ratio of the decay",
        "logarithmic decrement of the tip, from its largest amplitude after the shock to half of it; its quality "
        "is `zeta_quality`",
        "{:.4f}",
    ),
    "decay_zeta_numerical": share("part of it due to the integration scheme"),
    "decay_amplitude_start_m": Entry("m", "largest amplitude of the decay (0-peak)", "where the decay is read"),
    "decay_amplitude_end_m": Entry("m", "smallest amplitude of the decay (0-peak)"),
}  # fmt: skip
"""Name -> entry, in the order of summary.json."""
