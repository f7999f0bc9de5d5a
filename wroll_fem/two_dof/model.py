r"""Two masses, each on a spring and a dashpot, that are pressed together and rub (thesis, sections 5.1 and 5.2).

With the absolute displacements x = (x_1, x_2), the base's y = Y_0 sin(omega t) and d = (1, -1)

.. math:: M \ddot x + \sum_i r_i (k_i e_i + c_i \dot e_i) + F_c\, S(s\, d \cdot \dot x)\, d = 0,
          \qquad e_1 = x_1 - y, \quad e_2 = x_2 - a x_1 - b y

with r_1 = (1, 0), r_2 = (-a, 1). What the secondary's spring and dashpot hold on to makes the arrangements of Fig. 5.1:

- ``both_on_base`` (a): the base, a = 0, b = 1. Equations 5.2 and 5.3 with the smoothed sign S of 5.4, scaled by s
  (appendix C).
- ``secondary_isolated`` (b): a wall at rest, a = 0, b = 0.
- ``secondary_on_primary`` (c): the primary, a = 1, b = 0.

Relative to the base, u = x - (1, 1) y, the same equation reads

.. math:: M \ddot u + C \dot u + K u + F_c\, S(s\, d \cdot \dot u)\, d
          = -M (1,1)\, \ddot y + (a + b - 1)\, (k_2 y + c_2 \dot y)\, r_2,
          \qquad K = \sum_i k_i r_i r_i^T, \quad C = \sum_i c_i r_i r_i^T

so that in (b) alone the base is more than an acceleration.

Friction and dashpots are monotone in the velocities, so the energy of the difference of two motions never grows: there
is one periodic motion, all others tend to it, and its second half period mirrors the first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from wroll_fem.contact.smoothed_coulomb import regularised_sign
from wroll_fem.errors import InputError, require_positive
from wroll_fem.typing import FloatArray

Arrangement = Literal["both_on_base", "secondary_isolated", "secondary_on_primary"]
ARRANGEMENTS: tuple[str, ...] = get_args(Arrangement)

HOLDS = {"both_on_base": (0.0, 1.0), "secondary_isolated": (0.0, 0.0), "secondary_on_primary": (1.0, 0.0)}
"""Arrangement -> (a, b)."""

SLIDES = np.array([1.0, -1.0])
"""d: rubbing velocity of two velocities."""


def smoothed_sign(x: npt.ArrayLike) -> FloatArray:
    """S(x) = 2 / (1 + exp(-x)) - 1 (equation 5.4), the function of `contact.smoothed_coulomb`."""
    values = np.asarray(x, dtype=np.float64)
    return np.array([regularised_sign(v) for v in values.ravel()]).reshape(values.shape)


@dataclass(frozen=True)
class Pressed:
    """The two masses under one friction capacity, equations 5.6 and 5.7 applied.

    Attributes
    ----------
    m1, k1, c1, m2, k2, c2 : kg, N/m, N s/m
    capacity : friction capacity F_c, N
    smoothing : s, s/m
    base_amplitude : Y_0, m, 0-peak
    hold : (a, b), what the secondary's spring holds on to
    """

    m1: float
    k1: float
    c1: float
    m2: float
    k2: float
    c2: float
    capacity: float
    smoothing: float
    base_amplitude: float
    hold: tuple[float, float]

    @property
    def mass(self) -> FloatArray:
        """(2, 2) kg."""
        return np.diag([self.m1, self.m2])

    @property
    def stiffness(self) -> FloatArray:
        """(2, 2) N/m."""
        return self._assembled(self.k1, self.k2)

    @property
    def damping(self) -> FloatArray:
        """(2, 2) N s/m."""
        return self._assembled(self.c1, self.c2)

    def _assembled(self, first: float, second: float) -> FloatArray:
        across = np.array([-self.hold[0], 1.0])
        return np.diag([first, 0.0]) + second * np.outer(across, across)

    @property
    def unshaken(self) -> FloatArray:
        """(2,) r_2 (a + b - 1): force per k_2 y + c_2 y' in relative displacements, for a secondary on a wall."""
        return (sum(self.hold) - 1.0) * np.array([-self.hold[0], 1.0])

    @property
    def stuck_frequency(self) -> float:
        """Resonance with the masses stuck together, rad/s, without damping."""
        return float(np.sqrt(self.stiffness.sum() / (self.m1 + self.m2)))

    @property
    def free_frequencies(self) -> FloatArray:
        """(2,) resonances without friction and damping, rising, rad/s."""
        values = np.linalg.eigvals(np.linalg.solve(self.mass, self.stiffness))
        return np.sqrt(np.sort(values.real))


@dataclass(frozen=True)
class TwoMasses:
    """Parameters of the model (thesis, Table 5.2); any consistent units, SI in the names here.

    Attributes
    ----------
    m1, k1, c1
        Primary (mandrel): mass kg, stiffness N/m, dashpot N s/m.
    m2, k2, c2
        Secondary (roll), as wound infinitely tight.
    base_amplitude
        Y_0, m, 0-peak.
    smoothing
        s of S(s v), s/m; 1 in the source.
    arrangement
        Of Fig. 5.1, see above.
    preload_dependent
        Whether mass and stiffness of the secondary follow the capacity, equations 5.6 and 5.7:
        k_2' = k_2 S(F_c), m_1' = m_1 + m_2 (1 - S(F_c)), m_2' = m_2 S(F_c), F_c in units of the model's force.

    Raises
    ------
    InputError
        For values without a meaning.
    """

    m1: float = 1.0
    k1: float = 1.0
    c1: float = 0.002
    m2: float = 0.85
    k2: float = 1.15
    c2: float = 0.0025
    base_amplitude: float = 1.5
    smoothing: float = 1.0
    arrangement: Arrangement = "both_on_base"
    preload_dependent: bool = True

    def __post_init__(self) -> None:
        names = ("m1", "k1", "c1", "m2", "k2", "c2", "base_amplitude", "smoothing")
        require_positive(self, names, section="two_dof")
        if self.arrangement not in ARRANGEMENTS:
            raise InputError(
                f"no arrangement {self.arrangement!r}",
                key="two_dof.arrangement",
                remedy=f"use {', '.join(ARRANGEMENTS)}",
            )

    def pressed(self, capacity: float) -> Pressed:
        """The model under the friction capacity F_c = mu F_N in N.

        Raises
        ------
        InputError
            For a capacity that is not positive.
        """
        if not (capacity > 0.0 and np.isfinite(capacity)):
            raise InputError(
                f"friction capacity {capacity}", key="two_dof.friction_capacity", remedy="give positive forces in N"
            )
        share = float(regularised_sign(capacity)) if self.preload_dependent else 1.0
        return Pressed(
            m1=self.m1 + self.m2 * (1.0 - share),
            k1=self.k1,
            c1=self.c1,
            m2=self.m2 * share,
            k2=self.k2 * share,
            c2=self.c2,
            capacity=float(capacity),
            smoothing=self.smoothing,
            base_amplitude=self.base_amplitude,
            hold=HOLDS[self.arrangement],
        )
