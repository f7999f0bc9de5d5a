r"""Constants of rate-and-state friction from velocity steps, for the ageing and the slip law (thesis, equation E.4).

For a given distance D_R the coefficient is linear in mu_R, a and b, so D_R is searched on a grid first; all four are
then refined together. The reference rate V_R only fixes which mu is called mu_R and is not fitted.

References
----------
.. [1] Marone (1998), Annu. Rev. Earth Planet. Sci. 26, 643-696, doi:10.1146/annurev.earth.26.1.643.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.lab.shear.segments import Part, constant_rates
from wroll_fem.numerics.inference import Estimate, Fit, fit
from wroll_fem.tribology.rate_and_state import LAWS, RateAndState, StateLaw
from wroll_fem.typing import FloatArray

GRID = 40
"""Distances D_R tried before the fit."""

CLEAR = 10.0
"""Difference of Akaike's criterion from which the data prefer one law."""

GUARD = 0.5
"""Samples nearer to a change of the rate than this part of their distance are left out."""

SOFT = 0.1
"""Elastic travel of the fixture under the change of force by a step, relative to D_R, above which it blurs the step."""


class StepData(NamedTuple):
    """Samples of a step test that enter the fit.

    Attributes
    ----------
    parts
        Parts of constant rate.
    part, elapsed
        (n,) part of each sample, and time since its begin, s.
    slip
        (n,) displacement from the start of the record, m.
    coefficient
        (n,) measured coefficient of friction.
    """

    parts: tuple[Part, ...]
    part: FloatArray
    elapsed: FloatArray
    slip: FloatArray
    coefficient: FloatArray

    def basis(self, law: StateLaw, distance: float) -> FloatArray:
        """(n,) ln(V_R theta/D_R) + ln(V/V_R) = ln u along the record, from steady sliding at the first rate."""
        unit = RateAndState(distance=distance, law=law)
        state = float(unit.steady_state(self.parts[0].rate))
        found = np.empty(len(self.elapsed))
        for k, part in enumerate(self.parts):
            own = self.part == k
            found[own] = np.log(unit.state_after(state, part.rate, self.elapsed[own]) * part.rate / distance)
            state = float(unit.state_after(state, part.rate, part.end - part.begin))
        return found

    @property
    def rates(self) -> FloatArray:
        """(n,) slip rate at each sample, m/s."""
        return np.array([part.rate for part in self.parts])[self.part.astype(int)]


@dataclass(frozen=True)
class StateFit:
    """Fit of one law.

    Attributes
    ----------
    law
        Law of the state.
    rate
        Reference rate V_R, m/s.
    fit
        Parameters mu, a, b and distance (m).
    scatter
        Standard deviation of the residuals of the coefficient.
    """

    law: StateLaw
    rate: float
    fit: Fit
    scatter: float

    def __getitem__(self, name: str) -> Estimate:
        """Estimate of mu, a, b or distance."""
        return self.fit[name]

    @property
    def friction(self) -> RateAndState:
        """Fitted law.

        Raises
        ------
        InputError
            If a constant is negative.
        """
        a, b = self["a"].value, self["b"].value
        return RateAndState(self["mu"].value, a, b, self.rate, self["distance"].value, self.law)

    @property
    def steady_slope(self) -> Estimate:
        """Estimate of a - b, the slope of the coefficient in steady sliding over ln V: negative weakens with V."""
        gradient = np.zeros(len(self.fit.names))
        gradient[self.fit.names.index("a")], gradient[self.fit.names.index("b")] = 1.0, -1.0
        return self.fit.predicted(gradient, self["a"].value - self["b"].value)


class StateFits(NamedTuple):
    """Fits of both laws.

    Attributes
    ----------
    fits
        Law -> fit.
    preferred
        Law with the smaller criterion of Akaike.
    difference
        Difference of the criteria; above `CLEAR` the data decide between the laws.
    data
        Fitted samples.
    doubts
        Doubts, one sentence each.
    """

    fits: dict[StateLaw, StateFit]
    preferred: StateLaw
    difference: float
    data: StepData
    doubts: tuple[str, ...]


def step_data(record: ShearRecord, *, skip: float = 0.0) -> StepData:
    """Samples of a velocity-step record that enter the fit, beyond the first ``skip`` m of displacement.

    Raises
    ------
    InputError
        If the rate never changes beyond ``skip``.
    """
    coefficient = record.coefficient
    parts = tuple(part for part in constant_rates(record) if part.rate > 0.0)
    # before the first part that slides, force and displacement rise together
    x = record.displacement - record.displacement[0]
    if len(parts) < 2 or x[parts[-1].start] <= skip:
        raise InputError(
            f"the rate does not change beyond the first {1e3 * skip:g} mm", file=record.source, key="skip",
            remedy="lower skip, or give a record with velocity steps",
        )  # fmt: skip
    spacing = np.gradient(record.time)
    number = np.zeros(len(x), dtype=int)
    elapsed = np.zeros(len(x))
    used = x > skip
    for k, part in enumerate(parts):
        own = slice(part.start, part.stop)
        number[own], elapsed[own] = k, record.time[own] - part.begin
        for edge in (part.begin, part.end):
            used[own] &= np.abs(record.time[own] - edge) > GUARD * np.min(spacing[own])
    used[: parts[0].start] = False
    return StepData(parts, number[used].astype(float), np.maximum(elapsed[used], 0.0), x[used], coefficient[used])


