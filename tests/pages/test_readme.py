"""What README and docs show is what the program does."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from support.paths import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_ten_lines_of_the_readme_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (block,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert len(block.strip().splitlines()) <= 10
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(compile(block, "README.md", "exec"), names)
    assert (tmp_path / "slip_map.png").stat().st_size > 10_000
    assert float(names["result"]["friction_energy"][-1]) > 0  # type: ignore[index]


def test_every_picture_and_page_that_is_linked_exists() -> None:
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_the_readmes_commands_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for command in set(re.findall(r"^make ([a-z-]+)", README, flags=re.MULTILINE)):
        assert re.search(rf"^{command}:", makefile, flags=re.MULTILINE), command


def test_the_counts_of_the_claims_are_those_of_their_page() -> None:
    """Evidence and construction apart, and all 126 claims in the sum."""
    page = (ROOT / "docs" / "claims.md").read_text(encoding="utf-8")
    head = re.search(r"^Written by `wroll reproduce`: (.+)\.$", page, flags=re.MULTILINE)
    assert head is not None
    counts = dict.fromkeys(("met", "not met", "thesis error: explained", "out of scope: experiment", "not yet"), 0)
    evidence, construction = (
        counts | {words: int(number) for number, words in re.findall(r"(\d+) ([^,]+)", part)}
        for part in head[1].split("; by construction: ")
    )
    shown = re.search(
        r"(\d+) of its claims .*?(\d+) are met, (\d+) not met, (\d+) errors in the thesis, "
        r"(\d+) only an experiment can settle, (\d+) not computed yet.*?by construction .*?(\d+) are met, "
        r"(\d+) errors in the thesis, (\d+) only an experiment",
        README,
    )
    assert shown is not None
    total, *numbers = map(int, shown.groups())
    assert numbers[:5] == [
        evidence[w] for w in ("met", "not met", "thesis error: explained", "out of scope: experiment", "not yet")
    ]
    assert numbers[5:] == [construction[w] for w in ("met", "thesis error: explained", "out of scope: experiment")]
    assert total == sum(numbers) == sum(evidence.values()) + sum(construction.values())


def test_the_thesis_is_cited_in_full() -> None:
    title = "Vibration Damping of Coiled Structures Through Frictional Slip"
    for name in ("README.md", "CITATION.cff", "docs/theory.md", "docs/index.md"):
        text = (ROOT / name).read_text(encoding="utf-8")
        for part in (title, "Wen", "California Institute of Technology", "2024", "https://thesis.library.caltech.edu"):
            assert part in text, f"{name}: {part}"


def test_no_page_calls_the_thesis_the_source() -> None:
    """Lists that are made from docstrings follow the code, not this page."""
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    pages += sorted((ROOT / "reproduction" / "explanations").glob("*.md"))
    found = [
        f"{page.name}: {line}"
        for page in pages
        for line in page.read_text(encoding="utf-8").splitlines()
        if re.search(r"\bthe source\b(?!s| of| file)", line, flags=re.IGNORECASE)
        and not line.startswith("- `wroll_fem/")
    ]
    assert found == []
