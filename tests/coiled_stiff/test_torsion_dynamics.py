"""Torsion of a coil whose wraps slide: the quasi-static path against harmonic balance of the shaken coil."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import g as GRAVITY
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.followed_mode import axisymmetric_mode
from wroll_fem.analyses.slip_structure import slipping_structure
from wroll_fem.case import SlipDampingCase, load_case
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.response import response_curve
from wroll_fem.dynamics.reduction.path_modes import path_modes
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import modal_path
from wroll_fem.dynamics.system.modal_damping import ModalDamping
from wroll_fem.numerics.continuation import StepControl

MESH, RATIO = "mesh={circumferential: 8, axial: 8, grading: 20, radial: 2}", 0.02
TOLERANCES = {5.0: (0.015, 1e-3), 20.0: (0.05, 2e-3)}
"""Level in g: tolerance of tip and damping, and of the frequency. The loads keep the shape of the stuck mode; torsion
moves away from it further than bending."""


@pytest.mark.slow  # 40 s: harmonic balance with friction at every point
def test_the_path_has_the_peak_of_harmonic_balance_in_torsion() -> None:
    """Seven harmonics."""
    motion = f"excitation={{kind: sine, frequency: resonance, amplitude_g: {list(TOLERANCES)}, mode: torsion}}"
    case = load_case(CONFIGS / "slipping_coil.yaml", [MESH, motion])
    assert isinstance(case, SlipDampingCase)
    quasi_static = wf.run(case, progress=False)
    _, _, system, start = slipping_structure(case)
    system = replace(system, modal_damping=ModalDamping(table=((1.0, RATIO), (1e7, RATIO))))
    path = LoadPath(system, start)
    modal_path(path, axisymmetric_mode(system, path), np.geomspace(1.0, 12.0, 13))
    contact = HarmonicContact(ReducedModel.complete(path_modes(path)), start, system.laws, Sampling(7, 64))
    for level, (loose, tight) in TOLERANCES.items():
        expected = quasi_static.sel(amplitude_g=level)
        hertz = float(expected["frequency_at_level"])
        band, control = (0.9 * hertz, 1.08 * hertz), StepControl(largest=0.1)
        found = response_curve(contact, amplitude=level * GRAVITY, frequencies=band, control=control)
        tips = np.array([np.hypot(*(q[1:3] @ contact.model.tip)) for q in found.coefficients])
        k = int(np.argmax(tips))
        top = np.polynomial.Polynomial.fit(found.frequencies[k - 1 : k + 2], tips[k - 1 : k + 2], 2)
        peak = float(top.deriv().roots()[0])
        assert float(expected["tip_at_level"]) == pytest.approx(top(peak), rel=loose)
        assert hertz == pytest.approx(peak / (2.0 * np.pi), rel=tight)
        work = found.balance.cycle_work(found.coefficients[k], found.frequencies[k])
        assert work.input == pytest.approx(work.interface + work.viscous, rel=1e-6)
        amplitude = float(np.linalg.norm(found.coefficients[k][1:3, 0]))
        zeta = (work.friction + work.viscous) / (2.0 * np.pi * (found.frequencies[k] * amplitude) ** 2)
        assert float(expected["damping_at_level"]) == pytest.approx(zeta, rel=loose)
