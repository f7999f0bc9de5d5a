"""Entries of summary.json of a random response of a backbone; those of `random` have the same names."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, number, share

RANDOM_RESPONSE: dict[str, Entry] = {
    "f_effective_hz": number("Hz", "mean frequency", "mean number of cycles per second", "{:.2f} Hz"),
    "zeta_effective": share(
        "effective damping ratio",
        "dissipated power divided by 2 omega E, E: mean of twice the kinetic energy",
        "{:.4f}",
    ),
    "tip_amplitude_exceeded_m": Entry("m", "tip amplitude exceeded by 1.1 % of the cycles", "3 sigma if Gaussian"),
    "dissipated_power_w": Entry("W", "mean dissipated power"),
    "friction_power_w": Entry("W", "mean power dissipated by friction"),
    "power_balance_error": share("difference of mean input and dissipated power", "relative"),
    "slip_rms_m": Entry("m", "rms of the relative displacement", "per interface, where its amplitude is largest"),
    "von_mises_rms_pa": Entry(
        "Pa", "rms of the von Mises stress of the vibration", "per shell, where it is largest; without the preload"
    ),
    "backbone_exceeded": share("part of the mean square beyond the backbone", "of the tip displacement"),
    "averaging_quality": Entry(
        "", "quality of the averaging", "`ok`, `doubtful` or `invalid`, of all entries of this group", "si", "{}"
    ),
    "averaging_doubts": Entry("", "reasons for this quality", "a list, worst first; also among the warnings"),
    "averaging_time_s": Entry("s", "CPU time without the backbone", "levels and limits included"),
    "levels_db": number("dB", "levels", "of the PSD, relative to the case"),
    "tip_displacement_rms_at_level_m": Entry("m", "rms of the tip displacement per level"),
    "tip_rms_at_level_m_s2": number("m/s²", "rms of the absolute tip acceleration per level"),
    "f_effective_at_level_hz": number("Hz", "mean frequency per level"),
    "zeta_effective_at_level": share("effective damping ratio per level"),
    "level_at_limit_db": number("dB", "level at each limit", "relative to the case"),
    "backbone_exceeded_at_limit": share("part of the mean square beyond the backbone, at each limit"),
    "allowed_level_db": number("dB", "allowed level", "the lowest of them", "{:+.2f} dB"),
    "allowed_base_rms_m_s2": number("m/s²", "rms of the base acceleration at the allowed level"),
    "limiting_response": Entry("", "response that reaches its limit first"),
}
"""Group of `summary.GROUPS`."""
