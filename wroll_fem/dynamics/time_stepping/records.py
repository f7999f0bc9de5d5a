"""Columns of a step record and entries of `Accumulated.flows`, with a named constant for the index of each."""

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
    "material_damping",
    "impact_dissipation",
)
"""Names of the columns of a step record. Energies are in J; work and dissipation are totals since the start."""

(
    TIP_DISPLACEMENT, TIP_VELOCITY, TIP_ACCELERATION, INPUT, KINETIC, STRAIN, CONTACT, FRICTION, MODULATION, NUMERICAL,
    INTERFACE, ITERATIONS, OPEN, SLIPPING, VISCOUS, IMPACT,
) = range(16)  # fmt: skip
"""Index of each column of `RECORDS`."""

FIRST_PROBE, OF_PROBE = len(RECORDS), 3
"""Index of the first probe column of a step record, and number of columns per probe (displacement, velocity,
acceleration). The probe columns follow the columns of `RECORDS`; the tip is not one of these probes."""


def record_size(probes: int) -> int:
    """Number of columns of a step record with ``probes`` probes besides the tip."""
    return FIRST_PROBE + OF_PROBE * probes


INPUT_FLOW, NUMERICAL_FLOW, VISCOUS_FLOW = range(3)
"""Indices of the work of the base, the numerical dissipation and the work of the dashpots in `Accumulated.flows`."""


@numba.njit(cache=True)
def record_contact(record, accumulated, iterations, status):
    """Write interface energies (J), number of iterations, and fractions of open and of slipping points to a record."""
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
    """Write the work of the base, the numerical dissipation and the work of the dashpots (J) to a record."""
    record[INPUT] = accumulated.flows[INPUT_FLOW]
    record[NUMERICAL] = accumulated.flows[NUMERICAL_FLOW]
    record[VISCOUS] = accumulated.flows[VISCOUS_FLOW]
