"""Signals: base motions, random records, spectra, transmissibility and damping estimates.

`wf.signals` has the functions of `_HOMES`, for use without a case; the modules of the folder have the rest.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wroll_fem.signals.attainment import rate_for_attainment, swept_peak
    from wroll_fem.signals.averaging.amplitude_process import AmplitudeDensity, NonlinearMode, amplitude_density
    from wroll_fem.signals.averaging.averaged_spectrum import LinearModes, ResponseSpectra, response_spectra
    from wroll_fem.signals.averaging.notching import factor_at_limit
    from wroll_fem.signals.random.psd import PsdTable
    from wroll_fem.signals.random.random_motion import random_record
    from wroll_fem.signals.random.welch import Spectra, averaged_spectra, rms_error, wanted_duration, wanted_resolution
    from wroll_fem.signals.shock.pulses import HalfSine, Sawtooth, Trapezoid
    from wroll_fem.signals.shock.spectrum import shock_spectrum
    from wroll_fem.signals.shock.synthesis import synthesise_shock
    from wroll_fem.signals.shock.table import SpectrumTable

_HOMES = {
    "rate_for_attainment": "attainment",
    "swept_peak": "attainment",
    "HalfSine": "shock.pulses",
    "Sawtooth": "shock.pulses",
    "Trapezoid": "shock.pulses",
    "shock_spectrum": "shock.spectrum",
    "synthesise_shock": "shock.synthesis",
    "SpectrumTable": "shock.table",
    "PsdTable": "random.psd",
    "random_record": "random.random_motion",
    "Spectra": "random.welch",
    "averaged_spectra": "random.welch",
    "rms_error": "random.welch",
    "wanted_duration": "random.welch",
    "wanted_resolution": "random.welch",
    "AmplitudeDensity": "averaging.amplitude_process",
    "NonlinearMode": "averaging.amplitude_process",
    "amplitude_density": "averaging.amplitude_process",
    "LinearModes": "averaging.averaged_spectrum",
    "ResponseSpectra": "averaging.averaged_spectrum",
    "response_spectra": "averaging.averaged_spectrum",
    "factor_at_limit": "averaging.notching",
}
"""Public name -> module, imported on first use."""

__all__ = [
    "AmplitudeDensity", "HalfSine", "LinearModes", "NonlinearMode", "PsdTable", "ResponseSpectra", "Sawtooth",
    "Spectra", "SpectrumTable", "Trapezoid", "amplitude_density", "averaged_spectra", "factor_at_limit",
    "random_record", "rate_for_attainment", "response_spectra", "rms_error", "shock_spectrum", "swept_peak",
    "synthesise_shock", "wanted_duration", "wanted_resolution",
]  # fmt: skip


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it has {', '.join(__all__)}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
