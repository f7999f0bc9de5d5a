"""Slip criterion of a solid coil: largest shear resultant in a steady-state cycle compared with friction capacity.

The model is linear ("coiled stiff"): stresses are proportional to the base acceleration, so each point has one level of
the base acceleration, its onset level, above which it slips. Slip does not redistribute the stresses.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.constants import g as GRAVITY

from wroll_fem.coiled_stiff.modal_response import Oscillators
from wroll_fem.coiled_stiff.stress_modes import ShearModes
from wroll_fem.typing import ComplexArray, FloatArray


class ShearPerG(NamedTuple):
    """Steady-state shear stress in the coil, Pa, under a base acceleration of 1 g (0-peak); arrays (n_points,).

    Attributes
    ----------
    srz, srt
        Complex amplitudes S of Im(S e^(i W t)).
    resultant
        Maximum over the cycle of sqrt(srz^2 + srt^2).
    """

    srz: ComplexArray
    srt: ComplexArray
    resultant: FloatArray


def cycle_maximum(first: ComplexArray, second: ComplexArray) -> FloatArray:
    """Largest magnitude during a cycle of the vector (Im(``first`` e^(i W t)), Im(``second`` e^(i W t))).

    The vector describes an ellipse. Its squared magnitude is a constant plus a cosine of 2 W t, with the maximum
    (|first|^2 + |second|^2 + |first^2 + second^2|) / 2, the square of the major semi-axis.
    """
    first, second = np.asarray(first), np.asarray(second)
    mean = np.abs(first) ** 2 + np.abs(second) ** 2
    return np.asarray(np.sqrt(0.5 * (mean + np.abs(first**2 + second**2))))


def shear_per_g(modes: ShearModes, oscillators: Oscillators, frequency_hz: float) -> ShearPerG:
    """Steady-state shear stress in the coil under a sinusoidal base acceleration of 1 g amplitude.

    Parameters
    ----------
    modes
        Modes with their shear stress.
    oscillators
        The same modes as oscillators.
    frequency_hz
        Frequency of the base acceleration, Hz.
    """
    amplitudes = oscillators.steady(frequency_hz, GRAVITY)
    srz, srt = amplitudes @ modes.srz, amplitudes @ modes.srt
    return ShearPerG(srz, srt, cycle_maximum(srz, srt))


def slips(resultant: FloatArray, capacity: FloatArray) -> npt.NDArray[np.bool_]:
    """Mask of the points whose shear resultant exceeds the friction capacity (thesis, equations 2.17 and 2.18)."""
    return np.asarray(resultant > capacity)


def onset_levels(resultant_per_g: FloatArray, capacity: FloatArray) -> FloatArray:
    """(n_points,) base acceleration above which each point slips, g; infinite at points without shear stress."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(resultant_per_g > 0.0, capacity / resultant_per_g, np.inf)


class SlipZone(NamedTuple):
    """Extent of the slip zone at one level of the base acceleration; all values are 0 if no point slips.

    Attributes
    ----------
    volume_fraction
        Fraction of the volume of the coil that slips.
    height
        Height of the highest slipping point above the base, m.
    depth
        Distance of the outermost slipping point from the surface of the mandrel, m.
    """

    volume_fraction: float
    height: float
    depth: float


def slip_zone(modes: ShearModes, slipping: npt.NDArray[np.bool_], mandrel_radius: float) -> SlipZone:
    """Extent of the zone that consists of the slipping points.

    Parameters
    ----------
    modes
        Modes with the quadrature points of the coil.
    slipping
        (n_points,) mask of the slipping points.
    mandrel_radius
        Outer radius of the mandrel, m.
    """
    if not slipping.any():
        return SlipZone(0.0, 0.0, 0.0)
    fraction = float(modes.volumes[slipping].sum() / modes.volumes.sum())
    z, r = modes.points[slipping, 1], modes.points[slipping, 2]
    return SlipZone(fraction, float(z.max()), float(r.max() - mandrel_radius))


def driven_mode(modes: ShearModes) -> int:
    """Index of the mode with the largest effective mass along the excitation; `frequency: resonance` excites this mode.

    For a cantilevered roll this is the first bending mode, even if modes of torsion or axial shear, which the base
    motion hardly excites, have lower frequencies.
    """
    return int(np.argmax(np.asarray(modes.participation) ** 2))
