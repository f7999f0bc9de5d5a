"""Case section `integrator`: time integration."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import Field, model_validator

from wroll_fem.case.base import Real, Section, Whole, validation_error

SCHEME_ALPHA = {"transient_fidelity": -0.05, "moderate_dissipation": -0.41421, "no_damping": 0.0, "quasi_static": 0.0}
"""Alpha of the named schemes (thesis, Table B.1); quasi_static is backward Euler, without alpha."""


def _own_alpha(given: dict[str, Any]) -> float:
    """Default of alpha: the value of the named scheme, else the value of transient_fidelity."""
    return SCHEME_ALPHA.get(given.get("scheme", ""), SCHEME_ALPHA["transient_fidelity"])


class Integrator(Section):
    """Hilber-Hughes-Taylor integration, alpha <= 0, or backward Euler (quasi_static)."""

    scheme: Literal["hht", "transient_fidelity", "moderate_dissipation", "no_damping", "quasi_static"] = Field(
        default="hht",
        description="hht uses alpha; transient_fidelity (-0.05), moderate_dissipation (-0.41421) and no_damping (0) "
        "are hht with that alpha; quasi_static is backward Euler",
    )
    alpha: Real = Field(
        default_factory=_own_alpha,
        ge=-0.41422,
        le=0,
        description="HHT parameter, dimensionless, between -0.41421 and 0 (0: no damping)",
    )
    steps_per_cycle: Whole = Field(
        default=40, ge=2, description="time steps per cycle of the highest excitation frequency (count)"
    )

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
