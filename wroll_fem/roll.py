"""Wound roll in Python: case sections shared by all analyses, and a method per analysis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Self

from wroll_fem.case import Case
from wroll_fem.case.coil import Coil
from wroll_fem.case.contact import Contact
from wroll_fem.case.design_map import DesignMap
from wroll_fem.case.excitation import SineExcitation
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.mesh import Mesh
from wroll_fem.case.modal import Modal
from wroll_fem.case.output import Output
from wroll_fem.case.preload import Preload
from wroll_fem.case.probes import ProbePoint
from wroll_fem.case.winding import Winding
from wroll_fem.result import Result, ShowProgress
from wroll_fem.runs import Runs


@dataclass(frozen=True, kw_only=True)
class Roll(Runs):
    """Web wound on a mandrel, with a method per analysis.

    Each attribute is a case section with the keys, units and checks of the case file.

    Attributes
    ----------
    geometry, mandrel, coil
        Tube of the mandrel, its material and end conditions, and the model of the wound web.
    contact, preload
        Friction and normal contact between the layers, and their pressure; required with layers.
    winding
        Winding of the roll; required for `run_winding`, slip of a solid coil, and preload by winding tension.
    probes
        Named points whose motion the results contain; the tip is always included.
    mesh
        Numbers of elements, or a mesh file.

    Examples
    --------
    >>> import wroll_fem as wf
    >>> roll = wf.Roll(
    ...     geometry=wf.Geometry(length=0.300, mandrel_outer_diameter=0.080, mandrel_thickness=1.5e-3),
    ...     mandrel=wf.Mandrel(material=wf.IsotropicMaterial(E=2.7e9, nu=0.35, rho=1200), tip_mass=0.05),
    ...     coil=wf.Coil(
    ...         model="layers", total_thickness=1.25e-3, material=wf.IsotropicMaterial(E=2.8e9, nu=0.35, rho=2000)
    ...     ),
    ...     contact=wf.Contact(friction=wf.PenaltyFriction(mu=0.25, elastic_slip=1e-6)),
    ...     preload=wf.Preload(pressure=3e4),
    ...     mesh=wf.Mesh(circumferential=12, axial=4),
    ... )
    >>> roll.case("preload").analysis
    'preload'
    """

    geometry: Geometry
    mandrel: Mandrel
    coil: Coil
    contact: Contact | None = None
    preload: Preload | None = None
    winding: Winding | None = None
    probes: Mapping[str, ProbePoint] | None = None
    mesh: Mesh = field(default_factory=Mesh)

    @classmethod
    def from_case(cls, case: Case) -> Self:
        """Return the roll of a case.

        Raises
        ------
        InputError
            If the case does not describe a roll (matrices from a file, two_dof, some winding cases).
        """
        from wroll_fem.errors import InputError

        given = {f.name: getattr(case, f.name) for f in fields(cls) if f.name in case.model_fields_set}
        missing = [name for name in ("geometry", "mandrel", "coil") if name not in given]
        if missing:
            remedy = "use a case with geometry, mandrel and coil"
            raise InputError("the case does not describe a roll", key=missing[0], remedy=remedy)
        return cls(**given)

    def replace(self, **sections: Any) -> Self:
        """Return a copy with changed case sections, for example ``roll.replace(preload=wf.Preload(pressure=1e5))``."""
        return replace(self, **sections)

    def own_sections(self) -> dict[str, Any]:
        """Return the case sections of this roll."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def run_buckling(
        self,
        modal: Modal | None = None,
        *,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Compute the load factors at which the preload makes the roll buckle, and the buckling modes.

        Parameters
        ----------
        modal, output
            Case sections; None gives the default. `modal` sets the number of modes and the interface springs.
        out, progress
            As of `wroll_fem.run`.
        """
        return self.run("buckling", modal=modal, output=output, out=out, progress=progress)

    def run_modal_transient(
        self,
        excitation: SineExcitation,
        *,
        damping_ratio: float,
        modal: Modal | None = None,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Compute steady response, shear stress and slip zone of a solid coil at several excitation levels.

        Parameters
        ----------
        excitation, modal, output
            Case sections; None gives the default.
        damping_ratio
            Damping ratio of every mode.
        out, progress
            As of `wroll_fem.run`.
        """
        return self.run(
            "modal_transient", excitation=excitation, damping_ratio=damping_ratio, modal=modal, output=output, out=out,
            progress=progress,
        )  # fmt: skip

    def run_slip_damping(
        self,
        excitation: SineExcitation,
        *,
        damping_ratio: float,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Compute frequency and damping of a solid coil whose wraps slide versus amplitude; needs `inside: slipping`.

        Parameters
        ----------
        excitation, output
            Case sections; None gives the default.
        damping_ratio
            Damping ratio without slip.
        out, progress
            As of `wroll_fem.run`.
        """
        return self.run(
            "slip_damping", excitation=excitation, damping_ratio=damping_ratio, output=output, out=out,
            progress=progress,
        )  # fmt: skip

    def run_design_map(
        self, design_map: DesignMap, *, out: str | Path | None = None, progress: ShowProgress = None
    ) -> Result:
        """Compute the bending frequency with softest and with stiffest coil for each radius and wall of the mandrel.

        Parameters
        ----------
        design_map
            Case section with mandrels and softest coil.
        out, progress
            As of `wroll_fem.run`.
        """
        return self.run("design_map", design_map=design_map, out=out, progress=progress)
