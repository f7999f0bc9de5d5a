r"""Cylindrical-orthotropic elasticity of a wound web: stiffness, admissibility, mixture of its constituents. FEM-free.

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

if TYPE_CHECKING:  # cases are checked without numpy
    pass


MODULI = ("E_theta", "E_z", "E_r", "G_z_theta", "G_r_theta", "G_r_z")
IN_PLANE = ("E_theta", "E_z", "nu_theta_z", "G_z_theta", "rho")
"""Constants of a web that the mixture of its constituents decides."""

RADIAL_RATIO = 0.01
"""E_r over the largest in-plane modulus where nothing better is known (thesis, sections 2.4 and 2.5)."""

_ROUNDING = 1e-12


class Orthotropic(Protocol):
    """Anything that carries the nine constants."""

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
    """First condition of admissibility that a material breaks.

    Attributes
    ----------
    key
        Constant to blame.
    value
        Its value.
    problem, remedy
        What is wrong and what would be right.
    """

    key: str
    value: float
    problem: str
    remedy: str


def violation(m: Orthotropic) -> Violation | None:
    """First broken condition of the module's docstring, or None for an admissible material."""
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
                f"breaks |{key}| < sqrt({first} / {second}) = {bound:.4g}: the strain energy would not be positive"
            )
            remedy = f"use a smaller {key} (nu_ij = -strain_j / strain_i under stress i)"
            return Violation(key, nu, problem, remedy)
    tz, zr, rt = m.nu_theta_z, m.nu_z_r, m.nu_theta_r * m.E_r / m.E_theta
    rest = 1 - tz**2 * m.E_z / m.E_theta - m.nu_theta_r * rt - zr**2 * m.E_r / m.E_z - 2 * tz * zr * rt
    if rest <= _ROUNDING:
        problem = (
            "breaks 1 - nu_tz nu_zt - nu_tr nu_rt - nu_zr nu_rz - 2 nu_tz nu_zr nu_rt > 0 "
            f"(it is {rest:.3g}): the strain energy would not be positive"
        )
        remedy = "make one of nu_theta_z, nu_theta_r, nu_z_r smaller in size"
        return Violation("nu_theta_z", float(tz), problem, remedy)
    return None


@dataclass(frozen=True)
class CylindricalOrthotropic:
    """Linear elastic material with three planes of symmetry, normal to r, theta and z.

    Attributes
    ----------
    E_theta, E_z, E_r
        Young's moduli along the web, along the axis and through the stack, Pa.
    nu_theta_z, nu_theta_r, nu_z_r
        Poisson's ratios, nu_ij = -strain_j / strain_i under stress i.
    G_z_theta, G_r_theta, G_r_z
        Shear moduli, Pa; the last two are those between the wraps.
    rho
        Density, kg/m^3.

    Raises
    ------
    InputError
        If the constants are not admissible: which condition, which value, what would be right.
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
        """Isotropic limit: E (Pa), nu and rho (kg/m^3); every shear modulus is E / (2 (1 + nu))."""
        G = E / (2 * (1 + nu)) if nu > -1 else math.nan
        return cls(E, E, E, nu, nu, nu, G, G, G, rho)

    def compliance(self) -> FloatArray:
        """(6, 6) strain per stress, 1/Pa, Voigt order (rr, tt, zz, tz, rz, rt)."""
        import numpy as np

        rt, zt = -self.nu_theta_r / self.E_theta, -self.nu_theta_z / self.E_theta
        rz = -self.nu_z_r / self.E_z
        S = np.zeros((6, 6))
        S[:3, :3] = [[1 / self.E_r, rt, rz], [rt, 1 / self.E_theta, zt], [rz, zt, 1 / self.E_z]]
        S[3:, 3:] = np.diag([1 / self.G_z_theta, 1 / self.G_r_z, 1 / self.G_r_theta])
        return S

    def stiffness(self) -> FloatArray:
        """(6, 6) stress per strain, Pa, Voigt order (rr, tt, zz, tz, rz, rt)."""
        import numpy as np

        S = self.compliance()
        C = np.zeros((6, 6))
        C[:3, :3] = np.linalg.inv(S[:3, :3])
        C[3:, 3:] = np.diag(1 / np.diag(S)[3:])
        return 0.5 * (C + C.T)


@dataclass(frozen=True)
class Constituent:
    """One of the materials that a web is made of, with its in-plane constants in the web's axes.

    Attributes
    ----------
    fraction
        Share of the web's volume, 0 to 1.
    E_theta, E_z, G_z_theta
        Pa.
    nu_theta_z, rho
        Dimensionless; kg/m^3.
    """

    fraction: float
    E_theta: float
    E_z: float
    nu_theta_z: float
    G_z_theta: float
    rho: float

    @classmethod
    def isotropic(cls, fraction: float, E: float, nu: float, rho: float) -> Constituent:
        """Isotropic constituent: share of the volume, E (Pa), nu, rho (kg/m^3)."""
        return cls(fraction, E, E, nu, E / (2 * (1 + nu)), rho)


def weighted_mean(constituents: Sequence[Constituent], name: str) -> float:
    """Volume-weighted mean of one in-plane constant; what is missing to 1 is void and counts as zero.

    Voids count in moduli and density; Poisson's ratio is the mean over the material that is there.
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
    """Homogenised coil of a web with a representative volume element of several constituents.

    Thesis, section 2.4: each in-plane constant is the weighted mean over all constituents, or that of the one
    constituent that limits it (the shear modulus of a sparse frame on a membrane is the membrane's).

    Parameters
    ----------
    constituents
        Name -> constituent; the fractions add to at most 1, the rest is void.
    limited_by
        In-plane constant (one of `IN_PLANE`) -> name of the constituent whose value it takes.
    radial_ratio
        E_r over the larger of E_theta and E_z.
    nu_theta_r, nu_z_r
        Out-of-plane Poisson's ratios.
    G_interlayer
        G_r_theta = G_r_z, Pa; None for the limit of a stack without slip, G_z_theta.

    Raises
    ------
    InputError
        For fractions outside 0 to 1, unknown names, or a mixture that is not admissible.

    Notes
    -----
    The mean of moduli is an upper bound for frames with cutouts (Voigt); it holds along members that run through.
    """
    limited = dict(limited_by or {})
    total = sum(c.fraction for c in constituents.values())
    for name, c in constituents.items():
        if not 0.0 < c.fraction <= 1.0:
            raise InputError(
                f"must be above 0 and at most 1, got {c.fraction:g}", key=f"{name}.fraction",
                remedy="give the share of the web's volume",
            )  # fmt: skip
    if not 0.0 < total <= 1.0 + 1e-9:
        raise InputError(
            f"fractions of {', '.join(constituents) or 'no constituent'} add to {total:g}", key="fraction",
            remedy="they must add to at most 1 (the rest is void)",
        )  # fmt: skip
    for constant, name in limited.items():
        if constant not in IN_PLANE or name not in constituents:
            raise InputError(
                f"cannot take {constant} from {name}", key="limited_by",
                remedy=f"constants: {', '.join(IN_PLANE)}; constituents: {', '.join(constituents)}",
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
