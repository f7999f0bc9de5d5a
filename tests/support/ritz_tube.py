"""Buckling of a tube under external pressure by a Ritz method: polynomials along the axis, one wave number around.

An independent discretisation of the shell of docs/geometric-stiffness.md: components (w radial, v hoop, u axial, and
changes b_t, b_z of the director), derivatives written out for a cylinder, no mesh and no rotation vector.
"""

import numpy as np
import scipy.linalg as la
from numpy.polynomial import legendre

RADIAL, HOOP, AXIAL, TURN_HOOP, TURN_AXIAL = range(5)
SIMPLE = (RADIAL, HOOP, TURN_HOOP)
CLAMPED = (RADIAL, HOOP, AXIAL, TURN_HOOP, TURN_AXIAL)


class RitzTube:
    """Tube of a `ShellSection` with mid-surface radius and length in m; the components `held` vanish at both ends."""

    def __init__(self, section, radius, length, held, degree=40):
        self.section, self.radius = section, radius
        points, weights = legendre.leggauss(2 * degree)
        self.weight = 0.5 * length * weights
        values = np.array([legendre.legval(points, np.eye(degree)[k]) for k in range(degree)]).T
        slopes = np.array([legendre.legval(points, legendre.legder(np.eye(degree)[k])) for k in range(degree)]).T * (
            2 / length
        )
        # differences of Legendre polynomials of equal parity vanish at both ends
        free = np.eye(degree)
        fixed = np.eye(degree)[2:] - np.eye(degree)[np.arange(degree - 2) % 2]
        bases = [fixed if c in held else free for c in range(5)]
        starts = np.concatenate([[0], np.cumsum([len(b) for b in bases])])
        self.count = int(starts[-1])
        self.fields = np.zeros((5, len(points), self.count))
        self.slopes = np.zeros_like(self.fields)
        for c, basis in enumerate(bases):
            part = slice(starts[c], starts[c + 1])
            self.fields[c, :, part], self.slopes[c, :, part] = values @ basis.T, slopes @ basis.T

    def _gradients(self, n):
        """Vectors (radial, hoop, axial) of the derivatives of u along hoop and axis, and of the director."""
        w, v, u, bt, bz = self.fields
        dw, dv, du, dbt, dbz = self.slopes
        R, none = self.radius, np.zeros_like(w)
        around = np.array([-n * w - v, n * v + w, -n * u]) / R
        along = np.array([dw, dv, du])
        turn_around = np.array([-bt, n * bt, -n * bz]) / R
        turn_along = np.array([none, dbt, dbz])
        return around, along, turn_around, turn_along

    def _strains(self, n):
        bt, bz = self.fields[TURN_HOOP], self.fields[TURN_AXIAL]
        around, along, turn_around, turn_along = self._gradients(n)
        membrane = (along[2], around[1], around[2] + along[1])
        curvature = (turn_along[2], turn_around[1] + around[1] / self.radius,
                     turn_around[2] + turn_along[1] + along[1] / self.radius)  # fmt: skip
        shear = (along[0] + bz, around[0] + bt)
        return membrane, curvature, shear

    def _moduli(self):
        s = self.section
        plane, G = s.E / (1 - s.nu**2), s.E / (2 * (1 + s.nu))
        ratio = np.array([[1, s.nu, 0], [s.nu, 1, 0], [0, 0, (1 - s.nu) / 2]])
        return plane * s.thickness * ratio, plane * s.thickness**3 / 12 * ratio, 5 / 6 * G * s.thickness

    def _gram(self, a, b, density=1.0):
        return np.einsum("q,qi,qj->ij", self.weight * density, a, b)

    def stiffness(self, n):
        """Stiffness per half circumference (cosines and sines have the mean square 1/2), N/m per pi R."""
        membrane, curvature, shear = self._strains(n)
        C, D, S = self._moduli()
        total = sum(S * self._gram(g, g) for g in shear)
        for i in range(3):
            for k in range(3):
                total = total + C[i, k] * self._gram(membrane[i], membrane[k])
                total = total + D[i, k] * self._gram(curvature[i], curvature[k])
        return total

    def prestress(self):
        """Resultants (N_z, N_t, M_z, M_t, Q_z) along the axis under 1 Pa, of the axisymmetric linear solution."""
        K = self.stiffness(0)
        load = -np.einsum("q,qi->i", self.weight, self.fields[RADIAL])
        # torsion and an axial shift are not loaded: least squares leaves them out
        q = la.lstsq(K, load)[0]
        membrane, curvature, shear = self._strains(0)
        C, D, S = self._moduli()
        N = [sum(C[i, k] * (membrane[k] @ q) for k in range(3)) for i in range(2)]
        M = [sum(D[i, k] * (curvature[k] @ q) for k in range(3)) for i in range(2)]
        return N[0], N[1], M[0], M[1], S * (shear[0] @ q)

    def geometric(self, n):
        """Second derivative of the work of the prestress and of the pressure, per Pa, in the unit of `stiffness`."""
        Nz, Nt, Mz, Mt, Qz = self.prestress()
        w, v, u, bt, bz = self.fields
        around, along, turn_around, turn_along = self._gradients(n)
        total = np.zeros((self.count, self.count))
        for c in range(3):
            total += self._gram(along[c], along[c], Nz) + self._gram(around[c], around[c], Nt)
            total += 2 * self._gram(along[c], turn_along[c], Mz) + 2 * self._gram(around[c], turn_around[c], Mt)
        total -= self._gram(bt, bt, Mt / self.radius) + self._gram(bz, bz, Mt / self.radius)
        total += 2 * self._gram(along[1], bt, Qz) + 2 * self._gram(along[2], bz, Qz)
        # pressure on the mid-surface: change of the enclosed volume
        total += self._gram(w, around[1] + along[2]) - self._gram(v, around[0]) - self._gram(u, along[0])
        return 0.5 * (total + total.T)

    def critical_pressure(self, n):
        """Lowest pressure, Pa, at which the tube buckles with n waves."""
        nu = la.eigh(-self.geometric(n), self.stiffness(n), eigvals_only=True)
        return 1.0 / nu[-1]


def von_mises(section, radius, length, n):
    """Pressure, Pa, of a simply supported tube under lateral pressure (von Mises 1914; Timoshenko and Gere 11.5)."""
    E, nu, t = section.E, section.nu, section.thickness
    z = 1 + (n * length / (np.pi * radius)) ** 2
    bending = t**2 / (12 * radius**2 * (1 - nu**2)) * (n**2 - 1 + (2 * n**2 - 1 - nu) / z)
    return E * t / radius * (1 / ((n**2 - 1) * z**2) + bending)
