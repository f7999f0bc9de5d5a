r"""Formulas of one contact point: order of its degrees of freedom, normal law, stick stiffness and work of a step.

Time integration, statics and harmonic balance all call these functions; numba inlines them.

Order of the contact degrees of freedom of ``n`` points: the hoop and axial components of point ``k`` have the indices
``2 k`` and ``2 k + 1``, its normal component has the index ``2 n + k``. The tangential components come first because
only they change between stick and slip while the contact stays closed.
"""

from __future__ import annotations

import numba
import numpy as np
from numba.extending import register_jitable

from wroll_fem.typing import FloatArray, IntArray

HOOP, AXIAL, NORMAL = 0, 1, 2
"""Components of a relative displacement or traction at a point."""

EVERY = slice(None)

# ---- order of the contact degrees of freedom -------------------------------------------------------------------------


@numba.njit(cache=True, inline="always")
def hoop(k):
    """Index of the contact degree of freedom of the hoop component of point ``k``."""
    return 2 * k


@numba.njit(cache=True, inline="always")
def axial(k):
    """Index of the contact degree of freedom of the axial component of point ``k``."""
    return 2 * k + 1


@numba.njit(cache=True, inline="always")
def normal(k, n):
    """Index of the contact degree of freedom of the normal component of point ``k`` (``n`` points in total)."""
    return 2 * n + k


@numba.njit(cache=True, inline="always")
def contact_dof(k, component, n):
    """Index of the contact degree of freedom of a ``component`` of point ``k`` (``n`` points in total)."""
    return 2 * k + component if component < NORMAL else 2 * n + k


@numba.njit(cache=True, inline="always")
def point_of(dof, n):
    """Index of the point to which a contact degree of freedom belongs (``n`` points in total)."""
    return dof // 2 if dof < 2 * n else dof - 2 * n


@numba.njit(cache=True, inline="always")
def component_of(dof, n):
    """Component (HOOP, AXIAL or NORMAL) of a contact degree of freedom (``n`` points in total)."""
    return dof % 2 if dof < 2 * n else NORMAL


def contact_dofs(n: int) -> IntArray:
    """(n, 3) indices of the contact degrees of freedom of ``n`` points; columns hoop, axial, normal."""
    k = np.arange(n)
    return np.column_stack([2 * k, 2 * k + 1, 2 * n + k])


def dofs_of(points: IntArray, n: int) -> IntArray:
    """(3 a,) contact degrees of freedom of a ``points`` among ``n``: tangential ones first, as for all points."""
    return np.concatenate([(2 * points[:, None] + np.arange(2)).ravel(), 2 * n + points])


