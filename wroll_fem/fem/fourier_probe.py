"""Displacement of Fourier modes at probes. A probe is a point of a wall or layer, with a direction."""

from __future__ import annotations

import numpy as np

from wroll_fem.bodies.probe import Probe, unit_vector
from wroll_fem.fem.fourier_modes import FourierMode
from wroll_fem.fem.fourier_roll import FourierRoll


def mode_at_probe(roll: FourierRoll, mode: FourierMode, probe: Probe, radius: float, *, turned: bool = False) -> float:
    """Displacement of a mode at a probe, in the direction of the probe, per modal coordinate, 1/sqrt(kg).

    Parameters
    ----------
    roll
        Roll of the mode.
    mode
        Mode of unit modal mass.
    probe
        Point and direction.
    radius
        Radius of the mid-surface that contains the point, m.
    turned
        Take the other mode of the degenerate pair, rotated about the axis by pi / (2 m).
    """
    values, _ = roll.model.evaluate(mode.values, np.array([[radius, probe.z]]))
    m = mode.symmetry.wave_number
    phase = m * probe.theta - (0.5 * np.pi if turned else 0.0)
    radial, hoop, axial = values[0] * np.array([np.cos(phase), np.sin(phase) if m else 1.0, np.cos(phase)])
    c, s = np.cos(probe.theta), np.sin(probe.theta)
    return float(unit_vector(probe) @ np.array([radial * c - hoop * s, radial * s + hoop * c, axial]))
