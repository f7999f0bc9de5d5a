"""Base classes of the cases of structural analyses: for a roll, and for matrices from a file."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any, ClassVar, Literal

from pydantic import Field

from wroll_fem.case.case import Case, Check
from wroll_fem.case.checks import (
    check_base,
    check_damping_of_file,
    check_direction_of_file,
    check_fourier,
    check_geometric_stiffness,
    check_probes,
)
from wroll_fem.case.checks_coil import check_inside, check_shaken_wraps
from wroll_fem.case.checks_interfaces import (
    INTERFACE_SECTIONS,
    check_held,
    check_interfaces,
    check_pressures,
    check_winding_stress,
)
from wroll_fem.case.checks_supports import check_supports
from wroll_fem.case.checks_walls import check_margins, check_plies, check_wall
from wroll_fem.case.checks_winding import (
    check_winding_given,
    check_winding_mandrel,
    check_winding_size,
    check_wraps_of_layers,
)
from wroll_fem.case.contact import Contact, Friction, friction_law
from wroll_fem.case.damping import Damping
from wroll_fem.case.excitation import Excitation
from wroll_fem.case.harmonic import Backbone, Harmonic
from wroll_fem.case.integrator import Integrator
from wroll_fem.case.mesh import Mesh
from wroll_fem.case.modal import Modal
from wroll_fem.case.preload import DEFAULT_STEPS, Preload
from wroll_fem.case.probes import Probes
from wroll_fem.case.random_response import RandomResponse
from wroll_fem.case.roll import ROLL, RollSections
from wroll_fem.case.solver import Solver
from wroll_fem.case.structure import Structure
from wroll_fem.case.winding import Winding
from wroll_fem.contact.law import FrictionLaw
from wroll_fem.errors import InputError

CONTACT, PRELOAD = INTERFACE_SECTIONS["contact"], INTERFACE_SECTIONS["preload"]
WINDING = "winding of the roll: tension, wraps, mandrel, web"
EXCITATION = "motion of the base"
DAMPING = "material damping of mandrel and coil, in addition to friction"
INTEGRATOR = "time integration"
SOLVER = "solution of a step"
MODAL = "the eigenvalue analysis"
HARMONIC = "periodic motions by harmonic balance"
BACKBONE = "range of the backbone"
RANDOM_RESPONSE = "levels and limits of the random response of a backbone"
PROBES = "named points whose motion the results contain; the tip is always included"

_OF_ROLL = (*ROLL, "mesh", "preload", "probes")
"""Case sections that are replaced by the matrices from a file."""


class StructuralCase(Case):
    """Case of a structural analysis, for a roll or for matrices from a file.

    Sections that the analysis does not use are allowed, so that one file can serve several analyses.
    """

    contact: Contact | None = Field(default=None, description=CONTACT)
    winding: Winding | None = Field(default=None, description=WINDING)
    excitation: Excitation | None = Field(default=None, description=EXCITATION)
    damping: Damping | None = Field(default=None, description=DAMPING)
    integrator: Integrator = Field(default_factory=Integrator, description=INTEGRATOR)
    solver: Solver = Field(default_factory=Solver, description=SOLVER)
    modal: Modal = Field(default_factory=Modal, description=MODAL)
    harmonic: Harmonic | None = Field(default=None, description=HARMONIC)
    backbone: Backbone | None = Field(default=None, description=BACKBONE)
    random_response: RandomResponse | None = Field(default=None, description=RANDOM_RESPONSE)

    ALWAYS_WRITTEN: ClassVar[tuple[str, ...]] = (*Case.ALWAYS_WRITTEN, "integrator", "solver", "modal")

    @property
    def friction(self) -> Friction:
        """Friction law of the interfaces.

        Raises
        ------
        InputError
            When the case has no section `contact`.
        """
        if self.contact is None:
            remedy = f"add it ({CONTACT})"
            raise InputError("required section is missing", key="contact", remedy=remedy)
        return self.contact.friction

    @property
    def direction(self) -> Literal["x", "y"]:
        """Direction of the base motion; x by default."""
        return "x" if self.excitation is None else self.excitation.direction

    @property
    def time_step(self) -> float:
        """Time step, s: 1 / (f `integrator.steps`); f: highest excitation frequency, or 1 Hz without excitation."""
        highest = 1.0 if self.excitation is None else self.excitation.highest_frequency_hz
        return 1.0 / (highest * self.integrator.steps)


class OnRoll(StructuralCase, RollSections):
    """Structural case of a roll described by geometry, mandrel and coil."""

    preload: Preload | None = Field(default=None, description=PRELOAD)
    probes: Probes | None = Field(default=None, description=PROBES)

    ALWAYS_WRITTEN: ClassVar[tuple[str, ...]] = (*StructuralCase.ALWAYS_WRITTEN, *ROLL, "mesh")

    def _checks(self) -> Iterator[Check]:
        for section in INTERFACE_SECTIONS:
            yield partial(self._check_section, section)
        yield lambda: check_base(self.mandrel, self.analysis)
        yield self._check_supports
        yield lambda: check_plies(self.geometry, self.mandrel, self.coil)
        yield lambda: check_wall(self.geometry, self.mandrel, self.coil, self.mesh)
        yield self._check_margins
        yield lambda: check_pressures(self.preload, self.coil.layers)
        yield lambda: check_held(self.coil, self.contact, self.preload, self.analysis)
        yield lambda: check_probes(self.probes or {}, self.coil, self.coil_span, self.geometry.length)
        yield lambda: check_winding_given(self.winding, self.preload)
        yield lambda: check_winding_size(self.winding, self.geometry, self.coil)
        yield lambda: check_wraps_of_layers(self.winding, self.coil)
        yield lambda: check_inside(self.coil, self.analysis)
        yield self._check_shaken_wraps
        yield lambda: check_fourier(self.coil, self.mesh, self.analysis)
        yield self._check_geometric_stiffness
        yield from super()._checks()

    def _check_shaken_wraps(self) -> None:
        check_shaken_wraps(self.coil, self.winding, self.damping, self.solver, self.preload, self.analysis)

    def _check_section(self, section: str) -> None:
        check_interfaces(section, self.coil, self.modal, self.analysis, self.model_fields_set)

    def _check_supports(self) -> None:
        check_supports(self.mandrel, self.coil, self.analysis, prestressed=self.has_geometric_stiffness)

    def _check_margins(self) -> None:
        check_margins(self.geometry, self.coil, self.mesh, prestressed=self.has_geometric_stiffness)

    def _check_geometric_stiffness(self) -> None:
        if self.has_geometric_stiffness:
            asked = self.preload is not None and self.preload.geometric_stiffness
            analysis = "" if asked else self.analysis
            check_winding_stress(self.preload)
            check_geometric_stiffness(self.coil, self.mesh, contact=self.contact is not None, analysis=analysis)

    @property
    def interface_laws(self) -> list[FrictionLaw]:
        """Friction law of each interface, inner first: that of `contact.friction`, with `coil.per_wrap` of all wraps.

        Raises
        ------
        InputError
            When the case has no section `contact`, or the law has no elastic slip that `coil.per_wrap` could add up.
        """
        law, coil, winding = friction_law(self.friction), self.coil, self.winding
        if not coil.per_wrap or winding is None:
            return [law] * coil.layers
        return [law.in_series(count) for count in coil.interfaces_in_series(winding.wraps)]

    @property
    def preload_steps(self) -> int:
        """Number of load steps of the static preload."""
        return DEFAULT_STEPS if self.preload is None else self.preload.steps

    @property
    def has_geometric_stiffness(self) -> bool:
        """Whether the geometric stiffness of the preload is added to the structure."""
        return self.preload is not None and self.preload.geometric_stiffness

    @property
    def wound(self) -> Winding | None:
        """Case section `winding`, or None; a missing mandrel is taken from `geometry` and `mandrel`."""
        return None if self.winding is None else self.winding.on_mandrel(self.geometry, self.mandrel)

    def resolved(self) -> dict[str, Any]:
        """Like `Case.resolved`, but keys that the coil model ignores are kept only if they were given."""
        data = super().resolved()
        if self.coil.model != "solid":
            for key in set(Mesh.OF_SOLID) - self.mesh.model_fields_set:
                del data["mesh"][key]
        if self.coil.model == "none":
            for key in {"total_thickness", "material"} - self.coil.model_fields_set:
                data["coil"].pop(key, None)
        return data


class OnStructure(StructuralCase):
    """Structural case whose matrices are read from a file, together with interfaces, preload and influence vector."""

    structure: Structure = Field(
        description="matrices from a file, in place of geometry, mandrel, coil, mesh and preload"
    )

    ALWAYS_WRITTEN: ClassVar[tuple[str, ...]] = (*StructuralCase.ALWAYS_WRITTEN, "structure")

    def _checks(self) -> Iterator[Check]:
        yield lambda: check_direction_of_file(self.excitation)
        yield lambda: check_damping_of_file(self.damping)
        yield lambda: check_winding_mandrel(self.winding, described=False)
        yield from super()._checks()

    @property
    def preload_steps(self) -> int:
        """Number of load steps of the static preload."""
        return self.structure.preload_steps

    @classmethod
    def _refusal(cls, key: str) -> tuple[str, str] | None:
        if key in _OF_ROLL:
            return (
                "cannot be combined with structure, whose file replaces it",
                f"leave {key} out, or leave structure out",
            )
        return super()._refusal(key)

    def resolved(self) -> dict[str, Any]:
        """Like `Case.resolved`, but keys that the matrix file replaces are kept only if they were given."""
        data = super().resolved()
        if "excitation" in data:
            del data["excitation"]["direction"]
        if self.contact is not None and "normal" not in self.contact.model_fields_set:
            del data["contact"]["normal"]
        return data
