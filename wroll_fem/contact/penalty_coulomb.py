r"""Coulomb friction with an elastic slip before sliding (penalty, or Jenkins element in two directions).

.. math:: e = \operatorname{clip}(e_c + \Delta g_t), \quad |e| \le \gamma^*, \qquad \tau = \frac{\mu p}{\gamma^*} e
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from wroll_fem.errors import InputError

KIND = 0


@dataclass(frozen=True)
class PenaltyCoulomb:
    """Coulomb friction with an elastic slip (penalty) branch.

    The traction is ``tau = (mu p / elastic_slip) e`` with the elastic slip ``e`` clipped to the
    disc ``|e| <= elastic_slip``; limit and stick stiffness follow the current pressure ``p``.

    Attributes
    ----------
    mu
        Coefficient of friction.
    elastic_slip
        Largest elastic relative displacement, gamma* in m.
    """

    mu: float
    elastic_slip: float

    def __post_init__(self) -> None:
        check_stick(self.mu, self.elastic_slip)


def check_stick(mu: float, elastic_slip: float) -> None:
    """Refuse a negative coefficient and an elastic slip that is not positive."""
    if not mu >= 0:
        raise InputError(
            f"coefficient of friction {mu} is negative", key="contact.friction.mu", remedy="give 0 or more"
        )
    if not elastic_slip > 0:
        raise InputError(
            f"elastic slip {elastic_slip} m is not positive",
            key="contact.friction.elastic_slip",
            remedy="give a length in m, for example 1e-6",
        )


@numba.njit(cache=True, inline="always")
def slip_update(trial_h: float, trial_z: float, radius: float) -> tuple[float, float, bool]:
    """Elastic slip (m) clipped to the disc of ``radius`` (m), and whether the point slides."""
    length = np.sqrt(trial_h * trial_h + trial_z * trial_z)
    if length > radius:
        scale = radius / length
        return trial_h * scale, trial_z * scale, True
    return trial_h, trial_z, False


@numba.njit(cache=True, inline="always")
def slip_derivatives(trial_h: float, trial_z: float, radius: float) -> tuple[float, float, float, float]:
    """Derivatives (00, 01, 10, 11) of the clipped slip with respect to the trial slip."""
    length = np.sqrt(trial_h * trial_h + trial_z * trial_z)
    if length > radius:
        mh, mz = trial_h / length, trial_z / length
        c = radius / length
        return c * (1.0 - mh * mh), -c * mh * mz, -c * mh * mz, c * (1.0 - mz * mz)
    return 1.0, 0.0, 0.0, 1.0
