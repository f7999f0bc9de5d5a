"""Results of the laboratory evaluation `shear`."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, Field, number

INTERVAL = "pairs: lower and upper end at 95 %"

ENTRIES: dict[str, Entry] = {
    "shear_capacity_n": Entry("N", "shear capacity per ramp", "force at the onset of slip", "si"),
    "shear_capacity_interval_n": Entry("N", "interval of the shear capacity", INTERVAL),
    "onset_rules": Entry("", "rule that found the onset of slip", "`force_drop` or `displacement_jump`, per ramp"),
    "capacity_coefficient": number("", "coefficient of friction from the capacities", "F_c = 2 mu F_N", "{:.4f}"),
    "capacity_coefficient_interval": number("", "interval of this coefficient", "lower and upper end at 95 %"),
    "shear_stiffness_n_per_m": Entry("N/m", "shear stiffness of both stacks per ramp", "without the fixture"),
    "shear_stiffness_interval_n_per_m": Entry("N/m", "interval of the shear stiffness", INTERVAL),
    "shear_modulus_pa": Entry("Pa", "shear modulus of a stack per ramp", "G = K t/(2 A): two stacks act in parallel"),
    "shear_modulus_interval_pa": Entry("Pa", "interval of the shear modulus", INTERVAL),
    "shear_modulus_one_stack_pa": Entry(
        "Pa", "K t/A per ramp", "equations E.2 and E.3 of the thesis; twice the modulus: they omit the second stack"
    ),
    "loop_energy_j": Entry("J", "energy per cycle, of each record with loops", "mean over its cycles"),
    "loop_energy_interval_j": Entry("J", "interval of the energy per cycle", INTERVAL),
    "slip_rates_m_s": number("m/s", "slip rates", "rising, of all sliding records and loops"),
    "sliding_coefficient": number("", "coefficient of friction per slip rate"),
    "sliding_coefficient_interval": number("", "interval of the coefficient per slip rate", INTERVAL),
}
"""Name in summary.json -> entry."""


def estimate(name: str, units: str, label: str) -> dict[str, Field]:
    """Fields of an estimate and of the ends of its interval."""
    ends = {f"{name}_{end}": Field(units, f"{label}, {end} end of the 95 % interval") for end in ("low", "high")}
    return {name: Field(units, label), **ends}


FIELDS: dict[str, Field] = {
    "test_record": Field("1", "file of the record"),
    "record_profile": Field("1", "kind of test"),
    "normal_force": Field("N", "normal force of one piston"),
    "onset_rule": Field("1", "rule that found the onset of slip"),
    **estimate("shear_capacity", "N", "shear capacity"),
    **estimate("shear_stiffness", "N m-1", "shear stiffness of both stacks"),
    **estimate("shear_modulus", "Pa", "shear modulus of a stack"),
    "shear_modulus_one_stack": Field("Pa", "K t/A, twice the shear modulus"),
    **estimate("loop_energy", "J", "energy per cycle"),
    **estimate("loop_displacement", "m", "amplitude of the displacement in a cycle"),
    **estimate("loop_force", "N", "amplitude of the force in a cycle"),
    "loop_count": Field("1", "number of cycles"),
    "point_slip_rate": Field("m s-1", "slip rate of the point"),
    "point_profile": Field("1", "profile of the test"),
    "point_record": Field("1", "record, counted from 0"),
    **estimate("point_coefficient", "1", "coefficient of friction of the point"),
    "curve_displacement": Field("m", "displacement without the fixture"),
    "curve_force": Field("N", "shear force on both stacks along the record"),
}
"""Name in results.nc -> unit and label."""
