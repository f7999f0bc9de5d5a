r"""Spectra of a nonlinear mode under a random base acceleration, from the averaged Fokker-Planck equation.

With the angle :math:`\theta` of the motion beside its action J (see `amplitude_process`), the tip moves as
:math:`X(J) \cos\theta`, and the first harmonic of the density in the angle obeys

.. math:: \partial_t p_1 = L p_1, \qquad
   -L = -\partial_J \tfrac12 d\, \partial_J - \partial_J \frac{D}{2\pi} + \frac{W G'^2}{8} + i \omega(J) .

Correlation and spectrum of the displacement follow from its resolvent :math:`(i\Omega - L)^{-1}`, and so does the
linear response of the mean to a small added base motion, which is the estimate H1 of a measurement. With p_1 = p u the
operator is symmetric, and linear elements in :math:`\sqrt J` are exact for a linear oscillator (u proportional to its
amplitude). The detuning :math:`\Omega - \omega` is replaced by :math:`(\Omega^2 - \omega^2) / (2 \Omega)`, and spectra
are those of the velocity: then a linear oscillator has its exact spectrum at every frequency,

.. math::
   W_v(\Omega) = \mathrm{Re} \left\langle \omega X, M^{-1}\, \omega X\, p \right\rangle, \qquad
   H_x(\Omega) = \frac{i}{\Omega} \left\langle \omega X, M^{-1} \frac{A}{W(\omega)}\, p \right\rangle,
   \quad A = \frac{D}{\pi G} ,

where A is the base acceleration that holds the amplitude at resonance. The width of the line contains the damping, the
wandering of the frequency with the amplitude, and how fast the amplitude wanders. Higher harmonics are neglected.

References
----------
Stratonovich (1963), Topics in the Theory of Random Noise, vol. 1; Risken (1996), The Fokker-Planck Equation, chapter 7
(linear response, doi:10.1007/978-3-642-61544-3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.integrate import trapezoid
from scipy.linalg import solve_banded

from wroll_fem.signals.averaging.amplitude_process import GAUSS_POINTS, AmplitudeDensity, Density
from wroll_fem.typing import FloatArray

ComplexArray = npt.NDArray[np.complex128]


UNDAMPED = 1e-6
"""Damping ratio below which a mode beside the nonlinear one counts as undamped."""
LEAST_WIDTH = 1e-5
"""Least damping ratio for which the frequency axis is refined."""
LEAST_PARTICIPATION, MOST_LINES = 1e-4, 30
"""Participation at the tip from which a further mode has its own points on the frequency axis; most such modes."""


@dataclass(frozen=True)
class LinearModes:
    """Modes beside the nonlinear one; they respond linearly.

    Attributes
    ----------
    frequency : (m,) rad/s
    damping : (m,) damping ratios
    participation : (m,) tip displacement of the mode times its participation factor; with the nonlinear mode, the sum
        over all modes is 1 at the tip of a structure on a rigid base
    """

    frequency: FloatArray
    damping: FloatArray
    participation: FloatArray

    @classmethod
    def none(cls) -> LinearModes:
        """No further mode."""
        return cls(np.zeros(0), np.zeros(0), np.zeros(0))

    def displacement(self, omega: FloatArray) -> ComplexArray:
        """(n,) tip displacement per base acceleration at ``omega`` (rad/s), s^2; without modes that are `loose`."""
        kept = ~self.loose((float(omega.min()), float(omega.max())))
        w, z, share = (a[kept, None] for a in (self.frequency, self.damping, self.participation))
        return -np.asarray((share / (w**2 - omega**2 + 2j * z * w * omega)).sum(axis=0))

    def loose(self, band: tuple[float, float]) -> npt.NDArray[np.bool_]:
        """(m,) whether a mode lies in a ``band`` (rad/s) without damping, so that its response is not bounded."""
        return np.asarray((self.damping < UNDAMPED) & (self.frequency >= band[0]) & (self.frequency <= band[1]))


@dataclass(frozen=True)
class ResponseSpectra:
    """Spectra of the tip; one-sided densities per Hz.

    Attributes
    ----------
    frequency : (n,) Hz
    base : (n,) PSD of the base acceleration, (m/s^2)^2/Hz
    displacement : (n,) PSD of the displacement relative to the base, m^2/Hz
    acceleration : (n,) PSD of the absolute acceleration, (m/s^2)^2/Hz
    transmissibility : (n,) complex H1: cross-spectrum of absolute tip and base acceleration divided by `base`
    mode_displacement : (n,) PSD of the displacement in the nonlinear mode alone, m^2/Hz
    mode_acceleration : (n,) PSD of its acceleration relative to the base, (m/s^2)^2/Hz
    """

    frequency: FloatArray
    base: FloatArray
    displacement: FloatArray
    acceleration: FloatArray
    transmissibility: ComplexArray
    mode_displacement: FloatArray
    mode_acceleration: FloatArray

    def rms(self, name: str) -> float:
        """Root mean square of a spectrum in its band; trapezoidal rule in the logarithm of the frequency."""
        return float(np.sqrt(trapezoid(getattr(self, name) * self.frequency, np.log(self.frequency))))


def _elements(law: AmplitudeDensity) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Shape functions (3, 2) and, per cell, the matrices (cells, 2, 2) of dissipation, mass and squared frequency."""
    step = np.diff(law.nodes)[:, None]
    shape = np.stack([1.0 - GAUSS_POINTS, GAUSS_POINTS], axis=1)
    slope = np.array([-1.0, 1.0])
    spread = law.share * law.psd / (32.0 * law.root**2)
    both = shape[:, :, None] * shape[:, None, :]
    loss = np.einsum("cg,ij->cij", spread * law.base**2 / step**2, np.outer(slope, slope))
    loss += np.einsum("cg,gij->cij", spread * law.base_slope**2, both)
    mass = np.einsum("cg,gij->cij", law.share, both)
    stiffness = np.einsum("cg,gij->cij", law.share * law.frequency**2, both)
    return shape, loss, mass, stiffness


