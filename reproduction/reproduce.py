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
from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.verdict import NOT_COMPUTED, NOT_YET, VERDICTS, Verdict
from wroll_fem.errors import ConvergenceError, InputError, WrollError
from wroll_fem.jobs.interrupts import interrupt_arrived
from wroll_fem.progress import Progress, SilentProgress

GROUPS: dict[str, tuple[str, ...]] = {
    "ch2": ("winding", "coiled_stiff", "coil_slip", "design_map"),
    "ch3": ("sweep_rate", "experiments", "shaker_sweeps", "shaker_random", "shaker_shock", "camera_slip"),
    "ch4": ("lab_model", "preload_series", "layers"),
    "ch5": ("two_dof",),
    "ch6": ("realistic_scale", "flight_rolls", "flight_sensitivity"),
    "appendices": (
        "elastic_slip",
        "integrators",
        "regularised_sign",
        "estimators",
        "shear_tests",
        "kapton_friction",
        "friction_rate",
    ),
}
"""Chapter -> modules of this package with the claim groups (`GROUP`)."""

BY_CONSTRUCTION = ", by construction"
"""Ending of the label of a claim whose verdict cannot fail."""


@dataclass(frozen=True)
class Judged:
    """Claim with its verdict and wall time, s; the first claim of a group carries the time of shared runs."""

    claim: Claim
    verdict: Verdict
    seconds: float

    @property
    def label(self) -> str:
        """Verdict; "met, by construction" for a judged claim whose verdict cannot fail."""
        built = self.claim.by_construction and self.verdict.word not in (NOT_YET, NOT_COMPUTED)
        return f"{self.verdict.word}{BY_CONSTRUCTION if built else ''}"

    @property
    def line(self) -> str:
        """Line with id, verdict, statement of the thesis and computed value."""
        return f"{self.claim.id:<5} {self.label:<24} thesis: {self.claim.claim}  here: {self.verdict.value}"


@dataclass(frozen=True)
class Reproduction:
    """Result of `reproduce`.

    Attributes
    ----------
    judged
        Judged claims in the order of the list.
    written
        Files of the table, the page and the figures.
    """

    judged: list[Judged]
    written: list[Path]

    @property
    def count(self) -> str:
        """Number of claims with each verdict, as text."""
        return count(self.judged)

    @property
    def unfinished(self) -> list[str]:
        """Ids of claims whose runs failed."""
        return [one.claim.id for one in self.judged if one.verdict.word == NOT_COMPUTED]


def claim_groups(chapter: str) -> list[ClaimGroup]:
    """Claim groups of a chapter; empty for a chapter that is not reproduced yet."""
    return [import_module(f".{name}", __package__).GROUP for name in GROUPS.get(chapter, ())]


def begin_studies(chapters: Sequence[str], evidence: Evidence) -> None:
    """Start all studies of the given chapters (all chapters if none is given), so that no worker waits for a judge."""
    named = dict.fromkeys(claim.chapter for claim in of_chapters(chapters))
    groups = [group for chapter in named for group in claim_groups(chapter)]
    for group in groups:
        evidence.begin(group.studies)
        evidence.begin(group.partial_studies, partial=True)


def judge(chapters: Sequence[str], evidence: Evidence, progress: Progress) -> list[Judged]:
    """Judge the claims of the given chapters (all chapters if none is given), in the order of the list.

    A claim whose runs fail has the verdict "not computed" and the reason as its value; other claims are not affected.

    Raises
    ------
    InputError
        If a chapter is unknown.
    """
    claims = of_chapters(chapters)
    found: dict[str, Judged] = {}
    for chapter in dict.fromkeys(claim.chapter for claim in claims):
        own = {claim.id: claim for claim in claims if claim.chapter == chapter}
        judges = {name: one for group in claim_groups(chapter) for name, one in group.judges.items()}
        for name, claim in own.items():
            started = time.perf_counter()
            if name not in judges:
                verdict = Verdict(f"{chapter} is not reproduced yet", False, NOT_YET)
            else:
                try:
                    verdict = judges[name](evidence)
                except WrollError as error:
                    if interrupt_arrived():  # for instance tables of a study that could not be written on the way out
                        raise KeyboardInterrupt from error
                    reason = "did not converge: " if isinstance(error, ConvergenceError) else ""
                    verdict = Verdict(f"{reason}{error}".splitlines()[0], False, NOT_COMPUTED)
            found[name] = Judged(claim, verdict, time.perf_counter() - started)
            progress.info(found[name].line)
    return [found[claim.id] for claim in claims]


def count(judged: Sequence[Judged]) -> str:
    """Number of claims with each verdict as text; those that cannot fail are counted apart.

    "12 met, 2 not met; by construction: 4 met, 1 thesis error: explained".
    """
    numbers = Counter(one.label for one in judged)

    def said(ending: str) -> str:
        return ", ".join(f"{numbers[word + ending]} {word}" for word in VERDICTS if numbers[word + ending])

    parts = (said(""), f"by construction: {said(BY_CONSTRUCTION)}" if said(BY_CONSTRUCTION) else "")
    return "; ".join(part for part in parts if part)


def write_table(judged: Sequence[Judged], path: Path) -> None:
    """Write claims.csv: id, chapter, kind, basis of the verdict, claim, our value, verdict, seconds."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(("id", "chapter", "kind", "basis", "claim", "value", "verdict", "seconds"))
        for one in judged:
            basis = "construction" if one.claim.by_construction else "evidence"
            row = (one.claim.id, one.claim.chapter, one.claim.kind, basis, one.claim.claim, one.verdict.value)
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
    """Judge the claims of the given chapters (all chapters if none is given) and write claims.csv and the page.

    Parameters
    ----------
    folder
        Folder of the runs, stored by the hash of their cases. Stored runs are used again, even if the code has changed.
    fast
        Use coarse meshes and fewer values (fast.yaml). The published verdicts are those without this option.
    workers
        Number of processes.
    page
        Markdown file, with its figures in figures/ next to it; `folder`/claims.md by default.
    command
        Command that is named on the page.

    Raises
    ------
    InputError
        If a chapter is unknown, or the folder configs/ of the project is missing.
    """
    from reproduction.page import unexplained, write_page

    progress = progress if progress is not None else SilentProgress()
    of_chapters(chapters)  # before any work
    if workers < 1:
        raise InputError(f"must be at least 1, got {workers}", key="--workers", remedy="use 1 or more")
    folder = Path(folder)
    with Evidence(folder, fast=fast, workers=workers, progress=progress) as evidence:
        begin_studies(chapters, evidence)
        judged = judge(chapters, evidence, progress)
        table = folder / "claims.csv"
        write_table(judged, table)
        if missing := unexplained(judged):
            progress.warning(f"no explanation of {', '.join(missing)}: write one into reproduction/explanations")
        written = write_page(judged, evidence, page if page is not None else folder / "claims.md", command)
    return Reproduction(judged, [table, *written])
