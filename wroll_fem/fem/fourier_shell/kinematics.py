r"""Kinematics of a shear-deformable cylindrical shell with displacements of one circumferential wave number.

The point at height zeta above the mid-surface, r = R + zeta, has the displacement (wave number n)

    u_r = U(z) cos n theta,    u_theta = (V + zeta B) sin n theta,    u_z = (W + zeta A) cos n theta.

A and B are the changes of the director along z and theta. The strains are those of `fem.fourier` for this displacement,

    cos n theta:  zz = W' + zeta A'                           tt = (U + n (V + zeta B)) / r      rz = U' + A
    sin n theta:  tz = V' + zeta B' - n (W + zeta A) / r      rt = (R B - V - n U) / r

Stresses follow from plane stress, with the shear factor 5/6 for rz and rt. The factor r / R of the area and 1 / r in
the strains are kept, so the hoop stress on the two faces of a thick tube differs as it should.
"""

from __future__ import annotations

from typing import Any, NamedTuple

SHEAR_FACTOR = 5.0 / 6.0
"""Shear factor of the transverse shear stresses."""
COMPONENTS = 5
"""Amplitudes per node: U, V, W, B, A."""


class Strains(NamedTuple):
    """Amplitudes of the strains (engineering shear); zz, tt, rz of cos n theta, tz and rt of sin n theta."""

    zz: Any
    tt: Any
    tz: Any
    rz: Any
    rt: Any


class Plane(NamedTuple):
    """Elastic constants of plane stress, Pa."""

    direct: Any  # E / (1 - nu^2)
    coupling: Any  # nu E / (1 - nu^2)
    shear: Any  # G


def strains(values: Any, slopes: Any, wave_number: Any, radius: Any, zeta: Any) -> Strains:
    """Strains at the height zeta; for UFL expressions and for arrays alike.

    Parameters
    ----------
    values, slopes
        Amplitudes U, V, W (m), B, A (rad), and their derivatives along z.
    wave_number
        Circumferential wave number n.
    radius, zeta
        Radius R of the mid-surface and height above it, m.
    """
    U, V, W, B, A = (values[i] for i in range(COMPONENTS))
    dU, dV, dW, dB, dA = (slopes[i] for i in range(COMPONENTS))
    n, r = wave_number, radius + zeta
    return Strains(
        zz=dW + zeta * dA,
        tt=(U + n * (V + zeta * B)) / r,
        tz=dV + zeta * dB - n * (W + zeta * A) / r,
        rz=dU + A,
        rt=(radius * B - V - n * U) / r,
    )


def stresses(strain: Strains, plane: Plane) -> Strains:
    """Stresses (Pa) of strains, in the same order."""
    return Strains(
        zz=plane.direct * strain.zz + plane.coupling * strain.tt,
        tt=plane.direct * strain.tt + plane.coupling * strain.zz,
        tz=plane.shear * strain.tz,
        rz=SHEAR_FACTOR * plane.shear * strain.rz,
        rt=SHEAR_FACTOR * plane.shear * strain.rt,
    )


Gradient = tuple[tuple[Any, str], tuple[Any, str], tuple[Any, str]]
"""Components along r, theta, z of the derivative of a displacement, each with its parity: "c" or "s"."""


def gradients(values: Any, slopes: Any, wave_number: Any, radius: Any, zeta: Any) -> tuple[Gradient, Gradient]:
    """Derivatives of the displacement at the height zeta along z, and along theta divided by r."""
    U, V, W, B, A = (values[i] for i in range(COMPONENTS))
    dU, dV, dW, dB, dA = (slopes[i] for i in range(COMPONENTS))
    n, r = wave_number, radius + zeta
    v, w = V + zeta * B, W + zeta * A
    along = ((dU, "c"), (dV + zeta * dB, "s"), (dW + zeta * dA, "c"))
    around = ((-(n * U + v) / r, "s"), ((U + n * v) / r, "c"), (-n * w / r, "s"))
    return along, around


def director_change(values: Any) -> Gradient:
    """First-order change of the director, with the parity of each component."""
    return ((0, "c"), (values[3], "s"), (values[4], "c"))
