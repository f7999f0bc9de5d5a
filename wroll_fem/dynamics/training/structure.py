"""Whole structure with its contact, from which a training makes reduced models and their contacts."""

from __future__ import annotations

from dataclasses import dataclass, replace

from wroll_fem.contact.laws import PointLaws
from wroll_fem.dynamics.aft.every_mode import ModeMaps
from wroll_fem.dynamics.aft.half_period import HalfPeriod
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.evaluated_points import PointSample
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.training.basis import first_model


@dataclass(frozen=True)
class Structure:
    """Whole structure with its contact, from which reduced models and their contacts are made.

    Attributes
    ----------
    condensation, preload, laws : modes, state to which motions are relative, friction laws of the contact points
    sampling : harmonics and samples
    max_periods : largest number of periods until the hysteresis is periodic
    symmetry : half-period symmetry; None without symmetry
    maps : maps of all modes, shared by all contacts of the structure
    """

    condensation: Condensation
    preload: ContactState
    laws: PointLaws
    sampling: Sampling
    max_periods: int
    symmetry: HalfPeriod | None
    maps: ModeMaps

    @classmethod
    def of(
        cls, condensation: Condensation, preload: ContactState, laws: PointLaws, sampling: Sampling, max_periods: int
    ) -> Structure:
        """Structure with its half-period symmetry, if it has one."""
        symmetry = None if sampling.odd else HalfPeriod.of(condensation, preload, laws)
        return cls(condensation, preload, laws, sampling, max_periods, symmetry, ModeMaps(condensation, symmetry))

    def contact(
        self, model: ReducedModel, *, sample: PointSample | None = None, tangent: PointSample | None = None
    ) -> HarmonicContact:
        """Periodic contact of a reduced model of this structure; for ``sample``, ``tangent`` see `HarmonicContact`."""
        return HarmonicContact(
            model, self.preload, self.laws, self.sampling, max_periods=self.max_periods, symmetry=self.symmetry,
            sample=sample, tangent=tangent, maps=self.maps,
        )  # fmt: skip

    def with_harmonics(self, most: int) -> Structure:
        """The same structure, with motions of at most ``most`` harmonics."""
        s = self.sampling
        return self if s.harmonics <= most else replace(self, sampling=Sampling(most, s.samples, odd=s.odd))

    def first_model(self) -> ReducedModel:
        """Reduced model to start from."""
        return first_model(self.condensation, self.contact, self.symmetry)
