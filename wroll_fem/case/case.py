"""The case: everything a run needs, typed, frozen, in SI units."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Self, get_args

import yaml
from pydantic import ConfigDict, Field, PrivateAttr, ValidationError, field_validator, model_validator

from wroll_fem.case.base import Real, Section, wrong
from wroll_fem.case.coil import Coil
from wroll_fem.case.contact import Contact, PenaltyFriction
from wroll_fem.case.design_map import DesignMap
from wroll_fem.case.excitation import DwellExcitation, Excitation
from wroll_fem.case.fourier import design_map_fits, fourier_fits
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.harmonic import Backbone, Harmonic
from wroll_fem.case.integrator import Integrator
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.mesh import Mesh
from wroll_fem.case.messages import input_error
from wroll_fem.case.modal import Modal
from wroll_fem.case.modal_transient import damping_ratio_fits, solid_coil
from wroll_fem.case.output import Output, damping_fits
from wroll_fem.case.preload import Preload
from wroll_fem.case.solver import Solver
from wroll_fem.case.structure import Structure, unused_coil, unused_geometry, unused_mandrel
from wroll_fem.case.two_dof import NOT_IN_TWO_DOF, TwoDof, two_dof_fits
from wroll_fem.case.winding import Winding, winding_fits, winding_present
from wroll_fem.errors import InputError

Analysis = Literal[
    "sweep", "dwell", "harmonic", "backbone", "modal", "modal_transient", "preload", "winding", "design_map", "two_dof"
]  # fmt: skip
ANALYSES: tuple[str, ...] = get_args(Analysis)

#: Analyses that write checkpoints, from which `--resume` goes on.
RESUMABLE = frozenset({"sweep", "dwell"})

#: Fewer steps per cycle than this are refused: period error above 0.8 % and slip reversals missed.
FEWEST_STEPS_PER_CYCLE = 20

#: Sections that only some analyses use; when neither used nor written they stay out of resolved case and hash.
_OPTIONAL = (
    "contact", "preload", "excitation", "geometry", "mandrel", "coil", "structure", "harmonic", "backbone",
    "damping_ratio", "winding", "design_map", "two_dof",
)  # fmt: skip

#: Sections without a part in the wound-roll stress; they stay out of its resolved case unless written.
_NOT_IN_WINDING = ("integrator", "solver", "mesh", "modal")

#: Sections that describe a roll, and what the matrices of `structure` stand for.
_ROLL = ("geometry", "mandrel", "coil")
_IN_PLACE_OF_ROLL = ("structure", "winding", "two_dof")
_IN_STRUCTURE = (*_ROLL, "mesh", "preload")

#: Solver keys that change when something is saved or accepted, never a number.
_NOT_PHYSICS = ("checkpoint_seconds", "allow_coarse")


def _unused_contact() -> Contact:
    return Contact(friction=PenaltyFriction(mu=0.25, elastic_slip=1e-6))


def _unused_preload() -> Preload:
    return Preload(pressure=0.0)


def _unused_excitation() -> DwellExcitation:
    return DwellExcitation(kind="dwell", amplitude=1.0, frequency=1.0, cycles=5.0)


class Case(Section):
    """One analysis of one roll, or of a structure from a file: the whole content of a case file.

    `contact`, `preload` and `excitation` must be written for the analyses that use them
    and hold inert placeholders otherwise, so their attributes can always be read. With `structure`
    that holds for `geometry`, `mandrel` and `coil` too (their numbers are NaN, the coil's model is "none").

    Raises
    ------
    InputError
        From `model_validate` and `load_case`, naming key, value and remedy.
    """

    model_config = ConfigDict(
        # for editors
        json_schema_extra={"anyOf": [{"required": [*keys]} for keys in (_ROLL, *([key] for key in _IN_PLACE_OF_ROLL))]}
    )

    analysis: Analysis = Field(description="what to compute")
    structure: Structure | None = Field(
        default=None, description="matrices from a file, in place of geometry, mandrel, coil, mesh and preload"
    )
    geometry: Geometry = Field(default_factory=unused_geometry, description="the mandrel's tube")
    mandrel: Mandrel = Field(default_factory=unused_mandrel, description="material and end conditions of the mandrel")
    coil: Coil = Field(default_factory=unused_coil, description="how the wound web is modelled")
    contact: Contact = Field(default_factory=_unused_contact, description="between facing surfaces")
    preload: Preload = Field(default_factory=_unused_preload, description="what presses the layers onto the mandrel")
    winding: Winding | None = Field(default=None, description="how the roll was wound: tension, wraps, mandrel, web")
    excitation: Excitation = Field(default_factory=_unused_excitation, description="motion of the base")
    damping_ratio: Real | None = Field(
        default=None,
        ge=1e-3,
        lt=1,
        description="share of critical damping of every mode, dimensionless (modal_transient)",
    )
    integrator: Integrator = Field(default_factory=Integrator, description="time integration")
    solver: Solver = Field(default_factory=Solver, description="how a step is solved")
    mesh: Mesh = Field(default_factory=Mesh, description="element counts or a mesh file")
    modal: Modal = Field(default_factory=Modal, description="the eigenvalue analysis")
    harmonic: Harmonic = Field(default_factory=Harmonic, description="periodic motions by harmonic balance")
    backbone: Backbone = Field(default_factory=Backbone, description="range of the backbone")
    design_map: DesignMap | None = Field(default=None, description="mandrels of the map between loosest and tightest")
    two_dof: TwoDof | None = Field(default=None, description="two masses that rub, in place of a roll")
    output: Output = Field(default_factory=Output, description="what a run writes")

    _source: Path | None = PrivateAttr(default=None)

    @field_validator("analysis", mode="before")
    @classmethod
    def _available(cls, value: Any) -> Any:
        if value not in ANALYSES:
            raise wrong("this analysis is not available", remedy=f"use one of: {', '.join(ANALYSES)}", value=value)
        return value

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for check in _CHECKS:
            check(self)
        return self

    def __init__(self, **sections: Any) -> None:
        """Build a case from its sections, given as models or dicts; raises `InputError` as `model_validate` does."""
        try:
            super().__init__(**sections)
        except ValidationError as error:
            raise input_error(error, type(self)) from None

    # else model_validate would come here too, and the loader lose the plain error to which it adds file and --set
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    @classmethod
    def model_validate(cls, obj: Any, **keywords: Any) -> Self:
        """Build a case from a mapping; raises `InputError` (one line, all checks) when it is wrong."""
        try:
            return super().model_validate(obj, **keywords)
        except ValidationError as error:
            raise input_error(error, cls) from None

    def __eq__(self, other: object) -> bool:
        """Cases are equal when their content is, wherever it was read from."""
        return isinstance(other, Case) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash(self.resolved_yaml())

    @property
    def source(self) -> Path | None:
        """File that the case was read from."""
        return self._source

    @property
    def time_step(self) -> float:
        """Time step, s: `integrator.steps_per_cycle` steps per cycle of the highest excitation frequency."""
        return 1.0 / (self.excitation.highest_frequency_hz * self.integrator.steps_per_cycle)

    def resolved(self) -> dict[str, Any]:
        """All values, defaults included, as plain types; sections that are neither used nor written stay out."""
        unused = {key for key in _OPTIONAL if key not in self.model_fields_set}
        if self.structure is not None:
            return self._resolved_structure(unused | {"mesh"})
        if self.analysis == "winding":
            return self.model_dump(
                mode="json", exclude=unused | {key for key in _NOT_IN_WINDING if key not in self.model_fields_set}
            )
        if self.analysis == "two_dof":
            return self.model_dump(mode="json", exclude=unused | set(NOT_IN_TWO_DOF), exclude_none=True)
        data = self.model_dump(mode="json", exclude=unused)
        if self.coil.model != "solid":
            for key in set(Mesh.OF_SOLID) - self.mesh.model_fields_set:
                del data["mesh"][key]
        if self.coil.model == "none":
            given = self.coil.model_fields_set
            data["coil"] = {
                k: v for k, v in data["coil"].items() if k in given or k not in ("total_thickness", "material")
            }
        return data

    def _resolved_structure(self, unused: set[str]) -> dict[str, Any]:
        """As `resolved`; what the file decides stays out unless it was written."""
        data = self.model_dump(mode="json", exclude=unused)
        if "excitation" in data:
            del data["excitation"]["direction"]
        if "contact" in data and "normal" not in self.contact.model_fields_set:
            del data["contact"]["normal"]
        return data

    def resolved_yaml(self) -> str:
        """All values as YAML text that loads to an equal case."""
        return str(yaml.safe_dump(self.resolved(), sort_keys=False, default_flow_style=None, width=120))

    def hash(self) -> str:
        """Return the SHA-256 of everything that can change a number: files by content, of `output` how to read damping.

        The default `output.damping` stays out: cases that do not name it keep the hash they had before it existed.
        """
        data = self.resolved()
        del data["output"]
        if self.output.damping != Output.model_fields["damping"].default:
            data["output"] = {"damping": self.output.damping}
        for key in _NOT_PHYSICS:
            data.get("solver", {}).pop(key, None)
        if self.mesh.file is not None:
            data["mesh"]["file"] = hashlib.sha256(self.mesh.file.read_bytes()).hexdigest()
        if self.structure is not None:
            data["structure"]["file"] = hashlib.sha256(self.structure.file.read_bytes()).hexdigest()
        return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()

    def changed(self, *overrides: str | Mapping[str, Any]) -> Case:
        """Copy with dotted keys changed and checked again.

        Parameters
        ----------
        overrides
            "dotted.key=value" texts, the value in YAML, or mappings of dotted keys to values:
            `case.changed("contact.friction.mu=0.5")`, `case.changed({"preload.pressure": 3e4})`.

        Raises
        ------
        InputError
            One line that names key, value and remedy.
        """
        from wroll_fem.case.loader import build_case, override_texts

        given = self.model_dump(mode="json", exclude_unset=True)
        try:
            return build_case(given, override_texts(*overrides), source=self.source)
        except InputError as error:  # speaks of the command line
            error.key = (error.key or "").removeprefix("--set ") or None
            error.remedy = (error.remedy or "").replace("--set ", "") or None
            raise


def _needs(case: Case, section: str, reason: str) -> None:
    if section not in case.model_fields_set:
        what = Case.model_fields[section].description
        raise wrong("required section is missing", key=section, show_value=False, remedy=f"add it ({what}): {reason}")


def _roll_or_structure(case: Case) -> None:
    """Either the sections of a roll, or matrices in their place; wound-roll stress and two masses need neither."""
    if case.analysis == "two_dof":
        return
    if case.analysis == "winding":
        if case.structure is not None:
            remedy = "leave it out: section winding describes the roll"
            raise wrong("analysis winding has no matrices", key="structure", show_value=False, remedy=remedy)
        return
    if case.structure is None:
        for section in _ROLL:
            if section not in case.model_fields_set:
                remedy = f"add it ({Case.model_fields[section].description})"
                raise wrong("required section is missing", key=section, show_value=False, remedy=remedy)
        return
    for section in _IN_STRUCTURE:
        if section in case.model_fields_set:
            raise wrong(
                "stands beside structure, whose file replaces it", key=section, show_value=False,
                remedy=f"leave {section} out, or leave structure out",
            )  # fmt: skip
    if "direction" in case.excitation.model_fields_set:
        raise wrong(
            "the influence vector of structure.file sets the direction", key="excitation.direction",
            value=case.excitation.direction, remedy="leave it out (`wroll export` writes the direction of its case)",
        )  # fmt: skip


def _sections_present(case: Case) -> None:
    if case.analysis in ("sweep", "dwell", "harmonic", "modal_transient"):
        _needs(case, "excitation", f"analysis {case.analysis} shakes the base")
    stuck = case.analysis == "modal" and case.modal.interface == "stuck"
    if case.coil.model == "layers" and (case.analysis not in ("modal", "winding") or stuck):
        reason = "modal.interface stuck follows the preloaded contact" if stuck else "coil.model layers has interfaces"
        _needs(case, "contact", reason)
        _needs(case, "preload", reason)


def _excitation_fits(case: Case) -> None:
    wanted = {"sweep": "chirp", "harmonic": "chirp", "dwell": "dwell", "modal_transient": "sine"}.get(case.analysis)
    if wanted and case.excitation.kind != wanted:
        other = {"chirp": "sweep", "dwell": "dwell", "sine": "modal_transient"}[case.excitation.kind]
        raise wrong(
            f"analysis {case.analysis} needs a {wanted}", key="excitation.kind", value=case.excitation.kind,
            remedy=f"use excitation.kind: {wanted}, or analysis: {other}",
        )  # fmt: skip


def _base_fits(case: Case) -> None:
    if case.mandrel.base == "free" and case.analysis != "modal":
        raise wrong(
            f"analysis {case.analysis} needs a held mandrel", key="mandrel.base", value="free",
            remedy="use mandrel.base: clamped, or analysis: modal",
        )  # fmt: skip


def _layers_for_preload(case: Case) -> None:
    if case.analysis == "preload" and case.coil.model != "layers" and case.structure is None:
        raise wrong("analysis preload presses layers", key="coil.model", value=case.coil.model, remedy="use layers")


def _one_pressure_per_layer(case: Case) -> None:
    pressure, layers = case.preload.pressure, case.coil.layers
    if isinstance(pressure, list) and len(pressure) != layers:
        raise wrong(
            f"{len(pressure)} pressures for {layers} layer{'s' if layers > 1 else ''}", key="preload.pressure",
            value=pressure, remedy=f"give {layers} (inner first), or one number for the outermost layer",
        )  # fmt: skip


def _fine_enough(case: Case) -> None:
    steps = case.integrator.steps_per_cycle
    if case.analysis not in ("sweep", "dwell") or case.solver.allow_coarse or steps >= FEWEST_STEPS_PER_CYCLE:
        return
    f = case.excitation.highest_frequency_hz
    raise wrong(
        f"too few steps per cycle: dt = {case.time_step:.3g} s at the highest frequency, {f:g} Hz",
        key="integrator.steps_per_cycle", value=steps,
        remedy=f"use {FEWEST_STEPS_PER_CYCLE} or more (dt <= {1 / (f * FEWEST_STEPS_PER_CYCLE):.3g} s; "
        "40 is the default) or set solver.allow_coarse: true",
    )  # fmt: skip


_CHECKS: Sequence[Callable[[Case], None]] = (
    _roll_or_structure, _sections_present, _excitation_fits, _base_fits, _layers_for_preload, _one_pressure_per_layer,
    _fine_enough, winding_present, winding_fits, damping_ratio_fits, solid_coil, fourier_fits,
    design_map_fits, two_dof_fits, damping_fits,
)  # fmt: skip
