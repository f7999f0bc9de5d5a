"""Commands for the project: `wroll reproduce` and `wroll info`."""

from __future__ import annotations

import json
import shlex
import sys
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer

from wroll_fem.cli.app import app, reporting
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.jobs.interrupts import stopped_by_signals
from wroll_fem.progress import TerminalProgress
from wroll_fem.results.provenance import program_version


@app.command()
def reproduce(
    chapters: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[CHAPTER]...", help="ch2 ch3 ch4 ch5 ch6 appendices; all by default.", show_default=False
        ),
    ] = None,
    fast: Annotated[
        bool, typer.Option("--fast", help="Coarse meshes and fewer values: about 25 minutes on two cores.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", help="Folder for runs, table and page; delete it to repeat all runs. Default runs/reproduce."
        ),
    ] = None,
    workers: Annotated[int, typer.Option("--workers", help="Number of cases to run at a time.")] = 2,
    page: Annotated[
        Path | None, typer.Option("--page", help="Where to write the page (Markdown); default OUT/claims.md.")
    ] = None,
) -> None:
    """Check the claims of the thesis with stored or new runs; print one line per claim."""
    with reporting():
        judge_all = _reproduction().reproduce

        folder = out if out is not None else Path("runs") / ("reproduce_fast" if fast else "reproduce")
        command = ["wroll", "reproduce", *(chapters or ()), *(["--fast"] if fast else [])]
        try:
            with stopped_by_signals(), TerminalProgress() as progress:
                done = judge_all(
                    chapters or (), folder, fast=fast, workers=workers, progress=progress, page=page,
                    command=shlex.join(command),
                )  # fmt: skip
        except KeyboardInterrupt:
            typer.echo("interrupted; run the same command again to continue", err=True)
            raise typer.Exit(130) from None
        typer.echo(done.count)
        for path in done.written:
            typer.echo(f"written     {path}")
        if done.unfinished:
            typer.echo(f"not computed, because a run failed: {', '.join(done.unfinished)}", err=True)
            raise typer.Exit(ConvergenceError.exit_code)


def _reproduction() -> Any:
    """Import `reproduction.reproduce`, which exists only in a clone of the project."""
    root = Path(__file__).resolve().parents[2]
    if not (root / "reproduction" / "reproduce.py").is_file():
        remedy = "use a clone of the project, with its folders reproduction/ and configs/"
        raise InputError("the claims of the thesis are not part of the installed package", remedy=remedy)
    if str(root) not in sys.path:
        sys.path.insert(0, str(root))
    return import_module("reproduction.reproduce")


@app.command()
def materials() -> None:
    """Print the materials that a case file may name, with their properties and sources."""
    from wroll_fem.bodies.material_library import LIBRARY

    for name, known in LIBRARY.items():
        low, high = known.range_E
        typer.echo(f"{name}: {known.title}")
        typer.echo(f"  E = {known.E / 1e9:g} GPa ({low / 1e9:g} to {high / 1e9:g}), nu = {known.nu:g}, "
                   f"rho = {known.rho:g} kg/m^3")  # fmt: skip
        if known.yield_stress is not None:
            typer.echo(f"  yield stress {known.yield_stress / 1e6:g} MPa")
        if known.friction is not None:
            typer.echo(f"  friction against itself: mu = {known.friction[0]:g} to {known.friction[1]:g}")
        typer.echo(f"  source: {known.source}")


@app.command()
def info(
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, for scripts and bug reports.")] = False,
) -> None:
    """Print the version of each library and whether the library works."""
    from wroll_fem.jobs.environment import OPTIONAL, check_environment

    parts = check_environment()
    if as_json:
        libraries = {part.name: {"version": part.version, "problem": part.problem or None} for part in parts}
        typer.echo(json.dumps({"wroll_fem": program_version(), "libraries": libraries}, indent=2))
    else:
        typer.echo(f"{'wroll_fem':<10} {program_version()}")
        for part in parts:
            state = "works" if not part.problem else f"DOES NOT WORK: {part.problem}"
            typer.echo(f"{part.name:<10} {part.version:<12} {state}")
    if any(part.problem and part.name not in OPTIONAL for part in parts):
        raise typer.Exit(1)
