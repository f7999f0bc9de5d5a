"""Examples of other harmonic-balance programs, unchanged in physics: first harmonics to 1e-3 of the peak.

`peers.json` holds points of the curves that these programs computed, with the version and the example of each.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import wroll_fem as wf
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance, solve_motion
from wroll_fem.dynamics.periodic.response import response_curve
from wroll_fem.dynamics.reduction.condensation import condense
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.typing import FloatArray

PEERS = json.loads((Path(__file__).parent / "peers.json").read_text(encoding="utf-8"))
J = wf.joints

CHAIN = [
    J.Jenkins(at=0, stiffness=20.0, limit=1.0), J.Jenkins(at=(1, 0), stiffness=20.0, limit=1.0),
    J.Spring(at=1, coefficients=(0.0, 0.0, 1.0), length=0.1),
    J.Spring(at=(2, 1), coefficients=(0.0, 0.0, 1.0), length=0.1),
    J.Gap(at=2, stiffness=1.0, gap=0.25),
]  # fmt: skip

STRUCTURES = {
    "pyHarm": lambda: wf.structure(
        [[680.0, -40.0], [-40.0, 40.0]], [[1.0, 0.0], [0.0, 0.02]], [J.Jenkins(at=1, stiffness=200.0, limit=5.0)],
        damping=[[0.1, -0.05], [-0.05, 0.05]], force={0: 1.0},
    ),
    "NLvib": lambda: wf.structure(
        [[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]], np.eye(3), CHAIN,
        damping=0.02 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]]), force={1: 1.0},
    ),
    "tmdsimpy Iwan": lambda: wf.structure(
        [[0.75]], [[1.0]], [J.Iwan(at=0, stiffness=0.25, limit=0.2, chi=-0.5)], damping=[[0.01]], force={0: 0.1}
    ),
    "tmdsimpy friction": lambda: wf.structure(
        np.diag([12.0, 21.0]), np.eye(2),
        [J.Coulomb(at=0, normal=[0.0, -1.0], stiffness=5.0, normal_stiffness=21.0, mu=0.85, normal_force=50.0)],
        damping=np.diag([0.34641016151377546, 2.0]), force={0: 100.0, 1: 10.0},
    ),
    "tmdsimpy Duffing": lambda: wf.structure(
        [[1.0]], [[1.0]], [J.Spring(at=0, coefficients=(0.0, 0.0, 1.0), length=1.0)], damping=[[0.01]], force={0: 1.0}
    ),
}  # fmt: skip


def contact_of(name: str) -> tuple[HarmonicContact, FloatArray]:
    """Contact of the structure, and the displacements (n, m) per reduced coordinate."""
    own = STRUCTURES[name]()
    condensation = condense(own.system, stick_springs(own.system, own.rest), Scheme.hht(0.0), 1e-3)
    model = ReducedModel.complete(condensation)
    sampling = Sampling(PEERS[name]["harmonics"], PEERS[name]["samples"])
    shapes = np.array([condensation.displacement(unit) for unit in np.eye(model.size)]).T @ model.vectors
    return HarmonicContact(model, own.rest, own.system.laws, sampling), shapes


@pytest.mark.parametrize("name", STRUCTURES)
def test_first_harmonics_are_those_of_the_peer(name: str) -> None:
    """From the first harmonic of the peer as the initial guess, so that the same of two branches is found."""
    contact, shapes = contact_of(name)
    balance, inverse, peer = HarmonicBalance(contact, 1.0), np.linalg.inv(shapes), PEERS[name]
    for frequency, parts in zip(peer["frequency_rad_s"], peer["first_harmonic"], strict=True):
        wanted = np.array(parts) @ [1.0, 1.0j]
        guess = np.zeros((contact.sampling.size, len(wanted)))
        guess[1], guess[2] = inverse @ wanted.real, -inverse @ wanted.imag
        motion = solve_motion(balance, frequency, guess)
        found = shapes @ (motion[1] - 1j * motion[2])
        np.testing.assert_allclose(found, wanted, atol=1e-3 * max(peer["peak"]), err_msg=f"{frequency} rad/s")


@pytest.mark.parametrize(
    ("name", "band"), [("pyHarm", (24.0, 27.5)), ("NLvib", (0.5, 2.0)), ("tmdsimpy friction", (0.2, 6.0))]
)
def test_peaks_of_own_curves_are_those_of_the_peer(name: str, band: tuple[float, float]) -> None:
    """The curve followed by the program itself, past the fold of the chain."""
    contact, shapes = contact_of(name)
    curve = response_curve(contact, amplitude=1.0, frequencies=(band[0] / (2 * np.pi), band[1] / (2 * np.pi)))
    found = [float(np.abs(curve.fundamental(row)).max()) for row in shapes]
    np.testing.assert_allclose(found, PEERS[name]["peak"], rtol=2e-3)
