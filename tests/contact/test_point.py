"""Formulas of one contact point, and the order of the contact degrees of freedom."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.contact import point
from wroll_fem.contact.laws import PenaltyCoulomb, stack_laws

LAWS = stack_laws([np.ones(3)], [PenaltyCoulomb(0.3, 2.0e-6)], [np.array([1.0e12, 2.0e12, 3.0e12])], [True])
STEP, STATIC = 1.0e-4, np.inf


def test_the_order_of_the_degrees_of_freedom_is_one_and_the_same_everywhere() -> None:
    """Compiled helpers, the table of all points and the splitting of arrays agree; every number occurs once."""
    n = 4
    table = point.contact_dofs(n)
    assert sorted(table.ravel()) == list(range(3 * n))
    for k in range(n):
        assert list(table[k]) == [point.hoop(k), point.axial(k), point.normal(k, n)]
        for component in (point.HOOP, point.AXIAL, point.NORMAL):
            dof = point.contact_dof(k, component, n)
            assert dof == table[k, component]
            assert (point.point_of(dof, n), point.component_of(dof, n)) == (k, component)
    values = np.arange(3.0 * n)
    np.testing.assert_array_equal(point.normals(values), values[table[:, point.NORMAL]])
    np.testing.assert_array_equal(point.tangentials(values), values[table[:, : point.NORMAL]])
    spread = point.per_dof(np.arange(n), 10 + np.arange(n))
    np.testing.assert_array_equal(spread[table], np.column_stack([np.arange(n), np.arange(n), 10 + np.arange(n)]))


def test_stick_stiffness_of_every_point_is_that_of_each() -> None:
    pressure = np.array([1.0e5, 0.0, 3.0e4])
    each = [point.stick_stiffness(k, pressure[k], LAWS) for k in range(3)]
    np.testing.assert_array_equal(point.stick_stiffness(point.EVERY, pressure, LAWS), each)
    assert each[0] == pytest.approx(0.3 * 1.0e5 / 2.0e-6, rel=1e-15)


@pytest.mark.parametrize("gn", [-3.0e-7, 0.0, 2.0e-7])
@pytest.mark.parametrize("gn_c", [-1.0e-7, 1.0e-7])
def test_the_release_traction_belongs_to_a_time_step_that_opens_the_point(gn: float, gn_c: float) -> None:
    """Statics, harmonic balance (the penalty alone) and all other steps have the penalty's traction."""
    penalty = point.penalty_traction(gn, 1.0e12, True)
    assert penalty == (1.0e12 * gn if gn <= 0.0 else 0.0)
    assert point.step_traction(gn, gn_c, 1.0e12, True, STATIC) == penalty
    released = gn > 0.0 > gn_c
    assert point.opens_in_step(gn, gn_c, True, STEP) == released
    assert (point.step_traction(gn, gn_c, 1.0e12, True, STEP) != penalty) == released
    assert point.step_traction(gn, gn_c, 1.0e12, False, STEP) == 1.0e12 * gn
    if gn != 0.0:  # its slope, by differences
        h = 1.0e-4 * abs(gn)
        ends = [point.step_traction(gn + sign * h, gn_c, 1.0e12, True, STEP) for sign in (1, -1)]
        slope = point.step_stiffness(gn, gn_c, 1.0e12, True, STEP)
        assert (ends[0] - ends[1]) / (2.0 * h) == pytest.approx(slope, rel=1e-7, abs=1e-3)


def test_pressure_is_positive_in_compression_and_zero_in_tension() -> None:
    assert [point.pressure(tn) for tn in (-5.0, 0.0, 5.0)] == [5.0, 0.0, 0.0]


def test_the_work_of_a_step_splits_completely() -> None:
    """Friction + stored + modulation is the mean traction times the increment; modulation has its closed form."""
    rng = np.random.default_rng(4)
    for _ in range(50):
        p_c, p = rng.uniform(0.0, 2.0e5, 2)
        e_c, e, dg = (tuple(rng.uniform(-1.0e-6, 1.0e-6, 2)) for _ in range(3))
        t_c, t = (
            tuple(point.stick_stiffness(0, pressure, LAWS) * x for x in slip) for pressure, slip in ((p_c, e_c), (p, e))
        )
        friction, elastic, stored = point.tangential_work(0, p_c, p, t_c, t, dg, e_c, e, LAWS)
        total = sum(0.5 * (a + b) * d for a, b, d in zip(t_c, t, dg, strict=True))
        size = max(abs(friction), abs(elastic), abs(stored))
        assert friction + elastic == pytest.approx(total, abs=1e-13 * size)
        modulation = point.modulation_work(0, p_c, p, e_c, e, LAWS)
        assert elastic - stored == pytest.approx(modulation, abs=1e-13 * size)
    assert point.modulation_work(0, p, p, e_c, e, LAWS) == 0.0
