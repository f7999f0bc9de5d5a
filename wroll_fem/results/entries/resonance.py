"""Entries of summary.json of a resonance curve, and of the downward branch of a sweep up and down."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, number, share

RESONANCE: dict[str, Entry] = {
    "f_n_hz": number(
        "Hz", "resonance frequency f_n", "frequency of the peak; `null` without a maximum in the band", "{:.2f} Hz"
    ),
    "zeta": share(
        "damping ratio zeta",
        "(f2 - f1)/(2 f_n) by default; `null` where a half-power point lies outside the band", "{:.4f}",
    ),
    "zeta_quality": Entry(
        "", "quality of zeta", "`ok`, `doubtful` or `invalid`; zeta is `null` if it is invalid", "si", "{}"
    ),
    "zeta_doubts": Entry("", "reasons for the quality of zeta", "a list, worst first; also among the warnings"),
    "zeta_apparent": share("apparent damping ratio", "the estimate, whatever its quality"),
    "zeta_spread": share("distance of zeta to that from the spectra of the sweep", "relative"),
    "zeta_method": Entry("", "method of zeta", "estimator (`output.damping`) and curve"),
    "half_power_reason": Entry(
        "", "reason for a missing reading", "why f_n or zeta is `null`, or what makes zeta doubtful; else empty"
    ),
    "zeta_material": share(
        "zeta due to material damping",
        "work of material damping, divided by 4 pi times the kinetic energy: at the peak (harmonic), between the "
        "half-power frequencies (sweep), at zeta_max (backbone); share of the energy lost in the decay (shock)",
        "{:.4f}",
    ),
    "zeta_friction": share("zeta due to friction", "the rest of zeta", "{:.4f}"),
    "zeta_error": share("standard error of zeta", "of estimators that have one"),
    "zeta_lower_bound": share("zeta, lower end of its error bar"),
    "zeta_misfit": share("distance of fit and curve, divided by the peak"),
    "zeta_reason": Entry("", "reason for this method"),
    "f_n_error_hz": number("Hz", "standard error of f_n"),
    "peak_transmissibility": number(
        "", "peak transmissibility", "|A_tip + A_g|/|A_g|; of the displacements with two_dof", "{:.2f}"
    ),
    "half_power_low_hz": number("Hz", "lower half-power frequency", "f1, where T is its peak divided by sqrt 2"),
    "half_power_high_hz": number("Hz", "upper half-power frequency", "f2"),
    "stuck_resonance_hz": number("Hz", "resonance frequency with sticking interfaces", "of the main mode"),
    "tip_participation": number(
        "", "participation of the main mode at the tip", "T is this value divided by twice the damping ratio"
    ),
    "skewness": number("", "skewness of the peak", "(f2 - f_n)/(f_n - f1) - 1; positive: long tail to the right"),
}  # fmt: skip
"""Name -> entry, in the order of summary.json."""

_OF_THE_RUN = ("stuck_resonance_hz", "tip_participation", "zeta_reason", "zeta_spread")
_OF_THE_CURVE = [name for name in RESONANCE if name not in _OF_THE_RUN]

DOWNWARD: dict[str, Entry] = {
    f"down_{name}": RESONANCE[name]._replace(label=f"{RESONANCE[name].label}, downward", sentence="")
    for name in _OF_THE_CURVE
} | {
    "down_sweep_attainment": share("part of the steady peak that the downward sweep reaches"),
    "down_time_step_error": share("estimated error by the time step, downward"),
}
"""The same of the downward branch. The entries without prefix belong to the upward branch."""
