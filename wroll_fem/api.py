"""What `import wroll_fem as wf` offers beyond cases: run them, in memory or into folders, and read what is there."""

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
from wroll_fem.errors import InputError
from wroll_fem.jobs.grid import REFERENCE, Grid, load_grid
from wroll_fem.progress import Progress, TerminalProgress

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.analyses.slip_model import SlipModel
    from wroll_fem.jobs.batch import Outcome
    from wroll_fem.plotting.study import SeriesMember

ShowProgress = bool | Progress | None


class CaseWarning(UserWarning):
    """Warning about a case or its results, with what to change; issued where no progress is shown."""


class _Quiet(TerminalProgress):
    """Shows nothing but Python warnings; still writes the log of a run folder."""

    def __init__(self) -> None:
        super().__init__(io.StringIO(), bars=False)

    def warning(self, text: str) -> None:
        super().warning(text)
        _warn(text)


def _warn(text: str) -> None:
    """Python warning that points to the line outside of this package from which the work was started."""
    frame, level = sys._getframe(1), 2  # level 1 is this function
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).split(".")[0] == "wroll_fem":
        frame, level = frame.f_back, level + 1
    warnings.warn(text, CaseWarning, stacklevel=level)


@contextmanager
def _reporting(progress: ShowProgress) -> Iterator[Progress]:
    """Progress as the argument of that name wants it."""
    if progress is not None and not isinstance(progress, bool):
        yield progress
    else:
        shown = sys.stdout.isatty() if progress is None else progress
        with TerminalProgress() if shown else _Quiet() as reporter:
            yield reporter


