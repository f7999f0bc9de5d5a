"""Checks of case sections against each other; each function raises an error if the sections are inconsistent."""

from __future__ import annotations

from typing import Any

from wroll_fem.case.base import validation_error
from wroll_fem.case.coil import Coil
from wroll_fem.case.damping import Damping
from wroll_fem.case.design_map import DesignMap
from wroll_fem.case.excitation import ANALYSIS_OF_MOTION, ChirpExcitation, Excitation, HistoryExcitation
from wroll_fem.case.integrator import Integrator
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.mesh import Mesh
from wroll_fem.case.output import Output
from wroll_fem.case.probes import Probes
from wroll_fem.case.solver import Solver
from wroll_fem.case.two_dof import TwoDof
from wroll_fem.numerics.step_limit import MOST_STEPS

FEWEST_STEPS_PER_CYCLE = 20
"""Smallest number of steps per cycle without `solver.allow_coarse`; with fewer, the period error exceeds 0.8 % and slip
reversals are missed."""

FEWEST = 3, "too few to sample the base motion: every sample could be zero"
"""Smallest number of steps per cycle with `solver.allow_coarse`, and the message for a smaller number."""

FEWEST_OF_KIND = {"chirp": (9, "too few to demodulate the response of a sweep")}
"""Kinds of base motion that need more than `FEWEST`."""

WITH_CURVE = ("sweep", "random", "random_response", "harmonic", "two_dof")
"""Analyses that give a response curve versus frequency, from which damping can be estimated."""

FOURIER = ("modal", "modal_transient", "design_map")
"""Analyses that can use `mesh.discretisation: fourier`."""

FOURIER_COILS = ("solid", "bonded", "nonstructural_mass", "none")
"""Coil models without friction: their circumferential harmonics are uncoupled."""


def check_damping_of_file(damping: Damping | None) -> None:
    """Refuse loss factors with matrices from a file, which do not tell mandrel and coil apart."""
    if damping is not None and damping.loss_factor is not None:
        raise validation_error(
            "needs a mandrel and a coil, but the case has matrices from a file", key="damping.loss_factor",
            show_value=False,
            remedy="use damping.modal or damping.rayleigh, or write damping_loss or C to the file",
        )  # fmt: skip


def check_motion(excitation: Any, analysis: str, *wanted: str) -> None:
    """Refuse a kind of base motion that the analysis cannot use; called before the other keys are validated.

    Parameters
    ----------
    excitation
        Case section `excitation`, as a mapping or a model.
    wanted
        Kinds that the analysis can use.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    names = " or ".join(wanted)
    usual = wanted[0]
    kind = excitation.get("kind", usual) if isinstance(excitation, dict) else getattr(excitation, "kind", usual)
    if kind not in wanted and isinstance(kind, str) and kind in ANALYSIS_OF_MOTION:
        raise validation_error(
            f"analysis {analysis} needs a {names}", key="kind", value=kind,
            remedy=f"use excitation.kind: {names}, or analysis: {ANALYSIS_OF_MOTION[kind]}",
        )  # fmt: skip
    if kind not in wanted:
        raise validation_error(
            "is not one of the choices", key="kind", value=kind, remedy=f"use {', '.join(ANALYSIS_OF_MOTION)}"
        )
    if isinstance(excitation, dict) and "kind" not in excitation:
        remedy = f"add it (motion of the base): {names}"
        raise validation_error("required key is missing", key="kind", show_value=False, remedy=remedy)


def check_direction_of_file(excitation: Excitation | None) -> None:
    """Refuse `excitation.direction` for matrices from a file; their influence vector sets the direction.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if excitation is not None and "direction" in excitation.model_fields_set:
        raise validation_error(
            "the direction is set by the influence vector in structure.file", key="excitation.direction",
            value=excitation.direction, remedy="leave it out here; set it in the case that `wroll export` reads",
        )  # fmt: skip


