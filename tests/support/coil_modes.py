"""Synthetic modes of a roll with a solid coil: shear stress of a cantilever in closed form."""

from __future__ import annotations

import numpy as np

from wroll_fem.analyses.transient_results import CoilShape
from wroll_fem.coiled_stiff.stress_modes import ShearModes

SHAPE = CoilShape(mandrel_radius=0.010, outer_radius=0.025, length=0.300)
MASS = 1.0


def coil_points(n_theta: int = 24, n_z: int = 12, n_r: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 3) of theta, z, r and volumes of equal cells; 0 and 90 degrees are hit."""
    theta = np.arange(1, n_theta + 1) * 2.0 * np.pi / n_theta - np.pi
    z = (np.arange(n_z) + 0.5) * SHAPE.length / n_z
    step = (SHAPE.outer_radius - SHAPE.mandrel_radius) / n_r
    r = SHAPE.mandrel_radius + (np.arange(n_r) + 0.5) * step
    points = np.stack([a.ravel() for a in np.meshgrid(theta, z, r, indexing="ij")], axis=1)
    volumes = points[:, 2] * step * (2.0 * np.pi / n_theta) * (SHAPE.length / n_z)
    return points, volumes


def beam(*, kinds: bool = True, decay_rz: float = 4e-3, decay_rt: float = 8e-3, ratio: float = 0.5) -> ShearModes:
    """Torsion at 60 Hz (not excited), bending at 100 and 600 Hz with srz ~ cos theta, srt ~ ratio sin theta.

    In bending mode k, with depth d = r - r_m and height z over L,
    srz = s_k (1 - z/L)^2 exp(-d/decay_rz) cos theta, srt = ratio s_k (1 - z/L) exp(-d/decay_rt) sin theta.
    """
    points, volumes = coil_points()
    theta, depth, up = points[:, 0], points[:, 2] - SHAPE.mandrel_radius, 1.0 - points[:, 1] / SHAPE.length
    srz = up**2 * np.exp(-depth / decay_rz) * np.cos(theta)
    srt = ratio * up * np.exp(-depth / decay_rt) * np.sin(theta)
    scale = np.array([0.0, 2e8, -6e8])
    return ShearModes(
        frequencies_hz=np.array([60.0, 100.0, 600.0]),
        participation=np.array([0.0, 0.8, 0.5]) * np.sqrt(MASS),
        tip=np.array([0.0, 2.0, -2.0]),
        points=points,
        volumes=volumes,
        srz=scale[:, None] * srz,
        srt=scale[:, None] * srt + np.array([[3e7], [0.0], [0.0]]) * up,
        mass_total=MASS,
        kinds=("torsion", "bending", "bending") if kinds else (),
    )
