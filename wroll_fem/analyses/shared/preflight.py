"""What can be said before a run: size, time and warnings, from closed forms alone."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wroll_fem.case import Case
    from wroll_fem.case.material import IsotropicMaterial, OrthotropicMaterial

SECONDS_PER_UNIT = {"reduced": 4.0e-7, "condensed": 3.0e-8, "full": 1.2e-5}
"""Time per step: `reduced` x points, `condensed` x points x modes per harmonic, `full` x DOFs; one 2.5 GHz core."""

SECONDS_PER_EIGENPROBLEM = 2.2e-10
"""Time to find the modes of one harmonic's block over the cube of its size, on the same core."""

SECONDS_PER_SOLID_DOF = 3.5e-4
"""Time to assemble a solid coil and find ten modes over its DOFs, on the same core."""


def beam_frequency(case: Case, *, bonded: bool, added_mass: bool = True) -> float:
    """First bending frequency in Hz of the tube(s) as a cantilever with tip mass (Rayleigh, with shear flexibility).

    The end mass takes 33/140 of the beam's mass. Good to some per cent: for warnings, not for results.
    """
    g, m, coil = case.geometry, case.mandrel, case.coil
    radius = 0.5 * g.mandrel_outer_diameter - 0.5 * g.mandrel_thickness
    tubes: list[tuple[IsotropicMaterial | OrthotropicMaterial, float, float, bool]] = [
        (m.material, radius, g.mandrel_thickness, True)
    ]
    if coil.model != "none":
        radius = 0.5 * g.mandrel_outer_diameter + 0.5 * coil.total_thickness
        stiff = bonded and coil.model != "nonstructural_mass"
        tubes.append((coil.material, radius, coil.total_thickness, stiff))
    bending = shear = mass = 0.0
    for material, radius, thickness, stiff in tubes:
        area = 2 * math.pi * radius * thickness
        if stiff or material is m.material:
            E, G = _axial_moduli(material)
            bending += E * math.pi * radius**3 * thickness
            shear += G * area / 2
        if added_mass or material is m.material:
            mass += material.rho * area * g.length
    compliance = g.length**3 / (3 * bending) + g.length / shear
    return math.sqrt(1 / (compliance * (m.tip_mass + 33 / 140 * mass))) / (2 * math.pi)


def _axial_moduli(material: IsotropicMaterial | OrthotropicMaterial) -> tuple[float, float]:
    """Young's modulus along the axis and in-plane shear modulus, Pa."""
    if material.kind == "cylindrical_orthotropic":
        return material.E_z, material.G_z_theta
    return material.E, material.E / (2 * (1 + material.nu))


def buckling_pressure(case: Case) -> float:
    """Linear hoop-buckling pressure in Pa of mandrel plus layers, each a short tube with round ends.

    Windenburg and Trilling's formula, p = 2.42 E (t/D)^2.5 / ((1 - nu^2)^0.75 (L/D - 0.45 (t/D)^0.5)), summed.
    """
    g, coil = case.geometry, case.coil
    tubes = [(case.mandrel.material, g.mandrel_outer_diameter - g.mandrel_thickness, g.mandrel_thickness, 1)]
    if coil.bending:
        tubes.append(
            (coil.layer_material, g.mandrel_outer_diameter + coil.total_thickness, coil.layer_thickness, coil.layers)
        )
    total = 0.0
    for material, diameter, thickness, count in tubes:
        slender = thickness / diameter
        length = g.length / diameter - 0.45 * math.sqrt(slender)
        if length > 0:
            total += count * 2.42 * material.E * slender**2.5 / ((1 - material.nu**2) ** 0.75 * length)
    return total


def interface_pressures(case: Case) -> list[float]:
    """Estimated pressure in Pa at each interface, inner first: rings that move alike share the load by E t / R^2.

    Thin concentric rings without end effects; an interface that this would pull apart has none.
    """
    g, coil = case.geometry, case.coil
    if case.preload.kind == "winding_tension":
        from wroll_fem.winding.interface import target_pressures

        return target_pressures(case).tolist()
    pressures = case.preload.per_layer(coil.layers)
    core = case.mandrel.material.E * g.mandrel_thickness / (0.5 * g.mandrel_outer_diameter) ** 2
    ring = coil.layer_material.E * coil.layer_thickness / (0.5 * g.mandrel_outer_diameter) ** 2
    shift = sum(pressures) / (core + coil.layers * ring)
    return [max(0.0, sum(pressures[k:]) - (coil.layers - k) * ring * shift) for k in range(coil.layers)]


