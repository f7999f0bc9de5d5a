"""Case section `integrator`: time integration."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from wroll_fem.case.base import Real, Section, _number, validation_error

MOST_STEPS_PER_CYCLE = 100_000

DEFAULT_STEPS = 40
"""Number of time steps per cycle for `auto`; the analysis of a dwell may choose more."""

SCHEME_ALPHA = {"transient_fidelity": -0.05, "moderate_dissipation": -0.41421, "no_damping": 0.0, "quasi_static": 0.0,
                "trigonometric": 0.0}  # fmt: skip
"""HHT parameter alpha of the named schemes (thesis, Table B.1); 0 for quasi_static, which is backward Euler, and for
trigonometric, which has no alpha."""


def _own_alpha(given: dict[str, Any]) -> float:
    """Default of alpha: the value of the named scheme, else the value of transient_fidelity."""
    return SCHEME_ALPHA.get(given.get("scheme", ""), SCHEME_ALPHA["transient_fidelity"])


class Integrator(Section):
    """Time integration: Hilber-Hughes-Taylor (HHT) scheme with alpha <= 0, backward Euler, or trigonometric."""

    scheme: Literal[
        "hht", "transient_fidelity", "moderate_dissipation", "no_damping", "quasi_static", "trigonometric"
    ] = Field(
        default="hht",
        description="hht uses alpha; transient_fidelity (-0.05), moderate_dissipation (-0.41421) and no_damping (0) "
        "are hht with that alpha; quasi_static is backward Euler; trigonometric propagates the modes of the sticking "
        "structure exactly (method reduced alone)",
    )  # fmt: skip
    alpha: Real = Field(
        default_factory=_own_alpha,
        ge=-0.41422,
        le=0,
        description="HHT parameter, dimensionless, between -0.41421 and 0 (0: no damping)",
    )
    steps_per_cycle: Literal["auto"] | Annotated[int, Field(ge=2, le=MOST_STEPS_PER_CYCLE)] = Field(
        default="auto",
        description="time steps per cycle of the highest excitation frequency (count, 2 or more); auto: 40, and 60 to "
        "160 for a dwell near the resonance of a roll, where HHT's period error would change the response by more "
        "than 5 %; for random 20 to 40, with 40 or more per cycle of the resonance of a roll",
    )

    follow_frequency: bool = Field(
        default=False,
        description="whether the steps of a sweep are longer by powers of two where its frequency is low: at least "
        "steps_per_cycle per cycle of the frequency at each time, and 16 per cycle of the main mode with stuck "
        "interfaces",
    )

    @field_validator("steps_per_cycle", mode="before")
    @classmethod
    def _count(cls, value: Any) -> Any:
        if value == "auto":
            return value
        number = _number(value)
        if not isinstance(number, int | float) or not 2 <= number <= MOST_STEPS_PER_CYCLE or number != int(number):
            problem = f"must be auto or a whole number from 2 to {MOST_STEPS_PER_CYCLE}"
            raise validation_error(problem, remedy="write for example 80", value=value)
        return int(number)

    @property
    def steps(self) -> int:
        """Number of time steps per cycle. For `auto` it is `DEFAULT_STEPS`; the analysis of a dwell may use more."""
        return DEFAULT_STEPS if self.steps_per_cycle == "auto" else self.steps_per_cycle

    @model_validator(mode="after")
    def _alpha_of_scheme(self) -> Self:
        """Refuse an alpha that differs from the alpha of the scheme."""
        own = _own_alpha({"scheme": self.scheme})
        if self.scheme in SCHEME_ALPHA and abs(self.alpha - own) > 1e-5:
            remedy = f"leave alpha out (it is {own:g} here) or use scheme: hht"
            raise validation_error(
                f"scheme {self.scheme} has a fixed alpha", key="alpha", value=self.alpha, remedy=remedy
            )
        return self
