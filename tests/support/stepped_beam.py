"""Clamped beam of a tube whose wall varies along its axis, as many uniform elements with transverse shear."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wroll_fem.typing import FloatArray

Radii = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
SHEAR_FACTOR = 0.53
"""Cowper's factor of a thin tube with a Poisson's ratio of 0.33."""


def stepped_beam(length: float, radii: Radii, E: float, nu: float, rho: float, count: int = 300) -> FloatArray:
    """First two bending frequencies, Hz; ``radii`` gives inner and outer radii (m) at heights (m)."""
    h = length / count
    inner, outer = radii((np.arange(count) + 0.5) * h)
    area, second = np.pi * (outer**2 - inner**2), np.pi / 4 * (outer**4 - inner**4)
    shear = SHEAR_FACTOR * E / (2 * (1 + nu)) * area
    K, M = (np.zeros((2 * count + 2, 2 * count + 2)) for _ in range(2))
    for k in range(count):
        phi = 12 * E * second[k] / (shear[k] * h**2)
        at = slice(2 * k, 2 * k + 4)
        K[at, at] += E * second[k] / (h**3 * (1 + phi)) * np.array([
            [12, 6 * h, -12, 6 * h], [6 * h, (4 + phi) * h * h, -6 * h, (2 - phi) * h * h],
            [-12, -6 * h, 12, -6 * h], [6 * h, (2 - phi) * h * h, -6 * h, (4 + phi) * h * h],
        ])  # fmt: skip
        M[at, at] += 0.5 * rho * h * np.diag([area[k], second[k], area[k], second[k]])
    values = np.sort(np.linalg.eigvals(np.linalg.solve(M[2:, 2:], K[2:, 2:])).real)[:2]
    return np.asarray(np.sqrt(values) / (2 * np.pi))
