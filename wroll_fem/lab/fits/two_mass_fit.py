"""Fit of the two-mass model to a family of measured curves (thesis, chapter 5).

The model is scaled: masses by that of the primary, frequencies by the resonance of the primary alone, displacements by
the base amplitude of the first condition. So m1 = k1 = 1, and a friction capacity F is F / (k1 Y_0). The base amplitude
of a condition is that at its resonance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, pi
from typing import Literal

import numpy as np
from pydantic import Field, field_validator

from wroll_fem.case.base import Real, Switch, TaggedSection, Whole, validation_error
from wroll_fem.errors import InputError
from wroll_fem.lab.fits.family_file import Resonance
from wroll_fem.two_dof.fit import Fit, Measured, fit_curves
from wroll_fem.two_dof.model import Arrangement, TwoMasses
from wroll_fem.typing import FloatArray

Range = tuple[Real, Real]

ACCURACY = 1e-5
"""Relative accuracy of the computed curves; that of measured ones is 1e-3 at best."""


class TwoMassSettings(TaggedSection):
    """Fit of the two-mass model: parameters with their bounds, or as a number, which is not fitted."""

    kind: Literal["two_masses"] = Field("two_masses", description="two_masses")
    primary_hz: Real = Field(gt=0, description="resonance frequency of the primary mass alone (mandrel), Hz")
    primary_mass: Real | None = Field(None, gt=0, description="modal mass of the primary, kg; needed for forces in N")
    zeta_primary: Range | Real = Field(
        (0.001, 0.05), description="bounds or value of c1 / (2 sqrt(k1 m1)), dimensionless"
    )
    mass_ratio: Range | Real = Field((0.05, 2.0), description="bounds or value of m2 / m1, dimensionless")
    stiffness_ratio: Range | Real = Field((0.05, 4.0), description="bounds or value of k2 / k1, dimensionless")
    zeta_secondary: Range | Real = Field(0.001, description="bounds or value of c2 / (2 sqrt(k1 m1)), dimensionless")
    capacity: Range = Field(
        (0.1, 50.0), description="bounds of the friction capacity over k1 Y0 of the first condition, dimensionless"
    )
    smoothing: Real = Field(3.0, gt=0, description="scale of the regularised sign function, dimensionless")
    preload_dependent: Switch = Field(False, description="whether mass and stiffness depend on the capacity (eq. 5.6)")
    arrangement: Arrangement = Field(
        "both_on_base", description="both_on_base, secondary_isolated or secondary_on_primary (Fig. 5.1)"
    )
    points: Whole = Field(12, ge=6, description="points per curve, closest at the resonance (count)")
    starts: Whole = Field(2, ge=1, description="starting points of the fit (count)")

    @field_validator("zeta_primary", "mass_ratio", "stiffness_ratio", "zeta_secondary", "capacity")
    @classmethod
    def _ascending(cls, value: Range | float) -> Range | float:
        if isinstance(value, tuple):
            if not 0.0 < value[0] < value[1]:
                raise validation_error(
                    "must be two numbers above 0 in ascending order", remedy="give the lower first", value=list(value)
                )
        elif not value > 0.0:
            raise validation_error("must be greater than 0", remedy="give a number, or bounds", value=value)
        return value


@dataclass(frozen=True, eq=False)
class TwoMassFit:
    """Fitted two-mass model.

    Attributes
    ----------
    fit
        Fit of the scaled model.
    curves
        Points of the curves.
    rolls
        (n,) place of the roll of each condition.
    force
        Unit of the scaled forces, N; nan without the mass of the primary.
    """

    fit: Fit
    curves: tuple[Measured, ...]
    rolls: tuple[int, ...]
    force: float


def fit_two_masses(family: Sequence[Resonance], settings: TwoMassSettings) -> TwoMassFit:
    """Fit the model to a family; conditions of the same tension share a friction capacity.

    Raises
    ------
    InputError
        If a curve has too few points around its resonance.
    """
    unit = family[0].base_amplitude
    rolls = _rolls(family)
    low, high = settings.capacity
    start = float(np.sqrt(low * high))
    curves = []
    for one, roll in zip(family, rolls, strict=True):
        omega, size = _points(one, settings)
        curves.append(Measured(omega, size, start, one.base_amplitude / unit, roll))
    given = {
        "m2": (settings.mass_ratio, 1.0), "k2": (settings.stiffness_ratio, 1.0),
        "c1": (settings.zeta_primary, 2.0), "c2": (settings.zeta_secondary, 2.0),
    }  # fmt: skip
    bounds = {
        name: (factor * value[0], factor * value[1])
        for name, (value, factor) in given.items() if isinstance(value, tuple)
    }  # fmt: skip
    first = {
        name: factor * float(np.sqrt(value[0] * value[1]) if isinstance(value, tuple) else value)
        for name, (value, factor) in given.items()
    }
    model = TwoMasses(
        **first, smoothing=settings.smoothing, arrangement=settings.arrangement,
        preload_dependent=settings.preload_dependent, base_amplitude=1.0,
    )  # fmt: skip
    fit = fit_curves(
        curves, bounds, model=model, capacity_bounds=settings.capacity, starts=settings.starts, accuracy=ACCURACY
    )
    mass = settings.primary_mass
    force = float("nan") if mass is None else mass * (2.0 * pi * settings.primary_hz) ** 2 * unit
    return TwoMassFit(fit, tuple(curves), tuple(rolls), force)


def _rolls(family: Sequence[Resonance]) -> list[int]:
    """Number of the roll of each condition: one per tension; a condition without tension is a roll of its own."""
    keys = [("tension", one.tension) if isfinite(one.tension) else ("own", float(k)) for k, one in enumerate(family)]
    places = {key: k for k, key in enumerate(dict.fromkeys(keys))}
    return [places[key] for key in keys]


def _points(one: Resonance, settings: TwoMassSettings) -> tuple[FloatArray, FloatArray]:
    """Scaled frequencies and |T| of a condition: equal steps of the phase of a linear resonance of the same width."""
    zeta = one.zeta if isfinite(one.zeta) else 0.5 / one.peak
    width = zeta * one.f_n
    ends = np.arctan((one.frequency[[0, -1]] - one.f_n) / width)
    steep = np.arctan(12.0)
    ends = np.clip(ends, -steep, steep)
    f = one.f_n + width * np.tan(np.linspace(ends[0], ends[1], settings.points))
    f = np.unique(np.clip(f, one.frequency[0], one.frequency[-1]))
    if len(f) < settings.points or np.count_nonzero(np.abs(one.frequency - one.f_n) < width) < 3:
        raise InputError(
            f"the curve of {one.name} has too few lines around its resonance", key="model.points",
            remedy="evaluate the records with a finer resolution or a wider band",
        )  # fmt: skip
    return f / settings.primary_hz, np.interp(f, one.frequency, one.magnitude)