def run(case: Case, *, out: str | Path | None = None, progress: ShowProgress = None) -> xr.Dataset:
    """Run a case.

    Parameters
    ----------
    case
        What to compute (`load_case`, `example_case`, `Case`).
    out
        Run folder, the same that `wroll run --out` makes: case, results, summary, fields, figures, log. A case that is
        done there is read and not computed again; an unfinished one goes on from its checkpoint. Without, nothing is
        written.
    progress
        True shows bars, or lines where the output is no terminal; False is silent; None, the default, shows bars on a
        terminal and is silent elsewhere, in notebooks for example. Also any object with the methods of
        `wroll_fem.progress.Progress`. Where nothing is shown, warnings about the case are issued as `CaseWarning`.

    Returns
    -------
    xr.Dataset
        Variables with `units` and `long_name`; docs/api.md lists them for each analysis. Attributes: numbers of the
        summary, and the origin in `analysis`, `case_yaml`, `case_hash` and `provenance`.

    Raises
    ------
    InputError
        When the case cannot be run, or `out` holds something else.
    ConvergenceError
        When a step did not converge; what was computed until then is in `out`, and in ``partial`` of the error.
    KeyboardInterrupt
        After saving a checkpoint (analyses sweep and dwell, with `out`): the same call goes on from there.
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
    """Read the results of a run: its folder, or a file that `save_result` wrote.

    Raises
    ------
    InputError
        When there are none.
    """
    from wroll_fem.results.dataset import load_dataset

    path = Path(path)
    dataset = load_dataset(path / "results.nc" if path.is_dir() else path)
    if not dataset.attrs.get("complete", True):
        _warn(f"{path}: results of a run that did not finish")
    return dataset


def case_of(result: xr.Dataset) -> Case:
    """Return the case that a result was computed from.

    Raises
    ------
    InputError
        When the result does not hold it.
    """
    import yaml

    if "case_yaml" not in result.attrs:
        raise InputError("does not hold its case", key="result", remedy="pass the result of run(case)")
    return build_case(yaml.safe_load(result.attrs["case_yaml"]))


def summarise(result: xr.Dataset, case: Case | None = None) -> dict[str, Any]:
    """Numbers of a result, as in summary.json: flat, SI, the unit in the name.

    Parameters
    ----------
    case
        Only for a Dataset that does not name its analysis.

    Raises
    ------
    InputError
        When neither names the analysis.
    """
    from wroll_fem import analyses

    return analyses.summarise(result, case)


def transmissibility(result: xr.Dataset) -> xr.DataArray:
    """|T| over frequency of a sweep, a harmonic response or the two masses.

    Returns
    -------
    xr.DataArray
        Over `frequency` in Hz; of the two masses over `friction_capacity` and `omega`.

    Raises
    ------
    InputError
        When the result holds no such curve.
    """
    from wroll_fem.signals.transmissibility import magnitude

    if "omega" in result.dims and "transmissibility" in result:
        return result["transmissibility"]
    if "transmissibility_real" not in result:
        remedy = "take one of analysis sweep, harmonic or two_dof"
        raise InputError("holds no transmissibility over frequency", key="result", remedy=remedy)
    return magnitude(result)


def slip_model(case: Case, *, progress: ShowProgress = None) -> SlipModel:
    """Solve a case of the analysis modal_transient once, to ask for its slip at many levels.

    Returns
    -------
    SlipModel
        `run(case)` gives the result of any case that differs in level, friction, damping, frequency or winding at the
        cost of a few milliseconds.

    Raises
    ------
    InputError
        For a case of another analysis.
    """
    from wroll_fem.analyses.slip_model import SlipModel

    with _reporting(progress) as reporter:
        return SlipModel.of(case, progress=reporter)


def run_series(
    case: Case, keys: Mapping[str, Sequence[Any]], *, reference: Case | None = None, progress: ShowProgress = None
) -> list[SeriesMember]:
    """Run every combination of dotted keys one after the other in memory, for the figures of a study.

    Parameters
    ----------
    case
        What the series starts from.
    keys
        Dotted key -> its values.
    reference
        A case to run once beside them, to compare with.

    Returns
    -------
    list of SeriesMember
        With `name`, `values` (dotted key -> value) and `data` (the result); the reference last.

    Raises
    ------
    InputError
        For a key or value that does not fit, before anything is run.
    ConvergenceError
        From the first case that does not converge.

    Notes
    -----
    `run_grid` takes longer series: in processes of their own, with what is done kept.
    """
    from wroll_fem.plotting.study import SeriesMember, shown

    members = []
    for combination in itertools.product(*keys.values()):
        values = dict(zip(keys, combination, strict=True))
        members.append((", ".join(shown(key, value) for key, value in values.items()), values, case.changed(values)))
    done = [SeriesMember(name, values, run(one, progress=progress)) for name, values, one in members]
    if reference is not None:
        done.append(SeriesMember(REFERENCE, {}, run(reference, progress=progress), reference=True))
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
    """Run every case of a grid that is not yet done, as `wroll batch` does; see `wroll_fem.jobs.batch.run_grid`.

    Parameters
    ----------
    grid
        Grid file, or what `load_grid` made of it.
    out
        Folder that gets one run folder per case, and the table that `batch_table` reads.
    workers, scheduler
        Cases at a time on this machine, or the address of a Dask scheduler.
    retry
        Try cases again that failed in an earlier call; without it they stay failed and are reported.

    Returns
    -------
    list of Outcome
        `member` (name, values, case), `status` and `error` of every case. A failed case stops no other; where no
        progress is shown, failures are issued as a `CaseWarning`.

    Raises
    ------
    InputError
        For a grid that is wrong, or a folder that holds another batch.
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
    """Read the table of a batch: one row per case, its keys and every single number of its summary, with units.

    Raises
    ------
    InputError
        When the folder holds no table.
    """
    import xarray as xr

    source = Path(out) / "batch.nc"
    if not source.is_file():
        raise InputError("no table of a batch", file=str(source), remedy="give the folder of run_grid or `wroll batch`")
    try:
        return xr.load_dataset(source, engine="h5netcdf")
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read ({error})", file=str(source), remedy="run the batch again") from None


def load_series(grid: Grid | str | Path, out: str | Path) -> list[SeriesMember]:
    """Read the finished cases of a batch, for the figures of a study.

    Returns
    -------
    list of SeriesMember
        In the order of the grid; cases without results, or with those of another case, are left out.

    Raises
    ------
    InputError
        For a grid that is wrong.
    """
    from wroll_fem.jobs.batch import load_series as load

    return load(grid if isinstance(grid, Grid) else load_grid(grid), out)
