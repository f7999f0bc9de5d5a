"""Shear stress of a solid coil in its modes: what the finite-element models hand over. FEM-free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.typing import FloatArray


@dataclass(frozen=True)
class ShearModes:
    """Modes of a mandrel with a solid coil, and the shear stress that each makes in the coil.

    The modes are normalised to unit modal mass; the modal coordinate has the unit m sqrt(kg).

    Attributes
    ----------
    frequencies_hz
        (n_modes,) natural frequencies, ascending, Hz.
    participation
        (n_modes,) phi^T M i along the excitation, sqrt(kg); its square is the effective mass.
    tip
        (n_modes,) displacement of the tip along the excitation per modal coordinate, 1/sqrt(kg).
    points
        (n_points, 3) theta in (-pi, pi] (rad, from the direction x), z (m, above the base), r (m): quadrature points
        of the coil around the whole circumference.
    volumes
        (n_points,) volume that each point stands for, m^3; the sum is the volume of the coil.
    srz, srt
        (n_modes, n_points) shear stress on the cylinder through the point, along the axis and along the hoop,
        Pa per modal coordinate.
    mass_total
        Mass of roll and tip, kg.
    kinds
        Name of each mode ("bending", "torsion", ...) as in `wroll_fem.structure.mode_shapes`; empty when unknown.
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

    def __post_init__(self) -> None:
        modes, points = len(self.frequencies_hz), len(self.volumes)
        wanted = {
            "participation": (modes,), "tip": (modes,), "points": (points, 3), "srz": (modes, points),
            "srt": (modes, points),
        }  # fmt: skip
        for name, shape in wanted.items():
            if np.shape(getattr(self, name)) != shape:
                raise ValueError(f"{name} has shape {np.shape(getattr(self, name))}, not {shape}")
        if self.kinds and len(self.kinds) != modes:
            raise ValueError(f"{len(self.kinds)} kinds for {modes} modes")
