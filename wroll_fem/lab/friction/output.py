"""Summary, variables and the file friction.yaml of fitted friction laws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.common.intervals import entries, variables
from wroll_fem.lab.friction.elastic_slip import ElasticSlip
from wroll_fem.lab.friction.rate_law import MODELS, Model, RateFits, RateLaw
from wroll_fem.lab.friction.section import law_text
from wroll_fem.lab.friction.settings import FrictionSettings
from wroll_fem.lab.friction.state_law import StateFits
from wroll_fem.lab.shear.evaluation import Measured
from wroll_fem.numerics.inference import Estimate
from wroll_fem.progress import Progress
from wroll_fem.tribology.rate_and_state import LAWS

Parts = tuple[dict[str, Any], dict[str, tuple[Any, Any]]]
"""Entries of the summary, and variables of the Dataset."""


def chosen(fits: RateFits, wanted: str) -> RateLaw:
    """Law of the wanted model, the best one for `auto`.

    Raises
    ------
    InputError
        If the points do not determine the wanted model.
    """
    model: Model = fits.best if wanted == "auto" else wanted  # type: ignore[assignment]  # checked by the settings
    if model not in fits.fits:
        raise InputError(
            f"the points do not determine the model {model}", key="rate_model",
            remedy=f"use one of: {', '.join(fits.fits)}",
        )  # fmt: skip
    return fits.fits[model]


def rate_results(fits: RateFits | None, wanted: str) -> Parts:
    """Results of the fit of mu(V)."""
    if fits is None:
        return {}, {}
    law = chosen(fits, wanted)
    summary = {
        "rate_model": law.model,
        "rate_criterion": [fits.fits[name].criterion if name in fits.fits else None for name in MODELS],
        "rate_table_m_s": law.rates.tolist(),
        **entries("rate_table_mu", "", law.coefficients),
        "rate_scatter": law.between,
    }
    data = {"rate_table_slip_rate": ("rate_row", law.rates)}
    return summary, data | variables("rate_table_coefficient", "rate_row", law.coefficients)


def state_results(fits: Sequence[StateFits]) -> Parts:
    """Results of the fits of rate and state, lists over the records; curves of the first one."""
    if not fits:
        return {}, {}
    summary: dict[str, Any] = {
        "state_reference_rate_m_s": [one.fits[LAWS[0]].rate for one in fits],
        "state_law": [one.preferred for one in fits],
        "state_criterion_difference": [one.difference for one in fits],
    }
    for law in LAWS:
        own = [one.fits[law] for one in fits]
        for name, unit in (("mu", ""), ("a", ""), ("b", ""), ("distance", "m")):
            summary |= entries(f"state_{law}_{name}", unit, [one[name] for one in own])
        summary |= entries(f"state_{law}_a_minus_b", "", [one.steady_slope for one in own])
        summary[f"state_{law}_scatter"] = [one.scatter for one in own]
    first = fits[0]
    slip = first.data.slip
    data = {"step_slip": ("step_sample", slip), "step_coefficient": ("step_sample", first.data.coefficient)}
    for law, name in zip(LAWS, ("step_ageing", "step_slip_law"), strict=True):
        data[name] = ("step_sample", first.data.coefficient - first.fits[law].fit.residuals[: len(slip)])
    return summary, data


def slip_results(found: ElasticSlip | None, measured: Sequence[Measured], interfaces: int) -> Parts:
    """Results of the fit of the elastic slip."""
    if found is None:
        return {}, {}
    summary = {
        **entries("elastic_slip", "m", found.elastic_slip),
        **entries("elastic_slip_mu", "", found.mu),
        **entries("series_compliance", "m_per_n", found.series),
    }
    ramps = [one for one in measured if one.capacity is not None and one.stiffness is not None]
    force = np.array([one.read.record.normal_force for one in ramps])
    compliance = [
        Estimate(1.0 / one.stiffness.value, one.stiffness.error / one.stiffness.value**2, one.stiffness.freedom)
        for one in ramps
        if one.stiffness is not None
    ]
    fitted = interfaces * found.elastic_slip.value / (2.0 * found.mu.value * force) + found.series.value
    data: dict[str, tuple[Any, Any]] = {"preload_force": ("ramp", force)}
    data |= variables("preload_compliance", "ramp", compliance)
    data["preload_compliance_fitted"] = ("ramp", fitted)
    data |= variables("preload_capacity", "ramp", [one.capacity.force for one in ramps if one.capacity is not None])
    data["preload_capacity_fitted"] = ("ramp", 2.0 * found.mu.value * force)
    return summary, data


def friction_text(
    rate: RateFits | None, slip: ElasticSlip | None, settings: FrictionSettings, progress: Progress
) -> str:
    """Content of friction.yaml: the case section `contact.friction`; empty if the elastic slip is unknown."""
    length = settings.elastic_slip
    if length is None and slip is not None:
        length = slip.elastic_slip.value
    if length is None:
        progress.warning(
            "friction.yaml is not written, because the elastic slip is unknown; give elastic_slip, or ramps at several "
            "preloads"
        )
        return ""
    length = float(f"{length:.4g}")
    if rate is not None:
        law = chosen(rate, settings.rate_model)
        section = law.section(length)
        origin = f"mu(V): model {law.model}, standard deviation between tests {law.between:.2g}"
    elif slip is not None:
        section = {"law": "penalty_coulomb", "mu": float(f"{slip.mu.value:.6g}"), "elastic_slip": length}
        origin = "mu from the capacities of the ramps"
    else:
        return ""
    own = "given" if settings.elastic_slip is not None or slip is None else _ends(slip.elastic_slip)
    return law_text(section, [origin, f"elastic_slip: m, {own}"])


def _ends(estimate: Estimate) -> str:
    low, high = estimate.interval()
    return f"95 % interval {low:.3g} to {high:.3g} m"
