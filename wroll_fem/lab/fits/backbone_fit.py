r"""Fit of friction and elastic slip of a roll to its resonances over level, with backbones of the finite-element model.

With penalty Coulomb friction the stick stiffness is :math:`\kappa = \mu p / \gamma^*`. If all displacements and
:math:`\gamma^*` are scaled by one factor at constant :math:`\kappa`, all forces scale by it as well, and frequencies do
not change. So one backbone per :math:`\kappa`, computed with :math:`\gamma_0`, gives all others:

.. math:: f(a; \kappa, \gamma^*) = f_0(a \gamma_0 / \gamma^*; \kappa), \qquad
          b(a; \kappa, \gamma^*) = (\gamma^* / \gamma_0)\, b_0(a \gamma_0 / \gamma^*; \kappa)

with the amplitude a of the tip and the base acceleration b that drives it at resonance. The data are f, b
and a. They contain friction and pressure as :math:`\mu p` alone, as long as the layers do not open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Literal

import numpy as np
import yaml
from pydantic import Field
from scipy.interpolate import make_interp_spline
from scipy.optimize import least_squares

from wroll_fem.case.base import Real, Switch, TaggedSection
from wroll_fem.errors import InputError
from wroll_fem.lab.fits.family_file import Resonance
from wroll_fem.numerics.identifiability import Uncertainty, uncertainty
from wroll_fem.results.dataset import load_dataset
from wroll_fem.typing import FloatArray, IntArray

WIDEST = 1e3
"""Factor around the elastic slip of the grid within which that of the roll is searched."""

LEAST_LOSS = 0.2
"""Increase of the base acceleration over the amplitude from which a backbone slides."""

STEP = 1e-6
"""Step of the differences of logarithms."""

STARTS = 5
"""Starting values of the elastic slip."""


class BackboneSettings(TaggedSection):
    """Fit of mu p and elastic slip with a grid of backbones, such as a batch of backbones over the pressure."""

    kind: Literal["backbones"] = Field("backbones", description="backbones")
    grid: str = Field(description="folder with the run folders of the backbones, one per stick stiffness mu p / gamma*")
    level_error: Real = Field(
        0.03, gt=0, description="relative standard error of the levels of base and tip each, dimensionless"
    )
    frequency_error: Real = Field(
        0.002, ge=0, description="relative error of the frequencies of the model, dimensionless; added to the measured"
    )
    frequency_factor: Switch = Field(
        True, description="whether a common factor of the frequencies of the model is fitted too"
    )
    pressure: list[Real] | None = Field(
        None, description="interface pressure of each roll, in the order of the conditions, Pa; gives mu from mu p"
    )


@dataclass(frozen=True, eq=False)
class Backbone:
    """Backbone of the model at one stick stiffness.

    Attributes
    ----------
    stick
        Stick stiffness mu p / gamma*, Pa/m.
    slip
        Elastic slip gamma* of the run, m.
    amplitude
        (n,) amplitude of the tip, m, ascending.
    frequency, base
        (n,) resonance frequency, Hz, and base acceleration, m/s^2 (0-peak).
    """

    stick: float
    slip: float
    amplitude: FloatArray
    frequency: FloatArray
    base: FloatArray

    @cached_property
    def onset(self) -> float:
        """Logarithm of the amplitude over gamma* at which half of the largest damping by sliding is reached."""
        ratio = self.base / self.amplitude
        excess = ratio - ratio[0]
        top = int(np.argmax(excess))
        if not excess[top] > LEAST_LOSS * ratio[0]:
            return float(np.log(self.amplitude[-1] / self.slip))
        return float(
            np.log(
                np.interp(0.5 * excess[top], np.maximum.accumulate(excess[: top + 1]), self.amplitude[: top + 1])
                / self.slip
            )
        )

    def at(self, relative: FloatArray) -> FloatArray:
        """(2, n) logarithms of frequency and of base acceleration over amplitude, at amplitudes relative to the onset.

        ``relative`` are logarithms of amplitudes over that of `onset`. Beyond the ends both are constant.
        """
        own = np.log(self.amplitude / self.slip) - self.onset
        return np.array([
            np.interp(relative, own, np.log(self.frequency)),
            np.interp(relative, own, np.log(self.base / self.amplitude)),
        ])  # fmt: skip


def read_backbones(folder: Path, *, fewest: int = 2) -> list[Backbone]:
    """Backbones of all run folders inside a folder, by ascending stick stiffness; ``fewest`` or more.

    Raises
    ------
    InputError
        If there are too few backbones of penalty Coulomb friction, or two have the same stick stiffness.
    """
    found = []
    for file in sorted(folder.glob("**/results.nc")):
        data = load_dataset(file)
        if "resonant_base_acceleration" not in data:
            continue
        friction = yaml.safe_load(str(data.attrs["case_yaml"])).get("contact", {}).get("friction", {})
        if friction.get("law", "penalty_coulomb") != "penalty_coulomb" or "pressure" not in data:
            raise InputError(
                "needs penalty_coulomb friction and a pressure", file=str(file), key="model.grid",
                remedy="compute backbones with contact.friction.law: penalty_coulomb",
            )  # fmt: skip
        pressure = data["pressure"].values
        area = data["area"].values if "area" in data else np.ones_like(pressure)
        real = np.isfinite(pressure)
        mean = float(np.average(pressure[real], weights=area[real]))
        slip = float(friction["elastic_slip"])
        order = np.argsort(data["tip_amplitude"].values)
        rows = (data[n].values[order] for n in ("tip_amplitude", "resonance_frequency", "resonant_base_acceleration"))
        found.append(Backbone(float(friction["mu"]) * mean / slip, slip, *rows))
    found.sort(key=lambda one: one.stick)
    if len(found) < fewest or np.diff(np.log([one.stick for one in found])).min(initial=1.0) < 1e-6:
        raise InputError(
            f"{len(found)} backbones with different stick stiffness are needed: two or more", file=str(folder),
            key="model.grid", remedy="run a batch of analysis: backbone over preload.pressure",
        )  # fmt: skip
    return found


@dataclass(frozen=True, eq=False)
class BackboneFit:
    """Friction and elastic slip of a roll.

    Attributes
    ----------
    tensions
        (n,) winding tension of each roll, N; nan if unknown.
    friction
        (n,) mu p of each roll, Pa.
    friction_low, friction_high
        (n,) 95 % intervals.
    slip, slip_low, slip_high
        Elastic slip, m, and its 95 % interval.
    factor
        Factor of the frequencies of the model.
    uncertainty
        Confidence of the fitted parameters: stick stiffness of each roll, elastic slip, frequency factor.
    misfit
        Square root of the sum of the squared residuals over their degrees of freedom, in standard errors.
    rolls
        (m,) place of the roll of each condition.
    fitted_f, fitted_base
        (m,) fitted frequency (Hz) and base acceleration (m/s^2) of each condition.
    outside
        Whether a stick stiffness lies at an end of the grid.
    """

    tensions: FloatArray
    friction: FloatArray
    friction_low: FloatArray
    friction_high: FloatArray
    slip: float
    slip_low: float
    slip_high: float
    factor: float
    uncertainty: Uncertainty
    misfit: float
    rolls: tuple[int, ...]
    fitted_f: FloatArray
    fitted_base: FloatArray
    outside: bool


def predicted(
    grid: Sequence[Backbone], stick: float, slip: float, amplitude: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Logarithms of frequency and base acceleration at amplitudes (m), for stick stiffness (Pa/m) and elastic slip (m).

    The backbones are interpolated over ln(kappa) at equal amplitude relative to the onset of sliding, and so is the
    onset: at equal amplitude one backbone may slide and its neighbour not.
    """
    sticks = np.log([one.stick for one in grid])
    at = float(np.clip(np.log(stick), sticks[0], sticks[-1]))
    order = min(3, len(grid) - 1)
    onset = float(make_interp_spline(sticks, np.array([one.onset for one in grid]), k=order)(at))
    relative = np.log(amplitude / slip) - onset
    each = np.array([one.at(relative) for one in grid])  # backbone, quantity, amplitude
    frequency, ratio = make_interp_spline(sticks, each, k=order, axis=0)(at)
    return np.asarray(frequency), np.asarray(ratio + np.log(amplitude))


