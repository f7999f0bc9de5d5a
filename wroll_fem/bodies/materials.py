r"""Cylindrical-orthotropic elasticity of a wound web: stiffness, admissibility and homogenisation.

Material axes are r, theta, z of the roll; Voigt order is everywhere (rr, tt, zz, tz, rz, rt) with engineering shear
strains. Poisson's ratios are nu_ij = -strain_j / strain_i under stress i alone, so that nu_ij / E_i = nu_ji / E_j.

A material is admissible when its strain energy is positive for every strain (R. M. Jones, Mechanics of Composite
Materials, 2nd ed. 1999, section 2.4):

    all moduli > 0,    |nu_ij| < sqrt(E_i / E_j) for each pair,
    1 - nu_tz nu_zt - nu_tr nu_rt - nu_zr nu_rz - 2 nu_tz nu_zr nu_rt > 0.

References
----------
Thesis, section 2.4, Table 2.4 (homogenised strip), section 2.5, Table 2.5 (Kapton).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Protocol

from wroll_fem.errors import InputError

if TYPE_CHECKING:
    from wroll_fem.typing import FloatArray

MODULI = ("E_theta", "E_z", "E_r", "G_z_theta", "G_r_theta", "G_r_z")
IN_PLANE = ("E_theta", "E_z", "nu_theta_z", "G_z_theta", "rho")
"""In-plane constants of a web that are averaged over its constituents."""

RADIAL_RATIO = 0.01
"""Default ratio of E_r to the largest in-plane modulus (thesis, sections 2.4 and 2.5)."""

_ROUNDING = 1e-12


class Orthotropic(Protocol):
    """Protocol of an object that has the nine elastic constants of an orthotropic material."""

    @property
    def E_theta(self) -> float: ...  # noqa: D102
    @property
    def E_z(self) -> float: ...  # noqa: D102
    @property
    def E_r(self) -> float: ...  # noqa: D102
    @property
    def nu_theta_z(self) -> float: ...  # noqa: D102
    @property
    def nu_theta_r(self) -> float: ...  # noqa: D102
    @property
    def nu_z_r(self) -> float: ...  # noqa: D102
    @property
    def G_z_theta(self) -> float: ...  # noqa: D102
    @property
    def G_r_theta(self) -> float: ...  # noqa: D102
    @property
    def G_r_z(self) -> float: ...  # noqa: D102


@dataclass(frozen=True)
class Violation:
    """First admissibility condition that a material violates.

    Attributes
    ----------
    key
        Name of the offending constant.
    value
        Its value.
    problem, remedy
        Description of the problem and of its remedy.
    """

    key: str
    value: float
    problem: str
    remedy: str


def violation(m: Orthotropic) -> Violation | None:
    """First admissibility condition (see the module's docstring) that a material violates; None if it is admissible."""
    for key in MODULI:
        value = float(getattr(m, key))
        if not (math.isfinite(value) and value > 0.0):
            return Violation(key, value, "must be positive and finite", f"give {key} in Pa")
    for key, first, second in (
        ("nu_theta_z", "E_theta", "E_z"),
        ("nu_theta_r", "E_theta", "E_r"),
        ("nu_z_r", "E_z", "E_r"),
    ):
        nu, bound = float(getattr(m, key)), math.sqrt(getattr(m, first) / getattr(m, second))
        if not abs(nu) < bound * (1 - _ROUNDING):
            problem = (
                f"violates |{key}| < sqrt({first} / {second}) = {bound:.4g}: the strain energy is not positive definite"
            )
            remedy = f"reduce {key} (nu_ij = -strain_j / strain_i under stress i)"
            return Violation(key, nu, problem, remedy)
    tz, zr, rt = m.nu_theta_z, m.nu_z_r, m.nu_theta_r * m.E_r / m.E_theta
    rest = 1 - tz**2 * m.E_z / m.E_theta - m.nu_theta_r * rt - zr**2 * m.E_r / m.E_z - 2 * tz * zr * rt
    if rest <= _ROUNDING:
        problem = (
            "violates 1 - nu_tz nu_zt - nu_tr nu_rt - nu_zr nu_rz - 2 nu_tz nu_zr nu_rt > 0 "
            f"(it is {rest:.3g}): the strain energy is not positive definite"
        )
        remedy = "reduce the magnitude of nu_theta_z, nu_theta_r or nu_z_r"
        return Violation("nu_theta_z", float(tz), problem, remedy)
    return None


@dataclass(frozen=True)
class CylindricalOrthotropic:
    """Linear elastic material with three planes of symmetry, normal to r, theta and z.

    Attributes
    ----------
    E_theta, E_z, E_r
        Young's moduli along the web, along the axis and through the thickness of the coil, Pa.
    nu_theta_z, nu_theta_r, nu_z_r
        Poisson's ratios, nu_ij = -strain_j / strain_i under stress i.
    G_z_theta, G_r_theta, G_r_z
        Shear moduli, Pa; G_r_theta and G_r_z are the interlayer shear moduli.
    rho
        Density, kg/m^3.

    Raises
    ------
    InputError
        If the density is not positive or the elastic constants are not admissible.
    """

    E_theta: float
    E_z: float
    E_r: float
    nu_theta_z: float
    nu_theta_r: float
    nu_z_r: float
    G_z_theta: float
    G_r_theta: float
    G_r_z: float
    rho: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.rho) and self.rho > 0.0):
            raise InputError(f"must be positive and finite, got {self.rho:g}", key="rho", remedy="give rho in kg/m^3")
        found = violation(self)
        if found is not None:
            raise InputError(f"{found.problem}, got {found.value:g}", key=found.key, remedy=found.remedy)

    @classmethod
    def isotropic(cls, E: float, nu: float, rho: float) -> CylindricalOrthotropic:
        """Isotropic material.

        Parameters
        ----------
        E, nu, rho
            Young's modulus (Pa), Poisson's ratio and density (kg/m^3).

        Raises
        ------
        InputError
            If the constants are not admissible.
        """
        G = E / (2 * (1 + nu)) if nu > -1 else math.nan
        return cls(E, E, E, nu, nu, nu, G, G, G, rho)

    def compliance(self) -> FloatArray:
        """(6, 6) elastic compliance, 1/Pa, in Voigt order (rr, tt, zz, tz, rz, rt)."""
        import numpy as np

        rt, zt = -self.nu_theta_r / self.E_theta, -self.nu_theta_z / self.E_theta
        rz = -self.nu_z_r / self.E_z
        S = np.zeros((6, 6))
        S[:3, :3] = [[1 / self.E_r, rt, rz], [rt, 1 / self.E_theta, zt], [rz, zt, 1 / self.E_z]]
        S[3:, 3:] = np.diag([1 / self.G_z_theta, 1 / self.G_r_z, 1 / self.G_r_theta])
        return S

    def stiffness(self) -> FloatArray:
        """(6, 6) elastic stiffness, Pa, in Voigt order (rr, tt, zz, tz, rz, rt)."""
        import numpy as np

        S = self.compliance()
        C = np.zeros((6, 6))
        C[:3, :3] = np.linalg.inv(S[:3, :3])
        C[3:, 3:] = np.diag(1 / np.diag(S)[3:])
        return 0.5 * (C + C.T)