def shear_lag_length(case: Case, pressure: float) -> float:
    """Length in m over which friction hands axial force from layer to mandrel, sqrt((E t)_series / k_t)."""
    mandrel = case.mandrel.material.E * case.geometry.mandrel_thickness
    layer = case.coil.layer_material.E * case.coil.layer_thickness
    friction = case.contact.friction
    if friction.law == "smoothed_coulomb":  # sticks nowhere
        return math.inf
    stick = friction.mu * pressure / friction.elastic_slip
    return math.sqrt(mandrel * layer / (mandrel + layer) / stick) if stick > 0 else math.inf


def root_element_height(case: Case) -> float:
    """Height in m of the element row at the base of the generated mesh."""
    n, grading = case.mesh.axial, case.mesh.grading
    if n < 2 or grading == 1:
        return case.geometry.length / n
    ratio = grading ** (1 / (n - 1))
    return case.geometry.length * (ratio - 1) / (ratio**n - 1)


def case_warnings(case: Case) -> list[str]:
    """What a user should know before the run, each with what to change; reads the file of `structure`.

    Raises
    ------
    InputError
        When that file is wrong.
    """
    if case.structure is not None:
        return _scheme_warnings(case) + _structure_warnings(case)
    if case.analysis in ("winding", "two_dof"):  # what is doubtful there is known after the run, a moment later
        return []
    warnings = []
    contact = case.coil.model == "layers" and case.analysis in ("sweep", "dwell", "harmonic", "backbone", "preload")
    if case.analysis in ("sweep", "harmonic"):
        warnings += _missed_resonance(case)
    if contact and any(interface_pressures(case)):
        warnings += _contact_warnings(case)
    return warnings + _scheme_warnings(case)


def _scheme_warnings(case: Case) -> list[str]:
    scheme = case.integrator.scheme
    if case.analysis not in ("sweep", "dwell") or scheme not in ("moderate_dissipation", "quasi_static"):
        return []
    return [
        f"integrator.scheme {scheme} takes a visible part of the energy itself; use hht with alpha "
        "-0.05, and read numerical_dissipation_j next to friction_energy_j"
    ]


def _structure_warnings(case: Case) -> list[str]:
    """What is doubtful in a file of matrices."""
    from wroll_fem.analyses.shared.preparation import read_structure

    system, state = read_structure(case)
    warnings = []
    pressed = system.loads.get("preload") if state is None else state.traction
    if system.interfaces and (pressed is None or not pressed.any()):
        warnings.append(
            "nothing presses the interfaces together, so there is no friction before they close; "
            "add load_preload or a preload state to the file"
        )
    if not system.influence.any():
        warnings.append("influence is zero: the base motion does not act; write the rigid translation of every DOF")
    rigid = float(system.probes["tip"] @ system.influence)
    if system.influence.any() and abs(rigid - 1.0) > 1e-6:
        warnings.append(
            f"probe_tip moves {rigid:.6g} m when the base moves 1 m; the transmissibility adds the base motion once: "
            "write the row of a displacement along the excitation"
        )
    return warnings


def _missed_resonance(case: Case) -> list[str]:
    low = beam_frequency(case, bonded=False)
    high = beam_frequency(case, bonded=case.coil.model in ("layers", "bonded", "solid"))
    start, end = case.excitation.f_start, case.excitation.f_end  # type: ignore[union-attr]
    if start < 1.05 * high and end > 0.95 * low:
        return []
    return [
        f"the chirp of {start:g} to {end:g} Hz misses the resonance, expected between {low:.0f} Hz (frictionless) and "
        f"{high:.0f} Hz (bonded); set excitation.f_start and f_end around it"
    ]


def _contact_warnings(case: Case) -> list[str]:
    warnings = []
    pressures = interface_pressures(case)
    lag, height = shear_lag_length(case, max(pressures)), root_element_height(case)
    if case.mesh.file is None and height > lag:
        need = math.ceil(case.mesh.axial * height / lag)
        warnings.append(
            f"the mesh does not resolve the shear lag: the root element is {1e3 * height:.1f} mm high, the shear-lag "
            f"length at {max(pressures) / 1e3:.3g} kPa is {1e3 * lag:.1f} mm; peak and f_n can be off by "
            f"some per cent; raise mesh.axial (about {need}) or mesh.grading"
        )
    if case.contact.friction.law == "smoothed_coulomb":
        warnings.append(
            "contact.friction.law smoothed_coulomb holds nothing at rest: the preload is frictionless, and below "
            "reference_speed the layers creep instead of sticking; use penalty_coulomb where sticking matters"
        )
    from wroll_fem.winding.interface import external_pressures

    total, limit = sum(external_pressures(case)), buckling_pressure(case)
    if total > limit:
        warnings.append(
            f"the external pressure of {total / 1e3:.3g} kPa exceeds the linear hoop-buckling pressure of the tubes, "
            f"about {limit / 1e3:.0f} kPa: kinematics are linear and do not see it; real winding pressure is balanced "
            "by web tension"
        )
    if 0 < min(pressures) < 2e3:
        warnings.append(
            f"the estimated interface pressure of {min(pressures):.0f} Pa is low: surfaces may open widely; "
            "watch for step cuts, and raise integrator.steps_per_cycle if the run stops"
        )
    return warnings


