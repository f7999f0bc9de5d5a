"""Python functions of `import wroll_fem as wf`: run cases in memory or into folders, and read results."""

from __future__ import annotations

import io
import itertools
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wroll_fem.case import Case
from wroll_fem.case.loader import build_case
from wroll_fem.case.strict_yaml import parse_yaml
from wroll_fem.errors import InputError
from wroll_fem.jobs.grid import REFERENCE, Grid, load_grid
from wroll_fem.progress import Progress, TerminalProgress

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.analyses.slip_model import SlipModel
    from wroll_fem.jobs.batch import Outcome
    from wroll_fem.plotting.study import StudyCase

ShowProgress = bool | Progress | None


class CaseWarning(UserWarning):
    """Python warning about a case or its results, with a remedy. A run that shows progress prints it instead."""


class _Quiet(TerminalProgress):
    """Progress that issues warnings as Python warnings and writes the log of a run folder."""

    def __init__(self) -> None:
        super().__init__(io.StringIO(), bars=False)

    def warning(self, text: str) -> None:
        super().warning(text)
        _warn(text)


def _warn(text: str) -> None:
    """Issue a Python warning attributed to the line that calls this package."""
    frame, level = sys._getframe(1), 2  # level 1 is this function
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).split(".")[0] == "wroll_fem":
        frame, level = frame.f_back, level + 1
    warnings.warn(text, CaseWarning, stacklevel=level)


@contextmanager
def _reporting(progress: ShowProgress) -> Iterator[Progress]:
    """Context manager that yields the progress reporter for the argument `progress`."""
    if progress is not None and not isinstance(progress, bool):
        yield progress
    else:
        shown = sys.stdout.isatty() if progress is None else progress
        with TerminalProgress() if shown else _Quiet() as reporter:
            yield reporter


def run(case: Case, *, out: str | Path | None = None, progress: ShowProgress = None) -> xr.Dataset:
    """Run a case and return its results.

    Parameters
    ----------
    case
        Case from `load_case`, `example_case` or `Case`.
    out
        Run folder as with `wroll run --out`: case, results, summary, fields, figures, log. If the folder contains the
        finished case, its results are read; an unfinished run continues from its checkpoint. None writes nothing.
    progress
        True shows bars on a terminal and lines elsewhere; False shows nothing; None, the default, shows bars on a
        terminal and nothing elsewhere, for example in notebooks. An object with the methods of
        `wroll_fem.progress.Progress` receives the reports. If nothing is shown, warnings are issued as `CaseWarning`.

    Returns
    -------
    xr.Dataset
        Variables with `units` and `long_name`; docs/api.md lists them for each analysis. Attributes: numbers of the
        summary, and the provenance in `analysis`, `case_yaml`, `case_hash` and `provenance`.

    Raises
    ------
    InputError
        If the case is invalid, or `out` contains another case or other files.
    ConvergenceError
        If a step does not converge; results up to that step are in `out`, and in ``partial`` of the error.
    KeyboardInterrupt
        After an interrupt; with `out`, sweep, dwell, harmonic and backbone save a checkpoint, from which the same
        call continues.
    """
    if not isinstance(case, Case):
        remedy = "load it first: run(load_case(path))"
        raise InputError(f"is not a case but a {type(case).__name__}", key="case", remedy=remedy)
    from wroll_fem.jobs.run import run_case, with_provenance

    with _reporting(progress) as reporter:
        if out is not None:
            done = run_case(case, out, progress=reporter, resume=True, command=f"wroll_fem.run(case, out={str(out)!r})")
            return load_result(done.folder.path)
        from wroll_fem import analyses

        for text in analyses.case_warnings(case):
            reporter.warning(text)
        return with_provenance(analyses.run_analysis(case, progress=reporter), case)


def load_result(path: str | Path) -> xr.Dataset:
    """Read results from a run folder, or from a file written by `save_result`.

    Raises
    ------
    InputError
        If there are no results.
    """
    from wroll_fem.results.dataset import load_dataset

    path = Path(path)
    dataset = load_dataset(path / "results.nc" if path.is_dir() else path)
    if not dataset.attrs.get("complete", True):
        _warn(f"{path}: results of an incomplete run")
    return dataset


def case_of(result: xr.Dataset) -> Case:
    """Return the case from which a result was computed.

    Raises
    ------
    InputError
        If the result does not contain its case.
    """
    if "case_yaml" not in result.attrs:
        raise InputError("does not contain its case", key="result", remedy="pass the result of run(case)")
    return build_case(parse_yaml(str(result.attrs["case_yaml"]), "result"))


def summarise(result: xr.Dataset, case: Case | None = None) -> dict[str, Any]:
    """Summarise a result as in summary.json: flat, in SI, with units in the names.

    Parameters
    ----------
    case
        Case of the Dataset; needed only if the Dataset does not name its analysis.

    Raises
    ------
    InputError
        If the analysis is unknown.
    """
    from wroll_fem import analyses

    return analyses.summarise(result, case)


