"""The `wroll` command.

Heavy libraries are imported inside the commands that need them, so that `wroll validate` answers at once.
"""

from __future__ import annotations

import os
import shlex
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import FrameType
from typing import Annotated, Any

# One thread per process: the solvers work on small matrices, where threads only get in each other's way.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")

import typer

from wroll_fem.case import load_case, schema_text
from wroll_fem.errors import ConvergenceError, InputError, WrollError
from wroll_fem.jobs.console import summary_lines
from wroll_fem.progress import TerminalProgress
from wroll_fem.results.provenance import program_version

app = typer.Typer(
    name="wroll", help="Dynamics of wound rolls: from a case file to transmissibility, damping and slip maps.",
    no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None,
)  # fmt: skip

CaseFile = Annotated[Path, typer.Argument(metavar="CASE", help="Case file (YAML).", show_default=False)]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a dotted key, e.g. contact.friction.mu=0.5. Repeatable."),
]


@contextmanager
def _reporting() -> Iterator[None]:
    """One line on standard error instead of a traceback, and the documented exit code."""
    try:
        yield
    except WrollError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(error.exit_code) from None


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"wroll_fem {program_version()}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Dynamics of wound rolls: from a case file to transmissibility, damping and slip maps."""


@app.command()
def run(
    case_file: CaseFile,
    out: Annotated[Path | None, typer.Option("--out", help="Run folder; default runs/<name of the case file>.")] = None,
    overrides: Overrides = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the checkpoint of an unfinished run.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only say how large the job is and how long it takes.")
    ] = False,
) -> None:
    """Run a case: results, summary, fields and figures go to the run folder."""
    with _reporting():
        case = load_case(case_file, overrides or ())
        if dry_run:
            _print_estimate(case)
            return
        from wroll_fem.jobs.run import run_case

        target = out if out is not None else Path("runs") / case_file.stem
        command = ["wroll", "run", str(case_file), "--out", str(target)]
        command += [word for text in overrides or () for word in ("--set", text)]
        try:
            with _sigterm_interrupts(), TerminalProgress() as progress:
                done = run_case(case, target, progress=progress, resume=resume, command=shlex.join(command))
        except KeyboardInterrupt:
            from wroll_fem import analyses

            _explain_interrupt(target, command, resumable=analyses.find_analysis(case.analysis).resumable)
            raise typer.Exit(130) from None
        if done.already_done:
            typer.echo(f"{target}: this case is already done; delete the folder to run it again")
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
    workers: Annotated[int, typer.Option("--workers", help="Cases to run at a time.")] = 1,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", help="tcp://HOST:PORT of a Dask cluster whose workers run the cases instead."),
    ] = None,
    retry: Annotated[bool, typer.Option("--retry", help="Try cases again that failed in an earlier call.")] = False,
) -> None:
    """Run a grid of cases: only what is not yet done; one table and the study's figures at the end."""
    with _reporting():
        from wroll_fem.jobs.batch import draw_figures, run_grid
        from wroll_fem.jobs.grid import load_grid

        grid = load_grid(grid_file)
        target = out if out is not None else Path("runs") / grid_file.stem
        try:
            with _sigterm_interrupts(), TerminalProgress() as progress:
                outcomes = run_grid(grid, target, workers=workers, scheduler=scheduler, retry=retry, progress=progress)
        except KeyboardInterrupt:
            typer.echo("interrupted; the same command goes on from here", err=True)
            raise typer.Exit(130) from None
        typer.echo(f"table       {target / 'batch.csv'}")
        failed = [outcome for outcome in outcomes if outcome.status == "failed"]
        for outcome in failed:
            typer.echo(f"{outcome.member.name}: {outcome.error}", err=True)
        before = sum(not outcome.tried for outcome in failed)
        if before:
            typer.echo(f"{before} failed in an earlier call and stay so; --retry tries them again", err=True)
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


