"""A solid coil so soft that most of the mass moves in a mode of its own, computed as users do."""

from __future__ import annotations

import re

import numpy as np
import pytest
import xarray as xr
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.case import build_case
from wroll_fem.progress import SilentProgress

COARSE = (
    "mesh={circumferential: 8, axial: 6, radial: 2, grading: 8}", "harmonic.harmonics=3",
    "preload={kind: winding_stress, pressure: 2.0e+5}",
)  # fmt: skip
SOFT = (
    "coil.material={kind: cylindrical_orthotropic, E_theta: 5.0e9, E_r: 1.0e6, nu_theta_z: 0.3, nu_theta_r: 0, "
    "nu_z_r: 0, G_r_theta: 1.0e6, G_r_z: 1.0e6, rho: 265.3}"
)
"""Soft between its wraps, in shear and in compression: a coil soft in shear alone moves sideways with the mandrel."""


def modes_of(case: wf.Case) -> xr.Dataset:
    """Modes of the whole roll with sticking interfaces, by the other eigensolver."""
    sections = case.resolved() | {"analysis": "modal", "modal": {"interface": "stuck", "count": 60}}
    return wf.run(
        build_case({k: v for k, v in sections.items() if k not in ("excitation", "harmonic")}), progress=False
    )


@pytest.mark.parametrize(("band", "level"), [((240, 340), 0.5), pytest.param((10, 30), 0.1, marks=pytest.mark.slow)])
def test_a_coil_that_moves_by_itself_is_told_of_with_the_mode_that_is_followed(
    band: tuple[int, int], level: float
) -> None:
    """One band is around the bending of the mandrel, in which this coil hardly moves, the other around its own mode.

    In its own mode the coil lifts off nearly everywhere at 0.5 g: 0.1 g keep it closed.
    """
    excitation = (f"f_start={band[0]}", f"f_end={band[1]}", f"amplitude_g={level}")
    changes = [*COARSE, SOFT, *(f"excitation.{entry}" for entry in excitation)]
    case = wf.load_case(CONFIGS / "sspp_friction.yaml", changes)
    progress = SilentProgress()
    found = wf.run(case, progress=progress)
    [told] = [text for text in progress.warnings if "the base excites a mode at" in text]
    assert told in found.attrs["warnings"]
    modes = modes_of(case)
    frequency, mass = modes["mode_frequency"].values, modes["effective_mass_fraction"].sel(component="x").values
    tip = np.abs(modes["tip_participation"].values)
    most, main = int(mass.argmax()), int(tip.argmax())
    followed = int(np.where((frequency > band[0]) & (frequency < band[1]), tip, 0.0).argmax())
    named = re.search(
        r"at ([\d.]+) Hz most \((\d+) % .* in the mode at ([\d.]+) Hz .* f_n and zeta follow the mode at ([\d.]+) Hz",
        told,
    )
    assert named is not None
    other, share, own, read = map(float, named.groups())
    assert other == pytest.approx(frequency[most], rel=1e-3)
    assert share == pytest.approx(100.0 * mass[most], abs=1.0)
    assert share > 75.0
    assert own == pytest.approx(frequency[main], rel=1e-3)
    assert read == pytest.approx(frequency[followed], rel=1e-3)
    assert found.attrs["f_n_hz"] == pytest.approx(read, rel=0.04)  # slip lowers it
    assert found.attrs["stuck_resonance_hz"] == pytest.approx(frequency[followed], rel=1e-3)
    assert found.attrs["tip_participation"] == pytest.approx(tip[followed], rel=1e-2)
    assert other < 0.1 * own


def test_the_shipped_coil_bends_with_its_mandrel_and_nothing_is_told() -> None:
    progress = SilentProgress()
    found = wf.run(wf.load_case(CONFIGS / "sspp_friction.yaml", COARSE), progress=progress)
    assert not [text for text in progress.warnings if "the base excites a mode" in text or "soft between" in text]
    assert "the base excites a mode" not in found.attrs["warnings"]
    assert found.attrs["peak_transmissibility"] > 5.0
