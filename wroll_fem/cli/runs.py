"""Commands `wroll run` and `wroll batch`: progress, figures, exit code, and how to continue after an interrupt."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wroll_fem.case import load_case
from wroll_fem.cli.app import CaseFile, Overrides, app, reporting
from wroll_fem.errors import InputError
from wroll_fem.jobs.console import summary_lines
from wroll_fem.jobs.interrupts import stopped_by_signals
from wroll_fem.progress import TerminalProgress

if TYPE_CHECKING:
    from wroll_fem.jobs.grid import Grid


@app.command()
def run(
    case_file: CaseFile,
    out: Annotated[Path | None, typer.Option("--out", help="Run folder; default runs/<name of the case file>.")] = None,
    overrides: Overrides = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue from the checkpoint of the run.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Print problem size and estimated computing time; compute nothing.")
    ] = False,
) -> None:
    """Run a case and write results, summary, fields and figures to the run folder."""
    with reporting():
        case = load_case(case_file, overrides or ())
        if dry_run:
            _print_estimate(case)
            return
        from wroll_fem.jobs.run import run_case

        target = out if out is not None else Path("runs") / case_file.stem
        command = ["wroll", "run", str(case_file), "--out", str(target)]
        command += [word for text in overrides or () for word in ("--set", text)]
        try:
            with stopped_by_signals(), TerminalProgress() as progress:
                done = run_case(case, target, progress=progress, resume=resume, command=shlex.join(command))
        except KeyboardInterrupt:
            from wroll_fem import analyses

            _explain_interrupt(target, command, resumable=analyses.find_analysis(case.analysis).resumable)
            raise typer.Exit(130) from None
        if done.already_done:
            typer.echo(f"{target}: this case is already complete; delete the folder to run it again")
        for line in summary_lines(done.summary):
            typer.echo(line)
        typer.echo(f"run folder  {done.folder.path}")
        for figure in done.figures:
            typer.echo(f"figure      {figure}")


@app.command()
def batch(
    grid_file: Annotated[Path, typer.Argument(metavar="GRID", help="Grid file (YAML).", show_default=False)],
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder for the cases; default runs/<name of the grid file>.")
    ] = None,
    workers: Annotated[int, typer.Option("--workers", help="Number of cases to run at a time.")] = 1,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", help="Run the cases on the Dask cluster at tcp://HOST:PORT instead."),
    ] = None,
    retry: Annotated[bool, typer.Option("--retry", help="Run failed cases of earlier calls again.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Print the cases and their estimated computing time; compute nothing.")
    ] = False,
) -> None:
    """Run the unfinished cases of a grid file; write a table and the figures of the study."""
    with reporting():
        from wroll_fem.jobs.batch import draw_figures, run_grid
        from wroll_fem.jobs.grid import load_grid

        grid = load_grid(grid_file)
        target = out if out is not None else Path("runs") / grid_file.stem
        if dry_run:
            _print_plan(grid, target, workers)
            return
        try:
            with stopped_by_signals(), TerminalProgress() as progress:
                outcomes = run_grid(grid, target, workers=workers, scheduler=scheduler, retry=retry, progress=progress)
        except KeyboardInterrupt:
            typer.echo("interrupted; run the same command again to continue", err=True)
            raise typer.Exit(130) from None
        typer.echo(f"table       {target / 'batch.csv'}")
        failed = [outcome for outcome in outcomes if outcome.status == "failed"]
        for outcome in failed:
            typer.echo(f"{outcome.member.name}: {outcome.error}", err=True)
        before = sum(not outcome.tried for outcome in failed)
        if before:
            typer.echo(f"{before} of these failed in an earlier call; run them again with --retry", err=True)
        if failed:
            typer.echo(f"{len(failed)} of {len(outcomes)} cases failed", err=True)
        try:
            for figure in draw_figures(grid, target):
                typer.echo(f"figure      {figure}")
        except InputError as error:
            if not failed:
                raise
            typer.echo(str(error), err=True)  # the figure may lack the cases that failed
        if failed:
            raise typer.Exit(max(outcome.exit_code for outcome in failed))


def _print_estimate(case: Any) -> None:
    from wroll_fem import analyses

    for text in analyses.case_warnings(case):
        typer.echo(f"warning: {text}")
    for key, value in analyses.estimate(case).items():
        shown = f"{value:.3g}" if isinstance(value, float) else str(value)
        typer.echo(f"{key.replace('_', ' '):<24} {shown}")


def _print_plan(grid: Grid, target: Path, workers: int) -> None:
    """Cases of a grid: folder, what is left to do, estimated seconds; their sum, and the warnings."""
    from wroll_fem import analyses
    from wroll_fem.jobs.folder import RunFolder

    total, unknown = 0.0, 0
    width = max(len(member.name) for member in grid.members)
    for member in grid.members:
        complete = RunFolder(target / member.name).check(member.case, resume=True) == "complete"
        seconds = analyses.estimate(member.case).get("estimated_seconds")
        left = "complete" if complete else "no estimate" if seconds is None else f"{seconds:.3g} s"
        total += 0.0 if complete or seconds is None else seconds
        unknown += not complete and seconds is None
        typer.echo(f"{member.name:<{width}}  {left}")
    for text in dict.fromkeys(text for member in grid.members for text in analyses.case_warnings(member.case)):
        typer.echo(f"warning: {text}")
    without = f", {unknown} cases without an estimate" if unknown else ""
    typer.echo(f"{len(grid.members)} cases, {total / workers:.3g} s with {workers} workers{without}")


def _explain_interrupt(target: Path, command: list[str], *, resumable: bool) -> None:
    from wroll_fem.jobs.folder import RunFolder

    if RunFolder(target).checkpoint_file.is_file():
        typer.echo(f"interrupted; continue with: {shlex.join([*command, '--resume'])}", err=True)
    elif resumable:
        typer.echo("interrupted before the first checkpoint; run the same command again", err=True)
    else:
        typer.echo("interrupted; this analysis has no checkpoints: run the same command again", err=True)