def check_base(mandrel: Mandrel, analysis: str) -> None:
    """Refuse a mandrel with a free base in every analysis except modal.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if mandrel.base == "free" and analysis != "modal":
        raise validation_error(
            f"analysis {analysis} needs a supported mandrel", key="mandrel.base", value="free",
            remedy="use mandrel.base: clamped, or analysis: modal",
        )  # fmt: skip


def check_probes(probes: Probes, coil: Coil, span: tuple[float, float], length: float) -> None:
    """Refuse probes outside the shells of the roll, whose coil has a ``span`` in m, and invalid probe names.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    layers = coil.layers if coil.model in ("layers", "bonded") else 0
    shells = ["mandrel", *(f"layer_{k:02d}" for k in range(1, layers + 1))]
    for name, probe in probes.items():
        key = f"probes.{name}"
        if name == "tip":
            remedy = "choose another name; every result contains the tip"
            raise validation_error("is the name of the default probe", key=key, show_value=False, remedy=remedy)
        if not name.isidentifier():
            remedy = "use letters, digits and underscores, for example mid_height"
            raise validation_error("is not a valid name", key=key, show_value=False, remedy=remedy)
        if probe.z > length:
            remedy = f"give at most geometry.length = {length:g} m"
            raise validation_error("is above the roll", key=f"{key}.z", value=probe.z, remedy=remedy)
        if probe.body not in shells:
            remedy = f"use one of: {', '.join(shells)}"
            raise validation_error("the roll has no such shell", key=f"{key}.body", value=probe.body, remedy=remedy)
        if probe.body != "mandrel" and not span[0] <= probe.z <= span[1]:
            remedy = f"give a height from {span[0]:g} to {span[1]:g} m, or body: mandrel"
            raise validation_error("is outside the coil", key=f"{key}.z", value=probe.z, remedy=remedy)


def check_band(excitation: ChirpExcitation) -> None:
    """Refuse the band of a response curve whose last frequency is below the first one, or with several amplitudes.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if excitation.f_end < excitation.f_start:
        raise validation_error(
            f"must be above excitation.f_start = {excitation.f_start:g} Hz", key="excitation.f_end",
            value=excitation.f_end, remedy="give f_end > f_start, in Hz",
        )  # fmt: skip
    if excitation.sweep_direction == "up_down":
        raise validation_error(
            "a response curve has no direction: it contains both branches", key="excitation.sweep_direction",
            value="up_down", remedy="leave it out, or use analysis: sweep",
        )  # fmt: skip
    if excitation.profile is not None:
        raise validation_error(
            "a response curve has one amplitude", key="excitation.profile", show_value=False,
            remedy="leave it out, or use analysis: sweep",
        )  # fmt: skip


def check_steps(excitation: HistoryExcitation, integrator: Integrator, solver: Solver) -> None:
    """Refuse too few time steps per cycle; `solver.allow_coarse` lowers the limit to what sampling requires.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if integrator.follow_frequency and excitation.kind != "chirp":
        raise validation_error(
            f"a {excitation.kind} has no frequency that changes", key="integrator.follow_frequency", value=True,
            remedy="leave it out; it is for analysis: sweep",
        )  # fmt: skip
    steps = integrator.steps
    fewest, reason = FEWEST_OF_KIND.get(excitation.kind, FEWEST)
    if steps < fewest:
        raise validation_error(
            reason, key="integrator.steps_per_cycle", value=steps,
            remedy=f"use {FEWEST_STEPS_PER_CYCLE} or more ({fewest} or more with solver.allow_coarse: true)",
        )  # fmt: skip
    if (cycles := getattr(excitation, "most_cycles", 0.0)) * steps > MOST_STEPS:
        raise validation_error(
            f"the motion takes {cycles * steps:.3g} time steps, at most {MOST_STEPS:.0e} are possible",
            key="excitation", show_value=False, remedy="shorten it, or lower integrator.steps_per_cycle",
        )  # fmt: skip
    if solver.allow_coarse or steps >= FEWEST_STEPS_PER_CYCLE:
        return
    f = excitation.highest_frequency_hz
    raise validation_error(
        f"too few steps per cycle: dt = {1 / (f * steps):.3g} s at the highest frequency, {f:g} Hz",
        key="integrator.steps_per_cycle", value=steps,
        remedy=f"use {FEWEST_STEPS_PER_CYCLE} or more (dt <= {1 / (f * FEWEST_STEPS_PER_CYCLE):.3g} s; "
        "40 is the default) or set solver.allow_coarse: true",
    )  # fmt: skip


