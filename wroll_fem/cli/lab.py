"""Commands `wroll lab KIND`: evaluate measurements into a folder; one command per kind, made from their table."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from wroll_fem.cli.app import app, reporting
from wroll_fem.jobs.console import summary_lines
from wroll_fem.jobs.interrupts import stopped_by_signals
from wroll_fem.lab.kinds import KINDS, find_kind
from wroll_fem.progress import TerminalProgress

lab = typer.Typer(
    name="lab", no_args_is_help=True, context_settings={"help_option_names": ["-h", "--help"]}, rich_markup_mode=None
)
app.add_typer(
    lab, name="lab",
    help="Evaluate measurements: records, images, friction tests. Settings, results and figures go to a folder.",
)  # fmt: skip

Files = Annotated[list[Path], typer.Argument(metavar="FILE...", help="Measurements.", show_default=False)]
Out = Annotated[Path, typer.Option("--out", help="Folder for the results; new or empty.", show_default=False)]
SettingsFile = Annotated[
    Path | None, typer.Option("--settings", metavar="FILE", help="Settings (YAML); the rest are defaults.")
]
Changes = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a setting by its dotted key. Repeatable.")
]


class KindCommand(TyperCommand):
    """Command whose help ends with the files and settings of the kind."""

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write what the files contain, and each setting with its default; the module of the kind is imported here."""
        kind = find_kind(str(ctx.info_name))
        with formatter.section("Files"):
            formatter.write_text(kind.files)
        rows = []
        for name, field in kind.settings.model_fields.items():
            default = "" if field.is_required() else _default(field.get_default(call_default_factory=True))
            rows.append((name, f"{field.description or ''}{default}"))
        with formatter.section("Settings (--settings, --set)"):
            formatter.write_dl(rows)


def _default(value: Any) -> str:
    if value is None or hasattr(type(value), "model_fields") or value == () or value == []:
        return ""
    return f"  [default: {str(value).lower() if isinstance(value, bool) else value}]"


def _evaluate(kind: str, files: list[Path], out: Path, settings: Path | None, changes: list[str] | None) -> None:
    with reporting():
        from wroll_fem.jobs.lab_run import run_lab
        from wroll_fem.lab.settings import read_settings

        complete = read_settings(find_kind(kind).settings, settings, changes or ())
        command = ["wroll", "lab", kind, *map(str, files), *(["--settings", str(settings)] if settings else [])]
        command += [word for text in changes or () for word in ("--set", text)]
        command += ["--out", str(out)]
        try:
            with stopped_by_signals(), TerminalProgress() as progress:
                result, figures = run_lab(
                    kind, files, complete, out, progress=progress, command=shlex.join(command)
                )  # fmt: skip
        except KeyboardInterrupt:
            typer.echo("interrupted; run the same command again", err=True)
            raise typer.Exit(130) from None
        for line in summary_lines(result.summary):
            typer.echo(line)
        typer.echo(f"folder      {out}")
        for figure in figures:
            typer.echo(f"figure      {figure}")


def _command(kind: str) -> Callable[..., None]:
    def evaluate(files: Files, out: Out, settings: SettingsFile = None, changes: Changes = None) -> None:
        _evaluate(kind, files, out, settings, changes)

    return evaluate


for _name, _listed in KINDS.items():
    lab.command(_name, help=_listed.sentence, short_help=_listed.sentence, cls=KindCommand)(_command(_name))


@lab.command("example", short_help="Write example measurements of a kind, with known truth.")
def example(
    kind: Annotated[str, typer.Argument(metavar="KIND", help="Kind of evaluation.", show_default=False)],
    out: Annotated[Path, typer.Option("--out", help="Folder for the files; new or empty.", show_default=False)],
) -> None:
    """Write example measurements of a kind, computed with known truth, with settings; print the command to try."""
    with reporting():
        from wroll_fem.lab.examples import write_example

        for line in write_example(kind, out):
            typer.echo(line)
