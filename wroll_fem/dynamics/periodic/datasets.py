"""Datasets of response curves and backbones: work per cycle and its balance error, slip, opening, periodicity."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from wroll_fem.contact.point import normals
from wroll_fem.dynamics.aft import kernel
from wroll_fem.dynamics.joints.loops import loops
from wroll_fem.dynamics.periodic.harmonic_balance import CycleWork, HarmonicBalance
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.fields import interface_fields, least_pressure, per_interface
from wroll_fem.signals.tip import EXCITED_BY
from wroll_fem.typing import FloatArray

SLIP_SHARE = 1e-9
"""Slip path per period, relative to gamma*, below which slip counts as rounding error."""


LEAST_LOSS = 6e-4
"""Lower limit of the work per cycle by which energy errors are divided, relative to the peak kinetic energy. It is
about 4 pi zeta for the damping ratio zeta = 5e-5."""


class PeriodicMotion:
    """Work, slip and opening of one periodic motion (R, m) at ``frequency`` (rad/s).

    Attributes
    ----------
    work : work done during a period
    friction : (n,) friction work per area and period, J/m^2
    path : (n,) slip path per period, m
    peak : (n, 3) largest tangential displacement from the preload state, then its hoop and axial components, m
    slips : (n,) whether a contact point slips at any time of the period
    open_time : (n,) share of the period during which a contact point is open
    gap : (n,) largest normal relative displacement, m, negative at a point that stays pressed
    memory : change of the elastic slip during the last period computed, relative to gamma*
    damped : whether the structure has dashpots
    kinetic : amplitude of the kinetic energy of the motion relative to the base, sum of all harmonics, J
    """

    def __init__(self, balance: HarmonicBalance, coefficients: FloatArray, frequency: float):
        contact = balance.contact
        state = contact.evaluate(contact.motion(coefficients), frequency)
        n = contact.n
        self.work = balance.cycle_work(coefficients, frequency)
        self.friction, self.path, self.peak = np.zeros(n), np.zeros(n), np.zeros((n, 3))
        kernel.cycle_work(
            state.sampled.motion, state.hysteresis.slip, contact.reference.jump, contact.laws,
            self.friction, np.zeros(n), self.path, self.peak,
        )  # fmt: skip
        self.slips = (state.hysteresis.sliding & ~state.open).any(axis=1) & (
            self.path > SLIP_SHARE * contact.laws.gamma
        )
        self.open_time = state.open.mean(axis=1)
        self.gap = normals(contact.reference.jump) + normals(state.sampled.motion).max(axis=1)
        for name in ("friction", "path", "peak", "slips", "open_time", "gap"):
            setattr(self, name, contact.of_every_point(getattr(self, name)))
        self.damped = balance.model.damping is not None
        self.memory = state.periodicity_error
        self.kinetic = 0.5 * float(np.sum(balance.velocity(coefficients, frequency) ** 2))


def per_motion(motions: Sequence[PeriodicMotion], system: System, dim: str) -> dict[str, tuple]:
    """Dataset variables along dimension ``dim``: work per cycle, slip and opening.

    With dashpots they include the damping ratio that corresponds to their work, the work divided by 4 pi times the
    kinetic energy. With interfaces they include the fractions of contact points that slip and that open, and for each
    point the amplitude of the relative displacement.
    """
    works: Sequence[CycleWork] = [motion.work for motion in motions]
    data: dict[str, tuple] = {
        "input_work_per_cycle": (dim, np.array([w.input for w in works])),
        "friction_work_per_cycle": (dim, np.array([w.friction for w in works])),
        "modulation_work_per_cycle": (dim, np.array([w.modulation for w in works])),
        "material_damping_work_per_cycle": (dim, np.array([w.viscous for w in works])),
        "interface_work_per_cycle": (dim, np.array([w.interface for w in works])),
    }
    if any(motion.damped for motion in motions):
        ratios = [w.viscous / (4.0 * np.pi * m.kinetic) for w, m in zip(works, motions, strict=True)]
        data["material_modal_damping"] = (dim, np.array(ratios))
    if system.interfaces:
        slips = np.array([motion.slips for motion in motions])
        opens = np.array([motion.open_time > 0.0 for motion in motions])
        peaks = np.array([motion.peak[:, 0] for motion in motions])
        data |= {
            "slipping_fraction": (dim, slips.mean(axis=1)),
            "open_fraction": (dim, opens.mean(axis=1)),
            "memory_change": (dim, np.array([motion.memory for motion in motions])),
            "slip_amplitude": ((dim, "interface", "point"), np.array([per_interface(system, p) for p in peaks])),
        }
    return data


def at_one_motion(system: System, balance: HarmonicBalance, motion: PeriodicMotion) -> xr.Dataset:
    """Interface fields of one motion, named as in a sweep; slip path, friction work and open time are per period."""
    if not system.interfaces:
        return xr.Dataset()
    fields = interface_fields(system, balance.contact.preload)
    dims = ("interface", "point")
    for name, values in (
        ("cumulative_slip", motion.path),
        ("max_slip", motion.peak[:, 0]),
        ("slipped", motion.slips),
        ("peak_slip_hoop", motion.peak[:, 1]),
        ("peak_slip_axial", motion.peak[:, 2]),
        ("friction_work_density", motion.friction),
        ("open_time_fraction", motion.open_time),
        ("least_pressure", least_pressure(system, balance.contact.preload, motion.gap)),
    ):
        fields[name] = (dims, per_interface(system, values))
    return fields


def probe_response(system: System, curve: HarmonicCurve, dim: str) -> xr.Dataset:
    """Complex absolute acceleration of every probe divided by the base acceleration; dimensions probe and ``dim``.

    The base motion has no component in the direction of a probe normal to the excitation. The ratio of such a probe is
    zero at zero frequency.
    """
    model = curve.balance.model
    rows = np.vstack([model.tip, model.probes[: len(system.named_probes)]])
    rigid = np.array([system.rigid_motion(name) for name in system.probe_names])
    relative = np.array([curve.fundamental(row) for row in rows])
    ratio = rigid[:, None] - curve.frequencies**2 * relative / curve.balance.acceleration
    data = {"probe_transmissibility_real": ratio.real, "probe_transmissibility_imag": ratio.imag}
    return xr.Dataset(
        {name: (("probe", dim), values) for name, values in data.items()}, {"probe": list(system.probe_names)}
    )


def base_load_amplitudes(system: System, curve: HarmonicCurve, dim: str) -> dict[str, tuple]:
    """Amplitude of the fundamental of each load at the base (N, N m), along ``dim``."""
    rows = curve.balance.model.probes[len(system.named_probes) :]
    found: dict[str, tuple] = {}
    for row, (name, (_, rigid)) in zip(rows, system.base_loads.items(), strict=True):
        inertia = rigid * curve.balance.acceleration - curve.frequencies**2 * curve.fundamental(row)
        found[f"{name}_amplitude"] = (dim, np.abs(inertia))
    return found


def curve_dataset(system: System, curve: HarmonicCurve) -> xr.Dataset:
    """Dataset of a response curve along `frequency`, or along `branch_point` if the curve has folds.

    With folds, `frequency` is a variable. Fields per contact point are those of the motion with the highest
    transmissibility. `friction_modal_damping` is the friction work of a cycle divided by 4 pi times the kinetic energy,
    the damping ratio of the motion itself, whatever the shape of the curve. Attributes hold the size of the model, the
    number of iterations and the number of folds.
    """
    hertz = curve.frequencies / (2.0 * np.pi)
    rises = bool(np.all(np.diff(hertz) > 0.0))
    dim = "frequency" if rises else "branch_point"
    ratio = curve.transmissibility
    motions = [PeriodicMotion(curve.balance, q, w) for q, w in zip(curve.coefficients, curve.frequencies, strict=True)]
    tip = np.abs(curve.fundamental(curve.balance.model.tip))
    data: dict[str, tuple] = (
        {
            "transmissibility_real": (dim, ratio.real.copy()),
            "transmissibility_imag": (dim, ratio.imag.copy()),
            "tip_amplitude": (dim, tip),
            "stable": (dim, curve.stable),
            "newton_iterations": (dim, curve.iterations),
        }
        | per_motion(motions, system, dim)
        | base_load_amplitudes(system, curve, dim)
    )
    if system.interfaces:
        ratios = [m.work.friction / (4.0 * np.pi * max(m.kinetic, 1e-300)) for m in motions]
        data["friction_modal_damping"] = (dim, np.array(ratios))
    place = {dim: hertz} if rises else {dim: np.arange(len(hertz)), "frequency": (dim, hertz)}
    dataset = xr.Dataset(data, coords=place)
    if len(system.probe_names) > 1:
        dataset = xr.merge([dataset, probe_response(system, curve, dim)])
    peak = int(np.abs(ratio).argmax())
    dataset = xr.merge(
        [
            dataset,
            at_one_motion(system, curve.balance, motions[peak]),
            loops(system, curve.balance, curve.coefficients[peak], float(curve.frequencies[peak])),
        ]
    )
    sampling = curve.balance.contact.sampling
    if system.force is not None:
        dataset.attrs[EXCITED_BY] = "force"
    dataset.attrs |= {
        "folds": curve.folds,
        "branch_points": len(hertz),
        "harmonics": sampling.harmonics,
        "samples_per_period": sampling.samples,
        "newton_iterations_mean": float(np.mean(curve.iterations)),
        "reduced_coordinates": curve.balance.model.size,
        "dofs": system.n_dofs,
        "interface_points": system.n_points,
        "fields_at_frequency_hz": float(hertz[peak]),
        "memory_change": float(max((m.memory for m in motions), default=0.0)),
        "least_work_per_cycle_j": least_work(motions),
    }
    return dataset


def least_work(motions: Sequence[PeriodicMotion]) -> float:
    """Lower limit, J, of the work per cycle by which errors of the energy balance are divided.

    It is `LEAST_LOSS` times the largest kinetic energy of the motions. A roll that sticks dissipates no energy:
    relative to its input, the balance error would be rounding error alone.
    """
    return float(LEAST_LOSS * max((motion.kinetic for motion in motions), default=0.0))


def cycle_balance_error(dataset: xr.Dataset) -> float:
    """Error of the work balance per cycle, input = interface + viscous, relative to the largest input work of a cycle.

    The balance holds as exactly as the harmonic balance itself, at any number of samples.
    """
    return _relative_gap(dataset, ("interface_work_per_cycle", "material_damping_work_per_cycle"))


def quadrature_error(dataset: xr.Dataset) -> float:
    """Input work minus work of friction, modulation and dashpots per cycle, relative to the largest input work.

    It is the error of the friction work, which is computed as traction times slip from sample to sample:
    O(1 / samples^2).
    """
    parts = ("friction_work_per_cycle", "modulation_work_per_cycle", "material_damping_work_per_cycle")
    return _relative_gap(dataset, parts)


def _relative_gap(dataset: xr.Dataset, parts: Sequence[str]) -> float:
    given = dataset["input_work_per_cycle"].values
    gap = np.abs(given - np.sum([dataset[name].values for name in parts], axis=0))
    scale = max(float(np.abs(given).max()), float(dataset.attrs.get("least_work_per_cycle_j", 0.0)))
    return float(gap.max() / scale) if scale > 0.0 else 0.0
