"""Slip of a solid coil under sinusoidal base motion, by modal superposition: response, shear stress, slip zone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.constants import g as GRAVITY

from wroll_fem.coiled_stiff.modal_response import Oscillators, run_to_steady_state, steady_transmissibility
from wroll_fem.coiled_stiff.slip_criterion import (
    ShearPerG,
    SlipZone,
    driven_mode,
    onset_levels,
    shear_per_g,
    slip_zone,
    slips,
)
from wroll_fem.coiled_stiff.stress_modes import ShearModes
from wroll_fem.errors import InputError
from wroll_fem.results.dataset import annotate
from wroll_fem.typing import FloatArray

FEWEST_MASS = 0.9
"""Effective mass of all computed modes along the excitation, divided by the total mass, below which the run warns."""


LEAST_MASS = 1e-6
"""Least effective mass of the driven mode, divided by the total mass; smaller values are round-off."""


class CoilShape(NamedTuple):
    """Dimensions of the coil: `mandrel_radius`, `outer_radius`, `length` in m."""

    mandrel_radius: float
    outer_radius: float
    length: float


def transient_dataset(
    modes: ShearModes,
    capacity_at: Callable[[FloatArray], FloatArray],
    shape: CoilShape,
    *,
    damping_ratio: float,
    frequency_hz: float | None,
    levels_g: list[float],
) -> xr.Dataset:
    """Compute the response from rest at the highest excitation level, shear stress at 1 g, and slip at every level.

    Parameters
    ----------
    modes
        Modes of the roll with the shear stress in its coil.
    capacity_at
        Friction capacity in Pa at radii (k,) in m.
    shape
        Extent of the coil.
    damping_ratio
        Damping ratio of every mode.
    frequency_hz
        Frequency of the base motion; None: natural frequency of the mode with the largest effective mass.
    levels_g
        Base acceleration (0-peak) divided by 9.80665 m/s^2, ascending.

    Returns
    -------
    xr.Dataset
        Over `mode`: frequency, effective mass. Over `time`, from rest to the first steady cycle at the top level:
        base, tip and shear where slip starts. Over `point`: shear at 1 g, capacity, onset. Over `amplitude_g`: slip
        zone.

    Raises
    ------
    InputError
        If no mode has effective mass along the excitation.
    """
    driven = driven_mode(modes)
    if modes.participation[driven] ** 2 < LEAST_MASS * modes.mass_total:
        raise InputError(
            f"none of {len(modes.frequencies_hz)} modes has effective mass along the excitation", key="modal.count",
            remedy="raise it",
        )  # fmt: skip
    frequency = float(modes.frequencies_hz[driven]) if frequency_hz is None else frequency_hz
    oscillators = Oscillators(modes.frequencies_hz, modes.participation, damping_ratio)
    shear = shear_per_g(modes, oscillators, frequency)
    capacity = np.asarray(capacity_at(modes.points[:, 2]))
    onset = onset_levels(shear.resultant, capacity)
    first = int(np.argmin(onset))
    zones = [slip_zone(modes, slips(g * shear.resultant, capacity), shape.mandrel_radius) for g in levels_g]

    amplitude = GRAVITY * levels_g[-1]
    run = run_to_steady_state(oscillators, modes.tip, frequency, amplitude)
    base = amplitude * np.sin(2.0 * np.pi * frequency * run.time)
    absolute = base + modes.tip @ run.state.acceleration
    history = np.hypot(modes.srz[:, first] @ run.state.coordinate, modes.srt[:, first] @ run.state.coordinate)
    data: dict[str, Any] = {
        **_mode_fields(modes),
        "base_acceleration": ("time", base),
        "tip_displacement": ("time", modes.tip @ run.state.coordinate),
        "tip_acceleration_absolute": ("time", absolute),
        "shear_resultant_history": ("time", history),
        "change_per_cycle": ("cycle", run.change),
        **_point_fields(modes, shear, capacity, onset),
        **_zone_fields(zones),
        **_capacity_fields(capacity_at, shape),
    }
    coords: dict[str, Any] = {
        "mode": np.arange(1, len(modes.frequencies_hz) + 1), "time": run.time,
        "cycle": np.arange(1, run.change.size + 1), "amplitude_g": levels_g,
    }  # fmt: skip
    if modes.probes:
        at_probes = np.array([modes.tip, *modes.probes.values()])
        data |= {
            "probe_displacement": (("probe", "time"), at_probes @ run.state.coordinate),
            "probe_acceleration": (("probe", "time"), at_probes @ run.state.acceleration),
            "mode_at_probe": (("mode", "probe"), at_probes.T),
        }
        coords["probe"] = ["tip", *modes.probes]
    dataset = xr.Dataset(data, coords=coords)
    dataset.attrs |= {
        "f_n_hz": float(modes.frequencies_hz[driven]),
        "driven_mode": driven + 1,
        "excitation_frequency_hz": frequency,
        "zeta": damping_ratio,
        "zeta_method": "given, the same for every mode",
        "participating_mass_fraction": float((np.asarray(modes.participation) ** 2).sum() / modes.mass_total),
        "mass_total_kg": modes.mass_total,
        "transmissibility": abs(steady_transmissibility(oscillators, modes.tip, frequency)),
        "transmissibility_last_cycle": float(np.abs(absolute[run.last_cycle]).max()) / amplitude,
        "steady_cycles": run.change.size,
        "mandrel_radius_m": shape.mandrel_radius,
        "coil_outer_radius_m": shape.outer_radius,
        "length_m": shape.length,
        "capacity_mandrel_pa": float(dataset["capacity_profile"][0]),
    }
    return annotate(dataset)


def _mode_fields(modes: ShearModes) -> dict[str, Any]:
    """Frequency, effective mass and, if available, kind of every mode."""
    mass = np.asarray(modes.participation) ** 2
    fields: dict[str, Any] = {
        "mode_frequency": ("mode", modes.frequencies_hz), "effective_mass_fraction": ("mode", mass / modes.mass_total),
    }  # fmt: skip
    return fields | ({"mode_kind": ("mode", np.array(modes.kinds))} if modes.kinds else {})


def _capacity_fields(capacity_at: Callable[[FloatArray], FloatArray], shape: CoilShape) -> dict[str, Any]:
    """Friction capacity versus radius, from the mandrel outwards."""
    radius = np.linspace(shape.mandrel_radius, shape.outer_radius, 301)
    return {
        "capacity_radius": ("capacity_point", radius),
        "capacity_profile": ("capacity_point", np.asarray(capacity_at(radius))),
    }


def _point_fields(modes: ShearModes, shear: ShearPerG, capacity: FloatArray, onset: FloatArray) -> dict[str, Any]:
    """Position, shear stress at 1 g, friction capacity and slip onset of every quadrature point."""
    return {
        "theta_rad": ("point", modes.points[:, 0]),
        "z_m": ("point", modes.points[:, 1]),
        "r_m": ("point", modes.points[:, 2]),
        "volume": ("point", modes.volumes),
        "shear_rz": ("point", np.abs(shear.srz)),
        "shear_rt": ("point", np.abs(shear.srt)),
        "shear_resultant": ("point", shear.resultant),
        "friction_capacity": ("point", capacity),
        "slip_onset": ("point", onset),
    }


def _zone_fields(zones: list[SlipZone]) -> dict[str, Any]:
    """Extent of the slip zone at every excitation level."""
    return {
        "slipping_volume_fraction": ("amplitude_g", [zone.volume_fraction for zone in zones]),
        "slip_zone_height": ("amplitude_g", [zone.height for zone in zones]),
        "slip_zone_depth": ("amplitude_g", [zone.depth for zone in zones]),
    }


def remarks(dataset: xr.Dataset) -> list[str]:
    """Warnings about the result, each with a remedy."""
    found = []
    share = float(dataset.attrs["participating_mass_fraction"])
    if share < FEWEST_MASS:
        found.append(
            f"{dataset.sizes['mode']} modes carry {100 * share:.0f} % of the mass along the excitation; "
            "the contribution of the other modes to the stresses is missing: raise modal.count until "
            f"{100 * FEWEST_MASS:.0f} % is reached"
        )
    f, top = float(dataset.attrs["excitation_frequency_hz"]), float(dataset["mode_frequency"].max())
    if f > 0.7 * top:
        found.append(
            f"the base moves at {f:.1f} Hz and the highest mode is at {top:.1f} Hz: raise modal.count until the "
            "highest mode lies well above the excitation"
        )
    return found
