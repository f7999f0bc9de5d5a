"""Columns of the step records: their names, and what the steppers write into them."""

from __future__ import annotations

import numpy as np
import pytest
from support.exact_systems import STEPPERS, slipping_pair, stepper

from wroll_fem.contact import kernels
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.time_stepping import records
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import RECORDS

NAMES = {
    "TIP_DISPLACEMENT": "tip_displacement", "TIP_VELOCITY": "tip_velocity", "TIP_ACCELERATION": "tip_acceleration",
    "INPUT": "input_work", "KINETIC": "kinetic_energy", "STRAIN": "strain_energy", "CONTACT": "contact_energy",
    "FRICTION": "friction_energy", "MODULATION": "pressure_modulation_work", "NUMERICAL": "numerical_dissipation",
    "INTERFACE": "interface_work", "ITERATIONS": "newton_iterations", "OPEN": "open_fraction",
    "SLIPPING": "slipping_fraction", "VISCOUS": "material_damping", "IMPACT": "impact_dissipation",
}  # fmt: skip


def test_every_column_has_a_name_in_the_code() -> None:
    assert [RECORDS[getattr(records, name)] for name in NAMES] == list(NAMES.values())
    assert sorted(NAMES.values()) == sorted(RECORDS)


@pytest.mark.parametrize("method", STEPPERS)
def test_the_columns_hold_the_totals_of_the_stepper(method: str) -> None:
    system = slipping_pair()
    dt = 1.0 / 1400.0
    run = stepper(method, system, solve_preload(system), Scheme.hht(-0.05), dt)
    last = run.advance(20.0 * np.sin(2 * np.pi * 14.0 * dt * np.arange(201)), dt, 0.0)[-1]
    work, flows = run.accumulated.work, run.accumulated.flows
    assert work[kernels.FRICTION] > 0.0
    assert last[records.FRICTION] == work[kernels.FRICTION]
    assert last[records.CONTACT] == work[kernels.STORED]
    assert last[records.MODULATION] == work[kernels.MODULATION]
    assert last[records.INTERFACE] == work[kernels.TOTAL]
    assert last[records.IMPACT] == work[kernels.IMPACT]
    assert last[records.INPUT] == flows[records.INPUT_FLOW]
    assert last[records.NUMERICAL] == flows[records.NUMERICAL_FLOW]
    assert last[records.VISCOUS] == flows[records.VISCOUS_FLOW] == 0.0
    motion = run.state.motion
    if method == "full":
        tip = system.probes["tip"]
        assert last[records.TIP_DISPLACEMENT] == tip @ motion.q
        assert last[records.TIP_ACCELERATION] == tip @ motion.a
    kinetic = motion.v @ (system.mass @ motion.v) if method == "full" else motion.v @ motion.v
    assert last[records.KINETIC] == pytest.approx(0.5 * kinetic, rel=1e-12)
