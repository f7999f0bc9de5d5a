"""Methods that run an analysis, shared by rolls and by structures from matrices."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

from wroll_fem.case import Case
from wroll_fem.case.excitation import ChirpExcitation, DwellExcitation, RandomExcitation, ShockExcitation
from wroll_fem.case.harmonic import Backbone, Harmonic
from wroll_fem.case.integrator import Integrator
from wroll_fem.case.modal import Modal
from wroll_fem.case.output import Output
from wroll_fem.case.solver import Solver
from wroll_fem.result import Result, ShowProgress, run_case


class Runs(ABC):
    """Object with cases: a method per analysis."""

    @abstractmethod
    def own_sections(self) -> dict[str, Any]:
        """Return the case sections that describe this object, as models or dicts."""

    def case(self, analysis: str, **sections: Any) -> Case:
        """Return the case of an analysis; `case.resolved_yaml()` is its case file.

        Parameters
        ----------
        analysis
            Value of `analysis` in the case file.
        sections
            Further case sections, as models or dicts; None gives the default.

        Raises
        ------
        InputError
            If the case is invalid; the message names key, value and remedy.
        """
        given = {name: section for name, section in (self.own_sections() | sections).items() if section is not None}
        return Case(analysis=analysis, **given)

    def run(
        self, analysis: str, *, out: str | Path | None = None, progress: ShowProgress = None, **sections: Any
    ) -> Result:
        """Run an analysis by name.

        Parameters
        ----------
        analysis, sections
            As for `case`.
        out, progress
            As of `wroll_fem.run`.
        """
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
        """Compute the time history of a sine sweep: transmissibility, f_n, zeta, slip map, energy ledger.

        Parameters
        ----------
        excitation, integrator, solver, output
            Case sections; None gives the default.
        out, progress
            As of `wroll_fem.run`.
        """
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
        """Compute the time history of a dwell at one frequency: response, slip map, energy ledger.

        Parameters
        ----------
        excitation, integrator, solver, output
            Case sections; None gives the default.
        out, progress
            As of `wroll_fem.run`.
        """
        return self.run(
            "dwell", excitation=excitation, integrator=integrator, solver=solver, output=output, out=out,
            progress=progress,
        )  # fmt: skip

    def run_random(
        self,
        excitation: RandomExcitation,
        *,
        integrator: Integrator | None = None,
        solver: Solver | None = None,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Compute the response to a random motion: spectra, H1, f_n, zeta, rms values, slip map, energy ledger.

        Parameters
        ----------
        excitation, integrator, solver, output
            Case sections; None gives the default.
        out, progress
            As of `wroll_fem.run`.
        """
        return self.run(
            "random", excitation=excitation, integrator=integrator, solver=solver, output=output, out=out,
            progress=progress,
        )  # fmt: skip

    def run_shock(
        self,
        excitation: ShockExcitation,
        *,
        integrator: Integrator | None = None,
        solver: Solver | None = None,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Compute the response to a shock: peaks, shock response spectra, frequency and damping of the decay.

        Parameters
        ----------
        excitation, integrator, solver, output
            Case sections; None gives the default.
        out, progress
            As of `wroll_fem.run`.
        """
        return self.run(
            "shock", excitation=excitation, integrator=integrator, solver=solver, output=output, out=out,
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
        """Compute the steady response versus frequency by harmonic balance; the sweep rate is not used.

        Parameters
        ----------
        excitation, harmonic, output
            Case sections; None gives the default.
        out, progress
            As of `wroll_fem.run`.
        """
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
        """Compute frequency and damping of the resonance versus amplitude.

        Parameters
        ----------
        backbone, harmonic, output
            Case sections; None gives the default.
        out, progress
            As of `wroll_fem.run`.
        """
        return self.run("backbone", backbone=backbone, harmonic=harmonic, output=output, out=out, progress=progress)

    def run_modal(
        self,
        modal: Modal | None = None,
        *,
        output: Output | None = None,
        out: str | Path | None = None,
        progress: ShowProgress = None,
    ) -> Result:
        """Compute natural frequencies and mode shapes.

        Parameters
        ----------
        modal, output
            Case sections; None gives the default.
        out, progress
            As of `wroll_fem.run`.
        """
        return self.run("modal", modal=modal, output=output, out=out, progress=progress)

    def run_preload(self, *, out: str | Path | None = None, progress: ShowProgress = None) -> Result:
        """Compute the static preload: interface pressure and friction traction."""
        return self.run("preload", out=out, progress=progress)
