"""Fake evidence for the judges of `wroll reproduce`: given results in place of runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from reproduction import Evidence, Verdict
from reproduction.reproduce import claim_groups
from wroll_fem.jobs.grid import Member
from wroll_fem.plotting.study import StudyCase


def judges(*chapters: str) -> dict[str, Callable[[Evidence], Verdict]]:
    """Judges of some chapters by claim."""
    return {name: one for chapter in chapters for f in claim_groups(chapter) for name, one in f.judges.items()}


class FakeEvidence(Evidence):
    """Evidence with given studies and summaries (by name) and results (function of config, override, ...)."""

    def __init__(
        self,
        folder: Path,
        studies: Mapping[str, list[StudyCase]] | None = None,
        summaries: Mapping[str, dict] | None = None,
        answer: Callable[..., xr.Dataset] | None = None,
    ) -> None:
        super().__init__(folder, workers=1)
        self.given, self.summaries, self.answer = dict(studies or {}), summaries or {}, answer

    def study(self, name: str) -> list[StudyCase]:
        return self.given[name]

    def finished(self, name: str) -> tuple[list[StudyCase], list[Member]]:
        return self.given[name], []

    def summary(self, study: str, member: StudyCase) -> dict:
        return self.summaries[member.name]

    def results(self, cases: Sequence[Sequence[str]]) -> list[xr.Dataset]:
        assert self.answer is not None
        return [self.answer(*words) for words in cases]

    def kept(self, name: str, compute: Callable[[], xr.Dataset], **inputs: object) -> xr.Dataset:
        return xr.Dataset({"shear_modulus": 700.0})


def bending_at(frequency: float, **more: object) -> xr.Dataset:
    """Modal results: torsion at 20 Hz, bending at a frequency, axial shear far above; rising."""
    modes = sorted(
        [
            (20.0, "torsion", (1e-9, 0.0, 0.0), 0.0),
            (frequency, "bending", (0.7, 0.0, 0.0), 1.4),
            (5e3, "axial", (0.0, 0.0, 0.6), 0.0),
        ]
    )
    frequencies, kinds, shares, tips = zip(*modes, strict=True)
    data = {
        "mode_frequency": ("mode", list(frequencies)),
        "mode_kind": ("mode", list(kinds)),
        "effective_mass_fraction": (("mode", "component"), np.array(shares)),
        "tip_participation": ("mode", list(tips)),
    }
    return xr.Dataset(data, coords={"component": ["x", "y", "z"]}, attrs=more)


def member(data: xr.Dataset, name: str = "m", **values: object) -> StudyCase:
    return StudyCase(name, {key.replace("__", "."): value for key, value in values.items()}, data)


def reference(data: xr.Dataset) -> StudyCase:
    return StudyCase("reference", {}, data, reference=True)
