r"""Error of the time step, estimated for one degree of freedom: HHT lengthens the period and adds damping.

With the shift operator z, Newmark's formulas and HHT's equation of motion for :math:`\ddot u + 2 \zeta \omega \dot u +
\omega^2 u = -a_g` give for a step h

.. math::
    D(z)\, u = -h^2 N_u(z) E(z)\, a_g, \qquad
    D = z (z-1)^2 + E \left[2 \zeta \omega h\, (z-1) N_v + (\omega h)^2 N_u\right],

    N_u = \beta z^2 + (\gamma + \tfrac12 - 2 \beta) z + \tfrac12 + \beta - \gamma, \quad
    N_v = \gamma z + 1 - \gamma, \quad E = (1 + \alpha) z - \alpha,

which is a recursive filter of third order; the relative acceleration is :math:`-E (z-1)^2 a_g / D`. The same filter
with a tenth of the step is the reference. The error of a history therefore follows from the frequency and the damping
of the resonance alone. Near the resonance, the period error of 0.2 % at 40 steps per cycle acts as a detuning: it
changes a response with 1 % damping by about 10 %.

A roll that slips is not linear, and with friction a resonance is more sensitive to detuning than with a dashpot. Part
of the spring is then replaced by M parallel friction elements (Iwan 1966), each of stiffness
:math:`\kappa \omega^2 / M`, which slide at the displacements :math:`g_j = s\, ((j - \tfrac12)/M)^q`.
`fitted_oscillator` finds the oscillator whose history, at the time step of the run, is closest to the history of the
tip. The error of this oscillator is the estimate for the roll. The error of a slow sweep follows from its own curve
(`curve_error`).

References
----------
Hilber, Hughes, Taylor (1977), Earthquake Eng. Struct. Dyn. 5, 283, doi:10.1002/eqe.4290050306.
Iwan (1966), J. Appl. Mech. 33, 893, doi:10.1115/1.3625199.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter

from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.dynamics.trigonometric.oscillator import trigonometric_response
from wroll_fem.signals.base_motion import BaseMotion, SineMotion
from wroll_fem.typing import FloatArray

FINER = 10
"""Number of steps of the reference solution per step of the run."""

TRIALS = 0.25
"""Spacing of the trial frequencies when an oscillator is fitted, for at most `MOST_TRIALS` frequencies.

