"""Results of the laboratory evaluation `friction`."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, Field, number
from wroll_fem.results.lab.shear import estimate

ENDS = "lower and upper end at 95 %"

_STATE: dict[str, Entry] = {}
for _law in ("ageing", "slip"):
    for _name, _unit, _label in (
        ("mu", "", "mu_R"), ("a", "", "a"), ("b", "", "b"), ("a_minus_b", "", "a - b"), ("distance", "m", "D_R"),
    ):  # fmt: skip
        _end = f"_{_unit}" if _unit else ""
        _entry = Entry(_unit, f"{_label} of the {_law} law", "rate and state", "si" if _unit else "number")
        _STATE[f"state_{_law}_{_name}{_end}"] = _entry
        _STATE[f"state_{_law}_{_name}_interval{_end}"] = _entry._replace(
            label=f"interval of {_label} of the {_law} law", sentence=ENDS
        )
    _STATE[f"state_{_law}_scatter"] = number("", f"standard deviation of the residuals of the {_law} law")

ENTRIES: dict[str, Entry] = {
    "rate_model": Entry("", "model of mu(V)", "of the file friction.yaml", "si", "{}"),
    "rate_criterion": number(
        "",
        "Akaike's criterion of each model of mu(V)",
        "constant, logarithmic, table; `null` without; the smallest is best",
    ),
    "rate_table_m_s": number("m/s", "slip rates of the table"),
    "rate_table_mu": number("", "coefficient of friction per slip rate of the table"),
    "rate_table_mu_interval": number("", "interval of this coefficient", "pairs: lower and upper end at 95 %"),
    "rate_scatter": number("", "standard deviation between tests", "of the coefficient, beyond the noise of each test"),
    "state_reference_rate_m_s": number("m/s", "reference rate V_R"),
    "state_law": Entry("", "law of the state that fits better", "", "si", "{}"),
    "state_criterion_difference": number(
        "", "difference of Akaike's criterion between the laws", "above 10 the record decides"
    ),
    **_STATE,
    "elastic_slip_m": Entry(
        "m", "elastic slip gamma*", "from stiffness and capacity over the preload", "si", "{:.3g} m"
    ),
    "elastic_slip_interval_m": Entry("m", "interval of the elastic slip", ENDS),
    "elastic_slip_mu": number("", "coefficient of friction from the capacities", "F_c = 2 mu F_N"),
    "elastic_slip_mu_interval": number("", "interval of this coefficient", ENDS),
    "series_compliance_m_per_n": number("m/N", "compliance in series with the interfaces", "of layers and fixture"),
    "series_compliance_interval_m_per_n": number("m/N", "interval of this compliance", ENDS),
}
"""Name in summary.json -> entry."""

FIELDS: dict[str, Field] = {
    "rate_table_slip_rate": Field("m s-1", "slip rate of the table"),
    **estimate("rate_table_coefficient", "1", "coefficient of friction of the table"),
    "step_slip": Field("m", "slip in the record of steps"),
    "step_coefficient": Field("1", "coefficient of friction in the record of steps"),
    "step_ageing": Field("1", "coefficient of friction by the ageing law"),
    "step_slip_law": Field("1", "coefficient of friction by the slip law"),
    "preload_force": Field("N", "normal force of one piston in the ramp"),
    **estimate("preload_compliance", "m N-1", "compliance of both stacks"),
    "preload_compliance_fitted": Field("m N-1", "fitted compliance of both stacks"),
    **estimate("preload_capacity", "N", "shear capacity of the ramp"),
    "preload_capacity_fitted": Field("N", "fitted shear capacity"),
}
"""Name in results.nc -> unit and label."""
