r"""Two masses, each on a spring and a dashpot, coupled by friction (thesis, sections 5.1 and 5.2).

With the absolute displacements x = (x_1, x_2), the base displacement y = Y_0 sin(omega t) and d = (1, -1),

.. math:: M \ddot x + \sum_i r_i (k_i e_i + c_i \dot e_i) + F_c\, S(s\, d \cdot \dot x)\, d = 0,
          \qquad e_1 = x_1 - y, \quad e_2 = x_2 - a x_1 - b y

with r_1 = (1, 0), r_2 = (-a, 1). The arrangements of Fig. 5.1 differ in the support of the secondary's spring and
dashpot:

- ``both_on_base`` (a): the base, a = 0, b = 1. Equations 5.2 and 5.3 with the regularised sign function S of equation
  5.4, scaled by s (appendix C).
- ``secondary_isolated`` (b): fixed ground, a = 0, b = 0.
- ``secondary_on_primary`` (c): the primary mass, a = 1, b = 0.

For the displacement relative to the base, u = x - (1, 1) y, the same equation is

.. math:: M \ddot u + C \dot u + K u + F_c\, S(s\, d \cdot \dot u)\, d
          = -M (1,1)\, \ddot y + (a + b - 1)\, (k_2 y + c_2 \dot y)\, r_2,
          \qquad K = \sum_i k_i r_i r_i^T, \quad C = \sum_i c_i r_i r_i^T

so only the acceleration of the base acts on the masses, except in arrangement (b).

Friction and damping forces are monotonic in the velocities, so the energy of the difference of two motions never
increases. There is therefore one periodic motion, all other motions converge to it, and its second half period is the
first one with the opposite sign.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from wroll_fem.contact.smoothed_coulomb import regularised_sign as contact_sign
from wroll_fem.errors import InputError, require_positive
from wroll_fem.typing import FloatArray

Arrangement = Literal["both_on_base", "secondary_isolated", "secondary_on_primary"]
ARRANGEMENTS: tuple[str, ...] = get_args(Arrangement)

SUPPORT_COUPLING = {"both_on_base": (0.0, 1.0), "secondary_isolated": (0.0, 0.0), "secondary_on_primary": (1.0, 0.0)}
"""For each arrangement, coefficients (a, b) of the motion a x_1 + b y of the secondary mass's support."""

RELATIVE_VELOCITY = np.array([1.0, -1.0])
"""Vector d: the relative velocity at the interface is d . (v_1, v_2), with the velocities v_1 and v_2 of the masses."""


def regularised_sign(x: npt.ArrayLike) -> FloatArray:
    """Regularised sign function S(x) = 2 / (1 + exp(-x)) - 1 = tanh(x / 2) (thesis, equation 5.4)."""
    values = np.asarray(x, dtype=np.float64)
    return np.array([contact_sign(v) for v in values.ravel()]).reshape(values.shape)


@dataclass(frozen=True)
class PreloadedTwoMasses:
    """Parameters of the two masses at one friction capacity, on which m1, m2 and k2 may depend (equations 5.6 and 5.7).

    Attributes
    ----------
    m1, k1, c1, m2, k2, c2 : masses (kg), stiffnesses (N/m) and dashpot constants (N s/m)
    capacity : friction capacity F_c, N
    smoothing : scale s of the regularised sign function, s/m
    base_amplitude : amplitude Y_0 of the base displacement, 0-peak, m
    support_coupling : coefficients (a, b) of the motion a x_1 + b y of the secondary mass's support
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
    support_coupling: tuple[float, float]

    @property
    def mass(self) -> FloatArray:
        """(2, 2) mass matrix, kg."""
        return np.diag([self.m1, self.m2])

    @property
    def stiffness(self) -> FloatArray:
        """(2, 2) stiffness matrix, N/m."""
        return self._assembled(self.k1, self.k2)

    @property
    def damping(self) -> FloatArray:
        """(2, 2) damping matrix, N s/m."""
        return self._assembled(self.c1, self.c2)

    def _assembled(self, first: float, second: float) -> FloatArray:
        across = np.array([-self.support_coupling[0], 1.0])
        return np.diag([first, 0.0]) + second * np.outer(across, across)

    @property
    def ground_coupling(self) -> FloatArray:
        """(2,) vector that multiplies k_2 y + c_2 y' in the equations of relative motion.

        It is (a + b - 1) r_2 with the symbols of the module docstring, and zero unless fixed ground supports the
        secondary mass.
        """
        return (sum(self.support_coupling) - 1.0) * np.array([-self.support_coupling[0], 1.0])

    @property
    def stuck_frequency(self) -> float:
        """Undamped natural frequency with the masses stuck together, rad/s."""
        return float(np.sqrt(self.stiffness.sum() / (self.m1 + self.m2)))

    @property
    def free_frequencies(self) -> FloatArray:
        """(2,) natural frequencies without friction and damping, rad/s, ascending."""
        values = np.linalg.eigvals(np.linalg.solve(self.mass, self.stiffness))
        return np.sqrt(np.sort(values.real))


@dataclass(frozen=True)
class TwoMasses:
    """Parameters of the two-mass model; the defaults are those of Table 5.2 of the thesis.

    Any consistent units can be used; SI units are given here.

    Attributes
    ----------
    m1, k1, c1
        Primary (mandrel): mass (kg), stiffness (N/m) and dashpot constant (N s/m).
    m2, k2, c2
        Secondary (roll) in the limit of infinite preload.
    base_amplitude
        Amplitude Y_0 of the base displacement, 0-peak, m.
    smoothing
        Scale s of the regularised sign function S(s v), s/m; 1 in the thesis.
    arrangement
        Arrangement of Fig. 5.1; see the docstring of the module.
    preload_dependent
        Whether mass and stiffness of the secondary depend on the friction capacity F_c (equations 5.6 and 5.7):
        k_2' = k_2 S(F_c), m_1' = m_1 + m_2 (1 - S(F_c)), m_2' = m_2 S(F_c), with F_c in the force unit of the model.

    Raises
    ------
    InputError
        If a value is not positive, or the arrangement is unknown.
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
                f"unknown arrangement {self.arrangement!r}",
                key="two_dof.arrangement",
                remedy=f"use {', '.join(ARRANGEMENTS)}",
            )

    def preloaded(self, capacity: float) -> PreloadedTwoMasses:
        """Parameters at the friction capacity F_c = mu F_N (N).

        Raises
        ------
        InputError
            If the capacity is not positive and finite.
        """
        if not (capacity > 0.0 and np.isfinite(capacity)):
            raise InputError(
                f"must be positive and finite, got {capacity}",
                key="two_dof.friction_capacity",
                remedy="give forces in N",
            )
        share = float(contact_sign(capacity)) if self.preload_dependent else 1.0
        return PreloadedTwoMasses(
            m1=self.m1 + self.m2 * (1.0 - share),
            k1=self.k1,
            c1=self.c1,
            m2=self.m2 * share,
            k2=self.k2 * share,
            c2=self.c2,
            capacity=float(capacity),
            smoothing=self.smoothing,
            base_amplitude=self.base_amplitude,
            support_coupling=SUPPORT_COUPLING[self.arrangement],
        )

    pressed = preloaded  # name until version 0.1