def transmissibility(result: xr.Dataset) -> xr.DataArray:
    """Return |T| versus frequency of a sweep, a harmonic response or the two-mass model.

    Returns
    -------
    xr.DataArray
        Dimension `frequency` in Hz; for the two-mass model, dimensions `friction_capacity` and `omega`.

    Raises
    ------
    InputError
        If the result has no transmissibility.
    """
    from wroll_fem.signals.transmissibility import magnitude

    if "omega" in result.dims and "transmissibility" in result:
        return result["transmissibility"]
    if "transmissibility_real" not in result:
        remedy = "use analysis sweep, harmonic or two_dof"
        raise InputError("has no transmissibility versus frequency", key="result", remedy=remedy)
    return magnitude(result)


def slip_model(case: Case, *, progress: ShowProgress = None) -> SlipModel:
    """Compute the modes of a modal_transient case once, to reuse them for slip at many excitation levels.

    Parameters
    ----------
    case
        Case of the analysis modal_transient.
    progress
        As for `run`.

    Returns
    -------
    SlipModel
        Its method `run(case)` computes, in a few milliseconds, the result of any case that differs in excitation level,
        friction, damping, frequency or winding.

    Raises
    ------
    InputError
        If the case has another analysis.
    """
    from wroll_fem.analyses.slip_model import SlipModel

    with _reporting(progress) as reporter:
        return SlipModel.of(case, progress=reporter)


def run_series(
    case: Case, keys: Mapping[str, Sequence[Any]], *, reference: Case | None = None, progress: ShowProgress = None
) -> list[StudyCase]:
    """Run a case in memory for every combination of key values, one run after another, for the figures of a study.

    Parameters
    ----------
    case
        Case that is varied.
    keys
        Dotted key -> its values.
    reference
        Reference case, run once.

    Returns
    -------
    list of StudyCase
        Name, `values` (dotted key -> value) and `data` (the result) of every case; the reference is last.

    Raises
    ------
    InputError
        If a key or value is invalid; then no case is run.
    ConvergenceError
        If a case does not converge.

    Notes
    -----
    While only preload, contact laws and excitation vary, the bodies are assembled once, and so are the modes of
    `harmonic` and `backbone`. The results are those of single runs.
    For longer studies use `run_grid`, which runs cases in parallel processes and keeps finished cases.
    """
    from wroll_fem.dynamics.reduction.kept_structure import keeping_structure
    from wroll_fem.plotting.study import StudyCase, shown

    members = []
    for combination in itertools.product(*keys.values()):
        values = dict(zip(keys, combination, strict=True))
        members.append((", ".join(shown(key, value) for key, value in values.items()), values, case.changed(values)))
    with keeping_structure():
        done = [StudyCase(name, values, run(one, progress=progress)) for name, values, one in members]
    if reference is not None:
        done.append(StudyCase(REFERENCE, {}, run(reference, progress=progress), reference=True))
    return done


def run_grid(
    grid: Grid | str | Path,
    out: str | Path,
    *,
    workers: int = 1,
    scheduler: str | None = None,
    retry: bool = False,
    progress: ShowProgress = None,
) -> list[Outcome]:
    """Run the unfinished cases of a grid, like `wroll batch`; see `wroll_fem.jobs.batch.run_grid`.

    Parameters
    ----------
    grid
        Grid file, or grid from `load_grid`.
    out
        Folder for the run folders of the cases, and for the table that `batch_table` reads.
    workers, scheduler
        Number of cases at a time on this machine, or address of a Dask scheduler.
    retry
        Run again the cases that failed in earlier calls; otherwise they are only reported.

    Returns
    -------
    list of Outcome
        `member` (name, values, case), `status` and `error` of each case. A failed case does not stop the others;
        if progress is not shown, failures are issued as a `CaseWarning`.

    Raises
    ------
    InputError
        If the grid is invalid, or the folder contains another batch.
    """
    from wroll_fem.jobs.batch import run_grid as run_all

    grid = grid if isinstance(grid, Grid) else load_grid(grid)
    with _reporting(progress) as reporter:
        outcomes = run_all(grid, out, workers=workers, scheduler=scheduler, retry=retry, progress=reporter)
    failed = [outcome for outcome in outcomes if outcome.status == "failed"]
    if failed and isinstance(reporter, _Quiet):
        _warn(f"{len(failed)} of {len(outcomes)} cases failed; {failed[0].member.name}: {failed[0].error}")
    return outcomes


def batch_table(out: str | Path) -> xr.Dataset:
    """Read the table of a batch: one row per case, with keys and scalar summary values in their units.

    Raises
    ------
    InputError
        If the folder has no table.
    """
    import xarray as xr

    source = Path(out) / "batch.nc"
    if not source.is_file():
        raise InputError("table of a batch not found", file=str(source), remedy="give the folder of a batch")
    try:
        return xr.load_dataset(source, engine="h5netcdf")
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read ({error})", file=str(source), remedy="run the batch again") from None


def load_series(grid: Grid | str | Path, out: str | Path) -> list[StudyCase]:
    """Read the finished cases of a batch, for the figures of a study.

    Returns
    -------
    list of StudyCase
        Cases in the order of the grid, without unfinished cases and outdated results.

    Raises
    ------
    InputError
        If the grid is invalid.
    """
    from wroll_fem.jobs.batch import load_series as load

    return load(grid if isinstance(grid, Grid) else load_grid(grid), out)
