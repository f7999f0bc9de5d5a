"""Case classes of the time histories: sweep, dwell, random and shock, each for a roll and for matrices from a file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from wroll_fem.case.case import Check, case_kind
from wroll_fem.case.checks import check_motion, check_steps
from wroll_fem.case.checks_random import check_duration
from wroll_fem.case.checks_scheme import check_hyper_reduction, check_scheme
from wroll_fem.case.excitation import (
    SHOCK_KINDS,
    ChirpExcitation,
    DwellExcitation,
    HistoryExcitation,
    RandomExcitation,
    ShockExcitation,
)
from wroll_fem.case.output import Output
from wroll_fem.case.structural import EXCITATION, OnRoll, OnStructure, StructuralCase

ANALYSIS = "what to compute"


def motion(analysis: str, *wanted: str) -> BeforeValidator:
    """Validator that refuses kinds of base motion which an analysis cannot use."""

    def check(value: Any) -> Any:
        check_motion(value, analysis, *wanted)
        return value

    return BeforeValidator(check)


class HistoryCase(StructuralCase):
    """Time history of the response to a motion of the base."""

    excitation: HistoryExcitation = Field(description=EXCITATION)

    def _checks(self) -> Iterator[Check]:
        yield from super()._checks()
        yield lambda: check_steps(self.excitation, self.integrator, self.solver)
        yield lambda: check_scheme(self.integrator, self.solver)
        yield lambda: check_hyper_reduction(
            self.solver, self.excitation, inside=isinstance(self, OnRoll) and self.coil.slips
        )


class SweepCase(HistoryCase):
    """Time history of the response to a sine sweep of the base."""

    analysis: Literal["sweep"] = Field(description=ANALYSIS)
    excitation: Annotated[ChirpExcitation, motion("sweep", "chirp")] = Field(description=EXCITATION)


@case_kind
class RollSweepCase(SweepCase, OnRoll):
    """Sine sweep of a roll."""


@case_kind
class StructureSweepCase(SweepCase, OnStructure):
    """Sine sweep of a structure whose matrices come from a file."""


class DwellCase(HistoryCase):
    """Time history of the response to sine motion of the base at one frequency."""

    analysis: Literal["dwell"] = Field(description=ANALYSIS)
    excitation: Annotated[DwellExcitation, motion("dwell", "dwell")] = Field(description=EXCITATION)


@case_kind
class RollDwellCase(DwellCase, OnRoll):
    """Dwell of a roll."""


@case_kind
class StructureDwellCase(DwellCase, OnStructure):
    """Dwell of a structure whose matrices come from a file."""


def _by_fit(output: Output) -> Output:
    """Section `output` with the rational fraction as estimator, unless it names one: H1 has noise, and a phase."""
    if "damping" in output.model_fields_set:
        return output
    changed = output.model_copy()
    changed.__dict__["damping"] = "rational_fraction"  # still counts as left out: another analysis has its own default
    return changed


def _output_with_fit() -> Output:
    return _by_fit(Output())


class RandomCase(HistoryCase):
    """Time history of the response to a random motion of the base, with its spectra."""

    analysis: Literal["random"] = Field(description=ANALYSIS)
    excitation: Annotated[RandomExcitation, motion("random", "random")] = Field(description=EXCITATION)
    output: Annotated[Output, AfterValidator(_by_fit)] = Field(
        default_factory=_output_with_fit, description="what a run writes"
    )

    def _checks(self) -> Iterator[Check]:
        yield from super()._checks()
        yield lambda: check_duration(self.excitation, roll=isinstance(self, OnRoll))


@case_kind
class RollRandomCase(RandomCase, OnRoll):
    """Random motion of a roll."""


@case_kind
class StructureRandomCase(RandomCase, OnStructure):
    """Random motion of a structure whose matrices come from a file."""


class ShockCase(HistoryCase):
    """Time history of the response to a shock of the base, and the free vibration after it."""

    analysis: Literal["shock"] = Field(description=ANALYSIS)
    excitation: Annotated[Annotated[ShockExcitation, Field(discriminator="kind")], motion("shock", *SHOCK_KINDS)] = (
        Field(description=EXCITATION)
    )


@case_kind
class RollShockCase(ShockCase, OnRoll):
    """Shock of a roll."""


@case_kind
class StructureShockCase(ShockCase, OnStructure):
    """Shock of a structure whose matrices come from a file."""
