r"""Solid coil whose wraps slide: friction at every quadrature point, with the shear strain as relative displacement.

The stiffness :math:`K_0` of the coil has no shear between the wraps. The shear stress :math:`\tau = (\tau_{rt},
\tau_{rz})` acts at the points k of `ShearPoints`, of volume :math:`V_k` and strain rows :math:`B_k`:

.. math:: K_0 u + \sum_k V_k B_k^T \tau_k = f, \qquad
          \tau = \tau^* \min\left(1, \frac{\mu P}{|\tau^*|}\right), \quad \tau^* = \tau_c + G\, \Delta\gamma

P(r) is the pressure of the wound roll, which stays constant. With the thickness h of a wrap this is elastic-slip
Coulomb friction at contact points of area :math:`V_k/h` with the relative displacement :math:`h \gamma` of neighbouring
wraps: the stick stiffness is :math:`G_k/h`, the limit :math:`\mu P_k`, the elastic slip :math:`\mu P_k h/G_k`. Slip
and its work per area are therefore those between two wraps; stresses, motion and energy do not depend on h. The
interface has no normal displacement.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Body
from wroll_fem.coiled_stiff.shear_points import ShearPoints
from wroll_fem.contact.elastic_coulomb import ElasticCoulomb
from wroll_fem.contact.interface import Interface, NormalPenalty, PenaltyCoulomb, PointwiseFriction
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

NAME = "coil"
"""Name of the interface."""


def slipping_system(
    body: Body,
    points: ShearPoints,
    *,
    shear_modulus: float | FloatArray,
    pressure: FloatArray,
    mu: float,
    wrap_thickness: float,
    direction: int = 0,
    varying: bool = False,
) -> tuple[System, ContactState]:
    """System of a mandrel with a slipping coil, and its state at rest, without shear stress.

    Parameters
    ----------
    body
        Mandrel with the coil bonded to it; its stiffness has no shear between the wraps.
    points
        Points of the coil.
    shear_modulus
        G, Pa, the same for rt and rz: one value, or that of each point (n,).
    pressure
        (n,) pressure P of the wound roll at the points, Pa.
    mu
        Coefficient of friction between the wraps.
    wrap_thickness
        Thickness h of a wrap, m: the slip is that between two wraps.
    direction
        Direction of the base motion: 0 for x, 1 for y.
    varying
        The friction limit follows a pressure that varies, see `shear_interface`.

    Raises
    ------
    InputError
        If a point has no friction capacity.
    """
    system = System.from_bodies([body], direction=direction)
    system = with_slip(
        system, body, points, shear_modulus=shear_modulus, pressure=pressure, mu=mu, wrap_thickness=wrap_thickness,
        varying=varying,
    )  # fmt: skip
    return system, ContactState.pressed(system, pressure)


def with_slip(
    system: System,
    body: Body,
    points: ShearPoints,
    *,
    shear_modulus: float | FloatArray,
    pressure: FloatArray,
    mu: float,
    wrap_thickness: float,
    varying: bool = False,
) -> System:
    """System with friction between the wraps of its last body, as its last interface.

    For the parameters and the error see `slipping_system`.
    """
    assert body.solid is not None
    strain = points.strain @ body.solid.expand
    others = sp.csr_matrix((strain.shape[0], system.n_dofs - strain.shape[1]))
    interface = shear_interface(
        points, sp.hstack([others, strain], format="csr"), shear_modulus=shear_modulus, pressure=pressure, mu=mu,
        wrap_thickness=wrap_thickness, varying=varying,
    )  # fmt: skip
    return replace(system, interfaces=(*system.interfaces, interface))


def shear_interface(
    points: ShearPoints,
    strain: sp.csr_matrix,
    *,
    shear_modulus: float | FloatArray,
    pressure: FloatArray,
    mu: float,
    wrap_thickness: float,
    varying: bool = False,
) -> Interface:
    """Friction at ``points`` with the shear strains rt and rz, (2 n, n_dofs) rows ``strain``, as relative displacement.

    With ``varying`` the law has a stick stiffness that does not depend on the pressure, and a friction limit that
    falls to zero with it. For the other parameters and the error see `slipping_system`.
    """
    capacity = mu * np.asarray(pressure, float)
    if not np.all(capacity > 0.0):
        where = points.points[int(np.argmin(capacity)), 2]
        raise InputError(
            f"the friction capacity between the wraps is {capacity.min():g} Pa at a radius of {1e3 * where:.4g} mm",
            key="winding", remedy="wind all of the coil with tension, and give winding.mu above 0",
        )  # fmt: skip
    n = len(points.volumes)
    stick = np.broadcast_to(shear_modulus, n) / wrap_thickness
    slip = capacity / stick
    if varying:
        friction = PointwiseFriction.varying(ElasticCoulomb, mu=mu, elastic_slip=slip, stick_stiffness=stick)
    else:
        friction = PointwiseFriction.varying(PenaltyCoulomb, mu=mu, elastic_slip=slip)
    tangential = wrap_thickness * strain
    rows = (3 * np.arange(n)[:, None] + [1, 2]).ravel()
    place = sp.csr_matrix((np.ones(2 * n), (rows, np.arange(2 * n))), shape=(3 * n, 2 * n))
    return Interface(
        name=NAME, operator=(place @ tangential).tocsr(), areas=points.volumes / wrap_thickness, points=points.points,
        friction=friction, normal=NormalPenalty(stick, varying), fills_body=True,
    )  # fmt: skip
