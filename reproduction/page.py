"""Markdown page on all claims: tables, figures and explanations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from reproduction.checklist import CHAPTERS, explanations
from reproduction.evidence import Evidence
from reproduction.reproduce import Judged, claim_groups, count
from reproduction.verdict import NOT_MET, THESIS_ERROR
from reproduction.words import table
from wroll_fem.errors import WrollError
from wroll_fem.plotting.style import save_figure


def unexplained(judged: Sequence[Judged]) -> list[str]:
    """Ids of claims that are not met or reveal an error in the thesis, and have no explanation yet."""
    return [
        one.claim.id
        for one in judged
        if one.verdict.word in (NOT_MET, THESIS_ERROR) and one.claim.id not in explanations()
    ]


def write_page(judged: Sequence[Judged], evidence: Evidence, path: Path, command: str) -> list[Path]:
    """Write the page and its figures, in the folder figures/ next to it.

    Parameters
    ----------
    command
        Command that wrote the page, for its head.

    Returns
    -------
    list of Path
        The page and the figures.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    coarse = " with coarse meshes (`--fast`)" if evidence.fast else ""
    lines = ["# The claims of the thesis", ""]
    lines += [f"Written by `{command}`{coarse}: {count(judged)}.", ""]
    lines += [
        "Each row restates one claim of the thesis (A. Wen, \"Vibration Damping of Coiled Structures Through "
        "Frictional Slip\", PhD thesis, California Institute of Technology, 2024) as a test of computed results, with "
        "its criterion. No input was tuned. An input that the thesis does not state is named with the value used. A "
        "verdict *by construction* cannot fail (a definition, arithmetic, or a law that is put in and read out): it is "
        "a check of the program, no evidence, and is counted apart.",
        "",
    ]  # fmt: skip
    written = [path]
    for chapter in dict.fromkeys(one.claim.chapter for one in judged):
        own = [one for one in judged if one.claim.chapter == chapter]
        lines += [f"## {CHAPTERS[chapter]}", "", f"{count(own)}.", "", table_of(own), ""]
        drawn, text = draw(chapter, evidence, path.parent / "figures")
        written += drawn
        lines += text
        lines += explained(own)
    path.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")
    return written


def table_of(judged: Sequence[Judged]) -> str:
    """Markdown table of some claims."""
    rows = [
        (
            one.claim.id, f"{one.claim.claim} ({one.claim.where})", one.claim.accept, one.verdict.value,
            f"**{one.verdict.word}**{one.label.removeprefix(one.verdict.word)}",
        )
        for one in judged
    ]  # fmt: skip
    return table(("id", "claim of the thesis", "criterion", "computed here", "verdict"), rows)


def draw(chapter: str, evidence: Evidence, folder: Path) -> tuple[list[Path], list[str]]:
    """Draw the figures of a chapter; return their files and the Markdown lines of figures and tables.

    Tables are omitted if the evidence is fast.
    """
    paths: list[Path] = []
    lines: list[str] = []
    for group in claim_groups(chapter):
        for name, (caption, drawing) in group.figures.items():
            try:
                paths.append(save_figure(drawing(evidence), folder / f"{name}.png"))
            except WrollError as error:
                evidence.progress.warning(f"figure {name} is not drawn: {error}")
                lines += [f"*{caption}: not drawn ({error}).*", ""]
                continue
            lines += [f"![{caption}](figures/{name}.png)", "", f"*{caption}*", ""]
        for name, text in group.tables.items() if not evidence.fast else ():  # studies beside the claims
            lines += [f"**{name}**", "", text(evidence).strip(), ""]
    return paths, lines


def explained(judged: Sequence[Judged]) -> list[str]:
    """Explanations of the claims that have one, as Markdown sections."""
    lines = []
    for one in judged:
        text = explanations().get(one.claim.id)
        if text:
            lines += [f"### {one.claim.id}: {one.verdict.word}", "", text, ""]
    return lines