@dataclass(frozen=True)
class Constituent:
    """Constituent of a web: volume fraction, density, and in-plane elastic constants in the axes of the web.

    Attributes
    ----------
    fraction
        Volume fraction, 0 to 1.
    E_theta, E_z, G_z_theta
        Young's moduli along the web and along the axis, and in-plane shear modulus, Pa.
    nu_theta_z, rho
        In-plane Poisson's ratio; density, kg/m^3.
    """

    fraction: float
    E_theta: float
    E_z: float
    nu_theta_z: float
    G_z_theta: float
    rho: float

    @classmethod
    def isotropic(cls, fraction: float, E: float, nu: float, rho: float) -> Constituent:
        """Isotropic constituent.

        Parameters
        ----------
        fraction
            Volume fraction, 0 to 1.
        E, nu, rho
            Young's modulus (Pa), Poisson's ratio and density (kg/m^3).
        """
        return cls(fraction, E, E, nu, E / (2 * (1 + nu)), rho)


def weighted_mean(constituents: Sequence[Constituent], name: str) -> float:
    """Volume-weighted mean of one in-plane constant.

    If the volume fractions sum to less than 1, the rest is void. Voids reduce the moduli and the density; Poisson's
    ratio is the mean over the material alone.
    """
    total = sum(c.fraction for c in constituents)
    mean = sum(c.fraction * float(getattr(c, name)) for c in constituents)
    return mean / total if name == "nu_theta_z" else mean


