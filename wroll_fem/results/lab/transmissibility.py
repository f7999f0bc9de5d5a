"""Results of the laboratory evaluation `transmissibility`."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, Field, number, share

ENTRIES: dict[str, Entry] = {
    "base_motion": Entry("", "motion of the base", "`random` or `sweep`", "si", "{}"),
    "conditions": Entry("", "conditions", "a list, like all entries of this group", "si", "{}"),
    "trials": Entry("", "number of trials", "of each condition", "number", "{}"),
    "base_level_m_s2": number(
        "m/s²", "level of the base", "measured: rms inside the band (random), 0-peak at the resonance (sweep)",
        "{:.3g} m/s²",
    ),
    "tip_level_m_s2": number("m/s²", "level of the tip", "as that of the base"),
    "f_n_interval_hz": number(
        "Hz", "half width of the 95 % interval of f_n",
        "the larger of 1.96 standard errors and Student's interval of three or more trials", "{:.2g} Hz",
    ),
    "f_n_scatter_hz": number("Hz", "standard deviation of f_n over the trials", "`null` for one trial"),
    "zeta_interval": share("half width of the 95 % interval of zeta", "as that of f_n", "{:.2g}"),
    "zeta_scatter": share("standard deviation of zeta over the trials"),
}  # fmt: skip
"""Name in summary.json -> entry."""

_ACCELERATION = "m s-2"

FIELDS: dict[str, Field] = {
    "condition": Field("1", "condition"),
    "trial": Field("1", "trial"),
    "condition_name": Field("1", "label of the condition"),
    "tension": Field("N", "winding tension"),
    "nominal_level": Field(_ACCELERATION, "nominal base acceleration"),
    "base_level": Field(_ACCELERATION, "base acceleration (rms of random, 0-peak of sweep)"),
    "tip_level": Field(_ACCELERATION, "absolute tip acceleration (rms of random, 0-peak of sweep)"),
    "condition_f_n": Field("Hz", "resonance frequency of the condition"),
    "condition_zeta": Field("1", "damping ratio of the condition"),
    "condition_peak": Field("1", "peak transmissibility"),
    "zeta_grade": Field("1", "quality of the damping ratio of the condition"),
    "condition_f_n_error": Field("Hz", "standard error of the resonance frequency of the condition"),
    "condition_f_n_scatter": Field("Hz", "standard deviation of the resonance frequency over the trials"),
    "condition_f_n_interval": Field("Hz", "half width of the 95 % interval of the resonance frequency"),
    "condition_zeta_error": Field("1", "standard error of the damping ratio of the condition"),
    "condition_zeta_scatter": Field("1", "standard deviation of the damping ratio over the trials"),
    "condition_zeta_interval": Field("1", "half width of the 95 % interval of the damping ratio"),
    "trial_file": Field("1", "file of the trial"),
    "trial_condition": Field("1", "condition of the trial"),
    "trial_f_n": Field("Hz", "resonance frequency of the trial"),
    "trial_zeta": Field("1", "damping ratio of the trial"),
    "trial_base_level": Field(_ACCELERATION, "base acceleration of the trial"),
    "family_real": Field("1", "transmissibility of the condition, real part"),
    "family_imag": Field("1", "transmissibility of the condition, imaginary part"),
    "family_coherence": Field("1", "coherence of the condition"),
    "family_error": Field("1", "relative standard deviation of the transmissibility"),
}
"""Name in results.nc -> unit and label."""
