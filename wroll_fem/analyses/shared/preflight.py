"""Checks before a run, by closed-form estimates; each returns warnings with remedies."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from wroll_fem.analyses.forecasts.closed_forms import (
    beam_frequency,
    buckling_pressure,
    interface_pressures,
    root_element_height,
    shear_lag_length,
)
from wroll_fem.analyses.forecasts.slip import slip_warnings
from wroll_fem.case.checks import FEWEST_STEPS_PER_CYCLE
from wroll_fem.case.structural import OnRoll, OnStructure, StructuralCase
from wroll_fem.signals.base_motion import sweep_rate_limit

if TYPE_CHECKING:
    from wroll_fem.case import HarmonicCase, RandomCase, ShockCase, SweepCase
    from wroll_fem.case.kinds import BucklingCase, ModalCase
    from wroll_fem.case.preload import Preload


HIGHEST_AT_BASE = 1.0
"""Height of the root element of a solid coil that rubs, divided by sqrt(R t) of the mandrel, above which a run warns.
Of configs/irosa_friction.yaml at 3.4 (0.9) the peak is 10 % (1 %) from that of a mesh with 24 x 5 elements along and
across, graded by 40."""

WANTED_DAMPING, LARGEST_NEEDED = 0.01, 0.04
"""Damping ratio for which a warning names the rate of a sweep, and the ratio that 90 % of the steady peak needs, above
which it warns."""

SHARE_OF_90 = 1.73
"""Sweep rate, relative to the limit of ISO 7626-2, at which a resonance with `WANTED_DAMPING` reaches 90 % of its
steady peak (`signals.attainment.rate_for_attainment`, which needs scipy)."""

USUAL_FREQUENCIES = (0.05, 1e5)
"""Usual range of the first bending frequency of a roll, Hz."""


def unusual_frequency(case: Any) -> list[str]:
    """Warn if the first bending frequency of a roll is far outside the usual range: some unit is probably wrong."""
    if not isinstance(case, OnRoll) or case.mandrel.base == "free":
        return []
    f, (low, high) = beam_frequency(case, bonded=False), USUAL_FREQUENCIES
    if low <= f <= high:
        return []
    return [
        f"the first bending frequency of the mandrel with its coil and tip mass is about {f:.2g} Hz, far outside the "
        f"usual range of rolls, {low:g} to {high:g} Hz; check the units of geometry, mandrel and coil"
    ]


def scheme_warnings(case: StructuralCase) -> list[str]:
    """Warn about integration schemes with considerable numerical dissipation."""
    scheme = case.integrator.scheme
    if scheme not in ("moderate_dissipation", "quasi_static"):
        return []
    return [
        f"integrator.scheme {scheme} dissipates a considerable part of the energy numerically; use hht with alpha "
        "-0.05, and compare numerical_dissipation_j with friction_energy_j"
    ]


def motion_remarks(case: ShockCase) -> list[str]:
    """Doubts about the base motion of a shock, such as a clipped record; scipy is imported here alone."""
    from wroll_fem.signals.motions import base_motion

    return [f"excitation: {text}" for text in getattr(base_motion(case.excitation), "remarks", ())]


def structure_warnings(case: StructuralCase) -> list[str]:
    """Warn if matrices from a file have no preload, a zero influence vector or a wrongly scaled tip probe.

    Raises
    ------
    InputError
        If the file is invalid.
    """
    if not isinstance(case, OnStructure):
        return []
    from wroll_fem.analyses.shared.preparation import read_structure

    system, state = read_structure(case)
    warnings = []
    pressed = system.loads.get("preload") if state is None else state.traction
    if system.laws.mu.any() and (pressed is None or not pressed.any()):
        warnings.append(
            "the interfaces have no preload, so there is no friction before they close; "
            "add load_preload or a preload state to the file"
        )
    if system.force is not None:
        excited = bool(system.force.any() or system.harmonic_forces)
        return warnings if excited else [*warnings, "force is zero: nothing excites the structure"]
    if not system.influence.any():
        warnings.append("influence is zero: the base motion does not act; write the rigid translation of every DOF")
    rigid = float(system.probes["tip"] @ system.influence)
    if system.influence.any() and abs(rigid - 1.0) > 1e-6:
        warnings.append(
            f"probe_tip moves {rigid:.6g} m when the base moves 1 m, but the transmissibility assumes 1 m; "
            "write the row of a displacement along the excitation"
        )
    return warnings


LOWERED_BY_OPENING = 0.7
"""Lowest resonance of a coil that rubs, relative to that of the beams without friction: a thick coil opens and rocks.
The flight rolls come down to 0.77."""


def _highest_resonance(case: OnRoll) -> tuple[float, str]:
    """Frequency, Hz, of the roll without slip, and the state of its layers."""
    stiff = case.coil.model in ("layers", "bonded", "solid")
    return beam_frequency(case, bonded=stiff), "sticking" if case.coil.per_wrap else "bonded"


def missed_resonance(case: SweepCase | HarmonicCase) -> list[str]:
    """Warn about a chirp whose band does not contain the expected resonance of the roll."""
    if not isinstance(case, OnRoll):
        return []
    low = beam_frequency(case, bonded=False) * (LOWERED_BY_OPENING if case.coil.rubs else 1.0)
    high, state = _highest_resonance(case)
    start, end = sorted((case.excitation.f_start, case.excitation.f_end))
    if start < 1.05 * high and end > 0.95 * low:
        return []
    lowest = "open" if case.coil.rubs else "frictionless"
    return [
        f"the chirp of {start:g} to {end:g} Hz misses the resonance, expected between {low:.0f} Hz ({lowest}) and "
        f"{high:.0f} Hz ({state}); set excitation.f_start and f_end around it"
    ]


def fast_sweeps(case: SweepCase) -> list[str]:
    """Warn about a sweep that lightly damped resonances cannot follow (`wroll_fem.signals.attainment`)."""
    if not isinstance(case, OnRoll):
        return []
    motion = case.excitation
    low, high = sorted((motion.f_start, motion.f_end))
    f_n = min(max(beam_frequency(case, bonded=False), low), high)
    rate = motion.rate_oct_per_min or 60.0 * (motion.rate_hz_per_s or 0.0) / (f_n * math.log(2.0))
    slow = SHARE_OF_90 * sweep_rate_limit(f_n, WANTED_DAMPING)
    needed = WANTED_DAMPING * math.sqrt(rate / slow)
    if needed <= LARGEST_NEEDED:
        return []
    return [
        f"the sweep passes a resonance at {f_n:.0f} Hz with {rate:.3g} oct/min: its peak reaches 90 % of the steady "
        f"one only with a damping ratio of {100 * needed:.1f} % or more; for {100 * WANTED_DAMPING:g} % sweep with "
        f"{slow:.2g} oct/min, or use harmonic"
    ]


def random_warnings(case: RandomCase) -> list[str]:
    """Warn about a PSD that misses the resonance, or that reaches above the frequencies that the time step resolves."""
    excitation, warnings = case.excitation, []
    low, high = excitation.psd.table.band
    highest = excitation.highest_frequency_hz
    if isinstance(case, OnRoll):
        first = beam_frequency(case, bonded=False) * (LOWERED_BY_OPENING if case.coil.rubs else 1.0)
        last, state = _highest_resonance(case)
        if not (low < 1.05 * last and high > 0.95 * first):
            lowest = "open" if case.coil.rubs else "frictionless"
            warnings.append(
                f"the PSD from {low:g} to {high:g} Hz misses the resonance, expected between {first:.0f} Hz ({lowest}) "
                f"and {last:.0f} Hz ({state}); extend excitation.psd"
            )
    steps = case.integrator.steps * highest / high
    if steps < FEWEST_STEPS_PER_CYCLE:
        warnings.append(
            f"the PSD reaches {high:g} Hz, but nearly all of its energy lies below {highest:.4g} Hz, which the time "
            f"step resolves: at {high:g} Hz it has {steps:.2g} steps per cycle, and responses there are wrong; end the "
            f"PSD at {highest:.4g} Hz, or set integrator.steps_per_cycle to "
            f"{math.ceil(FEWEST_STEPS_PER_CYCLE * high / highest)}"
        )
    return warnings


def _external_pressures(case: OnRoll, preload: Preload) -> list[float]:
    """External pressure on each layer, Pa; `wroll_fem.winding` is imported only for other preloads."""
    if preload.kind == "external_pressure":
        return preload.per_layer(case.coil.layers)
    from wroll_fem.winding.interface import external_pressures

    return external_pressures(case, preload, case.wound)


def unresolved_shear_lag(case: StructuralCase) -> list[str]:
    """Warn about a root element that is higher than the shear-lag length of the interfaces."""
    if not isinstance(case, OnRoll) or not case.coil.has_interfaces or case.preload is None or case.contact is None:
        return []
    pressures = interface_pressures(case)
    if case.mesh.file is not None or not any(pressures):
        return []
    lags = [shear_lag_length(case, law, p) for law, p in zip(case.interface_laws, pressures, strict=True)]
    lag, height = min(lags), root_element_height(case)
    if height <= lag:
        return []
    return [
        f"the mesh does not resolve the shear lag: the root element is {1e3 * height:.1f} mm high, the shear-lag "
        f"length at {pressures[lags.index(lag)] / 1e3:.3g} kPa is {1e3 * lag:.1f} mm; peak and f_n can be off by "
        f"a few per cent; raise mesh.axial (about {math.ceil(case.mesh.axial * height / lag)}) or mesh.grading"
    ]


def sticking_shear_lag(case: ModalCase | BucklingCase) -> list[str]:
    """`unresolved_shear_lag` of interfaces that stick in linear modes."""
    return unresolved_shear_lag(case) if isinstance(case, OnRoll) and case.modal.interface == "stuck" else []


def contact_warnings(case: StructuralCase) -> list[str]:
    """Warn about shear-lag resolution, friction law, buckling and low pressure of a roll with interfaces."""
    if not isinstance(case, OnRoll) or not case.coil.has_interfaces or case.preload is None:
        return []
    pressures = interface_pressures(case)
    if not any(pressures):
        return []
    warnings = unresolved_shear_lag(case)
    height = root_element_height(case)
    edge = math.sqrt(0.5 * case.geometry.mandrel_outer_diameter * case.geometry.mandrel_thickness)
    if case.coil.rubs and case.mesh.file is None and height > HIGHEST_AT_BASE * edge:
        warnings.append(
            f"the root element is {1e3 * height:.1f} mm high, but the wall bends within "
            f"sqrt(R t) = {1e3 * edge:.1f} mm of its round base: pressure and slip there are those of the mesh, "
            "and peak and f_n can be off by 10 %; raise mesh.grading or mesh.axial"
        )
    if case.coil.rubs and case.coil.base_width == 0.0:
        warnings.append(
            "coil.base_width 0 clamps a line, whose stiffness falls with the size of the elements: frequency and "
            "damping are those of this mesh; give a width, or leave it out (the wall thickness of the mandrel)"
        )
    if case.friction.law == "smoothed_coulomb":
        warnings.append(
            "contact.friction.law smoothed_coulomb has no friction at rest: the preload is frictionless, and below "
            "reference_speed the layers creep instead of sticking; use penalty_coulomb where sticking matters"
        )
    limit = buckling_pressure(case)
    if case.coil.rubs and pressures[0] > limit:
        warnings.append(
            f"the coil presses on the mandrel with about {pressures[0] / 1e3:.3g} kPa, {pressures[0] / limit:.3g} "
            f"times the linear hoop-buckling pressure of the tube alone, {limit / 1e3:.3g} kPa; the kinematics are "
            "linear and do not include buckling: check that the coil supports the tube, or use a thicker wall"
        )
    total = sum(_external_pressures(case, case.preload))
    if total > limit and not case.has_geometric_stiffness and not case.coil.rubs:
        warnings.append(
            f"the external pressure of {total / 1e3:.3g} kPa exceeds the linear hoop-buckling pressure of the tubes, "
            f"about {limit / 1e3:.0f} kPa: the kinematics are linear and do not include buckling; real winding "
            "pressure is balanced by web tension; preload.geometric_stiffness: true computes the buckling load"
        )
    if 0 < min(pressures) < 2e3:
        warnings.append(
            f"the estimated interface pressure of {min(pressures):.0f} Pa is low: large areas may open; "
            "watch for step cuts, and raise integrator.steps_per_cycle if the run stops"
        )
    return warnings


CHECKS: dict[str, tuple[Callable[[Any], list[str]], ...]] = {
    "sweep": (missed_resonance, fast_sweeps, contact_warnings, slip_warnings, structure_warnings, scheme_warnings),
    "dwell": (contact_warnings, structure_warnings, scheme_warnings),
    "random": (random_warnings, contact_warnings, structure_warnings, scheme_warnings),
    "shock": (motion_remarks, contact_warnings, structure_warnings, scheme_warnings),
    "harmonic": (missed_resonance, contact_warnings, slip_warnings, structure_warnings),
    "backbone": (contact_warnings, slip_warnings, structure_warnings),
    "random_response": (contact_warnings, slip_warnings, structure_warnings),
    "modal": (structure_warnings, sticking_shear_lag),
    "modal_transient": (),
    "slip_damping": (),
    "preload": (contact_warnings, structure_warnings),
    "buckling": (sticking_shear_lag,),
    "winding": (),
    "design_map": (),
    "two_dof": (),
    "sizing": (),
}
"""Analysis -> its checks. They are listed here, not in the modules of the analyses, so that `wroll validate` imports no
solver."""
