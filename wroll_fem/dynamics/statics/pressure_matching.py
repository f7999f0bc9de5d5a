"""Preload with a prescribed mean pressure in every interface; Broyden's method finds the external pressures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wroll_fem.dynamics.statics.condensed import CondensedStatic
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.preload import solve_load_path
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import ConvergenceError
from wroll_fem.typing import FloatArray

TOLERANCE = 1e-4
"""Largest relative error of a mean interface pressure. The error of the initial linear estimate is a few per cent."""


def mean_pressures(system: System, state: ContactState) -> FloatArray:
    """(n_interfaces,) area-weighted mean of the contact pressure, Pa, inner interface first."""
    ends = np.cumsum([interface.n_points for interface in system.interfaces])[:-1]
    area, force = system.laws.area, system.laws.area * state.pressure
    return np.array([f.sum() / a.sum() for f, a in zip(np.split(force, ends), np.split(area, ends), strict=True)])


def match_interface_pressure(
    system: System,
    unit_loads: FloatArray,
    targets: FloatArray,
    split: FloatArray,
    *,
    steps: int,
    max_iterations: int = 12,
) -> System:
    """System whose preload has the target mean pressure in every interface.

    Parameters
    ----------
    unit_loads
        (n_interfaces, n_dofs) forces in N due to a pressure of 1 Pa on the outside of each layer.
    targets
        (n_interfaces,) prescribed mean pressures, Pa, above 0.
    split
        (n_interfaces, n_interfaces) estimate of the mean interface pressures per unit external pressure.
    steps
        Number of load steps of the preload.

    Raises
    ------
    ConvergenceError
        If no external pressures are found; its residual history holds the relative misfit of each attempt.

    Notes
    -----
    In each attempt the whole ramp is computed with friction from the unloaded roll, as in `preload.solve_preload`:
    because of friction, the pressures depend slightly on the load path.
    """
    solver = CondensedStatic.of(system, float(targets.max()))
    jacobian, pressures, history = split.copy(), np.linalg.solve(split, targets), []
    found = change = np.zeros(len(targets))
    for attempt in range(max_iterations):
        force = pressures @ unit_loads
        path = [force * (i + 1) / steps for i in range(steps)]
        before, found = found, mean_pressures(system, solve_load_path(system, path, condensed=solver)[-1])
        misfit = targets - found
        history.append(float(np.abs(misfit / targets).max()))
        if history[-1] <= TOLERANCE:
            return replace(system, loads={**system.loads, "preload": force}, pressures=tuple(pressures.tolist()))
        if attempt:
            jacobian += np.outer(found - before - jacobian @ change, change) / (change @ change)
        change = np.linalg.solve(jacobian, misfit)
        pressures = pressures + change
    raise ConvergenceError(
        "no external pressures give the interfaces the prescribed pressure", time_s=None,
        iterations=max_iterations, residual_history=history,
        advice="use fewer coil.layers or more pressure (winding tension): at low pressure the layers open",
    )  # fmt: skip
