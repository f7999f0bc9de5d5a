"""Results of the laboratory evaluation `tension`."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, Field, number
from wroll_fem.results.lab.shear import INTERVAL, estimate

ENTRIES: dict[str, Entry] = {
    "voltages_v": number("V", "voltage of the winding motor per setting"),
    "currents_ampere": number("A", "current of the membrane roller per setting"),
    "trial_counts": number("", "number of trials per setting"),
    "winding_tension_n": Entry("N", "mean tension per setting"),
    "winding_tension_interval_n": Entry("N", "interval of the mean tension", INTERVAL),
    "tension_within_n": Entry("N", "standard deviation within a trial, per setting"),
    "tension_between_n": Entry(
        "N", "standard deviation between trials, per setting", "of their true means; `null` for one trial"
    ),
    "tension_scatter_n": Entry("N", "standard deviation of both together", "error bar of Fig. 3.6 of the thesis"),
    "wound_pressure_pa": Entry("Pa", "pressure at the mandrel per setting", "from the case file"),
    "wound_pressure_interval_pa": Entry("Pa", "interval of the pressure at the mandrel", INTERVAL),
    "wound_pressure_sample_pa": Entry("Pa", "quantiles of the pressure at the mandrel", "2.5 % and 97.5 % of a sample"),
    "wound_pressure_mean_pa": Entry("Pa", "mean pressure between the wraps per setting"),
    "wound_pressure_mean_interval_pa": Entry("Pa", "interval of the mean pressure", INTERVAL),
}
"""Name in summary.json -> entry."""

FIELDS: dict[str, Field] = {
    "motor_voltage": Field("V", "voltage of the winding motor"),
    "roller_current": Field("A", "current of the membrane roller"),
    "trial_count": Field("1", "number of trials"),
    **estimate("winding_tension", "N", "mean tension of the web"),
    "tension_within": Field("N", "standard deviation of the tension within a trial"),
    "tension_between": Field("N", "standard deviation of the tension between trials"),
    "tension_scatter": Field("N", "standard deviation of the tension, both together"),
    "trial_setting": Field("1", "setting of the trial, counted from 0"),
    **estimate("trial_tension", "N", "mean tension of the trial"),
    "trial_drift": Field("N", "change of the tension during the trial"),
    **estimate("wound_pressure", "Pa", "pressure at the mandrel"),
    **estimate("wound_pressure_mean", "Pa", "mean pressure between the wraps"),
    "wound_pressure_slope": Field("Pa N-1", "change of the pressure at the mandrel with the tension"),
}
"""Name in results.nc -> unit and label."""
