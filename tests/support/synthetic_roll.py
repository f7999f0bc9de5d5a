"""A synthetic roll for tests of results and figures: physics small enough to write down, nothing constant.

The history is an oscillator with a Jenkins element (spring and slider in series) on a shaken base, integrated by
central differences; the slip map slips near the root on the faces along the excitation direction.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from wroll_fem.results.dataset import annotate
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.sweeps import Chirp
from wroll_fem.signals.transmissibility import magnitude, transmissibility

MOTION = Chirp(5.0, 125.0, 175.0, 6.0, ramp_cycles=10.0)


def history(motion: Chirp = MOTION, f_n: float = 150.0, slip_limit: float = 5.0, per_cycle: int = 50) -> xr.Dataset:
    """1 kg, stiffness of `f_n` when stuck, a fifth of it through a slider of `slip_limit` (N per kg)."""
    dt = 1.0 / (per_cycle * f_n)
    time, base = motion.samples(dt)
    k = (2.0 * np.pi * f_n) ** 2
    spring, contact = 0.8 * k, 0.2 * k
    n = time.size
    u, friction, force = np.zeros(n), np.zeros(n), np.zeros(n)
    slider = work = 0.0
    for i in range(n - 1):
        trial = contact * (u[i] - slider)
        force[i] = max(-slip_limit, min(slip_limit, trial)) if slip_limit < np.inf else trial
        moved = (trial - force[i]) / contact
        slider += moved
        work += force[i] * moved
        friction[i] = work
        u[i + 1] = 2.0 * u[i] - (u[i - 1] if i else 0.0) + dt**2 * (-base[i] - spring * u[i] - force[i])
    force[-1], friction[-1] = force[-2], work
    v, a = np.gradient(u, dt), np.gradient(np.gradient(u, dt), dt)
    given = np.concatenate([[0.0], np.cumsum(0.5 * (base[1:] + base[:-1]) * -np.diff(u))])
    kinetic, strain, stored = 0.5 * v**2, 0.5 * spring * u**2, 0.5 * force**2 / contact
    series = {
        "base_acceleration": base,
        "tip_displacement": u,
        "tip_velocity": v,
        "tip_acceleration": a,
        "input_work": given,
        "kinetic_energy": kinetic,
        "strain_energy": strain,
        "contact_energy": stored,
        "friction_energy": friction,
        "numerical_dissipation": given - kinetic - strain - stored - friction,
        "newton_iterations": np.full(n, 2),
    }
    attrs = {
        "excitation_kind": "chirp",
        "f_start_hz": motion.f_start,
        "f_end_hz": motion.f_end,
        "rate_oct_per_min": motion.rate_oct_per_min,
    }
    return xr.Dataset({name: ("time", s) for name, s in series.items()}, coords={"time": time}, attrs=attrs)


def contact_points(n_theta: int = 24, n_z: int = 13, interfaces: int = 2, *, half: bool = False) -> xr.Dataset:
    """Per-point results; `half` keeps theta in [0, pi] with areas doubled off the plane, as with a symmetry plane."""
    radius, height = 0.04, 0.3
    angles = 2.0 * np.pi * np.arange(n_theta) / n_theta
    angles = np.where(angles > np.pi + 1e-9, angles - 2.0 * np.pi, angles)
    levels = height * np.linspace(0.0, 1.0, n_z) ** 1.4  # graded towards the root
    theta, z = (g.ravel() for g in np.meshgrid(angles, levels))
    ring = np.gradient(levels)
    ring[[0, -1]] = 0.5 * (levels[1] - levels[0]), 0.5 * (levels[-1] - levels[-2])
    ring *= height / ring.sum()
    area = np.repeat(ring, n_theta) * 2.0 * np.pi * radius / n_theta
    if half:
        keep = theta > -1e-9
        off = (theta > 1e-9) & (theta < np.pi - 1e-9)
        area = np.where(off, 2.0 * area, area)[keep]
        theta, z = theta[keep], z[keep]
    fields: dict[str, list[np.ndarray]] = {}
    for k in range(interfaces):
        axial = 3.0e-6 * 0.45**k * np.cos(theta) * np.exp(-z / 0.11)
        hoop = -0.8e-6 * 0.45**k * np.sin(theta) * np.exp(-z / 0.11)
        size = np.hypot(hoop, axial)
        slipped = size > 1.0e-6
        cumulative = np.where(slipped, 900.0 * (size - 1.0e-6), 0.0)
        for name, values in {
            "peak_slip_axial": axial,
            "peak_slip_hoop": hoop,
            "max_slip": size,
            "slipped": slipped,
            "cumulative_slip": cumulative,
            "pressure": 5.0e4 * (1.0 + 0.1 * np.cos(2 * theta)),
            "area": area,
        }.items():
            fields.setdefault(name, []).append(values)
    data = {name: (("interface", "point"), np.array(rows)) for name, rows in fields.items() if name != "area"}
    coords = {
        "interface": np.arange(interfaces),
        "theta_rad": ("point", theta),
        "z_m": ("point", z),
        "area": (("interface", "point"), np.array(fields["area"])),
    }
    return xr.Dataset(data, coords=coords)


def modes() -> xr.Dataset:
    kinds = np.array(["bending", "bending", "torsion", "ovalling-2", "ovalling-2", "axial", "ovalling-3", "bending"])
    frequency = np.array([148.3, 148.3, 402.7, 611.0, 611.2, 903.4, 1105.9, 1320.4])
    mass = np.zeros((8, 3))
    mass[0, 0] = mass[1, 1] = 0.71
    mass[5, 2], mass[7, 0] = 0.82, 0.13
    return xr.Dataset(
        {
            "mode_frequency": ("mode", frequency),
            "mode_kind": ("mode", kinds),
            "effective_mass_fraction": (("mode", "component"), mass),
        },
        coords={"mode": np.arange(1, 9), "component": ["x", "y", "z"]},
    )


def sweep(*, half: bool = False, **options: float) -> xr.Dataset:
    """Everything a sweep leaves behind, annotated."""
    run = history(**options)
    data = xr.merge([run, contact_points(half=half), transmissibility(run, MOTION)], combine_attrs="override")
    return estimated(annotate(data))


def estimated(dataset: xr.Dataset) -> xr.Dataset:
    """Results with the damping estimate that the analysis stores."""
    return dataset.assign_attrs(half_power(dataset["frequency"].values, magnitude(dataset).values).as_attrs())