def normals(values: FloatArray) -> FloatArray:
    """(n, ...) view of the normal components in an array (3 n, ...) with one row per contact degree of freedom."""
    return values[2 * (len(values) // 3) :]


def tangentials(values: FloatArray) -> FloatArray:
    """(n, 2) view of the hoop and axial components in an array (3 n,) with one value per contact degree of freedom."""
    return values[: 2 * (len(values) // 3)].reshape(-1, 2)


def per_dof(tangential: FloatArray, normal: FloatArray) -> FloatArray:
    """(3 n,) values at the contact degrees of freedom: ``tangential`` (n,) for hoop and axial, then ``normal`` (n,)."""
    return np.concatenate([np.repeat(tangential, 2), normal])


# ---- normal law ---------------------------------------------------------------------------------------------------
# These functions take the numbers of one point, not `PointLaws`: numba would count references to its arrays in a
# function that branches.


@numba.njit(cache=True, inline="always")
def is_closed(gn, separates):
    """Whether a point is in contact at the normal gap ``gn`` (m); always True if ``separates`` is False."""
    return gn <= 0.0 or not separates


@numba.njit(cache=True, inline="always")
def penalty_traction(gn, kn, separates):
    """Normal traction (Pa, negative in compression) of the penalty law at the normal gap ``gn`` (m)."""
    return kn * gn if is_closed(gn, separates) else 0.0


@numba.njit(cache=True, inline="always")
def opens_in_step(gn, gn_c, separates, dt):
    """Whether a point opens within a time step, from the committed gap ``gn_c`` < 0 to ``gn`` > 0 (m)."""
    return not is_closed(gn, separates) and gn_c < 0.0 and dt < np.inf


@numba.njit(cache=True, inline="always")
def step_traction(gn, gn_c, kn, separates, dt):
    """Normal traction (Pa) at the end of a step ``dt`` (s) from the committed gap ``gn_c`` (m) to the gap ``gn`` (m).

    It follows the penalty law, except in a time step in which the point opens: the release traction then conserves the
    energy of the step.
    """
    if opens_in_step(gn, gn_c, separates, dt):
        return kn * gn_c * gn / (gn_c - gn)
    return penalty_traction(gn, kn, separates)


@numba.njit(cache=True, inline="always")
def step_stiffness(gn, gn_c, kn, separates, dt):
    """Derivative of `step_traction` with respect to the gap ``gn``, Pa/m."""
    if is_closed(gn, separates):
        return kn
    if opens_in_step(gn, gn_c, separates, dt):
        return kn * (gn_c / (gn_c - gn)) ** 2
    return 0.0


@numba.njit(cache=True, inline="always")
def pressure(tn):
    """Contact pressure (Pa) for the normal traction ``tn`` (Pa); 0 in tension."""
    return -tn if tn < 0.0 else 0.0


@numba.njit(cache=True, inline="always")
def squared_penalty(tn, separates):
    """Square of the normal traction ``tn``, Pa^2, for the penalty energy tn^2 / (2 kn) per area.

    It is 0 for a release traction, because a release traction stores no energy.
    """
    return 0.0 if separates and tn > 0.0 else tn * tn


# ---- friction --------------------------------------------------------------------------------------------------------


@register_jitable(inline="always")
def stick_stiffness(k, p, laws):
    """Stick stiffness, Pa/m, of point ``k`` at the pressure ``p``: tangential traction per elastic slip.

    It is mu p / gamma*, or constant. Outside compiled code ``k`` may be `EVERY` (all points), with ``p`` (n,).
    """
    return laws.stick[k] + laws.follows[k] * laws.mu[k] * p / laws.gamma[k]


@register_jitable(inline="always")
def stick_change(k, p, laws):
    """Part of the stick stiffness that is proportional to the pressure ``p``, Pa/m, of point ``k``.

    With -kn in place of ``p`` it is the derivative of the stick stiffness with respect to the normal gap.
    """
    return laws.follows[k] * laws.mu[k] * p / laws.gamma[k]


@numba.njit(cache=True, inline="always")
def correction(t, t_0, spring, change):
    """Traction correction, Pa: traction ``t`` minus the linear traction ``t_0 + spring * change`` of a stuck interface.

    ``t_0`` is the traction at the preload, Pa, ``spring`` the reference contact stiffness, Pa/m, and ``change`` the
    relative displacement minus its value at the preload, m.
    """
    return t - t_0 - spring * change


@numba.njit(cache=True, inline="always")
def tangential_work(k, p_c, p, t_c, t, dg, e_c, e, laws):
    """Work of the tangential traction in a step, J/m^2, from the committed state (index c) to the new state.

    Parameters
    ----------
    p_c, p : pressure, Pa
    t_c, t : (hoop, axial) traction, Pa
    dg : (hoop, axial) increment of the relative displacement, m
    e_c, e : (hoop, axial) elastic slip, m; zero for a law without memory

    Returns
    -------
    friction : mean traction times plastic slip
    elastic : mean traction times the increment of the elastic slip
    stored : increase of the energy of the elastic slip; elastic - stored is `modulation_work`
    """
    mean_h, mean_z = 0.5 * (t[0] + t_c[0]), 0.5 * (t[1] + t_c[1])
    de_h, de_z = e[0] - e_c[0], e[1] - e_c[1]
    old = 0.5 * stick_stiffness(k, p_c, laws) * (e_c[0] ** 2 + e_c[1] ** 2)
    new = 0.5 * stick_stiffness(k, p, laws) * (e[0] ** 2 + e[1] ** 2)
    friction = mean_h * (dg[0] - de_h) + mean_z * (dg[1] - de_z)
    elastic = mean_h * de_h + mean_z * de_z
    conserved = laws.elastic[k] * 1.0  # no branch here: numba would count references to the arrays of the laws
    return friction, elastic, conserved * elastic + (1.0 - conserved) * (new - old)


@numba.njit(cache=True, inline="always")
def modulation_work(k, p_c, p, e_c, e, laws):
    """Work exchanged between the elastic slip and the varying stick stiffness k_t in a step: -(k_t - k_tc) e . e_c / 2.

    In J/m^2; the index c marks the committed state. It equals elastic - stored of `tangential_work` where the traction
    is the stick stiffness times e, but without the rounding error of this difference.
    """
    stick = stick_change(k, 1.0, laws)
    return -0.5 * stick * (p - p_c) * (e[0] * e_c[0] + e[1] * e_c[1])