@dataclass(frozen=True, eq=False)
class _Problem:
    """Least-squares problem: unknowns are ln(kappa) per roll, ln(gamma*), the frequency factor, and ln(a) per datum.

    The true amplitudes are unknowns, since the measured ones have errors as well: near the onset of sliding the base
    acceleration depends on them steeply.
    """

    grid: Sequence[Backbone]
    rolls: IntArray
    with_factor: bool
    seen: FloatArray
    """(3, m) logarithms of measured frequency, base acceleration and amplitude."""
    errors: FloatArray
    """(3, m) their standard errors."""

    @property
    def rolls_count(self) -> int:
        return int(self.rolls.max()) + 1

    @property
    def main(self) -> int:
        """Number of unknowns without the amplitudes."""
        return self.rolls_count + 1 + self.with_factor

    def model(self, x: FloatArray) -> FloatArray:
        """(3, m) logarithms of frequency, base acceleration and amplitude."""
        count, amplitude = self.rolls_count, x[self.main :]
        found = np.empty((3, len(self.rolls)))
        for roll in range(count):
            own = self.rolls == roll
            found[:2, own] = predicted(self.grid, np.exp(x[roll]), np.exp(x[count]), np.exp(amplitude[own]))
        found[0] += x[count + 1] if self.with_factor else 0.0
        found[2] = amplitude
        return found

    def residuals(self, x: FloatArray) -> FloatArray:
        return np.asarray(((self.model(x) - self.seen) / self.errors).ravel())

    def jacobian(self, x: FloatArray) -> FloatArray:
        """Derivatives by differences; an amplitude acts on its own datum alone, so one difference gives all of them."""
        base, size = self.residuals(x), len(self.rolls)
        found = np.zeros((3 * size, len(x)))
        for k in range(self.main):
            moved = x.copy()
            moved[k] += STEP
            found[:, k] = (self.residuals(moved) - base) / STEP
        moved = x.copy()
        moved[self.main :] += STEP
        change = ((self.residuals(moved) - base) / STEP).reshape(3, size)
        for row in range(3):
            found[row * size + np.arange(size), self.main + np.arange(size)] = change[row]
        return found


