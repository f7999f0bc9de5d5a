"""Case classes, one per analysis; a structural analysis has two: one for a roll, one for matrices from a file.

Those of the time histories are in `kinds_history`, imported here first. A roll analysis that has no case section of its
own has no class here; its class is created from its name.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, create_model

from wroll_fem.case.analyses import MODULES
from wroll_fem.case.base import Real
from wroll_fem.case.case import Case, Check, case_kind, case_kinds
from wroll_fem.case.checks import (
    check_band,
    check_damping_method,
    check_design_map,
)
from wroll_fem.case.checks_coil import check_mode, check_resonance, check_solid_coil
from wroll_fem.case.checks_interfaces import check_layers
from wroll_fem.case.checks_winding import check_winding_friction, check_winding_mandrel, check_winding_size
from wroll_fem.case.coil import Coil
from wroll_fem.case.contact import Contact
from wroll_fem.case.damping import Damping
from wroll_fem.case.design_map import DesignMap
from wroll_fem.case.excitation import (
    ChirpExcitation,
    Excitation,
    SineExcitation,
)
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.harmonic import Backbone, Harmonic
from wroll_fem.case.integrator import Integrator
from wroll_fem.case.kinds_history import ANALYSIS, motion
from wroll_fem.case.kinds_random_response import RollRandomResponseCase, StructureRandomResponseCase
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.mesh import Mesh
from wroll_fem.case.modal import Modal
from wroll_fem.case.preload import Preload
from wroll_fem.case.random_response import RandomResponse
from wroll_fem.case.sizing import Sizing, SizingMesh
from wroll_fem.case.solver import Solver
from wroll_fem.case.structural import (
    BACKBONE,
    CONTACT,
    DAMPING,
    EXCITATION,
    HARMONIC,
    INTEGRATOR,
    MODAL,
    PRELOAD,
    RANDOM_RESPONSE,
    SOLVER,
    WINDING,
    OnRoll,
    OnStructure,
    StructuralCase,
)
from wroll_fem.case.two_dof import TwoDof
from wroll_fem.case.winding import Winding


class HarmonicCase(StructuralCase):
    """Periodic response to sine motion of the base versus frequency, by harmonic balance."""

    analysis: Literal["harmonic"] = Field(description=ANALYSIS)
    excitation: Annotated[ChirpExcitation, motion("harmonic", "chirp")] = Field(description=EXCITATION)
    harmonic: Harmonic = Field(default_factory=Harmonic, description=HARMONIC)

    def _checks(self) -> Iterator[Check]:
        yield from super()._checks()
        yield lambda: check_band(self.excitation)


@case_kind
class RollHarmonicCase(HarmonicCase, OnRoll):
    """Periodic response of a roll."""


@case_kind
class StructureHarmonicCase(HarmonicCase, OnStructure):
    """Periodic response of a structure whose matrices come from a file."""


class BackboneCase(StructuralCase):
    """Backbone: periodic motion at resonance versus amplitude."""

    analysis: Literal["backbone"] = Field(description=ANALYSIS)
    harmonic: Harmonic = Field(default_factory=Harmonic, description=HARMONIC)
    backbone: Backbone = Field(default_factory=Backbone, description=BACKBONE)


@case_kind
class RollBackboneCase(BackboneCase, OnRoll):
    """Backbone of a roll."""


@case_kind
class StructureBackboneCase(BackboneCase, OnStructure):
    """Backbone of a structure whose matrices come from a file."""


case_kind(RollRandomResponseCase)
case_kind(StructureRandomResponseCase)


def _stuck(value: Any) -> Any:
    """Section `modal` with sticking interfaces if it does not name them: joints of matrices rarely mean bonds."""
    if isinstance(value, Modal):
        return value if "interface" in value.model_fields_set else value.model_copy(update={"interface": "stuck"})
    return {"interface": "stuck", **value} if isinstance(value, dict) else value


def _stuck_modes() -> Modal:
    return Modal(interface="stuck")


class ModalCase(StructuralCase):
    """Natural frequencies and mode shapes."""

    analysis: Literal["modal"] = Field(description=ANALYSIS)


@case_kind
class RollModalCase(ModalCase, OnRoll):
    """Modes of a roll."""


@case_kind
class StructureModalCase(ModalCase, OnStructure):
    """Modes of a structure whose matrices come from a file."""

    modal: Annotated[Modal, BeforeValidator(_stuck)] = Field(default_factory=_stuck_modes, description=MODAL)


class ShakenCoilCase(OnRoll):
    """Solid coil with the pressure of its wound roll, under steady sine motion of the base at several levels."""

    winding: Winding = Field(description=WINDING)
    damping_ratio: Real = Field(
        ge=1e-3,
        lt=1,
        description="damping ratio of every mode without slip, dimensionless (modal_transient, slip_damping; 0.02 in "
        "the thesis)",
    )

    def _checks(self) -> Iterator[Check]:
        yield from super()._checks()
        yield lambda: check_winding_friction(self.winding, positive=True)
        yield lambda: check_solid_coil(self.coil, self.analysis)

    @classmethod
    def _refusal(cls, key: str) -> tuple[str, str] | None:
        if key == "structure":
            return (
                "contains only matrices, from which no stress is recovered",
                "describe the roll by geometry, mandrel and coil",
            )
        return super()._refusal(key)

    @property
    def wound(self) -> Winding:
        """Case section `winding`; a missing key `winding.mandrel` is filled in from `geometry` and `mandrel`."""
        return self.winding.on_mandrel(self.geometry, self.mandrel)


@case_kind
class ModalTransientCase(ShakenCoilCase):
    """Solid coil under steady sine motion of the base: points at which shear exceeds the friction capacity."""

    analysis: Literal["modal_transient"] = Field(description=ANALYSIS)
    excitation: Annotated[SineExcitation, motion("modal_transient", "sine")] = Field(description=EXCITATION)

    def _checks(self) -> Iterator[Check]:
        yield from super()._checks()
        yield lambda: check_mode(self.excitation, self.analysis)


@case_kind
class SlipDampingCase(ShakenCoilCase):
    """Solid coil whose wraps slide: frequency and damping of its resonance versus amplitude."""

    analysis: Literal["slip_damping"] = Field(description=ANALYSIS)
    excitation: Annotated[SineExcitation, motion("slip_damping", "sine")] = Field(description=EXCITATION)

    def _checks(self) -> Iterator[Check]:
        yield from super()._checks()
        yield lambda: check_resonance(self.excitation)


class PreloadCase(StructuralCase):
    """Static contact pressure under the preload."""

    analysis: Literal["preload"] = Field(description=ANALYSIS)


@case_kind
class RollPreloadCase(PreloadCase, OnRoll):
    """Preload of a roll with layers."""

    def _checks(self) -> Iterator[Check]:
        yield from super()._checks()
        yield lambda: check_layers(self.coil)


@case_kind
class StructurePreloadCase(PreloadCase, OnStructure):
    """Preload of a structure whose matrices come from a file."""


@case_kind
class BucklingCase(OnRoll):
    """Linear buckling under the preload."""

    analysis: Literal["buckling"] = Field(description=ANALYSIS)
    preload: Preload = Field(description=PRELOAD)

    @property
    def has_geometric_stiffness(self) -> bool:
        """True, because linear buckling is computed with the geometric stiffness."""
        return True

    @classmethod
    def _refusal(cls, key: str) -> tuple[str, str] | None:
        if key == "structure":
            return "contains only matrices, without stresses", "describe the roll by geometry, mandrel and coil"
        return super()._refusal(key)


@case_kind
class WindingCase(Case):
    """Stress in the wound roll: pressure between the wraps and friction capacity.

    The sections of a roll are optional. `geometry` and `mandrel` describe the mandrel under the web. The wound roll
    must have the size of `coil`. The other sections have no effect here.
    """

    analysis: Literal["winding"] = Field(description=ANALYSIS)
    winding: Winding = Field(description=WINDING)
    geometry: Geometry | None = Field(default=None, description="tube of the mandrel")
    mandrel: Mandrel | None = Field(default=None, description="material and end conditions of the mandrel")
    coil: Coil | None = Field(default=None, description="model of the wound web")
    contact: Contact | None = Field(default=None, description=CONTACT)
    preload: Preload | None = Field(default=None, description=PRELOAD)
    excitation: Excitation | None = Field(default=None, description=EXCITATION)
    damping: Damping | None = Field(default=None, description=DAMPING)
    integrator: Integrator | None = Field(default=None, description=INTEGRATOR)
    solver: Solver | None = Field(default=None, description=SOLVER)
    mesh: Mesh | None = Field(default=None, description="element counts or a mesh file")
    modal: Modal | None = Field(default=None, description=MODAL)
    harmonic: Harmonic | None = Field(default=None, description=HARMONIC)
    backbone: Backbone | None = Field(default=None, description=BACKBONE)
    random_response: RandomResponse | None = Field(default=None, description=RANDOM_RESPONSE)

    def _checks(self) -> Iterator[Check]:
        yield lambda: check_winding_friction(self.winding)
        yield lambda: check_winding_mandrel(
            self.winding, described=self.geometry is not None and self.mandrel is not None
        )
        yield lambda: check_winding_size(self.winding, self.geometry, self.coil)
        yield from super()._checks()

    @property
    def wound(self) -> Winding:
        """Case section `winding`; a missing mandrel is taken from `geometry` and `mandrel` if these are given."""
        if self.geometry is None or self.mandrel is None:
            return self.winding
        return self.winding.on_mandrel(self.geometry, self.mandrel)

    @classmethod
    def _refusal(cls, key: str) -> tuple[str, str] | None:
        if key == "structure":
            return "analysis winding has no matrices", "leave it out: section winding describes the roll"
        return super()._refusal(key)


@case_kind
class DesignMapCase(OnRoll):
    """Frequencies of the softest and the stiffest coil versus mandrel radius and wall thickness."""

    analysis: Literal["design_map"] = Field(description=ANALYSIS)
    design_map: DesignMap = Field(
        description="mandrels of the map, and softest coil",
        examples=[{"mandrel_radius": [0.03, 0.04], "mandrel_thickness": [1.5e-3, 2.0e-3]}],
    )

    def _checks(self) -> Iterator[Check]:
        yield from super()._checks()
        yield lambda: check_design_map(self.design_map, self.coil, self.mesh)


@case_kind
class SizingCase(Case):
    """Wall of a mandrel for a margin against yield under a transverse acceleration and an external pressure."""

    analysis: Literal["sizing"] = Field(description=ANALYSIS)
    sizing: Sizing = Field(
        description="structure, loads, margin and material of a mandrel, in place of a roll",
        examples=[
            {
                "structure": "iROSA", "length": 3.0, "mandrel_outer_diameter": 0.5, "coil_outer_diameter": 0.8,
                "coil_mass": 25, "acceleration_g": 100, "pressure": 5.0e5, "margin": 0.25, "factor_of_safety": 1.2,
            }
        ],
    )  # fmt: skip
    mesh: SizingMesh = Field(default_factory=SizingMesh, description="cells of the mandrel along its axis")

    ALWAYS_WRITTEN: ClassVar[tuple[str, ...]] = (*Case.ALWAYS_WRITTEN, "mesh")

    @classmethod
    def _refusal(cls, key: str) -> tuple[str, str] | None:
        problem = super()._refusal(key)
        return None if problem is None else ("analysis sizing does not use it", f"leave {key} out")


@case_kind
class TwoDofCase(Case):
    """Two masses coupled by friction, under sine motion of the base."""

    analysis: Literal["two_dof"] = Field(description=ANALYSIS)
    two_dof: TwoDof = Field(
        description="two masses coupled by friction, in place of a roll",
        examples=[{"friction_capacity": [1.0, 10.0], "omega": {"start": 0.4, "stop": 2.0, "points": 400}}],
    )

    def _checks(self) -> Iterator[Check]:
        yield lambda: check_damping_method(self.output, self.analysis, self.two_dof)

    @classmethod
    def _refusal(cls, key: str) -> tuple[str, str] | None:
        problem = super()._refusal(key)
        return None if problem is None else ("analysis two_dof does not use it", f"leave {key} out")


def _roll_case(name: str) -> type[OnRoll]:
    """Case class of a roll analysis that has no case section of its own."""
    title = "".join(word.capitalize() for word in name.split("_"))
    analysis: Any = (Literal[name], Field(description=ANALYSIS))
    return create_model(f"Roll{title}Case", __base__=OnRoll, __doc__=f"Case of the analysis {name}.", analysis=analysis)


for _name in MODULES:
    if (_name, False) not in case_kinds():
        case_kind(_roll_case(_name))

ANALYSES = tuple(MODULES)
"""Names of the analyses: the values of `analysis`."""