def homogenise(
    constituents: Mapping[str, Constituent],
    *,
    limited_by: Mapping[str, str] | None = None,
    radial_ratio: float = RADIAL_RATIO,
    nu_theta_r: float = 0.3,
    nu_z_r: float = 0.3,
    G_interlayer: float | None = None,
) -> CylindricalOrthotropic:
    """Homogenised material of a coil whose web consists of several constituents (thesis, section 2.4).

    Each in-plane constant is the volume-weighted mean over all constituents, or the value of the one constituent that
    limits it (for a sparse frame on a membrane, the membrane limits the shear modulus).

    Parameters
    ----------
    constituents
        Name -> constituent; the fractions sum to at most 1, the rest is void.
    limited_by
        In-plane constant (one of `IN_PLANE`) -> name of the constituent that limits it.
    radial_ratio
        Ratio of E_r to the larger of E_theta and E_z.
    nu_theta_r, nu_z_r
        Out-of-plane Poisson's ratios.
    G_interlayer
        Interlayer shear modulus G_r_theta = G_r_z, Pa; None for G_z_theta, the limit without slip.

    Raises
    ------
    InputError
        For fractions outside 0 to 1, unknown names, or a material that is not admissible.

    Notes
    -----
    The mean of the moduli is an upper bound (Voigt) for frames with cutouts; it is exact along continuous members.
    """
    limited = dict(limited_by or {})
    total = sum(c.fraction for c in constituents.values())
    for name, c in constituents.items():
        if not 0.0 < c.fraction <= 1.0:
            raise InputError(
                f"must be above 0 and at most 1, got {c.fraction:g}", key=f"{name}.fraction",
                remedy="give the volume fraction in the web",
            )  # fmt: skip
    if not 0.0 < total <= 1.0 + 1e-9:
        raise InputError(
            f"the fractions of {', '.join(constituents) or 'no constituent'} sum to {total:g}", key="fraction",
            remedy="use fractions that sum to at most 1 (the rest is void)",
        )  # fmt: skip
    for constant, name in limited.items():
        if constant not in IN_PLANE or name not in constituents:
            raise InputError(
                f"the pair {constant}: {name} has an unknown constant or an unknown constituent", key="limited_by",
                remedy=f"map constants ({', '.join(IN_PLANE)}) to constituents ({', '.join(constituents)})",
            )  # fmt: skip
    parts = list(constituents.values())
    mixed = {
        key: float(getattr(constituents[limited[key]], key)) if key in limited else weighted_mean(parts, key)
        for key in IN_PLANE
    }
    G = mixed["G_z_theta"] if G_interlayer is None else G_interlayer
    return CylindricalOrthotropic(
        **mixed, E_r=radial_ratio * max(mixed["E_theta"], mixed["E_z"]), nu_theta_r=nu_theta_r, nu_z_r=nu_z_r,
        G_r_theta=G, G_r_z=G,
    )  # fmt: skip


CONSTANTS = tuple(f.name for f in fields(CylindricalOrthotropic))
"""Names of the nine elastic constants and the density."""
