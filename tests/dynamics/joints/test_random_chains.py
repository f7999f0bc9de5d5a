"""Random chains with random joints (seed 77): harmonic balance against a dwell, and both energy balances."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import wroll_fem as wf
from wroll_fem.own_structure import OwnStructure
from wroll_fem.results.energy import energy_balance_error

J = wf.joints
SEED, SIZE = 77, 1e-3
"""Seed of the generator, and size of the motions, m."""


def random_chain(index: int) -> tuple[OwnStructure, float, float, float]:
    """Chain of 1 to 5 masses with 1 to 3 joints; first frequency with open joints, Hz; level; place of the dwell."""
    rng = np.random.default_rng([SEED, index])
    n = int(rng.integers(1, 6))

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    mass = np.array([between(0.2, 5.0) for _ in range(n)])
    k = np.array([between(2e3, 5e4) for _ in range(n + 1)])
    stiffness = np.diag(k[:n] + np.append(k[1:n], 0.0)) - np.diag(k[1:n], 1) - np.diag(k[1:n], -1)
    lowest = float(np.sqrt(np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(mass, mass)))[0]))
    joints = []
    for _ in range(int(rng.integers(1, 4))):
        i, j = (int(x) for x in rng.integers(0, n, 2))
        at, kt = (i if i == j else (i, j)), between(5e2, 2e4)
        limit = kt * SIZE * between(0.05, 0.8)
        kinds: list[Callable[[], J.Joint]] = [
            lambda at=at, kt=kt, limit=limit: J.Jenkins(at=at, stiffness=kt, limit=limit),
            lambda at=at, kt=kt, limit=limit: J.Iwan(
                at=at, stiffness=kt, limit=limit, chi=rng.uniform(-0.8, 0.5), beta=rng.uniform(0.0, 2.0), sliders=40
            ),
            lambda at=at, kt=kt, limit=limit: J.BoucWen(
                at=at, stiffness=kt, limit=limit, exponent=rng.uniform(1.0, 4.0), unloading=rng.uniform(0.5, 1.0)
            ),
            lambda at=at, kt=kt: J.Spring(at=at, coefficients=(0.0, 0.0, 0.3 * kt / SIZE**2), length=SIZE),
            lambda at=at, kt=kt: J.Gap(
                at=at, stiffness=kt, gap=SIZE * rng.uniform(0.3, 1.2), both=bool(rng.integers(0, 2))
            ),
        ]
        joints.append(kinds[int(rng.integers(0, len(kinds)))]())
    zeta = rng.uniform(0.01, 0.05)
    level = zeta * lowest**2 * SIZE * float(mass.sum())
    chain = wf.structure(stiffness, np.diag(mass), joints, damping=zeta, force={int(rng.integers(0, n)): 1.0})
    return chain, lowest / (2.0 * np.pi), level, float(rng.uniform(0.7, 1.4))


@pytest.mark.parametrize(
    "index", [1, 4, *(pytest.param(i, marks=pytest.mark.slow) for i in (0, 2, 3, *range(5, 40)))]
)  # fmt: skip
def test_a_random_chain_moves_in_a_dwell_as_in_harmonic_balance(
    index: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Tip to 2 %; energy to 1e-6 and 1e-8."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    chain, hertz, level, place = random_chain(index)
    at = place * hertz
    band = wf.Chirp(f_start=0.4 * hertz, f_end=at, rate_oct_per_min=1.0, amplitude=level)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wf.CaseWarning)
        data = chain.run_harmonic(band, harmonic={"harmonics": 7, "samples": 256}).data
        steady = wf.Dwell(frequency=at, cycles=80, ramp_cycles=10, amplitude=level)
        dwell = chain.run_dwell(steady, integrator={"steps_per_cycle": 160})
    assert data.attrs["energy_balance_error"] < 1e-6
    assert energy_balance_error(dwell.data) < 1e-8
    last = float(wf.transmissibility(data)[-1])  # at the frequency of the dwell
    assert dwell.summary["steady_magnitude"] == pytest.approx(last, rel=0.02)