def fit_backbones(family: Sequence[Resonance], grid: Sequence[Backbone], settings: BackboneSettings) -> BackboneFit:
    """Fit stick stiffness per tension and a common elastic slip to frequencies and levels.

    Raises
    ------
    InputError
        If there are fewer data than parameters.
    """
    keys = [("tension", one.tension) if isfinite(one.tension) else ("own", float(k)) for k, one in enumerate(family)]
    unique = list(dict.fromkeys(keys))
    count, factor = len(unique), settings.frequency_factor
    f = np.array([one.f_n for one in family])
    if 2 * len(family) < count + 1 + factor:
        raise InputError(
            f"{len(family)} conditions are too few for {count} rolls", key="conditions", remedy="measure more levels"
        )
    f_error = np.array([one.f_n_error if isfinite(one.f_n_error) else 0.0 for one in family]) / f
    f_error = np.maximum(np.hypot(f_error, settings.frequency_error), 1e-6)
    level_error = np.full(len(family), settings.level_error)
    amplitude = np.log([one.tip_amplitude for one in family])
    seen = np.array([np.log(f), np.log([one.base_level for one in family]), amplitude])
    rolls = np.array([unique.index(key) for key in keys])
    problem = _Problem(grid, rolls, factor, seen, np.array([f_error, level_error, level_error]))
    ends = np.log([grid[0].stick, grid[-1].stick])
    slip_0 = np.log(grid[0].slip)
    low = np.r_[[ends[0]] * count, slip_0 - np.log(WIDEST), [-0.3] * factor, amplitude - 3.0]
    high = np.r_[[ends[1]] * count, slip_0 + np.log(WIDEST), [0.3] * factor, amplitude + 3.0]
    tried = []
    for shift in np.linspace(-0.5, 0.5, STARTS) * np.log(WIDEST):
        start = np.r_[[0.5 * (ends[0] + ends[1])] * count, slip_0 + shift, [0.0] * factor, amplitude]
        done = least_squares(
            problem.residuals, start, problem.jacobian, bounds=(low, high), x_scale="jac", max_nfev=60
        )  # fmt: skip
        tried.append(done)
    best = min(tried, key=lambda done: done.cost)
    return _found(best.x, problem, unique, ends)


def _found(x: FloatArray, problem: _Problem, unique: list[tuple[str, float]], ends: FloatArray) -> BackboneFit:
    """Fit in physical parameters; mu p = kappa gamma* has the variance of the sum of both logarithms.

    The amplitudes are eliminated: the Jacobian of the parameters is projected beside that of the amplitudes.
    """
    count, main = len(unique), problem.main
    whole, rest = problem.jacobian(x), problem.residuals(x)
    beside, _ = np.linalg.qr(whole[:, main:])
    jacobian = whole[:, :main] - beside @ (beside.T @ whole[:, :main])
    change = np.eye(main)
    change[:count, count] = 1.0  # ln(mu p) = ln(kappa) + ln(gamma*)
    labels = [
        f"mu p of {value:g} N" if key == "tension" else f"mu p of roll {k + 1}" for k, (key, value) in enumerate(unique)
    ]
    names = [*labels, "elastic slip", *(["frequency factor"] if problem.with_factor else [])]
    physical = change @ x[:main]
    sure = uncertainty(names, physical, jacobian @ np.linalg.inv(change), rest, scaled=True, freedom=len(rest) - len(x))
    tensions = np.array([value if key == "tension" else np.nan for key, value in unique])
    edge = 1e-3 * (ends[1] - ends[0])
    outside = bool(np.any((x[:count] < ends[0] + edge) | (x[:count] > ends[1] - edge)))
    fitted = np.exp(problem.model(x))
    return BackboneFit(
        tensions, np.exp(physical[:count]), sure.low[:count], sure.high[:count], float(np.exp(x[count])),
        float(sure.low[count]), float(sure.high[count]), float(np.exp(x[count + 1])) if problem.with_factor else 1.0,
        sure, float(np.sqrt(rest @ rest / max(1, len(rest) - len(x)))), tuple(int(k) for k in problem.rolls),
        fitted[0], fitted[1], outside,
    )  # fmt: skip
