r"""Geometric stiffness of a tube in a static state of one wave number k, and follower stiffness of a pressure.

The work of the initial stresses s on the second-order Green strains, with the derivatives g of the displacement along z
and theta, the first-order change d of the director and the displacement m of the mid-surface,

    int [ s_zz g_z.g_z / 2 + s_tt (g_t.g_t / 2 - zeta d.d / (2 r)) + s_tz g_z.g_t + s_rz d.m,z + s_rt d.m,t / r ] dV,

couples the wave numbers n and n' of trial and test function if n' = |n - k| or n' = n + k: its integrals over theta are
those of three sines or cosines. A pressure that follows its surface adds the second variation of p times the enclosed
volume (docs/geometric-stiffness.md, eq-volume).

Notes
-----
Motions are symmetric about the plane theta = 0. The second-order motion of a rigid tip ring is left out. It concerns
the tilt of the ring (n = 1) under a pressure p alone; relative to the stiffness of a tube in bending it is about
p L / (E sqrt(R t)), 1e-3 for the mandrels of the thesis.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem

from wroll_fem.fem import compat
from wroll_fem.fem.fourier_shell.kinematics import COMPONENTS, Gradient, director_change, gradients, stresses
from wroll_fem.fem.fourier_shell.model import FourierShellModel
from wroll_fem.typing import FloatArray

_WAVES: dict[str, Any] = {"c": np.cos, "s": np.sin}


class GeometricStiffness:
    """Second variations of the work of initial stresses and of a follower pressure; forms compiled once."""

    def __init__(self, model: FourierShellModel):
        self.model = model
        names = ("state", "trial", "test", *("".join(p) for p in product("cs", repeat=3)))
        self._constants = {name: fem.Constant(model.mesh, 0.0) for name in names}
        self._state = fem.Function(model.space, name="state")
        u, v = ufl.TrialFunction(model.space), ufl.TestFunction(model.space)
        self._stress_form = compat.compile_form(self._stress_work(u, v) * model.dx())
        self._pressure_form = compat.compile_form(self._volume(u, v) * model.dx())

    def _dot(self, kind: str, a: Gradient, b: Gradient) -> Any:
        """Integral over theta of the scalar product a.b times cos k theta ("c") or sin k theta ("s")."""
        return sum(self._constants[kind + i + j] * x * y for (x, i), (y, j) in zip(a, b, strict=True))

    def _stress_work(self, u: Any, v: Any) -> Any:
        c, radius = self._constants, self.model.constants["radius"]
        slopes = [[q[i].dx(0) for i in range(COMPONENTS)] for q in (u, v)]
        waves = (c["trial"], c["test"])
        du, dv = director_change(u), director_change(v)
        (mu_z, mu_t), (mv_z, mv_t) = (
            gradients(q, dq, n, radius, 0) for q, dq, n in zip((u, v), slopes, waves, strict=True)
        )
        total: Any = 0
        for zeta, weight in self.model.layers():
            s = stresses(self.model.strains(self._state, c["state"], zeta), self.model.plane())
            (u_z, u_t), (v_z, v_t) = (
                gradients(q, dq, n, radius, zeta) for q, dq, n in zip((u, v), slopes, waves, strict=True)
            )
            r = radius + zeta
            axial = s.zz * self._dot("c", u_z, v_z)
            hoop = s.tt * (self._dot("c", u_t, v_t) - zeta / r * self._dot("c", du, dv))
            shear = s.tz * (self._dot("s", u_z, v_t) + self._dot("s", u_t, v_z))
            across_z = s.rz * (self._dot("c", du, mv_z) + self._dot("c", mu_z, dv))
            across_t = s.rt * radius / r * (self._dot("s", du, mv_t) + self._dot("s", mu_t, dv))
            total = total + weight * (axial + hoop + shear + across_z + across_t)
        return total

    def _volume(self, u: Any, v: Any) -> Any:
        """Second variation of the volume enclosed by the outer surface, per height."""
        c, radius = self._constants, self.model.constants["radius"]
        h = 0.5 * self.model.constants["thickness"]
        total = -h * self._dot("c", director_change(u), director_change(v))
        for p, q, n in ((u, v, c["trial"]), (v, u, c["test"])):
            slopes = [p[i].dx(0) for i in range(COMPONENTS)]
            (z_r, _, z_z), (t_r, t_t, _) = gradients(p, slopes, n, radius, h)
            turned: Gradient = ((t_t[0] + z_z[0], "c"), (-t_r[0], "s"), (-z_r[0], "c"))
            moved: Gradient = ((q[0], "c"), (q[1] + h * q[3], "s"), (q[2] + h * q[4], "c"))
            total = total + 0.5 * self._dot("c", turned, moved)
        return (radius + h) * total

    def _set_waves(self, state: int, trial: int, test: int) -> None:
        for name, value in (("state", state), ("trial", trial), ("test", test)):
            self._constants[name].value = float(value)
        points = 2 * (state + trial + test) + 4  # the trapezoidal rule is exact
        theta = 2.0 * np.pi * np.arange(points) / points
        for kinds in product("cs", repeat=3):
            waves = [_WAVES[k](n * theta) for k, n in zip(kinds, (state, trial, test), strict=True)]
            integral = 2.0 * np.pi * float(np.mean(waves[0] * waves[1] * waves[2]))
            self._constants["".join(kinds)].value = integral

    def stress_stiffness(self, field: FloatArray, state: int, test: int, trial: int) -> sp.csr_matrix:
        """(5 n_nodes, 5 n_nodes) geometric stiffness, N/m, between motions of the wave numbers `test` and `trial`.

        Parameters
        ----------
        field
            (5 n_nodes,) static displacements, m and rad.
        state
            Wave number of this field.
        test, trial
            Wave numbers of the rows and of the columns.
        """
        self._set_waves(state, trial, test)
        self._state.x.array[self.model.dof_order] = field
        return self.model.matrix(self._stress_form)

    def pressure_stiffness(self, wave_number: int) -> sp.csr_matrix:
        """(5 n_nodes, 5 n_nodes) follower stiffness, N/m, of an inward pressure of 1 Pa on the outer surface."""
        self._set_waves(0, wave_number, wave_number)
        return self.model.matrix(self._pressure_form)
