"""Kind `slip` of the laboratory: Dataset, summary and table of a measurement of slip."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from wroll_fem.lab.kinds import Figure, Kind
from wroll_fem.lab.result import LabResult
from wroll_fem.lab.slip_images.example import write_example
from wroll_fem.lab.slip_images.measurement import Measurement, measure
from wroll_fem.lab.slip_images.settings import SlipSettings
from wroll_fem.lab.slip_images.slip import Slip
from wroll_fem.lab.slip_images.spectrum import harmonics
from wroll_fem.lab.slip_images.table import MANDREL
from wroll_fem.progress import Progress


def evaluate(files: Sequence[Path], settings: SlipSettings, progress: Progress) -> LabResult:
    """Evaluate the frames of one recording."""
    found = measure(files, settings, progress)
    data = _targets(found, settings)
    if found.slip is not None:
        data = data.merge(_slip(found, found.slip, settings))
    data.attrs |= {
        "frequency_hz": settings.frequency,
        "frame_rate_hz": settings.frame_rate,
        "noise_source": "rest" if found.rest is not None else "beside the excitation",
    }
    if found.scale is not None:
        data.attrs |= {"pixel_length_m": found.scale.value, "pixel_length_error_m": found.scale.error}
    return LabResult(_summary(found, data), data, texts={"targets.csv": _table(found)})


def _targets(found: Measurement, settings: SlipSettings) -> xr.Dataset:
    """Motion of each target, and its noise."""
    paths, rate = found.paths, settings.frame_rate
    at = harmonics(paths.position, rate, np.array([settings.frequency]))[0]
    group, layer = (np.full(len(paths.diameter), -1) for _ in range(2))
    for member in found.members:
        group[member.target], layer[member.target] = member.group, member.layer
    columns: dict[str, Any] = {
        "target_position": (("time", "target", "axis"), paths.position),
        "target_amplitude": (("target", "axis"), np.abs(at)),
        "target_phase": (("target", "axis"), np.angle(at)),
        "target_diameter": ("target", paths.diameter),
        "target_seen": ("target", paths.seen.mean(axis=0)),
        "target_spectrum": (("frequency", "target", "axis"), np.abs(harmonics(paths.position, rate, found.lines))),
        "noise_spectrum": (("frequency", "target", "axis"), found.noise.spectrum),
        "noise_deviation": (("target", "axis"), found.noise.deviation),
        "noise_floor": ((), found.noise.floor),
        "slip_noise_floor": ((), found.noise.slip_floor),
        "first_frame": (("row", "column"), paths.frame),
    }
    if found.rest is not None:
        columns["rest_position"] = (("rest_time", "target", "axis"), found.rest)
    coords: dict[str, Any] = {
        "time": (settings.first_frame + np.arange(len(paths.position))) / rate,
        "target": 1 + np.arange(len(paths.diameter)),
        "axis": ["x", "y"],
        "frequency": found.lines,
        "target_group": ("target", group),
        "target_layer": ("target", layer),
    }
    if found.rest is not None:
        coords["rest_time"] = np.arange(len(found.rest)) / rate
    return xr.Dataset(columns, coords)


def _slip(found: Measurement, slip: Slip, settings: SlipSettings) -> xr.Dataset:
    """Slip of each pair: history, amplitude and phase, spectrum."""
    rate, value = settings.frame_rate, slip.value
    at = harmonics(value, rate, np.array([settings.frequency]))[0]
    dims = ("pair", "axis")
    columns: dict[str, Any] = {
        "slip_history": (("time", *dims), value),
        "slip_amplitude_px": (dims, np.abs(at)),
        "slip_phase": (dims, np.angle(at)),
        "slip_spectrum": (("frequency", *dims), np.abs(harmonics(value, rate, found.lines))),
        "slip_is_real": (dims, np.abs(at) >= 2.0 * found.noise.slip_floor),
    }
    if found.scale is not None:
        size = found.scale.value * np.abs(at)
        columns["slip_amplitude"] = (dims, size)
        columns["slip_error"] = (
            dims, np.hypot(found.scale.value * found.noise.slip_floor, size * found.scale.relative),
        )  # fmt: skip
    pairs = {
        "slip_group": ("pair", slip.group),
        "slip_layer": ("pair", slip.layer[:, 0]),
        "slip_relative_to": ("pair", slip.layer[:, 1]),
    }
    return xr.Dataset(columns, pairs)


def _summary(found: Measurement, data: xr.Dataset) -> dict[str, Any]:
    paths = found.paths
    summary: dict[str, Any] = {
        "targets": len(paths.diameter),
        "frames": len(paths.position),
        "lost_share": float(np.mean(~paths.seen)),
        "false_regions": len(paths.doubles),
        "motion_frequency_hz": found.best_frequency,
        "motion_amplitude_px": float(np.nanmax(data["target_amplitude"].values)),
        "noise_floor_px": found.noise.floor,
        "slip_noise_floor_px": found.noise.slip_floor,
        "noise_source": data.attrs["noise_source"],
    }
    if found.scale is not None:
        summary |= {
            "pixel_length_m": found.scale.value,
            "pixel_length_error_m": found.scale.error,
            "slip_noise_floor_m": found.scale.value * found.noise.slip_floor,
        }
    if found.slip is not None:
        summary |= _largest(data, data["slip_relative_to"].values == MANDREL, "mandrel_slip")
        summary |= _largest(data, data["slip_relative_to"].values != MANDREL, "layer_slip")
    return summary


def _largest(data: xr.Dataset, pairs: np.ndarray, name: str) -> dict[str, Any]:
    """Largest amplitude among some pairs along x or y, with its place; nothing if no amplitude is known."""
    size = data["slip_amplitude_px"].values[pairs]
    if not np.isfinite(size).any():
        return {}
    k, axis = np.unravel_index(int(np.nanargmax(size)), size.shape)
    chosen = data.isel(pair=np.flatnonzero(pairs)[k], axis=axis)
    found: dict[str, Any] = {
        f"{name}_px": float(size[k, axis]),
        f"{name}_is_real": bool(chosen["slip_is_real"]),
        f"{name}_group": int(chosen["slip_group"]),
        f"{name}_layer": int(chosen["slip_layer"]),
        f"{name}_axis": str(chosen["axis"].item()),
    }
    if "slip_amplitude" in data:
        found |= {f"{name}_m": float(chosen["slip_amplitude"]), f"{name}_error_m": float(chosen["slip_error"])}
    return found


def _table(found: Measurement) -> str:
    """Table of the targets, to be completed by group and layer."""
    given = {member.target: member for member in found.members}
    lines = ["target,group,layer,x_px,y_px,diameter_px,diameter_mm"]
    first = found.paths.first
    for k, ((x, y), size) in enumerate(zip(first.centroid, first.diameter, strict=True)):
        own = given.get(k)
        layer = "" if own is None else "mandrel" if own.layer == MANDREL else str(own.layer)
        known = "" if own is None or own.diameter is None else f"{1e3 * own.diameter:g}"
        group = "" if own is None else str(own.group)
        lines.append(f"{k + 1},{group},{layer},{x:.2f},{y:.2f},{size:.2f},{known}")
    return "\n".join(lines) + "\n"


_PLOTS = "wroll_fem.plotting.laboratory.slip_images"

KIND = Kind(
    settings=SlipSettings,
    evaluate=evaluate,
    files="One recording with a high-speed camera: a folder of PNG or TIFF images, a multi-page TIFF, or raw video.",
    figures={
        "targets": Figure(f"{_PLOTS}:plot_targets", "first_frame"),
        "slip_groups": Figure(f"{_PLOTS}:plot_slip_groups", "slip_amplitude_px"),
        "slip_history": Figure(f"{_PLOTS}:plot_slip_history", "slip_history"),
        "slip_spectrum": Figure(f"{_PLOTS}:plot_slip_spectrum", "slip_spectrum"),
        "noise": Figure(f"{_PLOTS}:plot_noise", "rest_position"),
    },
    variables={
        "time, target, axis": ("target_position",),
        "target, axis": ("target_amplitude", "target_phase", "noise_deviation"),
        "frequency, target, axis": ("target_spectrum", "noise_spectrum"),
        "time, pair, axis": ("slip_history",),
        "pair, axis": ("slip_amplitude_px", "slip_amplitude", "slip_error", "slip_phase", "slip_is_real"),
        "frequency, pair, axis": ("slip_spectrum",),
    },
    example=write_example,
    folders=True,
)
