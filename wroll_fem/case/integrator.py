"""Section `integrator`: time integration."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from wroll_fem.case.base import Real, Section, Whole, wrong

#: alpha of the named schemes (Table B.1 of the source); quasi_static is backward Euler and has none.
SCHEME_ALPHA = {"transient_fidelity": -0.05, "moderate_dissipation": -0.41421, "no_damping": 0.0, "quasi_static": 0.0}


class Integrator(Section):
    """Hilber-Hughes-Taylor integration, alpha <= 0, or backward Euler (quasi_static)."""

    scheme: Literal["hht", "transient_fidelity", "moderate_dissipation", "no_damping", "quasi_static"] = Field(
        default="hht",
        description="hht takes alpha; transient_fidelity (-0.05), moderate_dissipation (-0.41421) and no_damping (0) "
        "are named values of it; quasi_static is backward Euler",
    )
    alpha: Real = Field(
        default=-0.05,
        ge=-0.41422,
        le=0,
        description="HHT parameter, dimensionless, between -0.41421 and 0 (0: no damping)",
    )
    steps_per_cycle: Whole = Field(
        default=40, ge=2, description="time steps per cycle of the highest excitation frequency (count)"
    )

    @model_validator(mode="after")
    def _alpha_of_scheme(self) -> Self:
        """Give a named scheme its own alpha, and refuse an alpha that would be ignored."""
        own = SCHEME_ALPHA.get(self.scheme)
        if own is None:
            return self
        if "alpha" in self.model_fields_set and abs(self.alpha - own) > 1e-5:
            remedy = f"leave alpha out (it is {own:g} here) or use scheme: hht"
            raise wrong(f"scheme {self.scheme} has its own alpha", key="alpha", value=self.alpha, remedy=remedy)
        self.__dict__["alpha"] = own  # not marked as given: `Case.changed` may pick another scheme
        return self
