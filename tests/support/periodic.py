"""Small systems and rolls for the tests of periodic motions."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np

from support.paths import CONFIGS
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.case import load_case
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.condensation import Condensation, condense
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.training.enrichment import trained_response
from wroll_fem.dynamics.training.training import Trained

LAB = CONFIGS / "lab_harmonic.yaml"
TURN = 2.0 * np.pi


def complete(system: System) -> tuple[ReducedModel, ContactState]:
    """Every mode of a small system, and its preload state."""
    preload = solve_preload(system)
    springs = stick_springs(system, preload)
    return ReducedModel.complete(condense(system, springs, Scheme.hht(0.0), 1e-3)), preload


def balance(system: System, acceleration: float, harmonics: int = 3, samples: int = 64) -> HarmonicBalance:
    model, preload = complete(system)
    return HarmonicBalance(HarmonicContact(model, preload, system.laws, Sampling(harmonics, samples)), acceleration)


def with_friction(system: System, law: object) -> System:
    parts = [dataclasses.replace(interface, friction=law) for interface in system.interfaces]
    return dataclasses.replace(system, interfaces=tuple(parts))


def largest(coefficients: np.ndarray, row: np.ndarray) -> float:
    """Largest value of a Fourier series (R, m) read by ``row``."""
    harmonics = (len(coefficients) - 1) // 2
    fine = Sampling(harmonics, 4000)
    return float((fine.values @ coefficients @ row).max())


@cache
def small_roll(
    around: int, along: int, *overrides: str, mirrored: bool = True
) -> tuple[System, ContactState, Condensation]:
    mesh = f"mesh={{circumferential: {around}, axial: {along}, grading: 3}}"
    case = load_case(LAB, [mesh, *overrides])
    system = build_system(case, build_bodies(case, symmetric=mirrored))
    preload = solve_preload(system)
    return system, preload, condense(system, stick_springs(system, preload), Scheme.hht(0.0), 1e-4)


@cache
def trained_roll(around: int, along: int) -> Trained[HarmonicCurve]:
    """Curve of `small_roll` at 5 m/s^2 around its resonance, with the defaults of the training."""
    system, preload, condensation = small_roll(around, along)
    return trained_response(condensation, preload, system.laws, amplitude=5.0, frequencies=(140.0, 165.0))
