"""Reference of the laboratory evaluations: files, settings, results and figures of each kind."""

from __future__ import annotations

from pydantic import BaseModel

from tools.reference.case import section_parts
from tools.reference.markdown import GENERATED, code, prose, table
from wroll_fem.lab.kinds import KINDS, Kind, find_kind

_INTRO = """# Laboratory

`wroll lab KIND` evaluates measurements ([how](../laboratory.md)). Settings stand in a YAML file (`--settings`), on the
command line (`--set KEY=VALUE`) or in the call `wf.lab.evaluate(kind, files, KEY=VALUE)`. Units are SI; a number may be
written with another unit, such as `"200 mV"`. An unknown key is refused. Names of the results: [results](results.md).
"""


def lab_page() -> str:
    """Markdown of all kinds."""
    rows = ((f"[{code(name)}](#{name.replace('_', '-')})", one.sentence) for name, one in KINDS.items())
    parts = [GENERATED, _INTRO, table(("kind", "computes"), rows)]
    told: dict[type[BaseModel], str] = {}
    for name, listed in KINDS.items():
        kind = find_kind(name)
        settings = section_parts(name, kind.settings, told, tagged=False, level=2)
        parts += [f"## {name}", prose(f"{listed.sentence} {kind.files}"), *settings[2:], *_results(kind)]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _results(kind: Kind) -> list[str]:
    """Main variables and figures of a kind."""
    variables = "; ".join(f"{', '.join(map(code, names))} ({dims})" for dims, names in kind.variables.items())
    found = [f"Variables of results.nc: {variables}."] if variables else []
    figures = ", ".join(map(code, kind.figures))
    return [*found, *([f"Figures: {figures}."] if figures else [])]