def fit_state_laws(
    records: Sequence[ShearRecord],
    *,
    skip: float = 0.0,
    rate: float | None = None,
    fixture_stiffness: float | None = None,
) -> StateFits:
    """Fit both laws to one record with velocity steps, or to several together.

    Parameters
    ----------
    records
        Records with the displacement of the specimen and the normal force.
    skip
        Displacement from the start that is left out, m; 0.5 mm in the thesis.
    rate
        Reference rate V_R, m/s; by default the lowest rate.
    fixture_stiffness
        Stiffness of fixture and machine, N/m, to judge whether it blurs the steps.

    Raises
    ------
    InputError
        If a record has no velocity step, or fewer samples than parameters.
    """
    data = [step_data(record, skip=skip) for record in records]
    whole = data[0]
    reference = rate if rate is not None else min(part.rate for one in data for part in one.parts)
    fits = {law: _fitted(data, law, reference) for law in LAWS}
    first, second = LAWS
    best = min(LAWS, key=lambda law: fits[law].fit.criterion())
    noise = fits[best].fit.noise
    difference = abs(fits[first].fit.criterion(noise) - fits[second].fit.criterion(noise))
    best = min(LAWS, key=lambda law: fits[law].fit.criterion(noise))
    doubts = _doubts(fits[best], records, data, fixture_stiffness)
    if difference < CLEAR:
        doubts.append(
            f"ageing and slip law fit equally well (difference of Akaike's criterion {difference:.1f}); larger steps "
            "of the rate tell them apart"
        )
    return StateFits(fits, best, difference, whole, tuple(doubts))


def _fitted(data: Sequence[StepData], law: StateLaw, reference: float) -> StateFit:
    measured = np.concatenate([one.coefficient for one in data])
    ratio = np.log(np.concatenate([one.rates for one in data]) / reference)
    lengths = [len(one.coefficient) for one in data]

    def basis(distance: float) -> FloatArray:
        return np.concatenate([one.basis(law, distance) for one in data])

    def columns(distance: float) -> FloatArray:
        # mu = mu_R + a ln(V/V_R) + b (ln u - ln(V/V_R))
        return np.column_stack([np.ones_like(ratio), ratio, basis(distance) - ratio])

    travel = min(part.rate * (part.end - part.begin) for one in data for part in one.parts)
    tried = []
    for distance in travel * np.geomspace(2e-5, 2.0, GRID):
        found, misfit = nnls(columns(float(distance)), measured)  # mu, a and b are not negative
        tried.append((float(misfit), float(distance), found))
    _, distance, found = min(tried, key=lambda entry: entry[0])
    start = {"mu": float(found[0]), "a": float(found[1]), "b": float(found[2]), "distance": distance}

    def model(p: FloatArray) -> FloatArray:
        inside = float(np.clip(p[3], 1e-6 * travel, 1e3 * travel))
        return np.asarray(columns(inside) @ p[:3])

    scales = {"a": 0.01, "b": 0.01}
    done = fit(model, measured, start, lengths=lengths, positive=["distance"], scales=scales)
    if done.unidentified or min(done["a"].value, done["b"].value) < 0.0:
        # along a direction that the data do not determine, the fit may end anywhere: keep the admissible start
        done = fit(model, measured, start, lengths=lengths, positive=["distance"], scales=scales, solve=False)
    return StateFit(law, reference, done, done.noise_level)


def _doubts(
    best: StateFit, records: Sequence[ShearRecord], data: Sequence[StepData], stiffness: float | None
) -> list[str]:
    doubts = [f"{name} is not identifiable: {_reasons[name]}" for name in best.fit.unidentified]
    if best.fit.correlated:
        doubts.append(
            "the residuals stay correlated: the law does not describe the record, and its intervals are too narrow"
        )
    for name in ("a", "b"):
        if best[name].value < 0.0:
            doubts.append(f"{name} = {best[name].value:.2g} is negative, which the law does not allow")
        elif name not in best.fit.unidentified and best[name].interval()[0] <= 0.0:
            doubts.append(f"{name} does not differ from 0 at 95 %")
    near = max(_spacing(one) for one in data)
    distance = best["distance"].value
    if near > 0.5 * distance:
        doubts.append(
            f"the slip between two samples, {near:.2g} m, is not small against D_R = {distance:.2g} m; sample faster"
        )
    if stiffness is not None:
        change = max(abs(best["a"].value), abs(best["b"].value)) * np.log(_largest_step(data))
        blur = 2.0 * max(record.known_normal_force for record in records) * change / stiffness
        if blur > SOFT * distance:
            doubts.append(
                f"the fixture yields by {blur:.2g} m when the force changes at a step, not small against D_R = "
                f"{distance:.2g} m: the slip rate is not the rate of the machine, and a and D_R are blurred"
            )
    return doubts


def _spacing(data: StepData) -> float:
    """Largest slip between two samples, m, over the parts of a record."""
    parts = [(part.rate, data.elapsed[data.part == k]) for k, part in enumerate(data.parts)]
    return max(rate * float(np.median(np.diff(elapsed))) for rate, elapsed in parts if len(elapsed) > 1)


def _largest_step(data: Sequence[StepData]) -> float:
    ratios = [b.rate / a.rate for one in data for a, b in zip(one.parts[:-1], one.parts[1:], strict=True)]
    return max(max(ratio, 1.0 / ratio) for ratio in ratios)


_reasons = {
    "mu": "no part of the record slides steadily at a known state; slide longer",
    "a": "the record has no sharp change of the rate; sample faster, or raise the ratio of the rates",
    "b": "the record has no transient after a step; slide longer between the steps",
    "distance": "the transients after the steps are not resolved, or absent; sample faster, or slide longer",
}
"""Parameter -> why it may not be identifiable, and the remedy."""
