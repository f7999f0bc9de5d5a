"""Stress that winding leaves in a roll."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..body import FloatArray
from ..errors import InputError
from . import kernels
from .core import mandrel_stiffness
from .radial_modulus import RadialModulus
from .tension import tension_stress

if TYPE_CHECKING:
    from ..case.winding import Winding


@dataclass(frozen=True)
class WrapGrid:
    """The source's own grid: one node under each wrap.

    Attributes
    ----------
    radius, pressure
        (wraps + 1,) radius under each wrap and of the free surface, m; pressure there, Pa.
    hoop_stress
        (wraps,) mean tension in each wrap, Pa, from its equilibrium.
    """

    radius: FloatArray
    pressure: FloatArray
    hoop_stress: FloatArray


@dataclass(frozen=True)
class WoundRoll:
    """Stress in a wound roll at rest, from the mandrel's surface outwards.

    Attributes
    ----------
    radius
        (n,) m, the mandrel's outer radius first, the roll's last: the nodes that two grids share.
    pressure
        (n,) between the wraps, Pa, positive in compression; 0 at the outer radius.
    hoop_stress
        (n,) along the web, Pa, positive in tension.
    tension
        (n,) tension stress with which the web was laid there, Pa.
    modulus
        Radial modulus of the stack.
    mandrel_stiffness
        K_m, Pa.
    mu
        Friction between wraps; None when the section has none.
    error_estimate
        Estimated relative error of the pressure at the mandrel: what extrapolation from the two grids changes.
    wraps
        The same roll on the source's grid.
    """

    radius: FloatArray
    pressure: FloatArray
    hoop_stress: FloatArray
    tension: FloatArray
    modulus: RadialModulus
    mandrel_stiffness: float
    mu: float | None
    error_estimate: float
    wraps: WrapGrid

    @property
    def capacity(self) -> FloatArray:
        """(n,) largest shear stress that friction holds, mu times the pressure, Pa (equation 2.16)."""
        return self._mu * self.pressure

    def pressure_at(self, radius: FloatArray) -> FloatArray:
        """Pressure at ``radius`` (k,) in m, Pa: that at the mandrel inside, 0 outside the roll."""
        return np.interp(radius, self.radius, self.pressure, right=0.0)

    def capacity_at(self, radius: FloatArray) -> FloatArray:
        """Capacity at ``radius`` (k,) in m, Pa: that at the mandrel inside, 0 outside the roll.

        Raises
        ------
        InputError
            When the section has no coefficient of friction.
        """
        return self._mu * self.pressure_at(radius)

    @property
    def hoop_bound(self) -> float:
        """Pressure at the mandrel if no wrap relaxed: integral of T/r over the radius, Pa."""
        step = np.log(self.radius[-1] / self.radius[0]) / (len(self.radius) - 1)
        return float(step * (self.tension.sum() - 0.5 * (self.tension[0] + self.tension[-1])))

    @property
    def _mu(self) -> float:
        if self.mu is None:
            raise InputError(
                "required key is missing", key="winding.mu", remedy="add it (coefficient of friction between wraps)"
            )
        return self.mu


def wound_roll(section: Winding) -> WoundRoll:
    """Stress in the roll that a section `winding` describes.

    The roll grows continuously, which makes the result independent of the grid and of the thickness of a wrap. It is
    computed on two grids, `cells` and half of them, and extrapolated; `WoundRoll.wraps` holds the same roll by the
    source's scheme, one row per wrap.

    Raises
    ------
    InputError
        When the section has no mandrel (`case.winding.completed` takes it from the rest of a case).

    References
    ----------
    Thesis, section 2.2; Hakiel, Tappi J. 70(5), 1987.
    """
    if section.mandrel is None:
        raise InputError(
            "required section is missing", key="winding.mandrel", remedy="add it (outer_radius, wall, E, nu)"
        )
    inner, stiffness = section.mandrel.outer_radius, mandrel_stiffness(section.mandrel)
    modulus = RadialModulus.of(section.web.radial_modulus)
    core = section.web.E_theta / stiffness + section.web.nu_theta

    def grown(cells: int) -> FloatArray:  # (4, cells + 1): radius, tension, pressure, hoop stress
        radius = inner * (1.0 + section.build_up / inner) ** np.linspace(0.0, 1.0, cells + 1)
        tension = tension_stress(section, radius)
        pressure = kernels.accrete(radius, tension, section.web.E_theta, core, *modulus.knots)
        return np.array([radius, tension, pressure, hoop_stress(radius, pressure, tension, core)])

    coarse = grown(section.cells // 2)
    fine = grown(2 * (section.cells // 2))[:, ::2]
    radius, tension, pressure, hoop = (4.0 * fine - coarse) / 3.0  # both are of second order
    return WoundRoll(
        radius, pressure, hoop, tension, modulus, stiffness, section.mu,
        float(abs(pressure[0] / fine[2, 0] - 1.0)), _on_wraps(section, core, modulus),
    )  # fmt: skip


def hoop_stress(radius: FloatArray, pressure: FloatArray, tension: FloatArray, core: float) -> FloatArray:
    """(n,) Pa: equilibrium, -d(r P)/dr inside; the web's tension outside; the mandrel's strain at the core."""
    step = np.log(radius[1] / radius[0])
    hoop = -np.gradient(radius * pressure, step) / radius
    hoop[0], hoop[-1] = tension[0] - core * pressure[0], tension[-1]
    return hoop


def _on_wraps(section: Winding, core: float, modulus: RadialModulus) -> WrapGrid:
    assert section.mandrel is not None
    h = section.wrap_thickness
    radius = section.mandrel.outer_radius + h * np.arange(section.wraps + 1)
    tension = tension_stress(section, radius)
    pressure = kernels.wrap_by_wrap(radius, tension, h, section.web.E_theta, core - 1.0, *modulus.knots)
    return WrapGrid(radius, pressure, -np.diff(radius * pressure) / h)
