"""Wound-roll stress: pressure, hoop stress and friction capacity after winding (thesis, section 2.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray
from wroll_fem.winding import kernels
from wroll_fem.winding.core import mandrel_stiffness
from wroll_fem.winding.radial_modulus import RadialModulus
from wroll_fem.winding.tension import tension_stress

if TYPE_CHECKING:
    from wroll_fem.case.winding import Winding


_BLOCKS, _ZONES = (4, 32), (128, 1024)
"""Numbers of wraps, passed to `kernels.lay_wraps` as ``blocks`` and ``zones``. With them, nodes far below the surface
are updated less often; the resulting relative error of the pressure is below 4e-5."""

_MANY = 4000
"""Number of wraps above which all values of `_BLOCKS` are doubled; the relative error of the pressure due to `_BLOCKS`
and `_ZONES` is then below 2e-4."""


@dataclass(frozen=True)
class WrapGrid:
    """Pressure and hoop stress on the grid of the thesis, which has one node per wrap.

    Attributes
    ----------
    radius, pressure
        (wraps + 1,) inner radius of each wrap and radius of the free surface, m; pressure there, Pa.
    hoop_stress
        (wraps,) mean hoop stress in each wrap, from equilibrium, Pa.
    """

    radius: FloatArray
    pressure: FloatArray
    hoop_stress: FloatArray


@dataclass(frozen=True)
class WoundRoll:
    """Stress in a wound roll at rest, from the surface of the mandrel outwards.

    Attributes
    ----------
    radius
        (n,) radii from the surface of the mandrel to the outer surface, m: faces of the wraps, or the nodes of the grid
        for continuous growth.
    pressure
        (n,) interlayer pressure, Pa, positive in compression; 0 at the outer surface.
    hoop_stress
        (n,) stress along the web, Pa, positive in tension; at a face between two wraps the mean of both.
    tension
        (n,) tension stress at which the web was wound, Pa.
    modulus
        Radial modulus.
    mandrel_stiffness
        K_m, Pa.
    mu
        Coefficient of friction between wraps, or None.
    error_estimate
        Estimated relative error of the pressure at the mandrel: the relative change of this pressure when the results
        of the two grids are extrapolated.
    hoop_bound
        Pressure at the mandrel if no wrap relaxed: sum of T h/r, Pa.
    wraps
        The same roll on the grid of the thesis.
    """

    radius: FloatArray
    pressure: FloatArray
    hoop_stress: FloatArray
    tension: FloatArray
    modulus: RadialModulus
    mandrel_stiffness: float
    mu: float | None
    error_estimate: float
    hoop_bound: float
    wraps: WrapGrid

    @property
    def capacity(self) -> FloatArray:
        """(n,) friction capacity: mu times the pressure, Pa (equation 2.16).

        Raises
        ------
        InputError
            If the section `winding` has no coefficient of friction.
        """
        return self._mu * self.pressure

    def pressure_at(self, radius: FloatArray) -> FloatArray:
        """(k,) pressure, Pa, at radii (k,), m: 0 beyond the last wrap; below the first wrap, the value at this wrap."""
        return np.interp(radius, self.radius, self.pressure, right=0.0)

    def capacity_at(self, radius: FloatArray) -> FloatArray:
        """(k,) friction capacity, Pa, at radii (k,), m: mu times the pressure of `pressure_at`.

        Raises
        ------
        InputError
            If the section `winding` has no coefficient of friction.
        """
        return self._mu * self.pressure_at(radius)

    @property
    def _mu(self) -> float:
        if self.mu is None:
            raise InputError(
                "required key is missing", key="winding.mu", remedy="add it (coefficient of friction between wraps)"
            )
        return self.mu


def wound_roll(section: Winding) -> WoundRoll:
    """Stress in the wound roll described by a case section `winding`.

    With ``growth: wraps`` each wrap exerts the pressure T h/r on the roll below it, and the equations are solved on a
    grid with several cells per wrap. With ``continuous`` the wraps are infinitely thin, so only the tension stress and
    the total thickness matter. The results of two grids, one twice as fine as the other, are extrapolated.
    `WoundRoll.wraps` is the result of the scheme of the thesis, with one node per wrap.

    Raises
    ------
    InputError
        If the section has no mandrel (`Winding.on_mandrel` takes it from geometry and mandrel of a case).

    References
    ----------
    Thesis, section 2.2; Hakiel, Tappi J. 70(5), 1987.
    """
    stiffness = mandrel_stiffness(section.core)
    modulus = RadialModulus.from_case(section.web.radial_modulus)
    core = section.web.E_theta / stiffness + section.web.nu_theta
    if section.growth == "continuous":
        half = section.cells // 2
        coarse, fine = _grown(section, half, core, modulus), _grown(section, 2 * half, core, modulus)[:, ::2]
    else:
        half = max(1, section.cells // (2 * section.wraps))
        coarse, fine = _laid(section, half, core, modulus), _laid(section, 2 * half, core, modulus)
    radius, pressure, hoop = (4.0 * fine - coarse) / 3.0  # Richardson extrapolation of second order
    return WoundRoll(
        radius, pressure, hoop, tension_stress(section, radius), modulus, stiffness, section.mu,
        float(abs(pressure[0] / fine[1, 0] - 1.0)), _hoop_bound(section), _on_wraps(section, core, modulus),
    )  # fmt: skip


def _laid(section: Winding, cells: int, core: float, modulus: RadialModulus) -> FloatArray:
    """(3, wraps + 1) radius, pressure and hoop stress at the faces of the wraps, with ``cells`` cells in each wrap.

    The stress inside a wrap is discontinuous, because each wrap relaxes the one below; it is not returned.
    """
    under, tension = _under_wraps(section)
    h, inner = section.wrap_thickness, under[0]
    radius = inner + section.build_up * np.linspace(0.0, 1.0, section.wraps * cells + 1)
    blocks = np.array(_BLOCKS if section.wraps <= _MANY else [2 * block for block in _BLOCKS])
    pressure = kernels.lay_wraps(
        radius, tension[:-1], h, cells, section.web.E_theta, core, *modulus.knots, blocks, np.array(_ZONES)
    )[::cells]
    mean = -np.diff(under * pressure) / h
    hoop = np.concatenate([mean[:1], 0.5 * (mean[1:] + mean[:-1]), mean[-1:]])
    # the first wrap keeps its tension while it is wound; only later wraps relax it
    hoop[0], hoop[-1] = tension[0] - core * (pressure[0] - tension[0] * h / inner), tension[-2]
    return np.array([under, pressure, hoop])


def _grown(section: Winding, cells: int, core: float, modulus: RadialModulus) -> FloatArray:
    """(3, nodes) radius, pressure and hoop stress of a roll that grows continuously."""
    inner = section.core.outer_radius
    radius = inner * (1.0 + section.build_up / inner) ** np.linspace(0.0, 1.0, cells + 1)
    tension = tension_stress(section, radius)
    pressure = kernels.accrete(radius, tension, section.web.E_theta, core, *modulus.knots)
    hoop = -np.gradient(radius * pressure, np.log(radius[1] / radius[0])) / radius
    hoop[0], hoop[-1] = tension[0] - core * pressure[0], tension[-1]
    return np.array([radius, pressure, hoop])


def _under_wraps(section: Winding) -> tuple[FloatArray, FloatArray]:
    """(wraps + 1,) inner radii of the wraps and radius of the free surface, m; tension stress at these radii, Pa."""
    radius = section.core.outer_radius + section.wrap_thickness * np.arange(section.wraps + 1)
    return radius, tension_stress(section, radius)


def _on_wraps(section: Winding, core: float, modulus: RadialModulus) -> WrapGrid:
    radius, tension = _under_wraps(section)
    h = section.wrap_thickness
    pressure = kernels.wrap_by_wrap(radius, tension, h, section.web.E_theta, core - 1.0, *modulus.knots)
    return WrapGrid(radius, pressure, -np.diff(radius * pressure) / h)


def _hoop_bound(section: Winding) -> float:
    radius, tension = _under_wraps(section)
    return float(np.sum(tension[:-1] * section.wrap_thickness / radius[:-1]))
