"""Typer application and shared parts of its commands: options and error messages."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from wroll_fem.errors import WrollError
from wroll_fem.results.provenance import program_version

app = typer.Typer(
    name="wroll", help="Dynamics of wound rolls: transmissibility, damping and slip maps from a case file.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]}, pretty_exceptions_enable=False, rich_markup_mode=None,
)  # fmt: skip

CaseFile = Annotated[Path, typer.Argument(metavar="CASE", help="Case file (YAML).", show_default=False)]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a dotted key, e.g. contact.friction.mu=0.5. Repeatable."),
]


@contextmanager
def reporting() -> Iterator[None]:
    """Context manager: report an error in one line on standard error, and exit with the exit code of the error."""
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
    """Dynamics of wound rolls: transmissibility, damping and slip maps from a case file."""
