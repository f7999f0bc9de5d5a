"""Half-power damping of a Gaussian bell fitted to the peak (thesis, appendix D, algorithm 2).

As printed: T~(f) = a exp(-((f - b) / c)^2), best fit on (f_pk - d, f_pk + d), with d from

    maximise d / RMSE(d)   subject to   T~(f_pk - d) = T~(f_pk + d) <= T_pk / sqrt 2,
    RMSE(d)^2 = (1 / d) * integral of (T - T~)^2 over the window.

The text leaves some points open. They are resolved as follows:

- The equality requires b = f_pk, so b is not fitted (`centre="peak"`). With `centre="free"` b is fitted, and both ends
  of the window must lie at or below T_pk / sqrt 2.
- The maximum of d / RMSE does not depend on the units, but the objective increases towards both ends of the range of d.
  A bell fits any smooth peak better in a narrower window (RMSE decreases as d^3 or faster), so d / RMSE grows without
  bound towards d = 0 and only the constraint limits it. It grows again towards wide windows, where RMSE stays bounded.
  With a wide band around a narrow peak the maximum lies at the wide end, and the damping is much too high.
  `window="objective"` is the text as printed; `window="narrowest"` uses the narrowest window that the constraint
  allows, which does not depend on the band.
- "In the neighborhood of the peak" gives no size. `reach` limits d to a fraction of f_pk. A bell that would violate the
  constraint is then fitted with a exp(-(d / c)^2) = T_pk / sqrt 2 at both ends, so that there is a fit for any d.
- The integral is taken over a monotone cubic interpolation on a uniform grid, so the spacing of the data is no weight.
- "Best fit" means least squares in the same norm. Only windows inside the band are tried.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log, sqrt
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.integrate import trapezoid
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq, least_squares, minimize_scalar

from wroll_fem.errors import InputError
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.estimators.estimate import DampingEstimate, checked_curve, no_estimate, scatter
from wroll_fem.typing import FloatArray

METHOD = "Gaussian fit"
Centre = Literal["peak", "free"]
Window = Literal["objective", "narrowest"]

_GRID = np.linspace(-1.0, 1.0, 161)
_WINDOWS = 60
_FEWEST_POINTS = 5  # smallest number of data points in the window


@dataclass(frozen=True)
class Bell:
    """Gaussian bell a exp(-((f - b) / c)^2), fitted at frequencies f within d of the frequency of the peak.

    Attributes
    ----------
    a
        Height.
    b, c, d
        Centre, width and half the width of the window, Hz.
    rmse
        Root mean square error as defined in the thesis (integral over the window divided by d, not by 2 d).
    """

    a: float
    b: float
    c: float
    d: float
    rmse: float

    def __call__(self, frequency: npt.ArrayLike) -> FloatArray:
        """Value of the Gaussian curve at the given frequencies (Hz): an array of the same shape as the frequencies."""
        return np.asarray(self.a * np.exp(-(((np.asarray(frequency) - self.b) / self.c) ** 2)))

    @property
    def zeta(self) -> float:
        """Half-power damping ratio of the bell, whose width at a / sqrt 2 is 2 c sqrt(ln 2 / 2)."""
        return self.c * sqrt(0.5 * log(2.0)) / self.b


def _fit(curve: PchipInterpolator, f_pk: float, peak: float, d: float, centre: Centre) -> Bell:
    values = curve(f_pk + d * _GRID) / peak
    free = centre == "free"

    def parts(p: FloatArray) -> tuple[FloatArray, FloatArray]:
        x = (_GRID - (p[2] if free else 0.0)) * p[1]
        return x, np.exp(-(x**2))

    def residual(p: FloatArray) -> FloatArray:
        return p[0] * parts(p)[1] - values

    def jacobian(p: FloatArray) -> FloatArray:
        x, bell = parts(p)
        columns = [bell, -2.0 * p[0] * bell * x * x / p[1]]
        if free:
            columns.append(2.0 * p[0] * bell * x * p[1])
        return np.stack(columns, axis=1)

    drop = np.clip(0.5 * (values[0] + values[-1]), 1e-3, 0.999)
    start = [1.0, sqrt(-log(drop)), 0.0][: 3 if free else 2]
    p = least_squares(residual, start, jacobian, method="lm", xtol=1e-12, ftol=1e-12).x
    rmse = peak * sqrt(2.0 * float(trapezoid(residual(p) ** 2, _GRID)) / 2.0)
    return Bell(peak * p[0], f_pk + (d * p[2] if free else 0.0), d / abs(p[1]), d, rmse)


def _held_fit(curve: PchipInterpolator, f_pk: float, peak: float, d: float) -> Bell:
    """Best fit of a bell that is centred at the peak and equals T_pk / sqrt 2 at both ends of the window."""
    values = curve(f_pk + d * _GRID) / peak

    def square(q: float) -> float:  # q = (d / c)^2
        return float(trapezoid((np.exp(q * (1.0 - _GRID**2)) / sqrt(2.0) - values) ** 2, _GRID))

    found = minimize_scalar(square, bounds=(1e-6, 9.0), method="bounded", options={"xatol": 1e-10})
    return Bell(peak * np.exp(found.x) / sqrt(2.0), f_pk, d / sqrt(found.x), d, peak * sqrt(found.fun))


def gaussian_fit(
    frequency: npt.ArrayLike,
    transmissibility: npt.ArrayLike,
    *,
    centre: Centre = "peak",
    window: Window = "objective",
    reach: float | None = None,
    draws: int = 30,
    seed: int = 0,
    noise: float | None = None,
) -> DampingEstimate:
    """Half-power damping of a Gaussian bell fitted to the highest peak (thesis, algorithm 2).

    Parameters
    ----------
    frequency
        (n,) frequencies, Hz, ascending.
    transmissibility
        (n,) complex T, or |T|; the magnitude is fitted.
    centre
        "peak": b = f_pk, as the printed equality requires; "free": b is fitted.
    window
        "objective": d as printed; "narrowest": the smallest d that the constraint allows.
    reach
        Largest d divided by f_pk; bells that would violate the constraint are then fitted with it. None searches the
        whole band. Allowed only for `centre="peak"` and `window="objective"`.
    draws, seed
        Number of noisy repetitions for the standard errors; seed of the noise.
    noise
        Standard deviation of |T|, if it is known; by default it is estimated from the curve.

    Returns
    -------
    DampingEstimate
        `details`: `bell` (`Bell`), `at_constraint` (whether the constraint determines the window), `centre`.

    Raises
    ------
    InputError
        If the arrays do not form a curve, centre or window is unknown, or `reach` is not positive or not allowed.

    Notes
    -----
    `f_n` is b; the standard errors are those of `scatter`. For exact curves of a single degree of freedom the narrowest
    window gives 0.978, 1.019, 1.08 and 1.24 times zeta for zeta = 0.1, 0.2, 0.3, 0.5 (docs/damping-estimators.md).
    """
    if centre not in ("peak", "free") or window not in ("objective", "narrowest"):
        raise InputError(
            f"unknown centre {centre!r} or window {window!r}",
            remedy="use centre 'peak' or 'free', and window 'objective' or 'narrowest'",
        )
    if reach is not None and not (reach > 0.0 and centre == "peak" and window == "objective"):
        raise InputError(
            f"reach = {reach!r} must be positive and needs centre='peak' and window='objective'", remedy="leave it out"
        )
    f, _, magnitude = checked_curve(frequency, transmissibility)
    found = _search(f, magnitude, centre, window, reach)
    if isinstance(found, str):
        return no_estimate(METHOD, found, half_power(f, magnitude).f_n)
    bell, peak, f_pk, at_constraint = found

    def again(noisy: FloatArray) -> tuple[float, float] | None:
        other = _search(f, noisy, centre, window, reach)
        return None if isinstance(other, str) else (other[0].b, other[0].zeta)

    f_error, zeta_error = scatter(f, magnitude, again, draws, seed, noise)
    return DampingEstimate(
        bell.b, bell.zeta, f_error, zeta_error, METHOD, misfit=bell.rmse / sqrt(2.0) / peak,
        window=(f_pk - bell.d, f_pk + bell.d), details={"bell": bell, "at_constraint": at_constraint, "centre": centre},
    )  # fmt: skip


def _search(
    f: FloatArray, magnitude: FloatArray, centre: Centre, window: Window, reach: float | None = None
) -> tuple[Bell, float, float, bool] | str:
    """`Bell`, height and frequency of the peak, and whether the half-power constraint determines the window.

    If there is no fit, the reason is returned instead.
    """
    read = half_power(f, magnitude)
    k = int(np.argmax(magnitude))
    if k in (0, f.size - 1):
        return read.reason
    f_pk, peak, level = read.f_n, read.peak, read.peak / sqrt(2.0)
    widest = min(f_pk - f[0], f[-1] - f_pk, np.inf if reach is None else reach * f_pk)
    narrowest = 0.5 * (_FEWEST_POINTS - 1) * float(np.median(np.diff(f[max(0, k - 3) : k + 4])))
    if widest < narrowest:
        return f"the band has fewer than {_FEWEST_POINTS} points around the peak at {f_pk:.5g} Hz"
    curve = PchipInterpolator(f, magnitude)
    bells: dict[float, Bell] = {}

    def bell_at(d: float) -> Bell:
        if d not in bells:
            bells[d] = _fit(curve, f_pk, peak, float(d), centre)
            if reach is not None and float(bells[d](f_pk + d)) > level:
                bells[d] = _held_fit(curve, f_pk, peak, float(d))
        return bells[d]

    def excess(d: float) -> float:  # height of the bell above half power at the ends of the window
        return float(bell_at(d)(np.array([f_pk - d, f_pk + d])).max()) - level

    def cost(d: float) -> float:
        return bell_at(d).rmse / d

    widths = np.geomspace(narrowest, widest, _WINDOWS)
    if window == "narrowest":  # nothing beyond the first admissible window is needed
        widths = widths[: next((k for k, d in enumerate(widths) if excess(d) <= 0.0), _WINDOWS) + 1]
    allowed = np.array([reach is not None or excess(d) <= 0.0 for d in widths])
    if not allowed.any():
        return f"no bell within {widest:.4g} Hz of the peak at {f_pk:.5g} Hz falls to half power"
    costs = np.where(allowed, [cost(d) for d in widths], np.inf)
    best = int(costs.argmin() if window == "objective" else allowed.argmax())
    bell, at_constraint = bell_at(widths[best]), False
    if best > 0 and not allowed[best - 1]:  # the constraint limits the search towards narrower windows
        edge = brentq(excess, widths[best - 1], widths[best], xtol=1e-10 * widths[best])
        if window == "narrowest" or cost(edge) <= cost(widths[best]):
            bell, at_constraint = bell_at(edge), True
    if (
        window == "objective"
        and not at_constraint
        and 0 < best < widths.size - 1
        and allowed[best - 1 : best + 2].all()
    ):
        inside = minimize_scalar(cost, bounds=(widths[best - 1], widths[best + 1]), method="bounded").x
        if (reach is not None or excess(inside) <= 0.0) and cost(inside) < costs[best]:
            bell = bell_at(inside)
    return bell, peak, f_pk, at_constraint
