"""Fit of backbones against the finite-element model: friction and elastic slip of a roll that is not in the grid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.lab.fits.backbone_fit import BackboneSettings, fit_backbones, read_backbones
from wroll_fem.lab.fits.family_file import Resonance

COARSE = [
    "mesh.circumferential=8", "mesh.axial=2", "mesh.grading=1", "output.figures=false", "output.fields=none",
    "harmonic.harmonics=1", "harmonic.samples=32", "damping.modal=0.005",
]  # fmt: skip


def backbone(folder: Path, pressure: float, slip: float) -> None:
    changes = [*COARSE, f"preload.pressure={pressure}", f"contact.friction.elastic_slip={slip}"]
    wf.run(wf.load_case(CONFIGS / "lab_backbone.yaml", changes), out=folder / f"{pressure:g}", progress=False)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # a coarse mesh
def test_a_roll_between_the_backbones_of_a_grid_gives_its_friction_and_elastic_slip(tmp_path: Path) -> None:
    for pressure in (2.0e4, 4.0e4, 8.0e4):
        backbone(tmp_path / "grid", pressure, 1.0e-6)
    backbone(tmp_path / "roll", 1.0e5, 2.0e-6)
    grid, (roll, *_) = read_backbones(tmp_path / "grid"), read_backbones(tmp_path / "roll", fewest=1)
    family = []
    for amplitude in np.geomspace(2e-5, 4e-4, 8):
        f, base = (float(np.interp(amplitude, roll.amplitude, values)) for values in (roll.frequency, roll.base))
        peak = float(np.sqrt(1.0 + (amplitude * (2.0 * np.pi * f) ** 2 / base) ** 2))
        none = np.ones(2)
        family.append(Resonance("roll", 20.0, "sweep", base, f, 0.001 * f, 0.01, peak, none, none))
    fit = fit_backbones(family, grid, BackboneSettings(grid="", level_error=0.02, frequency_error=0.001))
    assert fit.friction[0] == pytest.approx(roll.stick * roll.slip, rel=0.01)  # interpolation between three backbones
    assert fit.slip == pytest.approx(2.0e-6, rel=0.03)
    assert fit.factor == pytest.approx(1.0, abs=1e-3)
