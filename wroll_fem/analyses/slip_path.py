"""Quasi-static path of a coil whose wraps slide: growing loads with the shape of a mode, as far as they are wanted."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from wroll_fem.bodies.levels import levels as levels_of
from wroll_fem.contact.kernels import STICK
from wroll_fem.dynamics.statics.cycle_path import cycle_path
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import ModalPath, modal_path
from wroll_fem.errors import ConvergenceError
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.dynamics.statics.contact_state import ContactState
    from wroll_fem.progress import Progress

JUST_BELOW = 1.0 - 1e-6
"""First load, relative to that of the first slip: nothing slides yet."""

GROWTH, MOST_LEVELS = 1.18, 80
"""Ratio of successive loads; most of them."""


def followed_path(
    path: LoadPath,
    mode: FloatArray,
    reached: Callable[[ModalPath], bool],
    progress: Progress,
    *,
    radius: FloatArray | None = None,
    ends: Callable[[str], None] | None = None,
) -> ModalPath:
    """Path of growing loads with the shape of ``mode`` (n_dofs,), until ``reached`` or to the last load that is held.

    Parameters
    ----------
    reached
        Whether the path is long enough; called after every load.
    radius
        (n_points,) m. If it is given, friction alone carries the load from wrap to wrap, as in torsion and along the
        axis with a coil that is not clamped: the path ends where every point of a cylinder slides.
    ends
        Called with a sentence if the path ends early; by default a warning.

    Raises
    ------
    ConvergenceError
        If the first load has no equilibrium.
    """
    follow: Any = cycle_path if path.stress is not None else modal_path
    with progress.stage("slip path", MOST_LEVELS) as stage:
        levels = [JUST_BELOW]
        found: ModalPath = follow(path, mode, levels, keep=True)
        while len(levels) < MOST_LEVELS and not reached(found):
            try:
                further = found.joined(follow(path, mode, [GROWTH * levels[-1]], keep=True, after=found))
                sliding = None if radius is None else sliding_cylinder(radius, path.state)
                reason = "" if sliding is None else f"all wraps at r = {1e3 * sliding:.4g} mm slide (gross slip)"
            except ConvergenceError:
                reason = "no equilibrium was found, the friction between the wraps may not hold it"
            if reason:
                (ends or progress.warning)(f"under a load {GROWTH:g} times the last one of the path {reason}")
                break
            levels.append(GROWTH * levels[-1])
            found = further
            stage.update(len(levels), f"{len(path.vectors)} basis vectors")
        stage.update(MOST_LEVELS, f"{len(levels)} amplitudes, {len(path.vectors)} basis vectors")
    return found


def sliding_cylinder(radius: FloatArray, state: ContactState) -> float | None:
    """Smallest radius, m, at which no point sticks; None if some point sticks at every radius (n_points,)."""
    at, which = levels_of(radius)
    sticks = np.bincount(which, weights=state.status == STICK, minlength=len(at))
    return float(at[sticks == 0.0][0]) if (sticks == 0.0).any() else None