It is the phase difference, in cycles, between neighbouring trial frequencies at the end of the fitted record."""

TRIAL_DAMPING = (0.003, 0.02, 0.1)
"""Trial damping ratios when an oscillator is fitted."""

BAND = 0.4, 2.5
"""Lowest and highest trial frequency when an oscillator is fitted, divided by the excitation frequency."""

MOST_TRIALS = 400

FITTED_CYCLES = 100
"""Largest number of excitation cycles, from the start of a record, to which an oscillator is fitted. Later cycles
repeat earlier cycles or add no information."""

LEAST_SHAPE = 1e-9
"""Norm of the part of an oscillator's response that is not proportional to the base acceleration, relative to the whole
response, below which this part counts as zero."""

ELEMENTS = 16
"""Number of friction elements of an oscillator."""

LINEAR = 0.01
"""Misfit below which the fit of an oscillator ends. An oscillator without friction is fitted first."""


@dataclass(frozen=True)
class Oscillator:
    """Oscillator with one degree of freedom under base motion.

    Attributes
    ----------
    frequency_hz, zeta
        Natural frequency with all friction elements stuck, Hz, and viscous damping ratio.
    friction
        Share kappa of the stiffness that the friction elements provide; 0 for a linear oscillator.
    slip, spread
        Largest displacement s at which a friction element starts to slide, m, and exponent q of the distribution of
        these displacements.
    """

    frequency_hz: float
    zeta: float
    friction: float = 0.0
    slip: float = 1.0
    spread: float = 1.0

    def response(self, scheme: Scheme, dt: float, base: FloatArray, finer: int = 1) -> FloatArray:
        """(n,) relative displacement, m, from rest in steps ``dt`` (s) under base acceleration ``base`` (n,), m/s^2.

        A scheme with exact modes follows a base motion with ``finer`` samples per step, ((n - 1) finer + 1,).
        """
        turn = 2.0 * np.pi * self.frequency_hz
        limits = self.slip * ((np.arange(ELEMENTS) + 0.5) / ELEMENTS) ** self.spread
        if scheme.exact_modes:
            return trigonometric_response(turn, self.zeta, self.friction, limits, dt, base, finer)
        if self.friction == 0.0:
            numerator, denominator = self.filter(scheme, dt)
            return np.asarray(lfilter(numerator, denominator, base))
        out = np.zeros(len(base))
        parameters = (scheme.alpha, scheme.beta, scheme.gamma)
        _integrate(base, dt, parameters, turn**2, 2.0 * self.zeta * turn, self.friction, limits, out)
        return out

    def filter(self, scheme: Scheme, dt: float) -> tuple[FloatArray, FloatArray]:
        """Numerator and denominator of the transfer function u / a_g in z with all friction elements stuck.

        The coefficient of the highest power of z is first.
        """
        alpha, beta, gamma = scheme.alpha, scheme.beta, scheme.gamma
        turn = 2.0 * np.pi * self.frequency_hz * dt
        displacement = np.array([beta, gamma + 0.5 - 2.0 * beta, 0.5 + beta - gamma])
        velocity = np.array([gamma, 1.0 - gamma])
        weight = np.array([1.0 + alpha, -alpha])
        force = 2.0 * self.zeta * turn * np.polymul([1.0, -1.0], velocity) + turn**2 * displacement
        return (
            -(dt**2) * np.polymul(displacement, weight),
            np.polyadd([1.0, -2.0, 1.0, 0.0], np.polymul(weight, force)),
        )


@numba.njit(cache=True)
def _integrate(
    base: FloatArray, dt: float, parameters: tuple[float, float, float], stiffness: float, damping: float, share: float,
    limits: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """HHT integration of the oscillator with friction elements; fills the displacement ``out`` (n,), m."""
    alpha, beta, gamma = parameters
    count = limits.shape[0]
    each, rest = share * stiffness / count, (1.0 - share) * stiffness
    elastic, trial = np.zeros(count), np.zeros(count)
    u, v, a, r = 0.0, 0.0, -base[0], base[0]
    for n in range(1, base.shape[0]):
        start = u + dt * v + dt * dt * (0.5 - beta) * a
        x = 2.0 * u - out[n - 2] if n > 1 else u
        force, v_new, a_new = 0.0, 0.0, 0.0
        for _ in range(30):
            a_new = (x - start) / (beta * dt * dt)
            v_new = v + dt * ((1.0 - gamma) * a + gamma * a_new)
            force, tangent = rest * x + damping * v_new + base[n], rest + damping * gamma / (beta * dt)
            for j in range(count):
                moved = elastic[j] + x - u
                trial[j] = min(max(moved, -limits[j]), limits[j])
                force += each * trial[j]
                if trial[j] == moved:
                    tangent += each
            gap = a_new + (1.0 + alpha) * force - alpha * r
            change = gap / (1.0 / (beta * dt * dt) + (1.0 + alpha) * tangent)
            if abs(gap) <= 1e-12 * (abs(a_new) + abs(force)):
                break
            x -= change
        elastic[:] = trial
        u, v, a, r = x, v_new, a_new, force
        out[n] = u


def history_error(scheme: Scheme, dt: float, motion: BaseMotion, oscillator: Oscillator) -> float:
    """Largest error of the displacement history of an oscillator, relative to its largest displacement.

    Parameters
    ----------
    dt
        Time step, s.
    motion
        Base motion; its acceleration is zero at the start.
    """
    steps = int(np.ceil(motion.duration / dt - 1e-9))
    fine = motion.acceleration(dt / FINER * np.arange(steps * FINER + 1))
    right = oscillator.response(scheme, dt / FINER, fine)[::FINER]
    coarse = (fine, FINER) if scheme.exact_modes else (fine[::FINER], 1)
    found = oscillator.response(scheme, dt, *coarse)
    return float(np.abs(found - right).max() / np.abs(right).max())


def period_error(scheme: Scheme, dt: float, frequency: float, stuck: float | None = None) -> float:
    """Relative lengthening of the period of a resonance at ``frequency`` (Hz), which is at ``stuck`` (Hz) without slip.

    With exact modes only the softening by slip has an error (docs/trigonometric.md); it is 0 if ``stuck`` is None.
    """
    if not scheme.exact_modes:
        return numerical_damping(scheme, 2.0 * np.pi * frequency * dt)[1]
    if stuck is None or not stuck > frequency:
        return 0.0
    softened = (frequency / stuck) ** 2
    return float(softened * (1.0 - softened) * (2.0 * np.pi * stuck * dt) ** 4 / 480.0)


def curve_error(
    scheme: Scheme, dt: float, frequency: FloatArray, magnitude: FloatArray, zeta: float, stuck: float | None = None
) -> float:
    """Largest error of |T| in a slow sweep through a resonance, relative to the peak, from the computed curve.

    The longer period shifts the whole curve to lower frequencies, also where friction makes a flank steep. The damping
    that the scheme adds lowers the peak.

    Parameters
    ----------
    dt
        Time step, s.
    frequency, magnitude
        (n,) Hz and (n,) |T| of the computed curve.
    zeta
        Damping ratio at the peak.
    stuck
        Resonance with stuck interfaces, Hz, for a scheme with exact modes.
    """
    peak = float(frequency[int(np.argmax(magnitude))])
    added = numerical_damping(scheme, 2.0 * np.pi * peak * dt)[0]
    lengthening = period_error(scheme, dt, peak, stuck) * (frequency / peak) ** 2  # second order in the step
    shifted = np.interp(frequency * (1.0 - lengthening), frequency, magnitude)
    lost = added / zeta
    return max(float(np.abs(shifted - magnitude).max() / magnitude.max()), lost / (1.0 + lost))


def without_ripple(magnitude: FloatArray) -> FloatArray:
    """(n,) |T| of a slow upward sweep, without the ripple below its peak.

    There the curve is replaced by the mean of the closest curves above and below that grow up to the peak. Slip makes a
    sweep ring on a steep flank. A shift of this ripple looks like an error that no step removes, because a smaller step
    damps the ripple less. In a fast sweep the ripple is the transient, which the longer period does shift.
    """
    before = magnitude[: int(np.argmax(magnitude)) + 1]
    above, below = np.maximum.accumulate(before), np.minimum.accumulate(before[::-1])[::-1]
    return np.concatenate([0.5 * (above + below), magnitude[len(before) :]])


def fitted_oscillator(
    scheme: Scheme, dt: float, motion: SineMotion, displacement: FloatArray
) -> tuple[Oscillator, float]:
    """Oscillator whose displacement history with steps ``dt`` (s), scaled by a factor, is closest to a given history.

    Parts of the histories that are proportional to the base acceleration are not compared.

    Parameters
    ----------
    motion
        Base motion of the history, with an almost constant frequency.
    displacement
        (n,) displacement of the tip relative to the base, m.

    Returns
    -------
    oscillator : Oscillator
    misfit : root mean square of the difference divided by the root mean square of the displacement, both in the first
        `FITTED_CYCLES` cycles
    """
    driven = float(np.mean(motion.frequency(np.array([0.0, motion.duration]))))
    displacement = displacement[: 1 + int(FITTED_CYCLES / (driven * dt))]
    base = motion.acceleration(dt * np.arange(len(displacement)))
    rigid = base / np.linalg.norm(base)
    wanted = displacement / np.linalg.norm(displacement)
    wanted -= (rigid @ wanted) * rigid  # the part along the base motion, which any factor of it takes up

    def gap(oscillator: Oscillator) -> FloatArray:
        """Difference (n,) between the scaled oscillator response and the history, relative to the norm of the history.

        The parts along the base acceleration are removed from both.
        """
        shape = oscillator.response(scheme, dt, base)
        shape /= np.linalg.norm(shape)
        shape -= (rigid @ shape) * rigid
        size = float(np.linalg.norm(shape))
        if size < LEAST_SHAPE:
            return -wanted
        shape /= size
        shape *= shape @ wanted
        shape -= wanted
        return shape

    low, high = (driven * part for part in BAND)
    count = int(np.clip(np.log(high / low) * driven * dt * len(base) / TRIALS, 30, MOST_TRIALS))
    trials = [Oscillator(f, zeta) for f in np.geomspace(low, high, count) for zeta in TRIAL_DAMPING]
    start = min(trials, key=lambda one: float(np.linalg.norm(gap(one))))
    least, most = np.log([0.5 * low, 1e-6]), np.log([2.0 * high, 0.9])
    fit = least_squares(
        lambda p: gap(Oscillator(*np.exp(p))), np.log([start.frequency_hz, start.zeta]), bounds=(least, most),
        x_scale=[1e-3, 0.1],
    )  # fmt: skip
    best, misfit = Oscillator(*(float(x) for x in np.exp(fit.x))), float(np.linalg.norm(fit.fun))
    if misfit < LINEAR:
        return best, misfit
    chosen = best
    reach = float(np.abs(best.response(scheme, dt, base)).max())
    lower, upper = np.log([0.5 * low, 1e-6, 0.01, 1e-3, 0.1]), np.log([2.0 * high, 0.9, 0.99, 1e3, 4.0])

    def of(p: FloatArray) -> Oscillator:
        frequency, zeta, friction, slip, spread = (float(x) for x in np.exp(p))
        return Oscillator(frequency, zeta, friction, slip * reach, spread)

    for stiffer in (1.0, 1.03, 1.08):  # the frequency of the linear fit lies below that of sticking
        for friction, slip in ((0.2, 1.0), (0.5, 3.0)):
            first = np.log([best.frequency_hz * stiffer, 1e-3, friction, slip, 1.0])
            fit = least_squares(
                lambda p: gap(of(p)), first, bounds=(lower, upper), x_scale=[1e-3, 1.0, 0.1, 0.1, 0.1], max_nfev=40
            )
            found = float(np.linalg.norm(fit.fun))
            if found < misfit:
                misfit, chosen = found, of(fit.x)
            if misfit < LINEAR:
                return chosen, misfit
    return chosen, misfit


def steps_for(error: float, steps: int, wanted: float) -> int:
    """Number of steps per cycle, a multiple of 10, that reduces a second-order ``error`` to ``wanted``.

    ``steps`` is the number of steps per cycle with this error.
    """
    return int(10 * np.ceil(steps * np.sqrt(error / wanted) / 10.0))
