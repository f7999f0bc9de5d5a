"""Preload: quasi-static load paths with friction, solved on the interfaces alone or on the full model."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from wroll_fem.dynamics.statics.condensed import CondensedStatic
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.full import solve_static
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import ConvergenceError
from wroll_fem.typing import FloatArray


def solve_load_path(
    system: System,
    forces: Sequence[FloatArray],
    state: ContactState | None = None,
    *,
    max_cuts: int = 6,
    progress: Callable[[int], None] | None = None,
    condensed: CondensedStatic | None = None,
) -> list[ContactState]:
    """Contact states on a quasi-static path with friction through a sequence of force vectors (n_dofs,), N.

    A step that does not converge is halved up to ``max_cuts`` times. The solver ``condensed`` works on the interfaces
    alone; without it the full model is solved.

    Returns
    -------
    list of ContactState
        One committed state per force vector.
    """
    current = ContactState.unloaded(system) if state is None else state
    previous = np.zeros(system.n_dofs) if state is None else equilibrium_force(system, current)
    path = []
    for i, target in enumerate(forces):
        done, step = 0.0, 1.0
        while done < 1.0:
            step = min(step, 1.0 - done)
            try:
                force = previous + (done + step) * (target - previous)
                current = _step(system, force, current, i + done + step, condensed)
            except ConvergenceError:
                step *= 0.5
                if step < 0.5**max_cuts:
                    raise
                continue
            done += step
        previous = target
        path.append(current)
        if progress is not None:
            progress(i + 1)
    return path


def _step(
    system: System, force: FloatArray, state: ContactState, load_factor: float, condensed: CondensedStatic | None
) -> ContactState:
    """Contact state in equilibrium with ``force``; the full model is solved if the condensed step fails."""
    if condensed is None:
        return solve_static(system, force, state, load_factor=load_factor)
    try:
        return condensed(force, state, load_factor=load_factor)
    except ConvergenceError:
        return solve_static(system, force, state, load_factor=load_factor)


def equilibrium_force(system: System, state: ContactState) -> FloatArray:
    """External force (n_dofs,) in N that holds ``state`` in equilibrium."""
    return system.stiffness @ state.displacement + system.contact_force(state.traction)


def solve_preload(
    system: System, *, steps: int = 10, progress: Callable[[int], None] | None = None, condensed: bool = True
) -> ContactState:
    """Contact state after the load "preload" is applied in equal steps with friction; motions start from this state.

    The initial stress of a wound roll (`System.pressed`) deforms nothing: its state needs no solution.

    Parameters
    ----------
    condensed
        Solve on the interfaces alone if the symmetry of the roll allows it; False solves the full model.
    """
    if system.initial_pressure is not None:
        return ContactState.pressed(system, system.initial_pressure)
    force = system.loads.get("preload", np.zeros(system.n_dofs))
    if not np.any(force):
        return ContactState.unloaded(system)
    scale = float(np.abs(force).sum() / max(system.laws.area.sum(), 1e-300)) / np.sqrt(3.0)
    solver = CondensedStatic.of(system, scale) if condensed else None
    path = [force * (i + 1) / steps for i in range(steps)]
    return solve_load_path(system, path, progress=progress, condensed=solver)[-1]
