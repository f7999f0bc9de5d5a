"""Where a solid coil would slip: shear resultant over a steady cycle against the friction capacity. FEM-free.

The model is linear ("coiled stiff"): stresses grow in proportion to the base acceleration, so each point has one
level, its onset, from which on it would slip. Slip itself is not followed: stresses do not redistribute.
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
    """Steady shear stress at every point of the coil under 1 g (0-peak) of base acceleration, (n_points,) each, Pa.

    Attributes
    ----------
    srz, srt
        Complex amplitudes S of Im(S e^(i W t)).
    resultant
        Largest sqrt(srz^2 + srt^2) in the cycle.
    """

    srz: ComplexArray
    srt: ComplexArray
    resultant: FloatArray


def cycle_maximum(first: ComplexArray, second: ComplexArray) -> FloatArray:
    """Largest length over a cycle of the vector with components Im(first e^(i W t)), Im(second e^(i W t)).

    The end of the vector runs on an ellipse; its squared length is a constant plus a cosine of 2 W t, whose largest
    value is (|first|^2 + |second|^2 + |first^2 + second^2|) / 2, half axis squared.
    """
    first, second = np.asarray(first), np.asarray(second)
    mean = np.abs(first) ** 2 + np.abs(second) ** 2
    return np.asarray(np.sqrt(0.5 * (mean + np.abs(first**2 + second**2))))


def shear_per_g(modes: ShearModes, oscillators: Oscillators, frequency_hz: float) -> ShearPerG:
    """Steady shear stress under 1 g of base acceleration at `frequency_hz`."""
    amplitudes = oscillators.steady(frequency_hz, GRAVITY)
    srz, srt = amplitudes @ modes.srz, amplitudes @ modes.srt
    return ShearPerG(srz, srt, cycle_maximum(srz, srt))


def slips(resultant: FloatArray, capacity: FloatArray) -> npt.NDArray[np.bool_]:
    """Slip where the shear resultant exceeds the capacity; equality is no slip (eqs 2.17, 2.18 of the source)."""
    return np.asarray(resultant > capacity)


def onset_levels(resultant_per_g: FloatArray, capacity: FloatArray) -> FloatArray:
    """(n_points,) base acceleration in g above which each point slips; infinite where nothing shears it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(resultant_per_g > 0.0, capacity / resultant_per_g, np.inf)


class SlipZone(NamedTuple):
    """How far slip reaches at one level; zeros where nothing slips.

    Attributes
    ----------
    volume_fraction
        Share of the coil's volume that slips.
    height
        Height above the base of the highest slipping point, m.
    depth
        Distance from the mandrel's surface to the outermost slipping point, m.
    """

    volume_fraction: float
    height: float
    depth: float


def slip_zone(modes: ShearModes, slipping: npt.NDArray[np.bool_], mandrel_radius: float) -> SlipZone:
    """Extent of the points that slip; `mandrel_radius` (m) is where the coil begins."""
    if not slipping.any():
        return SlipZone(0.0, 0.0, 0.0)
    fraction = float(modes.volumes[slipping].sum() / modes.volumes.sum())
    z, r = modes.points[slipping, 1], modes.points[slipping, 2]
    return SlipZone(fraction, float(z.max()), float(r.max() - mandrel_radius))


def driven_mode(modes: ShearModes) -> int:
    """Mode that a base at "resonance" drives: the one with the largest effective mass along the excitation.

    For a cantilevered roll this is the first bending mode, also where modes of torsion or axial shear, which the base
    hardly moves, lie below it.
    """
    return int(np.argmax(np.asarray(modes.participation) ** 2))
