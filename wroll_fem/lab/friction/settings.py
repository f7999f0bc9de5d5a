"""Settings of the evaluation `friction`."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from wroll_fem.case.base import Real, Whole
from wroll_fem.lab.shear.settings import ShearRecordSettings

Wanted = Literal["rate", "state", "elastic_slip"]


class FrictionSettings(ShearRecordSettings):
    """Settings of the evaluation `friction`; those of `shear` without area and thickness, and those of the fits."""

    fits: list[Wanted] | None = Field(
        None,
        description="fits: rate (coefficient over slip rate), state (rate and state), elastic_slip; default: those "
        "that the records allow",
    )
    rate_model: Literal["auto", "constant", "logarithmic", "table"] = Field(
        "auto", description="model of mu(V) in friction.yaml; auto takes the one with the smallest criterion of Akaike"
    )
    knots: list[Real] = Field(
        default_factory=list, description="slip rates of the table, m/s, rising; default: the tested rates"
    )
    reference_rate: Real | None = Field(
        None, gt=0, description="reference rate V_R of rate and state, m/s; default: the lowest rate of the record"
    )
    interfaces: Whole = Field(
        1, ge=1, description="frictional interfaces of one stack in the ramps: layers + 1 (count)"
    )
    series_compliance: Real | None = Field(
        None,
        ge=0,
        description="compliance of layers and fixture in series, m/N; default: fitted",
    )
    elastic_slip: Real | None = Field(
        None, gt=0, description="elastic slip gamma* for friction.yaml, m; default: the fitted one"
    )
