"""Table of energies, from the Dataset of a run."""

from __future__ import annotations

import numpy as np
import xarray as xr

from wroll_fem.report.html import Markup, paragraph, table
from wroll_fem.report.values import quantity
from wroll_fem.results.dataset import field
from wroll_fem.signals.transmissibility import magnitude

_SPENT = (
    "friction_energy", "material_damping", "impact_dissipation", "pressure_modulation_work", "numerical_dissipation",
)  # fmt: skip
_STORED = ("kinetic_energy", "strain_energy", "contact_energy")
_CYCLE = ("friction_work_per_cycle", "material_damping_work_per_cycle", "modulation_work_per_cycle")


def energy_ledger(dataset: xr.Dataset) -> Markup:
    """Table of energies at the end of a time history or per cycle of a periodic motion; empty without energies."""
    if "input_work" in dataset and "time" in dataset["input_work"].dims:
        from wroll_fem.results.energy import energy_balance_error

        last = dataset.isel(time=-1)
        taken = [name for name in (*_SPENT, *_STORED) if name in last]
        rows = _rows(float(last["input_work"]), {name: float(last[name]) for name in taken}, "input_work")
        closed = f"Largest balance error at any time: {energy_balance_error(dataset):.2e} of the largest input."
        return paragraph(f"At the end of the history, {float(last['time']):.4g} s.") + rows + paragraph(closed)
    if "input_work_per_cycle" in dataset and dataset["input_work_per_cycle"].ndim == 2:
        return _by_curve(dataset)
    if "input_work_per_cycle" in dataset:
        if "modal_damping" in dataset:
            at, where = int(dataset["modal_damping"].values.argmax()), "at the largest damping"
        else:
            at, where = int(magnitude(dataset).values.argmax()), "at the largest response"
        taken = [name for name in _CYCLE if name in dataset]
        values = {name: float(dataset[name].values[at]) for name in taken}
        rows = _rows(float(dataset["input_work_per_cycle"].values[at]), values, "input_work_per_cycle")
        return paragraph(f"Per cycle, {where}.") + rows
    return Markup()


def _by_curve(dataset: xr.Dataset) -> Markup:
    """Table of the energies per cycle at the highest point of each curve; variables have shape (curve, frequency)."""
    given = dataset["input_work_per_cycle"]
    curve, along = given.dims
    taken = [
        str(name) for name, series in dataset.data_vars.items()
        if "work" in str(name) and name != given.name and series.dims == given.dims
    ]  # fmt: skip
    rows = []
    for k in range(dataset.sizes[curve]):
        one = dataset.isel({curve: k})
        at = one.isel({along: int(np.abs(one["transmissibility"].values).argmax())})
        work, shares = float(at[given.name]), [float(at[name]) for name in taken]
        left = _share(work - sum(shares), work)
        rows.append([f"{float(one[curve]):.6g}", f"{work:.4g}", *(_share(value, work) for value in shares), left])
    head = [field(str(curve)).long_name, f"{field(str(given.name)).long_name} ({given.attrs.get('units', '')})"]
    head += [field(name).long_name for name in taken] + ["balance error"]
    title = "Per cycle, at the largest response of each curve, relative to the work of the base."
    return paragraph(title) + table(head, rows, numbers=range(len(head)))


def _rows(given: float, taken: dict[str, float], first: str) -> Markup:
    rows = [(_label(first), quantity(given, "J"), "100 %" if given else "")]
    rows += [(_label(name), quantity(value, "J"), _share(value, given)) for name, value in taken.items()]
    left = given - sum(taken.values())
    rows.append(("Balance error", quantity(left, "J"), _share(left, given)))
    return table(("energy", "value", "of the input"), rows, numbers=(1, 2))


def _share(value: float, given: float) -> str:
    return f"{100.0 * value / given:.3g} %" if given else ""


def _label(name: str) -> str:
    words = field(name).long_name
    return words[0].upper() + words[1:]
