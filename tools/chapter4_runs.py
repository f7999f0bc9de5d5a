"""Finished studies of chapter 4, and what its claims measure on them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.grid import REFERENCE, load_grid
from wroll_fem.plotting.convergence import first_bending
from wroll_fem.plotting.study import PRESSURE, SeriesMember, is_sweep
from wroll_fem.results import load_dataset
from wroll_fem.run_folder import RunFolder
from wroll_fem.slip import slipping_area_fraction, surface

ROOT = Path(__file__).resolve().parents[1]
STUDIES = ROOT / "configs" / "studies"
PRELOAD_STUDY = {"free": "preload", "clamped": "preload_clamped"}
SLACK = 0.005
"""Share of the range that a monotone series may go the other way: numerical noise."""


@dataclass(frozen=True)
class Verdict:
    """Outcome of one claim: our value in words, and whether the criterion holds (None: open)."""

    value: str
    holds: bool | None
    word: str = ""

    def text(self) -> str:
        """Verdict as the claims list spells it."""
        if self.word:
            return self.word
        return "open" if self.holds is None else "met" if self.holds else "not met"


class Runs:
    """Finished cases of the studies, loaded once; a study that is not there raises InputError."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._kept: dict[str, list[SeriesMember]] = {}

    def study(self, name: str) -> list[SeriesMember]:
        """Finished cases of a study, in the order of its grid file."""
        if name not in self._kept:
            found = []
            for m in load_grid(STUDIES / f"{name}.yaml").members:
                folder = RunFolder(self.folder / name / m.name)
                if folder.status() == "complete" and folder.case_hash() == m.case.hash():
                    data = load_dataset(folder.results_file)
                    found.append(SeriesMember(m.name, m.values, data, reference=m.name == REFERENCE))
            self._kept[name] = found
        if not self._kept[name]:
            raise InputError(f"study {name} has not been run", remedy=f"wroll batch configs/studies/{name}.yaml")
        return self._kept[name]

    def summary(self, study: str, member: SeriesMember) -> dict:
        """Content of summary.json of a case."""
        return RunFolder(self.folder / study / member.name).summary()

    def sweeps(self, base: str) -> list[SeriesMember]:
        """Sweeps over the preload with one base condition, rising preload."""
        study = PRELOAD_STUDY[base]
        found = sorted((m for m in self.study(study) if is_sweep(m)), key=lambda m: m.values[PRESSURE])
        if len(found) < 3:
            raise InputError(f"study {study} has fewer than three sweeps with base {base}", remedy="run it")
        return found

    def one(self, study: str, **wanted: Any) -> SeriesMember:
        """Return the case of a study with these values, keys written with __ for dots; raises InputError without."""
        values = {key.replace("__", "."): value for key, value in wanted.items()}
        for m in self.study(study):
            if not m.reference and all(m.values.get(key) == value for key, value in values.items()):
                return m
        raise InputError(f"study {study} has no finished case with {values}", remedy="run it")

    def mandrel(self) -> SeriesMember:
        """Modal analysis of the mandrel alone."""
        for m in self.study("bounds"):
            if m.reference:
                return m
        raise InputError("the reference of study bounds is not finished", remedy="run it")

    def bound(self, interface: str, base: str) -> float:
        """First bending frequency with the layer bonded or frictionless, Hz."""
        return first_bending(self.one("bounds", modal__interface=interface, coil__base=base))


def kpa(member: SeriesMember) -> str:
    return f"{member.values[PRESSURE] / 1e3:.3g} kPa"


def monotone(values: list[float], sign: int) -> bool:
    """Strictly rising (sign 1) or falling (-1), with the slack of the claims list."""
    return bool(np.all(sign * np.diff(values) > -SLACK * np.ptp(values)))


def rank_correlation(a: list[float], b: list[float]) -> float:
    """Spearman's."""
    ranks = [np.argsort(np.argsort(values)) for values in (a, b)]
    return float(np.corrcoef(*ranks)[0, 1])


def areas(member: SeriesMember) -> np.ndarray:
    """Slipped area of every interface, m^2."""
    total = member.data["area"].values.sum(axis=-1)
    return np.asarray(slipping_area_fraction(member.data).values * total)


def largest(member: SeriesMember) -> tuple[int, float, float, float]:
    """Interface (0 inner), hoop and axial part (m) of the largest relative displacement, angle from the axis (deg)."""
    best = (0, 0.0, 0.0, 0.0)
    for k in range(member.data.sizes["interface"]):
        points = surface(member.data, k, "peak_slip_hoop", "peak_slip_axial")
        hoop, axial = points.values["peak_slip_hoop"], points.values["peak_slip_axial"]
        i = int(np.argmax(np.hypot(hoop, axial)))
        if np.hypot(hoop[i], axial[i]) > np.hypot(best[1], best[2]):
            angle = abs(np.degrees(points.theta[i]))
            best = (k, float(hoop[i]), float(axial[i]), float(min(angle, 180.0 - angle)))
    return best


def tops(member: SeriesMember) -> float:
    """Highest point that slipped, m (0 when none)."""
    slipped = member.data["slipped"].values.astype(bool).any(axis=0)
    return float(member.data["z_m"].values[slipped].max(initial=0.0))
