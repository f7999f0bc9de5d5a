"""HTML pieces of a report: every text is escaped here, pictures are embedded, nothing points outside the file."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

_STYLE = """
:root { --ink: #1b1f24; --soft: #57606a; --line: #d8dee4; --paper: #ffffff; --wash: #f6f8fa; --accent: #0072B2; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--wash); color: var(--ink); font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 1.5rem 2rem 3rem; background: var(--paper); }
h1 { font-size: 1.6rem; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; padding-bottom: .25rem; border-bottom: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.2rem 0 .4rem; }
.lead { color: var(--soft); margin: .2rem 0 0; }
nav { margin: .8rem 0 0; } nav a { margin-right: 1rem; color: var(--accent); }
dl { display: grid; grid-template-columns: fit-content(16rem) 1fr; gap: .3rem 1rem; margin: .6rem 0; }
dt { color: var(--soft); min-width: 8rem; } dd { margin: 0; overflow-wrap: anywhere; }
p, li, figcaption, summary { overflow-wrap: anywhere; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .93rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .25rem .9rem .25rem 0; border-bottom: 1px solid var(--line); vertical-align: top; }
th { color: var(--soft); font-weight: 600; vertical-align: bottom; }
td.n, th.n { text-align: right; } td.n { white-space: nowrap; }
code, pre { font: 13px/1.45 "DejaVu Sans Mono", ui-monospace, monospace; }
pre { background: var(--wash); border: 1px solid var(--line); padding: .8rem; overflow-x: auto; }
details { margin: .5rem 0; } summary { cursor: pointer; color: var(--accent); }
figure { margin: 1rem 0 1.6rem; } figure img { max-width: 100%; height: auto; border: 1px solid var(--line); }
figcaption { color: var(--soft); font-size: .9rem; }
ul.notes { list-style: none; padding: 0; }
ul.notes li { border-left: 4px solid #E69F00; background: #fdf6e6; padding: .45rem .8rem; margin: .4rem 0; }
ul.notes li.bad { border-color: #D55E00; background: #fbeae2; }
.good { color: #1a7f37; }
@media print {
  body { background: none; } main { padding: 0; max-width: none; } nav { display: none; }
  .wide, pre { overflow: visible; } pre { white-space: pre-wrap; } table { font-size: .8rem; }
  h2, h3 { break-after: avoid; } figure, tr { break-inside: avoid; } thead { display: table-header-group; }
}
"""

#: A browser holds to this even where a text slipped through: no script, no request.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"


def text(value: object) -> str:
    """Text for HTML: escaped, and without characters that XML does not know."""
    return escape(_NOT_IN_XML.sub("\ufffd", str(value)), quote=True)


def page(title: str, lead: str, sections: Sequence[tuple[str, str]]) -> str:
    """Whole file.

    Parameters
    ----------
    title, lead
        Plain text.
    sections
        Heading (plain text) and content (HTML of this module); those without content are left out.
    """
    kept = [(f"part-{k}", heading, content) for k, (heading, content) in enumerate(sections, 1) if content]
    links = "".join(f'<a href="#{anchor}">{text(heading)}</a> ' for anchor, heading, _ in kept)
    body = "\n".join(f'<section id="{a}"><h2>{text(heading)}</h2>\n{content}</section>' for a, heading, content in kept)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8" />\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}" />\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1" />\n'
        f"<title>{text(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n<main>\n"
        f'<h1>{text(title)}</h1>\n<p class="lead">{text(lead)}</p>\n<nav aria-label="Sections">{links}</nav>\n{body}\n'
        "</main>\n</body>\n</html>\n"
    )


def paragraph(words: str) -> str:
    """One paragraph."""
    return f"<p>{text(words)}</p>\n"


def terms(pairs: Iterable[tuple[str, str]]) -> str:
    """List of terms and what is said about each."""
    inside = "".join(f"<dt>{text(term)}</dt><dd>{text(words)}</dd>\n" for term, words in pairs)
    return f"<dl>\n{inside}</dl>\n" if inside else ""


def table(head: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: Iterable[int] = ()) -> str:
    """Table of plain texts; columns in `numbers` are set flush right, sentences in them are not."""
    if not rows:
        return ""
    right = set(numbers)

    def line(cells: Sequence[str], tag: str, scope: str = "") -> str:
        number = [' class="n"' if k in right and (scope or len(cell) < 40) else "" for k, cell in enumerate(cells)]
        return "".join(f"<{tag}{scope}{n}>{text(cell)}</{tag}>" for n, cell in zip(number, cells, strict=True))

    top = line(head, "th", ' scope="col"')
    body = "\n".join(f"<tr>{line(row, 'td')}</tr>" for row in rows)
    return (
        '<div class="wide" tabindex="0"><table>\n'  # the keyboard reaches what has to be scrolled
        f"<thead><tr>{top}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table></div>\n"
    )


def notes(items: Iterable[tuple[str, bool]]) -> str:
    """Warnings: text, and whether it says that something went wrong."""
    inside = "".join(f'<li class="{"bad" if bad else "mild"}">{text(words)}</li>\n' for words, bad in items)
    return f'<ul class="notes">\n{inside}</ul>\n' if inside else '<p class="good">None.</p>\n'


def folded(summary: str, content: str) -> str:
    """Content that opens on a click."""
    return f"<details><summary>{text(summary)}</summary>\n{content}</details>\n"


def listing(words: str) -> str:
    """Text as it stands, line by line."""
    return f"<pre>{text(words)}</pre>\n"


def picture(path: Path, caption: str) -> str:
    """PNG file, embedded."""
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return (
        f'<figure><img src="data:image/png;base64,{data}" alt="{text(caption)}" />\n'
        f"<figcaption>{text(caption)}</figcaption></figure>\n"
    )
