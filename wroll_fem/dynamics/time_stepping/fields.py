"""Result fields of the contact points with dimensions (interface, point), and their coordinates."""

from __future__ import annotations

import numpy as np
import xarray as xr

from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.stepper import Stepper
from wroll_fem.typing import FloatArray

SAME_PLACE = 1e-6
"""Largest difference between matching points of two interfaces: in angle, rad, and in z relative to the length of the
interfaces."""


def per_interface(system: System, values: np.ndarray) -> np.ndarray:
    """Values (n_points, ...) as an array (n_interfaces, largest number of points, ...).

    Interfaces with fewer points are padded with NaN, or with False for flags.
    """
    counts = [interface.n_points for interface in system.interfaces]
    if len(set(counts)) == 1:
        return values.reshape(len(counts), counts[0], *values.shape[1:])
    empty = False if values.dtype == bool else np.nan
    result = np.full((len(counts), max(counts), *values.shape[1:]), empty)
    for row, part in zip(result, np.split(values, np.cumsum(counts)[:-1]), strict=True):
        row[: len(part)] = part
    return result


def least_pressure(system: System, preload: ContactState, gap: FloatArray) -> FloatArray:
    """(n_points,) lowest contact pressure, Pa, from the largest normal relative displacements ``gap`` (n_points,), m.

    A point without normal stiffness keeps the pressure of the preload.
    """
    kn = system.laws.kn
    pressed = kn * np.maximum(-np.where(np.isfinite(gap), gap, 0.0), 0.0)
    return np.where((kn > 0.0) & np.isfinite(gap), np.minimum(pressed, preload.pressure), preload.pressure)


def interface_fields(
    system: System, preload: ContactState, stepper: Stepper | None = None, duration: float = 0.0
) -> xr.Dataset:
    """Fields of the contact points: preload pressure and traction; slip and opening recorded by a stepper.

    Coordinates `theta_rad` and `z_m` have the dimension `point` if all interfaces share them, otherwise the dimensions
    (`interface`, `point`). They and `radius` are omitted if the positions of the points of an interface are unknown.
    Interfaces that fill a body have the coordinate `r_m` too; it is NaN for others.
    ``duration`` is the time, s, that the stepper has run.
    """
    dims = ("interface", "point")
    traction = tangentials(preload.traction)
    data: dict[str, np.ndarray] = {
        "area": system.laws.area,
        "pressure": preload.pressure,
        "traction_hoop": traction[:, 0],
        "traction_axial": traction[:, 1],
    }
    if stepper is not None:
        slip, opening = stepper.slip, stepper.opening
        vector = slip.peak_vector.reshape(-1, 2)
        data |= {
            "cumulative_slip": slip.path,
            "max_slip": slip.peak,
            "slipped": slip.path > 0.0,
            "peak_slip_hoop": vector[:, 0],
            "peak_slip_axial": vector[:, 1],
            "open_time_fraction": opening.open_time / max(duration, float(np.finfo(float).tiny)),
            "least_pressure": least_pressure(system, preload, opening.gap),
        }
    dataset = xr.Dataset(
        {name: (dims, per_interface(system, values)) for name, values in data.items()},
        coords={
            "interface": np.arange(len(system.interfaces)),
            "interface_name": ("interface", [interface.name for interface in system.interfaces]),
        },
    )
    if len(system.pressures) == len(system.interfaces):
        dataset = dataset.assign(external_pressure=("interface", np.array(system.pressures)))
    points = np.vstack([interface.points for interface in system.interfaces])
    if not np.isfinite(points).all():
        return dataset
    radius = [float(np.mean(interface.points[:, 2])) for interface in system.interfaces]
    place = per_interface(system, points[:, :2])
    tolerance = SAME_PLACE * np.array([1.0, max(float(np.ptp(points[:, 1])), 1e-12)])
    shared = bool(np.all(np.abs(place - place[0]) <= tolerance))
    dataset = dataset.assign(radius=("interface", radius))
    for c, name in enumerate(("theta_rad", "z_m")):
        dataset = dataset.assign_coords({name: ("point", place[0, :, c]) if shared else (dims, place[..., c])})
    if any(interface.fills_body for interface in system.interfaces):
        depth = [np.where(interface.fills_body, interface.points[:, 2], np.nan) for interface in system.interfaces]
        dataset = dataset.assign_coords(r_m=(dims, per_interface(system, np.concatenate(depth))))
    return dataset
