"""Case section `excitation`: motion of the base, one class per kind."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from wroll_fem.case.excitation.random import Psd, RandomExcitation, RandomSpectrum
from wroll_fem.case.excitation.shared import STANDARD_GRAVITY, AmplitudeSection, Direction
from wroll_fem.case.excitation.shocks import (
    SHOCK_KINDS,
    FileExcitation,
    HalfSineExcitation,
    SawtoothExcitation,
    ShockExcitation,
    Spectrum,
    SrsExcitation,
    TrapezoidExcitation,
)
from wroll_fem.case.excitation.sines import ChirpExcitation, DwellExcitation, SineExcitation

HistoryExcitation = ChirpExcitation | DwellExcitation | RandomExcitation | ShockExcitation
"""Motions of which a time history is computed. Each has `highest_frequency_hz` and `attributes`; the functions of time
are in `signals.motions`."""

Excitation = Annotated[
    ChirpExcitation | DwellExcitation | RandomSpectrum | ShockExcitation | SineExcitation, Field(discriminator="kind")
]

ANALYSIS_OF_MOTION = {
    "chirp": "sweep", "dwell": "dwell", "random": "random", **dict.fromkeys(SHOCK_KINDS, "shock"),
    "sine": "modal_transient",
}  # fmt: skip
"""Kind of base motion -> the analysis that messages suggest for it."""

__all__ = [
    "ANALYSIS_OF_MOTION", "SHOCK_KINDS", "STANDARD_GRAVITY", "AmplitudeSection", "ChirpExcitation", "Direction",
    "DwellExcitation", "Excitation", "FileExcitation", "HalfSineExcitation", "HistoryExcitation", "Psd",
    "RandomExcitation", "RandomSpectrum", "SawtoothExcitation", "ShockExcitation", "SineExcitation", "Spectrum",
    "SrsExcitation", "TrapezoidExcitation",
]  # fmt: skip
