"""Modes of a roll and their shear stress between the wraps of a solid coil: one data class for all finite elements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray


def needs_solid_coil() -> InputError:
    """Error for a case whose coil model has no interlayer shear stress."""
    return InputError(
        "the interlayer shear stress is computed for a solid coil only", key="coil.model",
        remedy="use coil.model: solid",
    )  # fmt: skip


@dataclass(frozen=True)
class ShearModes:
    """Modes of a mandrel with a solid coil, and the shear stress of each mode in the coil.

    The modes are normalised to unit modal mass; modal coordinates have the unit m sqrt(kg).

    Attributes
    ----------
    frequencies_hz
        (n_modes,) natural frequencies, Hz, ascending.
    participation
        (n_modes,) participation phi^T M i along the excitation, sqrt(kg); its square is the effective mass.
    tip
        (n_modes,) displacement of the tip along the excitation per modal coordinate, 1/sqrt(kg).
    points
        (n_points, 3) quadrature points of the whole coil: theta in (-pi, pi] from the x direction (rad), z above the
        base (m), r (m).
    volumes
        (n_points,) volume of each point, m^3; the sum is the volume of the coil.
    srz, srt
        (n_modes, n_points) axial and hoop component of the shear traction on cylindrical surfaces, Pa per modal
        coordinate.
    mass_total
        Mass of the roll, tip mass included, kg.
    kinds
        Kind of each mode ("bending", "torsion", ...) as in `wroll_fem.bodies.mode_shapes`; empty if unknown.
    probes
        Name -> (n_modes,) displacement at a named probe per modal coordinate, 1/sqrt(kg).

    Raises
    ------
    ValueError
        If the shapes of the arrays are inconsistent.
    """

    frequencies_hz: FloatArray
    participation: FloatArray
    tip: FloatArray
    points: FloatArray
    volumes: FloatArray
    srz: FloatArray
    srt: FloatArray
    mass_total: float
    kinds: tuple[str, ...] = ()
    probes: Mapping[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        modes, points = len(self.frequencies_hz), len(self.volumes)
        wanted = {
            "participation": (modes,), "tip": (modes,), "points": (points, 3), "srz": (modes, points),
            "srt": (modes, points),
        }  # fmt: skip
        for name, shape in wanted.items():
            if np.shape(getattr(self, name)) != shape:
                raise ValueError(f"{name} must have the shape {shape}, got {np.shape(getattr(self, name))}")
        for name, row in self.probes.items():
            if np.shape(row) != (modes,):
                raise ValueError(f"probe {name} must have the shape {(modes,)}, got {np.shape(row)}")
        if self.kinds and len(self.kinds) != modes:
            raise ValueError(f"kinds must have one entry for each of the {modes} modes, got {len(self.kinds)}")
