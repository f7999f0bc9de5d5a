r"""Lowest bending frequency of concentric tubes that stick on each other by springs, as beams with one deflection.

Tube k has the deflection w of all tubes and a tilt :math:`\varphi_k` of its own. Its sections move along the axis by
:math:`-R_k \varphi_k \cos\theta` at the middle of its wall, and turn with w' through it. Two tubes i and o therefore
move by :math:`J \cos\theta` on each other. Springs of stiffness k (per area) at radius r between them have the energy

.. math:: \tfrac12 \pi r k \int J^2\, dz, \qquad J = R_o (\varphi_o - w') - R_i (\varphi_i - w')

beside :math:`\tfrac12 \int E I_k \varphi_k'^2 + S_k (w' - \varphi_k)^2\, dz` of each tube. Without shear strain of the
tubes (S infinite) nothing slides; with k infinite and thin tubes all have one tilt. Hoop displacements of the tubes
are equal. Two-node elements with one integration point, refined towards the base.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from wroll_fem.typing import FloatArray, IntArray

ELEMENTS, FINEST = 60, 0.05
"""Number of elements between the base and the tip, and height of the lowest one relative to the uppermost one."""

SHIFT = 1.0
"""Distance of the shift below zero, rad^2/s^2."""

MOVING = 1e-3
"""Frequency, Hz, above which a motion of free tubes is not rigid."""


class StickingTube(NamedTuple):
    """Tube of `lowest_frequency`.

    Attributes
    ----------
    radius : radius of the middle of the wall, m
    bending, shear : stiffnesses E I, N m^2, and S, N
    mass : mass per length, kg/m
    span : heights of its ends, m
    base : tilt stiffness at its lower end, N m/rad; None: held
    """

    radius: float
    bending: float
    shear: float
    mass: float
    span: tuple[float, float]
    base: float | None


def lowest_frequency(
    tubes: Sequence[StickingTube],
    springs: Sequence[tuple[float, float]],
    length: float,
    *,
    lateral: float | None = None,
    tip_stiffness: FloatArray | None = None,
    tip_mass: FloatArray | None = None,
) -> float:
    """Lowest frequency that is not a rigid motion, Hz; zero if there is none.

    Parameters
    ----------
    tubes
        Inner first; the first one has the whole length and carries the body at the tip.
    springs
        (radius, m, and stiffness per area, Pa/m) between each tube and the next.
    lateral
        Lateral stiffness at the base, N/m; None: held.
    tip_stiffness, tip_mass
        (2, 2) matrices for lateral motion and tilt of the tip of the first tube.
    """
    ratio = FINEST ** (1.0 / ELEMENTS)
    ends = {end for tube in tubes for end in tube.span}
    grown = length * (ratio ** -np.arange(ELEMENTS + 1.0) - 1.0) / (ratio**-ELEMENTS - 1.0)
    z = np.unique(np.concatenate([grown, list(ends)]))
    z = z[np.append(True, np.diff(z) > 1e-9 * length)]
    width = 1 + len(tubes)  # unknowns of a node: w and the tilts
    rows, weights, mass = _energy(tubes, springs, z, width)
    stiffness = (rows.T @ sp.diags(weights) @ rows).tolil()
    inertia = sp.diags(mass).tolil()
    last = (len(z) - 1) * width + np.array([0, 1])
    for matrix, part in ((stiffness, tip_stiffness), (inertia, tip_mass)):
        if part is not None:
            matrix[np.ix_(last, last)] += np.asarray(part)
    held = []
    for number, spring in enumerate([lateral, *(tube.base for tube in tubes)]):
        node = 0 if number == 0 else int(np.argmin(np.abs(z - tubes[number - 1].span[0])))
        at = node * width + number
        if spring is None:
            held.append(at)
        else:
            stiffness[at, at] += spring
    kept = np.setdiff1d(np.flatnonzero(stiffness.diagonal() > 0.0), held)
    K, M = (matrix.tocsc()[kept][:, kept] for matrix in (stiffness, inertia))
    start = np.ones(len(kept))
    values = spla.eigsh(K, k=min(3, len(kept) - 1), M=M, sigma=-SHIFT, v0=start, return_eigenvectors=False)
    found = np.sort(np.sqrt(np.maximum(values, 0.0))) / (2.0 * math.pi)
    moving = found[found > MOVING]
    return float(moving[0]) if moving.size else 0.0


_Terms: TypeAlias = list[tuple[IntArray, FloatArray]]
"""Unknowns (m,) and their factors (m,) in a strain of each of m elements."""


def _energy(
    tubes: Sequence[StickingTube], springs: Sequence[tuple[float, float]], z: FloatArray, width: int
) -> tuple[sp.csr_matrix, FloatArray, FloatArray]:
    """Rows of the strains of all elements, their stiffness, and the mass of each unknown."""
    h, first = np.diff(z), width * np.arange(len(z) - 1)
    middle = 0.5 * (z[1:] + z[:-1])
    inside = [(middle > tube.span[0]) & (middle < tube.span[1]) for tube in tubes]
    mass, strains, weights = np.zeros(width * len(z)), list[_Terms](), list[FloatArray]()

    def slope(number: int, factor: float) -> _Terms:
        return [(first + number, -factor / h), (first + width + number, factor / h)]

    def mean(number: int, factor: float) -> _Terms:
        half = np.full(len(h), 0.5 * factor)
        return [(first + number, half), (first + width + number, half)]

    for number, (tube, here) in enumerate(zip(tubes, inside, strict=True), start=1):
        strains += [slope(number, 1.0), slope(0, 1.0) + mean(number, -1.0)]
        weights += [tube.bending * here * h, tube.shear * here * h]
        for node in (first, first + width):
            mass[node] += 0.5 * tube.mass * here * h
    for number, (radius, stick) in enumerate(springs, start=1):
        inner, outer = tubes[number - 1].radius, tubes[number].radius
        strains.append(mean(number + 1, outer) + mean(number, -inner) + slope(0, inner - outer))
        weights.append(math.pi * radius * stick * (inside[number - 1] & inside[number]) * h)
    rows = np.arange(len(strains) * len(h)).reshape(len(strains), -1)
    entries = [(row, *term) for row, terms in zip(rows, strains, strict=True) for term in terms]
    row, column, value = (np.concatenate(part) for part in zip(*entries, strict=True))
    return sp.csr_matrix((value, (row, column)), shape=(rows.size, len(mass))), np.concatenate(weights), mass