@app.command()
def validate(
    case_files: Annotated[list[Path], typer.Argument(metavar="CASE...", help="Case files.", show_default=False)],
) -> None:
    """Check case files and say what is wrong or doubtful in them."""
    wrong = 0
    for path in case_files:
        try:
            case = load_case(path)
            from wroll_fem import analyses

            warnings = analyses.case_warnings(case)  # reads the file of `structure`
        except InputError as error:
            typer.echo(str(error), err=True)
            wrong += 1
            continue
        typer.echo(f"{path}: OK")
        for text in warnings:
            typer.echo(f"{path}: warning: {text}")
    if wrong:
        raise typer.Exit(InputError.exit_code)


@app.command()
def schema(
    out: Annotated[Path | None, typer.Option("--out", help="File to write; standard output by default.")] = None,
) -> None:
    """Print the JSON schema of the case file, for completion and checks in an editor."""
    with _reporting():
        if out is None:
            typer.echo(schema_text(), nl=False)
            return
        try:
            out.parent.mkdir(parents=True, exist_ok=True)
            out.write_text(schema_text(), encoding="utf-8")
        except OSError as error:
            raise InputError(
                f"cannot be written ({error.strerror})", file=str(out), remedy="choose another --out"
            ) from None
        typer.echo(str(out))


@app.command()
def mesh(
    case_file: CaseFile,
    out: Annotated[Path, typer.Option("--out", help="Folder for mesh.msh and mesh.vtu.", show_default=False)],
    overrides: Overrides = None,
) -> None:
    """Mesh a case and write it as .msh (named groups) and .vtu."""
    with _reporting():
        case = load_case(case_file, overrides or ())
        from wroll_fem.mesh.files import write_mesh
        from wroll_fem.mesh.generate import build_mesh

        _refuse_winding(case, case_file)
        if case.structure is not None:
            remedy = "its file holds matrices alone: mesh the case it was exported from"
            raise InputError("leaves nothing to mesh", key="structure", file=str(case_file), remedy=remedy)
        if out.exists() and not out.is_dir():
            raise InputError("is a file, not a folder", file=str(out), remedy="choose another --out")
        built, coil = build_mesh(case), None
        if case.coil.model == "solid":
            from wroll_fem.fem.coil import coil_hexes

            coil = coil_hexes(case, built)
        try:
            written = write_mesh(built, out, coil=coil)
        except OSError as error:
            remedy = "choose another --out"
            raise InputError(f"cannot be written ({error.strerror})", file=str(out), remedy=remedy) from None
        for path in written:
            typer.echo(str(path))


@app.command()
def export(
    case_file: CaseFile,
    out: Annotated[Path, typer.Option("--out", help="File to write, .npz or .mat.", show_default=False)],
    overrides: Overrides = None,
) -> None:
    """Mesh, assemble and preload a case, and write its matrices and interfaces (docs/matrices.md)."""
    with _reporting():
        case = load_case(case_file, overrides or ())
        _refuse_winding(case, case_file)
        from wroll_fem.dynamics.system.array_file import check_suffix

        check_suffix(out)  # before the work
        from wroll_fem.analyses.shared.preparation import prepare
        from wroll_fem.dynamics.system.io import save_system

        with TerminalProgress() as progress:
            system, state = prepare(case, progress)
        written = save_system(system, out, preload=state)
        size = written.stat().st_size / 1e6
        typer.echo(f"{written}: {system.n_dofs} DOFs, {system.n_points} contact points, {size:.2g} MB")


@app.command()
def plot(
    run_dir: Annotated[Path, typer.Argument(metavar="RUN_DIR", help="Folder of a run.", show_default=False)],
) -> None:
    """Draw the figures of a run again from its results."""
    with _reporting():
        from wroll_fem.jobs.folder import RunFolder

        folder = RunFolder(run_dir)
        dataset = folder.load()
        from wroll_fem import analyses

        folder.figures.mkdir(exist_ok=True)
        for path in analyses.write_figures(dataset, folder.figures):
            typer.echo(str(path))


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a run or of a batch.", show_default=False)],
    out: Annotated[Path | None, typer.Option("--out", help="File to write; default DIR/report.html.")] = None,
) -> None:
    """Write one self-contained HTML file about a run or a batch."""
    with _reporting():
        from wroll_fem.report import write_report

        typer.echo(str(write_report(folder, out)))


