r"""Amplitude of a nonlinear mode under a random base acceleration: stationary density by stochastic averaging.

A backbone gives frequency :math:`\omega`, damping ratio :math:`\zeta` and motion at every amplitude. Its coordinate
here is the action J: the area that a period encloses in the plane of displacement and momentum, divided by 2 pi. J is
twice the mean kinetic energy divided by :math:`\omega`, and dE = :math:`\omega` dJ holds at any strength of the
nonlinearity. A base acceleration with the one-sided power spectral density W (per Hz) moves J as a diffusion,

.. math::
   \partial_t p = \partial_J\left(\tfrac12 d\, \partial_J p\right) + \partial_J\left(\frac{D}{2\pi} p\right), \qquad
   d(J) = \frac{W(\omega) G^2}{4}, \quad D(J) = 4 \pi \zeta \omega J ,

where D is the dissipation per cycle and G the amplitude of the base's share of the motion,
:math:`|r^T M \hat u|`, so that a sine of amplitude A at resonance does the work :math:`\pi A G`. Without
probability flux,

.. math:: p(J) = C \exp\left(-\int_0^J \frac{16\, \zeta\, \omega J'}{W G^2}\, dJ'\right) .

A linear oscillator has :math:`G^2 = 2 \Gamma^2 J / \omega`: J is exponential, the displacement Gaussian.

References
----------
Roberts and Spanos (1986), Int. J. Non-Linear Mechanics 21, 111: stochastic averaging.
Stratonovich (1963), Topics in the Theory of Random Noise, vol. 1, chapter 4: the averaged Fokker-Planck equation.
Zhu and Lin (1991), J. Engineering Mechanics 117, 1890: energy envelope.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

Density = Callable[[FloatArray], FloatArray]
"""One-sided power spectral density of the base acceleration, (m/s^2)^2/Hz, as a function of the frequency in Hz."""

LEAST_DENSITY = 1e-9
"""Least PSD relative to its largest value at the frequencies of a backbone. Where the PSD is zero, the amplitude does
not grow."""
NEGLIGIBLE = 40.0
"""The density is followed until its share of the mean square is below exp(-NEGLIGIBLE) of the largest."""
NO_DAMPING = 1e-9
"""Damping ratio up to which that of a computed backbone is regarded as rounding error."""
EVEN_CELLS, GRADED_CELLS = 360, 120
"""Cells of the amplitude axis: of equal length, and in geometric progression towards zero."""
GAUSS_POINTS, GAUSS_WEIGHTS = (0.5 + 0.5 * np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])), np.array([5.0, 8.0, 5.0]) / 18


def _running_weights() -> FloatArray:
    """(3, 3) weights that integrate the parabola through the Gauss points from the start of a cell to each of them."""
    powers = np.vander(GAUSS_POINTS, increasing=True)
    integrals = np.stack([GAUSS_POINTS ** (k + 1) / (k + 1) for k in range(3)], axis=1)
    return np.asarray(integrals @ np.linalg.inv(powers))


RUNNING_WEIGHTS = _running_weights()


@dataclass(frozen=True)
class NonlinearMode:
    """Backbone of a resonance, point by point with increasing amplitude.

    Below the first point and beyond the last, frequency, damping and the shape of the motion stay as they are there.

    Attributes
    ----------
    frequency : (p,) rad/s
    damping : (p,) damping ratio: dissipation per cycle divided by 4 pi `energy`
    energy : (p,) twice the mean kinetic energy of a period, J
    base : (p,) work of the base per cycle at resonance, divided by pi and the amplitude of its acceleration, kg m
    tip : (p,) amplitude of the displacement at the tip, m, with the sign of its direction relative to the base's work
    """

    frequency: FloatArray
    damping: FloatArray
    energy: FloatArray
    base: FloatArray
    tip: FloatArray

    def __post_init__(self) -> None:
        arrays = [np.atleast_1d(np.asarray(a, dtype=np.float64)) for a in vars(self).values()]
        for name, array in zip(vars(self), arrays, strict=True):
            object.__setattr__(self, name, array)
        if len({a.shape for a in arrays}) != 1 or arrays[0].ndim != 1 or not all(np.isfinite(a).all() for a in arrays):
            raise InputError("the arrays of a backbone must be finite and of equal length", key="backbone")
        if min(float(self.frequency.min()), float(self.energy.min()), float(np.abs(self.base).min())) <= 0.0:
            raise InputError(
                "frequency, energy and base motion of a backbone must be positive", key="backbone",
                remedy="use the mode that the base excites",
            )  # fmt: skip
        if (np.diff(self.root) <= 0.0).any():
            raise InputError(
                "the energy does not increase along the backbone (internal resonance)", key="backbone",
                remedy="lower backbone.tip_largest",
            )  # fmt: skip

    @classmethod
    def of_oscillator(
        cls, amplitude: npt.ArrayLike, frequency: npt.ArrayLike, damping: npt.ArrayLike,
        *, mass: float = 1.0, participation: float = 1.0,
    ) -> NonlinearMode:  # fmt: skip
        """Backbone of one degree of freedom: displacement ``amplitude`` (m), ``frequency`` (rad/s), damping ratio.

        The base works on ``participation`` times the ``mass`` (kg).
        """
        a, w, z = (np.atleast_1d(np.asarray(x, dtype=np.float64)) for x in (amplitude, frequency, damping))
        return cls(w, z, 0.5 * mass * (w * a) ** 2, participation * mass * a, a)

    @cached_property
    def root(self) -> FloatArray:
        """(p,) square root of the action, (J s)^(1/2)."""
        return np.asarray(np.sqrt(self.energy / self.frequency))

    def at(self, root: FloatArray, values: FloatArray, *, derivative: bool = False) -> FloatArray:
        """Values (p, ...) at points of the backbone, interpolated at ``root``; constant beyond its ends."""
        shape = (*np.shape(root), *values.shape[1:])
        if len(values) == 1:
            return np.zeros(shape) if derivative else np.broadcast_to(values[0], shape)
        x = np.log(np.maximum(root, 1e-300) / self.root[0])
        last = float(np.log(self.root[-1] / self.root[0]))
        curve = PchipInterpolator(np.log(self.root / self.root[0]), values)
        if not derivative:
            return np.asarray(curve(np.clip(x, 0.0, last)))
        slope = curve(np.clip(x, 0.0, last), 1)
        inside = ((x >= 0.0) & (x <= last)).reshape(*np.shape(root), *[1] * (values.ndim - 1))
        return np.where(inside, slope, 0.0)  # by the logarithm of the root

    def amplitude_at(self, root: FloatArray, values: FloatArray) -> FloatArray:
        """Amplitudes (p, ...) interpolated at ``root``; proportional to it beyond the ends of the backbone."""
        more = [1] * (values.ndim - 1)
        return np.asarray(root.reshape(*root.shape, *more) * self.at(root, values / self.root.reshape(-1, *more)))


@dataclass(frozen=True)
class AmplitudeDensity:
    """Stationary density of the amplitude of a nonlinear mode under a random base acceleration.

    The other arrays hold values at three Gauss points per cell of the amplitude axis, (cells, 3).

    Attributes
    ----------
    mode : the backbone
    nodes : (cells + 1,) square roots of the action, (J s)^(1/2)
    action_density : (cells + 1,) probability per unit of action at the nodes, 1/(J s)
    root : square root of the action
    density : probability per unit of `root`
    share : probability of each point; the sum is 1
    frequency : rad/s
    damping : damping ratio
    base : amplitude of the base's share of the motion, kg m
    base_slope : its derivative by `root`
    tip : amplitude at the tip, m
    psd : PSD of the base acceleration at the frequency of the amplitude, (m/s^2)^2/Hz
    """

    mode: NonlinearMode
    nodes: FloatArray
    action_density: FloatArray
    root: FloatArray
    density: FloatArray
    share: FloatArray
    frequency: FloatArray
    damping: FloatArray
    base: FloatArray
    base_slope: FloatArray
    tip: FloatArray
    psd: FloatArray

    @property
    def energy(self) -> FloatArray:
        """Twice the mean kinetic energy of a period, J."""
        return np.asarray(self.frequency * self.root**2)

    @property
    def power(self) -> FloatArray:
        """Dissipated power at each amplitude, W."""
        return np.asarray(2.0 * self.damping * self.frequency * self.energy)

    def mean(self, values: FloatArray) -> FloatArray:
        """Expected value of ``values`` (cells, 3, ...)."""
        return np.asarray(np.tensordot(self.share, values, axes=2))

    @cached_property
    def weights(self) -> FloatArray:
        """(p,) weights of the points of the backbone in the mean of a squared amplitude.

        Between the points the square is linear in the action, below the first and beyond the last proportional to it.
        """
        known, action, share = self.mode.root**2, self.root.ravel() ** 2, self.share.ravel()
        right = np.clip(np.searchsorted(known, action), 1, max(len(known) - 1, 1))
        out = np.zeros(len(known))
        inside = (action > known[0]) & (action < known[-1])
        if inside.any():
            k = right[inside]
            part = (action[inside] - known[k - 1]) / (known[k] - known[k - 1])
            np.add.at(out, k, share[inside] * part)
            np.add.at(out, k - 1, share[inside] * (1.0 - part))
        low, high = action <= known[0], (action >= known[-1]) & (action > known[0])
        out[0] += np.sum(share[low] * action[low]) / known[0]
        out[-1] += np.sum(share[high] * action[high]) / known[-1]
        return out

    def rms(self, amplitude: FloatArray) -> FloatArray:
        """(...) root mean square of quantities from their ``amplitude`` (p, ...) at the points of the backbone."""
        return np.asarray(np.sqrt(0.5 * np.tensordot(self.weights, amplitude**2, axes=1)))

    def mean_power(self, work: FloatArray) -> float:
        """Mean power, W, from the ``work`` per cycle (p,), J, at the points of the backbone."""
        per_action = self.mode.at(self.root, work / self.mode.root**2)
        return float(self.mean(per_action * self.root**2 * self.frequency) / (2.0 * np.pi))

    @property
    def mean_frequency(self) -> float:
        """Mean number of cycles per second, Hz: upward crossings of zero."""
        return float(self.mean(self.frequency) / (2.0 * np.pi))

    @property
    def mean_damping(self) -> float:
        """Mean dissipated power divided by twice the mean frequency (rad/s) and `energy`; zeta of a linear mode."""
        return float(self.mean(self.power) / (2.0 * self.mean(self.frequency) * self.mean(self.energy)))

    @property
    def tip_rms(self) -> float:
        """Root mean square of the displacement at the tip, m."""
        return float(np.sqrt(0.5 * self.mean(self.tip**2)))

    @property
    def input_power(self) -> float:
        """Mean power of the base, W: the diffusion of the action times the frequency, against the slope of the density.

        It equals the mean dissipated power, because the stationary density has no probability flux. The slope is taken
        from the density at the nodes, so that the comparison checks density and grid.
        """
        spread = self.frequency * self.psd * self.base**2 / 8.0
        return float(np.sum((spread @ GAUSS_WEIGHTS) * -np.diff(self.action_density)))

    def tip_exceeded(self, probability: float) -> float:
        """Tip amplitude, m, that a cycle exceeds with the given probability."""
        sizes, weights = np.abs(self.tip).ravel(), (self.share * self.frequency).ravel()
        order = np.argsort(sizes)
        above = 1.0 - (np.cumsum(weights[order]) - 0.5 * weights[order]) / weights.sum()
        return float(np.interp(-probability, -above, sizes[order]))

    def beyond(self) -> float:
        """Share of the mean square at the tip at amplitudes beyond the last point of the backbone."""
        square = self.share * self.tip**2
        return float(square[self.root > self.mode.root[-1]].sum() / square.sum())

    def below(self) -> float:
        """Share of the mean square at the tip at amplitudes below the first point of the backbone."""
        square = self.share * self.tip**2
        return float(square[self.root < self.mode.root[0]].sum() / square.sum())


def density_of(psd: Density, frequency: FloatArray, largest: float) -> FloatArray:
    """PSD at ``frequency`` (rad/s), at least `LEAST_DENSITY` of its ``largest`` value."""
    return np.maximum(psd(np.asarray(frequency / (2.0 * np.pi))), LEAST_DENSITY * largest)


def amplitude_density(mode: NonlinearMode, psd: Density, *, largest: float | None = None) -> AmplitudeDensity:
    """Stationary density of the amplitude of a mode under a base acceleration with a power spectral density.

    Parameters
    ----------
    mode
        Backbone of the resonance.
    psd
        One-sided PSD, (m/s^2)^2/Hz; 0 outside its band.
    largest
        Its largest value; by default its largest value at the frequencies of the backbone.

    Raises
    ------
    InputError
        If the PSD is zero at every frequency of the backbone, or the backbone has no damping at all.
    """
    top = float(np.max(psd(mode.frequency / (2.0 * np.pi)))) if largest is None else largest
    if not top > 0.0:
        raise InputError(
            f"the PSD is zero at the resonance, {mode.frequency.min() / (2 * np.pi):.5g} to "
            f"{mode.frequency.max() / (2 * np.pi):.5g} Hz", key="excitation.psd", remedy="extend its frequencies",
        )  # fmt: skip
    if mode.damping[-1] <= NO_DAMPING:
        raise InputError(
            "the backbone has no damping at its largest amplitude, so that the amplitude grows without limit",
            key="damping", remedy="give the material damping, or raise backbone.tip_largest",
        )  # fmt: skip

    def rate(root: FloatArray) -> FloatArray:  # derivative of the exponent by the action
        w, zeta = mode.at(root, mode.frequency), np.maximum(mode.at(root, mode.damping), 0.0)
        return 16.0 * zeta * w / (density_of(psd, w, top) * mode.at(root, mode.base / mode.root) ** 2)

    nodes = _nodes(mode, rate)
    step = np.diff(nodes)[:, None]
    root = nodes[:-1, None] + step * GAUSS_POINTS
    slope = 2.0 * root * rate(root)
    cells = step[:, 0] * (slope @ GAUSS_WEIGHTS)
    ends = np.concatenate([[0.0], np.cumsum(cells)])
    exponent = ends[:-1, None] + step * (slope @ RUNNING_WEIGHTS.T)
    density = 2.0 * root * np.exp(-exponent)
    share = density * step * GAUSS_WEIGHTS
    total = share.sum()
    frequency, ratio = mode.at(root, mode.frequency), mode.base / mode.root
    return AmplitudeDensity(
        mode=mode, nodes=nodes, action_density=np.exp(-ends) / total,
        root=root, density=density / total, share=share / total, frequency=frequency,
        damping=np.maximum(mode.at(root, mode.damping), 0.0), base=mode.amplitude_at(root, mode.base),
        base_slope=mode.at(root, ratio) + mode.at(root, ratio, derivative=True),
        tip=mode.amplitude_at(root, mode.tip), psd=density_of(psd, frequency, top),
    )  # fmt: skip


def _nodes(mode: NonlinearMode, rate: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Nodes of the amplitude axis, from 0 to where the density is negligible; ``rate``: d exponent / d action."""
    coarse = np.geomspace(1e-12 * mode.root[0], 1e12 * mode.root[-1], 12000)
    growth = rate(coarse)
    exponent = growth[0] * coarse[0] ** 2 + np.concatenate(
        [[0.0], np.cumsum(0.5 * (growth[1:] + growth[:-1]) * np.diff(coarse**2))]
    )
    size = 4.0 * np.log(coarse) - exponent  # of the mean square, per unit of ln(root)
    kept = np.flatnonzero(size > size.max() - NEGLIGIBLE)
    low, high = coarse[kept[0]], coarse[min(kept[-1] + 1, len(coarse) - 1)]
    inner = mode.root[(mode.root > low) & (mode.root < high)]
    even = np.linspace(0.0, high, EVEN_CELLS + 1)
    graded = np.geomspace(low, high, GRADED_CELLS + 1)
    nodes = np.unique(np.concatenate([even, graded, inner]))
    return nodes[np.concatenate([[True], np.diff(nodes) > 1e-9 * high])]
