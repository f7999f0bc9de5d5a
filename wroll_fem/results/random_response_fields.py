"""Names, units and labels of the variables of a random response of a backbone."""

from __future__ import annotations

from wroll_fem.results.field import Field

OF_RANDOM_RESPONSE: dict[str, Field] = {
    "tip_displacement_psd": Field("m2 s", "PSD of the tip displacement"),
    "amplitude_density": Field("m-1", "probability density of the tip amplitude"),
    "level_db": Field("dB", "level of the PSD relative to the case"),
    "base_rms_at_level": Field("m s-2", "rms of the base acceleration"),
    "tip_displacement_rms_at_level": Field("m", "rms of the tip displacement"),
    "tip_rms_at_level": Field("m s-2", "rms of the absolute tip acceleration"),
    "f_effective_at_level": Field("Hz", "mean frequency"),
    "zeta_effective_at_level": Field("1", "damping ratio from power and energy"),
    "dissipated_power_at_level": Field("W", "dissipated power"),
    "backbone_exceeded_at_level": Field("1", "part of the mean square beyond the backbone"),
    "other_frequency": Field("Hz", "natural frequency of another mode"),
    "other_damping": Field("1", "damping ratio of another mode"),
    "other_participation": Field("1", "participation of another mode at the tip"),
    "vibration_von_mises": Field("Pa", "largest von Mises stress of the vibration alone (0-peak)"),
}
"""Part of `dataset.FIELDS`: the spectra are those of `random`."""
