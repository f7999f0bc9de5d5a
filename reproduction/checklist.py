"""The checklist: every claim of the thesis, its place in the thesis, and the criterion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import yaml

from wroll_fem.errors import InputError

CHAPTERS = {
    "ch2": "Chapter 2: winding stress and slip prediction",
    "ch3": "Chapter 3: vibration experiments",
    "ch4": "Chapter 4: finite-element model at lab scale",
    "ch5": "Chapter 5: two-degree-of-freedom model",
    "ch6": "Chapter 6: realistic scale",
    "appendices": "Appendices",
}
"""Name on the command line -> title."""


@dataclass(frozen=True)
class Claim:
    """One claim of the thesis.

    Attributes
    ----------
    id
        C1 to C126.
    chapter
        Key of `CHAPTERS`.
    claim, where
        What the thesis states, and where.
    kind
        value, ordering, definition or experiment.
    accept
        Criterion for the verdict "met".
    caution
        Errors and missing information in the thesis; may be empty.
    by_construction
        Whether the verdict cannot fail: a definition, arithmetic, or a law that is put in and read out. Such a verdict
        is a check of the program, no evidence for the thesis.
    """

    id: str
    chapter: str
    claim: str
    where: str
    kind: str
    accept: str
    caution: str = ""
    by_construction: bool = False

    @property
    def number(self) -> int:
        """Number of the claim."""
        return int(self.id[1:])


@cache
def checklist() -> dict[str, Claim]:
    """Return all claims by id, in the order of the list."""
    text = (files(__package__) / "checklist.yaml").read_text(encoding="utf-8")
    return {name: Claim(name, **entry) for name, entry in yaml.safe_load(text).items()}


def of_chapters(names: Sequence[str]) -> list[Claim]:
    """Claims of the given chapters (all chapters if none is given), in the order of the list.

    Raises
    ------
    InputError
        If a chapter is unknown.
    """
    for name in names:
        if name not in CHAPTERS:
            raise InputError(f"no such chapter: {name}", remedy=f"use one or more of: {', '.join(CHAPTERS)}")
    return [claim for claim in checklist().values() if not names or claim.chapter in names]


@cache
def explanations() -> dict[str, str]:
    """Id -> Markdown text about a claim that is not met, or that names an error in the thesis."""
    found: dict[str, str] = {}
    for file in sorted((files(__package__) / "explanations").iterdir(), key=lambda f: f.name):
        for part in file.read_text(encoding="utf-8").split("\n### ")[1:]:
            name, _, text = part.partition("\n")
            found[name.strip()] = text.strip()
    return found
