"""Results of a coil whose wraps slide: response per level, dissipation, and slip in the coil."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
import xarray as xr
from scipy.constants import g as GRAVITY
from scipy.interpolate import PchipInterpolator

from wroll_fem.analyses.slip_structure import BetweenWraps
from wroll_fem.coiled_stiff.shear_points import ShearPoints
from wroll_fem.contact.kernels import SLIP
from wroll_fem.dynamics.statics.cycle_path import CyclePath
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import ModalPath
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import SlipDampingCase

STRONG = 0.5
"""Radial stress, relative to the pressure, that counts as a strong change of the pressure."""


def viscous_work(path: LoadPath, found: ModalPath, mode: FloatArray, damping_ratio: float) -> FloatArray:
    """(k,) energy that the dashpot of the mode dissipates in a cycle, J; ``damping_ratio`` is that without slip."""
    natural = np.sqrt(mode @ (path.stiffness @ mode))
    return np.asarray(2.0 * np.pi * damping_ratio * natural * found.frequency * found.amplitude**2)


def displacements(path: LoadPath, found: ModalPath) -> FloatArray:
    """(k, n) displacement of each state of a path from rest, m."""
    return np.array([state.displacement - path.start.displacement for state in found.states])


def base_acceleration(path: LoadPath, found: ModalPath, mode: FloatArray, damping_ratio: float) -> FloatArray:
    """(k,) base acceleration, m/s^2, whose work at resonance is the energy dissipated in a cycle of each amplitude."""
    dissipated = found.dissipation + viscous_work(path, found, mode, damping_ratio)
    moving = np.abs(displacements(path, found) @ (path.system.mass @ path.system.influence))
    return np.asarray(dissipated / (np.pi * moving))


def slip_dataset(
    system: System, points: ShearPoints, path: LoadPath, found: ModalPath, mode: FloatArray, case: SlipDampingCase
) -> xr.Dataset:
    """Dataset of frequency and damping versus `tip_amplitude`, response versus `amplitude_g`, and slip in the coil."""
    zeta, cycles = case.damping_ratio, isinstance(found, CyclePath)
    tip = np.abs(displacements(path, found) @ system.probes["tip"])
    base = base_acceleration(path, found, mode, zeta)
    viscous = viscous_work(path, found, mode, zeta)
    material = viscous / (2.0 * np.pi * (found.frequency * found.amplitude) ** 2)
    total = found.damping + material
    laws, start = system.laws, path.start
    limit = laws.mu * start.pressure
    slides = np.array([state.status == SLIP for state in found.states])
    levels = np.array(case.excitation.amplitude_g)
    natural = float(np.sqrt(mode @ (path.stiffness @ mode)))
    participation = float((mode @ (system.mass @ system.influence)) * (system.probes["tip"] @ mode))
    linear = abs(participation) * GRAVITY * levels / (2.0 * zeta * natural**2)
    stuck = GRAVITY * levels <= base[0]
    at = np.where(stuck, linear, _between(0.0, base, 0.0, tip)(GRAVITY * levels))
    frequency = _between(0.0, tip, natural, found.frequency)(at) / (2.0 * np.pi)
    damping = np.where(stuck, zeta, _between(0.0, tip, zeta, total)(at))
    on_path = {
        "slipping_volume_fraction_at_level": slides @ points.volumes / points.volumes.sum(),
        "friction_work_at_level": found.dissipation,
        "friction_work_rt_at_level": found.dissipation_by_component[:, 0],
        "friction_work_rz_at_level": found.dissipation_by_component[:, 1],
        "friction_damping_at_level": found.damping,
    }
    at_levels = {
        name: ("amplitude_g", np.where(stuck, 0.0, _between(0.0, tip, 0.0, values)(at)))
        for name, values in on_path.items()
    }
    onset = np.where(slides.any(axis=0), tip[slides.argmax(axis=0)], np.nan)
    most = int(np.argmax(total))
    by_point = found.dissipation_by_point / points.volumes[:, None]
    dataset = xr.Dataset(
        {
            "resonance_frequency": ("tip_amplitude", found.frequency / (2.0 * np.pi)),
            "modal_damping": ("tip_amplitude", total),
            "friction_modal_damping": ("tip_amplitude", found.damping),
            "material_modal_damping": ("tip_amplitude", material),
            "resonant_base_acceleration": ("tip_amplitude", base),
            "friction_work_per_cycle": ("tip_amplitude", found.dissipation),
            "friction_work_rt_per_cycle": ("tip_amplitude", found.dissipation_by_component[:, 0]),
            "friction_work_rz_per_cycle": ("tip_amplitude", found.dissipation_by_component[:, 1]),
            "material_damping_work_per_cycle": ("tip_amplitude", viscous),
            "slipping_volume_fraction": ("tip_amplitude", slides @ points.volumes / points.volumes.sum()),
            "tip_at_level": ("amplitude_g", at),
            "tip_at_level_without_slip": ("amplitude_g", linear),
            "frequency_at_level": ("amplitude_g", frequency),
            "damping_at_level": ("amplitude_g", damping),
            **at_levels,
            "theta_rad": ("point", points.points[:, 0]),
            "z_m": ("point", points.points[:, 1]),
            "r_m": ("point", points.points[:, 2]),
            "volume": ("point", points.volumes),
            "friction_capacity": ("point", limit),
            "tip_amplitude_at_slip": ("point", onset),
            "slip_work_density": ("point", by_point.sum(axis=1)),
            "slip_work_density_rt": ("point", by_point[:, 0]),
            "slip_work_density_rz": ("point", by_point[:, 1]),
        },
        coords={"tip_amplitude": tip, "amplitude_g": levels},
    )
    dataset.attrs |= {
        "f_stuck_hz": natural / (2.0 * np.pi),
        "f_largest_amplitude_hz": float(found.frequency[-1] / (2.0 * np.pi)),
        "zeta_max": float(total[most]),
        "tip_amplitude_at_zeta_max_m": float(tip[most]),
        "base_acceleration_at_zeta_max_m_s2": float(base[most]),
        "dofs": system.n_dofs,
        "interface_points": system.n_points,
        "reduced_coordinates": len(path.vectors),
        "reduction_error_estimate": float(found.error.max()),
        "branch_points": len(tip),
        "method": "quasi-static modal path, " + ("cycles" if cycles else "Masing's rule"),
        "followed_mode": case.excitation.mode,
        "mandrel_radius_m": 0.5 * case.geometry.mandrel_outer_diameter,
        "coil_outer_radius_m": 0.5 * case.geometry.mandrel_outer_diameter + case.coil.total_thickness,
        "length_m": case.geometry.length,
    }
    if isinstance(found, CyclePath):
        dataset.attrs["cycle_closure"] = float(found.closure.max())
    return dataset


def pressure_change(stress: sp.csr_matrix, points: ShearPoints, path: LoadPath, found: ModalPath) -> xr.Dataset:
    """Radial stress of the motion relative to the pressure between the wraps, where they slide, versus `tip_amplitude`.

    ``stress`` (n_points, n_dofs) are the rows of the radial stress, Pa/m.
    """
    change = np.abs((stress @ displacements(path, found).T).T) / path.start.pressure
    slides = np.array([state.status == SLIP for state in found.states])
    strong = (slides & (change > STRONG)) @ points.volumes
    return xr.Dataset(
        {
            "pressure_change_max": ("tip_amplitude", np.where(slides, change, 0.0).max(axis=1)),
            "pressure_change_volume_fraction": (
                "tip_amplitude", strong / np.maximum(slides @ points.volumes, np.finfo(float).tiny),
            ),
        }
    )  # fmt: skip


def with_moduli(dataset: xr.Dataset, between: BetweenWraps) -> xr.Dataset:
    """Dataset with the moduli between the wraps at its points, and the range of the shear modulus as attributes."""
    shear, radial = between.shear_modulus, between.radial_modulus
    dataset = dataset.assign(interlayer_shear_modulus=("point", shear), interlayer_radial_modulus=("point", radial))
    return dataset.assign_attrs(
        interlayer_shear_modulus_min_pa=float(shear.min()), interlayer_shear_modulus_max_pa=float(shear.max())
    )


def _between(x_0: float, x: FloatArray, y_0: float, y: FloatArray) -> PchipInterpolator:
    """Function through (x_0, y_0) and the points ``x``, ``y`` (k,); NaN beyond the last one."""
    return PchipInterpolator(np.append(x_0, x), np.append(y_0, y), extrapolate=False)