def _bands(cells: FloatArray) -> FloatArray:
    """(3, nodes - 1) bands of the assembled symmetric matrix without the first node, for `solve_banded`."""
    main = np.append(cells[1:, 0, 0], 0.0) + cells[:, 1, 1]
    off = cells[1:, 0, 1]
    return np.array([np.append(0.0, off), main, np.append(off, 0.0)])


def mode_spectra(law: AmplitudeDensity, psd: Density, frequency: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """PSD of the tip velocity (m^2/s^2/Hz), and tip displacement per base acceleration (s^2), of the nonlinear mode.

    Parameters
    ----------
    law
        Stationary density of the amplitude.
    psd
        One-sided PSD of the base acceleration.
    frequency
        (n,) frequencies, Hz, above zero.

    Returns
    -------
    (n,) PSD and (n,) complex response. Neither contains the base motion itself.
    """
    shape, *cells = _elements(law)
    loss, mass, stiffness = (_bands(c) for c in cells)

    def weighed(values: FloatArray) -> FloatArray:  # (nodes - 1,) integral of values times each shape function
        parts = np.einsum("cg,gi->ci", law.share * values, shape)
        return np.append(parts[1:, 0], 0.0) + parts[:, 1]

    velocity = law.frequency * law.tip
    action = law.root**2
    holding = 4.0 * law.damping * law.frequency * action / law.base
    rows = weighed(velocity)
    given = np.stack([weighed(velocity / law.psd), weighed(holding / law.psd)], axis=1)
    spectrum, response = np.empty(len(frequency)), np.empty(len(frequency), dtype=np.complex128)
    omega = 2.0 * np.pi * frequency
    for k, (w, level) in enumerate(zip(omega, psd(frequency), strict=True)):
        matrix = loss + 1j * (0.5 * w * mass - stiffness / (2.0 * w))
        found = rows @ solve_banded((1, 1), matrix, given, overwrite_ab=True, check_finite=False)
        spectrum[k] = level * found[0].real
        response[k] = 1j / w * found[1]
    return spectrum, response


def frequency_axis(
    law: AmplitudeDensity, band: tuple[float, float], corners: FloatArray, others: LinearModes | None = None
) -> FloatArray:
    """(n,) frequencies, Hz, in a band: geometric, the corners of the PSD, and dense at the resonances."""
    low, high = band
    order = np.argsort(law.frequency.ravel())
    spread = np.cumsum((law.share * law.tip**2).ravel()[order])
    shares = np.linspace(0.002, 0.998, 41)
    at = np.interp(shares, spread / spread[-1], law.frequency.ravel()[order]) / (2.0 * np.pi)
    width = max(law.mean_damping, LEAST_WIDTH)
    lines = [np.linspace(at[0], at[-1], 81), at, *(_line(at[k], width, 141) for k in (0, 10, 20, 30, 40))]
    if others is not None:
        hertz = others.frequency / (2.0 * np.pi)
        inside = (hertz > low) & (hertz < high) & (others.damping >= UNDAMPED)
        heard = np.flatnonzero(inside & (np.abs(others.participation) > LEAST_PARTICIPATION))
        lines += [_line(float(hertz[k]), max(float(others.damping[k]), LEAST_WIDTH), 61) for k in heard[:MOST_LINES]]
    axis = np.unique(np.concatenate([np.geomspace(low, high, 241), corners, *lines]))
    axis = axis[(axis >= low) & (axis <= high)]
    return axis[np.concatenate([[True], np.diff(axis) > 1e-4 * width * axis[1:]])]


def _line(centre: float, width: float, points: int) -> FloatArray:
    """Frequencies around a resonance of the damping ratio ``width``, denser at its centre."""
    return np.asarray(centre * (1.0 + width * np.sinh(np.linspace(-6.0, 6.0, points)) / 3.0))


def response_spectra(
    law: AmplitudeDensity, psd: Density, frequency: FloatArray, others: LinearModes | None = None, *, rigid: float = 1.0
) -> ResponseSpectra:
    """Spectra of displacement and absolute acceleration of the tip, with the linear response of the ``others``.

    ``rigid`` is the tip displacement per displacement of the base in rigid-body motion.
    """
    omega, base = 2.0 * np.pi * frequency, psd(frequency)
    velocity, main = mode_spectra(law, psd, frequency)
    other = (others or LinearModes.none()).displacement(omega)
    carried = rigid - omega**2 * other
    moved = velocity / omega**2 + base * (np.abs(other) ** 2 + 2.0 * np.real(np.conj(other) * main))
    shaken = omega**2 * velocity + base * (np.abs(carried) ** 2 - 2.0 * np.real(np.conj(carried) * omega**2 * main))
    return ResponseSpectra(
        frequency, base, np.maximum(moved, 0.0), np.maximum(shaken, 0.0), carried - omega**2 * main,
        velocity / omega**2, velocity * omega**2,
    )  # fmt: skip
