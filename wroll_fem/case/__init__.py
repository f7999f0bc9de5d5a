"""The case file: a module per case section, a class per analysis, a loader and a generated JSON schema."""

from __future__ import annotations

from wroll_fem.case.base import Section
from wroll_fem.case.case import Case
from wroll_fem.case.coil import Coil
from wroll_fem.case.contact import Contact, Friction, Normal
from wroll_fem.case.example import example_case
from wroll_fem.case.excitation import ChirpExcitation, DwellExcitation, Excitation
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.harmonic import Backbone, Harmonic
from wroll_fem.case.integrator import Integrator
from wroll_fem.case.kinds import (
    ANALYSES,
    BackboneCase,
    DesignMapCase,
    HarmonicCase,
    ModalCase,
    ModalTransientCase,
    PreloadCase,
    SizingCase,
    SlipDampingCase,
    TwoDofCase,
    WindingCase,
)
from wroll_fem.case.kinds_history import DwellCase, HistoryCase, RandomCase, ShockCase, SweepCase
from wroll_fem.case.kinds_random_response import RandomResponseCase
from wroll_fem.case.loader import build_case, load_case
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.material import IsotropicMaterial
from wroll_fem.case.mesh import Mesh
from wroll_fem.case.modal import Modal
from wroll_fem.case.output import Output
from wroll_fem.case.preload import Preload
from wroll_fem.case.roll import RollSections
from wroll_fem.case.schema import schema_text
from wroll_fem.case.solver import Solver
from wroll_fem.case.structural import OnRoll, OnStructure, StructuralCase
from wroll_fem.case.winding import Winding

__all__ = [
    "ANALYSES", "Backbone", "BackboneCase", "Case", "ChirpExcitation", "Coil", "Contact", "DesignMapCase",
    "DwellCase", "DwellExcitation", "Excitation", "Friction", "Geometry", "Harmonic", "HarmonicCase", "HistoryCase",
    "Integrator", "IsotropicMaterial", "Mandrel", "Mesh", "Modal", "ModalCase", "ModalTransientCase", "Normal",
    "OnRoll", "OnStructure", "Output", "Preload", "PreloadCase", "RandomCase", "RandomResponseCase", "RollSections",
    "Section", "ShockCase", "SizingCase", "SlipDampingCase", "Solver", "StructuralCase", "SweepCase", "TwoDofCase",
    "Winding", "WindingCase", "build_case", "example_case", "load_case", "schema_text",
]  # fmt: skip
