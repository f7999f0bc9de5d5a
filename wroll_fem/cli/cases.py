"""Commands for cases: `wroll validate`, `schema`, `mesh` and `export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wroll_fem.case import OnRoll, StructuralCase, load_case, schema_text
from wroll_fem.cli.app import CaseFile, Overrides, app, reporting
from wroll_fem.errors import InputError
from wroll_fem.progress import TerminalProgress


@app.command()
def validate(
    case_files: Annotated[list[Path], typer.Argument(metavar="CASE...", help="Case files.", show_default=False)],
) -> None:
    """Validate case files and print errors and warnings."""
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
    with reporting():
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
    """Mesh the roll of a case; write the mesh as .msh (with named groups) and as .vtu."""
    with reporting():
        case = _structural(case_file, overrides)
        from wroll_fem.mesh.files import write_mesh
        from wroll_fem.mesh.generate import build_mesh

        if not isinstance(case, OnRoll):
            remedy = "its file contains only matrices; mesh the case from which it was exported"
            raise InputError("cannot be meshed", key="structure", file=str(case_file), remedy=remedy)
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
    """Export matrices, interfaces and preload state of a case (docs/matrices.md)."""
    with reporting():
        case = _structural(case_file, overrides)
        from wroll_fem.dynamics.system.array_file import check_suffix

        check_suffix(out)  # before the work
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
