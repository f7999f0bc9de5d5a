"""Commands for results: `wroll plot`, `wroll compare` and `wroll report`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from wroll_fem.cli.app import app, reporting
from wroll_fem.results.storage.paths import check_path


@app.command()
def plot(
    run_dir: Annotated[
        Path,
        typer.Argument(
            metavar="RUN_DIR",
            help="Folder of a run or of a laboratory evaluation, or a results file (.nc).",
            show_default=False,
        ),
    ],
) -> None:
    """Redraw the figures of a run, or of a laboratory evaluation, from its results."""
    with reporting():
        from wroll_fem.jobs.folder import RunFolder
        from wroll_fem.jobs.lab_folder import LabFolder
        from wroll_fem.lab.evaluation import is_evaluation, result_of
        from wroll_fem.results.dataset import load_dataset

        check_path(run_dir)
        alone = run_dir.is_file()
        folder = RunFolder(run_dir.parent if alone else run_dir)
        measured = LabFolder(folder.path)
        if not alone and measured.is_one():
            dataset = measured.load().data
        else:
            dataset = load_dataset(run_dir) if alone else folder.load()
        from wroll_fem import analyses

        redraw = (
            result_of(dataset).write_figures if is_evaluation(dataset) else partial(analyses.write_figures, dataset)
        )
        for path in redraw(folder.subfolder(folder.figures)):
            typer.echo(str(path))


@app.command()
def compare(
    paths: Annotated[
        list[Path],
        typer.Argument(
            metavar="CURVE...",
            show_default=False,
            help="Run folders, results files (.nc), tables (.csv: frequency in Hz and |T|, or its two parts).",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", help="Figure to write (.png, .pdf or .svg).")] = Path("comparison.png"),
) -> None:
    """Draw transmissibility curves over each other and print their resonances."""
    with reporting():
        from wroll_fem.jobs.comparison import comparison_lines, load_curves
        from wroll_fem.plotting.style import save_figure
        from wroll_fem.plotting.transmissibility import plot_comparison

        for path in (*paths, out):
            check_path(path)
        curves = load_curves(paths)
        for line in comparison_lines(curves):
            typer.echo(line)
        typer.echo(f"figure      {save_figure(plot_comparison(curves), out)}")


@app.command()
def report(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR",
            help="Folder of a run, a batch or a laboratory evaluation, or a results file (.nc).",
            show_default=False,
        ),
    ],
    out: Annotated[Path | None, typer.Option("--out", help="File to write; default DIR/report.html.")] = None,
) -> None:
    """Write one self-contained HTML file about a run, a batch or a laboratory evaluation."""
    with reporting():
        from wroll_fem.report import write_report

        typer.echo(str(write_report(folder, out)))