def check_damping_method(output: Output, analysis: str, two_dof: TwoDof | None = None) -> None:
    """Refuse damping estimators other than half_power if the analysis or `two_dof.design_space` cannot use them.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    method = output.damping
    if method == "half_power":
        return
    if analysis not in WITH_CURVE:
        raise validation_error(
            f"analysis {analysis} has no response curve from which damping is "
            "estimated", key="output.damping", value=method,
            remedy=f"leave it out, or use one of the analyses {', '.join(WITH_CURVE)}",
        )  # fmt: skip
    if two_dof is not None and two_dof.design_space is not None:
        raise validation_error(
            "the map of the design space is computed with half_power", key="output.damping", value=method,
            remedy="leave it out, or leave two_dof.design_space out",
        )  # fmt: skip


def check_fourier(coil: Coil, mesh: Mesh, analysis: str) -> None:
    """Refuse `mesh.discretisation: fourier` for an analysis, coil or mesh that Fourier elements cannot handle.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if mesh.discretisation != "fourier":
        return
    three = "or leave out mesh.discretisation"
    if analysis not in FOURIER:
        raise validation_error(
            f"analysis {analysis} cannot use Fourier elements", key="mesh.discretisation", value="fourier",
            remedy=f"use three_dimensional, or one of the analyses {', '.join(FOURIER)}",
        )  # fmt: skip
    if coil.model not in FOURIER_COILS:
        raise validation_error(
            "friction between layers couples the circumferential harmonics", key="coil.model", value=coil.model,
            remedy=f"use {', '.join(FOURIER_COILS)}, {three}",
        )  # fmt: skip
    if coil.rubs:
        raise validation_error(
            "friction couples the circumferential harmonics", key="coil.interface", value=coil.interface,
            remedy=f"use bonded, {three}",
        )  # fmt: skip
    if coil.base == "guided":
        raise validation_error(
            "semi-analytical (Fourier) elements have no guided base", key="coil.base", value=coil.base,
            remedy=f"use free or clamped, {three}",
        )  # fmt: skip
    if mesh.file is not None:
        raise validation_error(
            "semi-analytical (Fourier) elements need the generated axisymmetric mesh", key="mesh.file",
            value=str(mesh.file), remedy=f"leave it out, {three}",
        )  # fmt: skip


def check_geometric_stiffness(coil: Coil, mesh: Mesh, *, contact: bool, analysis: str = "") -> None:
    """Refuse geometric stiffness for solid coils, Fourier elements, and layers without a section `contact`.

    ``analysis`` names the analysis that needs it; without a name, `preload.geometric_stiffness` asks for it.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if coil.model == "solid" or mesh.discretisation == "fourier":
        what = "a solid coil" if coil.model == "solid" else "a roll of Fourier elements"
        key, value = ("analysis", analysis) if analysis else ("preload.geometric_stiffness", True)
        remedy = "use coil.model: layers with mesh.discretisation: three_dimensional"
        raise validation_error(
            f"needs shells; {what} has no preload", key=key, value=value,
            remedy=remedy if analysis else f"leave it out, or {remedy}",
        )  # fmt: skip
    if coil.model == "layers" and not contact:
        remedy = "add it (friction and normal contact): the preload acts through the contact"
        raise validation_error("required section is missing", key="contact", show_value=False, remedy=remedy)


def check_design_map(design_map: DesignMap, coil: Coil, mesh: Mesh) -> None:
    """Require an orthotropic solid coil and Fourier elements for design_map; check its softest coil, radii and walls.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    if coil.model != "solid":
        raise validation_error(
            "analysis design_map varies the shear moduli of a solid coil", key="coil.model", value=coil.model,
            remedy="use solid",
        )  # fmt: skip
    if coil.material.kind != "cylindrical_orthotropic":
        raise validation_error(
            "analysis design_map varies the shear moduli between wraps", key="coil.material.kind",
            value=coil.material.kind, remedy="use cylindrical_orthotropic",
        )  # fmt: skip
    if mesh.discretisation != "fourier":
        raise validation_error(
            "analysis design_map uses semi-analytical (Fourier) elements", key="mesh.discretisation",
            value=mesh.discretisation, remedy="use mesh.discretisation: fourier",
        )  # fmt: skip
    stiffest = min(coil.material.G_r_theta, coil.material.G_r_z)
    if not isinstance(design_map.softest, str) and design_map.softest >= stiffest:
        raise validation_error(
            "the softest coil is not softer than the coil "
            "of the case", key="design_map.softest", value=design_map.softest,
            remedy=f"use less than {stiffest:g} Pa, the smaller shear modulus between wraps of that coil",
        )  # fmt: skip
    wall, radius = max(design_map.mandrel_thickness), min(design_map.mandrel_radius)
    if wall >= radius:
        raise validation_error(
            f"the smallest radius must exceed the thickest wall, {wall:g} m", key="design_map.mandrel_radius",
            value=radius, remedy=f"use radii above {wall:g} m, or thinner walls",
        )  # fmt: skip