def estimate(case: Case) -> dict[str, Any]:
    """Size of the job and a rough time, for ``--dry-run``.

    Returns
    -------
    dict
        dofs, interface_points, steps, time_step_s, duration_s, and for a roll estimated_seconds (one core, set-up
        included).
    """
    if case.two_dof is not None:
        from wroll_fem.analyses.two_dof import estimate_two_dof

        return estimate_two_dof(case.two_dof)
    if case.winding is not None and case.analysis == "winding":
        cells, wraps = case.winding.cells, case.winding.wraps
        return {"wraps": wraps, "cells": cells, "estimated_seconds": 0.5 + 8e-9 * (0.6 * cells**2 + 0.5 * wraps**2)}
    if case.structure is not None:
        from wroll_fem.dynamics.system.io import system_size

        dofs, points = system_size(case.structure.file)
        return {"dofs": dofs, "interface_points": points} | _time_steps(case)
    if case.mesh.discretisation == "fourier":
        return _harmonics(case)
    shells = 1 + (case.coil.layers if case.coil.model in ("layers", "bonded") else 0)
    half = case.solver.symmetry and case.excitation.direction == "x" and case.solver.method != "full"
    half = half and not case.analysis.startswith("modal")  # all modes are wanted
    around, along = case.mesh.circumferential, case.mesh.axial
    columns = around // 2 + 1 if half else around
    nodes = (around + 1 if half else 2 * around) * (2 * along + 1)
    solid = case.coil.model == "solid"
    result: dict[str, Any] = {
        "dofs": 6 * nodes * shells + (6 * nodes * case.mesh.radial if solid else 0),
        "interface_points": columns * (along + 1) * (shells - 1) if case.coil.model == "layers" else 0,
    }
    result |= _time_steps(case)
    seconds = 4.0 + (SECONDS_PER_SOLID_DOF if solid else 7e-5) * result["dofs"]
    if "steps" in result:
        per_harmonic = 2.0 * result["dofs"] / around
        if case.solver.method != "full":
            blocks, size = (0.5 * around, per_harmonic) if half else (around, 0.5 * per_harmonic)
            seconds += SECONDS_PER_EIGENPROBLEM * blocks * size**3
        points = result["interface_points"]
        unit = {"reduced": points, "condensed": points * per_harmonic, "full": result["dofs"]}[case.solver.method]
        seconds += result["steps"] * max(1e-4, SECONDS_PER_UNIT[case.solver.method] * unit)
    result["estimated_seconds"] = seconds
    return result


def _harmonics(case: Case) -> dict[str, Any]:
    """Unknowns of one harmonic around the axis, and a time: 3e-5 s per unknown and eigenproblem."""
    from wroll_fem.mesh.axisymmetric import make_section

    n_r, n_z = make_section(case).shape
    dofs = 3 * (3 * n_r + 1) * (3 * n_z + 1)
    if case.design_map is None:
        return {"dofs": dofs, "interface_points": 0, "estimated_seconds": 2.0 + 12 * 3e-5 * dofs}
    designs = len(case.design_map.mandrel_radius) * len(case.design_map.mandrel_thickness) + 1
    return {"dofs": dofs, "designs": designs, "estimated_seconds": 2.0 + 26 * 3e-5 * dofs * designs}


def _time_steps(case: Case) -> dict[str, Any]:
    """Steps, step and length of a time history; nothing for other analyses."""
    if case.analysis not in ("sweep", "dwell"):
        return {}
    from wroll_fem.signals.base_motion import base_motion

    duration = base_motion(case.excitation).duration
    steps = math.ceil(duration / case.time_step - 1e-9)
    return {"steps": steps, "time_step_s": case.time_step, "duration_s": duration}
