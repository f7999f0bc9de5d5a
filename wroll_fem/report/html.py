"""Pages of a report, their sections, table of contents and links, from Jinja2 templates.

Jinja2 escapes every text that does not come from a template. Figures are embedded, and the file refers to no other
file. A content security policy also forbids scripts and requests.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Sequence
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

if TYPE_CHECKING:
    from wroll_fem.report.words import CaseRow

__all__ = [
    "Markup", "case_table", "figure", "folded", "join", "listing", "notes", "page", "paragraph", "subheading", "table",
    "terms",
]  # fmt: skip

_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def _legible(value: Any) -> Any:
    """Text without characters that XML forbids; markup is unchanged."""
    return value if isinstance(value, Markup) else _NOT_IN_XML.sub("\ufffd", str(value))


@cache
def _environment() -> Environment:
    return Environment(
        loader=FileSystemLoader(Path(__file__).with_name("templates")), autoescape=True, finalize=_legible,
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip


def _block(name: str, *arguments: Any) -> Markup:
    """HTML element, made by a macro of the template blocks.html.j2."""
    made: Markup = getattr(_environment().get_template("blocks.html.j2").module, name)(*arguments)
    return made


def join(parts: Iterable[Markup]) -> Markup:
    """Join elements in sequence."""
    return Markup().join(parts)


def page(title: str, lead: str, sections: Sequence[tuple[str, Markup]]) -> str:
    """Complete HTML file.

    Parameters
    ----------
    title, lead
        Plain text.
    sections
        Heading (plain text) and content; those without content are left out.
    """
    kept = [(f"part-{k}", heading, content) for k, (heading, content) in enumerate(sections, 1) if content]
    return _environment().get_template("page.html.j2").render(title=title, lead=lead, sections=kept)


def paragraph(words: str) -> Markup:
    """Paragraph."""
    return _block("paragraph", words)


def subheading(words: str) -> Markup:
    """Subheading."""
    return _block("subheading", words)


def terms(pairs: Iterable[tuple[str, str]]) -> Markup:
    """List of terms with their descriptions; empty without terms."""
    listed = list(pairs)
    return _block("terms", listed) if listed else Markup()


def table(head: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: Iterable[int] = ()) -> Markup:
    """Table of texts; empty without rows.

    Parameters
    ----------
    head
        Column headings.
    rows
        Texts of the cells.
    numbers
        Indices of right-aligned columns.
    """
    return _block("table", head, rows, set(numbers)) if rows else Markup()


def case_table(rows: Sequence[CaseRow]) -> Markup:
    """Table of the keys of a case, grouped by case section; empty without rows."""
    groups = [(section, list(group)) for section, group in groupby(rows, key=lambda row: row.section)]
    return _block("case_table", groups) if groups else Markup()


def notes(items: Iterable[tuple[str, bool]]) -> Markup:
    """List of warnings, from pairs (text, whether it is an error)."""
    return _block("notes", list(items))


def folded(summary: str, content: Markup) -> Markup:
    """Collapsible element."""
    return _block("folded", summary, content)


def listing(words: str) -> Markup:
    """Preformatted text."""
    return _block("listing", words)


def figure(path: Path, caption: str) -> Markup:
    """Embedded PNG file."""
    return _block("figure", base64.b64encode(path.read_bytes()).decode("ascii"), caption)
