"""Largest stress of mandrel and layers, from preload and vibration, and its margin against yield.

Isotropic walls have a von Mises stress; the plies of a laminate have stresses along and across their fibres.

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
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import Case
    from wroll_fem.progress import Progress

COMPONENTS = ("1", "2", "12")
"""Components of the stress of a ply: along its fibres, across them, and shear."""

PHASES = 8
"""Times per half period at which the stress of a fundamental is evaluated; its components are nearly in phase."""

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
    series = Sampling(harmonics, max(SAMPLES, 4 * harmonics + 4)).values  # (samples, R)
    shapes = model.condensation.displacement(model.vectors @ motion.T)
    found = [shell.resultants(shapes) @ series.T + shell.resultants(state.displacement)[:, None] for shell in shells]
    return _largest(shells, found)


def stress_of_backbone(system: System, progress: Progress, curve: BackboneCurve) -> xr.Dataset:
    """Largest von Mises stress of the fundamental of each motion of a backbone, without the preload; 0-peak.

    Walls without a von Mises stress (orthotropic plies) have nan; without any such wall the result is empty.
    """
    shells = _shells(system, progress)
    model = curve.balance.model
    if not shells:
        return xr.Dataset()
    shapes = model.condensation.displacement(model.vectors)
    angle = np.linspace(0.0, np.pi, PHASES, endpoint=False)
    names, rows = [], []
    for shell in shells:
        unit = shell.resultants(shapes)
        found = []
        for cosine, sine in curve.coefficients[:, 1:3]:
            waves = np.column_stack([unit @ cosine, unit @ sine]) @ np.array([np.cos(angle), np.sin(angle)])
            found.append(np.nan_to_num(shell.von_mises(waves), nan=-1.0).max())
        if min(found) >= 0.0:
            names.append(shell.name)
            rows.append(found)
    if not names:
        return xr.Dataset()
    return xr.Dataset({"vibration_von_mises": (("tip_amplitude", "shell"), np.array(rows).T)}, {"shell": names})


def _shells(system: System, progress: Progress) -> tuple[ShellStress, ...]:
    if system.shell_stress is None:
        return ()
    with progress.stage("stress", 1) as stage:
        found = system.shells
        stage.update(1)
    return found


def _largest(shells: tuple[ShellStress, ...], resultants: list[FloatArray]) -> xr.Dataset:
    """Largest stresses of each shell; ``resultants`` (6 k, n) of each shell at n times."""
    if not shells:
        return xr.Dataset()
    stress, height = [], []
    for shell, found in zip(shells, resultants, strict=True):
        at_points = np.nan_to_num(shell.von_mises(found), nan=-1.0).max(axis=(1, 2))
        most = int(at_points.argmax())
        known = at_points[most] >= 0.0
        stress.append(float(at_points[most]) if known else np.nan)
        height.append(float(shell.points[most, 2]) if known else np.nan)
    fields = {"von_mises_max": ("shell", np.array(stress)), "von_mises_height": ("shell", np.array(height))}
    return xr.Dataset(fields, coords={"shell": [shell.name for shell in shells]}).merge(_of_plies(shells, resultants))


def _of_plies(shells: tuple[ShellStress, ...], resultants: list[FloatArray]) -> xr.Dataset:
    """Stress of largest magnitude along 1, along 2 and in shear 12 of every ply, with its sign; empty without plies."""
    found = [_extremes(shell.plies(part)) for shell, part in zip(shells, resultants, strict=True)]
    count = max(len(plies) for plies in found)
    if not count:
        return xr.Dataset()
    stress = np.full((len(shells), count, len(COMPONENTS)), np.nan)
    for own, plies in zip(stress, found, strict=True):
        own[: len(plies)] = plies
    return xr.Dataset(
        {"ply_stress_max": (("shell", "ply", "ply_component"), stress)},
        coords={"shell": [s.name for s in shells], "ply": np.arange(1, count + 1), "ply_component": list(COMPONENTS)},
    )


def _extremes(stress: FloatArray | None) -> FloatArray:
    """(n_plies, 3) values of largest magnitude of ply stresses (k, n_plies, 2, 3, n); (0, 3) without plies."""
    if stress is None:
        return np.empty((0, len(COMPONENTS)))
    flat = np.moveaxis(stress, (1, 3), (0, 1)).reshape(stress.shape[1], len(COMPONENTS), -1)
    return np.take_along_axis(flat, np.abs(flat).argmax(axis=2)[:, :, None], axis=2)[:, :, 0]


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
    found: dict[str, Any] = {}
    if not np.isnan(dataset["von_mises_max"].values).all():
        found["von_mises_max_pa"] = _or_none(dataset["von_mises_max"].values)
    if "ply_stress_max" in dataset:
        for component in COMPONENTS:
            plies = dataset["ply_stress_max"].sel(ply_component=component).values
            found[f"ply_stress_{component}_max_pa"] = _or_none(np.array([_largest_of(shell) for shell in plies]))
    if "yield_stress" in dataset:
        found["yield_margin"] = _or_none(dataset["yield_stress"].values / dataset["von_mises_max"].values - 1.0)
    return found


def _largest_of(plies: FloatArray) -> float:
    """Value of largest magnitude, with its sign; nan if there is none."""
    known = plies[~np.isnan(plies)]
    return float(known[np.abs(known).argmax()]) if len(known) else np.nan


def _or_none(values: FloatArray) -> list[float | None]:
    return [None if np.isnan(value) else float(value) for value in values]


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
