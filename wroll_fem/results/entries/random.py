"""Entries of summary.json of the analysis random."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, number, share

RANDOM: dict[str, Entry] = {
    "psd_rms_m_s2": number("m/s²", "rms of the PSD", "of the case, in closed form, level included"),
    "base_rms_m_s2": number("m/s²", "rms of the base acceleration", "of the steady part", "{:.4g} m/s²"),
    "tip_rms_m_s2": number("m/s²", "rms of the absolute tip acceleration", "of the steady part", "{:.4g} m/s²"),
    "tip_3sigma_m_s2": number("m/s²", "3 sigma of the absolute tip acceleration"),
    "tip_displacement_rms_m": Entry(
        "m", "rms of the tip displacement", "relative to the base, steady part", console="{:.4g} m"
    ),
    "tip_displacement_3sigma_m": Entry("m", "3 sigma of the tip displacement"),
    "tip_rms_error": share(
        "standard error of the rms of the tip acceleration", "from the length of the record and its PSD"
    ),
    "tip_kurtosis": number("", "kurtosis of the tip acceleration", "3 for a Gaussian response"),
    "base_shear_rms_n": Entry("N", "rms of the base shear"),
    "base_shear_3sigma_n": Entry("N", "3 sigma of the base shear"),
    "base_moment_rms_nm": number("N m", "rms of the base moment"),
    "base_moment_3sigma_nm": number("N m", "3 sigma of the base moment"),
    "steady_start_s": Entry("s", "start of the steady part"),
    "psd_resolution_hz": number("Hz", "distance of the lines of the averaged spectra"),
    "psd_averages": number("", "independent averages of the spectra"),
    "psd_random_error": share("standard error of the PSDs"),
    "psd_peak_bias": share("part of the peak of a PSD that the resolution takes", "H1 is corrected for it"),
    "level_db": number("dB", "level", "of each history, relative to the PSD of the case; a list, as all entries below"),
    "seeds": Entry("", "seeds of the records"),
    "level_base_rms_m_s2": number("m/s²", "rms of the base acceleration", "per level"),
    "level_f_n_hz": number("Hz", "resonance frequency f_n", "per level, of all records"),
    "level_f_n_error_hz": number("Hz", "standard error of f_n", "per level"),
    "level_zeta": share("damping ratio zeta", "per level, of all records"),
    "level_zeta_error": share("standard error of zeta", "per level"),
    "level_zeta_quality": Entry("", "quality of zeta", "per level"),
    "level_tip_rms_m_s2": number("m/s²", "rms of the absolute tip acceleration", "per level, over all records"),
    "level_tip_rms_error": share("standard error of the rms of the tip acceleration", "per level"),
    "level_tip_displacement_rms_m": Entry("m", "rms of the tip displacement", "per level"),
    "level_base_shear_rms_n": Entry("N", "rms of the base shear", "per level"),
    "level_base_moment_rms_nm": number("N m", "rms of the base moment", "per level"),
    "level_friction_energy_j": Entry("J", "energy dissipated by friction in a record", "per level"),
    "level_max_slip_m": Entry("m", "largest relative displacement", "per level, of all records"),
    "level_max_accumulated_slip_m": Entry("m", "largest accumulated slip of a record", "per level, mean"),
}  # fmt: skip
"""Name -> entry, in the order of summary.json."""
