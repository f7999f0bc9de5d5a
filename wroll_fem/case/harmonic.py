"""Case sections `harmonic` and `backbone`: periodic motions by harmonic balance."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from wroll_fem.case.base import Real, Section, Whole, validation_error


class Harmonic(Section):
    """Settings of harmonic balance: number of harmonics, sampling of friction, tolerance of the reduced model."""

    harmonics: Whole = Field(default=3, ge=1, le=50, description="number of harmonics besides the mean (count)")
    samples: Whole = Field(default=64, ge=8, le=8192, description="number of friction samples per period (count)")
    max_periods: Whole = Field(
        default=8,
        ge=1,
        le=1000,
        description="largest number of periods until the friction hysteresis is periodic (count)",
    )
    reduction_tolerance: Real = Field(
        default=1e-3,
        gt=0,
        le=0.1,
        description="tolerance of the reduced model: energy norm of the residual error divided by the energy norm "
        "of the motion, dimensionless",
    )
    hyper_reduction: bool = Field(
        default=False,
        description="whether curves are followed on a weighted subset of the contact points and completed with all "
        "points; for fine meshes",
    )

    @model_validator(mode="after")
    def _sampled(self) -> Self:
        if self.samples < 4 * self.harmonics + 4:
            raise validation_error(
                f"too few samples for {self.harmonics} harmonics", key="samples", value=self.samples,
                remedy=f"use {4 * self.harmonics + 4} or more (64 is the default)",
            )  # fmt: skip
        return self


class Backbone(Section):
    """Range of tip amplitudes of the backbone."""

    tip_smallest: Real = Field(default=1e-7, gt=0, description="smallest amplitude of the tip, m, 0-peak")
    tip_largest: Real = Field(default=5e-4, gt=0, description="largest amplitude of the tip, m, 0-peak")

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.tip_largest <= self.tip_smallest:
            raise validation_error(
                f"must be above backbone.tip_smallest = {self.tip_smallest:g} m", key="tip_largest",
                value=self.tip_largest, remedy="give tip_smallest < tip_largest, in m",
            )  # fmt: skip
        return self
