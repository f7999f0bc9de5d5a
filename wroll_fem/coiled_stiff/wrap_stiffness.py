r"""Stiffness of a coil between its wraps, from the web, its interfaces and the pressure of the wound roll.

A wrap of thickness h and its interface shear in series. The interface transmits :math:`\tau = \mu P\, s/\gamma^*` while
it sticks (elastic-slip Coulomb friction), so that the coil has, at the pressure P(r),

.. math:: \frac{1}{G} = \frac{1}{G_l} + \frac{\gamma^*}{\mu P h} .

The radial modulus :math:`E_r(P)` of the stack enters the compliance at the place rr alone,
:math:`S = S_0 + (1/E_r - 1/E_0)\, e_r e_r^T`. By the formula of Sherman and Morrison the stiffness of a coil with the
radial modulus :math:`E_0` of a reference becomes, with its rows :math:`R_k` of the radial stress,

.. math:: K = K(E_0) - \sum_k V_k \frac{d_k}{1 + d_k C_{rr}} R_k^T R_k, \qquad d_k = \frac{1}{E_r(P_k)} - \frac{1}{E_0}

at the quadrature points k of the elements, with their weights; the result does not depend on :math:`E_0`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import SolidPart
from wroll_fem.coiled_stiff.shear_points import ShearPoints, full_rule_weight, radial_stress
from wroll_fem.typing import FloatArray

_LEAST = float(np.finfo(float).tiny)


def shear_modulus(
    web: float, pressure: FloatArray, *, mu: float, elastic_slip: float, wrap_thickness: float
) -> FloatArray:
    """(n,) shear modulus between the wraps, Pa, at the ``pressure`` (n,), Pa, between them.

    Parameters
    ----------
    web
        Shear modulus of the web through its thickness, Pa.
    mu
        Coefficient of friction between the wraps.
    elastic_slip
        Elastic slip gamma* of an interface, m.
    wrap_thickness
        Thickness of the web, m.
    """
    interface = np.maximum(mu * np.asarray(pressure, float) * wrap_thickness, _LEAST)
    return np.asarray(web * (interface / (interface + web * elastic_slip)))


def radial_change(modulus: FloatArray, stiffness: FloatArray) -> FloatArray:
    """(n,) factor of the radial stress if the radial modulus is ``modulus`` (n,), Pa, and the strain is the same.

    ``stiffness`` (6, 6), Pa, is that of the reference, in the Voigt order of `materials`.
    """
    return np.asarray(1.0 / (1.0 + _difference(modulus, stiffness) * stiffness[0, 0]))


def with_radial_modulus(
    matrix: sp.csr_matrix, part: SolidPart, stiffness: FloatArray, modulus_at: Callable[[FloatArray], FloatArray]
) -> sp.csr_matrix:
    """Stiffness of a body whose coil has a radial modulus that varies with the radius, N/m.

    Parameters
    ----------
    matrix
        (n, n) stiffness of the body with the radial modulus of the reference.
    part
        Coil of the body.
    stiffness
        (6, 6) stiffness of the reference, Pa, in the Voigt order of `materials`.
    modulus_at
        Function from radii (k,), m, to the radial modulus there (k,), Pa.
    """
    weight = full_rule_weight(part)
    for gauss_points, share in ((3, weight), (2, 1.0 - weight)):
        if not share.any():
            continue
        at = ShearPoints.of(part, gauss_points)
        modulus = modulus_at(at.points[:, 2])
        d = _difference(modulus, stiffness)
        factor = -np.repeat(share, gauss_points**3) * at.volumes * d / (1.0 + d * stiffness[0, 0])
        rows = (radial_stress(part, stiffness, gauss_points) @ part.expand).tocsr()
        matrix = matrix + rows.T @ sp.diags(factor) @ rows
    return sp.csr_matrix(0.5 * (matrix + matrix.T))


def _difference(modulus: FloatArray, stiffness: FloatArray) -> FloatArray:
    """(n,) radial compliance less that of the reference, 1/Pa."""
    return 1.0 / np.asarray(modulus, float) - float(np.linalg.inv(stiffness[:3, :3])[0, 0])
