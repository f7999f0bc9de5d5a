"""The case file: one module per section, a loader and a generated JSON schema."""

from __future__ import annotations

from .base import Section
from .case import ANALYSES, RESUMABLE, Case
from .coil import Coil
from .contact import Contact, Friction, Normal
from .example import example_case
from .excitation import ChirpExcitation, DwellExcitation, Excitation
from .geometry import Geometry
from .harmonic import Backbone, Harmonic
from .integrator import Integrator
from .loader import build_case, load_case
from .mandrel import Mandrel
from .material import IsotropicMaterial
from .mesh import Mesh
from .modal import Modal
from .output import Output
from .preload import Preload
from .schema import schema_text
from .solver import Solver
from .winding import Winding

__all__ = [
    "ANALYSES", "RESUMABLE", "Backbone", "Case", "ChirpExcitation", "Coil", "Contact", "DwellExcitation", "Excitation",
    "Friction", "Geometry", "Harmonic", "Integrator", "IsotropicMaterial", "Mandrel", "Mesh", "Modal", "Normal",
    "Output", "Preload", "Section", "Solver", "Winding", "build_case", "example_case", "load_case", "schema_text",
]  # fmt: skip
