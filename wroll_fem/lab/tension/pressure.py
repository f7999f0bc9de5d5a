r"""Pressure that a measured tension winds, with its error, through the model of the wound roll.

The error is propagated linearly,

.. math:: s_p^2 = \Big(\frac{\partial p}{\partial T}\Big)^2 s_T^2 + \sum_k \Big(\frac{\partial p}{\partial q_k}\Big)^2
          s_k^2

with other uncertain keys q_k of the case, and compared with the quantiles of a sample.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import stdtrit

from wroll_fem.case import Case, load_case
from wroll_fem.case.winding import Winding
from wroll_fem.errors import InputError
from wroll_fem.numerics.inference import Estimate, combined_freedom
from wroll_fem.typing import FloatArray
from wroll_fem.winding import wound_roll

STEP = 0.01
"""Relative step of the differences."""

NODES = 9
"""Tensions at which the pressure is computed for the sample, if the tension alone is uncertain."""

CELLS = 8
"""Cells per wrap, and 400 at least, for differences and samples."""

SMALLEST = 0.05
"""Smallest value of an uncertain key in the sample, relative to its own: keys stay positive."""

APART = 0.1
"""Difference between the ends of the linear interval and those of the sample, relative to its half width, that is
reported."""


class Pressure(NamedTuple):
    """Pressure at one tension.

    Attributes
    ----------
    mandrel, mean
        Pressure between mandrel and first wrap, and mean over the radius between the wraps, Pa.
    slope
        Change of the pressure at the mandrel with the tension, Pa/N.
    sample
        Quantiles 2.5 % and 97.5 % of the pressure at the mandrel in the sample, Pa.
    """

    mandrel: Estimate
    mean: Estimate
    slope: float
    sample: tuple[float, float]

    @property
    def nonlinear(self) -> bool:
        """Whether the interval of the linear propagation departs from the sample."""
        low, high = self.mandrel.interval()
        apart = max(abs(low - self.sample[0]), abs(high - self.sample[1]))
        return bool(np.isfinite(high) and apart > APART * 0.5 * (high - low))


class WindingModel:
    """Pressures of a case with a section `winding`, as a function of the tension and of other uncertain keys.

    Parameters
    ----------
    case
        Case file with a section `winding` that has `web_width`, or gives the tension as a force.
    uncertain
        Dotted key -> relative standard error, dimensionless.

    Raises
    ------
    InputError
        If the case has no such section, the width of the web is missing, or a key is no number.
    """

    def __init__(self, case: str | Path, uncertain: Mapping[str, float] | None = None):
        self.path, self.uncertain = Path(case), dict(uncertain or {})
        base = load_case(self.path)
        self.base = self._section(base)
        self.values = {key: _number(base, key, self.path) for key in self.uncertain}

    def pressures(self, tension: float, changes: Mapping[str, float] | None = None, *, fine: bool = True) -> FloatArray:
        """Pressure at the mandrel and mean pressure, Pa, (2,), at a tension (N) and changed values of keys."""
        section = self._changed(changes or {})
        wanted = {"tension_newton": tension, "tension_stress": None}
        if not fine:
            wanted["cells"] = min(section.cells, max(400, CELLS * section.wraps))
        roll = wound_roll(section.model_copy(update=wanted))
        radius = roll.radius
        mean = float(np.sum(np.diff(radius) * 0.5 * (roll.pressure[1:] + roll.pressure[:-1])) / np.ptp(radius))
        return np.array([roll.pressure[0], mean])

    def at(self, tension: Estimate, *, draws: int = 400, seed: int = 1) -> Pressure:
        """Pressure at a measured tension (N), with its error.

        Parameters
        ----------
        tension
            Tension, N, above 0.
        draws, seed
            Size of the sample, and seed.

        Raises
        ------
        InputError
            If the tension is not positive.
        """
        if not tension.value > 0.0:
            raise InputError(
                f"a tension of {tension.value:.3g} N winds no roll", remedy="check sign and zero of the load cell"
            )
        value = self.pressures(tension.value)
        step = STEP * tension.value
        slope = self._difference(
            self.pressures(tension.value + step, fine=False), self.pressures(tension.value - step, fine=False), step
        )
        variances = [(slope * tension.error) ** 2]
        for key, relative in self.uncertain.items():
            size = STEP * abs(self.values[key])
            up, down = (
                self.pressures(tension.value, {key: self.values[key] + sign * size}, fine=False) for sign in (1.0, -1.0)
            )
            variances.append((self._difference(up, down, size) * relative * self.values[key]) ** 2)
        freedoms = (tension.freedom, *(np.inf for _ in self.uncertain))
        found = [
            Estimate(
                float(value[k]), float(np.sqrt(sum(v[k] for v in variances))),
                combined_freedom(tuple(float(v[k]) for v in variances), freedoms),
            )
            for k in range(2)
        ]  # fmt: skip
        sample = self.sample(tension, draws=draws, seed=seed) if np.isfinite(tension.error) else np.array([np.nan])
        low, high = np.quantile(sample, (0.025, 0.975))
        return Pressure(found[0], found[1], float(slope[0]), (float(low), float(high)))

    def sample(self, tension: Estimate, *, draws: int, seed: int) -> FloatArray:
        """Sample (draws,) of the pressure at the mandrel, Pa: tension by the t-distribution, keys by the normal one.

        Points of equal probability in random order (Latin hypercube), so that few draws suffice.
        """
        rng = np.random.default_rng(seed)
        levels = (np.arange(draws) + 0.5) / draws
        t = stdtrit(min(tension.freedom, 1e9), levels)
        tensions = np.maximum(tension.value + tension.error * t, 1e-3 * tension.value)
        if not self.uncertain:
            nodes = np.linspace(tensions.min(), tensions.max(), NODES)
            curve = CubicSpline(nodes, [self.pressures(float(node), fine=False)[0] for node in nodes])
            return np.asarray(curve(tensions))
        normal = stdtrit(1e9, levels)
        factors = {
            key: np.maximum(1.0 + size * rng.permutation(normal), SMALLEST) for key, size in self.uncertain.items()
        }
        found = [
            self.pressures(float(one), {key: self.values[key] * float(factors[key][k]) for key in factors}, fine=False)
            for k, one in enumerate(tensions)
        ]
        return np.array(found)[:, 0]

    def _changed(self, changes: Mapping[str, float]) -> Winding:
        """Section with other values of keys."""
        inside = all(key.startswith("winding.") for key in changes)
        if not inside:
            return self._section(load_case(self.path, [f"{key}={value!r}" for key, value in changes.items()]))
        if not changes:
            return self.base
        data = self.base.model_dump()
        for key, value in changes.items():
            *parents, last = key.split(".")[1:]
            here = data
            for part in parents:
                here = here[part]
            here[last] = value
        return Winding.model_validate(data)

    @staticmethod
    def _difference(up: FloatArray, down: FloatArray, step: float) -> FloatArray:
        return (up - down) / (2.0 * step)

    def _section(self, case: Case) -> Winding:
        winding = getattr(case, "winding", None)
        if not isinstance(winding, Winding):
            raise InputError(
                "required section is missing", file=str(self.path), key="winding", remedy="add it (docs/winding.md)"
            )
        if winding.web_width is None:
            raise InputError(
                "required key is missing", file=str(self.path), key="winding.web_width",
                remedy="add it (width of the web, m): the tension is measured as a force",
            )  # fmt: skip
        geometry, mandrel = getattr(case, "geometry", None), getattr(case, "mandrel", None)
        if winding.mandrel is None and geometry is not None and mandrel is not None:
            return winding.on_mandrel(geometry, mandrel)
        return winding


def _number(case: Case, key: str, path: Path) -> float:
    """Value of a dotted key of a case."""
    here: object = case
    for part in key.split("."):
        here = getattr(here, part, None)
    if isinstance(here, bool) or not isinstance(here, int | float) or here == 0.0:
        raise InputError(
            f"{key} is no number of the case, or is 0", key="uncertain", file=str(path),
            remedy="give dotted keys of the case, such as winding.web.radial_modulus.K2, and relative standard errors",
        )  # fmt: skip
    return float(here)
