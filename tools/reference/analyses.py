"""Table of the analyses in docs/api.md: variables and figures of each, from the registry."""

from __future__ import annotations

from pathlib import Path

from tools.reference.markdown import code, table
from wroll_fem.analyses.registry import Analysis, all_analyses
from wroll_fem.plotting.series import FIGURES

BEGIN, END = "<!-- Table made by `make schema` from the registry of analyses. -->\n", "\n<!-- End of table. -->"

_STUDIES = (
    "a list from `run_series`, `load_series`",
    "`member.values`, `member.data`",
    f"`curves`, {', '.join(map(code, FIGURES))}, `study_figure(name, members)`",
)
_WRITES_A_FILE = ("slip_on_cylinder", "slip_in_coil")


def analyses_table() -> str:
    """Markdown table: analysis, main variables with their dimensions, figures of `wf.plot`."""
    rows = [(code(one.name), _variables(one), ", ".join(map(_plot, one.plots))) for one in all_analyses()]
    return table(("analysis", "variables (dimensions)", "figures: `wf.plot.`"), [*rows, _STUDIES])


def with_table(page: str) -> str:
    """Page with the table between its two markers replaced."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}{analyses_table()}{END}{after}"


def write_table(path: Path) -> Path:
    """Write the table into a page."""
    path.write_text(with_table(path.read_text(encoding="utf-8")), encoding="utf-8")
    return path


def _variables(one: Analysis) -> str:
    return "; ".join(f"{', '.join(map(code, names))} ({dims})" for dims, names in one.variables.items())


def _plot(name: str) -> str:
    return code(name) + (" (file)" if name in _WRITES_A_FILE else "")
