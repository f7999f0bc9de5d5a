"""Commands for cases: `wroll validate`, `schema`, `mesh` and `export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wroll_fem.case import OnRoll, StructuralCase, load_case, schema_text
from wroll_fem.cli.app import CaseFile, Overrides, app, reporting
from wroll_fem.errors import InputError
from wroll_fem.progress import TerminalProgress
from wroll_fem.results.storage.atomic import make_folder, replacing
from wroll_fem.results.storage.paths import check_path


@app.command()
def validate(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="Case files and grid files.", show_default=False)
    ],
) -> None:
    """Validate case files and grid files; print all errors, and warnings."""
    wrong = 0
    for path in files:
        try:
            warnings = _warnings(path)
        except InputError as error:
            for line in error.lines:
                typer.echo(line, err=True)
            wrong += 1
            continue
        typer.echo(f"{path}: OK")
        for text in warnings:
            typer.echo(f"{path}: warning: {text}")
    if wrong:
        raise typer.Exit(InputError.exit_code)


def _warnings(path: Path) -> list[str]:
    """Warnings about a valid case file, or about the cases of a valid grid file."""
    from wroll_fem import analyses  # reads the file of `structure`
    from wroll_fem.jobs.grid import is_grid, load_grid

    if not is_grid(path):
        return analyses.case_warnings(load_case(path))
    members = load_grid(path).members
    return list(dict.fromkeys(text for member in members for text in analyses.case_warnings(member.case)))


@app.command()
def init(
    case_file: Annotated[Path, typer.Argument(metavar="FILE", help="Case file to write.", show_default=False)],
    analysis: Annotated[str, typer.Option("--analysis", help="Analysis of the case.")] = "sweep",
    overrides: Overrides = None,
    ask: Annotated[bool, typer.Option("--ask", help="Ask for the main dimensions and loads.")] = False,
) -> None:
    """Write a commented case file to start from: the roll of the laboratory, changed by --set or by your answers."""
    with reporting():
        from wroll_fem.case.starter import questions, starter_text

        check_path(case_file, "choose another name")
        if case_file.exists():
            raise InputError("exists", file=str(case_file), remedy="choose another name; nothing is overwritten")
        changed = list(overrides or ())
        if ask:
            given = {text.split("=", 1)[0].strip() for text in changed}
            for key, description, value in questions(analysis):
                if key not in given:
                    changed.append(f"{key}={typer.prompt(f'{key} ({description})', default=value)}")
        text = starter_text(analysis, changed)
        _write(case_file, text, "choose another name")
        typer.echo(f"{case_file}: try `wroll validate {case_file}`, then `wroll run {case_file} --dry-run`")


@app.command()
def schema(
    out: Annotated[Path | None, typer.Option("--out", help="File to write; standard output by default.")] = None,
    grid: Annotated[bool, typer.Option("--grid", help="Schema of the grid file of `wroll batch` instead.")] = False,
) -> None:
    """Print the JSON schema of the case file, for completion and checks in an editor."""
    with reporting():
        from wroll_fem.jobs.grid import grid_schema_text

        text = grid_schema_text() if grid else schema_text()
        if out is None:
            typer.echo(text, nl=False)
            return
        _write(out, text, "choose another --out")
        typer.echo(str(out))


def _write(path: Path, text: str, remedy: str) -> None:
    """Write a text file and its folders; an InputError with ``remedy`` if this is not possible."""
    check_path(path, remedy)
    make_folder(path.parent, remedy)
    with replacing(path, remedy) as file:
        file.write_text(text, encoding="utf-8")


@app.command()
def mesh(
    case_file: CaseFile,
    out: Annotated[Path, typer.Option("--out", help="Folder for mesh.msh and mesh.vtu.", show_default=False)],
    overrides: Overrides = None,
) -> None:
    """Mesh the roll of a case; write the mesh as .msh (with named groups) and as .vtu."""
    with reporting():
        case = _structural(case_file, overrides)
        from wroll_fem.mesh.files import write_mesh
        from wroll_fem.mesh.generate import build_mesh

        if not isinstance(case, OnRoll):
            remedy = "its file contains only matrices; mesh the case from which it was exported"
            raise InputError("cannot be meshed", key="structure", file=str(case_file), remedy=remedy)
        check_path(out, "choose another --out")
        if out.exists() and not out.is_dir():
            raise InputError("is a file, not a folder", file=str(out), remedy="choose another --out")
        built, coil = build_mesh(case), None
        if case.coil.model == "solid":
            from wroll_fem.fem.coil import coil_hexes

            coil = coil_hexes(case, built)
        for path in write_mesh(built, make_folder(out, "choose another --out"), coil=coil):
            typer.echo(str(path))


@app.command()
def export(
    case_file: CaseFile,
    out: Annotated[Path, typer.Option("--out", help="File to write, .npz or .mat.", show_default=False)],
    overrides: Overrides = None,
) -> None:
    """Export matrices, interfaces and preload state of a case (docs/matrices.md)."""
    with reporting():
        case = _structural(case_file, overrides)
        from wroll_fem.dynamics.system.array_file import check_suffix

        check_suffix(out)  # before the work
        check_path(out, "choose another --out")
        from wroll_fem.analyses.shared.preparation import prepare
        from wroll_fem.dynamics.system.io import save_system

        with TerminalProgress() as progress:
            system, state = prepare(case, progress)
        written = save_system(system, out, preload=state)
        size = written.stat().st_size / 1e6
        typer.echo(f"{written}: {system.n_dofs} DOFs, {system.n_points} contact points, {size:.2g} MB")


def _structural(file: Path, overrides: list[str] | None) -> StructuralCase:
    """Load a case that has a mesh or matrices.

    Raises
    ------
    InputError
        If the analysis has neither.
    """
    case = load_case(file, overrides or ())
    if not isinstance(case, StructuralCase):
        remedy = "use an analysis of a roll, for example analysis: modal"
        raise InputError(
            f"analysis {case.analysis} has no mesh and no matrices", key="analysis", file=str(file), remedy=remedy
        )
    return case
