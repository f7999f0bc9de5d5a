"""Mode of a coil with sticking wraps that `slip_damping` follows."""

from __future__ import annotations

import numpy as np
import scipy.sparse.linalg as spla

from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.system.system import System
from wroll_fem.numerics.linear import factorise
from wroll_fem.typing import FloatArray

FEW = 3
"""Number of inverse iterations before the shift. More would raise rounding errors along lower modes that the base does
not excite: bending modes lie far below those of torsion."""

NEAREST, EXCITED = 6, 0.05
"""Number of modes near the shift, and the smallest effective mass, relative to the total one, of the chosen one."""


def main_mode(system: System, path: LoadPath) -> FloatArray:
    """(n,) lowest mode that the base excites, with sticking wraps; unit modal mass. By inverse iteration."""
    mode, before = path.stuck(system.mass @ system.influence), np.inf
    while True:
        mode = path.stuck(system.mass @ mode)
        mode /= np.sqrt(mode @ (system.mass @ mode))
        square = float(mode @ (path.stiffness @ mode))
        if before - square <= 1e-13 * square:
            return mode
        before = square


def axisymmetric_mode(system: System, path: LoadPath) -> FloatArray:
    """(n,) lowest mode that a turning or axially moving base excites, with sticking wraps; unit modal mass.

    Modes of other circumferential wave numbers lie below it, so that the iteration has a shift near it.
    """
    inertia = system.mass @ system.influence
    start = path.stuck(inertia)
    for _ in range(FEW):
        start = path.stuck(system.mass @ start)
    shift = float(start @ (path.stiffness @ start)) / float(start @ (system.mass @ start))
    size = system.n_dofs
    shifted = factorise((path.stiffness - shift * system.mass).tocsc())
    values, modes = spla.eigsh(
        path.stiffness, min(NEAREST, size - 1), M=system.mass, sigma=shift, v0=start,
        OPinv=spla.LinearOperator((size, size), matvec=shifted.solve, dtype=float),
    )  # fmt: skip
    share = (modes.T @ inertia) ** 2 / float(system.influence @ inertia)
    chosen = min(np.flatnonzero(share >= min(EXCITED, share.max())), key=lambda k: values[k])
    mode = modes[:, chosen]
    return np.asarray(mode / np.sqrt(mode @ (system.mass @ mode)))
