"""Report of a run folder."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from wroll_fem.case.strict_yaml import parse_yaml
from wroll_fem.errors import InputError, WrollError
from wroll_fem.jobs.folder import ResultFolder, RunFolder
from wroll_fem.report import html
from wroll_fem.report.damping import damping_table
from wroll_fem.report.ledger import energy_ledger
from wroll_fem.report.values import open_balance, shown
from wroll_fem.report.words import NUMERICS, analysis_words, case_rows
from wroll_fem.results.summary import EFFORT, GROUPS, label

if TYPE_CHECKING:
    import xarray as xr

_STATUS = {
    "complete": "complete",
    "running": "not finished: still running, or killed",
    "interrupted": "interrupted; `wroll run ... --resume` continues it",
    "not_converged": "stopped: a step did not converge",
    "failed": "stopped by an error",
}
_LOGGED = re.compile(r"^\S+ (warning|error): (.*)$")
_OF_INTERFACES = (
    "interface_pressure_mean_pa", "external_pressure_pa", "winding_pressure_pa", "wrap_interfaces",
    "slipping_area_fraction",
)  # fmt: skip
_OF_MODES = ("modes_hz", "mode_kinds", "mode_damping_ratios", "effective_mass_fraction")
_DRIFT = 0.01
_CAPTIONS = {
    "transmissibility": "Transmissibility versus frequency",
    "two_dof": "Transmissibility of the two masses versus frequency",
    "slip_damping": "Tip motion, damping and frequency at resonance versus base acceleration",
    "backbone": "Frequency and damping of the resonance versus amplitude", "response": "Motion of the tip versus time",
    "spectra": "PSD of base and tip, transmissibility H1 and coherence versus frequency",
    "levels": "Frequency, damping and rms of the tip versus level",
    "energy_ledger": "Energies versus time", "slip_on_cylinder": "Slip on the roll",
    "two_dof_readings": "Damping, peak, its frequency and skewness versus friction capacity",
    "two_dof_design_space": "Largest damping versus mass and stiffness of the secondary",
    "modes": "Natural frequencies", "mode_shapes": "Mode shapes", "winding": "Pressure and stress in the wound roll",
    "margin": "Margin against yield versus wall",
    "design_map": "Map of mandrels", "slip_zone": "Slip zone", "root_section": "Shear stress at the root",
    "steady_response": "Tip motion from rest to steady state", "shear_distribution": "Shear versus height and radius",
    "slip_in_coil": "Slip in the coil", "slip_work": "Slip zone and slip work in the coil",
    "slip_work_sections": "Slip zone and slip work at the root", "slip_work_in_coil": "Slip work in the coil",
}  # fmt: skip


def run_page(path: Path) -> str:
    """HTML report of a run folder, complete or not.

    Raises
    ------
    InputError
        If summary.json or provenance.json cannot be read.
    """
    folder = RunFolder(path)
    written = folder.case_file.read_text(encoding="utf-8", errors="replace")
    summary = folder.summary() if folder.summary_file.is_file() else {}
    origin = folder.provenance()
    dataset, trouble = _results(folder)
    status = str(origin.get("status", "complete" if summary else "not finished"))
    errors = [("error", str(why))] if (why := origin.get("error")) else []
    warnings = run_warnings([*errors, *logged(folder)], status, summary, dataset) + [(text, True) for text in trouble]
    made = sorted(folder.figures.glob("*.png"))
    return _page(
        path.resolve().name, written, summary, origin | {"status": status}, dataset, warnings, made, file_list(path)
    )


def result_page(path: Path, dataset: xr.Dataset) -> str:
    """HTML report of a results file of a run, with its content."""
    from wroll_fem import analyses

    complete = bool(dataset.attrs.get("complete", True))
    summary = analyses.summarise(dataset) if complete else {}
    status = "complete" if complete else "not finished"
    origin = {**dataset.attrs.get("provenance", {}), "case_hash": dataset.attrs.get("case_hash"), "status": status}
    warnings = run_warnings([], status, summary, dataset)
    written = str(dataset.attrs.get("case_yaml", ""))
    return _page(path.resolve().name, written, summary, origin, dataset, warnings, [], html.Markup())


def _page(
    name: str,
    written: str,
    summary: Mapping[str, Any],
    origin: Mapping[str, Any],
    dataset: xr.Dataset | None,
    warnings: list[tuple[str, bool]],
    figures: list[Path],
    files: html.Markup,
) -> str:
    """HTML page with the available data of a run."""
    given, status = plain_case(written), str(origin["status"])
    with TemporaryDirectory() as scratch:
        drawn = _figures(figures, dataset, Path(scratch))
    return html.page(
        f"Run {name}",
        f"{given.get('analysis', 'analysis unknown')} · {_STATUS.get(status, status)} · {origin.get('time_utc', '')}",
        [
            ("What was solved", solved(given) + html.folded("Case file", html.listing(written))),
            ("Warnings", html.notes(warnings)),
            ("Metrics", metrics(summary)),
            ("Figures", drawn),
            ("Damping by several methods", damping_table(dataset) if dataset is not None else html.Markup()),
            ("Energy ledger", energy_ledger(dataset) if dataset is not None else html.Markup()),
            ("Versions and provenance", origin_table(origin)),
            ("Files", files),
        ],
    )


def solved(given: Mapping[str, Any]) -> html.Markup:
    """HTML of the analysis and the keys of a case, with the numerical settings collapsed."""
    rows = case_rows(given)
    physics = [row for row in rows if row.key.split(".")[0] not in NUMERICS]
    numerics = [row for row in rows if row not in physics]
    content = html.paragraph(analysis_words(given)) + html.case_table(physics)
    return content + (html.folded("Mesh and numerical settings", html.case_table(numerics)) if numerics else "")


def plain_case(written: str) -> Mapping[str, Any]:
    """Content of a case.yaml; empty if it is no case."""
    try:
        given = parse_yaml(written, "case.yaml")
    except InputError:
        return {}
    return _with_text_keys(given) if isinstance(given, dict) else {}


def _with_text_keys(given: Any) -> Any:
    """Content of a YAML file with texts as keys; a key that is a number is shown as written."""
    if isinstance(given, Mapping):
        return {str(key): _with_text_keys(value) for key, value in given.items()}
    return [_with_text_keys(entry) for entry in given] if isinstance(given, list) else given


def _results(folder: RunFolder) -> tuple[xr.Dataset | None, list[str]]:
    from wroll_fem.results.dataset import load_dataset

    if not folder.results_file.is_file():
        return None, ["there are no results (results.nc): figures and energy ledger are left out"]
    try:
        return load_dataset(folder.results_file), []
    except WrollError as error:
        return None, [f"{error}: figures and energy ledger are left out"]


def run_warnings(
    messages: Sequence[tuple[str, str]], status: str, summary: Mapping[str, Any], dataset: xr.Dataset | None
) -> list[tuple[str, bool]]:
    """Warnings issued by the run, and warnings about its results, as pairs (text, whether it is an error).

    Parameters
    ----------
    messages
        (Kind, text) of run.log.
    status
        Status of the run.
    summary
        Content of summary.json.
    dataset
        Results; None if there are none.
    """
    found: list[tuple[str, bool]] = []
    if status != "complete":
        found.append((f"The run is {_STATUS.get(status, status)}; numbers may be missing or partial.", True))
    for kind, words in (*messages, *(("warning", text) for text in summary.get("warnings") or [])):
        if (words, kind == "error") not in found:
            found.append((words, kind == "error"))
    gap = open_balance(summary)
    if gap is not None:
        found.append((f"The energy balance error is {gap:.2%} of the input (energy_balance_error).", True))
    drift = summary.get("steady_drift")
    if isinstance(drift, float) and drift > _DRIFT and not summary.get("steady_doubt"):
        found.append((f"The response is not steady: it still changes by {drift:.1%} (steady_drift).", True))
    cuts = summary.get("step_cuts")
    if cuts:
        found.append((f"{cuts} time steps were cut because Newton's method did not converge (step_cuts).", False))
    reason = dataset.attrs.get("half_power_reason") if dataset is not None else None
    if reason:
        found.append((f"Half power: {reason}.", False))
    return found


def logged(folder: ResultFolder) -> list[tuple[str, str]]:
    """Messages of run.log, in order: ("warning" or "error", text)."""
    if not folder.log_file.is_file():
        return []
    lines = folder.log_file.read_text(encoding="utf-8", errors="replace").splitlines()
    return [(m[1], m[2]) for m in map(_LOGGED.match, lines) if m]


def metrics(summary: Mapping[str, Any]) -> html.Markup:
    """Tables of summary.json: scalar values, interfaces, modes."""
    if not summary:
        return html.paragraph("There is no summary.json: the run is not complete.")
    lists = {
        key: value
        for key, value in summary.items()
        if isinstance(value, list) and value and key != "warnings" and not _is_pair(key, summary)
    }
    head = ("quantity", "value", "in summary.json")
    single = [(label(k), shown(k, v), k) for k, v in summary.items() if k not in (*lists, "analysis", "warnings")]
    parts = [html.table(head, [row for row in single if row[2] not in GROUPS[EFFORT]], numbers=(1,))]
    for title, first, names in (("Interface", "interface", _OF_INTERFACES), ("Mode", "mode", _OF_MODES)):
        columns = {name: lists.pop(name) for name in names if name in lists}
        if not columns:
            continue
        count = max(map(len, columns.values()))
        rows = [
            [str(k + 1), *(shown(name, values[k]) if k < len(values) else "" for name, values in columns.items())]
            for k in range(count)
        ]
        shared = f"{title}s, inner first" if title == "Interface" else f"{title}s"
        parts.append(html.subheading(shared))
        parts.append(html.table((first, *map(label, columns)), rows, numbers=range(1, len(columns) + 1)))
    effort = html.table(head, [row for row in single if row[2] in GROUPS[EFFORT]], numbers=(1,))
    for count in dict.fromkeys(map(len, lists.values())):  # lists of one length belong together
        columns = {key: values for key, values in lists.items() if len(values) == count}
        rows = [[str(k + 1), *(shown(key, values[k]) for key, values in columns.items())] for k in range(count)]
        parts.append(html.subheading("Series"))
        parts.append(html.table(("number", *map(label, columns)), rows, numbers=range(1, len(columns) + 1)))
    return html.join(parts) + (html.subheading(EFFORT) + effort if effort else html.Markup())


def _is_pair(name: str, summary: Mapping[str, Any]) -> bool:
    """Whether an entry is the interval of a single value, and not a list of intervals."""
    return "_interval" in name and isinstance(summary.get(name.replace("_interval", "")), float)


def _figures(made: list[Path], dataset: xr.Dataset | None, scratch: Path) -> html.Markup:
    """Figures of the run; drawn from its results if the folder has none."""
    if not made and dataset is not None:
        from wroll_fem import analyses

        try:
            made = sorted(analyses.write_figures(dataset, scratch))
        except WrollError as error:
            return html.paragraph(f"No figures: {error}")
    order = list(_CAPTIONS)
    made.sort(key=lambda p: (order.index(p.stem) if p.stem in order else len(order), p.stem))
    return html.join(html.figure(path, caption(path.stem)) for path in made)


def caption(stem: str) -> str:
    """Caption of a figure from the name of its file."""
    if stem in _CAPTIONS:
        return _CAPTIONS[stem]
    numbered = re.fullmatch(r"(slip_map|peak_slip|pressure)_(\d+)", stem)
    if numbered:
        what = {
            "slip_map": "Slip map",
            "peak_slip": "Largest slip",
            "pressure": "Pressure",
        }[numbered[1]]
        return f"{what}, interface {int(numbered[2])} (inner first)"
    return stem.replace("_", " ").capitalize()


def origin_table(origin: Mapping[str, Any]) -> html.Markup:
    """Versions, revision, machine, command and times from provenance.json."""
    if not origin:
        return html.paragraph("There is no provenance.json.")
    git, machine = origin.get("git") or {}, origin.get("machine") or {}
    revision = git.get("revision") or "unknown"
    if git.get("modified"):
        revision += ", with changes"
    entries = [
        ("Command", origin.get("command")),
        ("Case hash", origin.get("case_hash")),
        ("Revision", revision),
        ("Finished", origin.get("time_utc")),
        ("Wall time, figures included", shown("wall_time_s", origin.get("wall_time_s"))),
        ("Resumed", shown("resumed", origin.get("resumed"))),
        ("Machine", ", ".join(f"{k}: {v}" for k, v in machine.items() if v is not None)),
        ("Seeds", json.dumps(origin["seeds"]) if origin.get("seeds") else None),
    ]
    versions = ", ".join(f"{name} {version}" for name, version in (origin.get("versions") or {}).items() if version)
    return html.terms([(k, str(v)) for k, v in entries if v not in (None, "", "none")] + [("Versions", versions)])


def file_list(path: Path) -> html.Markup:
    """Names and sizes of the files of a folder."""
    found = sorted(p for p in path.rglob("*") if p.is_file() and p.name not in ("report.html", ".lock"))
    rows = [(str(p.relative_to(path)), f"{p.stat().st_size / 1e3:,.1f} kB") for p in found[:200]]
    return html.folded(f"{len(found)} files", html.table(("file", "size"), rows, numbers=(1,)))
