"""One block of a slipping coil under cyclic shear: stiffness, limit and loop area, in time and in harmonic balance.

The block is a cube with eight quadrature points of equal shear. It carries a mass so heavy that friction does not
change its motion, which is therefore prescribed by the base acceleration.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.typing import NDArray

from wroll_fem.coiled_stiff.shear_points import ShearPoints
from wroll_fem.coiled_stiff.slipping_coil import shear_interface
from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.dynamics.reduction.condensation import condense
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import FRICTION
from wroll_fem.dynamics.time_stepping.simulate import make_stepper
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions

SIDE, WRAP, G, P, MU = 1e-3, 1e-4, 1e7, 1e5, 0.3  # m, m, Pa, Pa
LIMIT = MU * P
ELASTIC = LIMIT / G * SIDE  # displacement of the upper face at first slip, m
ALONG = np.array([0.6, 0.8])  # direction of the motion: hoop and axial share
HEAVY = 1e12  # kg; friction carries 0.03 N
EXACT = 1e-10


def block() -> tuple[System, ContactState]:
    """The upper face moves in the hoop and in the axial direction."""
    strain = np.tile(np.eye(2) / SIDE, (8, 1))
    points = ShearPoints(np.tile([0.1, 0.0, 1.0], (8, 1)), np.full(8, SIDE**3 / 8.0), sp.csr_matrix(strain))
    pressure = np.full(8, P)
    interface = shear_interface(points, points.strain, shear_modulus=G, pressure=pressure, mu=MU, wrap_thickness=WRAP)
    none, mass = sp.csr_matrix((2, 2)), HEAVY * sp.identity(2, format="csr")
    system = System(none, mass, ALONG, (interface,), {"tip": ALONG})
    return system, ContactState.pressed(system, pressure)


def accelerations(places: NDArray, dt: float) -> NDArray:
    """Base acceleration with which the trapezoidal rule moves a free mass through ``places`` (k,), m, from rest."""
    found, velocity = [0.0], 0.0
    for before, after in pairwise(places):
        found.append(4.0 * (after - before - dt * velocity) / dt**2 - found[-1])
        velocity += 0.5 * dt * (found[-2] + found[-1])
    return -np.array(found)


def loop_area(amplitude: float) -> float:
    """Work of a cycle of the face between -amplitude and amplitude, J: 4 mu P (X - X_0) times the area of the face."""
    return 4.0 * LIMIT * SIDE**2 * max(amplitude - ELASTIC, 0.0)


def loop(places: NDArray) -> NDArray:
    """(k,) shear stress of the face at ``places`` (k,), m, along a path from rest, Pa: stiffness G, limit mu P."""
    tau = [0.0]
    for before, after in pairwise(places):
        tau.append(float(np.clip(tau[-1] + G * (after - before) / SIDE, -LIMIT, LIMIT)))
    return np.array(tau)


@pytest.mark.parametrize("method", ["full", "condensed", "reduced"])
@pytest.mark.parametrize("slips_at", [None, 3, 8, 12])
def test_in_time(method: str, slips_at: int | None) -> None:
    """Half cosines of 16 steps; after a turn, slip begins at the end of the step ``slips_at``, or never."""
    phase, dt = np.pi * np.arange(17) / 16.0, 1e-4
    amplitude = 0.9 * ELASTIC if slips_at is None else 2.0 / (1.0 - np.cos(phase[slips_at])) * ELASTIC
    start, back = 0.5 * amplitude * (1.0 - np.cos(phase)), amplitude * np.cos(phase[1:])
    places = np.concatenate([start, back, -back, back, -back])
    system, state = block()
    options = NewtonOptions(tolerance=1e-13)
    run = make_stepper(system, state, method=method, scheme=Scheme.named("no_damping"), options=options, dt=dt)
    base, records, shear = accelerations(places, dt), [], []
    for k in range(len(places) - 1):
        records.append(run.advance(base[k : k + 2], dt, k * dt)[0])
        np.testing.assert_allclose(  # the motion is the prescribed one
            tangentials(run.jump) / WRAP * SIDE, np.tile(places[k + 1] * ALONG, (8, 1)), atol=EXACT * amplitude
        )
        tau = tangentials(run.traction)
        assert np.ptp(tau, axis=0).max() <= EXACT * LIMIT
        np.testing.assert_allclose(tau @ (-ALONG[1], ALONG[0]), 0.0, atol=EXACT * LIMIT)
        shear.append(float(tau[0] @ ALONG))
    np.testing.assert_allclose(shear, loop(places)[1:], atol=EXACT * LIMIT)
    friction = np.array(records)[:, FRICTION]
    assert friction[-1] - friction[-33] == pytest.approx(
        loop_area(amplitude), rel=EXACT, abs=EXACT * loop_area(2 * ELASTIC)
    )


@pytest.mark.parametrize("slips_at", [None, 6, 16, 24])
def test_in_harmonic_balance(slips_at: int | None) -> None:
    """A cosine with 64 samples; after a turn, slip begins at the sample ``slips_at``, or never."""
    samples = 64
    turn = 2.0 * np.pi * (slips_at or 0) / samples
    amplitude = 0.9 * ELASTIC if slips_at is None else 2.0 / (1.0 - np.cos(turn)) * ELASTIC
    system, state = block()
    model = ReducedModel.complete(condense(system, stick_springs(system, state), Scheme.hht(0.0), 1e-3))
    balance = HarmonicBalance(HarmonicContact(model, state, system.laws, Sampling(3, samples)), 1.0)
    coefficients = np.zeros((7, model.size))
    coefficients[1] = np.linalg.solve(model.jump[:2], amplitude * WRAP / SIDE * ALONG)
    frequency = 10.0
    found = balance.contact.evaluate(balance.contact.motion(coefficients), frequency)
    springs = G / WRAP * found.sampled.motion[:16]
    tau = (springs + found.correction[:16]).reshape(8, 2, samples)
    places = amplitude * np.cos(2.0 * np.pi * np.arange(samples + 1) / samples)
    twice = loop(np.concatenate([[0.0], places, places[1:]]))[-samples - 1 : -1]
    np.testing.assert_allclose(tau, np.broadcast_to(np.outer(ALONG, twice), tau.shape), atol=EXACT * LIMIT)
    work = balance.cycle_work(coefficients, frequency)
    assert work.friction == pytest.approx(loop_area(amplitude), rel=EXACT, abs=EXACT * loop_area(2 * ELASTIC))
