"""Report of a laboratory evaluation, from its folder or its results file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from wroll_fem.errors import WrollError
from wroll_fem.jobs.lab_folder import LabFolder
from wroll_fem.lab.evaluation import result_of
from wroll_fem.lab.kinds import KINDS, find_kind
from wroll_fem.report import html
from wroll_fem.report.run import file_list, logged, metrics, origin_table, plain_case
from wroll_fem.report.values import shown
from wroll_fem.report.words import setting_rows
from wroll_fem.results.summary import label, unit_of

if TYPE_CHECKING:
    import xarray as xr

    from wroll_fem.lab.result import LabResult

CAPTIONS = {
    "transmissibility": "Transmissibility of the conditions versus frequency",
    "damping": "Resonance frequency and damping versus level, with 95 % intervals",
    "fit": "Measured and fitted resonances", "targets": "First frame with the numbers of the targets",
    "slip_groups": "Slip amplitude of the layers per group, with the noise floor",
    "slip_history": "Slip versus time", "slip_spectrum": "Spectrum of the slip",
    "noise": "Positions of the targets at rest versus time, and their spectra",
    "force_displacement": "Shear force versus displacement", "capacity": "Shear capacity versus normal force",
    "coefficient": "Coefficient of friction versus slip rate",
    "rate": "Coefficient of friction versus slip rate, measured and fitted",
    "state": "Coefficient of friction at velocity steps, measured and fitted",
    "elastic_slip": "Shear compliance versus preload, measured and fitted",
    "tension": "Tension versus voltage and current", "pressure": "Wound pressure versus tension",
}  # fmt: skip
"""Name of a figure -> caption."""

_STATUS = {
    "complete": "complete",
    "running": "not finished: still running, or killed",
    "interrupted": "interrupted; run the same command again",
    "failed": "stopped by an error",
}
_NOT_TEXTS = ("settings.yaml", "summary.json", "provenance.json")
_TEXTS = (".csv", ".yaml")


def lab_page(path: Path) -> str:
    """HTML report of the folder of an evaluation, finished or not.

    Raises
    ------
    InputError
        If summary.json or provenance.json cannot be read.
    """
    folder = LabFolder(path)
    origin = folder.provenance()
    summary = folder.summary() if folder.summary_file.is_file() else {}
    status = str(origin.get("status", "complete" if summary else "not finished"))
    warnings = _warnings(status, [*_failure(origin), *logged(folder)], summary)
    result: LabResult | None = None
    try:
        result = folder.load()
    except WrollError as error:
        warnings.append((str(error), True))
    texts = sorted(p for p in path.iterdir() if p.suffix in _TEXTS and p.name not in _NOT_TEXTS)
    tables = html.join(
        html.folded(p.name, html.listing(p.read_text(encoding="utf-8", errors="replace"))) for p in texts
    )
    return _page(
        name=path.resolve().name, kind=str(origin.get("evaluation") or summary.get("evaluation") or ""), status=status,
        written=folder.input_file.read_text(encoding="utf-8", errors="replace"), summary=summary, origin=origin,
        inputs=origin.get("inputs") or (), warnings=warnings, result=result,
        made=sorted(folder.figures.glob("*.png")), tables=tables, files=file_list(path),
    )  # fmt: skip


def lab_result_page(path: Path, dataset: xr.Dataset) -> str:
    """HTML report of a results file of an evaluation, with its content.

    Raises
    ------
    InputError
        If the kind of the evaluation is unknown to this version.
    """
    result = result_of(dataset, str(path))
    return _page(
        name=path.resolve().name, kind=result.kind, status="complete",
        written=str(dataset.attrs.get("settings_yaml", "")), summary=result.summary,
        origin=dict(dataset.attrs.get("provenance") or {}), inputs=result.inputs,
        warnings=_warnings("complete", [], result.summary), result=result,
        made=[], tables=html.Markup(), files=html.Markup(),
    )  # fmt: skip


def _page(
    *,
    name: str,
    kind: str,
    status: str,
    written: str,
    summary: Mapping[str, Any],
    origin: Mapping[str, Any],
    inputs: Sequence[Mapping[str, Any]],
    warnings: list[tuple[str, bool]],
    result: LabResult | None,
    made: list[Path],
    tables: html.Markup,
    files: html.Markup,
) -> str:
    with TemporaryDirectory() as scratch:
        figures = _figures(made, result, Path(scratch))
    return html.page(
        f"Evaluation {name}",
        f"{kind or 'kind unknown'} · {_STATUS.get(status, status)} · {origin.get('time_utc', '')}",
        [
            ("What was evaluated", _evaluated(kind, written) + _inputs(inputs)),
            ("Warnings", html.notes(warnings)),
            ("Metrics", _metrics(summary)),
            ("Figures", figures),
            ("Tables", tables),
            ("Versions and provenance", origin_table(origin)),
            ("Files", files),
        ],
    )


def _evaluated(kind: str, written: str) -> html.Markup:
    """Kind and settings of an evaluation."""
    known = kind in KINDS
    words = html.paragraph(f"{kind}. {KINDS[kind].sentence}" if known else f"{kind or 'The kind is unknown'}.")
    rows = setting_rows(find_kind(kind).settings.model_fields if known else {}, plain_case(written))
    return words + html.case_table(rows) + html.folded("Settings file", html.listing(written))


def _inputs(inputs: Sequence[Mapping[str, Any]]) -> html.Markup:
    """Table of the files that were evaluated."""
    found = [one for one in inputs if isinstance(one, dict)]
    rows = [[str(one.get(key, "")) for key in ("path", "bytes", "sha256")] for one in found]
    return html.folded(f"Inputs ({len(rows)})", html.table(("input", "bytes", "SHA-256"), rows, numbers=(1,)))


def _metrics(summary: Mapping[str, Any]) -> html.Markup:
    """Tables of summary.json; entries with a value per parameter share one table."""
    named = {key: value for key, value in summary.items() if isinstance(value, dict) and value}
    parts = [metrics({key: value for key, value in summary.items() if key not in named})]
    for keys in dict.fromkeys(tuple(value) for value in named.values()):
        columns = {name: value for name, value in named.items() if tuple(value) == keys}
        rows = [
            [key, *(shown(key if unit_of(key) else name, value[key]) for name, value in columns.items())]
            for key in keys
        ]
        parts.append(html.subheading("Parameters"))
        parts.append(html.table(("name", *map(label, columns)), rows, numbers=range(1, len(columns) + 1)))
    return html.join(parts)


def _failure(origin: Mapping[str, Any]) -> list[tuple[str, str]]:
    return [("error", str(origin["error"]))] if origin.get("error") else []


def _warnings(status: str, messages: Sequence[tuple[str, str]], summary: Mapping[str, Any]) -> list[tuple[str, bool]]:
    """Warnings of the evaluation as pairs (text, whether it is an error), equal ones once."""
    found: list[tuple[str, bool]] = []
    if status != "complete":
        found.append((f"The evaluation is {_STATUS.get(status, status)}.", True))
    for kind, text in (*messages, *(("warning", text) for text in summary.get("warnings") or ())):
        if (text, kind == "error") not in found:
            found.append((text, kind == "error"))
    return found


def _figures(made: list[Path], result: LabResult | None, scratch: Path) -> html.Markup:
    """Figures of the evaluation; drawn from its results if the folder has none."""
    if not made and result is not None:
        made = result.write_figures(scratch)
    order = list(CAPTIONS)
    made = sorted(made, key=lambda p: (order.index(p.stem) if p.stem in order else len(order), p.stem))
    return html.join(html.figure(p, CAPTIONS.get(p.stem, p.stem.replace("_", " ").capitalize())) for p in made)