@app.command()
def reproduce(
    chapters: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[CHAPTER]...", help="ch2 ch3 ch4 ch5 ch6 appendices; all by default.", show_default=False
        ),
    ] = None,
    fast: Annotated[bool, typer.Option("--fast", help="Coarse meshes, fewer values: a quarter of an hour.")] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", help="Folder for runs, table and page; delete it to run all anew. Default runs/reproduce."
        ),
    ] = None,
    workers: Annotated[int, typer.Option("--workers", help="Cases to run at a time.")] = 2,
    page: Annotated[
        Path | None, typer.Option("--page", help="Where to write the page (Markdown); default OUT/claims.md.")
    ] = None,
) -> None:
    """Judge the claims of the source, one line each, from stored or fresh runs."""
    with _reporting():
        judge_all = _reproduction().reproduce

        folder = out if out is not None else Path("runs") / ("reproduce_fast" if fast else "reproduce")
        command = ["wroll", "reproduce", *(chapters or ()), *(["--fast"] if fast else [])]
        try:
            with _sigterm_interrupts(), TerminalProgress() as progress:
                done = judge_all(
                    chapters or (), folder, fast=fast, workers=workers, progress=progress, page=page,
                    command=shlex.join(command),
                )  # fmt: skip
        except KeyboardInterrupt:
            typer.echo("interrupted; the same command goes on from here", err=True)
            raise typer.Exit(130) from None
        typer.echo(done.count)
        for path in done.written:
            typer.echo(f"written     {path}")
        if done.unfinished:
            typer.echo(f"not computed, because a run failed: {', '.join(done.unfinished)}", err=True)
            raise typer.Exit(ConvergenceError.exit_code)


def _reproduction() -> Any:
    """Module `reproduction.reproduce` of the clone that this package runs from; the package alone does not have it."""
    root = Path(__file__).resolve().parents[1]
    if not (root / "reproduction" / "reproduce.py").is_file():
        remedy = "run from a clone of the project, whose folders reproduction/ and configs/ have them"
        raise InputError("the claims of the thesis are not part of the installed package", remedy=remedy)
    if str(root) not in sys.path:
        sys.path.insert(0, str(root))
    return import_module("reproduction.reproduce")


@app.command()
def info() -> None:
    """Print the version of every library underneath, and whether it works."""
    from wroll_fem.jobs.environment import OPTIONAL, check_environment

    typer.echo(f"{'wroll_fem':<10} {program_version()}")
    broken = False
    for part in check_environment():
        state = "works" if not part.problem else f"DOES NOT WORK: {part.problem}"
        typer.echo(f"{part.name:<10} {part.version:<12} {state}")
        broken = broken or bool(part.problem and part.name not in OPTIONAL)
    if broken:
        raise typer.Exit(1)


def _refuse_winding(case: Any, file: Path) -> None:
    if case.analysis in ("winding", "two_dof"):
        remedy = "use a case with geometry, mandrel and coil"
        raise InputError(
            f"analysis {case.analysis} has no mesh and no matrices", key="analysis", file=str(file), remedy=remedy
        )


def _print_estimate(case: Any) -> None:
    from wroll_fem import analyses

    for text in analyses.case_warnings(case):
        typer.echo(f"warning: {text}")
    for key, value in analyses.estimate(case).items():
        shown = f"{value:.3g}" if isinstance(value, float) else str(value)
        typer.echo(f"{key.replace('_', ' '):<24} {shown}")


def _explain_interrupt(target: Path, command: list[str], *, resumable: bool) -> None:
    from wroll_fem.jobs.folder import RunFolder

    if RunFolder(target).checkpoint_file.is_file():
        typer.echo(f"interrupted; go on with: {shlex.join([*command, '--resume'])}", err=True)
    elif resumable:
        typer.echo(
            "interrupted before the first checkpoint; run the same command again (--resume goes on later)", err=True
        )
    else:
        typer.echo("interrupted; this analysis has no checkpoints: run the same command again", err=True)


@contextmanager
def _sigterm_interrupts() -> Iterator[None]:
    """Let a terminated job save itself like an interrupted one."""

    def interrupt(signum: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def main() -> None:
    """Entry point of the `wroll` command."""
    try:
        app()
    except BrokenPipeError:  # the reader (head, less) has gone: nothing left to tell
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)


if __name__ == "__main__":
    main()
