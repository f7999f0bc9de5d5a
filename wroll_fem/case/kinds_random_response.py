"""Case classes of the analysis random_response; `kinds` registers them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from wroll_fem.case.excitation import RandomSpectrum
from wroll_fem.case.harmonic import Backbone, Harmonic
from wroll_fem.case.kinds_history import ANALYSIS, motion
from wroll_fem.case.random_response import RandomResponse
from wroll_fem.case.structural import (
    BACKBONE,
    EXCITATION,
    HARMONIC,
    RANDOM_RESPONSE,
    OnRoll,
    OnStructure,
    StructuralCase,
)


class RandomResponseCase(StructuralCase):
    """Random vibration from a backbone: response at levels of the base, and levels at limits."""

    analysis: Literal["random_response"] = Field(description=ANALYSIS)
    excitation: Annotated[RandomSpectrum, motion("random_response", "random")] = Field(description=EXCITATION)
    harmonic: Harmonic = Field(default_factory=Harmonic, description=HARMONIC)
    backbone: Backbone = Field(default_factory=Backbone, description=BACKBONE)
    random_response: RandomResponse = Field(default_factory=RandomResponse, description=RANDOM_RESPONSE)


class RollRandomResponseCase(RandomResponseCase, OnRoll):
    """Random vibration of a roll from its backbone."""


class StructureRandomResponseCase(RandomResponseCase, OnStructure):
    """Random vibration of a structure whose matrices come from a file, from its backbone."""
