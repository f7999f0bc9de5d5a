"""Commands for results: `wroll plot` and `wroll report`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wroll_fem.cli.app import app, reporting


@app.command()
def plot(
    run_dir: Annotated[
        Path, typer.Argument(metavar="RUN_DIR", help="Folder of a run, or a results file (.nc).", show_default=False)
    ],
) -> None:
    """Redraw the figures of a run from its results."""
    with reporting():
        from wroll_fem.jobs.folder import RunFolder
        from wroll_fem.results.dataset import load_dataset

        alone = run_dir.is_file()
        folder = RunFolder(run_dir.parent if alone else run_dir)
        dataset = load_dataset(run_dir) if alone else folder.load()
        from wroll_fem import analyses

        folder.figures.mkdir(exist_ok=True)
        for path in analyses.write_figures(dataset, folder.figures):
            typer.echo(str(path))


@app.command()
def report(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR", help="Folder of a run or of a batch, or a results file (.nc).", show_default=False
        ),
    ],
    out: Annotated[Path | None, typer.Option("--out", help="File to write; default DIR/report.html.")] = None,
) -> None:
    """Write one self-contained HTML file about a run or a batch."""
    with reporting():
        from wroll_fem.report import write_report

        typer.echo(str(write_report(folder, out)))
