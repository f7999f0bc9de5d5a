"""Random motion at several levels, with several records each, in one run.

All histories share structure, preload state, modes and the basis of the reduced model. A run folder keeps each history
in `levels/`; an interrupted run continues with the first one that is missing.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wroll_fem.analyses.history import SharedStructure, time_history
from wroll_fem.analyses.random_reading import Reading, read_records
from wroll_fem.analyses.random_statistics import accuracy, graded, spectra_variables, statistics
from wroll_fem.analyses.shared import summary
from wroll_fem.results.dataset import annotate, load_dataset, save_dataset
from wroll_fem.results.energy import energy_balance_error
from wroll_fem.results.storage.checkpoint import read_checkpoint, write_checkpoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wroll_fem.case import RandomCase
    from wroll_fem.progress import Progress
    from wroll_fem.typing import FloatArray

SERIES = (
    "base_acceleration", "tip_acceleration", "tip_displacement", "base_shear", "base_moment", "material_damping",
    "friction_energy", "pressure_modulation_work", "impact_dissipation", "numerical_dissipation", "input_work",
    "kinetic_energy",
)  # fmt: skip
"""Time series of a history that the results of the levels need."""

ONCE = (
    "dofs", "interface_points", "steps_per_cycle", "stuck_resonance_hz", "tip_participation",
    "excited_to_hz", "period_error_at_highest",
)  # fmt: skip
SUMMED = ("steps", "step_cuts", "solver_time_s", "training_time_s")
WORST = (
    "reduction_error_estimate", "span_error_estimate", "reduced_coordinates", "energy_balance_error",
    "newton_iterations_mean",
)  # fmt: skip
"""Attributes of histories: the same for all, summed, and the largest; the last two of those that have them."""

LISTED = {
    "level_db": "level_db", "level_f_n_hz": "frequency_at_level", "level_f_n_error_hz": "frequency_error_at_level",
    "level_zeta": "damping_at_level", "level_zeta_error": "damping_error_at_level",
    "level_zeta_quality": "damping_quality_at_level", "level_base_rms_m_s2": "base_rms_at_level",
    "level_tip_rms_m_s2": "tip_rms_at_level", "level_tip_rms_error": "tip_rms_error_at_level",
    "level_tip_displacement_rms_m": "tip_displacement_rms_at_level",
    "level_base_shear_rms_n": "base_shear_rms_at_level", "level_base_moment_rms_nm": "base_moment_rms_at_level",
    "level_friction_energy_j": "friction_energy_at_level", "level_max_slip_m": "max_slip",
    "level_max_accumulated_slip_m": "cumulative_slip",
}  # fmt: skip
"""Entry of summary.json, a list with one number per level -> variable, whose largest value over the points is taken."""

SLIP = (
    "max_slip", "cumulative_slip", "slipped", "open_time_fraction", "least_pressure", "peak_slip_hoop",
    "peak_slip_axial",
)  # fmt: skip
"""Fields of the interfaces that depend on the level."""

PRELOADED = ("area", "pressure", "external_pressure", "traction_hoop", "traction_axial")
"""Fields of the interfaces that do not depend on the level."""

STATISTICS = {
    "base_rms_m_s2": "base_rms", "tip_rms_m_s2": "tip_rms", "tip_displacement_rms_m": "tip_displacement_rms",
    "base_shear_rms_n": "base_shear_rms", "base_moment_rms_nm": "base_moment_rms",
}  # fmt: skip
"""Entry of a single history -> stem of the variable `..._at_level`."""


@dataclass(frozen=True)
class Level:
    """Histories of one level.

    Attributes
    ----------
    level_db
        Level relative to the PSD of the case, dB.
    histories
        One per record, with the series of `SERIES` and the fields of the interfaces.
    """

    level_db: float
    histories: Sequence[xr.Dataset]


def seeds_of(seed: int, records: int) -> list[int]:
    """Seeds of the records of a level: the given one, then numbers that follow from it."""
    return [seed, *(int(number) for number in np.random.SeedSequence(seed).generate_state(max(records - 1, 1)))][
        :records
    ]


def single(case: RandomCase, level_db: float, seed: int) -> RandomCase:
    """Case of one history of a series."""
    changes = {"level_db": level_db, "seed": seed, "levels": None, "levels_db": None, "records": None}
    return case.model_copy(update={"excitation": case.excitation.model_copy(update=changes)})


def run_levels(
    case: RandomCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False
) -> xr.Dataset:
    """Compute all histories, and their spectra, damping and statistics along `level`.

    Raises
    ------
    ConvergenceError
        If a step does not converge; ``partial`` has the history of this record up to that step.
    """
    excitation = case.excitation
    seeds = seeds_of(excitation.seed, excitation.records or 1)
    runs = _Runs(case, progress, checkpoint, resume)
    levels = [Level(db, [runs.history(db, seed) for seed in seeds]) for db in excitation.all_levels_db]
    dataset = levels_dataset(case, levels, progress)
    attrs = {"seeds": seeds, "excitation_kind": excitation.kind, "excitation_direction": runs.direction}
    return annotate(dataset.assign_coords(seed=("record", np.array(seeds))).assign_attrs(attrs | dataset.attrs))


class _Runs:
    """Histories of a series, one after the other, with their files."""

    def __init__(self, case: RandomCase, progress: Progress, checkpoint: Path | None, resume: bool):
        self.case, self.progress, self.checkpoint, self.resume = case, progress, checkpoint, resume
        self.shared: SharedStructure | None = None
        self.direction = ""

    def history(self, level_db: float, seed: int) -> xr.Dataset:
        """History of one record, from its file if an interrupted run has completed it."""
        case = single(self.case, level_db, seed)
        file = self._file(level_db, seed)
        if self.resume and file is not None and file.is_file():
            return self._kept(load_dataset(file))
        self.progress.info(f"level {level_db:.4g} dB, record of seed {seed}")
        if self.shared is None:
            largest = single(self.case, self.case.excitation.all_levels_db[-1], seed)
            self.shared = SharedStructure(largest, self.progress)
            self.shared.basis = _kept_basis(self.checkpoint) if self.resume else None
        begun = self.resume and _holds_history(self.checkpoint)
        self.resume = False
        found = time_history(case, progress=self.progress, checkpoint=self.checkpoint, resume=begun, shared=self.shared)
        if file is not None:
            self._between()
            file.parent.mkdir(exist_ok=True)
            save_dataset(found.assign_attrs(analysis="random"), file)
        return self._kept(found)

    def _kept(self, history: xr.Dataset) -> xr.Dataset:
        self.direction = str(history.attrs["excitation_direction"])
        lost = [name for name in history.data_vars if "time" in history[name].dims and name not in SERIES]
        balance = energy_balance_error(history)
        return history.drop_vars(lost).load().assign_attrs(energy_balance_error=balance)

    def _file(self, level_db: float, seed: int) -> Path | None:
        if self.checkpoint is None:
            return None
        return self.checkpoint.parent / "levels" / f"level_{level_db:+.9g}_dB_seed_{seed}.nc"

    def _between(self) -> None:
        """Replace the checkpoint of a completed history by one with the basis of the next one alone."""
        basis = None if self.shared is None else self.shared.basis
        arrays = {} if basis is None else {"vectors": basis[0], "values": basis[1]}
        if self.checkpoint is not None:
            write_checkpoint(self.checkpoint, arrays | {"completed": np.array(True)})


def _kept_basis(checkpoint: Path | None) -> tuple[FloatArray, FloatArray] | None:
    """Basis of the last completed history of an interrupted series, from its checkpoint."""
    if checkpoint is None or not checkpoint.is_file() or _holds_history(checkpoint):
        return None
    data = read_checkpoint(checkpoint)
    return (data["vectors"], data["values"]) if "vectors" in data else None


def _holds_history(checkpoint: Path | None) -> bool:
    if checkpoint is None or not checkpoint.is_file():
        return False
    return "completed" not in read_checkpoint(checkpoint)


def levels_dataset(case: RandomCase, levels: Sequence[Level], progress: Progress) -> xr.Dataset:
    """Results of all levels, with the spectra on the lines of the finest resolution that a level asks for."""
    excitation, method = case.excitation, case.output.damping
    first = [read_records(level.histories, excitation, method).spectra.resolution for level in levels]
    resolution = min(first)
    rows = []
    for level in levels:
        found = read_records(level.histories, excitation, method, resolution)
        attrs, reasons = graded(single(case, level.level_db, excitation.seed), level.histories, found)
        for text in reasons:
            progress.warning(f"level {level.level_db:.4g} dB: {text}")
        rows.append(_row(level, found, attrs, method, excitation))
    factors = [10.0 ** (level.level_db / 20.0) for level in levels]
    dataset = xr.concat(rows, "level").assign_coords(
        level=np.array(factors), level_db=("level", np.array([level.level_db for level in levels]))
    )
    static = levels[0].histories[0]
    kept = [name for name in PRELOADED if name in static]
    dataset = dataset.merge(static[kept].drop_vars("time", errors="ignore"))
    return dataset.assign_attrs(_common(case, levels, found) | _lists(dataset))


def _row(level: Level, found: Reading, attrs: dict[str, Any], method: str, excitation: Any) -> xr.Dataset:
    """Results of one level."""
    steady = [one.isel(time=one["time"].values >= found.start) for one in level.histories]
    numbers = [statistics(one, found.spectra) for one in steady]
    alone = [read_records([one], excitation, method, found.spectra.resolution) for one in level.histories]
    count = len(steady)
    row = spectra_variables(found.spectra)
    for entry, stem in STATISTICS.items():
        if entry in numbers[0]:
            values = np.array([one[entry] for one in numbers])
            row[f"{stem}_of_record"] = ("record", values)
            row[f"{stem}_at_level"] = float(np.sqrt(np.mean(values**2)))
    row["tip_rms_error_at_level"] = float(np.mean([one["tip_rms_error"] for one in numbers])) / np.sqrt(count)
    row["tip_kurtosis_at_level"] = float(np.mean([one["tip_kurtosis"] for one in numbers]))
    for stem, entry, part in (("frequency", "f_n_hz", "f_n"), ("damping", "zeta", "zeta")):
        values = np.array([getattr(one.read.damping, part) for one in alone])
        error = float(attrs.get(f"{part}_error_hz" if part == "f_n" else "zeta_error", np.nan))
        row[f"{stem}_at_level"] = float(attrs[entry])
        row[f"{stem}_of_record"] = ("record", values)
        row[f"{stem}_error_at_level"] = error
        row[f"{stem}_scatter_at_level"] = float(values.std(ddof=1) / np.sqrt(count)) if count > 1 else np.nan
    row["damping_quality_at_level"] = str(attrs["zeta_quality"])
    for name in ("input_work", "friction_energy"):
        row[f"{name}_at_level"] = float(np.mean([one[name].values[-1] for one in level.histories]))
    return row if "max_slip" not in level.histories[0] else row.merge(_slip_of_records(level.histories))


def _slip_of_records(histories: Sequence[xr.Dataset]) -> xr.Dataset:
    """Fields of the contact points: largest relative displacement and opening of the records, mean slip path."""
    fields = xr.concat([one[list(SLIP)] for one in histories], "record")
    largest = fields["max_slip"].argmax("record")
    found = fields[["max_slip", "open_time_fraction"]].max("record")
    return found.assign(
        cumulative_slip=fields["cumulative_slip"].mean("record"), slipped=fields["slipped"].any("record"),
        least_pressure=fields["least_pressure"].min("record"),
        peak_slip_hoop=fields["peak_slip_hoop"].isel(record=largest),
        peak_slip_axial=fields["peak_slip_axial"].isel(record=largest),
    ).drop_vars("time", errors="ignore")  # fmt: skip


def _common(case: RandomCase, levels: Sequence[Level], found: Reading) -> dict[str, Any]:
    """Attributes that hold for all levels: accuracy of the spectra, size and effort of all histories."""
    everything = [one for level in levels for one in level.histories]
    first, low_high = everything[0].attrs, case.excitation.psd.table.band
    attrs: dict[str, Any] = {name: first[name] for name in ONCE if name in first}
    for names, of_all in ((SUMMED, sum), (WORST, max)):
        for name in names:  # a history that fell back to `condensed` has no basis, nor its error
            if values := [float(one.attrs[name]) for one in everything if name in one.attrs]:
                attrs[name] = of_all(values)
    attrs["method"] = ", ".join(dict.fromkeys(str(one.attrs["method"]) for one in everything))
    attrs |= {name: int(attrs[name]) for name in ("steps", "step_cuts", "reduced_coordinates") if name in attrs}
    accurate = accuracy(found)
    del accurate["psd_peak_bias"], accurate["steady_start_s"]  # of one level
    attrs |= accurate | {"f_low_hz": low_high[0], "f_high_hz": low_high[1], "duration_s": case.excitation.duration}
    return attrs


def _lists(dataset: xr.Dataset) -> dict[str, Any]:
    """Attributes with one number per level, named as in summary.json."""
    found: dict[str, Any] = {}
    for name, variable in LISTED.items():
        if variable in dataset:
            values = dataset[variable]
            over = [dim for dim in values.dims if dim != "level"]
            found[name] = values.max(over).values.tolist() if over else values.values.tolist()
    return found


def level_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """Entries of summary.json that are no attributes: pressure of the interfaces."""
    return summary.interfaces(dataset)
