"""`wroll reproduce`: every claim of the thesis, what was computed for it, and the verdict."""

from __future__ import annotations

import csv
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from reproduction.checklist import Claim, of_chapters
from reproduction.evidence import Evidence
from reproduction.family import Family
from reproduction.verdict import NOT_COMPUTED, NOT_YET, VERDICTS, Verdict
from wroll_fem.errors import ConvergenceError, InputError, WrollError
from wroll_fem.progress import Progress, SilentProgress

FAMILIES: dict[str, tuple[str, ...]] = {
    "ch2": ("winding", "coiled_stiff", "coil_slip", "design_map"),
    "ch4": ("lab_model", "preload_series", "layers"),
    "ch5": ("two_dof",),
    "appendices": (
        "elastic_slip",
        "integrators",
        "smoothed_sign",
        "estimators",
        "shear_tests",
        "kapton_friction",
        "friction_rate",
    ),
}
"""Chapter -> modules of this package, each with a `FAMILY`."""


@dataclass(frozen=True)
class Judged:
    """A claim, its verdict, and the wall time of judging it in s (the first of a family pays for its runs)."""

    claim: Claim
    verdict: Verdict
    seconds: float

    @property
    def line(self) -> str:
        """Id, verdict, what the thesis states, what was computed."""
        return f"{self.claim.id:<5} {self.verdict.word:<24} thesis: {self.claim.claim}  here: {self.verdict.value}"


@dataclass(frozen=True)
class Reproduction:
    """What `reproduce` leaves.

    Attributes
    ----------
    judged
        The claims in the order of the list.
    written
        Table, page and figures.
    """

    judged: list[Judged]
    written: list[Path]

    @property
    def count(self) -> str:
        """Number of claims with each verdict, in words."""
        return count(self.judged)

    @property
    def unfinished(self) -> list[str]:
        """Ids of claims whose runs failed."""
        return [one.claim.id for one in self.judged if one.verdict.word == NOT_COMPUTED]


def families(chapter: str) -> list[Family]:
    """Families of a chapter's claims; none for a chapter that is not reproduced yet."""
    return [import_module(f".{name}", __package__).FAMILY for name in FAMILIES.get(chapter, ())]


def judge(chapters: Sequence[str], evidence: Evidence, progress: Progress) -> list[Judged]:
    """Judge the claims of some chapters (all without a name), in the order of the list.

    A claim whose runs fail is "not computed", with the reason as its value; the others are judged all the same.

    Raises
    ------
    InputError
        For a chapter that the checklist does not have.
    """
    claims = of_chapters(chapters)
    found: dict[str, Judged] = {}
    for chapter in dict.fromkeys(claim.chapter for claim in claims):
        own = {claim.id: claim for claim in claims if claim.chapter == chapter}
        judges = {name: one for family in families(chapter) for name, one in family.judges.items()}
        for name, claim in own.items():
            started = time.perf_counter()
            if name not in judges:
                verdict = Verdict(f"{chapter} is not reproduced yet", False, NOT_YET)
            else:
                try:
                    verdict = judges[name](evidence)
                except WrollError as error:
                    reason = "did not converge: " if isinstance(error, ConvergenceError) else ""
                    verdict = Verdict(f"{reason}{error}".splitlines()[0], False, NOT_COMPUTED)
            found[name] = Judged(claim, verdict, time.perf_counter() - started)
            progress.info(found[name].line)
    return [found[claim.id] for claim in claims]


def count(judged: Sequence[Judged]) -> str:
    """Return "12 met, 2 not met, 1 thesis error: explained"."""
    numbers = Counter(one.verdict.word for one in judged)
    return ", ".join(f"{numbers[word]} {word}" for word in VERDICTS if numbers[word])


def write_table(judged: Sequence[Judged], path: Path) -> None:
    """Write claims.csv: id, chapter, kind, claim, our value, verdict, seconds."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(("id", "chapter", "kind", "claim", "value", "verdict", "seconds"))
        for one in judged:
            row = (one.claim.id, one.claim.chapter, one.claim.kind, one.claim.claim, one.verdict.value)
            writer.writerow((*row, one.verdict.word, f"{one.seconds:.1f}"))


def reproduce(
    chapters: Sequence[str],
    folder: str | Path,
    *,
    fast: bool = False,
    workers: int = 2,
    progress: Progress | None = None,
    page: Path | None = None,
    command: str = "wroll reproduce",
) -> Reproduction:
    """Judge the claims of some chapters (all without a name) and write claims.csv and the page about them.

    Parameters
    ----------
    folder
        Keeps every run by the hash of its case; what is there is not computed again, also when the code has changed.
    fast
        Coarse meshes and fewer values (fast.yaml); verdicts on the shipped cases are those without.
    workers
        Processes at a time.
    page
        Markdown file, figures in figures/ beside it; `folder`/claims.md by default.
    command
        What the page names as its maker.

    Raises
    ------
    InputError
        For an unknown chapter, or where the project's configs/ are missing.
    """
    from reproduction.page import unexplained, write_page

    progress = progress if progress is not None else SilentProgress()
    of_chapters(chapters)  # before any work
    if workers < 1:
        raise InputError(f"{workers} workers cannot run anything", key="--workers", remedy="use 1 or more")
    folder = Path(folder)
    with Evidence(folder, fast=fast, workers=workers, progress=progress) as evidence:
        judged = judge(chapters, evidence, progress)
        table = folder / "claims.csv"
        write_table(judged, table)
        if missing := unexplained(judged):
            progress.warning(f"no explanation of {', '.join(missing)}: write one into reproduction/explanations")
        written = write_page(judged, evidence, page if page is not None else folder / "claims.md", command)
    return Reproduction(judged, [table, *written])
