"""Damping ratios of modes: one number, one per natural frequency, a table over frequency, and loss factors."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from wroll_fem.dynamics.system.modal_damping import ModalDamping

HERTZ = np.array([30.0, 10.0, 10.0, 40.0, 0.0])
VALUES = (2.0 * np.pi * HERTZ) ** 2


@pytest.mark.parametrize(
    ("damping", "expected"),
    [
        (ModalDamping(ratios=(0.01,)), [0.01, 0.01, 0.01, 0.01, 0.0]),
        # the pair at 10 Hz counts as one natural frequency; the rigid motion as none
        (ModalDamping(ratios=(0.03, 0.02)), [0.02, 0.03, 0.03, 0.02, 0.0]),
        (ModalDamping(ratios=(0.03, 0.02, 0.01)), [0.02, 0.03, 0.03, 0.01, 0.0]),
        (ModalDamping(table=((20.0, 0.01), (40.0, 0.03))), [0.02, 0.01, 0.01, 0.03, 0.0]),
    ],
)
def test_ratios_follow_the_order_and_the_frequency_of_the_modes(damping: ModalDamping, expected: list[float]) -> None:
    np.testing.assert_allclose(damping.of_modes(VALUES), expected, rtol=1e-12)


def test_loss_factors_give_half_the_share_of_the_strain_energy() -> None:
    """Two springs in series on one mass, of which one has a loss factor of 0.1 and two thirds of the energy."""
    soft, stiff = 1.0e4, 2.0e4
    K = np.array([[soft + stiff, -stiff], [-stiff, stiff]])
    eta = 0.1
    damping = ModalDamping(loss=sp.csr_matrix(eta * np.array([[soft, 0.0], [0.0, 0.0]])))
    shape = np.array([1.0 / soft, 1.0 / soft + 1.0 / stiff])  # under a force on the second mass
    value = shape @ K @ shape
    ratio = damping.of_modes(np.array([value]), np.array([shape @ (damping.loss @ shape)]))
    assert ratio[0] == pytest.approx(0.5 * eta * 2.0 / 3.0, rel=1e-12)
