"""Columns of a step record and entries of the running totals, by name; compiled code takes the names as constants."""

from __future__ import annotations

import numba

from wroll_fem.contact import kernels
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__)

RECORDS = (
    "tip_displacement",
    "tip_velocity",
    "tip_acceleration",
    "input_work",
    "kinetic_energy",
    "strain_energy",
    "contact_energy",
    "friction_energy",
    "pressure_modulation_work",
    "numerical_dissipation",
    "interface_work",
    "newton_iterations",
    "open_fraction",
    "slipping_fraction",
    "viscous_energy",
    "impact_dissipation",
)
"""Columns of a step record; energies in J since the start of the run."""

(
    TIP_DISPLACEMENT, TIP_VELOCITY, TIP_ACCELERATION, INPUT, KINETIC, STRAIN, CONTACT, FRICTION, MODULATION, NUMERICAL,
    INTERFACE, ITERATIONS, OPEN, SLIPPING, VISCOUS, IMPACT,
) = range(16)  # fmt: skip
"""Number of each column of `RECORDS`."""

FIRST_PROBE, OF_PROBE = len(RECORDS), 3
"""Columns behind those of `RECORDS`: displacement, velocity and acceleration of each probe beside the tip."""


def record_size(probes: int) -> int:
    """Columns of a step record with ``probes`` probes beside the tip."""
    return FIRST_PROBE + OF_PROBE * probes


INPUT_FLOW, NUMERICAL_FLOW, VISCOUS_FLOW = range(3)
"""Entries of `Accumulated.flows`: work of the base, dissipation of the scheme, work of the dashpots, J."""


@numba.njit(cache=True)
def record_contact(record, accumulated, iterations, status):
    """Energy of the interfaces (J), iterations, and the fractions of the points that are open and slip."""
    work = accumulated.work
    record[CONTACT] = work[kernels.STORED]
    record[FRICTION] = work[kernels.FRICTION]
    record[MODULATION] = work[kernels.MODULATION]
    record[INTERFACE] = work[kernels.TOTAL]
    record[IMPACT] = work[kernels.IMPACT]
    record[ITERATIONS] = iterations
    slipping, opened = 0, 0
    for k in range(status.shape[0]):
        slipping += status[k] == kernels.SLIP
        opened += status[k] == kernels.OPEN
    record[OPEN] = opened / max(status.shape[0], 1)
    record[SLIPPING] = slipping / max(status.shape[0], 1)


@numba.njit(cache=True)
def record_flows(record, accumulated):
    """Work of the base, of the scheme and of the dashpots, J."""
    record[INPUT] = accumulated.flows[INPUT_FLOW]
    record[NUMERICAL] = accumulated.flows[NUMERICAL_FLOW]
    record[VISCOUS] = accumulated.flows[VISCOUS_FLOW]
