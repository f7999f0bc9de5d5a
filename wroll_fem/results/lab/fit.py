"""Results of the laboratory evaluation `fit`."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, Field, number

ENTRIES: dict[str, Entry] = {
    "fit_model": Entry("", "fitted model", "`two_masses` or `backbones`", "si", "{}"),
    "parameters": Entry("", "fitted parameters", "name, with its unit, and value"),
    "parameters_low": Entry("", "lower ends of their 95 % intervals"),
    "parameters_high": Entry("", "upper ends of their 95 % intervals"),
    "fit_misfit": number(
        "", "misfit", "root mean square of ln(model / measured) (two_masses), or in standard errors (backbones)",
        "{:.3g}",
    ),
    "undetermined": Entry("", "what the data do not determine", "a list of sentences; also among the warnings"),
    "at_bound": Entry("", "parameters at a bound", "a list; they are doubtful"),
}  # fmt: skip
"""Name in summary.json -> entry."""

FIELDS: dict[str, Field] = {
    "parameter": Field("1", "fitted parameter"),
    "fitted": Field("1", "unknown of the fit"),
    "other_fitted": Field("1", "other unknown of the fit"),
    "parameter_name": Field("1", "name of the parameter, with its unit"),
    "parameter_value": Field("1", "value of the parameter, in its unit"),
    "parameter_low": Field("1", "lower end of the 95 % interval, in the unit of the parameter"),
    "parameter_high": Field("1", "upper end of the 95 % interval, in the unit of the parameter"),
    "parameter_correlation": Field("1", "correlation of the logarithms of the parameters"),
    "datum": Field("1", "measured value"),
    "datum_condition": Field("1", "condition of the measured value"),
    "datum_frequency": Field("Hz", "frequency of the measured value"),
    "datum_level": Field("m s-2", "base acceleration of the measured value"),
    "datum_quantity": Field("1", "quantity: transmissibility, f_n in Hz, or level in m/s^2"),
    "fit_measured": Field("1", "measured value, in the unit of its quantity"),
    "fit_computed": Field("1", "value of the fitted model, in the unit of its quantity"),
}
"""Name in results.nc -> unit and label."""
