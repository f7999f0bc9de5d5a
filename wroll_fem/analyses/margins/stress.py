"""Largest von Mises stress of mandrel and layers, from preload and vibration, and its margin against yield.

A time history is evaluated at its largest tip displacement, a response curve over the period of its highest motion.
Stress from winding that the external pressure of the preload does not contain (the tension of the web) is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wroll_fem.bodies.stress import ShellStress
from wroll_fem.case.structural import OnRoll
from wroll_fem.dynamics.periodic.aft import Sampling
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import Case
    from wroll_fem.progress import Progress

SAMPLES = 64
"""Least number of times per period at which the stress of a periodic motion is evaluated."""


def stress_of_displacement(
    system: System, state: ContactState, progress: Progress, displacement: FloatArray
) -> xr.Dataset:
    """Largest von Mises stress at one time; ``displacement`` (n_dofs,) is relative to the preload state, m."""
    shells = _shells(system, progress)
    total = state.displacement + displacement
    return _largest(shells, [shell.resultants(total)[:, None] for shell in shells])


def stress_of_curve(system: System, state: ContactState, progress: Progress, curve: HarmonicCurve) -> xr.Dataset:
    """Largest von Mises stress during the period of the motion with the highest transmissibility."""
    shells = _shells(system, progress)
    if not shells:
        return xr.Dataset()
    model = curve.balance.model
    peak = int(np.abs(curve.transmissibility).argmax())
    motion = curve.coefficients[peak]  # (R, m)
    harmonics = (len(motion) - 1) // 2
    series = Sampling(harmonics, max(SAMPLES, 4 * harmonics + 4)).values @ motion  # (samples, m)
    shapes = model.condensation.displacement(model.vectors)
    found = [shell.resultants(shapes) @ series.T + shell.resultants(state.displacement)[:, None] for shell in shells]
    return _largest(shells, found)


def _shells(system: System, progress: Progress) -> tuple[ShellStress, ...]:
    if system.shell_stress is None:
        return ()
    with progress.stage("stress", 1) as stage:
        found = system.shells
        stage.update(1)
    return found


def _largest(shells: tuple[ShellStress, ...], resultants: list[FloatArray]) -> xr.Dataset:
    """Largest stress of each shell and its height; ``resultants`` (6 k, n) of each shell at n times."""
    if not shells:
        return xr.Dataset()
    stress, height = [], []
    for shell, found in zip(shells, resultants, strict=True):
        at_points = shell.von_mises(found).max(axis=(1, 2))
        most = int(at_points.argmax())
        stress.append(float(at_points[most]))
        height.append(float(shell.points[most, 2]))
    names = [shell.name for shell in shells]
    return xr.Dataset(
        {"von_mises_max": ("shell", np.array(stress)), "von_mises_height": ("shell", np.array(height))},
        coords={"shell": names},
    )


def yield_stresses(case: Case, shells: list[str]) -> list[float]:
    """Yield stress of each shell, Pa; nan where the case gives none."""
    if not isinstance(case, OnRoll):
        return [np.nan] * len(shells)
    given = {True: case.mandrel.yield_stress, False: case.coil.yield_stress}
    return [value if (value := given[name == "mandrel"]) is not None else np.nan for name in shells]


def with_yield(dataset: xr.Dataset, case: Case) -> xr.Dataset:
    """Dataset with the yield stress of each shell, if it has stresses and the case gives a yield stress."""
    if "von_mises_max" not in dataset:
        return dataset
    limits = yield_stresses(case, [str(name) for name in dataset["shell"].values])
    return dataset if np.isnan(limits).all() else dataset.assign(yield_stress=("shell", np.array(limits)))


def summary(dataset: xr.Dataset) -> dict[str, Any]:
    """Largest von Mises stress of mandrel and layers, and their margins; empty without stresses."""
    if "von_mises_max" not in dataset:
        return {}
    found: dict[str, Any] = {"von_mises_max_pa": dataset["von_mises_max"].values.tolist()}
    if "yield_stress" in dataset:
        margin = dataset["yield_stress"].values / dataset["von_mises_max"].values - 1.0
        found["yield_margin"] = [None if np.isnan(value) else float(value) for value in margin]
    return found


def stress_doubts(dataset: xr.Dataset, entries: Mapping[str, Any], case: Case) -> list[str]:
    """Warning for each shell whose stress exceeds its yield stress."""
    if "yield_stress" not in dataset:
        return []
    texts = []
    for shell in dataset["shell"].values:
        one = dataset.sel(shell=shell)
        stress, limit = float(one["von_mises_max"]), float(one["yield_stress"])
        if stress > limit:
            texts.append(
                f"{shell} yields: its von Mises stress reaches {stress / 1e6:.3g} MPa at z = "
                f"{1e3 * float(one['von_mises_height']):.3g} mm, above the yield stress of {limit / 1e6:.3g} MPa; "
                "the results are those of a linear material"
            )
    return texts
