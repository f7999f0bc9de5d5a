"""A wound roll in Python: the sections that all its analyses share, and one method per analysis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Self

from wroll_fem.case import Case
from wroll_fem.case.coil import Coil
from wroll_fem.case.contact import Contact
from wroll_fem.case.design_map import DesignMap
from wroll_fem.case.excitation import ChirpExcitation, DwellExcitation, SineExcitation
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.harmonic import Backbone, Harmonic
from wroll_fem.case.integrator import Integrator
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.mesh import Mesh
from wroll_fem.case.modal import Modal
from wroll_fem.case.output import Output
from wroll_fem.case.preload import Preload
from wroll_fem.case.probes import ProbePoint
from wroll_fem.case.solver import Solver
from wroll_fem.case.winding import Winding
from wroll_fem.result import Result, ShowProgress, run_case


@dataclass(frozen=True, kw_only=True)
class Roll:
    """A web wound on a mandrel.

    Each attribute is a section of the case file, with the same keys, units and checks; `case` shows the YAML.

    Attributes
    ----------
    geometry, mandrel, coil
        The mandrel's tube, its material and end conditions, and the model of the wound web.
    contact, preload
        Friction and normal contact between the layers, and what presses them together. Needed with layers.
    winding
        How the roll was wound: needed for `run_winding`, for slip of a solid coil, and for a preload by tension.
    probes
        Points whose motion the results hold, by name; the tip is always one.
    mesh
        Element counts, or a mesh file.

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
            When the case describes no roll (matrices, two masses, wound-roll stress alone).
        """
        from wroll_fem.errors import InputError

        given = {f.name: getattr(case, f.name) for f in fields(cls) if f.name in case.model_fields_set}
        missing = [name for name in ("geometry", "mandrel", "coil") if name not in given]
        if missing:
            remedy = "use a case with geometry, mandrel and coil"
            raise InputError("the case describes no roll", key=missing[0], remedy=remedy)
        return cls(**given)

    def replace(self, **sections: Any) -> Self:
        """Return a copy with other sections, for example ``roll.replace(preload=wf.Preload(pressure=1e5))``."""
        return replace(self, **sections)

    def case(self, analysis: str, **sections: Any) -> Case:
        """Return the case of an analysis of this roll; `case.resolved_yaml()` is its case file.

        Parameters
        ----------
        analysis
            Name as in the case file.
        sections
            Further sections, as models or dicts; None leaves a section at its default.

        Raises
        ------
        InputError
            One line that names key, value and remedy.
        """
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        given = {name: section for name, section in (own | sections).items() if section is not None}
        return Case(analysis=analysis, **given)

    def run(
        self, analysis: str, *, out: str | Path | None = None, progress: ShowProgress = None, **sections: Any
    ) -> Result:
        """Run any analysis of this roll by name; see `case` and `wroll_fem.run`."""
        return run_case(self.case(analysis, **sections), out=out, progress=progress)

    def run_sweep(
        self,
        excitation: ChirpExcitation,
        *,
        integrator: Integrator | None = None,
        solver: Solver | None = None,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Sweep through resonance in time: transmissibility, f_n, zeta, slip map, energy ledger."""
        return self.run(
            "sweep", excitation=excitation, integrator=integrator, solver=solver, output=output, out=out,
            progress=progress,
        )  # fmt: skip

    def run_dwell(
        self,
        excitation: DwellExcitation,
        *,
        integrator: Integrator | None = None,
        solver: Solver | None = None,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Vibrate at one frequency in time: history, slip map, energy ledger."""
        return self.run(
            "dwell", excitation=excitation, integrator=integrator, solver=solver, output=output, out=out,
            progress=progress,
        )  # fmt: skip

    def run_harmonic(
        self,
        excitation: ChirpExcitation,
        *,
        harmonic: Harmonic | None = None,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Steady response over a band of frequencies by harmonic balance; the sweep rate is not used."""
        return self.run("harmonic", excitation=excitation, harmonic=harmonic, output=output, out=out, progress=progress)

    def run_backbone(
        self,
        backbone: Backbone | None = None,
        *,
        harmonic: Harmonic | None = None,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Frequency and damping of the resonance over its amplitude."""
        return self.run("backbone", backbone=backbone, harmonic=harmonic, output=output, out=out, progress=progress)

    def run_modal(
        self,
        modal: Modal | None = None,
        *,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Natural frequencies and mode shapes."""
        return self.run("modal", modal=modal, output=output, out=out, progress=progress)

    def run_preload(self, *, out: str | Path | None = None, progress: ShowProgress = None) -> Result:
        """Static contact state of the preloaded layers: interface pressure and friction traction."""
        return self.run("preload", out=out, progress=progress)

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
        """Response of a solid coil to a sine at several levels, its shear stress, and where it would slip."""
        return self.run(
            "modal_transient", excitation=excitation, damping_ratio=damping_ratio, modal=modal, output=output, out=out,
            progress=progress,
        )  # fmt: skip

    def run_design_map(
        self, design_map: DesignMap, *, out: str | Path | None = None, progress: ShowProgress = None
    ) -> Result:
        """Frequency bounds of a solid coil over radius and wall of the mandrel."""
        return self.run("design_map", design_map=design_map, out=out, progress=progress)
